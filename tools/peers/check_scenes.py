"""Small glTF scenes, one a feature: a room open to the viewer and, above, to the sky."""

from __future__ import annotations

import base64
import json
import math
import struct
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

Json = dict[str, Any]
Rows = list[list[float]]


class Room:
    """Floor, back and side walls of a room of 2 × 2 × 2 about the origin, and what is added to it."""

    def __init__(self) -> None:
        self.data = b""
        self.json: Json = {
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}],
            "nodes": [{"mesh": 0}, {"camera": 0, "translation": [0, 0.2, 4.2]}],
            "cameras": [{"type": "perspective", "perspective": {"yfov": 0.6, "znear": 0.1}}],
            "meshes": [{"primitives": []}], "materials": [], "accessors": [], "bufferViews": [], "buffers": [],
            "textures": [], "images": [], "samplers": [], "extensionsUsed": [], "extensions": {},
        }
        white, red = self.material([0.7, 0.7, 0.7]), self.material([0.7, 0.2, 0.1])
        self.floor = self.quad([[-1, -1, 1], [1, -1, 1], [1, -1, -1], [-1, -1, -1]], white)
        self.wall = self.quad([[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1]], white)
        self.quad([[-1, -1, 1], [-1, -1, -1], [-1, 1, -1], [-1, 1, 1]], red)
        self.quad([[1, -1, -1], [1, -1, 1], [1, 1, 1], [1, 1, -1]], white)

    def material(self, colour: list[float], **more: Any) -> int:
        """Index of a new material."""
        pbr = {"baseColorFactor": [*colour, 1]} | more.pop("pbr", {})
        self.json["materials"].append({"pbrMetallicRoughness": pbr} | more)
        return len(self.json["materials"]) - 1

    def quad(self, corners: Rows, material: int) -> Json:
        """A rectangle, counter-clockwise from its front, with texture coordinates from 0 to 1."""
        return self.mesh(corners, [0, 1, 2, 0, 2, 3], material, TEXCOORD_0=[[0, 1], [1, 1], [1, 0], [0, 0]])

    def mesh(self, positions: Rows, indices: list[int], material: int, **streams: Rows) -> Json:
        """Any triangles; the primitive may be changed."""
        attributes = {"POSITION": self._accessor(positions)} | {k: self._accessor(v) for k, v in streams.items()}
        primitive = {"attributes": attributes, "indices": self._indices(indices), "material": material}
        self.json["meshes"][0]["primitives"].append(primitive)
        return primitive

    def texture(self, texels: Any, sampler: Json | None = None) -> int:
        """Index of a new texture of 8-bit RGBA rows."""
        self.json["samplers"].append(sampler or {})
        self.json["images"].append({"uri": "data:image/png;base64," + base64.b64encode(png(texels)).decode()})
        last = len(self.json["images"]) - 1
        self.json["textures"].append({"source": last, "sampler": last})
        return last

    def light(self, kind: str, intensity: float, translation: list[float], rotation: list[float], **more: Any) -> None:
        """A punctual light at a node of its own."""
        lights = self.json["extensions"].setdefault("KHR_lights_punctual", {"lights": []})["lights"]
        lights.append({"type": kind, "intensity": intensity, "color": [1, 0.9, 0.8]} | more)
        self.json["scenes"][0]["nodes"].append(len(self.json["nodes"]))
        used = {"KHR_lights_punctual": {"light": len(lights) - 1}}
        self.json["nodes"].append({"translation": translation, "rotation": rotation, "extensions": used})

    def write(self, path: Path) -> None:
        """The file, with its data in it."""
        kept = {k: v for k, v in self.json.items() if v not in ([], {})}
        data = base64.b64encode(self.data).decode()
        kept["buffers"] = [{"byteLength": len(self.data), "uri": f"data:application/octet-stream;base64,{data}"}]
        if "extensions" in kept:
            kept["extensionsUsed"] = list(kept["extensions"])
        path.write_text(json.dumps(kept))

    def _accessor(self, rows: Rows) -> int:
        values, width = np.asarray(rows, "<f4"), len(rows[0])
        more = {"min": values.min(0).tolist(), "max": values.max(0).tolist()}
        return self._add(values.tobytes(), {"componentType": 5126, "count": len(rows), "type": f"VEC{width}"} | more)

    def _indices(self, indices: list[int]) -> int:
        data = np.asarray(indices, "<u4").tobytes()
        return self._add(data, {"componentType": 5125, "count": len(indices), "type": "SCALAR"})

    def _add(self, data: bytes, accessor: Json) -> int:
        self.json["bufferViews"].append({"buffer": 0, "byteOffset": len(self.data), "byteLength": len(data)})
        self.data += data
        self.json["accessors"].append({"bufferView": len(self.json["bufferViews"]) - 1} | accessor)
        return len(self.json["accessors"]) - 1


def png(texels: Any) -> bytes:
    """8-bit RGBA as PNG."""
    texels = np.asarray(texels, np.uint8)
    height, width = texels.shape[:2]
    rows = b"".join(b"\0" + row.tobytes() for row in texels)

    def chunk(kind: bytes, body: bytes) -> bytes:
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    head = struct.pack(">IIBBBBB", width, height, 8, 6, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


DOWN = [-math.sqrt(0.5), 0, 0, math.sqrt(0.5)]  # turns -Z to -Y
TILTED = [-0.6, 0, 0.1, 0.787]
TO_WALL = [-0.25, 0.15, 0, 0.956]


def noise(height: int, width: int, seed: int) -> Any:
    """Random opaque texels."""
    texels = np.random.default_rng(seed).integers(30, 255, (height, width, 4))
    texels[..., 3] = 255
    return texels


def point(room: Room) -> None:
    """A point light."""
    room.light("point", 3, [0.3, 0.6, 0.2], DOWN)


def directional(room: Room) -> None:
    """A sun from above."""
    room.light("directional", 3, [0, 0, 0], TILTED)


def spot(room: Room) -> None:
    """A spot light with a wide soft edge."""
    room.light("spot", 10, [0, 0.3, 1.0], TO_WALL, spot={"innerConeAngle": 0.2, "outerConeAngle": 0.7})


def emitter(room: Room) -> None:
    """An emitter that shines on both sides."""
    shining = room.material([0, 0, 0], emissiveFactor=[1, 0.8, 0.5], doubleSided=True)
    room.quad([[-0.3, 0.5, -0.3], [0.3, 0.5, -0.3], [0.3, 0.6, 0.3], [-0.3, 0.6, 0.3]], shining)


def texture(room: Room) -> None:
    """A texture, moved, turned and mirrored, and a smooth ball."""
    mirrored = {"wrapS": 33648, "wrapT": 33648}
    info = {"index": room.texture(noise(6, 12, 1), mirrored)}
    room.json["extensions"]["KHR_texture_transform"] = {}
    info["extensions"] = {"KHR_texture_transform": {"offset": [0.3, 0.1], "rotation": 0.4, "scale": [1.5, 2]}}
    room.floor["material"] = room.material([1, 1, 1], pbr={"baseColorTexture": info})
    ball(room, room.material([0.4, 0.6, 0.8]))
    point(room)


def ball(room: Room, material: int) -> None:
    """A sphere with smooth normals."""
    rows, columns, radius = 12, 24, 0.4
    normals = [
        [math.sin(a) * math.sin(b), math.cos(a), math.sin(a) * math.cos(b)]
        for a in np.linspace(0, math.pi, rows + 1) for b in np.linspace(0, 2 * math.pi, columns + 1)
    ]
    positions = [[radius * x, radius * y - 0.5, radius * z] for x, y, z in normals]
    indices = []
    for i in range(rows):
        for j in range(columns):
            k = i * (columns + 1) + j
            indices += [k, k + columns + 1, k + 1, k + 1, k + columns + 1, k + columns + 2]
    room.mesh(positions, indices, material, NORMAL=normals)


def normal_map(room: Room) -> None:
    """Waves on the floor and on the back wall, mirrored there."""
    t = 2 * np.pi * (np.arange(32) + 0.5) / 32
    slope = 0.7 * np.stack([np.sin(t)[None, :] + 0 * t[:, None], 0.5 + 0.5 * np.cos(t)[:, None] + 0 * t[None, :]])
    vectors = np.stack([slope[0], slope[1], np.ones((32, 32))], axis=2)
    vectors /= np.linalg.norm(vectors, axis=2, keepdims=True)
    texels = np.dstack([np.round(127.5 * vectors + 127.5), np.full((32, 32), 255)])
    map_ = {"index": room.texture(texels), "scale": 0.9}
    bent = room.material([0.7, 0.7, 0.7], normalTexture=map_)
    room.floor["material"] = bent
    left = [[1.0 - u, v] for u, v in [[0, 1], [1, 1], [1, 0], [0, 0]]]
    primitives = room.json["meshes"][0]["primitives"]
    primitives.remove(room.wall)
    room.mesh([[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1]], [0, 1, 2, 0, 2, 3], bent, TEXCOORD_0=left)
    point(room)


def alpha_mask(room: Room) -> None:
    """A board with holes that casts a shadow."""
    texels = noise(8, 8, 2)
    texels[..., 3] = np.where((np.add.outer(np.arange(8), np.arange(8)) % 3) == 0, 255, 40)
    pbr = {"baseColorTexture": {"index": room.texture(texels)}}
    board = room.material([0.9, 0.9, 0.9], pbr=pbr, alphaMode="MASK", alphaCutoff=0.4, doubleSided=True)
    room.quad([[-0.7, 0, 0.6], [0.7, 0, 0.6], [0.7, 0.2, -0.6], [-0.7, 0.2, -0.6]], board)
    room.light("point", 3, [0.1, 0.9, 0.1], DOWN)


def vertex_colours(room: Room) -> None:
    """A floor whose colour runs from corner to corner."""
    room.floor["attributes"]["COLOR_0"] = room._accessor([[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]])
    point(room)


def nothing(room: Room) -> None:
    """Only what is around."""


def sky_and_point(room: Room) -> None:
    """Both at once: the sky comes by --background."""
    point(room)


def sky_map() -> Any:
    """Radiance that rises to one side and has a bright spot: height × width × 3."""
    v, u = np.meshgrid((np.arange(32) + 0.5) / 32, (np.arange(64) + 0.5) / 64, indexing="ij")
    radiance = 0.2 + 0.5 * (1 - v) + 6 * np.exp(-(((u - 0.62) / 0.06) ** 2) - ((v - 0.25) / 0.08) ** 2)
    return (radiance[..., None] * [1.0, 0.9, 0.7]).astype(np.float32)


# Name, what is added, the background, and peers that refuse it with a line.
SCENES: list[tuple[str, Callable[[Room], None], str | None, set[str]]] = [
    ("point", point, None, set()),
    ("directional", directional, None, set()),
    ("spot", spot, None, set()),
    ("emitter", emitter, None, set()),
    ("texture", texture, None, set()),
    ("normal map", normal_map, None, set()),
    ("alpha mask", alpha_mask, None, set()),
    ("vertex colours", vertex_colours, None, {"radiance"}),
    ("constant sky", nothing, "0.6,0.8,1", set()),
    ("map of the sky", nothing, "sky.exr", set()),
    ("sky and point", sky_and_point, "0.3,0.4,0.5", set()),
]
