#!/usr/bin/env python3
"""Writes assets/cornell.gltf: the Cornell box from its published measurements.

Geometry: Cornell University Program of Computer Graphics, "Cornell Box Data" (1998), millimetres, here in metres.
Reflectances are the usual RGB for its three paints; the light's radiance is (17, 12, 4) W/(sr m^2).
The lamp hangs 0.5 mm below the ceiling, so that the two do not coincide.
"""

import base64
import json
import math
import pathlib
import struct

LAMP_Y = 548.8 - 0.5

WHITE, RED, GREEN, LAMP = range(4)
MATERIALS = [
    ("white", (0.725, 0.71, 0.68)),
    ("red", (0.63, 0.065, 0.05)),
    ("green", (0.14, 0.45, 0.091)),
    ("lamp", (0.0, 0.0, 0.0)),
]
RADIANCE = (17.0, 12.0, 4.0)

# Each face's corners go round counter-clockwise seen from the side that is lit.
FLOOR = [(552.8, 0, 0), (0, 0, 0), (0, 0, 559.2), (549.6, 0, 559.2)]
CEILING = [(556, 548.8, 0), (556, 548.8, 559.2), (0, 548.8, 559.2), (0, 548.8, 0)]
BACK = [(549.6, 0, 559.2), (0, 0, 559.2), (0, 548.8, 559.2), (556, 548.8, 559.2)]
RIGHT = [(0, 0, 559.2), (0, 0, 0), (0, 548.8, 0), (0, 548.8, 559.2)]
LEFT = [(552.8, 0, 0), (549.6, 0, 559.2), (556, 548.8, 559.2), (556, 548.8, 0)]
LIGHT = [(343, LAMP_Y, 227), (343, LAMP_Y, 332), (213, LAMP_Y, 332), (213, LAMP_Y, 227)]
SHORT_TOP = [(130, 165, 65), (82, 165, 225), (240, 165, 272), (290, 165, 114)]
TALL_TOP = [(423, 330, 247), (265, 330, 296), (314, 330, 456), (472, 330, 406)]


def block(top):
    """A block's top and four sides."""
    faces = [top]
    for (x0, y, z0), (x1, _, z1) in zip(top, top[1:] + top[:1]):
        faces.append([(x0, y, z0), (x0, 0, z0), (x1, 0, z1), (x1, y, z1)])
    return faces


MESHES = [
    ("room", WHITE, [FLOOR, CEILING, BACK]),
    ("left wall", RED, [LEFT]),
    ("right wall", GREEN, [RIGHT]),
    ("short block", WHITE, block(SHORT_TOP)),
    ("tall block", WHITE, block(TALL_TOP)),
    ("lamp", LAMP, [LIGHT]),
]


class Writer:
    """Collects the buffer and what describes it."""

    def __init__(self):
        self.data, self.views, self.accessors = b"", [], []

    def add(self, packed, **accessor):
        """Appends bytes as a view of their own, with one accessor; returns the accessor's index."""
        self.views.append({"buffer": 0, "byteOffset": len(self.data), "byteLength": len(packed)})
        self.data += packed + b"\0" * (-len(packed) % 4)
        self.accessors.append({"bufferView": len(self.views) - 1, **accessor})
        return len(self.accessors) - 1

    def mesh(self, name, material, faces):
        """A mesh of quads."""
        points = [[struct.unpack("<f", struct.pack("<f", c / 1000))[0] for c in p] for f in faces for p in f]
        indices = [4 * f + i for f in range(len(faces)) for i in (0, 1, 2, 0, 2, 3)]
        low, high = [min(c) for c in zip(*points)], [max(c) for c in zip(*points)]
        flat = [c for p in points for c in p]
        position = self.add(
            struct.pack(f"<{len(flat)}f", *flat),
            componentType=5126, count=len(points), type="VEC3", min=low, max=high,
        )
        index = self.add(struct.pack(f"<{len(indices)}H", *indices), componentType=5123, count=len(indices), type="SCALAR")
        primitive = {"attributes": {"POSITION": position}, "indices": index, "material": material}
        return {"name": name, "primitives": [primitive]}


def material(name, color):
    """A Lambertian material; the lamp emits from its front only."""
    made = {
        "name": name,
        "doubleSided": name != "lamp",
        "pbrMetallicRoughness": {"baseColorFactor": [*color, 1.0], "metallicFactor": 0.0, "roughnessFactor": 1.0},
    }
    if name == "lamp":
        strength = max(RADIANCE)
        made["emissiveFactor"] = [c / strength for c in RADIANCE]
        made["extensions"] = {"KHR_materials_emissive_strength": {"emissiveStrength": strength}}
    return made


def main():
    writer = Writer()
    meshes = [writer.mesh(*m) for m in MESHES]
    nodes = [{"name": m["name"], "mesh": i} for i, m in enumerate(meshes)]
    # Half a turn about y: glTF cameras look along -z, this one along +z.
    nodes.append({"name": "camera", "camera": 0, "translation": [0.278, 0.273, -0.8], "rotation": [0, 1, 0, 0]})
    lens = {"yfov": 2 * math.atan(0.0125 / 0.035), "aspectRatio": 1.0, "znear": 0.01}
    uri = "data:application/octet-stream;base64," + base64.b64encode(writer.data).decode()
    document = {
        "asset": {"version": "2.0", "generator": "tools/make_cornell.py"},
        "extensionsUsed": ["KHR_materials_emissive_strength"],
        "scene": 0,
        "scenes": [{"nodes": list(range(len(nodes)))}],
        "nodes": nodes,
        "cameras": [{"name": "camera", "type": "perspective", "perspective": lens}],
        "materials": [material(*m) for m in MATERIALS],
        "meshes": meshes,
        "accessors": writer.accessors,
        "bufferViews": writer.views,
        "buffers": [{"byteLength": len(writer.data), "uri": uri}],
    }
    path = pathlib.Path(__file__).parent.parent / "assets" / "cornell.gltf"
    path.write_text(json.dumps(document, indent=1) + "\n")


if __name__ == "__main__":
    main()
