//! Measures where the time of mutations goes and prints it as JSON. `cargo xtask profile` runs it, once built with the feature
//! `record` and once with `phases`, and shows the result.

#[cfg(feature = "phases")]
mod phases;
#[cfg(feature = "record")]
mod rays;
#[cfg(any(feature = "record", feature = "phases"))]
mod work;

use std::process::ExitCode;

#[cfg(any(feature = "record", feature = "phases"))]
fn measure() -> Result<serde_json::Value, String> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [file, seconds] = &arguments[..] else {
        return Err("usage: ergodic-profile SCENE.glb SECONDS; better, run `cargo xtask profile SCENE`".into());
    };
    let seconds: f64 = seconds.parse().map_err(|_| format!("SECONDS is `{seconds}`; it must be a number"))?;
    work::load(file.as_ref())?.within(Measure { seconds }).map_err(|e| format!("{file}: {e}"))
}

/// Measures in the scene's repertoire, as a render does.
#[cfg(any(feature = "record", feature = "phases"))]
struct Measure {
    seconds: f64,
}

#[cfg(any(feature = "record", feature = "phases"))]
impl ergodic_pathspace::Within for Measure {
    type Output = Result<serde_json::Value, String>;

    fn run<R: ergodic_scattering::Repertoire>(self, scene: &ergodic_pathspace::Scene<R>) -> Self::Output {
        let work = work::Work::new(scene)?;
        #[cfg(feature = "record")]
        let report = rays::measure(&work, self.seconds);
        #[cfg(not(feature = "record"))]
        let report = phases::measure(&work, self.seconds);
        Ok(report)
    }
}

#[cfg(not(any(feature = "record", feature = "phases")))]
fn measure() -> Result<serde_json::Value, String> {
    Err("built without the features `record` and `phases` there is nothing to measure; run `cargo xtask profile SCENE`"
        .into())
}

fn main() -> ExitCode {
    match measure() {
        Ok(report) => {
            println!("{report}");
            ExitCode::SUCCESS
        }
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::from(2)
        }
    }
}
