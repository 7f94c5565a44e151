//! `ergodic verify`: whether this build still makes the stored references.

use std::path::{Path, PathBuf};

use ergodic_assess::{Exposure, Image, Reference, ReplicaTest, Verdict, test_replicas, write_png};
use ergodic_assets::load;
use ergodic_mutations::AnyMutation;
use ergodic_pathspace::Scene;
use ergodic_render::{Budget, Direct, Life, Method, Settings, render_replicas};
use ergodic_scattering::{Environment, Medium};

use crate::environment;
use crate::error::CliError;
use crate::options::{Effort, VerifyOptions};
use crate::output;
use crate::progress::{Progress, human_time};
use crate::{table, terminal};

/// How often a right build may fail: once in 200 runs, all tests of a run together.
const FAMILY_ALPHA: f64 = 0.005;

/// A case that does not hold is rendered again with other seeds and this many times the samples, and only if it fails again it fails:
/// where a block holds light that is found once in a hundred thousand samples, a first look finds none of it, and the spread of
/// what it does find says nothing of that. A fault is seen all the better by the second look.
const SECOND_LOOK: f64 = 8.0;

/// When chains begin anew. Not as soon as the seeds would allow: what a mutation does wrong adds up, and a picture by short lives is
/// one of their starts.
const LIFE: Life = Life::Mutations(4096);

/// Weight of the bidirectional mutation beside another that is tested alone.
const A_LITTLE: f64 = 0.5;

/// One line of the table: a method, and for Metropolis light transport a mix of mutations.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// The method.
    pub method: Method,
    /// Name of the mix; empty for other methods.
    pub mix: String,
    mutations: Vec<(f64, AnyMutation)>,
}

impl Case {
    /// Whether the mutation that the mix is named for can change any path of the scene.
    fn applies(&self, scene: &Scene) -> bool {
        let named = self.mutations.iter().find(|(_, mutation)| mutation.name() == self.mix);
        named.is_none_or(|(_, mutation)| mutation.never_applies(scene.effects()).is_none())
    }
}

/// All cases: the methods, the full mix, and every mutation with a little of one that reaches every path.
pub fn cases() -> Vec<Case> {
    let plain = |method| Case { method, mix: String::new(), mutations: Settings::default().mlt.mutations };
    let mut cases = vec![plain(Method::Path), plain(Method::Bidirectional)];
    cases.extend([plain(Method::Pssmlt), plain(Method::Mmlt)]);
    let mix = |name: &str, mutations| Case { method: Method::Mlt, mix: name.into(), mutations };
    cases.push(mix("full", AnyMutation::all().into_iter().map(|mutation| (1.0, mutation)).collect()));
    for mutation in AnyMutation::all() {
        let mut mutations = vec![(1.0, mutation)];
        if !mutation.is_ergodic() {
            mutations.extend(AnyMutation::all().into_iter().filter(AnyMutation::is_ergodic).map(|m| (A_LITTLE, m)));
        }
        cases.push(mix(mutation.name(), mutations));
    }
    cases
}

/// Replicas of one case, and how much goes into each.
#[derive(Clone, Copy, Debug)]
struct Work {
    replicas: usize,
    path: f64,
    bidirectional: f64,
    mlt: f64,
    seeding: u64,
}

impl Effort {
    fn work(self) -> Work {
        match self {
            Self::Quick => Work { replicas: 32, path: 12.0, bidirectional: 6.0, mlt: 32.0, seeding: 16_384 },
            Self::Full => Work { replicas: 48, path: 128.0, bidirectional: 64.0, mlt: 512.0, seeding: 131_072 },
        }
    }
}

/// Settings of the first look at a case, or of the second.
fn settings(case: &Case, reference: &Reference, work: &Work, options: &VerifyOptions, looks: usize) -> Settings {
    let more = if looks > 1 { SECOND_LOOK } else { 1.0 };
    let samples = match case.method {
        Method::Path => work.path,
        Method::Bidirectional => work.bidirectional,
        Method::Mlt => work.mlt,
        // A mutation of these is a whole sample.
        Method::Pssmlt => 0.125 * work.mlt,
        Method::Mmlt => 0.5 * work.mlt,
    };
    let mut settings = Settings {
        method: case.method,
        size: (reference.mean.width, reference.mean.height),
        seed: options.seed + if looks > 1 { work.replicas as u64 } else { 0 },
        threads: options.threads,
        budget: Budget::SamplesPerPixel(samples * more),
        ..Settings::default()
    };
    settings.mlt.mutations.clone_from(&case.mutations);
    settings.mlt.direct = Direct::InChain;
    settings.mlt.chains = 128;
    settings.mlt.life = LIFE;
    settings.mlt.seeding.max_samples = (work.seeding as f64 * more) as u64;
    settings
}

/// The outcome of one case on one scene.
struct Row {
    scene: String,
    case: Case,
    test: ReplicaTest,
    verdict: Verdict,
    /// 2 if it was rendered again.
    looks: usize,
    seconds: f64,
}

/// Verifies scenes against their references; true if all hold.
pub fn run(options: &VerifyOptions) -> Result<bool, CliError> {
    let scenes = scenes(options)?;
    let wanted = |case: &Case| {
        options.method.is_none_or(|method| method == case.method)
            && options.mix.as_ref().is_none_or(|mix| *mix == case.mix)
    };
    let cases: Vec<Case> = cases().into_iter().filter(wanted).collect();
    if cases.is_empty() {
        let mixes: Vec<String> = self::cases().into_iter().map(|c| c.mix).filter(|m| !m.is_empty()).collect();
        return Err(CliError::Said(format!("there is no such case; the mixes of mlt are {}", mixes.join(", "))));
    }
    // Each case may fail so often that all together fail as often as is allowed.
    let alpha = -f64::exp_m1(f64::ln_1p(-FAMILY_ALPHA) / (scenes.len() * cases.len()) as f64);
    let unwatched = |e: std::io::Error| CliError::Said(format!("cannot watch for interruptions: {e}"));
    let progress = Progress::new(options.quiet).map_err(unwatched)?;
    let mut rows = Vec::new();
    for (name, scene_file, reference_file) in &scenes {
        let reference = Reference::read(reference_file)?;
        let mut asset = load(scene_file)?;
        (asset.description.environment, asset.description.medium) = surroundings_of(scene_file, name)?;
        let (width, height) = (reference.mean.width, reference.mean.height);
        let (camera, _) = asset.camera("", f64::from(width) / f64::from(height))?;
        let view = Settings { size: (width, height), ..Settings::default() }.view(camera);
        let scene = Scene::new(asset.description, &view).map_err(|e| CliError::Said(format!("{name}: {e}")))?;
        for case in cases.iter().filter(|case| case.applies(&scene)) {
            let start = std::time::Instant::now();
            let look = |looks: usize| -> Result<ReplicaTest, CliError> {
                let work = options.budget.work();
                let settings = settings(case, &reference, &work, options, looks);
                let renderings = render_replicas(&scene, &settings, work.replicas, &progress)?;
                if progress.interrupted() {
                    progress.finish();
                    return Err(CliError::Said("stopped before all cases were tested".into()));
                }
                let images: Vec<Image> = renderings.iter().map(|r| output::image(&r.picture)).collect();
                test_replicas(&images, &reference).map_err(|e| CliError::Said(format!("{name}: {e}")))
            };
            let (mut test, mut looks) = (look(1)?, 1);
            if test.verdict(alpha) != Verdict::Holds {
                (test, looks) = (look(2)?, 2);
            }
            let verdict = test.verdict(alpha);
            if verdict == Verdict::Fails {
                write_difference(options, name, case, &test, (width, height))?;
            }
            let seconds = start.elapsed().as_secs_f64();
            rows.push(Row { scene: name.clone(), case: case.clone(), test, verdict, looks, seconds });
        }
    }
    progress.finish();
    let holds = rows.iter().all(|row| row.verdict != Verdict::Fails);
    if !options.quiet || !holds {
        terminal::print_lines(lines(&rows, alpha));
    }
    Ok(holds)
}

/// Names, scene files and reference files of the scenes to verify.
fn scenes(options: &VerifyOptions) -> Result<Vec<(String, PathBuf, PathBuf)>, CliError> {
    let folder = options.root.join("reference");
    let said = |e: std::io::Error| {
        let text =
            format!("{} cannot be read: {e}. Run this in the project's folder, or name it by --root", folder.display());
        CliError::Said(text)
    };
    let mut known: Vec<String> = std::fs::read_dir(&folder)
        .map_err(said)?
        .flatten()
        .filter_map(|entry| {
            let path = entry.path();
            (path.extension()? == "exr").then(|| path.file_stem().map(|s| s.to_string_lossy().into_owned()))?
        })
        .collect();
    known.sort();
    if let Some(unknown) = options.scenes.iter().find(|name| !known.contains(name)) {
        let text = format!("{} has no {unknown}.exr; there are references of {}", folder.display(), known.join(", "));
        return Err(CliError::Said(text));
    }
    let chosen = if options.scenes.is_empty() { known } else { options.scenes.clone() };
    let files = |name: String| {
        let scene = options.root.join("scenes").join(&name).join("scene.glb");
        let reference = folder.join(format!("{name}.exr"));
        (name, scene, reference)
    };
    Ok(chosen.into_iter().map(files).collect())
}

/// The environment and the medium that the config beside a scene names, NAME.ron; none without a config.
fn surroundings_of(scene_file: &Path, name: &str) -> Result<(Option<Environment>, Medium), CliError> {
    let config = scene_file.with_file_name(format!("{name}.ron"));
    if !config.exists() {
        return Ok((None, Medium::VACUUM));
    }
    let settings = crate::config::load(&config)?;
    let medium = settings.medium.map_or(Medium::VACUUM, |medium| medium.medium());
    Ok((environment::load(settings.environment.as_ref())?.0, medium))
}

fn stem(name: &str, case: &Case) -> String {
    let mix = if case.mix.is_empty() { String::new() } else { format!("-{}", case.mix) };
    format!("verify-{name}-{}{mix}", case.method.name())
}

fn write_difference(
    options: &VerifyOptions,
    name: &str,
    case: &Case,
    test: &ReplicaTest,
    (width, height): (u32, u32),
) -> Result<(), CliError> {
    let path: PathBuf = Path::new(&options.output).join(format!("{}.png", stem(name, case)));
    write_png(&path, &test.picture(width, height), Exposure::Stops(0.0))?;
    Ok(())
}

fn lines(rows: &[Row], alpha: f64) -> Vec<String> {
    let cells = |row: &Row| {
        let (difference, t, p) = row.test.total;
        let worst = row.test.worst();
        vec![
            row.scene.clone(),
            row.case.method.name().to_string(),
            if row.case.mix.is_empty() { "-".into() } else { row.case.mix.clone() },
            format!("{:+.2} %", difference * 100.0),
            format!("{t:+.1}"),
            format!("{p:.2e}"),
            worst.map_or("-".into(), |w| format!("{:+.1}", w.t)),
            format!("{:.2e}", row.test.p_largest),
            format!("{} of {}", row.test.exceedances.0, row.test.blocks.len()),
            format!("{:.2e}", row.test.exceedances.1),
            row.looks.to_string(),
            human_time(row.seconds),
            format!("{:.0} %", row.test.dominated() * 100.0),
            match row.verdict {
                Verdict::Holds => "holds".into(),
                Verdict::Unresolved => "unresolved".into(),
                Verdict::Fails => "FAILS".into(),
            },
        ]
    };
    let head = [
        "scene",
        "method",
        "mix",
        "total",
        "t",
        "p",
        "worst block t",
        "p",
        "beyond 1 %",
        "p",
        "looks",
        "time",
        "rare",
        "verdict",
    ];
    let mut lines = table::lines(&head, &rows.iter().map(cells).collect::<Vec<_>>());
    let count = |verdict| rows.iter().filter(|row| row.verdict == verdict).count();
    let (failed, unresolved) = (count(Verdict::Fails), count(Verdict::Unresolved));
    lines.push(String::new());
    if unresolved > 0 {
        lines.push(format!(
            "{unresolved} unresolved: in so many blocks (rare) one replica makes most of the spread that a block too dark means \
             nothing; the total and blocks too bright are judged"
        ));
    }
    lines.push(match failed {
        0 => format!("no case of {} disagrees with its reference (level {alpha:.1e} each)", rows.len()),
        _ => format!("{failed} of {} cases do not agree with their references; verify-*.png show where", rows.len()),
    });
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_mutation_has_a_case_and_every_case_is_valid() {
        let cases = cases();
        for mutation in AnyMutation::all() {
            assert!(cases.iter().any(|case| case.mix == mutation.name()), "{}", mutation.name());
        }
        for case in cases {
            let mut settings = Settings { method: case.method, ..Settings::default() };
            settings.mlt.mutations.clone_from(&case.mutations);
            assert_eq!(settings.validate(), Ok(()), "{case:?}");
        }
    }
}
