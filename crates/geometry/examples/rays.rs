//! Makes a scene and rays, writes them to a folder, and times them on request, for comparisons with other ray tracers:
//!
//! ```sh
//! cargo run --release -p ergodic-geometry --example rays -- TRIANGLES RAYS FOLDER
//! ```
//!
//! Writes `vertices` (f32, three each), `triangles` (i32, three each) and, for every query and kind of rays,
//! `QUERY.KIND.origins` and `QUERY.KIND.directions` (f32, three each). `closest` has unit directions; `any` asks whether something
//! lies between origin and origin + direction. Then it prints a line of facts and reads commands, one a line, each with one line
//! for an answer:
//!
//! - `time QUERY KIND`: traces all rays in one thread; the seconds of processor time that took;
//! - `answers QUERY KIND`: writes `QUERY.KIND.answers`, an f32 for each ray: for `closest` the distance or infinity, for `any`
//!   1 if blocked, else 0.

#[path = "../benches/generated/mod.rs"]
mod generated;

use std::collections::BTreeMap;
use std::error::Error;
use std::fs;
use std::hint::black_box;
use std::io::{BufRead, Write};
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use cpu_time::ThreadTime;
use ergodic_geometry::{Anchor, Ray, World};
use glam::DVec3;

const USAGE: &str = "usage: rays TRIANGLES RAYS FOLDER";

/// What is traced.
enum Query {
    Closest(Vec<Ray>),
    Any(Vec<[Anchor; 2]>),
}

impl Query {
    /// Seconds of processor time of this thread for all rays. Wall time would count what other programs do.
    fn time(&self, world: &World) -> f64 {
        let start = ThreadTime::now();
        match self {
            Self::Closest(rays) => rays.iter().for_each(|ray| {
                black_box(world.intersect(ray));
            }),
            Self::Any(segments) => segments.iter().for_each(|[a, b]| {
                black_box(world.visible(a, b));
            }),
        }
        start.elapsed().as_secs_f64()
    }

    fn answers(&self, world: &World) -> Vec<f32> {
        match self {
            Self::Closest(rays) => {
                rays.iter().map(|ray| world.intersect(ray).map_or(f32::INFINITY, |hit| hit.t as f32)).collect()
            }
            Self::Any(segments) => segments.iter().map(|[a, b]| f32::from(u8::from(!world.visible(a, b)))).collect(),
        }
    }

    /// Origins and directions.
    fn lines(&self) -> (Vec<DVec3>, Vec<DVec3>) {
        match self {
            Self::Closest(rays) => rays.iter().map(|ray| (ray.origin, ray.direction)).unzip(),
            Self::Any(segments) => segments.iter().map(|[a, b]| (a.position, b.position - a.position)).unzip(),
        }
    }
}

fn write_floats(file: &Path, values: impl Iterator<Item = f32>) -> Result<(), String> {
    let bytes: Vec<u8> = values.flat_map(f32::to_le_bytes).collect();
    fs::write(file, bytes).map_err(|e| format!("cannot write {}: {e}", file.display()))
}

fn write_points(file: &Path, points: &[DVec3]) -> Result<(), String> {
    write_floats(file, points.iter().flat_map(|p| p.as_vec3().to_array()))
}

fn number(text: &str, what: &str) -> Result<usize, String> {
    text.parse()
        .ok()
        .filter(|n| *n > 0)
        .ok_or(format!("{what} is `{text}`; it must be a number greater than 0\n{USAGE}"))
}

fn run(arguments: &[String]) -> Result<(), Box<dyn Error>> {
    let [triangles, rays, folder] = arguments else { return Err(USAGE.into()) };
    let (triangles, count) = (number(triangles, "TRIANGLES")?, number(rays, "RAYS")?);
    let folder = Path::new(folder);

    let (meshes, instances) = generated::flat(triangles);
    write_points(&folder.join("vertices"), &meshes[0].positions)?;
    let corners: Vec<u8> = meshes[0].triangles.iter().flatten().flat_map(|vertex| vertex.to_le_bytes()).collect();
    let file = folder.join("triangles");
    fs::write(&file, corners).map_err(|e| format!("cannot write {}: {e}", file.display()))?;
    let triangles = meshes[0].triangles.len();
    let start = Instant::now();
    let world = World::build(meshes, instances)?;
    let seconds = start.elapsed().as_secs_f64();

    let mut queries = BTreeMap::new();
    for kind in generated::KINDS {
        queries.insert(format!("closest {kind}"), Query::Closest(generated::rays(&world, kind, count)));
        queries.insert(format!("any {kind}"), Query::Any(generated::segments(&world, kind, count)));
    }
    for (name, query) in &queries {
        let (origins, directions) = query.lines();
        let name = name.replace(' ', ".");
        write_points(&folder.join(format!("{name}.origins")), &origins)?;
        write_points(&folder.join(format!("{name}.directions")), &directions)?;
    }
    let mut out = std::io::stdout().lock();
    writeln!(out, "{{\"triangles\": {triangles}, \"build_seconds\": {seconds}}}")?;
    out.flush()?;
    for line in std::io::stdin().lock().lines() {
        let line = line?;
        let (command, name) = line.split_once(' ').unwrap_or((&line, ""));
        let query = queries.get(name).ok_or(format!("there is no query `{name}`"))?;
        match command {
            "time" => writeln!(out, "{}", query.time(&world))?,
            "answers" => {
                let answers = query.answers(&world);
                write_floats(&folder.join(format!("{}.answers", name.replace(' ', "."))), answers.into_iter())?;
                writeln!(out, "written")?;
            }
            _ => return Err(format!("there is no command `{command}`; there are time and answers").into()),
        }
        out.flush()?;
    }
    Ok(())
}

fn main() -> ExitCode {
    match run(&std::env::args().skip(1).collect::<Vec<_>>()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::from(2)
        }
    }
}
