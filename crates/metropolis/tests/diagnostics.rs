//! Diagnostics against series whose answers are known.

use ergodic_laws::generator;
use ergodic_metropolis::diagnostics::{
    BatchMeans, Moments, Runs, autocorrelation, r_hat, split_r_hat, time_between_chains,
};
use ergodic_metropolis::{RandomSource, Step};

fn normal(rng: &mut impl RandomSource) -> f64 {
    // Box and Muller; 1 - u is never 0.
    (-2.0 * (1.0 - rng.uniform()).ln()).sqrt() * (2.0 * std::f64::consts::PI * rng.uniform()).cos()
}

/// x' = ρ x + noise, started in its stationary distribution with variance 1. Its time is (1 + ρ) / (1 - ρ).
fn autoregressive(rho: f64, n: usize, seed: u64) -> Vec<f64> {
    let mut rng = generator(seed);
    let mut x = normal(&mut rng);
    (0..n)
        .map(|_| {
            x = rho * x + (1.0 - rho * rho).sqrt() * normal(&mut rng);
            x
        })
        .collect()
}

fn batches(series: &[f64], batches: usize) -> BatchMeans {
    let mut means = BatchMeans::new(batches);
    series.iter().for_each(|v| means.add(*v));
    means
}

#[test]
fn autocorrelation_times_of_autoregressive_series() {
    for rho in [0.9, 0.5, 0.0, -0.5, -0.9] {
        let expected = (1.0 + rho) / (1.0 - rho);
        let series = autoregressive(rho, 1_000_000, 1);
        let geyer = autocorrelation(&series).unwrap();
        let batch = batches(&series, 1024).autocorrelation_time().unwrap();
        println!("rho {rho}: expected {expected:.3}, Geyer {:.3}, batches {batch:.3}", geyer.time);
        // The sum over lags starts from 1: below that its error is no longer relative.
        assert!((geyer.time - expected).abs() < 0.05 * expected.max(1.0), "{geyer:?}");
        assert!((batch / expected - 1.0).abs() < 0.1, "{batch}");
        assert!((geyer.effective_sample_size * geyer.time / 1e6 - 1.0).abs() < 1e-12);
    }
}

/// Chains that are hardly longer than what they remember: their means tell it, batches within each cannot.
#[test]
fn many_short_chains_tell_a_time_that_batches_within_them_do_not() {
    let (rho, n) = (0.9_f64, 200);
    let chains: Vec<Vec<f64>> = (0..1000).map(|seed| autoregressive(rho, n, 5000 + seed)).collect();
    let parts: Vec<Moments> = chains.iter().map(|chain| chain.iter().copied().collect()).collect();
    // n Var(mean of n terms), exactly.
    let steps = n as f64;
    let expected =
        (1.0 + rho) / (1.0 - rho) - 2.0 * rho * (1.0 - rho.powf(steps)) / (steps * (1.0 - rho) * (1.0 - rho));
    let found = time_between_chains(&parts).unwrap();
    let by_batches: Moments = chains.iter().filter_map(|chain| batches(chain, 32).autocorrelation_time()).collect();
    println!("expected {expected:.2}, between chains {found:.2}, batches {:.2}", by_batches.mean());
    assert!((found / expected - 1.0).abs() < 0.2, "{found}");
    assert!(by_batches.mean() < 0.5 * expected, "{by_batches:?}");
    // Chains that never move remember everything.
    let still: Vec<Moments> = (0..100).map(|i| std::iter::repeat_n(f64::from(i), n).collect()).collect();
    assert!((time_between_chains(&still).unwrap() / steps - 1.0).abs() < 1e-12);
    assert_eq!(time_between_chains(&parts[..1]), None);
}

/// What the standard error is for: it says how far the mean is off. With the one for independent terms it would not.
#[test]
fn standard_errors_hold_over_replicates() {
    let (mut honest, mut naive) = (Moments::new(), Moments::new());
    for seed in 0..400 {
        let means = batches(&autoregressive(0.9, 20_000, 1000 + seed), 64);
        let mean = means.terms().mean();
        honest.add((mean / means.standard_error().unwrap()).powi(2));
        naive.add((mean / means.terms().standard_error()).powi(2));
    }
    println!("mean square of mean / error: batches {:.2}, independent {:.2}", honest.mean(), naive.mean());
    assert!((0.8..1.35).contains(&honest.mean()), "{honest:?}");
    assert!(naive.mean() > 10.0, "{naive:?}");
}

#[test]
fn batches_grow_and_stay_few() {
    let series: Vec<f64> = autoregressive(0.3, 100_000, 2);
    let mut means = BatchMeans::new(16);
    assert_eq!(means.autocorrelation_time(), None);
    for (i, value) in series.iter().enumerate() {
        means.add(*value);
        let whole = (i as u64 + 1) / means.batch_length();
        assert!(whole < 32, "{whole}");
    }
    assert!(means.batch_length() >= 100_000 / 32);
    let direct: Moments = series.iter().copied().collect();
    let terms = means.terms();
    assert_eq!(terms.count(), direct.count());
    assert!((terms.mean() - direct.mean()).abs() < 1e-12);
    assert!((terms.variance() / direct.variance() - 1.0).abs() < 1e-12);
}

#[test]
fn series_without_an_answer_give_none() {
    assert_eq!(autocorrelation(&[]), None);
    assert_eq!(autocorrelation(&[0.1; 1000]), None);
    assert_eq!(autocorrelation(&[1.0, f64::NAN, 2.0]), None);
    // Far shorter than 50 times its autocorrelation time of 2000.
    assert_eq!(autocorrelation(&autoregressive(0.999, 5_000, 3)), None);
    assert_eq!(batches(&[0.5; 1000], 8).autocorrelation_time(), None);
    assert_eq!(split_r_hat(&[]), None);
    assert_eq!(split_r_hat(&[&[1.0, 2.0, 3.0]]), None);
    assert_eq!(split_r_hat(&[&[1.0; 50], &[1.0; 50]]), None);
}

#[test]
fn r_hat_tells_one_story_from_two() {
    let independent: Vec<Vec<f64>> = (0..4).map(|seed| autoregressive(0.0, 10_000, seed)).collect();
    let chains: Vec<&[f64]> = independent.iter().map(Vec::as_slice).collect();
    let one = split_r_hat(&chains).unwrap();
    assert!(one < 1.01, "{one}");

    // Two modes, six standard deviations apart, that no chain leaves.
    let modes: Vec<Vec<f64>> = (0..4)
        .map(|seed| independent[seed].iter().map(|v| v + if seed % 2 == 0 { 3.0 } else { -3.0 }).collect())
        .collect();
    let chains: Vec<&[f64]> = modes.iter().map(Vec::as_slice).collect();
    let two = split_r_hat(&chains).unwrap();
    assert!(two > 1.1, "{two}");

    // A drift that all chains share: only the halves show it.
    let drifting: Vec<Vec<f64>> =
        independent.iter().map(|chain| chain.iter().enumerate().map(|(i, v)| v + i as f64 * 2e-4).collect()).collect();
    let chains: Vec<&[f64]> = drifting.iter().map(Vec::as_slice).collect();
    let whole: Vec<Moments> = drifting.iter().map(|chain| chain.iter().copied().collect()).collect();
    assert!(split_r_hat(&chains).unwrap() > 1.1);
    assert!(r_hat(&whole).unwrap() < 1.01);
}

#[test]
fn runs_of_rejections_of_every_kind() {
    let moved: Step<(), ()> = Step::Tried { plan: (), acceptance: 0.5, accepted: true };
    let rejected = Step::Tried { plan: (), acceptance: 0.5, accepted: false };
    let failed = Step::NotProposed(());
    let mut runs = Runs::new();
    for step in [rejected, moved, rejected, failed, rejected, moved, failed] {
        runs.add(&step);
    }
    assert_eq!((runs.steps(), runs.accepted(), runs.longest(), runs.current()), (7, 2, 3, 1));
    let mut both = Runs::new();
    both.merge(&runs);
    assert_eq!((both.steps(), both.longest()), (7, 3));
}
