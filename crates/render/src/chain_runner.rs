//! One chain of any kind of states and what it leaves behind: splats by expected values, statistics, faults.

use std::sync::Arc;
use std::time::Instant;

use ergodic_geometry::phase::{self, Phase};
use ergodic_metropolis::{Chain, Fault, Mixture, Mutation, NotProposed, RandomSource, Step, Target};
use ergodic_mutations::{Rejection, Splice};
use ergodic_pathspace::{BrightnessMap, LuminanceTarget, Measured, Path, PathClass};
use ergodic_scattering::Repertoire;
use rand_pcg::Pcg64Dxsm;

use crate::layers::VisitBuffer;
use crate::mixing::ChainTrace;
use crate::statistics::{MutationStatistics, Outcome};
use crate::{Film, Settings, SplatBuffer};

/// What a step of a mixture of path mutations comes to.
pub type ChainStep = Step<(usize, Splice), NotProposed<Rejection>>;

/// A state whose chain makes a picture: a path, or a sample of a point of primary sample space.
pub trait Pictured: Clone + Send {
    /// What its chains spend their time by.
    type Target: Target<State = Self, Value: Send> + Clone + Default + Send + Sync;

    /// The target: luminance, or luminance over the brightness of the image.
    fn target(brightness: Option<Arc<BrightnessMap>>) -> Self::Target;

    /// The class of its path.
    fn class(&self) -> PathClass;

    /// What is watched of it, given the target's value there.
    fn measured(&self, value: &ValueOf<Self>) -> Measured;

    /// Leaves its light on the film, with the weight of `visits` visits.
    fn leave(&self, value: &ValueOf<Self>, visits: f64, splats: &mut SplatBuffer);
}

/// The value of the target at a state.
pub type ValueOf<S> = <<S as Pictured>::Target as Target>::Value;

impl<R: Repertoire> Pictured for Path<R> {
    type Target = LuminanceTarget<R>;

    fn target(brightness: Option<Arc<BrightnessMap>>) -> LuminanceTarget<R> {
        LuminanceTarget::new(brightness)
    }

    #[inline]
    fn class(&self) -> PathClass {
        self.class()
    }

    #[inline]
    fn measured(&self, value: &Measured) -> Measured {
        *value
    }

    #[inline]
    fn leave(&self, value: &Measured, visits: f64, splats: &mut SplatBuffer) {
        splats.splat(value.raster, value.color * visits);
    }
}

/// One step in this many is timed: reading the clock costs as much as a cheap proposal.
const TIMED_EVERY: u64 = 16;

/// At most this many faults are kept for replay; all are counted.
const FAULTS_KEPT: usize = 16;

/// A proposal whose density was not a number, with what it takes to see it again.
#[derive(Clone, Debug, PartialEq)]
pub struct FaultRecord {
    /// Chain, by index; a chain that began anew has another.
    pub chain: u64,
    /// Steps of the chain before this one.
    pub step: u64,
    /// Index of the mutation in the mixture.
    pub mutation: usize,
    /// Which density.
    pub fault: Fault,
    /// Class of the path that was to be changed.
    pub class: PathClass,
    /// State of the chain's stream before the step.
    pub stream: Pcg64Dxsm,
}

/// A chain under way.
#[derive(Clone, Debug)]
pub struct ChainRunner<S: Pictured = Path> {
    index: u64,
    target: S::Target,
    chain: Chain<S, ValueOf<S>>,
    rng: Pcg64Dxsm,
    class: PathClass,
    steps: u64,
    /// Weight that the current state has gathered and not yet left on the film.
    pending: f64,
    /// Steps since the chain last moved.
    stay: u64,
    trace: ChainTrace,
}

/// A chain's stream, with its time accounted for.
struct Accounted<'a>(&'a mut Pcg64Dxsm);

impl RandomSource for Accounted<'_> {
    #[inline]
    fn uniform(&mut self) -> f64 {
        let _phase = phase::enter(Phase::Random);
        self.0.uniform()
    }
}

/// Where a chain leaves its results.
#[derive(Clone, Debug)]
pub struct Ledger {
    /// Splats: for every call of [`ChainRunner::run`] one more than its steps at most.
    pub splats: SplatBuffer,
    /// One entry for each member of the mixture.
    pub mutations: Vec<MutationStatistics>,
    /// The first faults.
    pub faults: Vec<FaultRecord>,
    /// Steps in which no mutation of the mixture was suitable.
    pub none_suitable: u64,
    /// What happened at which pixel, if that is asked for; as many entries as splats at most.
    pub visits: Option<VisitBuffer>,
}

impl Ledger {
    /// Whether a chain can take `steps` steps without a buffer that has to grow.
    pub(crate) fn has_room(&self, steps: u64) -> bool {
        let room = self.visits.as_ref().map_or(usize::MAX, VisitBuffer::room).min(self.splats.room());
        steps < room as u64
    }

    /// Leaves the splats on a film if a chain that takes `steps` steps might have no room for more.
    pub fn make_room(&mut self, steps: u64, film: &mut Film) {
        if !self.has_room(steps) {
            film.take(&mut self.splats);
        }
    }

    /// An empty one for the members of a mixture, by their names.
    pub fn new(settings: &Settings, names: &[&'static str]) -> Self {
        Self {
            splats: SplatBuffer::new(),
            mutations: MutationStatistics::of_members(names, settings.max_edges),
            faults: Vec::new(),
            none_suitable: 0,
            visits: settings.mlt.layers.then(|| VisitBuffer::new(settings.film_size())),
        }
    }
}

impl ChainRunner {
    /// The path that the chain is at.
    pub fn path(&self) -> &Path {
        self.chain.current().0
    }

    /// After a step that built a candidate and stayed: the candidate.
    pub fn candidate(&self) -> &Path {
        self.chain.other().0
    }
}

impl<S: Pictured> ChainRunner<S> {
    /// A chain that starts at `start`, and whose target is luminance.
    pub fn new(index: u64, start: S, rng: Pcg64Dxsm) -> Self {
        Self::with_target(S::Target::default(), index, start, rng)
    }

    /// A chain that starts at `start`.
    pub fn with_target(target: S::Target, index: u64, start: S, rng: Pcg64Dxsm) -> Self {
        let class = start.class();
        let chain = Chain::new(start, &target);
        Self { index, target, chain, rng, class, steps: 0, pending: 0.0, stay: 0, trace: ChainTrace::new(index) }
    }

    /// Becomes another chain, that of number `index` which starts at `start`. Means of what shows its mixing go on.
    pub(crate) fn begin_anew(&mut self, index: u64, start: S, rng: Pcg64Dxsm, ledger: &mut Ledger) {
        self.finish(ledger);
        self.trace.begin_anew();
        self.class = start.class();
        self.chain = Chain::new(start, &self.target);
        (self.index, self.rng, self.steps) = (index, rng, 0);
    }

    /// Takes the present stay into account, after the last step.
    pub(crate) fn finish(&mut self, ledger: &mut Ledger) {
        let current = self.here();
        self.trace.record(&current, self.class, self.stay);
        self.trace.record_stay(self.class, self.stay);
        if let Some(visits) = &mut ledger.visits {
            visits.stayed(current.raster, self.stay);
        }
        self.stay = 0;
    }

    /// What the chain shows of its mixing.
    pub(crate) fn trace(&self) -> &ChainTrace {
        &self.trace
    }

    /// Number of steps taken since the start.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// One transition, without leaving anything behind.
    #[inline]
    pub fn step<M>(&mut self, mixture: &Mixture<M>, space: &M::Space) -> Step<(usize, M::Plan), NotProposed<M::Failure>>
    where
        M: Mutation<State = S>,
    {
        self.steps += 1;
        self.chain.step(&self.target, mixture, space, &mut Accounted(&mut self.rng))
    }

    /// Takes `count` steps.
    pub fn run<M>(&mut self, count: u64, mixture: &Mixture<M>, space: &M::Space, ledger: &mut Ledger)
    where
        M: Mutation<State = S>,
        M::Failure: Into<Rejection>,
    {
        for _ in 0..count {
            let timer = self.steps.is_multiple_of(TIMED_EVERY).then(Instant::now);
            let before = self.rng.clone();
            let from = self.here().raster;
            let step = self.step(mixture, space);
            let class = self.class;
            let (mutation, outcome) = match step {
                Step::NotProposed(NotProposed::NoneSuitable) => {
                    ledger.none_suitable += 1;
                    self.stays();
                    continue;
                }
                Step::NotProposed(NotProposed::Failed { index, reason }) => {
                    self.stays();
                    (index, Outcome::NotBuilt(reason.into()))
                }
                Step::Faulty { plan: (mutation, _), fault } => {
                    self.stays();
                    if ledger.faults.len() < FAULTS_KEPT {
                        let (chain, step) = (self.index, self.steps - 1);
                        ledger.faults.push(FaultRecord { chain, step, mutation, fault, class, stream: before });
                    }
                    (mutation, Outcome::Faulty(fault))
                }
                Step::Tried { plan: (mutation, _), acceptance, accepted } => {
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
        let (current, value) = self.chain.current();
        current.leave(value, self.pending, &mut ledger.splats);
        self.pending = 0.0;
    }

    fn stays(&mut self) {
        self.pending += 1.0;
        self.stay += 1;
    }

    /// What is watched of the current state.
    #[inline]
    fn here(&self) -> Measured {
        let (current, value) = self.chain.current();
        current.measured(value)
    }

    /// Expected values (Veach 11.3.2): the state before gets 1 - a of this step, the candidate a.
    fn deposit(&mut self, acceptance: f64, accepted: bool, ledger: &mut Ledger) -> Outcome {
        let ((current, value), (other, other_value)) = (self.chain.current(), self.chain.other());
        let (here, there) = (current.measured(value), other.measured(other_value));
        let splats = &mut ledger.splats;
        self.pending += 1.0 - acceptance;
        if accepted {
            other.leave(other_value, self.pending, splats);
            self.pending = acceptance;
            self.trace.record(&there, self.class, self.stay + 1);
            if let Some(visits) = &mut ledger.visits {
                visits.stayed(there.raster, self.stay);
            }
            self.class = current.class();
            self.stay = 0;
        } else {
            self.stay += 1;
            if acceptance > 0.0 {
                other.leave(other_value, acceptance, splats);
            }
        }
        let jump = if acceptance > 0.0 { here.raster.distance(there.raster) } else { 0.0 };
        Outcome::Tried { acceptance, accepted, jump }
    }
}
