"""A scene as `hemicube export` writes it: triangles in world space, and the points that irradiance is asked for at.

Every surface is Lambertian and two-sided, emitters are black and one-sided unless the material is double-sided: the
same reading of glTF as hemicube's, because it is hemicube's.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Json = dict[str, Any]


@dataclass
class Texture:
    """8-bit RGBA as in the file, first row at v = 0, and how it is read."""

    name: str
    pixels: NDArray[np.uint8]  # height × width × 4
    wrap: tuple[str, str]  # repeat, mirror or clamp, along u and v
    nearest: bool

    def colour(self) -> NDArray[np.float32]:
        """Linear RGB of sRGB texels (IEC 61966-2-1)."""
        encoded = self.pixels[..., :3].astype(np.float32) / 255
        return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4).astype(np.float32)

    def vectors(self) -> NDArray[np.float32]:
        """Texels as vectors, each from -1 to 1."""
        return self.pixels[..., :3].astype(np.float32) / 127.5 - 1

    def present(self, cutoff: float, finer: int = 4) -> NDArray[np.bool_]:
        """Where alpha, read between texels, is not below the cutoff; so many times finer than the texture."""
        finer = 1 if self.nearest else finer
        alpha = self.pixels[..., 3].astype(np.float32) / 255
        for axis in (0, 1):
            size = alpha.shape[axis]
            at = (np.arange(size * finer) + 0.5) / finer - 0.5
            low = np.floor(at).astype(int)
            part = (at - low).astype(np.float32).reshape((-1, 1) if axis == 0 else (1, -1))
            wrap = self.wrap[1 - axis]
            first, second = (np.take(alpha, wrapped(i, size, wrap), axis) for i in (low, low + 1))
            alpha = first * (1 - part) + second * part
        return alpha >= cutoff


def wrapped(index: NDArray[np.int64], size: int, wrap: str) -> NDArray[np.int64]:
    """Texels that stand for those outside the texture."""
    if wrap == "repeat":
        return index % size
    if wrap == "clamp":
        return np.clip(index, 0, size - 1)
    folded = index % (2 * size)
    return np.minimum(folded, 2 * size - 1 - folded)


@dataclass
class Use:
    """A texture as a material reads it: at transform · (u, v, 1) of a set of coordinates."""

    texture: Texture
    set: int
    transform: Floats  # 3 × 3


@dataclass
class Material:
    """Diffuse reflectance (linear Rec.709) and emitted radiance, each times an optional texture."""

    name: str
    albedo: Floats
    alpha: float
    base: Use | None
    normal: Use | None
    normal_scale: float
    emission: Floats
    emission_texture: Use | None
    cutoff: float | None  # the surface is absent where alpha is below; None: opaque
    two_sided: bool

    def emits(self) -> bool:
        """Whether any point of it does."""
        return bool(self.emission.any())

    def mask(self) -> NDArray[np.bool_] | None:
        """Where the surface is, over its base texture; None: everywhere."""
        if self.cutoff is None or self.base is None:
            return None
        present = self.base.texture.present(self.cutoff / max(self.alpha, 1e-9))
        return None if present.all() else present


@dataclass
class Mesh:
    """Triangles of one material, in world space."""

    material: Material
    positions: Floats  # vertices × 3
    normals: Floats  # vertices × 3, unit
    tangents: Floats | None  # vertices × 4, handedness last
    uvs: list[Floats | None]  # sets 0 and 1: vertices × 2, v downwards
    colours: Floats | None  # vertices × 4
    triangles: NDArray[np.int64]  # triangles × 3

    def is_flat(self) -> bool:
        """Whether every triangle's normals are its own."""
        a, b, c = (self.positions[self.triangles[:, k]] for k in range(3))
        own = np.cross(b - a, c - a)
        own /= np.linalg.norm(own, axis=1, keepdims=True)
        return bool((np.einsum("tkc,tc->tk", self.normals[self.triangles], own) > 1 - 1e-5).all())

    def part(self, chosen: NDArray[np.bool_]) -> Mesh:
        """Some of its triangles."""
        used, indices = np.unique(self.triangles[chosen], return_inverse=True)

        def of(stream: Floats | None) -> Floats | None:
            return None if stream is None else stream[used]

        return Mesh(
            self.material, self.positions[used], self.normals[used], of(self.tangents), [of(uv) for uv in self.uvs],
            of(self.colours), indices.reshape(-1, 3),
        )


@dataclass
class Light:
    """A punctual light; `colour` is irradiance (directional) or intensity (point, spot)."""

    kind: str
    colour: Floats
    position: Floats
    direction: Floats  # the way its light travels; of a spot its axis
    cos_inner: float = 0.0
    cos_outer: float = 0.0


@dataclass
class Points:
    """What each pixel's centre sees, row by row: where irradiance is asked for."""

    shape: tuple[int, int]  # height, width
    positions: Floats
    normals: Floats  # shading normals on the viewer's side
    sides: Floats  # normals of the triangles, on the same side
    reflect: NDArray[np.bool_]  # where a surface is seen that does not emit
    mapped: NDArray[np.bool_]  # where the surface that is seen has a normal map

    def bent(self) -> NDArray[np.bool_]:
        """Where a normal map turns the normal, by a degree or more."""
        return self.mapped & (np.einsum("pc,pc->p", self.normals, self.sides) < 0.99985)


@dataclass
class Scene:
    """What the other renderers are given."""

    meshes: list[Mesh]
    lights: list[Light]
    background: Floats | None  # radiance: three numbers, or an equirectangular map, height × width × 3
    points: Points

    def extent(self) -> float:
        """Longest side of the box about all triangles."""
        return float(np.ptp(np.vstack([mesh.positions for mesh in self.meshes]), axis=0).max())


def load(folder: Path) -> Scene:
    """Reads a folder that `hemicube export` wrote."""
    json_ = json.loads((folder / "scene.json").read_text())

    def array(name: str) -> NDArray[Any] | None:
        file = json_["files"].get(name)
        return None if file is None else np.fromfile(folder / name, file["kind"]).reshape(-1, file["columns"])

    def doubles(name: str) -> Floats | None:
        found = array(name)
        return None if found is None else found.astype(float)

    textures = []
    for number, texture in enumerate(json_["textures"]):
        pixels = array(f"texture{number}").reshape(texture["height"], texture["width"], 4)
        textures.append(Texture(texture["name"], pixels, tuple(texture["wrap"]), texture["nearest"]))
    materials = [_material(material, textures) for material in json_["materials"]]
    whole = Mesh(
        materials[0], doubles("positions"), doubles("normals"), doubles("tangents"), [doubles("uv0"), doubles("uv1")],
        doubles("colors"), array("triangles").astype(np.int64),
    )
    meshes = []
    for part in json_["parts"]:
        chosen = np.zeros(len(whole.triangles), bool)
        chosen[part["first_triangle"] : part["first_triangle"] + part["triangle_count"]] = True
        mesh = whole.part(chosen)
        mesh.material = materials[part["material"]]
        if mesh.material.base is not None or mesh.material.cutoff is None or mesh.material.alpha >= mesh.material.cutoff:
            meshes.append(mesh)
    lights = [
        Light(
            light["kind"], np.array(light["colour"]), np.array(light.get("position", [0, 0, 0])),
            np.array(light.get("direction", [0, 0, -1])), light.get("cos_inner", 0.0), light.get("cos_outer", 0.0),
        )
        for light in json_["lights"]
    ]
    pixels = array("pixels")
    mapped = np.zeros(len(whole.triangles), bool)
    for part in json_["parts"]:
        end = part["first_triangle"] + part["triangle_count"]
        mapped[part["first_triangle"] : end] = materials[part["material"]].normal is not None
    reflect = pixels[:, 9] > 0.5
    points = Points(
        (json_["height"], json_["width"]), pixels[:, :3], pixels[:, 3:6], pixels[:, 6:9], reflect,
        reflect & mapped[pixels[:, 10].astype(int)],
    )
    sky = json_["background"]
    if sky is not None:
        sky = np.array(sky["radiance"]) if "radiance" in sky else doubles("background").reshape(sky["height"], sky["width"], 3)
    return Scene(meshes, lights, sky, points)


def _material(json_: Json, textures: list[Texture]) -> Material:
    def use(key: str) -> Use | None:
        used = json_[key]
        return used and Use(textures[used["texture"]], used["set"], np.array(used["transform"]))

    colour = np.array(json_["base_color"])
    return Material(
        json_["name"] or "without a name", colour[:3], colour[3], use("base_texture"), use("normal_texture"),
        json_["normal_scale"], np.array(json_["emission"]), use("emission_texture"), json_["alpha_cutoff"],
        json_["double_sided"],
    )


def refuse(material: Material, what: str) -> SystemExit:
    """Ends the program with one line."""
    return SystemExit(f"material '{material.name}': {what}")
