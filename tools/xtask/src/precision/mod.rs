//! `cargo xtask precision`: what is done for accuracy, what it costs and what it gains, measured and written to a page.
//!
//! Everything is measured in pairs that take turns, in processor time of one thread, so that a machine that gets slower does so for
//! both. Every interval is of 95 %, from the bootstrap over rounds or replicas.

mod bias;
mod chains;
mod direct;
mod kernels;
mod leaks;
mod numbers;
mod page;
mod seeding;
mod splatting;
mod work;

use std::path::PathBuf;
use std::time::Instant;

use page::Section;

/// What `cargo xtask precision --help` prints.
const HELP: &str = "\
Usage: cargo xtask precision [--quick] [--output FILE] [NAME...]

Measures what is done for accuracy, what it costs and what it gains, and writes docs/precision.md. NAME is a part of it, for
printing that part alone and writing nothing:

numbers     f64 against f32 in the hot functions: time, and the error of f32
leaks       the watertight intersection test against a plain one: time, and rays that slip through a closed mesh
splatting   expected values against plain splatting: time and variance
seeding     samples that b is estimated from: time and error
direct      direct light sampled apart against in the chains: time and error
bias        number of chains at equal mutations: start-up bias and spread

--quick     budgets so small that the figures mean nothing, to see that everything works; needs --output or a NAME
--output    where to write the page instead
";

/// How much is measured.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// Rounds of each pair of timings.
    rounds: usize,
    /// Rays through edges for each row of the table of leaks.
    rays: usize,
    /// Replicas of small renders.
    replicas: usize,
    /// Pairs of whole renders for each scene.
    pairs: usize,
    /// What numbers of samples and mutations are divided by.
    divisor: u64,
}

const FULL: Effort = Effort { rounds: 40, rays: 10_000_000, replicas: 24, pairs: 8, divisor: 1 };
const QUICK: Effort = Effort { rounds: 3, rays: 2000, replicas: 3, pairs: 2, divisor: 16 };

type Measure = fn(&Effort) -> Result<Section, String>;

/// The parts of the page, in order.
const PARTS: [(&str, Measure); 6] = [
    ("numbers", numbers::measure),
    ("leaks", leaks::measure),
    ("splatting", splatting::measure),
    ("seeding", seeding::measure),
    ("direct", direct::measure),
    ("bias", bias::measure),
];

struct Options {
    effort: Effort,
    output: Option<PathBuf>,
    names: Vec<String>,
}

impl Options {
    fn read(arguments: &[String]) -> Result<Self, String> {
        let (mut quick, mut output, mut names) = (false, None, Vec::new());
        let mut rest = arguments.iter();
        while let Some(argument) = rest.next() {
            match argument.as_str() {
                "--quick" => quick = true,
                "--output" => output = Some(PathBuf::from(rest.next().ok_or("--output needs a file")?)),
                name if PARTS.iter().any(|(part, _)| *part == name) => names.push(name.to_string()),
                other => return Err(format!("`{other}` is not understood; see `cargo xtask precision --help`")),
            }
        }
        if quick && output.is_none() && names.is_empty() {
            return Err("--quick would write figures that mean nothing to docs/precision.md; give --output FILE".into());
        }
        Ok(Self { effort: if quick { QUICK } else { FULL }, output, names })
    }
}

/// Measures and writes the page, or prints parts of it.
pub fn run(arguments: &[String]) -> Result<(), String> {
    if arguments.iter().any(|argument| argument == "--help") {
        print!("{HELP}");
        return Ok(());
    }
    let options = Options::read(arguments)?;
    let start = Instant::now();
    let mut sections = Vec::new();
    for (name, measure) in PARTS {
        if options.names.is_empty() || options.names.iter().any(|wanted| wanted == name) {
            eprintln!("{name}");
            sections.push(measure(&options.effort)?);
        }
    }
    if !options.names.is_empty() && options.output.is_none() {
        sections.iter().for_each(|section| println!("{}", section.text()));
        return Ok(());
    }
    let file = options.output.unwrap_or_else(|| crate::root().join("docs/precision.md"));
    let text = page::text(&sections, start.elapsed().as_secs_f64());
    std::fs::write(&file, text).map_err(|e| format!("cannot write {}: {e}", file.display()))?;
    eprintln!("wrote {}", file.display());
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_can_be_made_and_has_a_number_in_every_cell() {
        let file = std::env::temp_dir().join(format!("ergodic-precision-{}.md", std::process::id()));
        run(&["--quick".into(), "--output".into(), file.display().to_string()]).unwrap();
        let text = std::fs::read_to_string(&file).unwrap();
        std::fs::remove_file(&file).unwrap();
        for (i, title) in
            ["f64 against f32", "Watertight", "Expected values", "Seeding", "Direct light", "chains"].iter().enumerate()
        {
            let heads: Vec<&str> = text.lines().filter(|line| line.starts_with("## ")).collect();
            assert!(heads.len() == 6 && heads[i].contains(title), "{heads:?}");
        }
        assert!(text.lines().filter(|line| line.starts_with('|')).count() > 30, "{text}");
        assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
        // Figures come with an interval.
        assert!(text.matches(" to ").count() > 40, "{text}");
    }

    #[test]
    fn figures_that_mean_nothing_do_not_replace_the_page() {
        assert!(run(&["--quick".into()]).unwrap_err().contains("--output"));
        assert!(run(&["magic".into()]).unwrap_err().contains("--help"));
    }
}
