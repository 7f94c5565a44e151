//! Settings from a RON file and from `--set`.

use std::path::{Path, PathBuf};

use ergodic_render::{EnvironmentSettings, Settings};
use miette::{NamedSource, SourceSpan};
use ron::Options;
use ron::error::{Position, SpannedError};
use ron::extensions::Extensions;
use ron::ser::PrettyConfig;

use crate::error::{CliError, SettingsError};
use crate::override_path::{PathError, value_span};

/// The default config with every setting explained. A test holds it to [`Settings::default`].
pub const TEMPLATE: &str = include_str!("default.ron");

fn extensions() -> Extensions {
    Extensions::UNWRAP_VARIANT_NEWTYPES | Extensions::IMPLICIT_SOME | Extensions::UNWRAP_NEWTYPES
}

fn parse(text: &str) -> Result<Settings, SpannedError> {
    Options::default().with_default_extension(extensions()).from_str(text)
}

/// Settings as RON, as configs are written.
pub fn to_ron(settings: &Settings) -> String {
    let pretty = PrettyConfig::default().compact_arrays(true).extensions(Extensions::empty());
    let options = Options::default().with_default_extension(extensions());
    options.to_string_pretty(settings, pretty).unwrap_or_default()
}

/// The byte at a line and column, both from 1; columns count characters.
fn offset(text: &str, position: Position) -> usize {
    let line_start: usize = text.split_inclusive('\n').take(position.line.saturating_sub(1)).map(str::len).sum();
    let rest = &text[line_start..];
    rest.char_indices().nth(position.col.saturating_sub(1)).map_or(text.len(), |(i, _)| line_start + i)
}

/// What to do about what is wrong at a byte of a config.
fn mend(text: &str, at: usize) -> String {
    let in_some = text[..at].trim_end().ends_with("Some(");
    let first = if in_some { "write the value alone, without `Some(...)`; " } else { "" };
    format!("{first}`ergodic config` prints every setting with what it means")
}

fn error_in(name: &str, text: &str, error: &SpannedError) -> CliError {
    let (start, end) = (offset(text, error.span.start), offset(text, error.span.end));
    let Position { line, col } = error.span.start;
    CliError::Settings(Box::new(SettingsError {
        title: format!("{name}, line {line}, column {col}: {}", error.code),
        text: NamedSource::new(name, text.to_string()),
        at: SourceSpan::from((start, end.saturating_sub(start).max(1))),
        help: mend(text, start),
    }))
}

/// Reads a config; the files that it names come back relative to the current folder.
pub fn load(path: &Path) -> Result<Settings, CliError> {
    let name = path.display().to_string();
    let text = std::fs::read_to_string(path).map_err(|e| {
        CliError::Said(format!("{name} cannot be read: {e}. `ergodic config > my.ron` makes a config to start from"))
    })?;
    let mut settings = parse(&text).map_err(|e| error_in(&name, &text, &e))?;
    let make_relative = |file: &mut String| {
        if !file.is_empty() {
            let beside: PathBuf = path.parent().unwrap_or(Path::new("")).join(&file);
            *file = beside.display().to_string();
        }
    };
    make_relative(&mut settings.scene);
    if let Some(EnvironmentSettings::Map(map)) = &mut settings.environment {
        make_relative(&mut map.file);
    }
    settings.validate().map_err(|what| CliError::Said(format!("{name}: {what}")))?;
    Ok(settings)
}

/// Applies `path=value`, where the value is RON.
pub fn set(settings: &Settings, assignment: &str) -> Result<Settings, CliError> {
    let Some((path, value)) = assignment.split_once('=') else {
        let text = format!("--set {assignment}: give a setting and its value, like --set mlt.chains=1000");
        return Err(CliError::Said(text));
    };
    let (path, value) = (path.trim(), value.trim());
    let text = to_ron(settings);
    let span = value_span(&text, path).map_err(|PathError { part, known }| {
        let known = if known.is_empty() { "it has no parts".into() } else { format!("there are {}", known.join(", ")) };
        CliError::Said(format!("--set {path}: there is no setting {part:?}; {known}"))
    })?;
    // A bare word where text is wanted: shells eat quotes.
    let quoted = text[span.clone()].starts_with('"') && !value.starts_with('"');
    let value = if quoted { format!("{value:?}") } else { value.to_string() };
    let changed = format!("{}{value}{}", &text[..span.start], &text[span.end..]);
    let settings = parse(&changed)
        .map_err(|e| CliError::Said(format!("--set {path}: {value} is not a value of this setting: {}", e.code)))?;
    settings.validate().map_err(|what| CliError::Said(format!("--set {path}: {what}")))?;
    Ok(settings)
}

#[cfg(test)]
mod tests {
    use ergodic_render::{Budget, EnvironmentMap, FilterSettings};

    use super::*;

    #[test]
    fn the_template_is_the_default() {
        assert_eq!(parse(TEMPLATE).unwrap_or_else(|e| panic!("{e}")), Settings::default());
    }

    /// What the template gives as examples of settings that are None by default can be set so.
    #[test]
    fn the_examples_of_the_template_are_values() {
        let comments: String = TEMPLATE.lines().map(|line| line.trim().trim_start_matches("//")).collect();
        let examples = [
            ("medium", "(scattering: (0.1, 0.1, 0.1), absorption: (0.0, 0.0, 0.0), anisotropy: 0.0)"),
            ("lens", "(radius: 0.02, focus_distance: 1.5, blades: 6, rotation: 0.0)"),
            ("environment", "Constant(1.0, 1.0, 1.0)"),
            ("environment", "Map(file: \"sky.hdr\", rotation: 0.0, strength: 1.0)"),
        ];
        for (setting, example) in examples {
            assert!(comments.contains(example), "the template no longer says {example}");
            let changed =
                set(&Settings::default(), &format!("{setting}={example}")).unwrap_or_else(|e| panic!("{e:?}"));
            assert_ne!(changed, Settings::default());
        }
    }

    #[test]
    fn the_template_explains_every_setting() {
        // Every field that the default has, written out, is a line of the template.
        for line in to_ron(&Settings::default()).lines() {
            if let Some((field, _)) = line.trim().split_once(':') {
                assert!(TEMPLATE.contains(&format!("{field}:")), "{field} is not explained");
            }
        }
    }

    #[test]
    fn a_value_in_some_is_told_to_stand_alone() {
        let help = |text: &str| match error_in("x.ron", text, &parse(text).expect_err("not a config")) {
            CliError::Settings(error) => error.help,
            other => panic!("{other:?}"),
        };
        assert!(help("(lens: Some((radius: 0.01, focus_distance: 1.0)))").starts_with("write the value alone"));
        assert!(help("(environment: Some(\n  (1.0, 1.0, 1.0)))").starts_with("write the value alone"));
        assert!(help("(lens: (radios: 0.01))").starts_with("`ergodic config`"));
    }

    #[test]
    fn settings_survive_being_written() {
        let settings = Settings { filter: FilterSettings::Gaussian { radius: 2.0, sigma: 0.5 }, ..Settings::default() };
        assert_eq!(parse(&to_ron(&settings)).unwrap(), settings);
    }

    #[test]
    fn single_settings_can_be_changed() {
        let defaults = Settings::default();
        let changed = set(&defaults, "mlt.chains=7").unwrap();
        assert_eq!((changed.mlt.chains, changed.size), (7, defaults.size));
        assert_eq!(set(&defaults, "budget=Seconds(2.5)").unwrap().budget, Budget::Seconds(2.5));
        assert_eq!(set(&defaults, "size=(3, 4)").unwrap().size, (3, 4));
        assert_eq!(set(&defaults, "size.1=4").unwrap().size, (defaults.size.0, 4));
        let constant = set(&defaults, "environment=Constant(1, 0.5, 2)").unwrap();
        assert_eq!(constant.environment, Some(EnvironmentSettings::Constant(1.0, 0.5, 2.0)));
        let map = set(&constant, "environment=Map(file: \"sky.hdr\", rotation: 90)").unwrap();
        let map = set(&set(&map, "environment.strength=2").unwrap(), "environment.file=dusk.exr").unwrap();
        let wanted = EnvironmentMap { file: "dusk.exr".into(), rotation: 90.0, strength: 2.0 };
        assert_eq!(map.environment, Some(EnvironmentSettings::Map(wanted)));
        assert_eq!(parse(&to_ron(&map)).unwrap(), map);
        assert_eq!(
            parse("(environment: Some(Map(file: \"dusk.exr\", rotation: 90, strength: 2)))").unwrap().environment,
            map.environment
        );
        assert_eq!(set(&map, "environment=None").unwrap().environment, None);
        assert_eq!(set(&defaults, "camera=left eye").unwrap().camera, "left eye");
        assert_eq!(set(&defaults, "mlt.mutations.1.0=3.5").unwrap().mlt.mutations[1].0, 3.5);
        let lens = set(&defaults, "mlt.mutations.1.1.min_pixels=0.25").unwrap();
        assert_ne!(lens.mlt.mutations[1], defaults.mlt.mutations[1]);
        let one = set(&defaults, "mlt.mutations=[(1.0, Bidirectional())]").unwrap();
        assert_eq!(one.mlt.mutations.len(), 1);
        let gaussian = set(&defaults, "filter=Gaussian(radius: 2, sigma: 0.5)").unwrap();
        assert_eq!(
            set(&gaussian, "filter.sigma=0.25").unwrap().filter,
            FilterSettings::Gaussian { radius: 2.0, sigma: 0.25 }
        );
    }

    #[test]
    fn wrong_settings_name_what_is_allowed() {
        let defaults = Settings::default();
        let said = |assignment: &str| set(&defaults, assignment).unwrap_err().report();
        assert!(said("mlt.chans=7").contains("there is no setting \"chans\"; there are mutations, chains"));
        assert!(said("mlt.chains=many").contains("--set mlt.chains"));
        assert!(said("mlt.chains=0").contains("from 1 to"));
        assert!(said("method=metropolis").contains("bidirectional"));
        assert!(said("environment=Constant(-1, 0, 0)").contains("not negative"));
        assert!(said("environment=Map(rotation: 3)").contains("has no file"));
        assert!(said("environment=Map(file: \"a.hdr\", strength: 0)").contains("environment.strength"));
        assert!(said("seed").contains("like --set"));
        assert!(said("seed.deeper=1").contains("no parts"));
    }

    #[test]
    fn a_broken_config_is_shown_with_its_place() {
        let text = "(\n    method: mlt,\n    mlt: (chans: 3),\n)\n";
        let report = error_in("my.ron", text, &parse(text).unwrap_err()).report();
        for part in ["my.ron, line 3, column 11", "chans", "`chains`", "mlt: (chans: 3)"] {
            assert!(report.contains(part), "{part} is not in\n{report}");
        }
    }
}
