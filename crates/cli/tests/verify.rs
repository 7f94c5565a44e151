//! `ergodic verify` with its quick budget: every method and every mutation on every scene.

use std::path::Path;
use std::process::Command;

#[test]
fn every_method_and_every_mutation_agrees_with_every_reference() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let folder = std::env::temp_dir().join(format!("ergodic-verify-all-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_ergodic"))
        .args(["verify", "--root"])
        .arg(&root)
        .arg("--output")
        .arg(&folder)
        .output()
        .unwrap();
    let printed = String::from_utf8_lossy(&output.stdout);
    println!("{printed}");
    assert_eq!(output.status.code(), Some(0), "{printed}{}", String::from_utf8_lossy(&output.stderr));
    let rows = |scene: &str| printed.lines().filter(|line| line.starts_with(scene)).count();
    for scene in ["ajar", "cornell", "dusk", "glass", "pool", "ring"] {
        // Path tracing, bidirectional path tracing, two methods in primary sample space, the full mix, the bidirectional mutation
        // alone, three others with it; in cornell and ring nothing is specular, so there are two.
        let expected = if matches!(scene, "cornell" | "ring") { 8 } else { 9 };
        assert_eq!(rows(scene), expected, "{scene}\n{printed}");
    }
    std::fs::remove_dir_all(&folder).unwrap();
}
