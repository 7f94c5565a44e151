//! One chain of primary samples and what it leaves behind.

use std::convert::Infallible;
use std::time::Instant;

use ergodic_metropolis::{Chain, Density, Mixture, NotProposed, Step};
use ergodic_pathspace::{Measured, PathClass};
use ergodic_scattering::Rgb;
use rand_pcg::Pcg64Dxsm;

use super::coordinates::PrimarySample;
use super::mutation::{PrimaryMutation, PrimarySpace, PrimaryTarget, PrimaryValue};
use crate::chain_runner::{FAULTS_KEPT, FaultRecord, Ledger, TIMED_EVERY};
use crate::chains::Runner;
use crate::mixing::ChainTrace;
use crate::statistics::Outcome;
use crate::{Estimator, SplatBuffer};

/// A chain under way.
pub(super) struct PrimaryRunner<E: Estimator> {
    index: u64,
    chain: Chain<PrimarySample<E>, PrimaryValue>,
    rng: Pcg64Dxsm,
    class: PathClass,
    steps: u64,
    /// Weight that the current sample has gathered and not yet left on the film.
    pending: f64,
    /// Steps since the chain last moved.
    stay: u64,
    trace: ChainTrace,
}

/// Leaves the light of a sample on the film, with the weight of `visits` visits.
fn leave<E: Estimator>(sample: &PrimarySample<E>, visits: f64, splats: &mut SplatBuffer) {
    if visits > 0.0 {
        let scale = visits / sample.luminance();
        sample.splats().iter().for_each(|(raster, color)| splats.splat(*raster, *color * scale));
    }
}

/// What is watched of a sample.
fn measured<E: Estimator>(sample: &PrimarySample<E>) -> Measured {
    let luminance = Density::new(sample.luminance());
    Measured { luminance, color: Rgb::ZERO, raster: sample.brightest() }
}

impl<E: Estimator> Runner for PrimaryRunner<E> {
    fn finish(&mut self, ledger: &mut Ledger) {
        let current = measured(self.chain.current().0);
        self.trace.record(&current, self.class, self.stay);
        self.trace.record_stay(self.class, self.stay);
        if let Some(visits) = &mut ledger.visits {
            visits.stayed(current.raster, self.stay);
        }
        self.stay = 0;
    }

    fn trace(&self) -> &ChainTrace {
        &self.trace
    }
}

impl<E: Estimator> PrimaryRunner<E> {
    /// A chain that starts at `start`.
    pub(super) fn new(index: u64, start: PrimarySample<E>, rng: Pcg64Dxsm) -> Self {
        let class = start.class();
        let chain = Chain::new(start, &PrimaryTarget::default());
        Self { index, chain, rng, class, steps: 0, pending: 0.0, stay: 0, trace: ChainTrace::new(index) }
    }

    /// Takes `count` steps.
    pub(super) fn run(
        &mut self,
        count: u64,
        mixture: &Mixture<PrimaryMutation<E>>,
        space: &PrimarySpace,
        ledger: &mut Ledger,
    ) {
        for _ in 0..count {
            let timer = self.steps.is_multiple_of(TIMED_EVERY).then(Instant::now);
            let before = self.rng.clone();
            let from = self.chain.current().0.brightest();
            self.steps += 1;
            let step: Step<(usize, ()), NotProposed<Infallible>> =
                self.chain.step(&PrimaryTarget::default(), mixture, space, &mut self.rng);
            let class = self.class;
            let (mutation, outcome) = match step {
                Step::NotProposed(NotProposed::NoneSuitable) => {
                    ledger.none_suitable += 1;
                    self.stays();
                    continue;
                }
                Step::NotProposed(NotProposed::Failed { reason, .. }) => match reason {},
                Step::Faulty { plan: (mutation, ()), fault } => {
                    self.stays();
                    if ledger.faults.len() < FAULTS_KEPT {
                        let (chain, step) = (self.index, self.steps - 1);
                        ledger.faults.push(FaultRecord { chain, step, mutation, fault, class, stream: before });
                    }
                    (mutation, Outcome::Faulty(fault))
                }
                Step::Tried { plan: (mutation, ()), acceptance, accepted } => {
                    (mutation, self.deposit(acceptance, accepted, ledger))
                }
            };
            if let Some(visits) = &mut ledger.visits {
                let acceptance = if let Outcome::Tried { acceptance, .. } = outcome { acceptance } else { 0.0 };
                visits.proposed(from, acceptance);
            }
            let nanoseconds = timer.map(|timer| timer.elapsed().as_nanos() as u64);
            ledger.mutations[mutation].record(class, outcome, nanoseconds);
        }
        // Nothing stays pending between calls, so that the splats are complete whenever they are looked at.
        leave(self.chain.current().0, self.pending, &mut ledger.splats);
        self.pending = 0.0;
    }

    fn stays(&mut self) {
        self.pending += 1.0;
        self.stay += 1;
    }

    /// Expected values (Veach 11.3.2): the sample before gets 1 - a of this step, the candidate a.
    fn deposit(&mut self, acceptance: f64, accepted: bool, ledger: &mut Ledger) -> Outcome {
        let (current, other) = (self.chain.current().0, self.chain.other().0);
        self.pending += 1.0 - acceptance;
        let (here, there) = (current.brightest(), other.brightest());
        if accepted {
            leave(other, self.pending, &mut ledger.splats);
            self.pending = acceptance;
            let left = measured(other);
            self.trace.record(&left, self.class, self.stay + 1);
            if let Some(visits) = &mut ledger.visits {
                visits.stayed(left.raster, self.stay);
            }
            self.class = current.class();
            self.stay = 0;
        } else {
            self.stay += 1;
            leave(other, acceptance, &mut ledger.splats);
        }
        let jump = if acceptance > 0.0 { here.distance(there) } else { 0.0 };
        Outcome::Tried { acceptance, accepted, jump }
    }
}
