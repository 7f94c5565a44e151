//! Chores of the project: the scenes, written from code so that every number in them has a source; the stored references;
//! the long tests; profiles; the price of precision; pictures of many files.

mod contact_sheet;
mod glb;
mod nightly;
mod precision;
mod profile;
mod reference;
mod scenes;
mod shapes;
mod sheet;
mod sky;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

const USAGE: &str = "\
Usage: cargo xtask <command>

Commands:
  scenes [NAME...]      write scenes/NAME/scene.glb and its sky, for all scenes if none is named
  profile SCENE         where the time of mutations goes on a scene; `profile --help` says how it is measured
  contact-sheet PATH... one picture of all glTF files below some folders; `contact-sheet --help` lists the options
  precision             measure what accuracy costs and gains, and write docs/precision.md: some minutes
  nightly               run all tests at their large sizes, then `ergodic verify --budget full`: some hours
  reference [NAME...]   render reference/NAME.exr with its provenance NAME.ron, for all scenes if none is named
";

/// The project's own folder.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn scenes_folder() -> PathBuf {
    root().join("scenes")
}

/// The file of a scene's environment in its folder.
const SKY: &str = "sky.hdr";

/// The scenes that are named, all if none is.
fn chosen(names: &[String]) -> Result<Vec<&'static scenes::Recipe>, String> {
    if let Some(unknown) = names.iter().find(|name| scenes::ALL.iter().all(|recipe| recipe.name != **name)) {
        let known = scenes::ALL.iter().map(|recipe| recipe.name).collect::<Vec<_>>().join(", ");
        return Err(format!("there is no scene `{unknown}`; the scenes are {known}"));
    }
    Ok(scenes::ALL.iter().filter(|recipe| names.is_empty() || names.iter().any(|n| n == recipe.name)).collect())
}

fn write_scenes(names: &[String]) -> Result<(), String> {
    for recipe in chosen(names)? {
        let folder = scenes_folder().join(recipe.name);
        let file = folder.join("scene.glb");
        let bytes = (recipe.make)().to_glb();
        std::fs::create_dir_all(&folder)
            .and_then(|()| std::fs::write(&file, &bytes))
            .map_err(|e| format!("cannot write {}: {e}", file.display()))?;
        println!("{:8} {:8} bytes  {}", recipe.name, bytes.len(), recipe.about);
        if let Some(sky) = recipe.sky {
            let file = folder.join(SKY);
            let bytes = sky().to_hdr();
            std::fs::write(&file, &bytes).map_err(|e| format!("cannot write {}: {e}", file.display()))?;
            println!("{:8} {:8} bytes  its sky", "", bytes.len());
        }
    }
    Ok(())
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let result = match arguments.split_first() {
        Some((command, names)) if command == "scenes" => write_scenes(names),
        Some((command, names)) if command == "reference" => reference::write(names),
        Some((command, arguments)) if command == "contact-sheet" => contact_sheet::run(arguments),
        Some((command, arguments)) if command == "profile" => profile::run(arguments),
        Some((command, arguments)) if command == "precision" => precision::run(arguments),
        Some((command, [])) if command == "nightly" => nightly::run(),
        Some((help, _)) if help == "--help" || help == "help" => {
            print!("{USAGE}");
            Ok(())
        }
        Some((command, _)) => Err(format!("there is no command `{command}`\n\n{USAGE}")),
        None => Err(USAGE.to_string()),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::from(2)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stored_scenes_are_what_the_code_makes() {
        for recipe in &scenes::ALL {
            let file = scenes_folder().join(recipe.name).join("scene.glb");
            let stored = std::fs::read(&file).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
            assert!(stored == (recipe.make)().to_glb(), "{}: run `cargo xtask scenes`", recipe.name);
            let file = scenes_folder().join(recipe.name).join(SKY);
            match recipe.sky {
                Some(sky) => {
                    let stored = std::fs::read(&file).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
                    assert!(stored == sky().to_hdr(), "{}: run `cargo xtask scenes`", recipe.name);
                }
                None => assert!(!file.exists(), "{} has a sky that no code makes", recipe.name),
            }
        }
    }

    #[test]
    fn the_scenes_are_valid_gltf() {
        for recipe in &scenes::ALL {
            let bytes = (recipe.make)().to_glb();
            let document = gltf::Gltf::from_slice(&bytes).unwrap_or_else(|e| panic!("{}: {e}", recipe.name));
            assert_eq!(document.cameras().count(), 1);
            assert!(document.materials().any(|m| m.emissive_factor() != [0.0; 3]), "{}: no lamp", recipe.name);
        }
    }
}
