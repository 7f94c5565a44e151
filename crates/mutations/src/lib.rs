//! The path-space mutations of Veach 11.4, one file each, and their registry.
//!
//! To add a mutation: one file that implements [`PathMutation`] and [`Registered`] for a struct with its settings, and one line in
//! [`AnyMutation`] below. That gives it dispatch, its RON syntax, its row in the statistics and its place in the laws.

#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

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

use std::marker::PhantomData;

use ergodic_geometry::phase::{self, Phase};
use ergodic_metropolis::{Density, Mixture, MixtureError, Mutation, RandomSource};
use ergodic_pathspace::{Effects, Path, PathSpace};
use ergodic_scattering::{Everything, Repertoire};
use serde::{Deserialize, Serialize};

use jump::JumpRange;

/// A mutation of paths, compiled for each repertoire of scenes. In the repertoire [`Everything`] it is a [`Mutation`] as it stands, in
/// another one as [`InRepertoire`].
pub trait PathMutation: Copy {
    /// The relative weight with which it wants to be chosen from `x`: see [`Mutation::suitability`].
    #[inline]
    fn suitability<R: Repertoire>(&self, _space: &PathSpace<R>, _x: &Path<R>) -> f64 {
        1.0
    }

    /// Makes `y` a candidate, or says why there is none: see [`Mutation::propose`].
    fn propose<R: Repertoire>(
        &self,
        space: &PathSpace<R>,
        x: &Path<R>,
        y: &mut Path<R>,
        rng: &mut impl RandomSource,
    ) -> Result<Splice, Rejection>;

    /// The joint density of `(plan, to)` given `from`, in the product of the measures of the new vertices: see [`Mutation::density`].
    fn density<R: Repertoire>(&self, space: &PathSpace<R>, from: &Path<R>, to: &Path<R>, plan: Splice) -> Density;
}

/// What the registry asks of a mutation beside [`PathMutation`] itself.
pub trait Registered: PathMutation + Default {
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

/// A mutation of paths as the kernel of a chain through the path space of a scene of the repertoire R.
#[derive(Clone, Copy, Debug)]
pub struct InRepertoire<M, R> {
    mutation: M,
    repertoire: PhantomData<R>,
}

impl<M, R> InRepertoire<M, R> {
    /// This mutation in the repertoire.
    pub fn new(mutation: M) -> Self {
        Self { mutation, repertoire: PhantomData }
    }

    /// The mixture of weighted mutations in the repertoire.
    ///
    /// # Errors
    ///
    /// Those of [`Mixture::new`].
    pub fn mixture(members: Vec<(f64, M)>) -> Result<Mixture<Self>, MixtureError> {
        Mixture::new(members.into_iter().map(|(weight, mutation)| (weight, Self::new(mutation))).collect())
    }
}

/// Makes a type with [`PathMutation`] a [`Mutation`].
macro_rules! kernel {
    (impl$([$($generics:tt)*])? for $kernel:ty, $repertoire:ty, $mutation:ident => $inner:expr) => {
        impl$(<$($generics)*>)? Mutation for $kernel {
            type Space = PathSpace<$repertoire>;
            type State = Path<$repertoire>;
            type Plan = Splice;
            type Failure = Rejection;

            #[inline]
            fn suitability(&self, space: &Self::Space, x: &Self::State) -> f64 {
                let $mutation = self;
                PathMutation::suitability(&$inner, space, x)
            }

            #[inline]
            fn propose(
                &self,
                space: &Self::Space,
                x: &Self::State,
                y: &mut Self::State,
                rng: &mut impl RandomSource,
            ) -> Result<Splice, Rejection> {
                let $mutation = self;
                PathMutation::propose(&$inner, space, x, y, rng)
            }

            #[inline]
            fn ln_density(&self, space: &Self::Space, from: &Self::State, to: &Self::State, plan: Splice) -> f64 {
                Mutation::density(self, space, from, to, plan).ln()
            }

            #[inline]
            fn density(&self, space: &Self::Space, from: &Self::State, to: &Self::State, plan: Splice) -> Density {
                let $mutation = self;
                PathMutation::density(&$inner, space, from, to, plan)
            }
        }
    };
}

kernel!(impl[M: PathMutation, R: Repertoire] for InRepertoire<M, R>, R, kernel => kernel.mutation);

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
                match self { $(Self::$variant(m) => Registered::validate(m)),+ }
            }
        }

        impl PathMutation for AnyMutation {
            #[inline]
            fn suitability<R: Repertoire>(&self, space: &PathSpace<R>, x: &Path<R>) -> f64 {
                match self { $(Self::$variant(m) => PathMutation::suitability(m, space, x)),+ }
            }

            #[inline]
            fn propose<R: Repertoire>(
                &self,
                space: &PathSpace<R>,
                x: &Path<R>,
                y: &mut Path<R>,
                rng: &mut impl RandomSource,
            ) -> Result<Splice, Rejection> {
                match self { $(Self::$variant(m) => PathMutation::propose(m, space, x, y, rng)),+ }
            }

            #[inline]
            fn density<R: Repertoire>(
                &self,
                space: &PathSpace<R>,
                from: &Path<R>,
                to: &Path<R>,
                plan: Splice,
            ) -> Density {
                let _phase = phase::enter(Phase::Density);
                match self { $(Self::$variant(m) => PathMutation::density(m, space, from, to, plan)),+ }
            }
        }

        kernel!(impl for AnyMutation, Everything, kernel => *kernel);
        $(kernel!(impl for $variant, Everything, kernel => *kernel);)+
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
pub(crate) fn max_pixels<R: Repertoire>(space: &PathSpace<R>, image_share: f64) -> f64 {
    (image_share * space.scene.camera().image_area_pixels() / std::f64::consts::PI).sqrt()
}

/// Moves of the image point. The smallest is kept below the largest on images of a few pixels.
#[inline]
pub(crate) fn image_jumps<R: Repertoire>(space: &PathSpace<R>, min_pixels: f64, image_share: f64) -> JumpRange {
    let max = max_pixels(space, image_share);
    JumpRange::new(min_pixels.min(max * 0.1), max)
}
