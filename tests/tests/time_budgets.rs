//! Budgets of time: kept by every method, and shared out among the parts of a render as the settings say.

use ergodic_pathspace::Scene;
use ergodic_render::{Budget, Method, Rendering, Settings, Unobserved, render};
use ergodic_tests::{description, view_of};

use crate::rendering::settings;

/// By how much a render may miss its budget, and a part of it its share: there is a last round of everything.
const TOLERANCE: f64 = 0.07;
const TOLERANCE_OF_SHARES: f64 = 0.2;

/// Other programs may disturb one render or another, but not all.
const TRIES: u64 = 8;

fn timed(scene: &Scene, method: Method, seconds: f64, seed: u64) -> (Rendering, Settings) {
    let mut settings =
        Settings { threads: 1, seed, budget: Budget::Seconds(seconds), ..settings(method, (64, 64), 0.0) };
    settings.mlt.chains = Settings::default().mlt.chains;
    // Seeding is to end by the clock.
    settings.mlt.seeding.relative_error = 1e-4;
    (render(scene, &settings, &Unobserved).expect("valid settings"), settings)
}

/// What was not as the budget says.
fn complaint(rendering: &Rendering, settings: &Settings) -> Option<String> {
    let Budget::Seconds(budget) = settings.budget else { return None };
    let over = |name: &str, seconds: f64, allowed: f64, tolerance: f64| {
        let missed = seconds / allowed - 1.0;
        (missed.abs() > tolerance).then(|| format!("{name}: {seconds:.4} s, {allowed:.4} s allowed"))
    };
    let whole = over("all", rendering.seconds, budget, TOLERANCE);
    whole.or_else(|| {
        let report = rendering.mlt.as_ref()?;
        let share = if settings.method == Method::Mlt { settings.mlt.share } else { settings.primary.share } * budget;
        let parts = [("seeding", report.seeding_seconds), ("direct light", report.direct_seconds)];
        parts.into_iter().find_map(|(name, seconds)| over(name, seconds, share, TOLERANCE_OF_SHARES))
    })
}

#[test]
fn every_method_keeps_a_budget_of_time_and_gives_each_part_its_share() {
    let scene = view_of(description("cornell"), (64, 64));
    for (method, name) in Method::ALL {
        let tried = |seconds, seed| {
            let (rendering, settings) = timed(&scene, method, seconds, seed);
            complaint(&rendering, &settings)
        };
        let complaints: Vec<String> = (1..=TRIES).map_while(|seed| tried(0.5, seed)).collect();
        assert!(complaints.len() < TRIES as usize, "{name}: {complaints:?}");
        // A budget that is too short for the least that is done cannot be kept, and it shows.
        assert!((1..=TRIES).all(|seed| tried(2e-4, seed).is_some()), "{name}");
    }
}
