#!/usr/bin/env python3
"""Cut every triangle of a glTF scene into 4^LEVELS equal ones, to measure how time grows with detail.

    tools/tessellate.py SCENE.gltf -o FINE.gltf --levels 2 [--rough 0.001]

The surface stays the same: corners are added, none is moved. With --rough all are, each its own way, so that nothing is flat. Meshes
must be triangle lists of plain float attributes with indices, in files beside the scene; textures are found where they are. Wants numpy (tools/setup.sh --peers).
"""

import argparse
import json
import os
from pathlib import Path

import numpy as np

WIDTH = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
TYPES = {5121: np.uint8, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}


def read(document, buffers, index):
    """The values of an accessor, a row an element."""
    accessor = document["accessors"][index]
    view = document["bufferViews"][accessor["bufferView"]]
    kind, width = TYPES[accessor["componentType"]], WIDTH[accessor["type"]]
    start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
    size = np.dtype(kind).itemsize * width
    stride = view.get("byteStride", size)
    data = np.frombuffer(buffers[view["buffer"]], np.uint8)[start:]
    rows = np.lib.stride_tricks.as_strided(data, (accessor["count"], size), (stride, 1))
    return np.ascontiguousarray(rows).view(kind).reshape(accessor["count"], width)


def cut(attributes, triangles):
    """Each triangle into four: corners are kept, the middles of edges added once."""
    edges = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2)
    edges, middle = np.unique(np.sort(edges, axis=1), axis=0, return_inverse=True)
    first = len(attributes["POSITION"])
    ab, bc, ca = (middle.reshape(-1, 3) + first).T
    a, b, c = triangles.T
    pieces = [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
    fine = {}
    for name, values in attributes.items():
        added = (values[edges[:, 0]] + values[edges[:, 1]]) * np.float32(0.5)
        if name in ("NORMAL", "TANGENT"):
            length = np.linalg.norm(added[:, :3], axis=1, keepdims=True)
            added[:, :3] /= np.maximum(length, 1e-20)
        if name == "TANGENT":
            added[:, 3] = values[edges[:, 0], 3]
        fine[name] = np.concatenate([values, added]).astype(np.float32)
    return fine, np.stack(pieces).transpose(2, 0, 1).reshape(-1, 3)


def moved(positions, distance):
    """Positions, each moved along every axis by up to that distance: by its bits, so that what met still meets."""
    words = np.ascontiguousarray(positions).view(np.uint32).astype(np.uint64)
    mixed = words @ np.array([[73856093, 19349663, 83492791], [49979687, 86028121, 15485863], [32452843, 67867967, 22801763]], np.uint64)
    mixed = (mixed ^ mixed >> 15) * np.uint64(0x9E3779B97F4A7C15) >> np.uint64(40)
    return positions + np.float32(distance) * (mixed.astype(np.float32) / 2**23 - 1)


class Output:
    """Buffer, views and accessors of the new file."""

    def __init__(self):
        self.data, self.views, self.accessors, self.size = [], [], [], 0

    def add(self, array, kind, component, **bounds):
        array = np.ascontiguousarray(array)
        self.views.append({"buffer": 0, "byteOffset": self.size, "byteLength": array.nbytes})
        view = len(self.views) - 1
        count = len(array)
        self.accessors.append({"bufferView": view, "componentType": component, "count": count, "type": kind, **bounds})
        self.data.append(array)
        self.size += array.nbytes
        return len(self.accessors) - 1


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", type=Path)
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--levels", type=int, default=2, help="4^LEVELS triangles for one (default 2: 16)")
    parser.add_argument("--rough", type=float, default=0.0, help="how far vertices are moved along each axis, at most (default 0)")
    arguments = parser.parse_args()

    document = json.loads(arguments.scene.read_text())
    folder, target = arguments.scene.parent, arguments.output
    buffers = [(folder / buffer["uri"]).read_bytes() for buffer in document["buffers"]]
    output, total = Output(), 0
    for mesh in document["meshes"]:
        for primitive in mesh["primitives"]:
            attributes = {name: read(document, buffers, at) for name, at in primitive["attributes"].items()}
            triangles = read(document, buffers, primitive["indices"]).reshape(-1, 3).astype(np.int64)
            for _ in range(arguments.levels):
                attributes, triangles = cut(attributes, triangles)
            total += len(triangles)
            if arguments.rough > 0:
                attributes["POSITION"] = moved(attributes["POSITION"], arguments.rough)
            for name, values in attributes.items():
                bounds = {}
                if name == "POSITION":
                    bounds = {"min": values.min(axis=0).tolist(), "max": values.max(axis=0).tolist()}
                kind = {2: "VEC2", 3: "VEC3", 4: "VEC4"}[values.shape[1]]
                primitive["attributes"][name] = output.add(values, kind, 5126, **bounds)
            primitive["indices"] = output.add(triangles.astype(np.uint32).reshape(-1), "SCALAR", 5125)
    for image in document.get("images", []):
        if "uri" in image:
            image["uri"] = os.path.relpath(folder / image["uri"], target.parent)
    binary = target.with_suffix(".bin")
    with binary.open("wb") as file:
        for array in output.data:
            file.write(array.tobytes())
    document["buffers"] = [{"uri": binary.name, "byteLength": output.size}]
    document["bufferViews"], document["accessors"] = output.views, output.accessors
    target.write_text(json.dumps(document))
    print(f"{total} triangles, {output.size / 2**20:.0f} MB: {target}")


if __name__ == "__main__":
    main()
