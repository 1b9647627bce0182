#!/usr/bin/env python3
"""How many times as fast as other renderers in their usual settings, at an error that is no larger.

  tools/setup.sh --peers
  tools/peers/ratios.py SCENE.gltf=REFERENCE_256x256.exr[@512x512]... -o DIR      [--repeats N] [--peers radiance,mitsuba]

For each scene Radiance (ambient cache, its default quality) and Mitsuba 3 (64 and 256 paths a pixel) run once on all cores by run.py; then
hemicube, from its quickest setting on until one errs no more than the peer. Where a size stands behind a reference, times are taken
at that size, and errors at the reference's, of each program in the same settings. Errors are mean absolute errors of the indirect
light over its mean; times are processor seconds of both cores together / seconds on the clock, and so are the ratios. What direct light alone takes is taken off: of whole
processes for hemicube, least of the repeats, with loading, building and writing in both, so that only what indirect light adds is
left; of rtrace's runs for Radiance. Mitsuba does no direct light here and loads before its time begins.

Then hemicubes of 64 x 64 texels a second in each scene of more than 10,000 triangles: in compute, by render passes, and, at the rate
at which the device draws triangles at best (hemicube info --measure), what five draws of the whole scene would allow.

References: layer b1, irradiance after one bounce, or irradiance, as hemicube reference makes it.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import environment
import points
from timing import Timed, measure_children

HEMICUBE = os.environ.get("HEMICUBE", environment.ROOT / "target" / "release" / "hemicube")
RADIANCE = {"ad": 512, "as": 128, "aa": 0.2, "ar": 64}
MITSUBA = [{"sampler": "multijitter", "spp": spp} for spp in (64, 256)]

# From quick to careful. Large zones first: what they miss is the error that a quick picture has.
SETTINGS = [
    "--accuracy 1 --capture-size 16 --min-radius .06 --max-radius .1 --contrast 0 --surface-cells 60000",
    "--accuracy 1 --capture-size 16 --min-radius .05 --max-radius .08 --contrast 0 --surface-cells 60000",
    "--accuracy 1 --capture-size 16 --min-radius .04 --contrast 0 --surface-cells 60000",
    "--accuracy 1 --capture-size 16 --min-radius .02 --contrast 0 --surface-cells 60000",
    "--accuracy .5 --capture-size 16 --contrast 0 --surface-cells 60000",
    "--accuracy .5 --capture-size 16 --contrast 0",
    "--capture-size 16",
    "",
]


def hemicube(*words: object) -> Timed:
    """Runs hemicube."""
    return measure_children(lambda: subprocess.run([HEMICUBE, *map(str, words)], check=True, stdout=subprocess.DEVNULL))[1]


def least(runs: list[Timed]) -> Timed:
    """Least processor time and least wall time."""
    return Timed(min(run.cpu_s for run in runs), min(run.wall_s for run in runs))


class Scene:
    """A scene, its reference, and what was measured of it."""

    def __init__(self, pair: str, options: argparse.Namespace) -> None:
        scene, _, reference = pair.partition("=")
        reference, _, timed_at = reference.partition("@")
        self.scene, self.reference, self.options = Path(scene), Path(reference), options
        size = re.search(r"(\d+)x(\d+)\.exr$", reference)
        if not self.scene.is_file() or not self.reference.is_file() or not size:
            sys.exit(f"{pair}: not SCENE.gltf=REFERENCE_WIDTHxHEIGHT.exr, or one of them is missing")
        self.size = size.groups()
        self.timed_at = tuple(timed_at.split("x")) if timed_at else self.size
        self.ours: dict[str, tuple[Timed, float]] = {}
        self.direct = least([self.render(self.timed_at, "--bounces", 0) for _ in range(options.repeats)])

    def render(self, size: tuple[str, ...], *words: object) -> Timed:
        """A render."""
        width, height = size
        return hemicube("render", self.scene, "-q", "-o", self.options.output / "out.exr", "--layers", "irradiance",
                     "--width", width, "--height", height, *words)

    def own(self, setting: str) -> tuple[Timed, float]:
        """Time of the indirect light, and its error."""
        if setting not in self.ours:
            time = least([self.render(self.timed_at, *setting.split()) for _ in range(self.options.repeats)])
            time = Timed(time.cpu_s - self.direct.cpu_s, time.wall_s - self.direct.wall_s)
            if self.timed_at != self.size:
                self.render(self.size, *setting.split())
            self.ours[setting] = time, self.error()
        return self.ours[setting]

    def error(self) -> float:
        """Of the last render."""
        compare = [HEMICUBE, "compare", self.options.output / "out.exr", self.reference, "--mask", "mask", "--no-flip", "--json", "-"]
        for layer in ("irradiance=b1", "irradiance"):
            done = subprocess.run([*compare, "--layer", layer], capture_output=True, text=True)
            if done.returncode == 0:
                return float(json.loads(done.stdout)["layers"][0]["mae"])
        sys.exit(f"{self.reference}: {done.stderr.strip()}")

    def peers(self) -> list[tuple[str, Timed, float]]:
        """Name, time and error of each peer in each setting, measured where the file has no such point yet."""
        errors = self.points(self.reference, self.size)
        times = errors if self.timed_at == self.size else self.points(self.frame(), self.timed_at)
        time = {(p["method"], p["settings"]): Timed(float(p["indirect_cpu_s"]), float(p["indirect_wall_s"])) for p in times}
        return [(name_of(p), time[p["method"], p["settings"]], float(p["mae"])) for p in errors]

    def frame(self) -> Path:
        """A reference that says at which size to take times, and nothing else."""
        width, height = self.timed_at
        frame = self.options.output / f"{self.scene.stem}_{width}x{height}.exr"
        hemicube("reference", self.scene, "-q", "--width", width, "--height", height, "--spp", 2, "-o", frame)
        return frame

    def points(self, reference: Path, size: tuple[str, ...]) -> list[points.Point]:
        """The peers' points at the reference's size."""
        csv = self.options.output / "peers.csv"
        run = [sys.executable, Path(__file__).with_name("run.py"), self.scene, "--reference", reference, "-o", csv, "--threads", "all",
               "--repeats", "1", "--peers", self.options.peers, "--radiance", json.dumps(RADIANCE)]
        for setting in MITSUBA:
            run += ["--mitsuba", json.dumps(setting)]
        subprocess.run(run, check=True)
        wanted = {json.dumps(setting, sort_keys=True) for setting in (RADIANCE, *MITSUBA)}
        return [p for p in points.read(csv) if (p["scene"], p["width"], p["height"]) == (self.scene.stem, *size) and p["settings"] in wanted]

    def rows(self) -> list[str]:
        """A row for each peer."""
        lines = []
        for peer, theirs, error in self.peers():
            setting = next((s for s in SETTINGS if self.own(s)[1] <= error), SETTINGS[-1])
            time, own = self.own(setting)
            lines.append(
                f"| {self.scene.stem} {' × '.join(self.timed_at)} | {peer} | {theirs.cpu_s:.2f} / {theirs.wall_s:.2f} s | {100 * error:.1f} % "
                f"| {time.cpu_s:.2f} / {time.wall_s:.2f} s | {100 * own:.1f} % | {theirs.cpu_s / time.cpu_s:.1f} / "
                f"{theirs.wall_s / time.wall_s:.1f} | `{setting or 'the usual ones'}` |"
            )
        return lines

    def hemicubes(self, triangle_views: float) -> list[str]:
        """A row of captures a second, for a scene that is not small."""
        rates = []
        for capture in ("compute", "hemicube"):
            stats = self.options.output / "stats.json"
            hemicube("render", self.scene, "-q", "-o", self.options.output / "out.exr", "--width", 32, "--height", 32, "--capture-size", 64,
                  "--surface-cells", 60000, "--capture", capture, "--stats", stats)
            said = json.loads(stats.read_text())
            spent = sum(p["total_ms"] for p in said["passes"] if p["name"] in {"cull", "capture", "capture_compute", "integrate"})
            rates.append(said["records"] / spent * 1e3)
            triangles = said["scene"]["triangles"]
        brute = triangle_views / (5 * triangles)
        return [] if triangles < 10_000 else [f"| {self.scene.stem} | {triangles:,} | {rates[0]:,.0f} | {rates[1]:,.0f} | {brute:,.0f} | {rates[0] / brute:,.0f} × |"]


def name_of(point: points.Point) -> str:
    """A peer, and what tells its settings apart."""
    spp = json.loads(point["settings"]).get("spp")
    return f"Mitsuba 3, {spp} paths" if spp else "Radiance"


def triangle_rate() -> float:
    """Triangles times views that the first device draws in a second."""
    said = subprocess.run([HEMICUBE, "info", "--measure"], check=True, capture_output=True, text=True).stdout
    found = re.search(r"([\d.]+) M/s triangles × views captured$", said, re.MULTILINE)
    return float(found.group(1)) * 1e6 if found else 0.0


def main() -> None:
    """Both tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="+", metavar="SCENE.gltf=REFERENCE.exr", help="the reference's name ends in WIDTHxHEIGHT.exr")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="DIR", help="keeps the peers' points, which are run once")
    parser.add_argument("--repeats", type=int, default=3, metavar="N", help="runs of hemicube, of which the quickest counts (3)")
    parser.add_argument("--peers", default="radiance,mitsuba", metavar="LIST", help="default: %(default)s")
    options = parser.parse_args()
    environment.enter()
    options.output.mkdir(parents=True, exist_ok=True)
    scenes = [Scene(pair, options) for pair in options.scenes]
    print("| scene | peer | its time | error | hemicube | error | times as fast | in settings |\n|---|---|--:|--:|--:|--:|--:|---|")
    for scene in scenes:
        print("\n".join(scene.rows()), flush=True)
    rate = triangle_rate()
    print("\n| scene | triangles | hemicubes of 64² a second, in compute | by render passes | all triangles drawn, at most | ratio |")
    print("|---|--:|--:|--:|--:|--:|")
    for scene in {s.scene: s for s in scenes}.values():
        print("\n".join(scene.hemicubes(rate)), flush=True)


if __name__ == "__main__":
    main()
