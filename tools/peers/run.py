#!/usr/bin/env python3
"""Renders a scene with other renderers and measures error against time, on this machine.

The peers are Radiance (Ward's irradiance cache) and Mitsuba 3 (path tracing). Both get the scene as hemicube reads it
(`hemicube export`), the same points, transport depth and quantity: indirect irradiance after 1 to N bounces at the first
hit of the ray through each pixel's centre, on the viewer's side. What is done to be fair to each stands at the top of
radiance.py and mitsuba_path.py; how the scene is said to each, and what one of them cannot say, in radiance_scene.py and
mitsuba_scene.py.

  tools/setup.sh --peers
  tools/peers/run.py scene.gltf --reference truth.exr -o points.csv
  hemicube convergence scene.gltf --reference truth.exr -o DIR --peers points.csv    shows them beside our own
  tools/peers/table.py DIR/points.csv                                                all of it as Markdown

On its first run it makes a Python environment (target/peers/venv) with the peers in it. Points that the CSV holds already
are not run again.

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
  indirect_cpu_spread_s           longest less shortest processor time of the repeats
  mae rms relmse p95 p99 max energy block_mae block_rms non_finite_test
                                  error against the reference, as hemicube compare defines it
  reference, version              file compared with; program and version
hemicube convergence writes the same columns, and some more.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import environment
import points

if TYPE_CHECKING:
    from numpy.typing import NDArray

# A run that takes longer, in seconds, is not repeated.
LONG = 30


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
    parser.add_argument(
        "--repeats", type=int, default=3, metavar="N",
        help=f"timings per point; default: %(default)s. A run of {LONG} s is not repeated",
    )
    parser.add_argument("--camera", metavar="NAME|INDEX", help="default: the file's first")
    parser.add_argument("--background", metavar="R,G,B|FILE.exr", help="light from outside the scene, as hemicube's")
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
    unknown = set(parsed.peers.split(",")) - {"radiance", "mitsuba"}
    if unknown:
        parser.error(f"no peer '{min(unknown)}': radiance, mitsuba")
    if parsed.bounces < 1 or parsed.repeats < 1:
        parser.error("--bounces and --repeats are 1 at least")
    return parsed


def read_reference(path: Path, bounces: int) -> tuple[NDArray[Any], NDArray[Any]]:
    """Irradiance of 1 to `bounces` bounces, and the mask."""
    import numpy as np

    import exr

    layers = exr.read(path)
    if "b1" in layers:
        names = [f"b{k}" for k in range(1, bounces + 1)]
    else:
        names = ["irradiance"]
    for name in names:
        if name not in layers:
            raise SystemExit(f"{path}: no layer '{name}'")
    truth = sum(layers[name] for name in names)
    mask = layers["mask"][..., 0] > 0.5 if "mask" in layers else truth.max(axis=2) > 0
    return np.asarray(truth), mask


class Runner:
    """Runs the points of one scene."""

    def __init__(self, options: argparse.Namespace) -> None:
        import scene

        self.options = options
        self.truth, self.mask = read_reference(options.reference, options.bounces)
        height, width = self.truth.shape[:2]
        self.folder = (environment.WORK / options.scene.stem).absolute()
        environment.export(
            options.scene, self.folder / "scene", (width, height), camera=options.camera, background=options.background
        )
        self.scene = scene.load(self.folder / "scene")
        self.mask &= self.scene.points.reflect.reshape(height, width)
        self.threads = [os.cpu_count() or 1 if t == "all" else int(t) for t in options.threads.split(",")]
        self.done = points.read(options.output)

    def radiance(self) -> None:
        """Radiance's points: direct light alone is run and timed too, once where it is always the same."""
        import radiance

        peer = radiance.export(self.scene, self.folder / "radiance")
        bent = self.scene.points.bent().sum() / max(self.scene.points.reflect.sum(), 1)
        if bent > 0:
            print(f"note: normal maps bend {100 * bent:.0f} % of the points: see radiance.py", file=sys.stderr)
        settings = self._settings(self.options.radiance, radiance.SETTINGS)
        direct: dict[tuple[int, str], Any] = {}
        for threads, setting in self._missing("radiance", settings):
            used = setting if peer.has_sky() else {}
            key = threads, json.dumps(used)
            if key not in direct:
                direct[key] = self._repeat(lambda: peer.irradiance(0, threads, used))
            direct_image, direct_times, _ = direct[key]
            image, times, records = self._repeat(lambda: peer.irradiance(self.options.bounces, threads, setting))
            less = direct_times["cpu_s"], direct_times["wall_s"]
            point = {"records": records, "setup_cpu_s": peer.setup.cpu_s, "version": peer.version()}
            self._add("radiance", threads, setting, point | times | _indirect(times, less), image - direct_image)

    def mitsuba(self) -> None:
        """Mitsuba's points."""
        import mitsuba_path

        peer = mitsuba_path.export(self.scene, self.folder / "mitsuba")
        if peer is None:
            return
        given = [{"sampler": "multijitter"} | setting for setting in self.options.mitsuba or []]
        for threads, setting in self._missing("mitsuba", self._settings(given, mitsuba_path.SETTINGS)):
            image, times, _ = self._repeat(lambda: (*peer.irradiance(self.options.bounces, threads, setting), 0))
            point = {"records": 0, "setup_cpu_s": peer.setup.cpu_s, "version": peer.version()}
            self._add("mitsuba", threads, setting, point | times | _indirect(times, (0, 0)), image)

    def _settings(self, given: list[dict[str, Any]] | None, built_in: list[dict[str, Any]]) -> list[dict[str, Any]]:
        return given or (built_in[:2] if self.options.quick else built_in)

    def _missing(self, method: str, settings: list[dict[str, Any]]) -> list[tuple[int, dict[str, Any]]]:
        known = {tuple(point[k] for k in points.KEY) for point in self.done}
        wanted = [(threads, setting) for setting in settings for threads in dict.fromkeys(self.threads)]
        return [(t, s) for t, s in wanted if tuple(self._key(method, t, s).values()) not in known]

    def _key(self, method: str, threads: int, setting: dict[str, Any]) -> dict[str, str]:
        height, width = self.truth.shape[:2]
        name, bounces = self.options.scene.stem, self.options.bounces
        values = [name, width, height, bounces, method, json.dumps(setting, sort_keys=True), threads]
        return dict(zip(points.KEY, map(str, values), strict=True))

    def _repeat(self, run: Any) -> tuple[Any, dict[str, Any], int]:
        """The image and count of the last of the runs; median seconds and their spread."""
        from statistics import median

        times = []
        for _ in range(1 if self.options.quick else self.options.repeats):
            image, timed, count = run()
            times.append(timed)
            if timed.wall_s > LONG:
                break
        walls, cpus = [timed.wall_s for timed in times], [timed.cpu_s for timed in times]
        figures = {
            "repeats": len(times), "cpu_s": median(cpus), "wall_s": median(walls),
            "wall_spread_s": max(walls) - min(walls), "indirect_cpu_spread_s": max(cpus) - min(cpus),
        }
        return image, figures, count

    def _add(self, method: str, threads: int, setting: dict[str, Any], point: dict[str, Any], image: Any) -> None:
        import metrics

        point |= self._key(method, threads, setting) | metrics.compare(image, self.truth, self.mask)
        point |= {"reference": self.options.reference.name}
        text = {name: f"{value:.6g}" if isinstance(value, float) else str(value) for name, value in point.items()}
        self.done.append(text)
        points.append(self.options.output, text)
        print(
            f"{method} {text['settings']} on {threads}: {text['indirect_cpu_s']} CPU s, {text['indirect_wall_s']} s, "
            f"mae {text['mae']}, energy {text['energy']}",
            file=sys.stderr,
        )
        if self.options.images:
            import exr

            self.options.images.mkdir(parents=True, exist_ok=True)
            exr.write(self.options.images / f"{self.options.scene.stem}-{method}-{len(self.done)}.exr", image)


def _indirect(times: dict[str, Any], direct: tuple[float, float]) -> dict[str, float]:
    return {"indirect_cpu_s": times["cpu_s"] - direct[0], "indirect_wall_s": times["wall_s"] - direct[1]}


def main() -> None:
    """Runs what is asked for, point by point."""
    options = arguments()
    environment.enter()
    if os.getloadavg()[0] > 0.5:
        print("note: this machine is busy with something else: wall times will be too long", file=sys.stderr)
    runner = Runner(options)
    for peer in options.peers.split(","):
        getattr(runner, peer)()


if __name__ == "__main__":
    main()
