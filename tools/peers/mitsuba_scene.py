"""How a scene is said in Mitsuba.

- One PLY mesh a material with `twosided` `diffuse`; texture coordinates are those of the material's first texture, and the
  others' transforms are relative to it.
- A normal map is a `normalmap` about the two-sided surface, so that both sides are bent alike. Mitsuba takes the tangent
  from the texture coordinates; triangles whose handedness is the other one get the map with its second axis turned.
- An alpha mask is a `mask` whose opacity is 0 or 1, four times finer than the texture: where alpha, read between texels,
  passes the cutoff. `path` lets such surfaces cast whole shadows, so scenes with masks are traced by `volpath`.
- Emitters are black with an `area` emitter, which shines on the front only; a two-sided one gets a second mesh a hair
  behind the first, turned round.
- A spot light projects a texture of glTF's falloff, which is not Mitsuba's own; a map about the scene is an `envmap`, read
  again at Mitsuba's texel places.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from scene import Floats, Light, Material, Mesh, Scene, Use, refuse

Dict = dict[str, Any]

SPOT_TEXELS = 1024
WIDEST_SPOT = 85.0  # degrees; the projected texture of a wider one would be stretched too far


def describe(mi: Any, scene: Scene, folder: Path) -> Dict:
    """The dictionary that Mitsuba loads."""
    description: Dict = {"type": "scene"}
    gap = 1e-5 * scene.extent()
    number = 0
    for mesh in (half for mesh in scene.meshes for half in _by_handedness(mesh)):
        sides = [mesh, _behind(mesh, gap)] if mesh.material.emits() and mesh.material.two_sided else [mesh]
        for side in sides:
            path = folder / f"s{number}.ply"
            path.write_bytes(_ply(side))
            description[f"s{number}"] = _shape(mi, path, side)
            number += 1
    description |= {f"l{number}": _light(mi, light) for number, light in enumerate(scene.lights)}
    if scene.background is not None:
        description["sky"] = _sky(mi, scene.background)
    return description


def has_masks(scene: Scene) -> bool:
    """Whether any surface is cut by its alpha."""
    return any(mesh.material.mask() is not None for mesh in scene.meshes)


def _by_handedness(mesh: Mesh) -> list[Mesh]:
    if mesh.material.normal is None or mesh.tangents is None:
        return [mesh]
    left = mesh.tangents[mesh.triangles[:, 0], 3] < 0
    return [mesh.part(chosen) for chosen in (left, ~left) if chosen.any()]


def _behind(mesh: Mesh, gap: float) -> Mesh:
    turned = mesh.part(np.ones(len(mesh.triangles), bool))
    turned.positions, turned.normals = turned.positions - gap * turned.normals, -turned.normals
    turned.triangles = turned.triangles[:, ::-1]
    return turned


def _shape(mi: Any, path: Path, mesh: Mesh) -> Dict:
    material = mesh.material
    shape: Dict = {"type": "ply", "filename": str(path), "face_normals": mesh.is_flat()}
    if material.emits():
        bsdf: Dict = {"type": "diffuse", "reflectance": _rgb(np.zeros(3))}
        shape |= {"emitter": {"type": "area", "radiance": _radiance(mi, material)}}
    else:
        bsdf = {"type": "twosided", "diffuse": {"type": "diffuse", "reflectance": _albedo(mi, mesh)}}
        if material.normal is not None and mesh.tangents is not None:
            bsdf = {"type": "normalmap", "normalmap": _normals(mi, mesh), "bsdf": bsdf}
    present = material.mask()
    if present is not None:
        if material.emits():
            raise refuse(material, "Mitsuba's emitters cannot be cut by alpha")
        opacity = present.astype(np.float32)[..., None]
        bsdf = {"type": "mask", "opacity": _bitmap(mi, material, opacity, material.base, nearest=True), "bsdf": bsdf}
    return shape | {"bsdf": bsdf}


def _first(material: Material) -> Use | None:
    """The texture whose coordinates the mesh carries: a normal map's, for its tangents, before any other's."""
    return material.normal or material.base or material.emission_texture


def _bitmap(mi: Any, material: Material, texels: Any, use: Use, nearest: bool = False) -> Dict:
    # Mitsuba's bitmaps, like glTF's, have their first row at v = 0.
    first = _first(material)
    if use.set != first.set:
        raise refuse(material, "Mitsuba's meshes carry one set of texture coordinates, and it reads two")
    if use.texture.wrap[0] != use.texture.wrap[1]:
        raise refuse(material, f"Mitsuba wraps a texture the same way along both sides, '{use.texture.name}' does not")
    place = np.eye(4)
    place[np.ix_([0, 1, 3], [0, 1, 3])] = use.transform @ np.linalg.inv(first.transform)
    return {
        "type": "bitmap", "bitmap": mi.Bitmap(np.ascontiguousarray(texels, np.float32)), "raw": True,
        "wrap_mode": use.texture.wrap[0], "filter_type": "nearest" if nearest or use.texture.nearest else "bilinear",
        "to_uv": mi.ScalarTransform4f(place),
    }


def _albedo(mi: Any, mesh: Mesh) -> Dict:
    material = mesh.material
    if mesh.colours is not None and not (mesh.colours[:, :3] == 1).all():
        if material.base is not None:
            raise refuse(material, "Mitsuba has no product of a texture and vertex colours")
        return {"type": "mesh_attribute", "name": "vertex_color"}
    if material.base is None:
        return _rgb(material.albedo)
    return _bitmap(mi, material, material.base.texture.colour() * material.albedo, material.base)


def _radiance(mi: Any, material: Material) -> Dict:
    if material.emission_texture is None:
        return _rgb(material.emission)
    texels = material.emission_texture.texture.colour() * material.emission
    if not texels.any(axis=2).all():
        raise refuse(material, "Mitsuba's emitters do not reflect where their texture is black, hemicube's do")
    return _bitmap(mi, material, texels, material.emission_texture)


def _normals(mi: Any, mesh: Mesh) -> Dict:
    material = mesh.material
    side = -1.0 if mesh.tangents[mesh.triangles[0, 0], 3] < 0 else 1.0
    vectors = material.normal.texture.vectors() * [material.normal_scale, side * material.normal_scale, 1.0]
    return _bitmap(mi, material, 0.5 * vectors + 0.5, material.normal)


def _rgb(value: Floats) -> Dict:
    return {"type": "rgb", "value": value.tolist()}


def _light(mi: Any, light: Light) -> Dict:
    if light.kind == "directional":
        return {"type": "directional", "direction": light.direction.tolist(), "irradiance": _rgb(light.colour)}
    if light.kind == "point":
        return {"type": "point", "position": light.position.tolist(), "intensity": _rgb(light.colour)}
    degrees = float(np.degrees(np.arccos(light.cos_outer)))
    if degrees > WIDEST_SPOT:
        raise SystemExit(f"a spot light of half angle {degrees:.0f}°: Mitsuba's projected falloff ends at {WIDEST_SPOT:.0f}°")
    across = np.tan(np.radians(degrees)) * (2 * (np.arange(SPOT_TEXELS) + 0.5) / SPOT_TEXELS - 1)
    cos = 1 / np.sqrt(1 + across[:, None] ** 2 + across[None, :] ** 2)
    edge = np.clip((cos - light.cos_outer) / (light.cos_inner - light.cos_outer), 0, 1) ** 2
    texels = (edge[..., None] * np.ones(3)).astype(np.float32)
    up = np.eye(3)[np.argmin(np.abs(light.direction))]
    return {
        "type": "spot", "intensity": _rgb(light.colour), "cutoff_angle": degrees, "beam_width": 0.9999 * degrees,
        "texture": {"type": "bitmap", "bitmap": mi.Bitmap(texels), "raw": True, "wrap_mode": "clamp"},
        "to_world": mi.ScalarTransform4f().look_at(
            origin=light.position.tolist(), target=(light.position + light.direction).tolist(), up=up.tolist()
        ),
    }


def _sky(mi: Any, radiance: Floats) -> Dict:
    if radiance.ndim == 1:
        return {"type": "constant", "radiance": _rgb(radiance)}
    # Mitsuba's first and last rows are the poles themselves, ours half a row beside them; and its first column looks the
    # way that our middle one does.
    height, width = radiance.shape[:2]
    rows = np.clip(np.arange(2 * height) / (2 * height - 1) * height - 0.5, 0, height - 1)
    low = np.minimum(np.floor(rows).astype(int), height - 2) if height > 1 else np.zeros(2 * height, int)
    part = (rows - low)[:, None, None]
    again = radiance[low] * (1 - part) + radiance[np.minimum(low + 1, height - 1)] * part
    columns = (np.arange(width) + 0.5) / width * width - 0.5 + width / 2
    left = np.floor(columns).astype(int)
    share = (columns - left)[None, :, None]
    again = again[:, left % width] * (1 - share) + again[:, (left + 1) % width] * share
    return {"type": "envmap", "bitmap": mi.Bitmap(np.ascontiguousarray(again, np.float32)), "scale": 1.0}


def _ply(mesh: Mesh) -> bytes:
    """Binary PLY."""
    columns, names = [mesh.positions], ["x", "y", "z"]
    if not mesh.is_flat():
        columns, names = [*columns, mesh.normals], [*names, "nx", "ny", "nz"]
    first = _first(mesh.material)
    if first is not None:
        uvs = np.hstack([mesh.uvs[first.set], np.ones((len(mesh.positions), 1))]) @ first.transform.T
        columns, names = [*columns, uvs[:, :2]], [*names, "u", "v"]
    if mesh.colours is not None:
        colours = mesh.colours[:, :3] * mesh.material.albedo
        columns, names = [*columns, colours], [*names, "r", "g", "b"]
    faces = np.zeros(len(mesh.triangles), np.dtype([("count", "u1"), ("index", "<i4", 3)]))
    faces["count"], faces["index"] = 3, mesh.triangles
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(mesh.positions)}"]
    header += [f"property float {name}" for name in names]
    header += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header", ""]
    return "\n".join(header).encode() + np.hstack(columns).astype("<f4").tobytes() + faces.tobytes()
