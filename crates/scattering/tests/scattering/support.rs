//! Random numbers, materials and the chi-square test shared by the tests.

use std::f64::consts::{PI, TAU};

use ergodic_geometry::{Frame, Surface};
use ergodic_scattering::{
    Interaction, Interpolation, Material, MaterialLayers, Rgb, Texels, Texture, TextureUse, Wrap,
};
use glam::{DAffine2, DVec2, DVec3, DVec4};
use rand_core::{Rng, SeedableRng};
use statrs::function::gamma::gamma_ur;

/// Numbers uniform on [0, 1).
pub struct Random(rand_pcg::Pcg64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(rand_pcg::Pcg64::seed_from_u64(seed))
    }

    pub fn next(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn two(&mut self) -> [f64; 2] {
        [self.next(), self.next()]
    }

    pub fn three(&mut self) -> [f64; 3] {
        [self.next(), self.next(), self.next()]
    }

    /// A direction uniform over the sphere.
    pub fn direction(&mut self) -> DVec3 {
        let z = 1.0 - 2.0 * self.next();
        let (sin, cos) = (TAU * self.next()).sin_cos();
        let radius = (1.0 - z * z).sqrt();
        DVec3::new(radius * cos, radius * sin, z)
    }
}

/// A point with geometric normal +z and the given shading normal.
pub fn surface(ns: DVec3) -> Surface {
    Surface {
        position: DVec3::ZERO,
        ng: DVec3::Z,
        ns,
        tangent: DVec3::X,
        bitangent_sign: 1.0,
        texcoords: [DVec2::ZERO; 2],
        color: DVec4::ONE,
        instance: 0,
        triangle: 0,
    }
}

pub const BASE: Rgb = Rgb::new(0.8, 0.5, 0.3);

/// The kinds of material that the tests go through, with alpha still open.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Lambert,
    Metal,
    Coated,
    HalfMetal,
    Glass,
    /// A solid with a diffuse part, a tinted specular layer and some metal.
    MixedSolid,
    Thin,
    MixedThin,
    /// A solid of lower index than its outside.
    Bubble,
    /// A solid of the same index as its outside.
    Invisible,
    /// A coat over rough metal; alpha is the coat's.
    Varnished,
    /// Metal under a smooth coat that does not follow the metal's normal map.
    Peeled,
    /// A sheen over a diffuse surface; alpha is the sheen's.
    Velvet,
    /// Anisotropic metal.
    Brushed,
    /// An anisotropic solid.
    BrushedGlass,
    /// A thin film on metal.
    Oiled,
    /// A thin film on a diffuse surface.
    Pearl,
    /// A thin film alone.
    SoapFilm,
    /// A solid with a thin film.
    Opal,
    /// A thin surface that transmits diffusely.
    Leaf,
    /// A solid that light enters diffusely.
    Wax,
    /// A solid that light enters both ways.
    Murky,
    /// A solid of lower index that light enters both ways.
    MurkyBubble,
    /// A thin surface with everything.
    Everything,
    /// A solid with everything.
    EverythingSolid,
}

/// All kinds with effects beyond the core's.
pub const EXTENDED: [Kind; 15] = [
    Kind::Varnished,
    Kind::Peeled,
    Kind::Velvet,
    Kind::Brushed,
    Kind::BrushedGlass,
    Kind::Oiled,
    Kind::Pearl,
    Kind::SoapFilm,
    Kind::Opal,
    Kind::Leaf,
    Kind::Wax,
    Kind::Murky,
    Kind::MurkyBubble,
    Kind::Everything,
    Kind::EverythingSolid,
];

pub const ALL: [Kind; 25] = [
    Kind::Lambert,
    Kind::Metal,
    Kind::Coated,
    Kind::HalfMetal,
    Kind::Glass,
    Kind::MixedSolid,
    Kind::Thin,
    Kind::MixedThin,
    Kind::Bubble,
    Kind::Invisible,
    Kind::Varnished,
    Kind::Peeled,
    Kind::Velvet,
    Kind::Brushed,
    Kind::BrushedGlass,
    Kind::Oiled,
    Kind::Pearl,
    Kind::SoapFilm,
    Kind::Opal,
    Kind::Leaf,
    Kind::Wax,
    Kind::Murky,
    Kind::MurkyBubble,
    Kind::Everything,
    Kind::EverythingSolid,
];

/// A tangent-space normal that leans, as the one texture of the tests.
pub fn textures() -> [Texture; 1] {
    let texels = Texels::Float([[0.7, 0.4, 0.9, 1.0]].into());
    let (wrap, interpolation) = (Wrap::Repeat, Interpolation::Nearest);
    [Texture { width: 1, height: 1, texels, wrap_u: wrap, wrap_v: wrap, interpolation }]
}

/// The layers of the kinds that have everything.
fn everything() -> MaterialLayers {
    MaterialLayers {
        clearcoat: 0.6,
        clearcoat_roughness: 0.3,
        sheen_color: Rgb::new(0.5, 0.3, 0.6),
        sheen_roughness: 0.4,
        anisotropy: 0.5,
        iridescence: 0.7,
        iridescence_thickness_maximum: 450.0,
        diffuse_transmission: 0.4,
        diffuse_transmission_color: Rgb::new(0.9, 0.4, 0.2),
        ..MaterialLayers::default()
    }
}

impl Kind {
    pub fn material(self, alpha: f64) -> Material {
        let dielectric = Material { base_color: BASE, metallic: 0.0, roughness: alpha.sqrt(), ..Material::default() };
        match self {
            Self::Lambert => Material { specular: 0.0, ..dielectric },
            Self::Metal => Material { metallic: 1.0, ..dielectric },
            Self::Coated => dielectric,
            Self::HalfMetal => Material { metallic: 0.4, ..dielectric },
            Self::Glass => Material { transmission: 1.0, solid: true, ..dielectric },
            Self::MixedSolid => Material {
                transmission: 0.7,
                solid: true,
                metallic: 0.2,
                specular: 0.8,
                specular_color: Rgb::new(1.0, 0.6, 0.4),
                ior: 1.8,
                ..dielectric
            },
            Self::Thin => Material { transmission: 1.0, ..dielectric },
            Self::MixedThin => Material { transmission: 0.6, metallic: 0.3, ..dielectric },
            Self::Bubble => Material { transmission: 1.0, solid: true, ior: 0.75, ..dielectric },
            Self::Invisible => Material { transmission: 1.0, solid: true, ior: 1.0, ..dielectric },
            _ => self.extended(dielectric),
        }
    }

    /// The kinds with layers, made of a dielectric that has the wanted alpha.
    fn extended(self, dielectric: Material) -> Material {
        let layers = MaterialLayers::default();
        let roughness = dielectric.roughness;
        let with = |material: Material, layers| Material { layers: Some(Box::new(layers)), ..material };
        let metal = Material { metallic: 1.0, ..dielectric.clone() };
        let glass = Material { transmission: 1.0, solid: true, ..dielectric.clone() };
        let film = MaterialLayers { iridescence: 1.0, iridescence_thickness_maximum: 550.0, ..layers.clone() };
        let translucent = MaterialLayers {
            diffuse_transmission: 0.6,
            diffuse_transmission_color: Rgb::new(0.9, 0.7, 0.2),
            ..layers.clone()
        };
        match self {
            Self::Varnished => with(
                Material { roughness: 0.6, ..metal },
                MaterialLayers { clearcoat: 0.8, clearcoat_roughness: roughness, ..layers },
            ),
            Self::Peeled => {
                let normal_texture = Some(TextureUse { texture: 0, texcoord: 0, transform: DAffine2::IDENTITY });
                with(Material { normal_texture, ..metal }, MaterialLayers { clearcoat: 1.0, ..layers })
            }
            Self::Velvet => with(
                Material { specular: 0.0, ..dielectric },
                MaterialLayers { sheen_color: Rgb::new(0.9, 0.6, 0.3), sheen_roughness: roughness, ..layers },
            ),
            Self::Brushed => with(metal, MaterialLayers { anisotropy: 0.7, anisotropy_rotation: 0.5, ..layers }),
            Self::BrushedGlass => with(glass, MaterialLayers { anisotropy: 0.5, anisotropy_rotation: -1.0, ..layers }),
            Self::Oiled => with(metal, film),
            Self::Pearl => with(dielectric, film),
            Self::SoapFilm => with(Material { solid: false, ior: 1.0, ..glass }, film),
            Self::Opal => with(glass, MaterialLayers { iridescence: 0.9, ..film }),
            Self::Leaf => with(dielectric, translucent),
            Self::Wax => with(Material { solid: true, ..dielectric }, translucent),
            Self::Murky => with(Material { transmission: 0.5, ..glass }, translucent),
            Self::MurkyBubble => with(Material { transmission: 0.5, ior: 0.75, ..glass }, translucent),
            Self::Everything => {
                with(Material { metallic: 0.3, transmission: 0.4, solid: false, ..glass }, everything())
            }
            _ => with(Material { metallic: 0.2, transmission: 0.6, ior: 1.7, ..glass }, everything()),
        }
    }

    /// Whether it is rougher along one direction.
    pub fn is_anisotropic(self) -> bool {
        self.material(1.0).layers.is_some_and(|layers| layers.anisotropy > 0.0)
    }

    /// Whether nothing gets through.
    pub fn is_opaque(self) -> bool {
        matches!(
            self,
            Self::Lambert
                | Self::Metal
                | Self::Coated
                | Self::HalfMetal
                | Self::Varnished
                | Self::Peeled
                | Self::Velvet
                | Self::Brushed
                | Self::Oiled
                | Self::Pearl
        )
    }

    pub fn at(self, alpha: f64, ns: DVec3) -> Interaction {
        self.material(alpha).interaction(&textures(), &surface(ns))
    }
}

/// The direction with a cosine of `cos` to +z.
pub fn inclined(cos: f64, phi: f64) -> DVec3 {
    let sin = ((1.0 - cos) * (1.0 + cos)).sqrt();
    DVec3::new(sin * phi.cos(), sin * phi.sin(), cos)
}

const GAUSS_NODES: [f64; 4] =
    [0.069_431_844_202_973_71, 0.330_009_478_207_571_87, 0.669_990_521_792_428_1, 0.930_568_155_797_026_2];
const GAUSS_WEIGHTS: [f64; 4] =
    [0.173_927_422_568_726_93, 0.326_072_577_431_273_07, 0.326_072_577_431_273_07, 0.173_927_422_568_726_93];

/// The most halvings of a cell.
const DEPTH: u32 = 10;

/// The integral of `f` over a rectangle, halving it until two orders agree to `tolerance`.
pub fn integrate(f: &dyn Fn(f64, f64) -> f64, low: DVec2, high: DVec2, tolerance: f64) -> f64 {
    let whole = gauss(f, low, high);
    refine(f, low, high, whole, tolerance, DEPTH)
}

fn gauss(f: &dyn Fn(f64, f64) -> f64, low: DVec2, high: DVec2) -> f64 {
    let size = high - low;
    let mut sum = 0.0;
    for (x, wx) in GAUSS_NODES.iter().zip(GAUSS_WEIGHTS) {
        for (y, wy) in GAUSS_NODES.iter().zip(GAUSS_WEIGHTS) {
            sum += wx * wy * f(low.x + size.x * x, low.y + size.y * y);
        }
    }
    sum * size.x * size.y
}

fn refine(f: &dyn Fn(f64, f64) -> f64, low: DVec2, high: DVec2, whole: f64, tolerance: f64, depth: u32) -> f64 {
    let middle = (low + high) * 0.5;
    let parts = [
        (low, middle),
        (DVec2::new(middle.x, low.y), DVec2::new(high.x, middle.y)),
        (DVec2::new(low.x, middle.y), DVec2::new(middle.x, high.y)),
        (middle, high),
    ];
    let values = parts.map(|(low, high)| gauss(f, low, high));
    let sum: f64 = values.iter().sum();
    // The first halving is never the last: a ridge can slip through sixteen points.
    if depth == 0 || (depth < DEPTH && (sum - whole).abs() <= tolerance) {
        return sum;
    }
    parts.iter().zip(values).map(|((low, high), value)| refine(f, *low, *high, value, tolerance * 0.5, depth - 1)).sum()
}

/// A histogram over directions: rings about an axis, narrow near it, cut into sectors.
pub struct Rings {
    frame: Frame,
    edges: Vec<f64>,
    sectors: usize,
    /// Normals of the half spaces, each with the axis inside, beyond which the density is 0.
    horizons: Vec<DVec3>,
}

impl Rings {
    /// Rings about `axis` whose innermost are a fraction of `width` (radians) wide.
    pub fn new(axis: DVec3, width: f64, rings: usize, sectors: usize) -> Self {
        let reach = (PI / width).asinh();
        let mut edges: Vec<f64> = (0..=rings).map(|i| width * (reach * i as f64 / rings as f64).sinh()).collect();
        edges[rings] = PI;
        // Narrow rings where a surface's horizon is, if the axis is its normal.
        edges.extend([-0.03, -3e-3, 0.0, 3e-3, 0.03].map(|offset| 0.5 * PI + offset));
        edges.sort_by(f64::total_cmp);
        Self { frame: Frame::from_normal(axis), edges, sectors, horizons: Vec::new() }
    }

    /// Integrates only over the half spaces about these normals, so that no cell has a step in it.
    pub fn within(self, normals: &[DVec3]) -> Self {
        let horizons = normals.iter().map(|n| n * n.dot(self.frame.n).signum()).collect();
        Self { horizons, ..self }
    }

    /// The angle from the axis at which the directions at `phi` cross the first horizon.
    fn horizon(&self, phi: f64) -> f64 {
        let outwards = self.direction(0.5 * PI, phi);
        // n·w = cos theta n·axis + sin theta n·outwards has one zero in (0, pi).
        let crossing = |n: &DVec3| n.dot(self.frame.n).atan2(-n.dot(outwards));
        self.horizons.iter().map(crossing).fold(PI, f64::min)
    }

    pub fn cells(&self) -> usize {
        (self.edges.len() - 1) * self.sectors
    }

    fn direction(&self, theta: f64, phi: f64) -> DVec3 {
        let (sin, cos) = theta.sin_cos();
        self.frame.to_world(DVec3::new(sin * phi.cos(), sin * phi.sin(), cos))
    }

    pub fn cell(&self, w: DVec3) -> usize {
        let local = self.frame.to_local(w);
        let theta = local.truncate().length().atan2(local.z);
        let phi = local.y.atan2(local.x).rem_euclid(TAU);
        let ring = self.edges.partition_point(|&edge| edge <= theta).clamp(1, self.edges.len() - 1) - 1;
        let sector = ((phi / TAU * self.sectors as f64) as usize).min(self.sectors - 1);
        ring * self.sectors + sector
    }

    /// The integral of `f` over every cell.
    pub fn integrals(&self, f: &dyn Fn(DVec3) -> f64, tolerance: f64) -> Vec<f64> {
        let sector = TAU / self.sectors as f64;
        let cell = |ring: &[f64], i: usize| {
            let over = |x: f64, phi: f64| {
                let size = self.horizon(phi).min(ring[1]) - ring[0];
                let theta = ring[0] + size * x;
                if size <= 0.0 { 0.0 } else { f(self.direction(theta, phi)) * theta.sin() * size }
            };
            let (low, high) = (DVec2::new(0.0, sector * i as f64), DVec2::new(1.0, sector * (i + 1) as f64));
            integrate(&over, low, high, tolerance)
        };
        self.edges.windows(2).flat_map(|ring| (0..self.sectors).map(|i| cell(ring, i)).collect::<Vec<_>>()).collect()
    }
}

/// Upper bound on the number of chi-square tests in this crate, which share one significance level.
const FAMILY: i32 = 3000;
/// The probability that any of them fails with everything right.
const SIGNIFICANCE: f64 = 0.01;

/// Pearson's test of `counts` against `expected` probabilities; cells that expect fewer than 5 are pooled. The error
/// says what is wrong.
pub fn chi_square(counts: &[u64], expected: &[f64]) -> Result<(), String> {
    let samples: u64 = counts.iter().sum();
    let mut statistic = 0.0;
    let mut cells = 0;
    let mut pool = (0.0, 0.0);
    let mut add = |count: f64, expected: f64| {
        statistic += (count - expected).powi(2) / expected;
        cells += 1;
    };
    for (&count, &probability) in counts.iter().zip(expected) {
        let expected = probability * samples as f64;
        if expected < 5.0 {
            pool = (pool.0 + count as f64, pool.1 + expected);
        } else {
            add(count as f64, expected);
        }
    }
    if pool.1 >= 1.0 {
        add(pool.0, pool.1);
    } else if pool.0 > 20.0 {
        return Err(format!("{} samples where {} are expected", pool.0, pool.1));
    }
    if cells < 2 {
        return Ok(());
    }
    let p = gamma_ur(0.5 * f64::from(cells - 1), 0.5 * statistic);
    let least = 1.0 - (1.0 - SIGNIFICANCE).powf(1.0 / f64::from(FAMILY));
    if p >= least { Ok(()) } else { Err(format!("chi-square {statistic:.1} over {cells} cells, p = {p:.2e}")) }
}

/// Tests a sampler of directions against its density. `others` are the probabilities of outcomes that `sample` reports by
/// their index instead of a direction; what is left of 1 is the probability of no outcome. Returns the mass left over.
pub fn chi_square_directions(
    rings: &Rings,
    samples: u64,
    pdf: &dyn Fn(DVec3) -> f64,
    others: &[f64],
    sample: &mut dyn FnMut() -> Outcome,
) -> Result<f64, String> {
    let mut expected = rings.integrals(pdf, 2e-7);
    expected.extend_from_slice(others);
    let mass: f64 = expected.iter().sum();
    if mass > 1.0 + 1e-3 {
        return Err(format!("the density integrates to {mass}"));
    }
    expected.push((1.0 - mass).max(0.0));
    let mut counts = vec![0; expected.len()];
    for _ in 0..samples {
        let cell = match sample() {
            Outcome::Direction(w) => rings.cell(w),
            Outcome::Other(i) => rings.cells() + i,
            Outcome::Nothing => expected.len() - 1,
        };
        counts[cell] += 1;
    }
    chi_square(&counts, &expected).map(|()| 1.0 - mass)
}

/// What one draw of a sampler came to.
pub enum Outcome {
    Direction(DVec3),
    Other(usize),
    Nothing,
}

/// Whether tests are to have their nightly sizes.
pub fn is_nightly() -> bool {
    std::env::var("ERGODIC_TESTS").is_ok_and(|value| value == "nightly")
}
