#!/usr/bin/env python3
"""Renders a scene with other renderers and measures error against time, on this machine.

The peers are Radiance (Ward's irradiance cache) and Mitsuba 3 (path tracing). Both get the same view, transport depth
and quantity: indirect irradiance after 1 to N bounces at the first hit of the ray through each pixel's centre, on the
viewer's side. What is done to be fair to each stands at the top of radiance.py and mitsuba_path.py.

  tools/setup.sh --peers
  tools/peers/run.py scene.gltf --reference truth.exr -o points.csv
  hemicube convergence scene.gltf --reference truth.exr -o DIR --peers points.csv    shows them beside our own

On its first run it makes a Python environment (target/peers/venv) with the peers in it. Points that the CSV holds already
are not run again. A Markdown table of all its points is printed at the end.

Columns of the CSV:
  scene, width, height, bounces   what was rendered
  method                          radiance or mitsuba
  settings                        JSON; radiance: rpict's flags by name; mitsuba: spp (samples a pixel) and sampler
  threads, repeats                threads or processes at once; times are medians over the repeats
  records                         records in Radiance's irradiance cache, 0 for Mitsuba
  setup_cpu_s                     loading or compiling the scene, not in the times below
  cpu_s, wall_s                   processor time (user + system, all threads) and wall time of the run
  wall_spread_s                   longest less shortest wall time of the repeats
  indirect_cpu_s, indirect_wall_s the same with the time for direct light alone (-ab 0) taken off; Mitsuba does none
  mae rms relmse p95 p99 max energy block_mae block_rms non_finite_test
                                  error against the reference, as hemicube compare defines it
  reference, version              file compared with; program and version
hemicube convergence writes the same columns, and some more.
"""

from __future__ import annotations

import argparse
import csv
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from numpy.typing import NDArray

HERE = Path(__file__).resolve().parent
WORK = HERE.parents[1] / "target" / "peers"
COLUMNS = (
    "scene width height bounces method settings threads repeats records setup_cpu_s cpu_s wall_s wall_spread_s "
    "indirect_cpu_s indirect_wall_s mae rms relmse p95 p99 max energy block_mae block_rms non_finite_test "
    "reference version"
).split()
KEY = ["scene", "width", "height", "bounces", "method", "settings", "threads"]


def arguments() -> argparse.Namespace:
    """The command line, checked."""
    description, columns = (__doc__ or "").split("Columns of the CSV:")
    parser = argparse.ArgumentParser(
        description=description, epilog="Columns of the CSV:" + columns,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("scene", type=Path, metavar="SCENE", help=".gltf or .glb")
    parser.add_argument(
        "--reference", type=Path, required=True, metavar="FILE.exr",
        help="truth, which also gives the image's size: layers b1, b2, … (irradiance after exactly so many bounces) or "
        "irradiance (hemicube convergence keeps one as DIR/reference.exr); pixels count where mask is above one half, or "
        "where that layer is not black",
    )
    parser.add_argument("-o", "--output", type=Path, default=Path("peers.csv"), metavar="FILE.csv", help="default: %(default)s")
    parser.add_argument("--peers", default="radiance,mitsuba", metavar="LIST", help="default: %(default)s")
    parser.add_argument("--bounces", type=int, default=1, metavar="N", help="default: %(default)s")
    parser.add_argument("--threads", default="1,all", metavar="LIST", help="each point once per entry; default: %(default)s")
    parser.add_argument("--repeats", type=int, default=3, metavar="N", help="timings per point; default: %(default)s")
    parser.add_argument("--camera", type=int, default=0, metavar="INDEX", help="default: %(default)s")
    parser.add_argument("--quick", action="store_true", help="only the two quickest settings of each peer, one timing")
    for peer, example in (("radiance", '{"ad": 512, "as": 128, "aa": 0.2, "ar": 64}'), ("mitsuba", '{"spp": 64}')):
        parser.add_argument(
            f"--{peer}", type=json.loads, action="append", metavar="JSON",
            help=f"a setting instead of the built-in ones, may be repeated: '{example}'",
        )
    parser.add_argument("--images", type=Path, metavar="DIR", help="keep each point's irradiance as EXR")
    parsed = parser.parse_args()
    for path in (parsed.scene, parsed.reference):
        if not path.is_file():
            parser.error(f"{path}: no such file")
    return parsed


def enter_environment() -> None:
    """Continues in the peers' own Python environment, made on the first run."""
    python = WORK / "venv" / "bin" / "python"
    if Path(sys.prefix).resolve() == python.parents[1].resolve():
        return
    requirements = HERE / "requirements.txt"
    installed = python.parents[1] / "installed.txt"
    if not installed.is_file() or installed.read_text() != requirements.read_text():
        print(f"making a Python environment in {python.parents[1]}", file=sys.stderr)
        subprocess.run([sys.executable, "-m", "venv", python.parents[1]], check=True)
        subprocess.run([python, "-m", "pip", "install", "-q", "-r", requirements], check=True)
        installed.write_text(requirements.read_text())
    os.execv(python, [str(python), str(HERE / "run.py"), *sys.argv[1:]])


def read_reference(path: Path, bounces: int) -> tuple[NDArray[Any], NDArray[Any]]:
    """Irradiance of 1 to `bounces` bounces, and the mask."""
    import mitsuba
    import numpy as np

    mitsuba.set_variant("scalar_rgb")
    bitmap = mitsuba.Bitmap(str(path))
    fields = bitmap.struct_()
    pixels = np.array(bitmap).astype(float)
    channels = {fields[k].name: pixels[..., k] for k in range(len(fields))}

    def layer(name: str) -> NDArray[Any]:
        if f"{name}.R" not in channels:
            raise SystemExit(f"{path}: no layer '{name}'")
        return np.stack([channels[f"{name}.{c}"] for c in "RGB"], axis=2)

    if "b1.R" in channels:
        truth = sum((layer(f"b{k}") for k in range(1, bounces + 1)), np.zeros(pixels.shape[:2] + (3,)))
    else:
        truth = layer("irradiance")
    masks = [channels[name] for name in ("mask", "mask.R", "mask.Y") if name in channels]
    mask = masks[0] > 0.5 if masks else truth.max(axis=2) > 0
    return truth, mask


class Runner:
    """Runs the points of one scene."""

    def __init__(self, options: argparse.Namespace) -> None:
        import scene

        self.options = options
        self.truth, self.mask = read_reference(options.reference, options.bounces)
        self.shape = self.truth.shape[:2]
        self.scene = scene.load(options.scene)
        for note in dict.fromkeys(self.scene.notes):
            print(f"note: {note}", file=sys.stderr)
        if options.camera >= len(self.scene.cameras):
            raise SystemExit(f"{options.scene}: no camera {options.camera}, it has {len(self.scene.cameras)}")
        self.rays = self.scene.cameras[options.camera].rays(self.shape[1], self.shape[0])
        self.folder = (WORK / options.scene.stem).absolute()
        self.threads = [os.cpu_count() or 1 if t == "all" else int(t) for t in options.threads.split(",")]
        self.done = read_points(options.output)

    def radiance(self) -> None:
        """Radiance's points: direct light alone is run and timed once, for its share of the rest."""
        import radiance

        peer = radiance.export(self.scene, self.rays, self.shape, self.folder / "radiance")
        settings = self._settings(self.options.radiance, radiance.SETTINGS)
        direct: dict[int, Any] = {}
        for threads, setting in self._missing("radiance", settings):
            if threads not in direct:
                direct[threads] = self._repeat(lambda: peer.irradiance(0, threads, {}))
            image, (cpu, wall, spread), records = self._repeat(
                lambda: peer.irradiance(self.options.bounces, threads, setting)
            )
            direct_image, (direct_cpu, direct_wall, _), _ = direct[threads]
            point = {
                "records": records, "setup_cpu_s": peer.setup.cpu_s, "cpu_s": cpu, "wall_s": wall, "wall_spread_s": spread,
                "indirect_cpu_s": cpu - direct_cpu, "indirect_wall_s": wall - direct_wall, "version": peer.version(),
            }
            self._add("radiance", threads, setting, point, image - direct_image)

    def mitsuba(self) -> None:
        """Mitsuba's points."""
        import mitsuba_path

        peer = mitsuba_path.export(self.scene, self.rays, self.shape, self.folder / "mitsuba")
        if peer is None:
            return
        given = [{"sampler": "multijitter"} | setting for setting in self.options.mitsuba or []]
        for threads, setting in self._missing("mitsuba", self._settings(given, mitsuba_path.SETTINGS)):
            image, (cpu, wall, spread), _ = self._repeat(
                lambda: (*peer.irradiance(self.options.bounces, threads, setting), 0)
            )
            point = {
                "records": 0, "setup_cpu_s": peer.setup.cpu_s, "cpu_s": cpu, "wall_s": wall, "wall_spread_s": spread,
                "indirect_cpu_s": cpu, "indirect_wall_s": wall, "version": peer.version(),
            }
            self._add("mitsuba", threads, setting, point, image)

    def _settings(self, given: list[dict[str, Any]] | None, built_in: list[dict[str, Any]]) -> list[dict[str, Any]]:
        return given or (built_in[:2] if self.options.quick else built_in)

    def _missing(self, method: str, settings: list[dict[str, Any]]) -> list[tuple[int, dict[str, Any]]]:
        known = {tuple(point[k] for k in KEY) for point in self.done}
        points = [(threads, setting) for setting in settings for threads in dict.fromkeys(self.threads)]
        return [(t, s) for t, s in points if tuple(self._key(method, t, s).values()) not in known]

    def _key(self, method: str, threads: int, setting: dict[str, Any]) -> dict[str, str]:
        height, width = self.shape
        name, bounces = self.options.scene.stem, self.options.bounces
        values = [name, width, height, bounces, method, json.dumps(setting, sort_keys=True), threads]
        return dict(zip(KEY, map(str, values), strict=True))

    def _repeat(self, run: Any) -> tuple[Any, tuple[float, float, float], int]:
        """The image and count of the last of the runs; median CPU and wall seconds, and the walls' spread."""
        from statistics import median

        times = []
        for _ in range(1 if self.options.quick else self.options.repeats):
            image, timed, count = run()
            times.append(timed)
        walls = [timed.wall_s for timed in times]
        return image, (median(timed.cpu_s for timed in times), median(walls), max(walls) - min(walls)), count

    def _add(self, method: str, threads: int, setting: dict[str, Any], point: dict[str, Any], image: Any) -> None:
        import metrics

        point |= self._key(method, threads, setting) | metrics.compare(image, self.truth, self.mask)
        point |= {"repeats": 1 if self.options.quick else self.options.repeats, "reference": self.options.reference.name}
        text = {name: f"{value:.6g}" if isinstance(value, float) else str(value) for name, value in point.items()}
        self.done.append(text)
        append_point(self.options.output, text)
        print(
            f"{method} {text['settings']} on {threads}: {text['cpu_s']} CPU s, {text['wall_s']} s, mae {text['mae']}",
            file=sys.stderr,
        )
        if self.options.images:
            self._keep(f"{self.options.scene.stem}-{method}-{len(self.done)}.exr", image)

    def _keep(self, name: str, image: Any) -> None:
        import mitsuba
        import numpy as np

        self.options.images.mkdir(parents=True, exist_ok=True)
        names = [f"irradiance.{c}" for c in "RGB"]
        pixels = np.ascontiguousarray(image, np.float32)
        bitmap = mitsuba.Bitmap(pixels, mitsuba.Bitmap.PixelFormat.MultiChannel, channel_names=names)
        bitmap.write(str(self.options.images / name))


def read_points(path: Path) -> list[dict[str, str]]:
    """Points of earlier runs."""
    if not path.is_file():
        return []
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def append_point(path: Path, point: dict[str, str]) -> None:
    """Adds a line, so that a run that is broken off keeps what it has."""
    is_new = not path.is_file()
    with path.open("a", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS)
        if is_new:
            writer.writeheader()
        writer.writerow(point)


def table(points: list[dict[str, str]]) -> str:
    """All points as Markdown; times are those of indirect light alone."""
    lines = [
        "| scene | method | settings | threads | records | CPU s | wall s | error (mean abs.) | 4×4 blocks | 99th pct. | energy |",
        "|---|---|---|--:|--:|--:|--:|--:|--:|--:|--:|",
    ]
    for p in points:
        settings = " ".join(f"{name} {value}" for name, value in json.loads(p["settings"]).items())
        percent = [f"{100 * float(p[name]):.1f} %" for name in ("mae", "block_mae", "p99")]
        times = [f"{float(p[name]):.2f}" for name in ("indirect_cpu_s", "indirect_wall_s")]
        scene = f"{p['scene']} {p['width']}×{p['height']}"
        cells = [scene, p["method"], settings, p["threads"], p["records"], *times, *percent, f"{float(p['energy']):.3f}"]
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def main() -> None:
    """Runs what is asked for, point by point."""
    options = arguments()
    enter_environment()
    if os.getloadavg()[0] > 0.5:
        print("note: this machine is busy with something else: wall times will be too long", file=sys.stderr)
    runner = Runner(options)
    for peer in options.peers.split(","):
        if peer not in ("radiance", "mitsuba"):
            raise SystemExit(f"no peer '{peer}': radiance, mitsuba")
        getattr(runner, peer)()
    print(table(runner.done))


if __name__ == "__main__":
    main()
