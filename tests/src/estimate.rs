//! Means over independent replicas, with their errors.

use std::ops::RangeInclusive;

use ergodic_assess::Image;
use ergodic_pathspace::Scene;
use ergodic_render::{
    Budget, Direct, Life, Method, Picture, RenderError, Rendering, Settings, Unobserved, render_replicas,
};
use ergodic_scattering::Rgb;

/// A mean over replicas and its standard error, for each channel.
#[derive(Clone, Copy, Debug)]
pub struct Estimate {
    /// The mean.
    pub mean: Rgb,
    /// Its standard error.
    pub error: Rgb,
}

impl Estimate {
    /// Of independent values.
    pub fn of(values: &[Rgb]) -> Self {
        let n = values.len() as f64;
        let mean = values.iter().sum::<Rgb>() / n;
        let variance = values.iter().map(|rgb| (*rgb - mean) * (*rgb - mean)).sum::<Rgb>() / (n - 1.0);
        Self { mean, error: (variance / n).map(f64::sqrt) }
    }

    /// The greatest distance of a channel from the truth, in standard errors. Where nothing is random, rounding is what is
    /// left.
    pub fn z(&self, truth: Rgb) -> f64 {
        self.z_against(&Self { mean: truth, error: 1e-9 * truth.abs() })
    }

    /// The greatest distance of a channel from another estimate, in standard errors of the difference.
    pub fn z_against(&self, other: &Self) -> f64 {
        let error = (self.error * self.error + other.error * other.error).map(f64::sqrt);
        let difference = (self.mean - other.mean).abs();
        (0..3).filter(|c| difference[*c] > 0.0).map(|c| difference[c] / error[c]).fold(0.0, f64::max)
    }

    /// The greatest relative error of a channel that is not black.
    pub fn relative_error(&self) -> f64 {
        (0..3).filter(|c| self.mean[*c] > 0.0).map(|c| self.error[c] / self.mean[c]).fold(0.0, f64::max)
    }
}

/// Renders replicas and takes the means of what `of` says of each picture. What went wrong with a contribution is an error.
pub fn estimate<const N: usize>(
    scene: &Scene,
    settings: &Settings,
    replicas: usize,
    of: impl Fn(&Picture) -> [Rgb; N],
) -> Result<[Estimate; N], RenderError> {
    let renderings = render_replicas(scene, settings, replicas, &Unobserved)?;
    let left_out: u64 = renderings.iter().map(left_out).sum();
    assert_eq!(left_out, 0, "contributions were not finite, or negative");
    let found: Vec<[Rgb; N]> = renderings.iter().map(|rendering| of(&rendering.picture)).collect();
    Ok(std::array::from_fn(|i| Estimate::of(&found.iter().map(|values| values[i]).collect::<Vec<_>>())))
}

/// Contributions and proposals of a rendering that were no numbers, or negative.
fn left_out(rendering: &Rendering) -> u64 {
    let faulty = rendering.mlt.iter().flat_map(|report| &report.statistics).flat_map(|s| s.total().faulty);
    rendering.counts.stability.total() + faulty.sum::<u64>()
}

/// Settings for paths of the given numbers of edges, all of them from the chains, on a square picture; with 16 times the samples
/// where the nightly sizes are asked for.
pub fn settings(method: Method, edges: &RangeInclusive<usize>, side: u32, samples_per_pixel: f64) -> Settings {
    let mut settings = Settings {
        method,
        size: (side, side),
        seed: 1,
        min_edges: *edges.start(),
        max_edges: *edges.end(),
        budget: Budget::SamplesPerPixel(nightly(1.0, 16.0) * samples_per_pixel),
        ..Settings::default()
    };
    settings.mlt.chains = 64;
    // What a mutation does wrong adds up; a picture by short lives would be one of their starts.
    settings.mlt.life = Life::Mutations(4096);
    settings.mlt.direct = Direct::InChain;
    // The mean over the whole picture is b then, which is known better than what chains make.
    settings.mlt.two_stage = false;
    settings.mlt.seeding.relative_error = 0.01;
    settings.mlt.seeding.max_samples = 200_000;
    settings
}

/// A picture as the images that references are compared with.
pub fn image(picture: &Picture) -> Image {
    let pixels = picture.pixels.iter().map(|p| p.to_array()).collect();
    Image { width: picture.width, height: picture.height, pixels }
}

/// `small`, or `large` where the nightly sizes are asked for: with ERGODIC_TESTS=nightly in the environment.
pub fn nightly<T>(small: T, large: T) -> T {
    if std::env::var("ERGODIC_TESTS").is_ok_and(|value| value == "nightly") { large } else { small }
}
