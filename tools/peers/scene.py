"""A small glTF reader: just what the other renderers need, with NumPy alone.

Every surface is taken as Lambertian and two-sided, emitters as black and one-sided unless the material is
double-sided: the same reading of glTF as hemicube's. What is not read is said in `Scene.notes`, never dropped in silence.
"""

from __future__ import annotations

import base64
import json
import struct
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Json = dict[str, Any]

READ_EXTENSIONS = {
    "KHR_lights_punctual", "KHR_materials_emissive_strength", "KHR_mesh_quantization", "KHR_texture_transform",
}
COMPONENT = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTH = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}


@dataclass
class Material:
    """Diffuse reflectance (linear Rec.709) times an optional texture, and emitted radiance."""

    name: str
    albedo: Floats
    texture: NDArray[np.float32] | None  # linear, height × width × 3, first row at v = 0
    emission: Floats
    two_sided: bool


@dataclass
class Mesh:
    """Triangles of one material, in world space."""

    material: int
    positions: Floats  # vertices × 3
    normals: Floats | None  # vertices × 3, unit; None: flat
    uvs: Floats | None  # vertices × 2, v downwards
    triangles: NDArray[np.int64]  # triangles × 3


@dataclass
class Light:
    """A directional or point light; `colour` is irradiance (directional) or intensity (point)."""

    kind: str
    colour: Floats
    position: Floats
    direction: Floats  # the way its light travels


@dataclass
class Camera:
    """A perspective camera, looking along `forward`."""

    position: Floats
    right: Floats
    up: Floats
    forward: Floats
    yfov: float

    def rays(self, width: int, height: int) -> Floats:
        """Origins and unit directions through pixel centres, rows from the top: (height·width) × 6."""
        tangent = np.tan(self.yfov / 2)
        x = (2 * (np.arange(width) + 0.5) / width - 1) * tangent * width / height
        y = (1 - 2 * (np.arange(height) + 0.5) / height) * tangent
        direction = (
            self.forward + x[None, :, None] * self.right + y[:, None, None] * self.up
        ).reshape(-1, 3)
        direction /= np.linalg.norm(direction, axis=1, keepdims=True)
        return np.hstack([np.broadcast_to(self.position, direction.shape), direction])


@dataclass
class Scene:
    """What both renderers are given."""

    materials: list[Material]
    meshes: list[Mesh] = field(default_factory=list)
    lights: list[Light] = field(default_factory=list)
    cameras: list[Camera] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)


def load(path: Path) -> Scene:
    """Reads a .gltf or .glb file; what it cannot read ends the program with one line."""
    try:
        scene = _Reader(path).scene()
    except (KeyError, IndexError, TypeError, AttributeError, ValueError, OSError, RecursionError, struct.error) as error:
        raise SystemExit(f"{path}: not a glTF file that this reader understands: {error!r}") from error
    if not scene.meshes:
        raise SystemExit(f"{path}: no triangles")
    return scene


class _Reader:
    def __init__(self, path: Path) -> None:
        self.folder = path.parent
        data = path.read_bytes()
        self.binary = b""
        if data[:4] == b"glTF":
            length = struct.unpack_from("<I", data, 12)[0]
            self.json: Json = json.loads(data[20 : 20 + length])
            self.binary = data[28 + length :]
        else:
            self.json = json.loads(data)
        unknown = set(self.json.get("extensionsRequired", [])) - READ_EXTENSIONS
        if unknown:
            raise SystemExit(f"{path}: required extensions that this reader lacks: {', '.join(sorted(unknown))}")
        self.buffers = [self._bytes(buffer) for buffer in self.json.get("buffers", [])]
        self.notes: list[str] = []

    def scene(self) -> Scene:
        materials = [self._material(m) for m in self.json.get("materials", [])]
        materials.append(Material("default", np.ones(3), None, np.zeros(3), False))
        scene = Scene(materials, notes=self.notes)
        which = self.json.get("scene", 0)
        for node in self.json["scenes"][which]["nodes"]:
            self._node(scene, node, np.eye(4))
        return scene

    def _bytes(self, item: Json) -> bytes:
        uri = item.get("uri")
        if uri is None:
            return self.binary
        if uri.startswith("data:"):
            return base64.b64decode(uri.split(",", 1)[1])
        return (self.folder / uri).read_bytes()

    def _view(self, index: int) -> tuple[bytes, int]:
        view = self.json["bufferViews"][index]
        start = view.get("byteOffset", 0)
        return self.buffers[view["buffer"]][start : start + view["byteLength"]], view.get("byteStride", 0)

    def _accessor(self, index: int) -> NDArray[Any]:
        accessor = self.json["accessors"][index]
        if "sparse" in accessor or "bufferView" not in accessor:
            raise SystemExit(f"accessor {index}: sparse accessors are not read")
        kind, width = np.dtype(COMPONENT[accessor["componentType"]]), WIDTH[accessor["type"]]
        data, stride = self._view(accessor["bufferView"])
        values = np.ndarray(
            (accessor["count"], width), kind, data, accessor.get("byteOffset", 0),
            (stride or kind.itemsize * width, kind.itemsize),
        )
        if accessor.get("normalized"):
            return np.maximum(values / np.iinfo(kind).max, -1.0)
        return values

    def _node(self, scene: Scene, index: int, parent: Floats) -> None:
        node = self.json["nodes"][index]
        matrix = parent @ _local(node)
        if "mesh" in node:
            for primitive in self.json["meshes"][node["mesh"]]["primitives"]:
                self._primitive(scene, primitive, matrix)
        if "camera" in node:
            scene.cameras.append(self._camera(node["camera"], matrix))
        light = node.get("extensions", {}).get("KHR_lights_punctual")
        if light:
            scene.lights.append(self._light(light["light"], matrix))
        for child in node.get("children", []):
            self._node(scene, child, matrix)

    def _primitive(self, scene: Scene, primitive: Json, matrix: Floats) -> None:
        if primitive.get("mode", 4) != 4:
            self.notes.append("a primitive that is not a triangle list is left out")
            return
        attributes = primitive["attributes"]
        material = primitive.get("material", len(scene.materials) - 1)
        positions = self._accessor(attributes["POSITION"]).astype(float) @ matrix[:3, :3].T + matrix[:3, 3]
        normals = uvs = None
        if "NORMAL" in attributes:
            normals = self._accessor(attributes["NORMAL"]).astype(float) @ np.linalg.inv(matrix[:3, :3])
            normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
        if "TEXCOORD_0" in attributes and scene.materials[material].texture is not None:
            uvs = self._transformed(self._accessor(attributes["TEXCOORD_0"]).astype(float), material)
        if "indices" in primitive:
            triangles = self._accessor(primitive["indices"]).astype(np.int64).reshape(-1, 3)
        else:
            triangles = np.arange(len(positions)).reshape(-1, 3)
        if np.linalg.det(matrix[:3, :3]) < 0:
            triangles = triangles[:, ::-1]
        scene.meshes.append(Mesh(material, positions, normals, uvs, _without_zero_area(positions, triangles)))

    def _transformed(self, uvs: Floats, material: int) -> Floats:
        texture = self.json["materials"][material]["pbrMetallicRoughness"]["baseColorTexture"]
        transform = texture.get("extensions", {}).get("KHR_texture_transform", {})
        angle = transform.get("rotation", 0.0)
        rotation = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        return (uvs * transform.get("scale", [1, 1])) @ rotation.T + transform.get("offset", [0, 0])

    def _camera(self, index: int, matrix: Floats) -> Camera:
        right, up, back = (matrix[:3, k] / np.linalg.norm(matrix[:3, k]) for k in range(3))
        return Camera(matrix[:3, 3], right, up, -back, self.json["cameras"][index]["perspective"]["yfov"])

    def _light(self, index: int, matrix: Floats) -> Light:
        light = self.json["extensions"]["KHR_lights_punctual"]["lights"][index]
        if light["type"] == "spot":
            raise SystemExit("spot lights: neither Radiance's nor Mitsuba's falloff is glTF's, so they are not exported")
        colour = np.array(light.get("color", [1, 1, 1]), float) * light.get("intensity", 1.0)
        direction = -matrix[:3, 2] / np.linalg.norm(matrix[:3, 2])
        return Light(light["type"], colour, matrix[:3, 3], direction)

    def _material(self, material: Json) -> Material:
        name = material.get("name", "unnamed")
        pbr = material.get("pbrMetallicRoughness", {})
        strength = material.get("extensions", {}).get("KHR_materials_emissive_strength", {}).get("emissiveStrength", 1.0)
        emission = np.array(material.get("emissiveFactor", [0, 0, 0]), float) * strength
        for key in ("normalTexture", "emissiveTexture"):
            if key in material:
                self.notes.append(f"material '{name}': {key} is not exported")
        if material.get("alphaMode", "OPAQUE") != "OPAQUE":
            self.notes.append(f"material '{name}': taken as opaque")
        albedo = np.array(pbr.get("baseColorFactor", [1, 1, 1, 1])[:3], float)
        texture = None
        if "baseColorTexture" in pbr:
            texture = self._image(self.json["textures"][pbr["baseColorTexture"]["index"]]["source"])
        return Material(name, albedo, texture, emission, material.get("doubleSided", False))

    def _image(self, index: int) -> NDArray[np.float32]:
        import io

        from PIL import Image

        image = self.json["images"][index]
        data = self._view(image["bufferView"])[0] if "bufferView" in image else self._bytes(image)
        encoded = np.asarray(Image.open(io.BytesIO(data)).convert("RGB"), np.float32) / 255
        # IEC 61966-2-1, the inverse of the sRGB transfer function
        return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4).astype(np.float32)


def _local(node: Json) -> Floats:
    if "matrix" in node:
        return np.array(node["matrix"], float).reshape(4, 4).T
    x, y, z, w = node.get("rotation", [0, 0, 0, 1])
    rotation = np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ])
    matrix = np.eye(4)
    matrix[:3, :3] = rotation * np.array(node.get("scale", [1, 1, 1]), float)
    matrix[:3, 3] = node.get("translation", [0, 0, 0])
    return matrix


def _without_zero_area(positions: Floats, triangles: NDArray[np.int64]) -> NDArray[np.int64]:
    a, b, c = (positions[triangles[:, k]] for k in range(3))
    return triangles[np.linalg.norm(np.cross(b - a, c - a), axis=1) > 0]
