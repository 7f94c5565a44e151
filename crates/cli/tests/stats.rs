//! `ergodic stats`: what it shows is what stats.json holds.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

use serde_json::Value;

const WIDTH: usize = 110;

/// A folder with two renders by Metropolis light transport, one by multiplexed chains and one by path tracing, made once.
fn folder() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("stats");
        fs::create_dir_all(&folder).expect("a folder for temporary files");
        let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/glass/scene.glb").display().to_string();
        let runs = [
            ("a", "mlt", "1", "64"),
            ("b", "mlt", "2", "32"),
            ("primary", "pssmlt", "3", "64"),
            ("path", "path", "4", "64"),
        ];
        for (stem, method, seed, chains) in runs {
            let output = command(&folder)
                .args(["render", &scene, "-q", "--size", "24x16", "--samples-per-pixel", "64", "--method", method])
                .args(["--seed", seed, "--set", "mlt.seeding.max_samples=20000", "-o", stem])
                .args(["--set", &format!("mlt.chains={chains}")])
                .output()
                .expect("the command starts");
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        }
        folder
    })
}

fn command(folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_ergodic"));
    command.current_dir(folder);
    command
}

fn run(arguments: &[&str]) -> Output {
    command(folder()).arg("stats").args(arguments).output().expect("the command starts")
}

fn printed(arguments: &[&str]) -> String {
    let output = run(arguments);
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("the command writes UTF-8")
}

fn refused(arguments: &[&str]) -> String {
    let output = run(arguments);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {}", String::from_utf8_lossy(&output.stdout));
    String::from_utf8(output.stderr).expect("the command writes UTF-8")
}

fn json(stem: &str) -> Value {
    serde_json::from_slice(&fs::read(folder().join(format!("{stem}.stats.json"))).expect("it was rendered"))
        .expect("JSON")
}

/// Lines of comma separated values, by the names in the head. No value of these renders has a comma.
fn csv(arguments: &[&str]) -> Vec<BTreeMap<String, String>> {
    let text = printed(&[arguments, &["--csv", "-"]].concat());
    let mut lines = text.lines();
    let head: Vec<&str> = lines.next().expect("a head").split(',').collect();
    let line = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        assert_eq!(cells.len(), head.len(), "{line}");
        head.iter().map(ToString::to_string).zip(cells.into_iter().map(str::to_string)).collect()
    };
    lines.map(line).collect()
}

/// Holds a line to a tally of the file, to the last bit of what the reader of JSON makes of it. That is right to one unit in the last
/// place.
fn assert_same(line: &BTreeMap<String, String>, tally: &Value) {
    let same = |name: &str, value: &Value| {
        let cell = &line[name];
        match value.as_f64() {
            Some(value) => assert_eq!(cell.parse::<f64>().expect("a number").to_bits(), value.to_bits(), "{name}"),
            None => assert!(cell.is_empty(), "{name}: {cell}"),
        }
    };
    same("proposed", &tally["proposed"]);
    same("accepted", &tally["accepted"]);
    same("faulty", &tally["faulty"]);
    same("acceptance", &tally["acceptance"]);
    same("jump_pixels", &tally["mean_jump_pixels"]);
    same("ns", &tally["ns_per_proposal"]);
    let reasons = tally["not_built"].as_object().expect("counts by reason");
    for (name, cell) in line {
        if let Some(reason) = name.strip_prefix("not_built.") {
            let count = reasons.get(reason).map_or(0, |count| count.as_u64().expect("a count"));
            assert_eq!(cell, &count.to_string(), "{reason}");
        }
    }
    assert!(reasons.keys().all(|reason| line.contains_key(&format!("not_built.{reason}"))), "{reasons:?}");
}

#[test]
fn comma_separated_values_are_those_of_the_file() {
    let lines = csv(&["a", "b.exr"]);
    let mut seen = 0;
    for stem in ["a", "b"] {
        let stats = json(stem);
        for mutation in stats["mutation_statistics"].as_array().unwrap() {
            let name = mutation["name"].as_str().unwrap();
            let line = lines.iter().find(|line| line["run"] == stem && line["mutation"] == name).unwrap();
            assert_same(line, mutation);
            assert_eq!(line["seed"], stats["seed"].to_string());
            assert_eq!(line["b"].parse::<f64>().unwrap(), stats["b"].as_f64().unwrap());
            seen += 1;
        }
    }
    assert_eq!(seen, lines.len());

    for (key, part) in [("length", "by_length"), ("class", "by_class")] {
        let lines = csv(&["a.stats.json", "--by", &format!("mutation,{key}")]);
        let mut seen = 0;
        for mutation in json("a")["mutation_statistics"].as_array().unwrap() {
            for (of, tally) in mutation[part].as_object().unwrap() {
                let name = mutation["name"].as_str().unwrap();
                let line = lines.iter().find(|line| line["mutation"] == name && line[key] == *of).unwrap();
                assert_same(line, tally);
                seen += 1;
            }
        }
        // Paths of more than 8 edges have no class.
        assert_eq!(seen, lines.iter().filter(|line| !line[key].is_empty()).count());
        let proposed: u64 = lines.iter().map(|line| line["proposed"].parse::<u64>().unwrap()).sum();
        assert_eq!(proposed, json("a")["mutations"].as_u64().unwrap(), "nothing is lost or counted twice");
    }
}

#[test]
fn filters_add_up_what_passes_them() {
    let stats = json("a");
    let lens = stats["mutation_statistics"].as_array().unwrap().iter().find(|m| m["name"] == "lens").unwrap();
    let lengths = lens["by_length"].as_object().unwrap();
    let wanted: Vec<&Value> = ["3", "4", "5"].iter().filter_map(|length| lengths.get(*length)).collect();
    let lines = csv(&["a", "--mutation", "lens", "--length", "3..5"]);
    let [line] = &lines[..] else { panic!("{lines:?}") };
    let sum = |of: fn(&Value) -> f64| wanted.iter().map(|tally| of(tally)).sum::<f64>();
    let proposed = sum(|tally| tally["proposed"].as_f64().unwrap());
    let accepted = sum(|tally| tally["proposed"].as_f64().unwrap() * tally["acceptance"].as_f64().unwrap());
    assert_eq!(line["proposed"].parse::<f64>().unwrap(), proposed);
    assert!((line["acceptance"].parse::<f64>().unwrap() - accepted / proposed).abs() < 1e-12);

    // The same paths by their classes and by their length.
    let by_class = csv(&["a", "--by", "length", "--class", "L..E"]);
    let by_length = csv(&["a", "--by", "length", "--length", "3"]);
    assert_eq!((by_class.len(), &by_class[0]["proposed"]), (1, &by_length[0]["proposed"]));
    assert!(by_class[0]["proposed"].parse::<u64>().unwrap() > 0);

    let classes = csv(&["a", "--by", "class", "--class", "LS+DE"]);
    assert!(!classes.is_empty());
    assert!(
        classes.iter().all(|line| line["class"].starts_with("LS") && line["class"].ends_with("SDE")),
        "{classes:?}"
    );
}

#[test]
fn renders_stand_side_by_side_with_differences_and_fit_the_width() {
    let one = printed(&["a"]);
    for part in ["not built because", "accepted", "standard error", "mutations", "R-hat", "jump px"] {
        assert!(one.contains(part), "{part} is not in\n{one}");
    }
    let two = printed(&["a", "b", "--reasons"]);
    for part in ["b minus a", "+- ", "mlt.chains", "seed", "not_connectable"] {
        assert!(two.contains(part), "{part} is not in\n{two}");
    }
    assert!(!two.contains("share random numbers"));
    assert!(printed(&["a", "a"]).contains("share random numbers"));
    for arguments in [
        vec!["a", "b", "primary", "path", "--reasons"],
        vec!["a", "b", "--by", "mutation,class", "--reasons"],
        vec!["a", "--by", "class", "--columns", "proposed,acceptance,correlation,moves_per_ms,seconds"],
    ] {
        let text = printed(&arguments);
        let widest = text.lines().max_by_key(|line| line.chars().count()).unwrap();
        assert!(widest.chars().count() <= WIDTH, "{widest}");
    }
    assert!(one.contains("mean probability") && !printed(&["a", "--brief"]).contains("mean probability"));
}

#[test]
fn errors_follow_from_the_autocorrelation_time() {
    let stats = json("a");
    let quantities = stats["diagnostics"]["quantities"].as_array().unwrap();
    let time = quantities.iter().map(|q| q["autocorrelation_time"].as_f64().unwrap()).fold(1.0, f64::max);
    let all = stats["mutations"].as_f64().unwrap();
    let lines = csv(&["a"]);
    // What was never proposed has no acceptance.
    let proposed: Vec<_> = lines.iter().filter(|line| line["proposed"] != "0").collect();
    assert!(proposed.len() >= 3, "{lines:?}");
    for line in proposed {
        let number = |name: &str| line[name].parse::<f64>().unwrap();
        let (a, n) = (number("acceptance"), number("proposed"));
        let expected = (a * (1.0 - a) / n * (1.0 + (time - 1.0) * n / all)).sqrt();
        assert!((number("acceptance_error") / expected - 1.0).abs() < 1e-9, "{line:?}");
    }
}

#[test]
fn rows_are_sorted_by_a_column() {
    let lines = csv(&["a", "--by", "class", "--sort", "acceptance"]);
    // What was never proposed has no acceptance, and comes last.
    let values: Vec<f64> = lines.iter().map_while(|line| line["acceptance"].parse().ok()).collect();
    assert!(values.len() > 3 && values.windows(2).all(|pair| pair[0] >= pair[1]), "{values:?}");
    assert!(lines[values.len()..].iter().all(|line| line["acceptance"].is_empty() && line["proposed"] == "0"));
    let classes = csv(&["a", "--by", "length"]);
    let proposed = classes.iter().filter(|line| line["proposed"] != "0");
    let lengths: Vec<usize> = proposed.map(|line| line["length"].parse().unwrap()).collect();
    assert!(lengths.is_sorted(), "{lengths:?}");
}

#[test]
fn a_render_without_mutations_shows_what_it_has() {
    let text = printed(&["path"]);
    for part in ["rays a second", "contributions left out", "mean radiance", "path has no mutations"] {
        assert!(text.contains(part), "{part} is not in\n{text}");
    }
    let lines = csv(&["path", "primary"]);
    assert_eq!(lines[0]["rays"], json("path")["rays"].to_string());
    assert!(lines[0]["mutation"].is_empty() && lines.len() > 1);
    // A step in primary sample space changes several paths at once.
    assert!(printed(&["primary", "--by", "class"]).contains("not told apart"));
}

#[test]
fn what_cannot_be_shown_is_told_with_what_can() {
    assert!(refused(&["a", "--mutation", "magic"]).contains("there are bidirectional, lens"));
    let told = refused(&["a", "--length", "90.."]);
    assert!(told.contains("there are paths of 3 to") && told.contains("LSDE"), "{told}");
    assert!(refused(&["a", "--class", "LXE"]).contains("LSDE"));
    assert!(refused(&["primary", "--length", "3"]).contains("several paths at once"));
    assert!(refused(&["path", "--mutation", "lens"]).contains("render by path has no mutations"));
    assert!(refused(&["a", "--sort", "luck"]).contains("proposed, share"));
    assert!(refused(&["a", "--columns", "luck"]).contains("proposed, share"));
    assert!(refused(&["missing.exr"]).contains("missing.stats.json: cannot be read"));
    assert!(refused(&["a.png", "nothing"]).contains("nothing.stats.json: cannot be read"));

    let write = |name: &str, text: &str| fs::write(folder().join(name), text).unwrap();
    write("x.accuracy.json", r#"{"rel_mse_epsilon": 0.01, "version": "0.1.0", "methods": []}"#);
    assert!(refused(&["x.accuracy.json"]).contains("the result of `ergodic accuracy`"));
    write("text.stats.json", "no JSON");
    assert!(refused(&["text.stats.json"]).contains("is not JSON"));
    write("other.stats.json", r#"{"name": "other"}"#);
    assert!(refused(&["other.stats.json"]).contains("is not the stats of a render: missing field"));
    let mut old = json("a");
    old.as_object_mut().unwrap().remove("stability");
    write("old.stats.json", &old.to_string());
    assert!(refused(&["old.stats.json"]).contains("was written by version"));
    let mut broken = json("a");
    broken["mutation_statistics"] = Value::Null;
    write("broken.stats.json", &broken.to_string());
    assert!(refused(&["broken.stats.json"]).contains("statistics of its mutations cannot be read"));
}
