//! Three states: a chain forgets where it started, with and without detailed balance.
//!
//! `cargo run --release -p ergodic-metropolis --example three_states`

use ergodic_metropolis::diagnostics::autocorrelation;
use ergodic_metropolis::finite::{FiniteError, FiniteProposal, FiniteTarget, TransitionMatrix};
use ergodic_metropolis::{Chain, Step};
use rand_pcg::Pcg64;

fn main() -> Result<(), FiniteError> {
    let chain = TransitionMatrix::from_rows(vec![vec![0.1, 0.3, 0.6], vec![0.4, 0.4, 0.2], vec![0.1, 0.7, 0.2]])?;
    println!("A Markov chain on three states. Row i holds the probabilities of going from i.\n");
    print_matrix(&chain);

    let stationary = chain.stationary_distribution()?;
    println!("\nIt is irreducible with period {}, so it converges from every start to the one", chain.period()?);
    println!("distribution π = π P:\n");
    println!("    π = {}\n", row(&stationary));
    convergence(&chain, &stationary)?;

    let (residual, i, j) = chain.detailed_balance_residual(&stationary)?;
    println!("\nIs it reversible? Detailed balance asks π_i P_ij = π_j P_ji for every pair. Here");
    println!(
        "    π_{i} P_{i}{j} = {:.6}  but  π_{j} P_{j}{i} = {:.6}",
        flow(&chain, &stationary, i, j),
        flow(&chain, &stationary, j, i)
    );
    println!("    largest difference {residual:.6}");
    println!("No: probability runs round in a circle and is stationary all the same. Detailed balance is");
    println!("enough for a stationary distribution; it is not necessary.");

    // The other way round: the distribution is given, the chain is built for it.
    let proposal = TransitionMatrix::from_rows(vec![vec![1.0 / 3.0; 3]; 3])?;
    let hastings = TransitionMatrix::from_metropolis_hastings(&proposal, &stationary)?;
    println!("\n\nMetropolis-Hastings builds a chain *for* the same π: propose one of the three states");
    println!("blindly, accept with probability min(1, π_j / π_i), stay where you are otherwise.\n");
    print_matrix(&hastings);
    let spectrum = hastings.reversible_spectrum()?;
    println!("\n    π = {}", row(&hastings.stationary_distribution()?));
    println!(
        "    largest |π_i P_ij - π_j P_ji| = {:.1e}: reversible\n",
        hastings.detailed_balance_residual(&stationary)?.0
    );
    convergence(&hastings, &stationary)?;
    println!(
        "\nEigenvalues {}: the distance shrinks by {:.4} a step.",
        row(&spectrum.values),
        spectrum.second_modulus()
    );

    simulate(&proposal, &stationary, &spectrum.functions[1], spectrum.autocorrelation_time(1))
}

/// Distance to `stationary` from each certain start, and from the even one, as steps are taken.
fn convergence(chain: &TransitionMatrix, stationary: &[f64]) -> Result<(), FiniteError> {
    let starts = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0 / 3.0; 3]];
    println!("    steps   from state 0                  distance from π, started in");
    println!("            p_0      p_1      p_2         0         1         2         anywhere");
    for steps in [0, 1, 2, 3, 4, 6, 8, 12, 16, 24] {
        print!("    {steps:>5}   {}", row(&chain.distribution_after(&starts[0], steps)?));
        for start in &starts {
            print!("  {:.2e}", total_variation(&chain.distribution_after(start, steps)?, stationary));
        }
        println!();
    }
    Ok(())
}

/// Runs the chain itself, by the kernel and the acceptance rule that every other chain of this crate uses.
fn simulate(
    proposal: &TransitionMatrix,
    stationary: &[f64],
    slowest: &[f64],
    expected_time: f64,
) -> Result<(), FiniteError> {
    let kernel = FiniteProposal::new(proposal.clone());
    // Any multiple will do: the chain never needs to know the constant.
    let target = FiniteTarget::new(stationary.iter().map(|p| 1000.0 * p).collect())?;
    let mut rng = Pcg64::new(2024, 1);
    let mut chain = Chain::new(0, &target);
    let (mut visits, mut accepted, mut series) = ([0u32; 3], 0u32, Vec::new());
    println!("\nThe same chain, run:\n");
    println!("       steps   share of the time in 0, 1, 2   distance from π   accepted");
    for step in 1..=1_000_000u32 {
        if let Step::Tried { accepted: true, .. } = chain.step(&target, &kernel, &(), &mut rng) {
            accepted += 1;
        }
        let state = *chain.current().0;
        visits[state] += 1;
        series.push(slowest[state]);
        if step.ilog10() != (step - 1).max(1).ilog10() {
            let shares = visits.map(|v| f64::from(v) / f64::from(step));
            let rate = f64::from(accepted) / f64::from(step);
            println!(
                "    {step:>8}   {}     {:.2e}          {rate:.3}",
                row(&shares),
                total_variation(&shares, stationary)
            );
        }
    }
    if let Some(measured) = autocorrelation(&series) {
        println!("\nAutocorrelation time of the slowest observable: {:.3} steps measured,", measured.time);
        println!("(1 + λ) / (1 - λ) = {expected_time:.3} by its eigenvalue.");
    }
    Ok(())
}

fn flow(chain: &TransitionMatrix, distribution: &[f64], from: usize, to: usize) -> f64 {
    distribution[from] * chain.row(from)[to]
}

/// Half the sum of differences: the largest error of the probability of any set of states.
fn total_variation(a: &[f64], b: &[f64]) -> f64 {
    0.5 * a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f64>()
}

fn row(values: &[f64]) -> String {
    values.iter().map(|v| format!("{v:.5}")).collect::<Vec<_>>().join("  ")
}

fn print_matrix(matrix: &TransitionMatrix) {
    for state in 0..matrix.states() {
        println!("    {}", row(matrix.row(state)));
    }
}
