#!/usr/bin/env python3
"""Times our ray queries against Embree 4: the same rays, in one run, in turns, in one thread.

    pip install embreex numpy
    python tools/peers/embree.py [--triangles 10000,100000,1000000] [--rays 200000] [--rounds 7] [--json FILE]

See README.md here.
"""

import argparse
import json
import platform
import statistics
import subprocess
import sys
import tempfile
import time
from importlib.metadata import version
from pathlib import Path

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene

ROOT = Path(__file__).resolve().parents[2]
KINDS = ["camera", "surface", "box"]
EMBREE_QUERY = {"closest": "INTERSECT", "any": "OCCLUDED"}
FAR = np.float32(1e30)
# Distances that differ by less than this, relative or in the room's unit, are the same up to the rounding of f32.
TOLERANCE = 1e-4


class Ours:
    """The program crates/geometry/examples/rays.rs, which stays resident with its scene."""

    def __init__(self, triangles, rays, folder):
        self.folder = Path(folder)
        command = ["cargo", "run", "--quiet", "--release", "-p", "ergodic-geometry", "--example", "rays", "--"]
        command += [str(triangles), str(rays), str(folder)]
        self.process = subprocess.Popen(command, cwd=ROOT, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.facts = json.loads(self.answer("build"))

    def answer(self, command):
        line = self.process.stdout.readline()
        if not line:
            sys.exit(f"error: the example `rays` ended at `{command}`, with status {self.process.wait()}; see its message above")
        return line

    def ask(self, command):
        self.process.stdin.write(command + "\n")
        self.process.stdin.flush()
        return self.answer(command)

    def seconds(self, query, kind):
        return float(self.ask(f"time {query} {kind}"))

    def answers(self, query, kind):
        self.ask(f"answers {query} {kind}")
        return self.floats(f"{query}.{kind}.answers")

    def floats(self, name):
        return np.fromfile(self.folder / name, "<f4").astype(np.float32)

    def points(self, name):
        return np.ascontiguousarray(self.floats(name).reshape(-1, 3))

    def close(self):
        self.process.stdin.close()
        self.process.wait()


class Embree:
    """One committed scene with embreex's default flags: not robust, not compact."""

    def __init__(self, vertices, triangles):
        self.scene = EmbreeScene()
        start = time.perf_counter()
        if len(triangles):
            self.mesh = TriangleMesh(self.scene, vertices, triangles)
        one = np.zeros((1, 3), np.float32)
        # The first query commits the scene.
        self.scene.run(one, one + 1, np.full(1, FAR))
        self.build_seconds = time.perf_counter() - start

    def seconds(self, query, origins, directions, reach):
        """Processor time of this thread. All arrays are made before."""
        start = time.thread_time()
        self.scene.run(origins, directions, reach, query=EMBREE_QUERY[query])
        return time.thread_time() - start

    def answers(self, query, origins, directions, reach):
        if query == "any":
            return (self.scene.run(origins, directions, reach, query="OCCLUDED") >= 0).astype(np.float32)
        # DISTANCE writes to the array that it is given.
        distance = self.scene.run(origins, directions, reach.copy(), query="DISTANCE")
        return np.where(distance < FAR, distance, np.inf).astype(np.float32)


def disagreement(query, ours, theirs):
    """The share of rays that hit in one and not in the other, and that of rays whose distances differ."""
    hit = np.isfinite(ours) & np.isfinite(theirs) if query == "closest" else np.ones(len(ours), bool)
    differs = np.isfinite(ours) != np.isfinite(theirs) if query == "closest" else ours != theirs
    far = np.zeros(len(ours), bool)
    far[hit] = np.abs(ours[hit] - theirs[hit]) > TOLERANCE * np.maximum(1, np.abs(ours[hit]))
    return float(differs.mean()), float((far & ~differs).mean())


def measure(triangles, rays, rounds):
    """All queries and kinds of rays in one scene."""
    with tempfile.TemporaryDirectory() as folder:
        ours = Ours(triangles, rays, folder)
        faces = np.fromfile(Path(folder) / "triangles", "<i4").astype(np.int32).reshape(-1, 3)
        embree = Embree(ours.points("vertices"), np.ascontiguousarray(faces))
        nothing = Embree(np.zeros((0, 3), np.float32), np.zeros((0, 3), np.int32))
        for query in EMBREE_QUERY:
            for kind in KINDS:
                origins, directions = ours.points(f"{query}.{kind}.origins"), ours.points(f"{query}.{kind}.directions")
                reach = np.full(rays, FAR if query == "closest" else 1, np.float32)
                mine, theirs = ours.answers(query, kind), embree.answers(query, origins, directions, reach)
                times = []
                for _ in range(rounds + 1):
                    times.append(
                        (
                            ours.seconds(query, kind),
                            embree.seconds(query, origins, directions, reach),
                            nothing.seconds(query, origins, directions, reach),
                        )
                    )
                # The first round warms the caches.
                a, b, empty = (np.array(column) for column in zip(*times[1:]))
                wrapper = statistics.median(empty)
                hits = np.isfinite(mine).mean() if query == "closest" else mine.mean()
                flips, far = disagreement(query, mine, theirs)
                yield {
                    "triangles": ours.facts["triangles"],
                    "query": query,
                    "rays": kind,
                    "hit_share": float(hits),
                    "ours_ns": statistics.median(a) / rays * 1e9,
                    "embree_ns": statistics.median(b) / rays * 1e9,
                    "wrapper_ns": wrapper / rays * 1e9,
                    "ratio": statistics.median(a / b),
                    "ratios": list(a / b),
                    "ratio_without_wrapper": statistics.median(a / (b - wrapper)),
                    "hit_disagreement": flips,
                    "distance_disagreement": far,
                    "ours_build_seconds": ours.facts["build_seconds"],
                    "embree_build_seconds": embree.build_seconds,
                }
        ours.close()


def processor():
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        return next(line.split(":")[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor()


def positive(text):
    value = int(text)
    if value < 1:
        raise argparse.ArgumentTypeError(f"{text} is not greater than 0")
    return value


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--triangles", default="10000,100000,1000000", help="sizes of the scene, with commas; 10000000 takes some GB")
    parser.add_argument("--rays", type=positive, default=200_000, help="rays of a round")
    parser.add_argument("--rounds", type=positive, default=7, help="rounds of which medians are taken")
    parser.add_argument("--json", type=Path, help="write all figures to this file")
    options = parser.parse_args()
    try:
        sizes = [positive(size) for size in options.triangles.split(",")]
    except (ValueError, argparse.ArgumentTypeError) as error:
        parser.error(f"--triangles: {error}")

    print(f"{processor()}; embreex {version('embreex')}; {options.rounds} rounds of {options.rays} rays, one thread")
    print("ns a ray of processor time; `wrapper` is embreex with an empty scene; `net` is the ratio without it")
    head = f"{'triangles':>9}  {'query':7}  {'rays':7}  {'hit':>5}  {'ours':>7}  {'embree':>7}  {'wrapper':>7}"
    head += f"  {'ratio':>5}  {'least':>5}  {'most':>5}  {'net':>5}  {'hits differ':>11}  {'t differs':>9}"
    print(head)
    print("-" * len(head))
    rows = []
    for size in sizes:
        for row in measure(size, options.rays, options.rounds):
            rows.append(row)
            print(
                f"{row['triangles']:9}  {row['query']:7}  {row['rays']:7}  {row['hit_share']:5.2f}  {row['ours_ns']:7.0f}"
                f"  {row['embree_ns']:7.0f}  {row['wrapper_ns']:7.0f}  {row['ratio']:5.2f}  {min(row['ratios']):5.2f}"
                f"  {max(row['ratios']):5.2f}  {row['ratio_without_wrapper']:5.2f}  {row['hit_disagreement']:11.1e}"
                f"  {row['distance_disagreement']:9.1e}",
                flush=True,
            )
    if options.json:
        facts = {"processor": processor(), "embreex": version("embreex"), "rays": options.rays, "rounds": options.rounds}
        options.json.write_text(json.dumps({**facts, "rows": rows}, indent=1) + "\n")


if __name__ == "__main__":
    main()
