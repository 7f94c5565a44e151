//! What a render is asked to do. Everything here is read from RON.

use ergodic_mutations::AnyMutation;
use ergodic_pathspace::{CameraDescription, Effects, Forced, Lengths, Projection, Roulette, View};
use ergodic_scattering::{Lens, Medium, Rgb};
use serde::{Deserialize, Serialize};

use crate::chains::GREATEST_SHARE;
use crate::primary::PrimaryMutation;

/// Settings of one render.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// The scene's file; empty if whoever renders chooses it. Rendering itself does not read it.
    pub scene: String,
    /// Light from infinitely far away, beside the scene's own; `None` for none. Rendering itself does not read it.
    pub environment: Option<EnvironmentSettings>,
    /// What fills the space outside all solids; `None` for nothing. Rendering itself does not read it.
    pub medium: Option<MediumSettings>,
    /// Which estimator.
    pub method: Method,
    /// Which camera: a name or an index; empty for the scene's first.
    pub camera: String,
    /// What the numbers of point, spot and directional lights in the scene's file mean. Rendering itself does not read it.
    pub light_units: LightUnits,
    /// Which variant of the materials (KHR_materials_variants), by name; empty for the scene's default.
    pub variant: String,
    /// The camera's lens; `None` for what the scene's file says, which is a pinhole if it says nothing.
    pub lens: Option<LensSettings>,
    /// Width and height of the picture in pixels, before it is cropped.
    pub size: (u32, u32),
    /// Effects that are forced on or off, whatever the scene has. Rendering itself does not read it.
    pub effects: Forced,
    /// The window of the picture that is rendered: `(left, top, right, bottom)` in pixels from its upper left corner, the last two
    /// not included. `None` for all of it.
    pub crop: Option<(u32, u32, u32, u32)>,
    /// Reconstruction filter.
    pub filter: FilterSettings,
    /// Key of all random streams.
    pub seed: u64,
    /// Worker threads; 0 for one a core. The picture does not depend on it.
    pub threads: usize,
    /// Least number of edges of a path; 1 for the whole picture.
    pub min_edges: usize,
    /// Greatest number of edges of a path: 1 sees lights only, 2 adds direct light, and so on.
    pub max_edges: usize,
    /// When to stop.
    pub budget: Budget,
    /// Where random walks of the path tracer and of bidirectional sampling may end early.
    pub roulette: RouletteSettings,
    /// Settings of Metropolis light transport. All but the mixture hold for pssmlt and mmlt too.
    pub mlt: MltSettings,
    /// What pssmlt and mmlt have for a mixture.
    pub primary: PrimarySettings,
}

/// Light from infinitely far away.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub enum EnvironmentSettings {
    /// The same radiance from every direction: red, green and blue.
    Constant(f64, f64, f64),
    /// A latitude-longitude map.
    Map(EnvironmentMap),
}

/// A latitude-longitude map in a file.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct EnvironmentMap {
    /// A .hdr or .exr file.
    pub file: String,
    /// Degrees by which the map is turned about +y, counter-clockwise as seen from above. Without rotation its middle column shows +x.
    pub rotation: f64,
    /// Factor of its radiance.
    pub strength: f64,
}

impl Default for EnvironmentMap {
    fn default() -> Self {
        Self { file: String::new(), rotation: 0.0, strength: 1.0 }
    }
}

impl EnvironmentSettings {
    fn validate(&self) -> Result<(), String> {
        match self {
            Self::Constant(r, g, b) if [r, g, b].iter().any(|c| !(0.0..f64::from(f32::MAX)).contains(*c)) => {
                Err(format!("environment: Constant is ({r}, {g}, {b}); radiance is finite and not negative"))
            }
            Self::Map(map) if map.file.is_empty() => {
                Err("environment: Map has no file; give a .hdr or .exr file".into())
            }
            Self::Map(map) if !(map.strength > 0.0 && map.strength.is_finite()) => {
                Err(format!("environment.strength is {}; it must be a finite number greater than 0", map.strength))
            }
            Self::Map(map) if !map.rotation.is_finite() => {
                Err(format!("environment.rotation is {}; it must be a finite number of degrees", map.rotation))
            }
            _ => Ok(()),
        }
    }
}

/// A homogeneous medium. Coefficients are per unit of length of the file, which in glTF is the metre.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct MediumSettings {
    /// Scattering coefficient: red, green and blue.
    pub scattering: (f64, f64, f64),
    /// Absorption coefficient.
    pub absorption: (f64, f64, f64),
    /// Mean cosine of the turn of scattered light, in (-1, 1): 0 to all sides alike, near 1 forward.
    pub anisotropy: f64,
}

impl Default for MediumSettings {
    fn default() -> Self {
        Self { scattering: (0.0, 0.0, 0.0), absorption: (0.0, 0.0, 0.0), anisotropy: 0.0 }
    }
}

impl MediumSettings {
    /// The medium itself.
    pub fn medium(&self) -> Medium {
        let rgb = |(r, g, b): (f64, f64, f64)| Rgb::new(r, g, b);
        let (scattering, absorption) = (rgb(self.scattering), rgb(self.absorption));
        Medium { scattering, absorption, anisotropy: self.anisotropy }
    }

    fn validate(&self) -> Result<(), String> {
        for (name, (r, g, b)) in [("scattering", self.scattering), ("absorption", self.absorption)] {
            if [r, g, b].iter().any(|c| !(0.0..f64::from(f32::MAX)).contains(c)) {
                return Err(format!("medium.{name} is ({r}, {g}, {b}); coefficients are finite and not negative"));
            }
        }
        // Nearer to 1 the phase function is a needle that no sampler of lights ever meets.
        if !(-0.999..=0.999).contains(&self.anisotropy) {
            return Err(format!("medium.anisotropy is {}; it must be from -0.999 to 0.999", self.anisotropy));
        }
        Ok(())
    }
}

/// An estimator of the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// Path tracing with next-event estimation.
    Path,
    /// Bidirectional path tracing.
    Bidirectional,
    /// Metropolis light transport in path space.
    Mlt,
    /// Metropolis light transport in primary sample space (Kelemen et al. 2002).
    Pssmlt,
    /// Multiplexed Metropolis light transport (Hachisuka et al. 2014).
    Mmlt,
}

impl Method {
    /// All methods with their names.
    pub const ALL: [(Self, &'static str); 5] = [
        (Self::Path, "path"),
        (Self::Bidirectional, "bidirectional"),
        (Self::Mlt, "mlt"),
        (Self::Pssmlt, "pssmlt"),
        (Self::Mmlt, "mmlt"),
    ];

    /// Whether it samples by Markov chains.
    pub fn has_chains(self) -> bool {
        match self {
            Self::Path | Self::Bidirectional => false,
            Self::Mlt | Self::Pssmlt | Self::Mmlt => true,
        }
    }

    /// The name used in configs and on the command line.
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(method, _)| *method == self).map_or("", |(_, name)| name)
    }
}

/// Units of the lights of KHR_lights_punctual. The specification asks for photometric ones, and leaves open how they go with
/// emitting surfaces; most programs that render take the numbers for radiometric ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LightUnits {
    /// Radiant intensity in W/sr and irradiance in W/m²: the units of everything else here.
    Radiometric,
    /// Candela and lux, at 683 lm/W: what Blender's exporter writes in its standard mode.
    Photometric,
    /// The power of point and spot lights in watts, over the whole sphere for spot lights too, and irradiance in W/m²: what
    /// Blender's exporter writes in its raw mode.
    Watts,
}

/// Luminous efficacy of light at 555 nm, in lm/W, which programs use for light of any colour.
const LUMENS_PER_WATT: f64 = 683.0;

impl LightUnits {
    /// What to multiply the intensity of point and spot lights with to get W/sr, and the irradiance of directional lights to
    /// get W/m².
    pub fn to_radiometric(self) -> (f64, f64) {
        match self {
            Self::Radiometric => (1.0, 1.0),
            Self::Photometric => (1.0 / LUMENS_PER_WATT, 1.0 / LUMENS_PER_WATT),
            Self::Watts => (1.0 / (4.0 * std::f64::consts::PI), 1.0),
        }
    }
}

/// A thin lens before the scene's camera. Lengths are in units of the scene's file, which are metres.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct LensSettings {
    /// Radius of the aperture; of a polygon, that of the circle through its corners. 0 for a pinhole.
    pub radius: f64,
    /// Distance along the camera's axis of the plane that is seen sharp.
    pub focus_distance: f64,
    /// Number of blades, which are the sides of the aperture; 0 for a disk.
    #[serde(default)]
    pub blades: u32,
    /// Angle of the polygon's first corner in radians, from right towards up as the camera sees it.
    #[serde(default)]
    pub rotation: f64,
}

/// A reconstruction filter.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub enum FilterSettings {
    /// One pixel, constant.
    Box,
    /// A Gaussian cut off at `radius` pixels.
    Gaussian {
        /// Cut-off in pixels.
        radius: f64,
        /// Standard deviation in pixels.
        sigma: f64,
    },
}

/// When a render stops.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub enum Budget {
    /// After this many samples a pixel; for mlt, mutations a pixel. The same seed then gives the same bytes.
    SamplesPerPixel(f64),
    /// After this many seconds of wall time, seeding included.
    Seconds(f64),
}

/// Russian roulette by depth.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct RouletteSettings {
    /// Vertices of a walk that are always sampled.
    pub start: usize,
    /// Probability of each further one.
    pub survival: f64,
}

/// Settings of Metropolis light transport.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct MltSettings {
    /// The mixture: weights and mutations.
    pub mutations: Vec<(f64, AnyMutation)>,
    /// Number of independent chains.
    pub chains: usize,
    /// Mutations after which a chain begins anew from another start; 0 for never.
    pub mutations_per_start: u64,
    /// Whether the chains' target is luminance over the brightness of the image, as a first stage of few samples saw it, and not luminance
    /// itself, so that dark parts get as good as bright ones.
    pub two_stage: bool,
    /// Light that arrives by at most one bounce.
    pub direct: Direct,
    /// The independent samples that estimate b and start the chains.
    pub seeding: Seeding,
    /// Share of the work that seeding has, and that direct light has, at most a quarter. Of a budget of time it is what they get, or
    /// with 0 what they need and at most a quarter; where the budget is in mutations, it is the least share of the time that these are
    /// expected to take.
    pub share: f64,
    /// Whether to keep numbers for each pixel: acceptance, standard error, longest stay.
    pub layers: bool,
}

/// Steps through primary sample space.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct PrimarySettings {
    /// What pssmlt makes of a point.
    pub sampler: PrimarySampler,
    /// Probability of a large step, in (0, 1].
    pub large_step: f64,
    /// Smallest move of a coordinate by a small step.
    pub min_step: f64,
    /// Largest move, less than 1/2.
    pub max_step: f64,
}

/// What makes a sample of a point of primary sample space.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum PrimarySampler {
    /// Path tracing with next-event estimation.
    Path,
    /// Bidirectional path tracing.
    Bidirectional,
}

/// Who renders paths of one and two edges.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub enum Direct {
    /// The chains, like all others.
    InChain,
    /// Bidirectional sampling of its own, with this many samples a pixel.
    Separate {
        /// Samples a pixel.
        samples_per_pixel: u32,
    },
}

/// How b is estimated.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Seeding {
    /// Relative standard error of b at which seeding ends.
    pub relative_error: f64,
    /// Seeding also ends after this many samples; the error reached is reported.
    pub max_samples: u64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            scene: String::new(),
            environment: None,
            medium: None,
            method: Method::Mlt,
            camera: String::new(),
            light_units: LightUnits::Radiometric,
            variant: String::new(),
            lens: None,
            size: (384, 256),
            effects: Forced::default(),
            crop: None,
            filter: FilterSettings::Box,
            seed: 0,
            threads: 0,
            min_edges: 1,
            max_edges: 16,
            budget: Budget::SamplesPerPixel(256.0),
            roulette: RouletteSettings::default(),
            mlt: MltSettings::default(),
            primary: PrimarySettings::default(),
        }
    }
}

impl Default for PrimarySettings {
    /// The sizes are those of Kelemen et al. (2002).
    fn default() -> Self {
        Self { sampler: PrimarySampler::Bidirectional, large_step: 0.3, min_step: 1.0 / 1024.0, max_step: 1.0 / 64.0 }
    }
}

impl Default for RouletteSettings {
    fn default() -> Self {
        Self { start: 5, survival: 0.8 }
    }
}

impl Default for MltSettings {
    fn default() -> Self {
        Self {
            mutations: AnyMutation::default_mixture(),
            chains: 512,
            mutations_per_start: 4096,
            two_stage: true,
            direct: Direct::Separate { samples_per_pixel: 32 },
            seeding: Seeding::default(),
            share: 0.1,
            layers: false,
        }
    }
}

impl Default for Seeding {
    fn default() -> Self {
        Self { relative_error: 0.005, max_samples: 4_000_000 }
    }
}

impl FilterSettings {
    /// The filter itself.
    pub fn filter(self) -> ergodic_scattering::Filter {
        match self {
            Self::Box => ergodic_scattering::Filter::Box,
            Self::Gaussian { radius, sigma } => ergodic_scattering::Filter::Gaussian { radius, sigma },
        }
    }
}

impl LensSettings {
    /// The lens itself.
    pub fn lens(self) -> Lens {
        let Self { radius, focus_distance, blades, rotation } = self;
        Lens { radius, focus_distance, blades, rotation }
    }
}

impl RouletteSettings {
    pub(crate) fn roulette(self) -> Roulette {
        Roulette { start: self.start, survival: self.survival }
    }
}

/// The largest picture, in pixels on a side.
const MAX_SIDE: u32 = 65_536;
/// The greatest number of samples of a seeding, so that 32 bits count them.
pub(crate) const MOST_SEEDS: u64 = 1 << 31;
/// The greatest number of pixels.
const MAX_PIXELS: u64 = 1 << 28;

impl Settings {
    /// Lengths of the paths that the whole picture is made of.
    pub fn lengths(&self) -> Lengths {
        Lengths { min_edges: self.min_edges, max_edges: self.max_edges }
    }

    /// The view of a scene that these settings ask for. An orthographic camera has no lens, whatever they say.
    pub fn view(&self, mut camera: CameraDescription) -> View {
        if let (Some(settings), Projection::Perspective { lens, .. }) = (self.lens, &mut camera.projection) {
            *lens = (settings.radius > 0.0).then(|| settings.lens());
        }
        let margin = (self.filter.filter().radius() - 0.5).max(0.0);
        View { camera, width: self.size.0, height: self.size.1, margin, crop: self.crop }
    }

    /// Number of worker threads, one a core if the setting is 0.
    pub fn worker_threads(&self) -> usize {
        match self.threads {
            0 => std::thread::available_parallelism().map_or(1, std::num::NonZero::get),
            threads => threads,
        }
    }

    /// Width and height in pixels of the picture that is rendered: of the window, if there is one.
    pub fn film_size(&self) -> (u32, u32) {
        self.crop
            .map_or(self.size, |(left, top, right, bottom)| (right.saturating_sub(left), bottom.saturating_sub(top)))
    }

    /// Checks all values.
    ///
    /// # Errors
    ///
    /// A sentence that names the setting, what is wrong with it and what is allowed.
    pub fn validate(&self) -> Result<(), String> {
        let positive = |name: &str, value: f64| {
            if value.is_finite() && value > 0.0 {
                Ok(())
            } else {
                Err(format!("{name} is {value}; it must be a finite number greater than 0"))
            }
        };
        let (width, height) = self.size;
        if width == 0 || height == 0 || width > MAX_SIDE || height > MAX_SIDE {
            return Err(format!("size is {width}x{height}; width and height must be from 1 to {MAX_SIDE}"));
        }
        if u64::from(width) * u64::from(height) > MAX_PIXELS {
            return Err(format!("size is {width}x{height}; a picture may have at most {MAX_PIXELS} pixels"));
        }
        if let Some((left, top, right, bottom)) = self.crop
            && !(left < right && right <= width && top < bottom && bottom <= height)
        {
            return Err(format!(
                "crop is ({left}, {top}, {right}, {bottom}); 0 <= left < right <= {width} and 0 <= top < bottom <= {height} must \
                 hold"
            ));
        }
        if let Some(lens) = self.lens {
            lens.lens().check().map_err(|(field, problem)| format!("lens.{field} {problem}"))?;
        }
        if let FilterSettings::Gaussian { radius, sigma } = self.filter {
            positive("filter.sigma", sigma)?;
            if !(0.5..=16.0).contains(&radius) {
                return Err(format!("filter.radius is {radius}; it must be from 0.5 to 16 pixels"));
            }
        }
        if !(1..=1024).contains(&self.max_edges) {
            return Err(format!("max_edges is {}; it must be from 1 to 1024", self.max_edges));
        }
        if !(1..=self.max_edges).contains(&self.min_edges) {
            return Err(format!(
                "min_edges is {}; it must be from 1 to max_edges, which is {}",
                self.min_edges, self.max_edges
            ));
        }
        self.environment.as_ref().map_or(Ok(()), EnvironmentSettings::validate)?;
        self.medium.as_ref().map_or(Ok(()), MediumSettings::validate)?;
        match self.budget {
            Budget::SamplesPerPixel(samples) => positive("budget: SamplesPerPixel", samples)?,
            Budget::Seconds(seconds) => positive("budget: Seconds", seconds)?,
        }
        if self.roulette.start < 2 {
            return Err(format!("roulette.start is {}; the first 2 vertices are always sampled", self.roulette.start));
        }
        if !(self.roulette.survival > 0.0 && self.roulette.survival <= 1.0) {
            return Err(format!("roulette.survival is {}; it must be in (0, 1]", self.roulette.survival));
        }
        self.primary.validate()?;
        self.mlt.validate()
    }
}

impl PrimarySettings {
    /// The mixture of large and small steps.
    pub(crate) fn mutations<E>(&self) -> Vec<(f64, PrimaryMutation<E>)> {
        let small = PrimaryMutation::small(self.min_step, self.max_step);
        vec![(self.large_step, PrimaryMutation::Large), (1.0 - self.large_step, small)]
    }

    fn validate(&self) -> Result<(), String> {
        if !(self.large_step > 0.0 && self.large_step <= 1.0) {
            return Err(format!(
                "primary.large_step is {}; it must be in (0, 1], because no other step reaches everything",
                self.large_step
            ));
        }
        if !(self.min_step >= 1e-12 && self.min_step < self.max_step && self.max_step < 0.5) {
            return Err(format!(
                "primary.min_step is {} and max_step {}; they must satisfy 1e-12 <= min_step < max_step < 0.5",
                self.min_step, self.max_step
            ));
        }
        Ok(())
    }
}

impl MltSettings {
    /// The mixture without the mutations of weight 0 and those that can change no path of a scene with these effects.
    pub fn mutations_for(&self, effects: Effects) -> Vec<(f64, AnyMutation)> {
        let used =
            |(weight, mutation): &&(f64, AnyMutation)| *weight > 0.0 && mutation.never_applies(effects).is_none();
        self.mutations.iter().filter(used).copied().collect()
    }

    fn validate(&self) -> Result<(), String> {
        if !(1..=1 << 20).contains(&self.chains) {
            return Err(format!("mlt.chains is {}; it must be from 1 to {}", self.chains, 1 << 20));
        }
        if let Direct::Separate { samples_per_pixel: 0 } = self.direct {
            return Err("mlt.direct: Separate has 0 samples_per_pixel; give at least 1, or use InChain".into());
        }
        if !(self.seeding.relative_error > 0.0 && self.seeding.relative_error.is_finite()) {
            return Err(format!(
                "mlt.seeding.relative_error is {}; it must be greater than 0",
                self.seeding.relative_error
            ));
        }
        if !(1000..=MOST_SEEDS).contains(&self.seeding.max_samples) {
            let given = self.seeding.max_samples;
            return Err(format!("mlt.seeding.max_samples is {given}; it must be from 1000 to {MOST_SEEDS}"));
        }
        if !(0.0..=GREATEST_SHARE).contains(&self.share) {
            return Err(format!("mlt.share is {}; it must be from 0 to {GREATEST_SHARE}", self.share));
        }
        for (i, (weight, mutation)) in self.mutations.iter().enumerate() {
            if !(weight.is_finite() && *weight >= 0.0) {
                return Err(format!("mlt.mutations[{i}] has weight {weight}; weights are finite and not negative"));
            }
            mutation.validate().map_err(|what| format!("mlt.mutations[{i}] ({}): {what}", mutation.name()))?;
        }
        let ergodic = |(weight, mutation): &(f64, AnyMutation)| *weight > 0.0 && mutation.is_ergodic();
        if !self.mutations.iter().any(ergodic) {
            return Err(
                "mlt.mutations needs Bidirectional with a positive weight: no other mutation reaches every path, \
                        so without it the picture would be wrong"
                    .into(),
            );
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_units_of_blender_agree() {
        // Lights of 40 W, 200 W and 0.5 W/m2 as the exporter of Blender 4.5 writes them in its three modes.
        let modes = [
            (LightUnits::Photometric, [2_174.056_522_635_290_5, 10_870.282_613_176_45, 341.5]),
            (LightUnits::Radiometric, [3.183_098_861_837_907, 15.915_494_309_189_533, 0.5]),
            (LightUnits::Watts, [40.0, 200.0, 0.5]),
        ];
        let pi = std::f64::consts::PI;
        for (units, [point, spot, sun]) in modes {
            let (intensity, irradiance) = units.to_radiometric();
            assert!((point * intensity - 10.0 / pi).abs() < 1e-12, "{units:?}");
            assert!((spot * intensity - 50.0 / pi).abs() < 1e-12, "{units:?}");
            assert!((sun * irradiance - 0.5).abs() < 1e-15, "{units:?}");
        }
    }
}
