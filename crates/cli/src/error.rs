//! Errors as the user sees them.

use ergodic_assess::FileError;
use ergodic_assets::{AssetError, CameraError};
use ergodic_render::RenderError;
use miette::{Diagnostic, GraphicalReportHandler, GraphicalTheme, NamedSource, SourceSpan};
use thiserror::Error;

/// Why the command failed.
#[derive(Debug, Error)]
pub enum CliError {
    /// Said in one paragraph.
    #[error("{0}")]
    Said(String),
    /// Wrong settings.
    #[error(transparent)]
    Settings(Box<SettingsError>),
}

/// Wrong settings, shown in their text.
#[derive(Debug, Error, Diagnostic)]
#[error("{title}")]
pub struct SettingsError {
    /// What is wrong, with file, line and column.
    pub title: String,
    /// The text.
    #[source_code]
    pub text: NamedSource<String>,
    /// Where in it.
    #[label("here")]
    pub at: SourceSpan,
    /// What to do.
    #[help]
    pub help: String,
}

impl CliError {
    /// The text to print.
    pub fn report(&self) -> String {
        match self {
            Self::Said(text) => format!("error: {text}\n"),
            Self::Settings(error) => {
                let handler = GraphicalReportHandler::new_themed(GraphicalTheme::unicode_nocolor()).with_width(100);
                let mut text = String::from("error: ");
                match handler.render_report(&mut text, error.as_ref()) {
                    Ok(()) => text,
                    Err(_) => format!("error: {self}\n"),
                }
            }
        }
    }
}

macro_rules! said {
    ($($error:ty),+) => {
        $(impl From<$error> for CliError {
            fn from(error: $error) -> Self {
                Self::Said(error.to_string())
            }
        })+
    };
}

said!(AssetError, CameraError, FileError, RenderError);
