//! `ergodic verify` with its quick budget: the methods on every scene, all other cases on one scene without specular surfaces and one
//! with them. The nightly run has every case on every scene, with the full budget.

use std::path::Path;
use std::process::Command;

/// Runs `ergodic verify` and holds it to a number of rows for each scene.
fn holds(arguments: &[&str], rows: &[(&str, usize)]) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let folder = std::env::temp_dir().join(format!("ergodic-verify-{}-{}", std::process::id(), arguments.join("-")));
    std::fs::create_dir_all(&folder).expect("a folder for temporary files");
    let output = Command::new(env!("CARGO_BIN_EXE_ergodic"))
        .args(["verify", "--root"])
        .arg(&root)
        .arg("--output")
        .arg(&folder)
        .args(arguments)
        .output()
        .expect("the command is built");
    let printed = String::from_utf8_lossy(&output.stdout);
    println!("{printed}");
    assert_eq!(output.status.code(), Some(0), "{printed}{}", String::from_utf8_lossy(&output.stderr));
    for (scene, expected) in rows {
        let found = printed.lines().filter(|line| line.starts_with(scene)).count();
        assert_eq!(found, *expected, "{scene}\n{printed}");
    }
    std::fs::remove_dir_all(&folder).expect("its own folder");
}

#[test]
fn every_method_and_every_mutation_agrees_with_the_references() {
    // Path tracing, bidirectional path tracing, two methods in primary sample space, the full mix, the bidirectional mutation alone, and
    // the others with a little of it. In cornell nothing is specular, so multi-chain perturbations never apply.
    holds(&["cornell", "pool"], &[("cornell", 9), ("pool", 10)]);
}

#[test]
fn independent_samples_and_the_full_mix_agree_with_the_other_references() {
    let scenes = ["ajar", "dusk", "glass", "ring"];
    let each = scenes.map(|scene| (scene, 1));
    for case in [&["--method", "path"][..], &["--method", "bidirectional"], &["--method", "mlt", "--mix", "full"]] {
        holds(&[&scenes[..], case].concat(), &each);
    }
}
