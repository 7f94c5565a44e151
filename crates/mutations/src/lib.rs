//! The path-space mutations of Veach 11.4, one file each, and their registry.
//!
//! To add a mutation: one file that implements [`Mutation`] for a struct with its settings, and one line in
//! [`AnyMutation`] below. That gives it dispatch, its RON syntax, its row in the statistics and its place in the laws.

mod bidirectional;
mod caustic;
mod chains;
mod eye_side;
mod jump;
mod lens;
mod lens_subpath;
mod multi_chain;
mod retrace;
mod splice;
mod volume;
mod wavelength;

pub use bidirectional::Bidirectional;
pub use caustic::Caustic;
pub use lens::Lens;
pub use lens_subpath::LensSubpath;
pub use multi_chain::MultiChain;
pub use splice::{Rejection, Splice};
pub use volume::Volume;

use ergodic_geometry::phase::{self, Phase};
use ergodic_metropolis::{Density, Mutation, RandomSource};
use ergodic_pathspace::{Effects, Path, PathSpace};
use serde::{Deserialize, Serialize};

use jump::JumpRange;

/// What the registry asks of a mutation beside [`Mutation`] itself.
pub trait PathMutation:
    Mutation<Space = PathSpace, State = Path, Plan = Splice, Failure = Rejection> + Default + Copy
{
    /// Whether this mutation alone reaches every path from every other.
    const ERGODIC: bool = false;

    /// Its weight where a config states no mixture. 0 for what helps in some scenes only.
    const WEIGHT: f64 = 1.0;

    /// Why it can change no path of a scene that has these effects only; `None` if it may.
    fn never_applies(_effects: Effects) -> Option<&'static str> {
        None
    }

    /// Checks the settings.
    ///
    /// # Errors
    ///
    /// A sentence that names the setting and what is allowed.
    fn validate(&self) -> Result<(), String>;
}

/// Checks the settings of a jump on the image.
fn validate_image_jump(min_pixels: f64, image_share: f64) -> Result<(), String> {
    if !(min_pixels > 0.0 && min_pixels.is_finite()) {
        return Err(format!("min_pixels is {min_pixels}; it must be greater than 0"));
    }
    if !(image_share > 0.0 && image_share <= 1.0) {
        return Err(format!("image_share is {image_share}; it must be in (0, 1]"));
    }
    Ok(())
}

macro_rules! registry {
    ($($(#[$doc:meta])* $variant:ident => $name:literal),+ $(,)?) => {
        /// A path-space mutation, chosen by name.
        #[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
        pub enum AnyMutation {
            $($(#[$doc])* $variant($variant)),+
        }

        impl AnyMutation {
            /// Every mutation there is, with its default settings.
            pub fn all() -> Vec<Self> {
                vec![$(Self::$variant($variant::default())),+]
            }

            /// Every mutation there is, with the weight that it has where a config states no mixture.
            pub fn default_mixture() -> Vec<(f64, Self)> {
                vec![$(($variant::WEIGHT, Self::$variant($variant::default()))),+]
            }

            /// Its name in tables and files.
            pub fn name(&self) -> &'static str {
                match self { $(Self::$variant(_) => $name),+ }
            }

            /// Whether it alone reaches every path from every other.
            pub fn is_ergodic(&self) -> bool {
                match self { $(Self::$variant(_) => $variant::ERGODIC),+ }
            }

            /// Why it can change no path of a scene that has these effects only; `None` if it may.
            pub fn never_applies(&self, effects: Effects) -> Option<&'static str> {
                match self { $(Self::$variant(_) => $variant::never_applies(effects)),+ }
            }

            /// Checks the settings.
            ///
            /// # Errors
            ///
            /// A sentence that names the setting and what is allowed.
            pub fn validate(&self) -> Result<(), String> {
                match self { $(Self::$variant(m) => PathMutation::validate(m)),+ }
            }
        }

        impl Mutation for AnyMutation {
            type Space = PathSpace;
            type State = Path;
            type Plan = Splice;
            type Failure = Rejection;

            #[inline]
            fn suitability(&self, space: &PathSpace, x: &Path) -> f64 {
                match self { $(Self::$variant(m) => m.suitability(space, x)),+ }
            }

            #[inline]
            fn propose(
                &self,
                space: &PathSpace,
                x: &Path,
                y: &mut Path,
                rng: &mut impl RandomSource,
            ) -> Result<Splice, Rejection> {
                match self { $(Self::$variant(m) => m.propose(space, x, y, rng)),+ }
            }

            #[inline]
            fn ln_density(&self, space: &PathSpace, from: &Path, to: &Path, plan: Splice) -> f64 {
                self.density(space, from, to, plan).ln()
            }

            #[inline]
            fn density(&self, space: &PathSpace, from: &Path, to: &Path, plan: Splice) -> Density {
                let _phase = phase::enter(Phase::Density);
                match self { $(Self::$variant(m) => m.density(space, from, to, plan)),+ }
            }
        }
    };
}

registry! {
    /// Replaces a run of vertices by bidirectional sampling.
    Bidirectional => "bidirectional",
    /// Moves the image point and keeps the rest.
    Lens => "lens",
    /// Turns the light that makes a caustic.
    Caustic => "caustic",
    /// Moves the image point through several Dirac chains.
    MultiChain => "multi_chain",
    /// Moves a point in a medium.
    Volume => "volume",
    /// Replaces what the eye sees and keeps the rest.
    LensSubpath => "lens_subpath",
}

/// The radius in pixels of a disk with this share of the image's area.
#[inline]
pub(crate) fn max_pixels(space: &PathSpace, image_share: f64) -> f64 {
    (image_share * space.scene.camera().image_area_pixels() / std::f64::consts::PI).sqrt()
}

/// Moves of the image point. The smallest is kept below the largest on images of a few pixels.
#[inline]
pub(crate) fn image_jumps(space: &PathSpace, min_pixels: f64, image_share: f64) -> JumpRange {
    let max = max_pixels(space, image_share);
    JumpRange::new(min_pixels.min(max * 0.1), max)
}
