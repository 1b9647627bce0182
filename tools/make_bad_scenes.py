#!/usr/bin/env python3
"""Writes tests/bad_scenes: files that are broken in one way each, and expected.txt with what is said of each.

A line of expected.txt is `FILE|PART|PART…`: the message holds every part; `FILE|ok|PART…` loads with a note that holds them.
"""

import base64
import copy
import json
import pathlib
import struct

FOLDER = pathlib.Path(__file__).parent.parent / "tests" / "bad_scenes"
EXPECTED = {}

POSITIONS = [0, 0, 0, 1, 0, 0, 0, 1, 0]
INDICES = [0, 1, 2]


def uri(data):
    return "data:application/octet-stream;base64," + base64.b64encode(data).decode()


def triangle(positions=POSITIONS, indices=INDICES):
    """A good file: one indexed triangle."""
    data = struct.pack(f"<{len(positions)}f", *positions)
    offset = len(data)
    data += struct.pack(f"<{len(indices)}H", *indices)
    return {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"name": "Node", "mesh": 0}],
        "meshes": [{"name": "Mesh", "primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(positions) // 3, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": len(indices), "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": offset},
            {"buffer": 0, "byteOffset": offset, "byteLength": 2 * len(indices)},
        ],
        "buffers": [{"byteLength": len(data), "uri": uri(data)}],
    }


def write(name, data, *expected):
    FOLDER.joinpath(name).write_bytes(data if isinstance(data, bytes) else (json.dumps(data) + "\n").encode())
    EXPECTED[name] = expected


def change(name, path, value, *expected, base=None):
    """Writes a file that differs from the good one at `path`; `None` removes."""
    document = copy.deepcopy(base or triangle())
    place = document
    for key in path[:-1]:
        place = place.setdefault(key, {}) if isinstance(place, dict) else place[key]
    if value is None:
        del place[path[-1]]
    else:
        place[path[-1]] = value
    write(name, document, *expected)


def glb(document, binary=b""):
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
    if binary:
        chunks += struct.pack("<II", len(binary), 0x004E4942) + binary
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def containers():
    write("empty.gltf", b"", "not a glTF 2.0 file", "empty")
    write("picture.gltf", b"\x89PNG\r\n\x1a\n", "not a glTF 2.0 file")
    write("broken.gltf", b'{"asset": {"version": "2.0"', "not a glTF 2.0 file", "JSON", "line 1")
    write("deep.gltf", b'{"asset":' + b"[" * 100000, "not a glTF 2.0 file", "recursion")
    write("version1.gltf", {"asset": {"version": "1.0"}}, "version 1.0", "convert")
    binary = struct.pack("<9f3H2x", *POSITIONS, *INDICES)
    good = triangle()
    good["buffers"] = [{"byteLength": 42}]
    whole = glb(good, binary)
    write("truncated_chunk.glb", whole[:-20], "cut short")
    write("truncated_header.glb", whole[:10], "header is cut short")
    write("no_json.glb", struct.pack("<4sII", b"glTF", 2, 12), "no JSON chunk")
    write("chunk_size_overflow.glb", whole[:12] + b"\xff\xff\xff\xff" + whole[16:], "cut short")
    write("no_binary_chunk.glb", glb(good), "buffer 0", "no binary chunk")
    write("version1.glb", whole[:4] + b"\1" + whole[5:], "GLB version 1")


def buffers():
    a0 = ["accessors", 0]
    change("buffer_too_short.gltf", ["buffers", 0, "byteLength"], 1000, "buffer 0", "1000", "42")
    change("view_past_buffer.gltf", ["bufferViews", 0, "byteLength"], 60, "bufferView 0", "60", "42")
    change("view_offset_overflow.gltf", ["bufferViews", 0, "byteOffset"], 2**64 - 4, "bufferView 0", "buffer 0")
    change("count_past_view.gltf", [*a0, "count"], 4, 'mesh 0 "Mesh" primitive 0: accessor 0 POSITION', "4 elements")
    change("count_giant.gltf", [*a0, "count"], 4_000_000_000, "accessor 0 POSITION", "4000000000")
    change("count_maximal.gltf", [*a0, "count"], 2**64 - 1, "accessor 0 POSITION", "do not fit")
    change("count_zero.gltf", [*a0, "count"], 0, "no triangles")
    change("count_without_view.gltf", ["accessors", 0], {"componentType": 5126, "count": 4_000_000_000, "type": "VEC3"},
           "accessor 0 POSITION", "4000000000", "no bufferView")
    change("offset_32_bit_overflow.gltf", [*a0, "byteOffset"], 2**32 - 36, "accessor 0 POSITION", "4294967260")
    change("offset_64_bit_overflow.gltf", [*a0, "byteOffset"], 2**64 - 8, "accessor 0 POSITION", "do not fit")
    change("stride_overflow.gltf", ["bufferViews", 0, "byteStride"], 2**63, "accessor 0 POSITION", "do not fit")
    change("stride_overlaps.gltf", ["bufferViews", 0, "byteStride"], 4, "accessor 0 POSITION", "overlap")
    change("component_type.gltf", [*a0, "componentType"], 5124, "accessor 0 POSITION", "componentType")
    change("wrong_type.gltf", [*a0, "type"], "VEC2", "accessor 0 POSITION", "2 components")
    change("missing_view.gltf", [*a0, "bufferView"], 9, "accessor 0 POSITION", "bufferView 9 does not exist", "has 2")
    change("missing_buffer_file.gltf", ["buffers", 0, "uri"], "gone%20away.bin", "buffer 0", '"gone away.bin"')
    change("folder_as_buffer.gltf", ["buffers", 0, "uri"], "..", "buffer 0", "not a regular file")
    change("http_buffer.gltf", ["buffers", 0, "uri"], "http://example.org/a.bin", "buffer 0", "scheme http", "save the file")
    change("broken_base64.gltf", ["buffers", 0, "uri"], "data:;base64,AA*A", "buffer 0", "base64")
    sparse = {"count": 1, "indices": {"bufferView": 1, "componentType": 5123}, "values": {"bufferView": 0}}
    change("sparse_out_of_range.gltf", [*a0, "sparse"],
           {**sparse, "indices": {"bufferView": 0, "byteOffset": 14, "componentType": 5123}}, "accessor 0 POSITION: sparse")
    change("sparse_giant.gltf", [*a0, "sparse"], {**sparse, "count": 2**40}, "accessor 0 POSITION: sparse")
    meshopt = {"buffer": 0, "byteLength": 42, "byteStride": 12, "count": 3, "mode": "ATTRIBUTES"}
    change("meshopt_garbage.gltf", ["bufferViews", 0, "extensions"], {"EXT_meshopt_compression": meshopt},
           "bufferView 0", "meshopt code is broken")
    change("meshopt_giant.gltf", ["bufferViews", 0, "extensions"], {"EXT_meshopt_compression": {**meshopt, "count": 2**60}},
           "bufferView 0", "claims")
    change("meshopt_stride.gltf", ["bufferViews", 0, "extensions"],
           {"EXT_meshopt_compression": {**meshopt, "byteStride": 300}}, "bufferView 0", "byteStride 300")


def geometry():
    nan, infinite = list(POSITIONS), list(POSITIONS)
    nan[4], infinite[8] = float("nan"), float("inf")
    write("nan_position.gltf", triangle(nan), 'mesh 0 "Mesh" primitive 0: accessor 0 POSITION', "NaN", "not finite")
    write("infinite_position.gltf", triangle(infinite), "accessor 0 POSITION", "inf", "not finite")
    write("index_out_of_range.gltf", triangle(indices=[0, 1, 3]), "accessor 1 indices", "index 3 at 2", "3 vertices")
    write("no_area.gltf", triangle(indices=[0, 1, 1]), "ok|nothing is seen")
    write("some_without_area.gltf", triangle(indices=[0, 1, 2, 0, 0, 1]), "ok", "without area")
    change("float_indices.gltf", ["accessors", 1, "componentType"], 5126, "accessor 1 indices", base=triangle(indices=[0] * 6))
    change("no_triangles.gltf", ["meshes"], None, "node 0", "mesh 0 does not exist")
    change("points_only.gltf", ["meshes", 0, "primitives", 0, "mode"], 0, "no triangles")
    change("mode.gltf", ["meshes", 0, "primitives", 0, "mode"], 7, "mode")
    change("empty_scene.gltf", ["scenes", 0, "nodes"], [], "no triangles")
    change("unequal_counts.gltf", ["meshes", 0, "primitives", 0, "attributes", "NORMAL"], 2, "accessor 2 NORMAL", "2 elements",
           base={**triangle(), "accessors": triangle()["accessors"] + [
               {"bufferView": 0, "componentType": 5126, "count": 2, "type": "VEC3"}]})
    far = triangle()
    far["nodes"][0]["scale"] = [1e30, 1e30, 1e30]
    far["nodes"].append({"children": [0], "scale": [1e30, 1, 1]})
    far["scenes"][0]["nodes"] = [1]
    write("beyond_single_precision.gltf", far, "primitive 0", "single precision")


def nodes():
    change("cycle.gltf", ["nodes", 0, "children"], [0], 'node 0 "Node"', "own ancestor")
    loop = triangle()
    loop["nodes"] += [{"children": [2]}, {"children": [1]}]
    write("unreached_cycle.gltf", loop, "node 1", "own ancestor")
    twice = triangle()
    twice["nodes"] += [{"children": [0]}, {"children": [0]}]
    write("two_parents.gltf", twice, 'node 0 "Node"', "two parents, node 1 and node 2")
    change("missing_child.gltf", ["nodes", 0, "children"], [7], "child node 7 does not exist")
    change("missing_scene.gltf", ["scene"], 3, "scene 3 does not exist")
    change("missing_mesh.gltf", ["nodes", 0, "mesh"], 3, 'node 0 "Node"', "mesh 3 does not exist")
    change("flat_matrix.gltf", ["nodes", 0, "matrix"], [0] * 16, 'node 0 "Node"', "affine")
    change("zero_rotation.gltf", ["nodes", 0, "rotation"], [0, 0, 0, 0], "ok", "rotations that are 0")
    change("zero_scale.gltf", ["nodes", 0, "scale"], [0, 0, 0], "ok|nothing is seen")
    change("short_matrix.gltf", ["nodes", 0, "matrix"], [1, 2], 'node 0 "Node"', "length 2")
    change("control_characters.gltf", ["nodes", 0], {"name": "a\nb\u001b[31m", "mesh": 3}, 'node 0 "a b [31m"')
    depth = triangle()
    depth["nodes"] += [{"children": [i]} for i in range(20000)]
    depth["scenes"][0]["nodes"] = [20000]
    write("deep_nodes.gltf", depth, "ok")
    many = triangle()
    zeros = {"componentType": 5126, "count": 60000, "type": "VEC3"}
    many["accessors"] += [zeros]
    many["nodes"] = [{"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 2}}}}] * 200
    many["scenes"] = [{"nodes": list(range(200))}]
    write("instance_bomb.gltf", many, "triangles once every instance is placed")


def materials():
    textured = triangle()
    textured["meshes"][0]["primitives"][0]["material"] = 0
    textured["materials"] = [{"name": "Paint", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]
    textured["textures"] = [{"source": 0}]
    textured["images"] = [{"uri": "gone.png"}]
    paint = 'material 0 "Paint"'
    write("missing_texture_file.gltf", textured, "ok", 'image 0 "gone.png"', "cannot read", "grey")
    change("texture_is_no_image.gltf", ["images", 0, "uri"], uri(b"hello"), "ok", "image 0", "PNG", "grey", base=textured)
    png = b"\x89PNG\r\n\x1a\n" + struct.pack(">I4sIIBBBBBI", 13, b"IHDR", 1 << 30, 1 << 30, 8, 2, 0, 0, 0, 0)
    change("texture_truncated.gltf", ["images", 0, "uri"], uri(png), "ok", "image 0", "grey", base=textured)
    webp = b"RIFF" + struct.pack("<I", 22) + b"WEBPVP8L" + struct.pack("<I", 10) + b"\x2f" + struct.pack("<I", (16382 << 14) | 16382)
    change("texture_bomb.gltf", ["images", 0, "uri"], uri(webp + b"\0" * 5), paint, "image 0", base=textured)
    change("missing_texture.gltf", ["textures"], [], "ok", "texture 0 does not exist", "grey", base=textured)
    change("missing_image.gltf", ["images"], [], "ok", "image 0 does not exist", "grey", base=textured)
    change("texture_set.gltf", ["materials", 0, "pbrMetallicRoughness", "baseColorTexture", "texCoord"], 4, "ok", "gone.png", base=textured)
    change("missing_material.gltf", ["meshes", 0, "primitives", 0, "material"], 5, "primitive 0", "material 5 does not exist")
    plain = triangle()
    plain["meshes"][0]["primitives"][0]["material"] = 0
    change("negative_emission.gltf", ["materials"], [{"emissiveFactor": [0, -1, 0]}], "material 0", "emission", base=plain)
    strong = [{"emissiveFactor": [1, 1, 1], "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 1e39}}}]
    change("infinite_emission.gltf", ["materials"], strong, "material 0", "emission", "not finite", base=plain)
    bright = [{"pbrMetallicRoughness": {"baseColorFactor": [2, 1, 1, 1]}}]
    change("bright_base_color.gltf", ["materials"], bright, "ok", "clamped", base=plain)
    change("blend.gltf", ["materials"], [{"alphaMode": "BLEND"}], "ok", "blended", base=plain)


def extensions():
    change("required_KHR_draco_mesh_compression.gltf", ["extensionsRequired"], ["KHR_draco_mesh_compression"], "ok")
    for name, part in [("KHR_texture_basisu", "PNG, JPEG or WebP"), ("ACME_unheard_of", "re-export without it")]:
        change(f"required_{name}.gltf", ["extensionsRequired"], [name], f"requires extension {name}", part)
    change("required_harmless.gltf", ["extensionsRequired"], ["KHR_materials_clearcoat"], "ok", "KHR_materials_clearcoat is ignored")
    change("used_unknown.gltf", ["extensionsUsed"], ["ACME_unheard_of"], "ok", "ACME_unheard_of is ignored")
    lit = triangle()
    lit["nodes"][0]["extensions"] = {"KHR_lights_punctual": {"light": 0}}

    def light(name, made, *expected):
        change(name, ["extensions"], {"KHR_lights_punctual": {"lights": [made]}}, *expected, base=lit)

    light("negative_light.gltf", {"name": "Sun", "type": "point", "intensity": -1}, 'light 0 "Sun"', "intensity")
    light("spot_angles.gltf", {"type": "spot", "spot": {"innerConeAngle": 1, "outerConeAngle": 0.5}}, "light 0", "cone angles")
    light("light_type.gltf", {"type": "area"}, "light 0", "type")
    change("missing_light.gltf", ["nodes"], lit["nodes"], 'node 0 "Node"', "light 0 does not exist")
    change("missing_camera.gltf", ["nodes", 0, "camera"], 1, 'node 0 "Node"', "camera 1 does not exist")
    seen = triangle()
    seen["nodes"][0]["camera"] = 0
    camera = [{"type": "perspective", "perspective": {"yfov": 4.0, "znear": 1}}]
    change("camera_angle.gltf", ["cameras"], camera, "camera 0", "yfov", base=seen)


def main():
    FOLDER.mkdir(exist_ok=True)
    for old in FOLDER.glob("*.gl*"):
        old.unlink()
    for group in (containers, buffers, geometry, nodes, materials, extensions):
        group()
    lines = ["|".join([name, *parts]) for name, parts in sorted(EXPECTED.items())]
    FOLDER.joinpath("expected.txt").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
