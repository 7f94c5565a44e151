//! The table of `docs/numerics.md` names tests that exist, and all of this folder.

use std::fs;

use ergodic_tests::root;

/// Names of the test functions of a source file.
fn tests_of(source: &str) -> Vec<String> {
    let after = source.split("#[test]").skip(1);
    after.filter_map(|rest| rest.split("fn ").nth(1)?.split('(').next().map(str::to_string)).collect()
}

#[test]
fn every_case_of_the_table_has_its_test() {
    let table = fs::read_to_string(root().join("docs/numerics.md")).expect("the table is there");
    let mut named = Vec::new();
    for row in table.lines().filter(|line| line.starts_with("| ")) {
        for name in row.split('`').skip(1).step_by(2).filter(|name| name.contains("::")) {
            let (file, test) = name.rsplit_once("::").expect("it contains ::");
            let source =
                fs::read_to_string(root().join(file)).unwrap_or_else(|e| panic!("docs/numerics.md names {file}: {e}"));
            assert!(
                tests_of(&source).iter().any(|t| t == test),
                "docs/numerics.md names {test}, which is not in {file}"
            );
            named.push(name.to_string());
        }
    }
    let folder = root().join("tests/tests/numerics");
    for entry in fs::read_dir(folder).expect("it is there") {
        let path = entry.expect("it can be read").path();
        let file = path.file_name().expect("a file").to_string_lossy().into_owned();
        for test in tests_of(&fs::read_to_string(&path).expect("it can be read")) {
            let name = format!("tests/tests/numerics/{file}::{test}");
            assert!(file == "table.rs" || named.contains(&name), "docs/numerics.md does not name {name}");
        }
    }
}
