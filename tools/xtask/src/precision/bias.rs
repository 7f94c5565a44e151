//! The number of chains at equal mutations: start-up bias and spread.

use ergodic_assess::accuracy::mean;
use ergodic_scattering::{Rgb, luminance};

use super::Effort;
use super::chains::{Chains, Deposit, Starts};
use super::page::{Section, cell, signed_percent, table};
use super::work::{Work, on_one_thread, spread};

const SCENES: [&str; 2] = ["cornell", "glass"];
const MUTATIONS: u64 = 65_536;
const COUNTS: [usize; 4] = [1, 16, 256, 4096];
const SAMPLES: u64 = 16_384;

/// The mean luminance of the darker half of the pixels over that of the reference, less 1: the mean over the whole picture is
/// b whatever chains do, so that it says nothing of them.
struct DarkHalf {
    pixels: Vec<usize>,
    mean: f64,
}

impl DarkHalf {
    fn new(work: &Work) -> Self {
        let luminances: Vec<f64> = work.reference.mean.pixels.iter().map(|p| luminance(Rgb::from_array(*p))).collect();
        let mut pixels: Vec<usize> = (0..luminances.len()).collect();
        pixels.sort_by(|a, b| luminances[*a].total_cmp(&luminances[*b]));
        pixels.truncate(luminances.len() / 2);
        let mean = pixels.iter().map(|pixel| luminances[*pixel]).sum::<f64>() / pixels.len() as f64;
        Self { pixels, mean }
    }

    fn bias(&self, picture: &[f64], b: f64) -> f64 {
        let mean = self.pixels.iter().map(|pixel| picture[*pixel]).sum::<f64>() / self.pixels.len() as f64;
        b * mean / self.mean - 1.0
    }
}

/// Measures both scenes.
pub fn measure(effort: &Effort) -> Result<Section, String> {
    let mutations = MUTATIONS / effort.divisor;
    let mut rows = Vec::new();
    for name in SCENES {
        let work = Work::new(name)?;
        let (chains, dark) = (Chains::new(&work)?, DarkHalf::new(&work));
        for count in COUNTS {
            let steps = mutations / count as u64;
            let of = |starts: Starts| -> Result<Vec<f64>, String> {
                on_one_thread(|| {
                    let one = |seed: usize| {
                        let ready = chains.ready(seed as u64, count, SAMPLES, starts);
                        dark.bias(&chains.run(&ready, steps, Deposit::Expected), ready.b)
                    };
                    (0..effort.replicas).map(one).collect()
                })
            };
            let (resampled, naive) = (of(Starts::Resampled)?, of(Starts::Naive)?);
            rows.push(vec![
                format!("`{name}`"),
                count.to_string(),
                steps.to_string(),
                signed_percent(mean(&resampled)),
                cell(spread(&resampled.iter().map(|bias| 100.0 * bias).collect::<Vec<_>>())),
                signed_percent(mean(&naive)),
            ]);
        }
    }
    Ok(Section {
        title: "Number of chains against start-up bias",
        parts: vec![
            format!(
                "{mutations} mutations in all, shared by 1 to 4096 chains, {} replicas, against the stored references. The mean over \
                 the whole picture is b\nwhatever chains do, so this is the mean luminance of the darker half of the pixels. *Seeds by \
                 weight* is what `ergodic` does: starts drawn\nfrom the samples of b in proportion to what they carry, which leaves no \
                 bias however short the chains are (Veach 11.3.1). *Any path* starts\nfrom the first path that carries light at all, \
                 and shows that a bias would be seen.",
                effort.replicas
            ),
            table(
                &[
                    "scene",
                    "chains",
                    "mutations a chain",
                    "bias, seeds by weight",
                    "standard deviation, %",
                    "bias, any path",
                ],
                &rows,
            ),
        ],
    })
}
