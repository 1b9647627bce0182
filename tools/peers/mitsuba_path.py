"""Mitsuba 3 (https://mitsuba-renderer.org): path tracing, vectorised over the CPU's cores by LLVM.

How a scene is said in Mitsuba: one PLY mesh a material with `twosided` `diffuse`; emitters are black with an `area`
emitter, which shines on the front only; directional and point lights are its own, in glTF's units.

How it is run: the first hits of the rays through pixel centres are found once. From each, cosine-distributed directions
about the shading normal, on the viewer's side, go to Mitsuba's own `path` integrator, whose answer, less the light that
it sees directly, is the light that has been reflected at least once; π times its mean is indirect irradiance. `max_depth`
counts edges: with this start, N + 1 is N bounces. That spares Mitsuba the first hit and the direct light there, which a
plain image pays for with every sample; finding the light that is seen directly costs it one intersection a sample, about
a fifth, in scenes with emitters.

The LLVM variant needs LLVM's library (Debian: libllvm19, by tools/setup.sh --peers). Without it Mitsuba is left out
rather than run as `scalar_rgb`, one ray at a time from Python: that would measure Python.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from scene import Floats, Light, Material, Mesh, Scene
from timing import Timed, measure_self

# Samples a pixel, from quick to careful. multijitter has less error than independent for the same time.
SETTINGS: list[dict[str, Any]] = [{"spp": spp, "sampler": "multijitter"} for spp in (16, 64, 256, 1024)]

BATCH = 1 << 24  # rays at once: samples are stratified within a batch, and this one takes a few hundred MB


@dataclass
class Mitsuba:
    """A scene loaded, with the rays to follow."""

    mi: Any
    scene: Any
    rays: Floats
    shape: tuple[int, int]
    setup: Timed
    has_emitters: bool

    def version(self) -> str:
        """The program's name, version and variant."""
        return f"Mitsuba {self.mi.__version__} {self.mi.variant()}"

    def irradiance(self, bounces: int, threads: int, settings: dict[str, Any]) -> tuple[Floats, Timed]:
        """Indirect irradiance of 1 to `bounces` bounces at the first hit of each ray, and its cost without compilation."""
        import drjit

        drjit.set_thread_count(threads)
        passes = _passes(settings["spp"], max(BATCH // len(self.rays), 1))
        self._gather(bounces, settings["sampler"], passes[:1])  # compiles
        image, timed = measure_self(lambda: self._gather(bounces, settings["sampler"], passes))
        drjit.set_thread_count(os.cpu_count() or 1)  # with one thread left, writing an EXR would wait for ever
        return image.reshape(*self.shape, 3), timed

    def _gather(self, bounces: int, kind: str, passes: list[int]) -> Floats:
        import drjit as dr

        mi, count = self.mi, len(self.rays)
        hits = self._first_hits()
        total = np.zeros((count, 3))
        for seed, spp in enumerate(passes):
            sampler = mi.load_dict({"type": kind, "sample_count": spp})
            sampler.set_samples_per_wavefront(spp)
            sampler.seed(seed, count * spp)
            radiance = self._bounced(hits, dr.arange(mi.UInt32, count * spp) // spp, bounces, sampler)
            dr.eval(radiance)  # once, not once a channel
            sums = [np.array(dr.block_sum(channel, spp)) for channel in radiance]
            total += np.stack(sums, axis=1)
        return total * (np.pi / sum(passes))

    def _first_hits(self) -> Any:
        """Where the rays land: hit or not, origin of the rays to come, frame about the shading normal."""
        import drjit as dr

        mi = self.mi
        origin, direction = (mi.Point3f(self.rays[:, :3].T), mi.Vector3f(self.rays[:, 3:].T))
        si = self.scene.ray_intersect(mi.Ray3f(origin, direction))
        normal = dr.select(dr.dot(si.sh_frame.n, direction) > 0, -si.sh_frame.n, si.sh_frame.n)
        side = dr.select(dr.dot(si.n, direction) > 0, -si.n, si.n)
        start = si.p + side * (1 + dr.max(dr.abs(si.p))) * mi.math.RayEpsilon
        hits = si.is_valid(), start, normal
        dr.eval(*hits)
        return hits

    def _bounced(self, hits: Any, pixel: Any, bounces: int, sampler: Any) -> Any:
        """Radiance that arrives in one cosine-distributed direction a ray, having been reflected on the way."""
        import drjit as dr

        mi = self.mi
        valid, start, normal = (dr.gather(type(field), field, pixel) for field in hits)
        local = mi.warp.square_to_cosine_hemisphere(sampler.next_2d())
        ray = mi.Ray3f(start, mi.Frame3f(normal).to_world(local))
        path = mi.load_dict({"type": "path", "max_depth": bounces + 1})
        radiance = path.sample(self.scene, sampler, mi.RayDifferential3f(ray), None, valid)[0]
        if self.has_emitters:
            seen = self.scene.ray_intersect(ray, valid)
            radiance -= seen.emitter(self.scene, valid).eval(seen, valid)
        return radiance & valid


def export(scene: Scene, rays: Floats, shape: tuple[int, int], folder: Path) -> Mitsuba | None:
    """Writes and loads the scene; None where Mitsuba finds no LLVM."""
    import mitsuba as mi

    folder.mkdir(parents=True, exist_ok=True)
    try:
        mi.set_variant("llvm_ad_rgb")
        mi.Float(1) + 1  # starts LLVM
    except (ImportError, RuntimeError) as error:
        print(f"Mitsuba left out, no LLVM library (try tools/setup.sh --peers): {str(error).splitlines()[0]}")
        return None
    description: dict[str, Any] = {"type": "scene"}
    for number, mesh in enumerate(scene.meshes):
        path = folder / f"s{number}.ply"
        path.write_bytes(_ply(mesh))
        description[f"s{number}"] = _shape(mi, path, mesh, scene.materials[mesh.material])
    description |= {f"l{number}": _light(light) for number, light in enumerate(scene.lights)}
    loaded, setup = measure_self(lambda: mi.load_dict(description))
    has_emitters = any(scene.materials[mesh.material].emission.any() for mesh in scene.meshes)
    return Mitsuba(mi, loaded, rays, shape, setup, has_emitters)


def _shape(mi: Any, path: Path, mesh: Mesh, material: Material) -> dict[str, Any]:
    shape = {"type": "ply", "filename": str(path), "face_normals": mesh.normals is None}
    if not material.emission.any():
        return shape | {"bsdf": {"type": "twosided", "diffuse": {"type": "diffuse", "reflectance": _albedo(mi, material)}}}
    if material.two_sided:
        raise SystemExit(f"material '{material.name}': Mitsuba's area emitters shine on one side only")
    black = {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0, 0, 0]}}
    return shape | {"bsdf": black, "emitter": {"type": "area", "radiance": _colour(material.emission)}}


def _albedo(mi: Any, material: Material) -> dict[str, Any]:
    if material.texture is None:
        return _colour(material.albedo)
    # Mitsuba's bitmaps, like glTF's, have their first row at v = 0
    texture = (material.texture * material.albedo).astype(np.float32)
    return {"type": "bitmap", "bitmap": mi.Bitmap(np.ascontiguousarray(texture)), "raw": True}


def _colour(value: Floats) -> dict[str, Any]:
    return {"type": "rgb", "value": value.tolist()}


def _light(light: Light) -> dict[str, Any]:
    if light.kind == "directional":
        return {"type": "directional", "direction": light.direction.tolist(), "irradiance": _colour(light.colour)}
    return {"type": "point", "position": light.position.tolist(), "intensity": _colour(light.colour)}


def _passes(spp: int, most: int) -> list[int]:
    """Splits samples into passes of equal size, so that one compiled program serves all."""
    count = -(-spp // most)
    return [-(-spp // count)] * count


def _ply(mesh: Mesh) -> bytes:
    """Binary PLY."""
    columns, names = [mesh.positions], ["x", "y", "z"]
    if mesh.normals is not None:
        columns, names = [*columns, mesh.normals], [*names, "nx", "ny", "nz"]
    if mesh.uvs is not None:
        columns, names = [*columns, mesh.uvs], [*names, "u", "v"]
    faces = np.zeros(len(mesh.triangles), np.dtype([("count", "u1"), ("index", "<i4", 3)]))
    faces["count"], faces["index"] = 3, mesh.triangles
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(mesh.positions)}"]
    header += [f"property float {name}" for name in names]
    header += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header", ""]
    return "\n".join(header).encode() + np.hstack(columns).astype("<f4").tobytes() + faces.tobytes()
