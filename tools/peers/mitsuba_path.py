"""Mitsuba 3 (https://mitsuba-renderer.org): path tracing, vectorised over the CPU's cores by LLVM.

How a scene is said in Mitsuba stands in mitsuba_scene.py.

How it is run: from each point, cosine-distributed directions about the shading normal, on the viewer's side, go to
Mitsuba's own `path` integrator (`volpath` where surfaces are cut by alpha), whose answer, less the light that it sees
directly, is the light that has been reflected at least once; π times its mean is indirect irradiance. `max_depth` counts
edges: with this start, N + 1 is N bounces. That spares Mitsuba the first hit and the direct light there, which a plain
image pays for with every sample; finding the light that is seen directly costs it one intersection a sample, about a
fifth, in scenes with emitters or a sky.

The LLVM variant needs LLVM's library (Debian: libllvm19, by tools/setup.sh --peers). Without it Mitsuba is left out
rather than run as `scalar_rgb`, one ray at a time from Python: that would measure Python.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import mitsuba_scene
from scene import Floats, Points, Scene
from timing import Timed, measure_self

# Samples a pixel, from quick to careful. multijitter has less error than independent for the same time.
SETTINGS: list[dict[str, Any]] = [{"spp": spp, "sampler": "multijitter"} for spp in (16, 64, 256, 1024)]

BATCH = 1 << 24  # rays at once: samples are stratified within a batch, and this one takes a few hundred MB


@dataclass
class Mitsuba:
    """A scene loaded, with the points to ask for."""

    mi: Any
    scene: Any
    points: Points
    setup: Timed
    sees_light: bool
    integrator: str

    def version(self) -> str:
        """The program's name, version and variant."""
        return f"Mitsuba {self.mi.__version__} {self.mi.variant()}"

    def irradiance(self, bounces: int, threads: int, settings: dict[str, Any]) -> tuple[Floats, Timed]:
        """Indirect irradiance of 1 to `bounces` bounces, or direct irradiance for 0, and its cost without compilation."""
        import drjit

        drjit.set_thread_count(threads)
        passes = _passes(settings["spp"], max(BATCH // self.points.reflect.sum(), 1))
        self._gather(bounces, settings["sampler"], passes[:1])  # compiles
        values, timed = measure_self(lambda: self._gather(bounces, settings["sampler"], passes))
        drjit.set_thread_count(os.cpu_count() or 1)  # with one thread left, writing an EXR would wait for ever
        image = np.zeros((len(self.points.reflect), 3))
        image[self.points.reflect] = values
        return image.reshape(*self.points.shape, 3), timed

    def _gather(self, bounces: int, kind: str, passes: list[int]) -> Floats:
        import drjit as dr

        mi, starts = self.mi, self._starts()
        count = int(self.points.reflect.sum())
        total = np.zeros((count, 3))
        for seed, spp in enumerate(passes):
            sampler = mi.load_dict({"type": kind, "sample_count": spp})
            sampler.set_samples_per_wavefront(spp)
            sampler.seed(seed, count * spp)
            point = dr.arange(mi.UInt32, count * spp) // spp
            start, normal, side = (dr.gather(type(field), field, point) for field in starts)
            if bounces == 0:
                radiance = self._lights(start, normal, side, sampler)
            else:
                radiance = self._bounced(start, normal, side, bounces, sampler)
            dr.eval(radiance)  # once, not once a channel
            sums = [np.array(dr.block_sum(channel, spp)) for channel in radiance]
            total += np.stack(sums, axis=1)
        return total * (np.pi / sum(passes))

    def _starts(self) -> tuple[Any, Any, Any]:
        """Where rays start, a hair off the surface as Mitsuba's own do, and both normals there."""
        import drjit as dr

        chosen = self.points.reflect
        positions, normals, sides = (
            self.mi.Vector3f(field[chosen].T) for field in (self.points.positions, self.points.normals, self.points.sides)
        )
        starts = positions + sides * (1 + dr.max(dr.abs(positions))) * self.mi.math.RayEpsilon
        dr.eval(starts, normals, sides)
        return starts, normals, sides

    def _bounced(self, start: Any, normal: Any, side: Any, bounces: int, sampler: Any) -> Any:
        """Radiance that arrives in one cosine-distributed direction a ray, having been reflected on the way.

        Directions below the triangle bring nothing.
        """
        import drjit as dr

        mi = self.mi
        direction = mi.Frame3f(normal).to_world(mi.warp.square_to_cosine_hemisphere(sampler.next_2d()))
        ray, above = mi.RayDifferential3f(mi.Ray3f(mi.Point3f(start), direction)), dr.dot(direction, side) > 0
        radiance = self._follow(ray, bounces + 1, sampler, above)
        if self.sees_light:
            radiance -= self._follow(ray, 1, sampler, above)
        return radiance & above

    def _follow(self, ray: Any, depth: int, sampler: Any, active: Any) -> Any:
        integrator = self.mi.load_dict({"type": self.integrator, "max_depth": depth})
        return integrator.sample(self.scene, sampler, ray, None, active)[0]

    def _lights(self, start: Any, normal: Any, side: Any, sampler: Any) -> Any:
        """Direct irradiance over π by a sample of a light each: for checks, not for speed."""
        import drjit as dr

        mi = self.mi
        point = dr.zeros(mi.Interaction3f, dr.width(start))
        point.p, point.n, point.t = mi.Point3f(start), mi.Normal3f(side), 0
        light, weight = self.scene.sample_emitter_direction(point, sampler.next_2d(), False, True)
        ray, rest = point.spawn_ray_to(light.p), mi.Color3f(1)
        for _ in range(4 if self.integrator == "volpath" else 1):  # surfaces that alpha lets light through
            hit = self.scene.ray_intersect(ray)
            rest *= dr.select(hit.is_valid(), hit.bsdf().eval_null_transmission(hit, hit.is_valid()), 1)
            ray = dr.select(hit.is_valid(), hit.spawn_ray_to(light.p), ray)
        cos = dr.select(dr.dot(light.d, side) > 0, dr.maximum(dr.dot(light.d, normal), 0), 0)
        return weight * rest * (cos / dr.pi)


def export(scene: Scene, folder: Path) -> Mitsuba | None:
    """Writes and loads the scene; None where Mitsuba finds no LLVM."""
    import mitsuba as mi

    folder.mkdir(parents=True, exist_ok=True)
    try:
        mi.set_variant("llvm_ad_rgb")
        mi.Float(1) + 1  # starts LLVM
    except (ImportError, RuntimeError) as error:
        print(f"Mitsuba left out, no LLVM library (try tools/setup.sh --peers): {str(error).splitlines()[0]}")
        return None
    description = mitsuba_scene.describe(mi, scene, folder)
    loaded, setup = measure_self(lambda: mi.load_dict(description))
    sees_light = scene.background is not None or any(mesh.material.emits() for mesh in scene.meshes)
    integrator = "volpath" if mitsuba_scene.has_masks(scene) else "path"
    return Mitsuba(mi, loaded, scene.points, setup, sees_light, integrator)


def _passes(spp: int, most: int) -> list[int]:
    """Splits samples into passes of equal size, so that one compiled program serves all."""
    count = -(-spp // most)
    return [-(-spp // count)] * count
