//! Chains run by hand, so that what they leave on the film can be chosen.

use ergodic_metropolis::{Chain, Mixture, RandomSource, Step};
use ergodic_mutations::AnyMutation;
use ergodic_pathspace::{BidirectionalSampler, Lengths, LuminanceTarget, Measured, Path, PathSpace, Roulette};
use ergodic_render::{Film, Purpose, Seeding, Seeds, SplatBuffer, Unobserved, stream};
use ergodic_scattering::luminance;

use super::work::Work;

/// What a step leaves on the film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Deposit {
    /// The path before and the candidate, by the probability of each (Veach 11.3.2).
    Expected,
    /// The path after the step.
    Plain,
}

/// Where chains start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Starts {
    /// Seeds drawn by their weight.
    Resampled,
    /// Whatever path carries light, without regard to how much: what start-up bias comes from.
    Naive,
}

/// One scene with the default mixture; all light comes from the chains.
pub struct Chains {
    space: PathSpace,
    mixture: Mixture<AnyMutation>,
    roulette: Roulette,
    size: (u32, u32),
}

/// Chains at their starts.
pub struct Ready {
    chains: Vec<(Chain<Path, Measured>, rand_pcg::Pcg64Dxsm)>,
    /// Estimate of b from the same samples.
    pub b: f64,
}

impl Chains {
    pub fn new(work: &Work) -> Result<Self, String> {
        let settings = &work.settings;
        let roulette = Roulette { start: settings.roulette.start, survival: settings.roulette.survival };
        let mixture = Mixture::new(settings.mlt.mutations_for(work.scene.effects())).map_err(|e| e.to_string())?;
        let space = PathSpace { scene: work.scene.clone(), lengths: settings.lengths() };
        Ok(Self { space, mixture, roulette, size: settings.size })
    }

    fn lengths(&self) -> Lengths {
        self.space.lengths
    }

    /// Chains of a replica.
    pub fn ready(&self, seed: u64, count: usize, samples: u64, starts: Starts) -> Ready {
        let seeding = Seeding { relative_error: 1e-9, max_samples: samples };
        let seeds = Seeds::draw(&self.space.scene, self.lengths(), self.roulette, &seeding, seed, &Unobserved);
        let paths = match starts {
            Starts::Resampled => seeds.starts(&self.space.scene, count),
            Starts::Naive => self.first_found(seed, count),
        };
        let chain =
            |(index, path)| (Chain::new(path, &LuminanceTarget::default()), stream(seed, Purpose::Chain, index));
        Ready { chains: (0..).zip(paths).map(chain).collect(), b: seeds.b }
    }

    /// The first paths that carry light at all.
    fn first_found(&self, seed: u64, count: usize) -> Vec<Path> {
        let scene = &self.space.scene;
        let mut sampler = BidirectionalSampler::new(self.lengths(), self.roulette);
        let mut found = Vec::with_capacity(count);
        // Not the samples that b comes from.
        let mut rng = stream(seed, Purpose::Pilot, 0);
        while found.len() < count {
            let mut path = Path::with_capacity(self.lengths().max_edges);
            let mut any = false;
            sampler.sample(scene, &mut rng, |sampler, connection| {
                if !any && luminance(connection.contribution()) > 0.0 {
                    sampler.assemble(scene, connection.s, connection.t, &mut path);
                    any = true;
                }
            });
            if any {
                found.push(path);
            }
        }
        found
    }

    /// Luminances of the picture of chains that make `steps` steps each, for b = 1.
    pub fn run(&self, ready: &Ready, steps: u64, deposit: Deposit) -> Vec<f64> {
        let (width, height) = self.size;
        let mut film = Film::new(width, height, ergodic_scattering::Filter::Box);
        let mut splats = SplatBuffer::new();
        for (chain, rng) in &ready.chains {
            let (mut chain, mut rng) = (chain.clone(), rng.clone());
            match deposit {
                Deposit::Expected => self.expected(&mut chain, &mut rng, steps, &mut splats, &mut film),
                Deposit::Plain => self.plain(&mut chain, &mut rng, steps, &mut splats, &mut film),
            }
        }
        film.take(&mut splats);
        let scale = self.space.scene.camera().image_area_pixels() / (steps * ready.chains.len() as u64) as f64;
        film.develop(scale).pixels.iter().map(|pixel| luminance(*pixel)).collect()
    }

    fn expected(
        &self,
        chain: &mut Chain<Path, Measured>,
        rng: &mut impl RandomSource,
        steps: u64,
        splats: &mut SplatBuffer,
        film: &mut Film,
    ) {
        // Weight that the current path has gathered and not yet left on the film.
        let mut pending = 0.0;
        for _ in 0..steps {
            match chain.step(&LuminanceTarget::default(), &self.mixture, &self.space, rng) {
                Step::Tried { acceptance, accepted, .. } => {
                    let other = *chain.other().1;
                    pending += 1.0 - acceptance;
                    if accepted {
                        leave(&other, pending, splats, film);
                        pending = acceptance;
                    } else if acceptance > 0.0 {
                        leave(&other, acceptance, splats, film);
                    }
                }
                Step::NotProposed(_) | Step::Faulty { .. } => pending += 1.0,
            }
        }
        leave(chain.current().1, pending, splats, film);
    }

    fn plain(
        &self,
        chain: &mut Chain<Path, Measured>,
        rng: &mut impl RandomSource,
        steps: u64,
        splats: &mut SplatBuffer,
        film: &mut Film,
    ) {
        let mut visits = 0.0;
        for _ in 0..steps {
            if let Step::Tried { accepted: true, .. } =
                chain.step(&LuminanceTarget::default(), &self.mixture, &self.space, rng)
            {
                leave(chain.other().1, visits, splats, film);
                visits = 0.0;
            }
            visits += 1.0;
        }
        leave(chain.current().1, visits, splats, film);
    }
}

fn leave(path: &Measured, weight: f64, splats: &mut SplatBuffer, film: &mut Film) {
    if weight > 0.0 {
        if splats.room() == 0 {
            film.take(splats);
        }
        splats.splat(path.raster, path.color * weight);
    }
}
