//! What the census found, and what follows, in words.

use ergodic_mutations::AnyMutation;
use ergodic_pathspace::{Census, Compiled, Effect, Finding, Plan, SceneDescription};
use serde::{Deserialize, Serialize};

use crate::table;

/// Materials that are named one by one.
const NAMED: usize = 3;

/// The plan in stats.json and in the EXR.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct PlanStats {
    /// Effects that the scene has, and that were rendered.
    on: Vec<String>,
    /// Effects that the scene does not have, and that cost nothing.
    off: Vec<String>,
    /// Forced on though the scene has nothing of them.
    forced_on: Vec<String>,
    /// Forced off though the scene has them.
    forced_off: Vec<String>,
    /// The repertoire whose code rendered the scene.
    #[serde(default)]
    repertoire: String,
    /// Mutations of the mixture that could apply to no path, and were left out.
    mutations_left_out: Vec<String>,
}

impl PlanStats {
    /// The plan, with the mutations of a mixture.
    pub fn new(plan: &Plan, repertoire: Compiled, mutations: &[(f64, AnyMutation)]) -> Self {
        let names = |effects: ergodic_pathspace::Effects| effects.iter().map(|effect| effect.name().into()).collect();
        let idle = |(_, mutation): &&(f64, AnyMutation)| mutation.never_applies(plan.on).is_some();
        Self {
            on: names(plan.on.and(plan.found)),
            off: names(ergodic_pathspace::Effects::all().without(plan.on).without(plan.found)),
            forced_on: names(plan.idle()),
            forced_off: names(plan.missing()),
            repertoire: repertoire.name().into(),
            mutations_left_out: mutations.iter().filter(idle).map(|(_, mutation)| mutation.name().into()).collect(),
        }
    }
}

/// What a scene has of an effect.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct CensusRow {
    effect: String,
    found: bool,
    /// Where: materials, lights, triangles; empty if it has nothing of it.
    place: String,
    /// What it means for the render, or what is saved.
    consequence: String,
}

/// All effects, those that the scene has first.
pub fn rows(census: &Census, description: &SceneDescription) -> Vec<CensusRow> {
    let found = census.effects();
    let row = |finding: &Finding| {
        let (effect, found) = (finding.effect, found.has(finding.effect));
        let consequence = if found { effect.when_on() } else { effect.when_off() };
        let place = if found { place(finding, description) } else { String::new() };
        CensusRow { effect: effect.name().into(), found, place, consequence: consequence.into() }
    };
    let mut rows: Vec<CensusRow> = census.findings().iter().map(row).collect();
    rows.sort_by_key(|row| !row.found);
    rows
}

fn place(finding: &Finding, description: &SceneDescription) -> String {
    let mut parts = Vec::new();
    let plural = |n: u64, what: &str| if n == 1 { format!("1 {what}") } else { format!("{n} {what}s") };
    if !finding.materials.is_empty() {
        let names = finding.materials.iter().take(NAMED).map(|i| format!("{:?}", description.materials[*i].name));
        let mut names = names.collect::<Vec<_>>().join(", ");
        if finding.materials.len() > NAMED {
            names.push_str(", ...");
        }
        parts.push(format!("{} ({names})", plural(finding.materials.len() as u64, "material")));
    }
    if finding.count > 0 {
        parts.push(plural(
            finding.count,
            match finding.effect {
                Effect::Environment => "map",
                Effect::Absorption | Effect::Scattering => "medium",
                Effect::VertexColors => "mesh with it",
                Effect::Instances => "placement",
                Effect::Aperture | Effect::Orthographic => "camera",
                _ => "light",
            },
        ));
    }
    if finding.triangles > 0 {
        parts.push(format!("{} triangles", table::count(finding.triangles as f64)));
    }
    parts.join(", ")
}

/// What `ergodic inspect` says: the effects found and what they mean, those absent and what is saved, the mutations that never apply.
///
/// The camera is the file's first.
pub fn lines(description: &SceneDescription, mutations: &[(f64, AnyMutation)]) -> Vec<String> {
    let census = Census::of(description, description.cameras.first());
    let found = census.effects();
    let rows = |on: bool| -> Vec<Vec<String>> {
        let findings = census.findings().iter().filter(|finding| found.has(finding.effect) == on);
        findings
            .map(|finding| {
                let effect = finding.effect;
                if on {
                    vec![effect.name().into(), place(finding, description), effect.when_on().into()]
                } else {
                    vec![effect.name().into(), effect.when_off().into()]
                }
            })
            .collect()
    };
    let indented = |lines: Vec<String>| lines.into_iter().map(|line| format!("  {line}"));
    let mut lines = vec!["Effects that the scene calls for:".to_string()];
    lines.extend(indented(table::lines(&["effect", "where", "consequence"], &rows(true))));
    lines.push(String::new());
    lines.push("Effects that it does not have, and does not pay for:".into());
    lines.extend(indented(table::lines(&["effect", "what is saved"], &rows(false))));
    let repertoire = Compiled::smallest(found, &description.materials);
    lines.push(format!("Rendered by the code for `{}`: {}.", repertoire.name(), repertoire.about()));
    for (_, mutation) in mutations {
        if let Some(reason) = mutation.never_applies(found) {
            lines.push(format!("{} never applies: {reason}; its weight goes to the others", mutation.name()));
        }
    }
    lines
}
