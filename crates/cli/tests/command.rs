//! The command as its users meet it: what it prints, what it writes, how it fails.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use ergodic_assess::read_image;
use serde_json::Value;

/// A folder of its own for each test, removed at the end.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("ergodic-command-{name}-{}", std::process::id()));
        fs::create_dir_all(&folder).expect("a folder for temporary files");
        Self(folder)
    }

    fn command(&self) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_ergodic"));
        command.current_dir(&self.0);
        command
    }

    fn run(&self, arguments: &[&str]) -> Output {
        self.command().args(arguments).output().expect("the command starts")
    }

    fn files(&self) -> Vec<String> {
        let entries = fs::read_dir(&self.0).expect("the folder is there").flatten();
        let mut names: Vec<String> = entries.map(|e| e.file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    fn write(&self, name: &str, text: &str) {
        fs::write(self.0.join(name), text).expect("the folder can be written");
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn scene(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes").join(name).join("scene.glb");
    path.display().to_string()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Settings under which a render takes a fraction of a second.
const QUICK: [&str; 6] = ["--size", "24x16", "--samples-per-pixel", "32", "--set", "mlt.seeding.max_samples=20000"];

#[test]
fn the_default_scene_is_built_in() {
    let folder = Folder::new("default");
    let mut arguments = vec!["render"];
    arguments.extend(QUICK);
    let output = folder.run(&arguments);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert_eq!(folder.files(), ["ajar.exr", "ajar.png", "ajar.stats.json"]);
    let printed = text(&output.stdout);
    for word in ["bidirectional", "lens", "caustic", "multi_chain", "accepted", "b = ", "mutations/s", "ajar.png"] {
        assert!(printed.contains(word), "{word} is not in\n{printed}");
    }
}

#[test]
fn statistics_hold_what_they_promise_and_add_up() {
    let folder = Folder::new("stats");
    let scene = scene("glass");
    let mut arguments = vec!["render", &scene, "-o", "a", "--seed", "5", "--threads", "2"];
    arguments.extend(QUICK);
    assert!(folder.run(&arguments).status.success());
    let stats: Value = serde_json::from_slice(&fs::read(folder.0.join("a.stats.json")).unwrap()).unwrap();
    for key in
        ["wall_seconds", "rays_per_second", "mutations_per_second", "b", "b_relative_error", "mutations", "threads"]
    {
        assert!(stats[key].as_f64().unwrap() > 0.0, "{key}");
    }
    assert_eq!((stats["method"].as_str(), stats["seed"].as_u64()), (Some("mlt"), Some(5)));
    let list = stats["mutation_statistics"].as_array().unwrap();
    let count = |value: &Value| value.as_u64().unwrap();
    assert_eq!(list.iter().map(|m| count(&m["proposed"])).sum::<u64>(), count(&stats["mutations"]));
    for mutation in list {
        let proposed = count(&mutation["proposed"]);
        for split in ["by_length", "by_class"] {
            let parts = mutation[split].as_object().unwrap();
            let sum: u64 = parts.values().map(|part| count(&part["proposed"])).sum();
            // Longer paths are not told apart by class.
            assert!(if split == "by_length" { sum == proposed } else { sum <= proposed }, "{split}");
        }
        if proposed > 0 {
            let acceptance = mutation["acceptance"].as_f64().unwrap();
            assert!((0.0..=1.0).contains(&acceptance));
            assert!(mutation["not_built"].is_object() && mutation["ns_per_proposal"].as_f64().is_some());
        }
    }
    let classes = list[0]["by_class"].as_object().unwrap();
    assert!(classes.keys().all(|c| c.starts_with('L') && c.ends_with('E')), "{classes:?}");
    assert!(classes.keys().any(|c| c.contains('S')), "glass has Dirac components");
}

#[test]
fn the_same_seed_gives_the_same_bytes_on_any_number_of_threads() {
    let folder = Folder::new("threads");
    let scene = scene("cornell");
    for method in ["path", "bidirectional", "mlt"] {
        let picture = |stem: &str, seed: &str, threads: &str| {
            let mut arguments =
                vec!["render", &scene, "-q", "--method", method, "-o", stem, "--seed", seed, "--threads", threads];
            arguments.extend(QUICK);
            assert!(folder.run(&arguments).status.success());
            // The EXR also holds the time that the render took.
            fs::read(folder.0.join(format!("{stem}.png"))).unwrap()
        };
        let one = picture("one", "1", "1");
        assert_eq!(one, picture("two", "1", "2"), "{method}");
        assert_ne!(one, picture("other", "2", "2"), "{method}");
    }
}

fn forget_times(value: &mut Value) {
    match value {
        Value::Object(fields) => {
            fields.remove("ns_per_proposal");
            fields.values_mut().for_each(forget_times);
        }
        Value::Array(values) => values.iter_mut().for_each(forget_times),
        _ => {}
    }
}

/// The C library has its functions twice and more, for processors with and without fused multiplication, and their last bits differ. A
/// render that asked it for one would tell: hundreds of thousands of numbers go into these.
#[test]
fn no_number_depends_on_what_the_processor_can_do() {
    let folder = Folder::new("processor");
    let scene = scene("ajar");
    let numbers = |stem: &str, seed: &str, variables: &[(&str, &str)]| {
        let arguments =
            ["render", &scene, "-q", "-o", stem, "--size", "64x64", "--samples-per-pixel", "32", "--seed", seed];
        let status =
            folder.command().args(arguments).envs(variables.iter().copied()).status().expect("the command starts");
        assert!(status.success());
        let file = fs::read(folder.0.join(format!("{stem}.stats.json"))).unwrap();
        let mut stats: Value = serde_json::from_slice(&file).unwrap();
        forget_times(&mut stats);
        ["mean", "b", "diagnostics", "mutation_statistics"].map(|key| stats[key].clone())
    };
    let here = numbers("here", "1", &[]);
    let without = [("ERGODIC_ISA", "plain"), ("GLIBC_TUNABLES", "glibc.cpu.hwcaps=-FMA,-FMA4,-AVX2,-AVX512F")];
    assert_eq!(here, numbers("without", "1", &without));
    assert_ne!(here, numbers("other", "2", &[]));
}

#[test]
fn options_win_over_set_and_set_over_the_config() {
    let folder = Folder::new("precedence");
    let file =
        format!("(scene: {:?}, size: (10, 10), seed: 1, max_edges: 3, budget: SamplesPerPixel(1))", scene("ring"));
    folder.write("my.ron", &file);
    let arguments = [
        "render",
        "--config",
        "my.ron",
        "--set",
        "seed=2",
        "--set",
        "size=(11, 11)",
        "--size",
        "12x9",
        "--method",
        "path",
    ];
    let output = folder.run(&arguments);
    assert!(output.status.success(), "{}", text(&output.stderr));
    // The scene's file is called scene.glb, so its folder names the picture.
    let stats: Value = serde_json::from_slice(&fs::read(folder.0.join("ring.stats.json")).unwrap()).unwrap();
    assert_eq!(
        (stats["width"].as_u64(), stats["height"].as_u64(), stats["seed"].as_u64()),
        (Some(12), Some(9), Some(2))
    );
    assert!(stats["config"].as_str().unwrap().contains("max_edges: 3"));
    assert_eq!(stats["method"], "path");
    assert!(stats.get("b").is_none(), "path tracing has no b");
}

#[test]
fn errors_are_one_paragraph_exit_with_2_and_write_nothing() {
    let folder = Folder::new("errors");
    let cornell = scene("cornell");
    folder.write("broken.ron", "(\n    method: mlt,\n    mlt: (chains: 5, seedling: ()),\n)\n");
    folder.write("unfinished.ron", "(method: mlt,\n  size: (3, 4");
    folder.write("wrong.ron", "(method: metropolis)");
    folder.write("zero.ron", "(max_edges: 0)");
    folder.write("not.glb", "glTF, but not really");
    let before = folder.files();
    let cases: [(&[&str], &[&str]); 19] = [
        (&["missing.glb"], &["missing.glb", "cannot be read"]),
        (&["not.glb"], &["not.glb"]),
        (&[&cornell, "--camera", "nowhere"], &["no camera \"nowhere\"", "Its cameras are"]),
        (&[&cornell, "--size", "0x100"], &["0x100", "at least 1"]),
        (&[&cornell, "--size", "big"], &["640x360"]),
        (&[&cornell, "--size", "100000x1"], &["65536"]),
        (&[&cornell, "-o", "missing/folder/a"], &["missing/folder/a.exr", "cannot be written"]),
        (&[&cornell, "-o", "/"], &["names no file"]),
        (&[&cornell, "--config", "missing.ron"], &["missing.ron", "ergodic config"]),
        (&[&cornell, "--config", "broken.ron"], &["broken.ron, line 3, column 22", "seedling", "`seeding`"]),
        (&[&cornell, "--config", "unfinished.ron"], &["unfinished.ron, line 2"]),
        (&[&cornell, "--config", "wrong.ron"], &["wrong.ron, line 1", "metropolis", "`bidirectional`"]),
        (&[&cornell, "--config", "zero.ron"], &["zero.ron", "max_edges is 0", "from 1"]),
        (&[&cornell, "--set", "mlt.chans=3"], &["\"chans\"", "chains"]),
        (&[&cornell, "--set", "crop=(5, 0, 5, 9)"], &["crop is (5, 0, 5, 9)", "left < right <= 384"]),
        (
            &[&cornell, "--set", "lens=(radius: 1.0, focus_distance: 0.0)"],
            &["lens.focus_distance is 0", "greater than 0"],
        ),
        (&[&cornell, "--set", "lens=(radius: 1.0)"], &["lens", "focus_distance"]),
        (&[&cornell, "--method", "magic"], &["path, bidirectional, mlt"]),
        (&[&cornell, "--time", "1s", "--samples-per-pixel", "3"], &["cannot be used with"]),
    ];
    for (arguments, expected) in cases {
        let output = folder.command().arg("render").args(arguments).output().unwrap();
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
        for part in expected {
            assert!(said.contains(part), "{arguments:?}: {part:?} is not in\n{said}");
        }
        assert!(said.starts_with("error: ") && !said.contains("panicked") && said.lines().count() < 16, "{said}");
        assert_eq!(folder.files(), before, "{arguments:?} left something behind");
    }
}

#[test]
fn a_window_is_rendered_through_a_lens_and_the_file_says_where_it_lies() {
    let folder = Folder::new("window");
    let scene = scene("cornell");
    let mut arguments = vec!["render", &scene, "-o", "part"];
    arguments.extend(QUICK);
    arguments.extend(["--set", "crop=(3, 2, 13, 9)", "--set", "lens=(radius: 0.02, focus_distance: 1.0, blades: 6)"]);
    let output = folder.run(&arguments);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let stats: Value = serde_json::from_slice(&fs::read(folder.0.join("part.stats.json")).unwrap()).unwrap();
    assert_eq!((stats["width"].as_u64(), stats["height"].as_u64()), (Some(10), Some(7)));
    let config = stats["config"].as_str().unwrap();
    assert!(config.contains("crop: (3, 2, 13, 9)") && config.contains("blades: 6"), "{config}");
    let header = fs::read(folder.0.join("part.exr")).unwrap();
    let window = |name: &str| {
        let at = header.windows(name.len()).position(|bytes| bytes == name.as_bytes()).expect("every EXR has windows");
        // The name, its type box2i and the size, then four integers: the lowest and the highest column and row.
        let start = at + name.len() + 1 + "box2i".len() + 1 + 4;
        let number = |i: usize| i32::from_le_bytes(header[start + 4 * i..start + 4 * i + 4].try_into().unwrap());
        [number(0), number(1), number(2), number(3)]
    };
    assert_eq!((window("dataWindow"), window("displayWindow")), ([3, 2, 12, 8], [0, 0, 23, 15]));
    // The settings that were written can be read.
    folder.write("again.ron", config);
    assert!(folder.run(&["render", "--config", "again.ron", "-q", "-o", "again"]).status.success());
    assert_eq!(fs::read(folder.0.join("part.png")).unwrap(), fs::read(folder.0.join("again.png")).unwrap());
}

#[test]
fn a_scene_without_light_or_camera_says_what_it_lacks() {
    let folder = Folder::new("lacks");
    let file = |material: &str| {
        format!(
            r#"{{"asset": {{"version": "2.0"}}, "nodes": [{{"mesh": 0}}],
            "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "material": 0}}]}}], "materials": [{material}],
            "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}}],
            "bufferViews": [{{"buffer": 0, "byteLength": 36}}],
            "buffers": [{{"byteLength": 36, "uri": "data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}}]}}"#
        )
    };
    folder.write("dark.gltf", &file("{}"));
    let output = folder.run(&["render", "dark.gltf", "--size", "8x8"]);
    assert_eq!(output.status.code(), Some(2));
    let said = text(&output.stderr);
    assert!(said.contains("no light") && said.contains("emissiveFactor") && said.contains("dark.gltf"), "{said}");
    assert_eq!(folder.files(), ["dark.gltf"]);

    folder.write("lit.gltf", &file(r#"{"emissiveFactor": [1, 1, 1]}"#));
    let output = folder.run(&["render", "lit.gltf", "--size", "8x8", "--samples-per-pixel", "16"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains("no camera"), "{}", text(&output.stderr));
}

#[cfg(unix)]
#[test]
fn an_interrupted_render_keeps_what_it_has() {
    let folder = Folder::new("interrupt");
    let scene = scene("cornell");
    let mut child = folder
        .command()
        .args(["render", &scene, "--size", "32x32", "--time", "600s", "-o", "kept"])
        .args(["--set", "mlt.seeding.max_samples=20000"])
        .stderr(std::process::Stdio::null())
        .stdout(std::process::Stdio::null())
        .spawn()
        .unwrap();
    std::thread::sleep(std::time::Duration::from_secs(3));
    let killed = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(killed.success());
    let status = child.wait().unwrap();
    assert_eq!(status.code(), Some(130));
    let stats: Value = serde_json::from_slice(&fs::read(folder.0.join("kept.stats.json")).unwrap()).unwrap();
    assert_eq!(stats["interrupted"], true);
    assert!(stats["mutations"].as_u64().unwrap() > 0 && folder.0.join("kept.exr").exists());
}

#[test]
fn the_printed_config_can_be_used() {
    let folder = Folder::new("config");
    folder.write("my.ron", &text(&folder.run(&["config"]).stdout));
    let mut arguments = vec!["render", "--config", "my.ron", "-q"];
    arguments.extend(QUICK);
    let output = folder.run(&arguments);
    assert!(output.status.success() && output.stdout.is_empty(), "{}", text(&output.stderr));
}

#[test]
fn the_configs_of_the_scenes_are_valid() {
    let folder = Folder::new("scenes");
    for name in ["cornell", "ajar", "ring", "glass", "pool"] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes").join(name).join(format!("{name}.ron"));
        let path = path.display().to_string();
        let mut arguments = vec!["render", "-q", "--config", &path];
        arguments.extend(QUICK);
        let output = folder.run(&arguments);
        assert!(output.status.success(), "{name}: {}", text(&output.stderr));
        assert!(folder.0.join(format!("{name}.exr")).exists());
    }
}

#[test]
fn inspect_tells_what_is_in_a_file() {
    let folder = Folder::new("inspect");
    let output = folder.run(&["inspect", &scene("glass")]);
    assert!(output.status.success());
    let printed = text(&output.stdout);
    for part in ["Cameras", "Lights", "Materials", "solid dielectric", "index 1.500", "absorbs", "Everything"] {
        assert!(printed.contains(part), "{part} is not in\n{printed}");
    }
    assert_eq!(folder.run(&["inspect", "missing.glb"]).status.code(), Some(2));
}

#[test]
fn compare_measures_pictures() {
    let folder = Folder::new("compare");
    let scene = scene("cornell");
    for (stem, seed) in [("a", "1"), ("b", "2")] {
        let arguments =
            ["render", &scene, "-q", "--method", "path", "--size", "16x16", "--samples-per-pixel", "4", "--seed", seed];
        assert!(folder.command().args(arguments).args(["-o", stem]).status().unwrap().success());
    }
    let same = text(&folder.run(&["compare", "a.exr", "a.exr"]).stdout);
    assert!(same.contains("1.000000") && same.contains("0.000000e0"), "{same}");
    let other = folder.run(&["compare", "a.exr", "b.exr"]);
    let printed = text(&other.stdout);
    for part in ["MSE", "relMSE", "trimmed relMSE", "mean ratio", "FLIP"] {
        assert!(printed.contains(part), "{part} is not in\n{printed}");
    }
    let output = folder.run(&["compare", "a.exr", "missing.exr"]);
    assert_eq!(output.status.code(), Some(2));
    fs::copy(folder.0.join("a.png"), folder.0.join("c.exr")).unwrap();
    assert!(folder.run(&["compare", "a.exr", "c.exr"]).status.success(), "the bytes decide, not the name");
}

#[cfg(unix)]
#[test]
fn a_reader_that_goes_away_is_no_trouble() {
    let folder = Folder::new("pipe");
    let mut child = folder.command().arg("config").stdout(std::process::Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    assert!(child.wait().unwrap().success());
}

#[test]
fn verify_tests_against_the_stored_references() {
    let folder = Folder::new("verify");
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").display().to_string();
    let output = folder.run(&["verify", "cornell", "--method", "path", "--root", &root]);
    let printed = text(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{printed}{}", text(&output.stderr));
    for part in ["cornell", "path", "holds", "no case of 1 disagrees"] {
        assert!(printed.contains(part), "{part} is not in\n{printed}");
    }
    assert!(folder.files().is_empty(), "{:?}", folder.files());

    for (arguments, part) in [
        (vec!["verify", "nowhere", "--root", &root], "there are references of ajar, cornell"),
        (vec!["verify", "--mix", "magic", "--root", &root], "full, bidirectional, lens"),
        (vec!["verify"], "--root"),
    ] {
        let output = folder.run(&arguments);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains(part), "{part} is not in\n{said}");
    }
}

#[test]
fn verify_fails_where_the_scene_is_another() {
    let folder = Folder::new("verify-fails");
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    // The reference of one scene beside the file of another.
    fs::create_dir_all(folder.0.join("scenes/cornell")).unwrap();
    fs::create_dir_all(folder.0.join("reference")).unwrap();
    fs::copy(root.join("scenes/ring/scene.glb"), folder.0.join("scenes/cornell/scene.glb")).unwrap();
    fs::copy(root.join("reference/cornell.exr"), folder.0.join("reference/cornell.exr")).unwrap();
    let output = folder.run(&["verify", "--method", "path"]);
    assert_eq!(output.status.code(), Some(1), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("FAILS"));
    assert!(folder.0.join("verify-cornell-path.png").exists(), "{:?}", folder.files());
}

#[test]
fn a_crop_lies_in_the_size_that_is_asked_for() {
    let folder = Folder::new("crop");
    let scene = scene("cornell");
    // Beyond the default size.
    let wide = ["render", &scene, "-q", "-o", "a", "--method", "path", "--samples-per-pixel", "1", "--size", "800x8"];
    let output = folder.command().args(wide).args(["--set", "crop=(780, 0, 800, 8)"]).output().unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    let picture = read_image(&folder.0.join("a.exr")).expect("the picture is there");
    assert_eq!((picture.width, picture.height), (20, 8));
    let output = folder.command().args(wide).args(["--set", "crop=(780, 0, 801, 8)"]).output().unwrap();
    assert!(!output.status.success() && text(&output.stderr).contains("right <= 800"), "{}", text(&output.stderr));
}

#[test]
fn layers_are_further_channels_of_the_exr() {
    let folder = Folder::new("layers");
    let scene = scene("cornell");
    let mut arguments = vec!["render", &scene, "-q", "-o", "a", "--set", "mlt.layers=true"];
    arguments.extend(QUICK);
    assert!(folder.run(&arguments).status.success());
    let bytes = fs::read(folder.0.join("a.exr")).unwrap();
    for name in ["acceptance", "longest_stay", "standard_error"] {
        assert!(bytes.windows(name.len()).any(|window| window == name.as_bytes()), "{name}");
    }
    let stats: Value = serde_json::from_slice(&fs::read(folder.0.join("a.stats.json")).unwrap()).unwrap();
    let diagnostics = &stats["diagnostics"];
    assert_eq!(diagnostics["quantities"].as_array().unwrap().len(), 3);
    assert!(diagnostics["longest_stay"].as_u64().unwrap() > 0 && diagnostics["warnings"].is_array());
}

/// A triangle that nothing lights, as a glTF file.
const UNLIT: &str = r#"{
    "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}],
    "buffers": [{"byteLength": 36, "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]
}"#;

/// A map of 8 x 4 pixels of radiance 1.
fn even_map() -> Vec<u8> {
    let mut file = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n".to_vec();
    file.extend([128, 128, 128, 129].repeat(32));
    file
}

#[test]
fn an_environment_lights_a_scene_that_has_no_light() {
    let folder = Folder::new("environment");
    folder.write("unlit.gltf", UNLIT);
    fs::create_dir(folder.0.join("skies")).unwrap();
    fs::write(folder.0.join("skies/even.hdr"), even_map()).unwrap();
    // The map's path is relative to the config.
    folder.write("skies/my.ron", "(scene: \"../unlit.gltf\", environment: Map(file: \"even.hdr\", strength: 2))");
    let mean = |stem: &str, arguments: &[&str]| {
        let mut all = vec!["render", "-o", stem];
        all.extend(QUICK);
        all.extend(arguments);
        let output = folder.run(&all);
        assert!(output.status.success(), "{}", text(&output.stderr));
        assert!(!text(&output.stderr).contains("warning"), "{}", text(&output.stderr));
        read_image(&folder.0.join(format!("{stem}.exr"))).expect("the picture is there").mean()[1]
    };
    let once = mean("once", &["unlit.gltf", "--environment", "skies/even.hdr"]);
    assert!((0.5..1.01).contains(&once), "nothing reflects more than it gets: {once}");
    let constant = mean("constant", &["unlit.gltf", "--set", "environment=Constant(1, 1, 1)"]);
    assert!((constant / once - 1.0).abs() < 0.03, "{constant} {once}");
    let twice = mean("twice", &["--config", "skies/my.ron"]);
    assert!((twice / once - 2.0).abs() < 0.06, "{twice} {once}");
    let set = ["unlit.gltf", "--environment", "skies/even.hdr", "--set", "environment.strength=2"];
    assert_eq!(twice, mean("set", &set));
    let without = folder.run(&["render", "unlit.gltf"]);
    assert!(!without.status.success() && text(&without.stderr).contains("give an environment"));
    let missing = folder.run(&["render", "unlit.gltf", "--environment", "none.hdr"]);
    assert!(!missing.status.success() && text(&missing.stderr).contains("none.hdr: cannot be read"));
    let told = text(&folder.run(&["inspect", "unlit.gltf", "--environment", "skies/even.hdr"]).stdout);
    assert!(told.contains("environment, 8 x 4 texels") && told.contains("mean [1.0000, 1.0000, 1.0000]"), "{told}");
}

/// The same triangle under a cube of six white pixels.
fn self_lit() -> String {
    let white = "data:image/png;base64,\
                 iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR42mP4//8/AAX+Av4zEpUUAAAAAElFTkSuQmCC";
    let light = r#"{"intensity": 1, "specularImageSize": 1, "specularImages": [[0, 0, 0, 0, 0, 0]]}"#;
    let used = format!(
        r#""extensionsUsed": ["EXT_lights_image_based"], "images": [{{"uri": "{white}"}}],
           "extensions": {{"EXT_lights_image_based": {{"lights": [{light}]}}}}, "scenes": [{{
           "extensions": {{"EXT_lights_image_based": {{"light": 0}}}}, "#
    );
    UNLIT.replace(r#""scenes": [{"#, &used)
}

#[test]
fn an_environment_of_the_settings_goes_before_that_of_the_file() {
    let folder = Folder::new("own-environment");
    folder.write("self-lit.gltf", &self_lit());
    let render = |stem: &str, set: &[&str]| {
        let mut all = vec!["render", "self-lit.gltf", "-o", stem];
        all.extend(QUICK);
        all.extend(set);
        let output = folder.run(&all);
        let said = text(&output.stderr);
        assert!(output.status.success() && !said.contains("warning"), "{said}");
        let mean = read_image(&folder.0.join(format!("{stem}.exr"))).expect("the picture is there").mean()[1];
        (mean, format!("{said}{}", text(&output.stdout)).contains("that of self-lit.gltf (EXT_lights_image_based)"))
    };
    let (own, said) = render("own", &[]);
    assert!((0.5..1.01).contains(&own) && !said, "{own}");
    let (given, said) = render("given", &["--set", "environment=Constant(4, 4, 4)"]);
    assert!((given / own - 4.0).abs() < 0.1 && said, "{given} {own}");
    let told = text(&folder.run(&["inspect", "self-lit.gltf"]).stdout);
    assert!(told.contains("environment, 4 x 2 texels") && told.contains("mean [1.0000, 1.0000, 1.0000]"), "{told}");
}
