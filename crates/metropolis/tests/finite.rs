//! Finite chains: exact answers, and the acceptance rule of the chain written down as a matrix.

use ergodic_laws::faults::{Forgetful, Scaled};
use ergodic_laws::{chi_square, generator};
use ergodic_metropolis::diagnostics::autocorrelation;
use ergodic_metropolis::finite::{FiniteError, FiniteProposal, FiniteTarget, TransitionMatrix};
use ergodic_metropolis::{Chain, Mixture, Mutation, RandomSource, Target};

fn matrix(rows: &[&[f64]]) -> TransitionMatrix {
    TransitionMatrix::from_rows(rows.iter().map(|row| row.to_vec()).collect()).expect("the rows sum to 1")
}

/// The example of the lectures. It has a stationary distribution without being reversible.
fn lecture() -> TransitionMatrix {
    matrix(&[&[0.1, 0.3, 0.6], &[0.4, 0.4, 0.2], &[0.1, 0.7, 0.2]])
}

/// A dense random matrix, rows summing to 1.
fn random_matrix(n: usize, rng: &mut impl RandomSource) -> TransitionMatrix {
    let row = |rng: &mut _| {
        let row: Vec<f64> = (0..n).map(|_| 0.01 + RandomSource::uniform(rng)).collect();
        let sum: f64 = row.iter().sum();
        row.iter().map(|v| v / sum).collect()
    };
    TransitionMatrix::from_rows((0..n).map(|_| row(rng)).collect()).expect("the rows were normalised")
}

#[test]
fn the_lecture_matrix_converges_but_is_not_reversible() {
    let matrix = lecture();
    let stationary = matrix.stationary_distribution().unwrap();
    let by_hand = [17.0 / 71.0, 33.0 / 71.0, 21.0 / 71.0];
    assert!(stationary.iter().zip(by_hand).all(|(a, b)| (a - b).abs() < 1e-15), "{stationary:?}");
    assert!(matrix.stationarity_residual(&stationary).unwrap() < 1e-15);
    for start in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] {
        let late = matrix.distribution_after(&start, 60).unwrap();
        assert!(late.iter().zip(&stationary).all(|(a, b)| (a - b).abs() < 1e-12));
    }
    assert!(matrix.is_ergodic());
    assert!(matrix.detailed_balance_residual(&stationary).unwrap().0 > 0.01);
    assert!(matches!(matrix.reversible_spectrum(), Err(FiniteError::NotReversible { .. })));
}

#[test]
fn stationary_distributions_keep_tiny_entries() {
    // A birth-death chain: by detailed balance entry k is (up / down)^k times the first.
    let (n, up, down) = (40, 1e-3, 0.5);
    let rows = (0..n)
        .map(|i| {
            let mut row = vec![0.0; n];
            if i + 1 < n {
                row[i + 1] = up;
            }
            if i > 0 {
                row[i - 1] = down;
            }
            row[i] = 1.0 - row.iter().sum::<f64>();
            row
        })
        .collect();
    let stationary = TransitionMatrix::from_rows(rows).unwrap().stationary_distribution().unwrap();
    for (k, p) in stationary.iter().enumerate() {
        let expected = stationary[0] * (up / down).powi(k as i32);
        assert!((p / expected - 1.0).abs() < 1e-12, "{k}: {p:e} {expected:e}");
    }
}

#[test]
fn structure_is_recognised() {
    let cycle = matrix(&[&[0.0, 1.0, 0.0], &[0.0, 0.0, 1.0], &[1.0, 0.0, 0.0]]);
    assert_eq!(cycle.period(), Ok(3));
    assert!(cycle.is_irreducible() && !cycle.is_ergodic());
    assert!(cycle.stationary_distribution().unwrap().iter().all(|p| (p - 1.0 / 3.0).abs() < 1e-15));
    let bipartite =
        matrix(&[&[0.0, 0.5, 0.5, 0.0], &[0.5, 0.0, 0.0, 0.5], &[0.5, 0.0, 0.0, 0.5], &[0.0, 0.5, 0.5, 0.0]]);
    assert_eq!(bipartite.period(), Ok(2));
    assert_eq!(matrix(&[&[1.0]]).period(), Ok(1));
    assert_eq!(matrix(&[&[1.0]]).stationary_distribution(), Ok(vec![1.0]));

    let trap = matrix(&[&[0.5, 0.5], &[0.0, 1.0]]);
    assert_eq!(trap.stationary_distribution(), Err(FiniteError::Reducible { from: 1, to: 0 }));
    let island = matrix(&[&[1.0, 0.0], &[0.5, 0.5]]);
    assert_eq!(island.period(), Err(FiniteError::Reducible { from: 0, to: 1 }));
}

#[test]
fn wrong_matrices_are_named_by_row_and_column() {
    let error = |rows: Vec<Vec<f64>>| TransitionMatrix::from_rows(rows).unwrap_err();
    assert_eq!(error(vec![]), FiniteError::Empty);
    assert_eq!(error(vec![vec![1.0], vec![0.0, 1.0]]), FiniteError::NotSquare { row: 0, length: 1, states: 2 });
    assert_eq!(error(vec![vec![1.0, 0.0], vec![1.5, -0.5]]), FiniteError::Entry { row: 1, column: 0, value: 1.5 });
    assert!(matches!(error(vec![vec![f64::NAN]]), FiniteError::Entry { .. }));
    assert!(matches!(error(vec![vec![0.5, 0.4], vec![0.5, 0.5]]), FiniteError::RowSum { row: 0, .. }));
    let text = ron::from_str::<TransitionMatrix>("[[0.5, 0.5], [0.25, 0.5]]").unwrap_err().to_string();
    assert!(text.contains("row 1 sums to 0.75; divide its entries by that"), "{text}");
    let read: TransitionMatrix = ron::from_str("[[0.5, 0.5], [0.25, 0.75]]").unwrap();
    assert_eq!(ron::to_string(&read).unwrap(), "[[0.5,0.5],[0.25,0.75]]");

    let hastings = |target: &[f64]| TransitionMatrix::from_metropolis_hastings(&lecture(), target).unwrap_err();
    assert_eq!(hastings(&[1.0]), FiniteError::Length { length: 1, states: 3 });
    assert_eq!(hastings(&[1.0, -1.0, 1.0]), FiniteError::Weight { state: 1, value: -1.0 });
    assert_eq!(hastings(&[0.0; 3]), FiniteError::NoWeight);
    assert_eq!(lecture().distribution_after(&[1.0], 1), Err(FiniteError::Length { length: 1, states: 3 }));
}

#[test]
fn steps_are_taken_by_the_rows() {
    let matrix = lecture();
    let mut rng = generator(1);
    for state in 0..3 {
        let mut counts = [0u64; 3];
        (0..100_000).for_each(|_| counts[matrix.step(state, &mut rng)] += 1);
        let expected: Vec<f64> = matrix.row(state).iter().map(|p| p * 1e5).collect();
        assert!(chi_square(&counts, &expected, 5.0).unwrap().p_value > 1e-4, "{counts:?}");
    }
}

#[test]
fn spectra_by_hand_and_by_residual() {
    // Eigenvalues of a two-state chain are 1 and 1 - p - q.
    let two = matrix(&[&[0.7, 0.3], &[0.1, 0.9]]).reversible_spectrum().unwrap();
    assert!((two.values[0] - 1.0).abs() < 1e-14 && (two.values[1] - 0.6).abs() < 1e-14, "{two:?}");
    assert!((two.autocorrelation_time(1) - 4.0).abs() < 1e-12);
    // The walk on a ring of n: cos(2 π k / n), and the period shows as -1.
    let n = 12;
    let ring = (0..n).map(|i| (0..n).map(|j| if (i + 1) % n == j || (j + 1) % n == i { 0.5 } else { 0.0 }).collect());
    let ring = TransitionMatrix::from_rows(ring.collect()).unwrap().reversible_spectrum().unwrap();
    let mut cosines: Vec<f64> = (0..n).map(|k| (2.0 * std::f64::consts::PI * k as f64 / n as f64).cos()).collect();
    cosines.sort_by(|a, b| b.total_cmp(a));
    assert!(ring.values.iter().zip(&cosines).all(|(a, b)| (a - b).abs() < 1e-13), "{:?}", ring.values);
    assert!((ring.second_modulus() - 1.0).abs() < 1e-13);

    let mut rng = generator(2);
    let proposal = random_matrix(30, &mut rng);
    let target: Vec<f64> = (0..30).map(|_| rng.uniform() + 0.01).collect();
    let chain = TransitionMatrix::from_metropolis_hastings(&proposal, &target).unwrap();
    let (spectrum, stationary) = (chain.reversible_spectrum().unwrap(), chain.stationary_distribution().unwrap());
    for (value, function) in spectrum.values.iter().zip(&spectrum.functions) {
        for state in 0..30 {
            let applied: f64 = chain.row(state).iter().zip(function).map(|(p, v)| p * v).sum();
            assert!((applied - value * function[state]).abs() < 1e-11);
        }
        let square: f64 = stationary.iter().zip(function).map(|(p, v)| p * v * v).sum();
        assert!((square - 1.0).abs() < 1e-11);
    }
}

#[test]
fn metropolis_hastings_makes_any_target_stationary() {
    let mut rng = generator(3);
    for n in [2, 5, 20] {
        let proposal = random_matrix(n, &mut rng);
        let mut target: Vec<f64> = (0..n).map(|_| rng.uniform()).collect();
        let total: f64 = target.iter().sum();
        target.iter_mut().for_each(|p| *p /= total);
        let chain = TransitionMatrix::from_metropolis_hastings(&proposal, &target).unwrap();
        assert!(chain.row_sums().iter().all(|sum| (sum - 1.0).abs() < 1e-12));
        assert!(chain.detailed_balance_residual(&target).unwrap().0 < 1e-15);
        let solved = chain.stationary_distribution().unwrap();
        assert!(solved.iter().zip(&target).all(|(a, b)| (a - b).abs() < 1e-13));
    }
}

// ---------------------------------------------------------------------------------------------------------------------
// Words of 1 to 3 letters out of 4, under a mixture of two kernels: a path space small enough to write down.

const LETTERS: u8 = 4;
const LONGEST: usize = 3;

type Word = Vec<u8>;

/// Letters that survive at each end.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Splice {
    prefix: usize,
    suffix: usize,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct OffTheAlphabet;

#[derive(Clone, Debug)]
enum Spelling {
    /// Cut out a range of letters and put in others, each beside the letter before or after it.
    Rewrite,
    /// The next letter up or down in one place.
    Nudge,
}

struct Likes;

impl Target for Likes {
    type State = Word;
    type Value = f64;

    fn evaluate(&self, x: &Word) -> f64 {
        x.iter().map(|letter| (0.4 * (1.0 + f64::from(*letter))).ln()).sum()
    }

    fn ln_density(value: &f64) -> f64 {
        *value
    }
}

/// (prefix, cut, put) for each word length.
fn edits(length: usize) -> Vec<(usize, usize, usize)> {
    let all = (0..=length)
        .flat_map(|cut| (0..=length - cut).flat_map(move |prefix| (0..=LONGEST).map(move |put| (prefix, cut, put))));
    all.filter(|(_, cut, put)| (1..=LONGEST).contains(&(length - cut + put)) && (*cut, *put) != (0, 0)).collect()
}

/// The same letter is twice as likely as each other.
fn beside(a: u8, b: u8) -> f64 {
    if a == b { 2.0 / 5.0 } else { 1.0 / 5.0 }
}

fn draw_beside(a: u8, rng: &mut impl RandomSource) -> u8 {
    let index = rng.below(usize::from(LETTERS) + 1) as u8;
    if index == LETTERS { a } else { index }
}

fn spell(start: u8, letters: impl Iterator<Item = u8>) -> f64 {
    let mut before = start;
    let mut probability = 1.0;
    for letter in letters {
        probability *= beside(before, letter);
        before = letter;
    }
    probability
}

impl Mutation for Spelling {
    type Space = Vec<Vec<(usize, usize, usize)>>;
    type State = Word;
    type Plan = Splice;
    type Failure = OffTheAlphabet;

    fn suitability(&self, _: &Self::Space, x: &Word) -> f64 {
        match self {
            Self::Rewrite => 1.0,
            Self::Nudge => {
                if x.len() >= 2 {
                    3.0
                } else {
                    0.0
                }
            }
        }
    }

    fn propose(
        &self,
        edits: &Self::Space,
        x: &Word,
        y: &mut Word,
        rng: &mut impl RandomSource,
    ) -> Result<Splice, OffTheAlphabet> {
        match self {
            Self::Rewrite => {
                let (prefix, cut, put) = edits[x.len()][rng.below(edits[x.len()].len())];
                let split = rng.below(put + 1);
                let kept = &x[prefix + cut..];
                y.clear();
                y.extend_from_slice(&x[..prefix]);
                y.resize(prefix + put, 0);
                y.extend_from_slice(kept);
                let mut before = if prefix > 0 { x[prefix - 1] } else { 0 };
                for letter in &mut y[prefix..prefix + split] {
                    before = draw_beside(before, rng);
                    *letter = before;
                }
                let mut before = kept.first().copied().unwrap_or(0);
                for letter in y[prefix + split..prefix + put].iter_mut().rev() {
                    before = draw_beside(before, rng);
                    *letter = before;
                }
                Ok(Splice { prefix, suffix: kept.len() })
            }
            Self::Nudge => {
                let place = rng.below(x.len());
                y.clone_from(x);
                y[place] = if rng.uniform() < 0.5 { x[place].wrapping_sub(1) } else { x[place] + 1 };
                if y[place] < LETTERS {
                    Ok(Splice { prefix: place, suffix: x.len() - place - 1 })
                } else {
                    Err(OffTheAlphabet)
                }
            }
        }
    }

    fn ln_density(&self, edits: &Self::Space, from: &Word, to: &Word, Splice { prefix, suffix }: Splice) -> f64 {
        let (old, new) = (&from[prefix..from.len() - suffix], &to[prefix..to.len() - suffix]);
        match self {
            Self::Rewrite => {
                if (old.len(), new.len()) == (0, 0) {
                    return f64::NEG_INFINITY;
                }
                let left = if prefix > 0 { to[prefix - 1] } else { 0 };
                let right = if suffix > 0 { to[to.len() - suffix] } else { 0 };
                let sum: f64 = (0..=new.len())
                    .map(|split| {
                        spell(left, new[..split].iter().copied()) * spell(right, new[split..].iter().rev().copied())
                    })
                    .sum();
                (sum / (new.len() + 1) as f64 / edits[from.len()].len() as f64).ln()
            }
            Self::Nudge => match (old, new) {
                ([a], [b]) if a.abs_diff(*b) == 1 => -(2.0 * from.len() as f64).ln(),
                _ => f64::NEG_INFINITY,
            },
        }
    }
}

fn all_words() -> Vec<Word> {
    let mut words: Vec<Word> = vec![vec![]];
    let mut first = 0;
    for _ in 0..LONGEST {
        let last = words.len();
        for i in first..last {
            for letter in 0..LETTERS {
                let mut word = words[i].clone();
                word.push(letter);
                words.push(word);
            }
        }
        first = last;
    }
    words.split_off(1)
}

/// All plans that keep only what the two words have in common, for both kernels.
fn plans(x: &Word, y: &Word) -> Vec<(usize, Splice)> {
    let shorter = x.len().min(y.len());
    let mut plans = vec![];
    for prefix in (0..=shorter).take_while(|n| x[..*n] == y[..*n]) {
        for suffix in (0..=shorter - prefix).take_while(|n| x[x.len() - n..] == y[y.len() - n..]) {
            plans.extend([0, 1].map(|member| (member, Splice { prefix, suffix })));
        }
    }
    plans
}

fn spellings() -> Mixture<Spelling> {
    Mixture::new(vec![(1.0, Spelling::Rewrite), (0.7, Spelling::Nudge)]).expect("the weights are positive")
}

fn space() -> Vec<Vec<(usize, usize, usize)>> {
    (0..=LONGEST).map(edits).collect()
}

fn written_down<M>(kernel: &M) -> Result<TransitionMatrix, FiniteError>
where
    M: Mutation<State = Word, Space = Vec<Vec<(usize, usize, usize)>>, Plan = (usize, Splice)>,
{
    TransitionMatrix::enumerate(&Likes, kernel, &space(), &all_words(), plans)
}

fn normalised_target() -> Vec<f64> {
    let weights: Vec<f64> = all_words().iter().map(|word| Likes.evaluate(word).exp()).collect();
    let total: f64 = weights.iter().sum();
    weights.iter().map(|w| w / total).collect()
}

/// All that the densities say is proposed, with all that fails, makes up 1: the densities are those of the sampler in
/// total, state by state.
#[test]
fn enumerated_densities_and_failures_sum_to_one() {
    let (kernel, space, words) = (spellings(), space(), all_words());
    assert_eq!(words.len(), 84);
    for x in &words {
        let proposed: f64 = words
            .iter()
            .flat_map(|y| plans(x, y).into_iter().map(move |plan| (y, plan)))
            .map(|(y, plan)| kernel.ln_density(&space, x, y, plan).exp())
            .sum();
        let edges = x.iter().filter(|l| **l == 0).count() + x.iter().filter(|l| **l == LETTERS - 1).count();
        let failed = kernel.probability(1, &space, x) * edges as f64 / (2 * x.len()) as f64;
        assert!((proposed + failed - 1.0).abs() < 1e-12, "{x:?}: {proposed} + {failed}");
    }
}

#[test]
fn the_chain_written_down_is_reversible_to_rounding() {
    let (chain, target) = (written_down(&spellings()).unwrap(), normalised_target());
    assert!(chain.row_sums().iter().all(|sum| (sum - 1.0).abs() <= 1e-12));
    assert!(chain.detailed_balance_residual(&target).unwrap().0 <= 1e-12);
    assert!(chain.stationarity_residual(&target).unwrap() <= 1e-12);
    assert!(chain.is_ergodic());
    let solved = chain.stationary_distribution().unwrap();
    assert!(solved.iter().zip(&target).all(|(a, b)| (a / b - 1.0).abs() < 1e-11));
}

/// The residuals can fail: the chain that a faulty kernel *makes* is its true proposals with the wrong acceptance.
#[test]
fn a_faulty_kernel_is_not_reversible() {
    let (right, space, words, target) = (spellings(), space(), all_words(), normalised_target());
    let forgetful = Forgetful(right.clone());
    let values: Vec<f64> = words.iter().map(|word| Likes.evaluate(word)).collect();
    let mut rows = vec![];
    for (i, x) in words.iter().enumerate() {
        let mut row = vec![0.0; words.len()];
        for (j, y) in words.iter().enumerate() {
            for plan in plans(x, y) {
                let density = right.ln_density(&space, x, y, plan).exp();
                if i != j && density > 0.0 {
                    let (there, here) = ((x, &values[i]), (y, &values[j]));
                    let a = ergodic_metropolis::acceptance::<Likes, _>(&forgetful, &space, there, here, plan).unwrap();
                    row[j] += density * a;
                }
            }
        }
        row[i] = 1.0 - row.iter().sum::<f64>();
        rows.push(row);
    }
    let chain = TransitionMatrix::from_rows(rows).unwrap();
    assert!(chain.detailed_balance_residual(&target).unwrap().0 > 1e-4);
    assert!(chain.stationarity_residual(&target).unwrap() > 1e-3);
}

#[test]
fn densities_that_are_too_large_are_refused() {
    let doubled = Scaled { mutation: spellings(), factor: |_: &Word, _: &Word, _| 2.0 };
    let error = written_down(&doubled).unwrap_err();
    assert!(matches!(error, FiniteError::RowSum { row: 0, sum } if (sum - 2.0).abs() < 1e-12), "{error}");
    let not_a_number = Scaled { mutation: spellings(), factor: |_: &Word, _: &Word, _| f64::NAN };
    assert_eq!(written_down(&not_a_number).unwrap_err(), FiniteError::Faulty { from: 0, to: 0 });
}

/// Runs the real chain and compares with what the matrix says: time in each state, and how long the slowest function of
/// the state is remembered.
#[test]
fn the_chain_that_runs_is_the_chain_written_down() {
    let (words, space, kernel, target) = (all_words(), space(), spellings(), normalised_target());
    let spectrum = written_down(&kernel).unwrap().reversible_spectrum().unwrap();
    let expected = spectrum.autocorrelation_time(1);
    let slowest = &spectrum.functions[1];
    // Words of n letters come after all shorter ones, in the order of numbers in base LETTERS.
    let index = |word: &Word| word.iter().fold(0, |i, letter| i * usize::from(LETTERS) + usize::from(*letter) + 1) - 1;
    assert!(words.iter().enumerate().all(|(i, word)| index(word) == i));

    let (mut chain, mut rng) = (Chain::new(words[0].clone(), &Likes), generator(4));
    let n = 5_000_000;
    let mut visits = vec![0u64; words.len()];
    let series: Vec<f64> = (0..n)
        .map(|_| {
            chain.step(&Likes, &kernel, &space, &mut rng);
            let state = index(chain.current().0);
            visits[state] += 1;
            slowest[state]
        })
        .collect();
    let measured = autocorrelation(&series).unwrap();
    println!("second eigenvalue {:.4}, time {expected:.3}, measured {:.3}", spectrum.values[1], measured.time);
    assert!((measured.time / expected - 1.0).abs() < 0.1, "{measured:?}, expected {expected}");
    for (visits, p) in visits.iter().zip(&target) {
        // No function of the state is remembered longer than the slowest one.
        let limit = 5.0 * (p * (1.0 - p) * expected / f64::from(n)).sqrt();
        assert!((*visits as f64 / f64::from(n) - p).abs() < limit);
    }
}

/// The same through the matrix kernel: a finite chain run by `Chain` and by the rows of the matrix itself.
#[test]
fn a_finite_proposal_runs_in_the_same_chain() {
    let proposal = matrix(&[&[0.2, 0.8, 0.0], &[0.5, 0.0, 0.5], &[0.1, 0.6, 0.3]]);
    let weights = vec![1.0, 2.0, 4.0];
    let exact = TransitionMatrix::from_metropolis_hastings(&proposal, &weights).unwrap();
    let (kernel, target) = (FiniteProposal::new(proposal), FiniteTarget::new(weights).unwrap());
    for start in 0..3 {
        let (mut by_chain, mut by_matrix) = ([0u64; 3], [0u64; 3]);
        let mut rng = generator(5 + start as u64);
        for _ in 0..200_000 {
            let mut chain = Chain::new(start, &target);
            chain.step(&target, &kernel, &(), &mut rng);
            by_chain[*chain.current().0] += 1;
            by_matrix[exact.step(start, &mut rng)] += 1;
        }
        let expected: Vec<f64> = exact.row(start).iter().map(|p| p * 2e5).collect();
        for counts in [by_chain, by_matrix] {
            assert!(chi_square(&counts, &expected, 5.0).unwrap().p_value > 1e-4, "{start}: {counts:?}");
        }
    }
}
