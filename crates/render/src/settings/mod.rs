//! What a render is asked to do. Everything here is read from RON.

mod chains;
mod surroundings;

use ergodic_pathspace::{CameraDescription, Forced, Lengths, Projection, Roulette, View};
use ergodic_scattering::Lens;
use serde::{Deserialize, Serialize};

pub(crate) use chains::MOST_SEEDS;
pub use chains::{Direct, Life, MltSettings, PrimarySampler, PrimarySettings, Seeding};
pub use surroundings::{EnvironmentMap, EnvironmentSettings, LightUnits, MediumSettings};

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

impl Default for RouletteSettings {
    fn default() -> Self {
        Self { start: 5, survival: 0.8 }
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

    /// Number of pixels of the film: so many mutations are a sample per pixel.
    pub(crate) fn pixels(&self) -> f64 {
        let (width, height) = self.film_size();
        f64::from(width) * f64::from(height)
    }

    /// The share of the work that seeding has, and direct light, of the method's chains.
    pub(crate) fn share(&self) -> f64 {
        match self.method {
            Method::Pssmlt | Method::Mmlt => self.primary.share,
            Method::Path | Method::Bidirectional | Method::Mlt => self.mlt.share,
        }
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
