//! A picture drawn by a Markov chain that knows its brightness only point by point, and up to a constant.
//!
//! `cargo run --release -p ergodic-metropolis --example picture [-- picture.pgm]`

use std::f64::consts::PI;
use std::io::Write;

use ergodic_metropolis::diagnostics::{BatchMeans, Runs};
use ergodic_metropolis::{Chain, Mixture, MixtureError, Mutation, RandomSource, Step, Target};
use rand_pcg::Pcg64;

/// Where the chain is: a point of the unit square, y upward.
type Point = [f64; 2];

/// The picture: a sun with rays over hills, and a moon that no small step can find. In units nobody needs to know.
struct Landscape;

impl Landscape {
    fn brightness([x, y]: Point) -> f64 {
        let (dx, dy) = (x - 0.32, y - 0.66);
        let (radius, angle) = (dx.hypot(dy), dy.atan2(dx));
        let sky = 0.06 + 0.12 * y;
        let disc = if radius < 0.11 { 6.0 } else { 0.0 };
        let rays = (8.0 * angle).cos().max(0.0) * 2.0 * (-(radius - 0.11) / 0.09).exp();
        let moon = if (x - 0.85).hypot(y - 0.84) < 0.05 && (x - 0.87).hypot(y - 0.855) > 0.04 { 9.0 } else { 0.0 };
        let near = 0.20 + 0.07 * (2.0 * PI * (1.3 * x + 0.1)).sin();
        let far = 0.36 + 0.05 * (2.0 * PI * (2.1 * x + 0.55)).sin();
        if y < near {
            0.15 + 0.3 * y
        } else if y < far {
            0.45 + 1.2 * (y - near)
        } else {
            sky + disc + if radius > 0.11 { rays } else { 0.0 } + moon
        }
    }
}

impl Target for Landscape {
    type State = Point;
    type Value = f64;

    fn evaluate(&self, x: &Point) -> f64 {
        Self::brightness(*x)
    }

    fn ln_density(value: &f64) -> f64 {
        value.ln()
    }
}

/// The ways to move.
#[derive(Clone, Copy, Debug)]
enum Move {
    /// To a point anywhere in the square: finds what lies apart.
    Large,
    /// By at most `reach` in x and in y: explores what has been found.
    Small { reach: f64 },
}

/// The candidate lies outside the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Outside;

impl Mutation for Move {
    type Space = ();
    type State = Point;
    type Plan = ();
    type Failure = Outside;

    fn propose(&self, (): &(), x: &Point, y: &mut Point, rng: &mut impl RandomSource) -> Result<(), Outside> {
        *y = match self {
            Self::Large => [rng.uniform(), rng.uniform()],
            Self::Small { reach } => x.map(|v| v + reach * (2.0 * rng.uniform() - 1.0)),
        };
        if y.iter().all(|v| (0.0..1.0).contains(v)) { Ok(()) } else { Err(Outside) }
    }

    fn ln_density(&self, (): &(), _: &Point, _: &Point, (): ()) -> f64 {
        match self {
            Self::Large => 0.0,
            Self::Small { reach } => -2.0 * (2.0 * reach).ln(),
        }
    }
}

const COLUMNS: usize = 96;
const ROWS: usize = 48;
/// Densities are shown against this multiple of the mean.
const WHITE: f64 = 4.0;

/// A picture of brightness relative to the mean.
struct Picture(Vec<f64>);

impl Picture {
    /// The truth: the mean brightness of each pixel, over the mean of all.
    fn truth() -> Self {
        const STEPS: usize = 32;
        let mean = |column: usize, line: usize| {
            let sub = |i: usize, k: usize, n: usize| (i as f64 + (k as f64 + 0.5) / STEPS as f64) / n as f64;
            let points = (0..STEPS * STEPS).map(|k| [sub(column, k % STEPS, COLUMNS), sub(line, k / STEPS, ROWS)]);
            points.map(Landscape::brightness).sum::<f64>()
        };
        let pixels: Vec<f64> = (0..COLUMNS * ROWS).map(|i| mean(i % COLUMNS, i / COLUMNS)).collect();
        Self::normalised(&pixels)
    }

    fn normalised(pixels: &[f64]) -> Self {
        let mean = pixels.iter().sum::<f64>() / pixels.len() as f64;
        Self(pixels.iter().map(|v| v / mean).collect())
    }

    fn error(&self, truth: &Self) -> f64 {
        let squares: f64 = self.0.iter().zip(&truth.0).map(|(a, b)| (a - b).powi(2)).sum();
        (squares / self.0.len() as f64).sqrt()
    }

    /// Lines from the top, each pixel in `0..=1` with the display's curve.
    fn lines(&self) -> impl Iterator<Item = impl Iterator<Item = f64>> {
        self.0.chunks(COLUMNS).rev().map(|line| line.iter().map(|v| (v / WHITE).clamp(0.0, 1.0).powf(1.0 / 2.2)))
    }

    fn print(&self) {
        const INK: &[u8] = b" .:-=+*#%@";
        for line in self.lines() {
            let text: String = line.map(|v| char::from(INK[((v * 9.0).round() as usize).min(9)])).collect();
            println!("    {}", text.trim_end());
        }
    }

    fn write_pgm(&self, path: &str) -> std::io::Result<()> {
        let mut file = std::io::BufWriter::new(std::fs::File::create(path)?);
        write!(file, "P5\n{COLUMNS} {ROWS}\n255\n")?;
        for line in self.lines() {
            let bytes: Vec<u8> = line.map(|v| (v * 255.0).round() as u8).collect();
            file.write_all(&bytes)?;
        }
        file.flush()
    }
}

fn pixel([x, y]: Point) -> usize {
    let index = |v: f64, n: usize| ((v * n as f64) as usize).min(n - 1);
    index(y, ROWS) * COLUMNS + index(x, COLUMNS)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let truth = Picture::truth();
    println!("The truth, {COLUMNS} x {ROWS} pixels:\n");
    truth.print();
    let drawn = draw(&truth, 1 << 24)?;
    println!("\nWhat the chain drew:\n");
    drawn.print();
    if let Some(path) = std::env::args().nth(1) {
        drawn.write_pgm(&path)?;
        println!("\nWritten to {path}.");
    }
    Ok(())
}

/// Draws by a chain of `steps` steps, a tenth of them large, and prints how the error falls on the way.
fn draw(truth: &Picture, steps: u64) -> Result<Picture, MixtureError> {
    let moves = Mixture::new(vec![(0.1, Move::Large), (0.9, Move::Small { reach: 0.03 })])?;
    let mut rng = Pcg64::new(1953, 1);
    let mut chain = Chain::new([0.5, 0.5], &Landscape);
    let mut pixels = vec![0.0; COLUMNS * ROWS];
    let (mut runs, mut height) = (Runs::new(), BatchMeans::new(256));
    let mut points: Vec<(f64, f64)> = Vec::new();

    println!("\nThe chain, with the root mean square error of its picture (mean brightness 1):\n");
    println!("    steps        error        accepted   longest stay   autocorrelation of height");
    for step in 1..=steps {
        let outcome = chain.step(&Landscape, &moves, &(), &mut rng);
        runs.add(&outcome);
        // Both ends are drawn, each by its probability: the coin that was tossed is only noise.
        let stays = match outcome {
            Step::Tried { acceptance, accepted, .. } => {
                let (from, to) =
                    if accepted { (chain.other(), chain.current()) } else { (chain.current(), chain.other()) };
                pixels[pixel(*to.0)] += acceptance;
                pixels[pixel(*from.0)] += 1.0 - acceptance;
                false
            }
            Step::NotProposed(_) | Step::Faulty { .. } => true,
        };
        let here = *chain.current().0;
        if stays {
            pixels[pixel(here)] += 1.0;
        }
        height.add(here[1]);
        if step.is_power_of_two() && step >= 1 << 12 && step.ilog2() % 2 == 0 {
            let error = Picture::normalised(&pixels).error(truth);
            let rate = runs.accepted() as f64 / runs.steps() as f64;
            let time = height.autocorrelation_time().map_or("-".into(), |t| format!("{t:.1} steps"));
            println!("    {step:<10}   {error:<10.4}   {rate:<8.3}   {:<12}   {time}", runs.longest());
            points.push(((step as f64).ln(), error.ln()));
        }
    }
    println!("\nThe error falls as steps^{:.3}; independent samples make it -0.5.", slope(&points));
    Ok(Picture::normalised(&pixels))
}

/// Slope of the least-squares line.
fn slope(points: &[(f64, f64)]) -> f64 {
    let n = points.len() as f64;
    let (mx, my) = (points.iter().map(|p| p.0).sum::<f64>() / n, points.iter().map(|p| p.1).sum::<f64>() / n);
    let (cov, var) =
        points.iter().fold((0.0, 0.0), |(cov, var), (x, y)| (cov + (x - mx) * (y - my), var + (x - mx).powi(2)));
    cov / var
}
