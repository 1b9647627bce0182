"""Radiance (https://radiance-online.org): Ward's irradiance cache on the CPU, by rtrace from the pyradiance package.

How a scene is said in Radiance stands in radiance_scene.py.

How it is run: points and normals come from us as doubles and the answer goes back as floats, so rtrace is used rather
than rpict, whose pictures keep 8 bits of mantissa; the sequence of points and the cache are the same. `-I` asks for the
irradiance at a point with a normal. `-ab N` gives direct light and N bounces.
With N processes each takes every N-th row and all share one cache file, which is what `rtrace -n` does too, but so that
the jitter of the direct light is the same with and without bounces: it cancels when one is taken from the other.
Radiance counts the way to the sky as a bounce of its own, since only the indirect calculation finds it. So a sky is
traced by itself, with one bounce more than the lights, and both are summed.
A point has one normal for Radiance. Where a normal map bends it, rays that go below the triangle itself find the same
surface and its light, which no renderer of the scene would count; `Points.bent` tells where, and run.py how much.
Radiance measures `-ar` in units of its octree's cube, which a mesh makes larger than the scene: the `ar` of the settings
is in units of the scene's largest side, and is scaled.
"""

from __future__ import annotations

import os
import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from radiance_scene import LENGTH, Writer
from scene import Floats, Points, Scene
from timing import Timed, measure_children

# The same for every run: one sample at the pixel's centre; every source tested and jittered over its area (without -dj
# indirect light is biased); sources cut only where they are large for their distance (a small -ds multiplies the time
# for nothing); no ambient guess; no ray dropped before the bounces end.
FIXED = "-h -I -u- -dt 0 -dc 1 -dj 1 -ds .1 -dr 0 -av 0 0 0 -aw 0 -lr 12 -lw 1e-6".split()

# From quick to careful; the third is what rpict's own defaults come to.
SETTINGS: list[dict[str, float]] = [
    {"ad": 128, "as": 0, "aa": 0.3, "ar": 32},
    {"ad": 256, "as": 64, "aa": 0.25, "ar": 48},
    {"ad": 512, "as": 128, "aa": 0.2, "ar": 64},
    {"ad": 1024, "as": 256, "aa": 0.15, "ar": 128},
    {"ad": 1024, "as": 512, "aa": 0.1, "ar": 256},
]


@dataclass
class Octree:
    """A compiled scene: its lights, or its sky."""

    folder: Path
    more_bounces: int
    cube_per_extent: float = 1.0

    def file(self) -> Path:
        """What oconv made."""
        return self.folder / "scene.oct"


@dataclass
class Radiance:
    """A scene compiled, ready to be asked."""

    environment: dict[str, str]
    points: Points
    extent: float
    octrees: list[Octree]
    setup: Timed

    def has_sky(self) -> bool:
        """Whether direct light depends on the settings of the indirect calculation."""
        return any(octree.more_bounces for octree in self.octrees)

    def irradiance(self, bounces: int, threads: int, settings: dict[str, float]) -> tuple[Floats, Timed, int]:
        """Direct light and `bounces` bounces at each point; its cost; the records in the cache."""
        image, total, records = np.zeros((*self.points.shape, 3)), Timed(0, 0), 0
        for octree in self.octrees:
            part, timed, made = self._trace(octree, bounces + octree.more_bounces, threads, settings)
            image += part
            total = Timed(total.cpu_s + timed.cpu_s, total.wall_s + timed.wall_s)
            records += made
        return image, total, records

    def version(self) -> str:
        """The program's own name and version."""
        return self._run(["rtrace", "-version"]).decode().strip()

    def _trace(
        self, octree: Octree, ambient_bounces: int, threads: int, settings: dict[str, float]
    ) -> tuple[Floats, Timed, int]:
        cache = octree.folder / "cache.amb"
        cache.unlink(missing_ok=True)
        if "ar" in settings:
            settings = settings | {"ar": round(settings["ar"] * octree.cube_per_extent)}
        flags = [str(part) for key, value in settings.items() for part in (f"-{key}", value)]
        is_cached = ambient_bounces > 0 and settings.get("aa") != 0
        if is_cached:
            flags += ["-af", str(cache)]
        command = ["rtrace", *FIXED, "-fdf", "-ab", str(ambient_bounces), *flags, str(octree.file())]
        height, width = self.points.shape
        row = np.repeat(np.arange(height), width)
        shares = [np.flatnonzero(self.points.reflect & (row % threads == k)) for k in range(threads)]
        for k, share in enumerate(shares):
            asked = np.hstack([self.points.positions[share] * LENGTH / self.extent, self.points.normals[share]])
            (octree.folder / f"points{k}").write_bytes(asked.astype("<f8").tobytes())
        _, timed = measure_children(lambda: self._processes(command, octree.folder, threads))
        image = np.zeros((height * width, 3))
        for k, share in enumerate(shares):
            image[share] = np.fromfile(octree.folder / f"answer{k}", "<f4").reshape(-1, 3)
        return image.reshape(height, width, 3), timed, self._records(cache) if is_cached else 0

    def _processes(self, command: list[str], folder: Path, count: int) -> None:
        if count > 1:  # makes the cache file: processes that do so at once wait seconds for each other
            subprocess.run(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, env=self.environment, check=True)
        running = []
        for k in range(count):
            with (folder / f"points{k}").open("rb") as points, (folder / f"answer{k}").open("wb") as answer:
                running.append(
                    subprocess.Popen(command, stdin=points, stdout=answer, stderr=subprocess.PIPE, env=self.environment)
                )
        for process in running:
            message = process.communicate()[1].decode(errors="replace").strip()
            if process.returncode != 0:
                raise SystemExit(f"{' '.join(command)}\n{message}")

    def _records(self, cache: Path) -> int:
        return self._run(["lookamb", "-h", "-d", str(cache)]).count(b"\n")

    def _run(self, command: list[str]) -> bytes:
        done = subprocess.run(command, capture_output=True, env=self.environment)
        if done.returncode != 0:
            raise SystemExit(f"{' '.join(command)}\n{done.stderr.decode(errors='replace').strip()}")
        return done.stdout

    def compile(self, scene: Scene, octree: Octree) -> None:
        """Writes the description and makes the octree. Paths are absolute: an octree knows no folder of its own."""
        folder = octree.folder
        folder.mkdir(parents=True, exist_ok=True)
        description, obj = Writer(scene, folder, octree.more_bounces == 0).write()
        if obj is not None:
            self._run(["obj2mesh", "-a", str(folder / "materials.rad"), str(obj), str(folder / "mesh.rtm")])
        octree.file().write_bytes(self._run(["oconv", str(description)]))
        octree.cube_per_extent = float(self._run(["getinfo", "-d", str(octree.file())]).split()[-1]) / LENGTH


def export(scene: Scene, folder: Path) -> Radiance:
    """Writes the scene and compiles it."""
    import pyradiance

    package = Path(pyradiance.__file__).parent
    environment = os.environ | {
        "PATH": f"{package / 'bin'}{os.pathsep}{os.environ['PATH']}",
        "RAYPATH": f".{os.pathsep}{package / 'lib'}",
    }
    radiance = Radiance(environment, scene.points, scene.extent(), [], Timed(0, 0))
    if scene.lights or any(mesh.material.emits() for mesh in scene.meshes):
        radiance.octrees.append(Octree(folder / "lights", 0))
    if scene.background is not None:
        radiance.octrees.append(Octree(folder / "sky", 1))
    _, radiance.setup = measure_children(lambda: [radiance.compile(scene, octree) for octree in radiance.octrees])
    return radiance
