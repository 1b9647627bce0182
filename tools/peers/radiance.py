"""Radiance (https://radiance-online.org): Ward's irradiance cache on the CPU, by rtrace from the pyradiance package.

How a scene is said in Radiance:

- Surfaces are `plastic` with specularity 0, which reflects on both sides. Flat ones without texture are polygons, which
  Radiance traces fastest; all others share one triangle mesh (.rtm), faster than a mesh each. A texture is a
  `colorpict`, whose picture coordinates run to 1 along the *shorter* side.
- Emitters: `light` polygons (a mesh cannot be a light source). Radiance's `light` is black and dark on the back, which
  is just what is wanted; a two-sided emitter gets a second polygon a hair behind the first, turned round.
  Pairs of triangles that make a parallelogram become one polygon: Radiance samples a source over its bounding
  parallelogram, so half of the samples of a triangle would be wasted.
- A directional light is a `source` 0.05° wide, a point light a small sphere.

How it is run: rays through pixel centres come from us as doubles and the answer goes back as floats, so rtrace is used
rather than rpict, whose pictures keep 8 bits of mantissa; the sequence of rays and the cache are the same. `-i` asks for
irradiance at the first hit with its shading normal, on the viewer's side. `-ab N` gives direct light and N bounces.
With N processes each takes every N-th row and all share one cache file, which is what `rtrace -n` does too, but so that
the jitter of the direct light is the same with and without bounces: it cancels when one is taken from the other.
Radiance measures `-ar` in units of its octree's cube, which a mesh makes larger than the scene: the `ar` of the settings
is in units of the scene's largest side, and is scaled.
"""

from __future__ import annotations

import os
import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from scene import Floats, Light, Material, Mesh, Scene
from timing import Timed, measure_children

# The same for every run: one sample at the pixel's centre; every source tested and jittered over its area (without -dj
# indirect light is biased); sources cut only where they are large for their distance (a small -ds multiplies the time
# for nothing); no ambient guess; no ray dropped before the bounces end.
FIXED = "-h -i -u- -dt 0 -dc 1 -dj 1 -ds .1 -dr 0 -av 0 0 0 -aw 0 -lr 12 -lw 1e-6".split()

# From quick to careful; the third is what rpict's own defaults come to.
SETTINGS: list[dict[str, float]] = [
    {"ad": 128, "as": 0, "aa": 0.3, "ar": 32},
    {"ad": 256, "as": 64, "aa": 0.25, "ar": 48},
    {"ad": 512, "as": 128, "aa": 0.2, "ar": 64},
    {"ad": 1024, "as": 256, "aa": 0.15, "ar": 128},
    {"ad": 1024, "as": 512, "aa": 0.1, "ar": 256},
]

SUN_DEGREES = 0.05


@dataclass
class Radiance:
    """A scene compiled to an octree, ready to be asked."""

    folder: Path
    environment: dict[str, str]
    octree: Path
    rays: Floats  # rows × columns × 6
    shape: tuple[int, int]
    setup: Timed
    cube_per_extent: float = 1.0

    def irradiance(self, bounces: int, threads: int, settings: dict[str, float]) -> tuple[Floats, Timed, int]:
        """Direct light and `bounces` bounces at the first hit of each ray; its cost; the records in the cache."""
        cache = self.folder / "cache.amb"
        cache.unlink(missing_ok=True)
        if "ar" in settings:
            settings = settings | {"ar": round(settings["ar"] * self.cube_per_extent)}
        flags = [str(part) for key, value in settings.items() for part in (f"-{key}", value)]
        if bounces > 0:
            flags += ["-af", str(cache)]
        command = ["rtrace", *FIXED, "-fdf", "-ab", str(bounces), *flags, str(self.octree)]
        for k in range(threads):
            self._part(k, "rays").write_bytes(np.ascontiguousarray(self.rays[k::threads], "<f8").tobytes())
        _, timed = measure_children(lambda: self._trace(command, threads))
        image = np.empty((*self.shape, 3))
        for k in range(threads):
            image[k::threads] = np.fromfile(self._part(k, "answer"), "<f4").reshape(-1, self.shape[1], 3)
        return image, timed, self._records(cache) if bounces > 0 else 0

    def _part(self, number: int, kind: str) -> Path:
        return self.folder / f"{kind}{number}"

    def _trace(self, command: list[str], processes: int) -> None:
        if processes > 1:  # makes the cache file: processes that do so at once wait seconds for each other
            subprocess.run(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, env=self.environment, check=True)
        running = []
        for k in range(processes):
            with self._part(k, "rays").open("rb") as rays, self._part(k, "answer").open("wb") as answer:
                running.append(subprocess.Popen(command, stdin=rays, stdout=answer, env=self.environment))
        if any([process.wait() for process in running]):
            raise SystemExit(f"failed: {' '.join(command)}")

    def version(self) -> str:
        """The program's own name and version."""
        return self._run(["rtrace", "-version"]).decode().strip()

    def _records(self, cache: Path) -> int:
        return self._run(["lookamb", "-h", "-d", str(cache)]).count(b"\n")

    def _run(self, command: list[str]) -> bytes:
        done = subprocess.run(command, capture_output=True, env=self.environment)
        if done.returncode != 0:
            raise SystemExit(f"{' '.join(command)}\n{done.stderr.decode(errors='replace').strip()}")
        return done.stdout


def export(scene: Scene, rays: Floats, shape: tuple[int, int], folder: Path) -> Radiance:
    """Writes the scene and compiles it."""
    import pyradiance

    folder.mkdir(parents=True, exist_ok=True)
    package = Path(pyradiance.__file__).parent
    environment = os.environ | {
        "PATH": f"{package / 'bin'}{os.pathsep}{os.environ['PATH']}",
        "RAYPATH": f".{os.pathsep}{package / 'lib'}",
    }
    radiance = Radiance(folder, environment, folder / "scene.oct", rays.reshape(*shape, 6), shape, Timed(0, 0))
    extent = _extent(scene)
    materials = "\n".join(_material(folder, k, m) for k, m in enumerate(scene.materials))
    lights = "\n".join(_light(k, light, extent) for k, light in enumerate(scene.lights))
    _, radiance.setup = measure_children(lambda: _compile(radiance, scene, materials, lights, extent))
    cube = float(radiance._run(["getinfo", "-d", str(radiance.octree)]).split()[-1])
    radiance.cube_per_extent = cube / extent
    return radiance


def _compile(radiance: Radiance, scene: Scene, materials: str, lights: str, extent: float) -> None:
    """Writes the description and makes the octree. Paths are absolute: an octree knows no folder of its own."""
    description, folder = [materials, lights], radiance.folder
    curved = []
    for number, mesh in enumerate(scene.meshes):
        material = scene.materials[mesh.material]
        if material.emission.any():
            description.append(_emitter(number, mesh, material.two_sided, 1e-5 * extent))
        elif mesh.normals is None and mesh.uvs is None:
            description.append(_polygons(number, mesh, [mesh.positions[t] for t in mesh.triangles]))
        else:
            curved.append(mesh)
    if curved:
        (folder / "materials.rad").write_text(materials)
        (folder / "mesh.obj").write_text(_wavefront(curved))
        radiance._run(["obj2mesh", "-a", str(folder / "materials.rad"), str(folder / "mesh.obj"), str(folder / "mesh.rtm")])
        description.append(f"void mesh curved\n1 {folder / 'mesh.rtm'}\n0\n0\n")
    (folder / "scene.rad").write_text("\n".join(description))
    radiance.octree.write_bytes(radiance._run(["oconv", str(folder / "scene.rad")]))


def _material(folder: Path, number: int, material: Material) -> str:
    if material.emission.any():
        return f"void light m{number}\n0\n0\n3 {_numbers(material.emission)}\n"
    colour = f"plastic m{number}\n0\n0\n5 {_numbers(material.albedo)} 0 0\n"
    if material.texture is None:
        return f"void {colour}"
    picture = folder / f"m{number}.hdr"
    picture.write_bytes(_rgbe(material.texture))
    height, width = material.texture.shape[:2]
    u, v = max(width / height, 1), max(height / width, 1)
    pattern = f"void colorpict p{number}\n7 red green blue {picture} . {u:.9g}*frac(Lu) {v:.9g}*frac(Lv)\n0\n0\n"
    return f"{pattern}p{number} {colour}"


def _light(number: int, light: Light, extent: float) -> str:
    if light.kind == "directional":
        solid_angle = 2 * np.pi * (1 - np.cos(np.radians(SUN_DEGREES / 2)))
        shape = f"source l{number}\n0\n0\n4 {_numbers(-light.direction)} {SUN_DEGREES}\n"
        return f"void light e{number}\n0\n0\n3 {_numbers(light.colour / solid_angle)}\ne{number} {shape}"
    radius = 1e-4 * extent
    shape = f"sphere l{number}\n0\n0\n4 {_numbers(light.position)} {radius:.9g}\n"
    return f"void light e{number}\n0\n0\n3 {_numbers(light.colour / (np.pi * radius**2))}\ne{number} {shape}"


def _emitter(number: int, mesh: Mesh, two_sided: bool, gap: float) -> str:
    polygons = []
    for corners in polygons_of(mesh):
        polygons.append(corners)
        if two_sided:
            normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
            polygons.append(corners[::-1] - gap * normal / np.linalg.norm(normal))
    return _polygons(number, mesh, polygons)


def _polygons(number: int, mesh: Mesh, polygons: list[Floats]) -> str:
    return "\n".join(
        f"m{mesh.material} polygon s{number}.{k}\n0\n0\n{corners.size} {_numbers(corners.ravel())}\n"
        for k, corners in enumerate(polygons)
    )


def polygons_of(mesh: Mesh) -> list[Floats]:
    """The mesh's triangles, where two neighbours make a parallelogram as one polygon of four corners."""
    polygons, waiting = [], [mesh.positions[triangle] for triangle in mesh.triangles]
    while waiting:
        first = waiting.pop()
        for k, second in enumerate(waiting):
            merged = _parallelogram(first, second)
            if merged is not None:
                first = merged
                del waiting[k]
                break
        polygons.append(first)
    return polygons


def _parallelogram(first: Floats, second: Floats) -> Floats | None:
    size = np.ptp(first, axis=0).max()
    for turn in range(3):
        a, b, c = np.roll(first, -turn, axis=0)
        fourth = b + c - a  # opposite a, across the edge b–c
        for other in range(3):
            if np.abs(np.roll(second, -other, axis=0) - [fourth, c, b]).max() < 1e-6 * size:
                return np.array([a, b, fourth, c])
    return None


def _wavefront(meshes: list[Mesh]) -> str:
    """Wavefront OBJ of many meshes; glTF's v runs down the picture, Radiance's up."""
    lines: list[str] = []
    vertices = uvs = normals = 1  # OBJ counts each kind on its own, from 1
    for mesh in meshes:
        lines.append(f"usemtl m{mesh.material}")
        lines += [f"v {_numbers(p)}" for p in mesh.positions]
        corner = "{v}/{t}/{n}"
        if mesh.uvs is None:
            corner = corner.replace("{t}", "")
        else:
            lines += [f"vt {u:.9g} {1 - v:.9g}" for u, v in mesh.uvs]
        if mesh.normals is None:
            corner = corner.replace("/{n}", "")
        else:
            lines += [f"vn {_numbers(n)}" for n in mesh.normals]
        lines += [
            "f " + " ".join(corner.format(v=vertices + k, t=uvs + k, n=normals + k) for k in triangle)
            for triangle in mesh.triangles.tolist()
        ]
        vertices += len(mesh.positions)
        uvs += 0 if mesh.uvs is None else len(mesh.uvs)
        normals += 0 if mesh.normals is None else len(mesh.normals)
    return "\n".join(lines) + "\n"


def _rgbe(texture: NDArray[np.float32]) -> bytes:
    """A Radiance picture with flat (not run-length encoded) pixels."""
    height, width = texture.shape[:2]
    mantissa, exponent = np.frexp(texture.max(axis=2))
    scale = np.where(texture.max(axis=2) > 1e-32, np.ldexp(1.0, 8 - exponent), 0)
    pixels = np.zeros((height, width, 4), np.uint8)
    pixels[..., :3] = np.clip(texture * scale[..., None], 0, 255)
    pixels[..., 3] = np.where(scale > 0, exponent + 128, 0)
    header = f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n"
    return header.encode() + pixels.tobytes()


def _extent(scene: Scene) -> float:
    points = np.vstack([mesh.positions for mesh in scene.meshes])
    return float(np.ptp(points, axis=0).max())


def _numbers(values: Floats) -> str:
    return " ".join(f"{value:.9g}" for value in np.asarray(values).ravel())
