"""How a scene is said in Radiance.

- Lengths are scaled so that the scene is 5 units long. Radiance knows fixed lengths: of a Cornell box 100 units long it keeps
  four times as many records, for as much less error as they cost, and of one below a unit its rays start far off.
- Surfaces are `plastic` with specularity 0, which reflects on both sides. Flat ones without texture are polygons, which
  Radiance traces fastest; all others share one triangle mesh (.rtm), faster than a mesh each. A texture is a `colorpict`,
  whose picture coordinates run to 1 along the *shorter* side; an alpha mask is a `mixpict` with nothing behind it.
- A normal map is a `texdata`, which adds to the normal a vector in the scene's own axes. It knows no tangents, so each
  group of triangles whose tangents are alike (within half a degree or so) gets one of its own.
- Emitters: `light` polygons (a mesh cannot be a light source). Radiance's `light` is black and dark on the back, which
  is just what is wanted; a two-sided emitter gets a second polygon a hair behind the first, turned round.
  Pairs of triangles that make a parallelogram become one polygon: Radiance samples a source over its bounding
  parallelogram, so half of the samples of a triangle would be wasted.
- A directional light is a `source` 0.05° wide, a point light a small sphere, a spot light the same with glTF's falloff as
  its pattern. The sky is a `glow` all around, which is found by the indirect calculation alone.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from scene import Floats, Light, Material, Mesh, Scene, Use, refuse

SUN_DEGREES = 0.05
LENGTH = 5.0
MOST_TANGENTS = 4096

# What a texdata adds to the normal: the map's vector about the tangents A1..A3 and A4..A6, less the normal itself.
NORMAL_MAP = "".join(
    f"{axis}bend(x,y,z)=x*A{k + 1}+y*A{k + 4}+(z-1)*N{axis};\n" for k, axis in enumerate("xyz")
)


class Writer:
    """Writes the files of one scene; `shining` chooses its lights and emitters or else its sky."""

    def __init__(self, scene: Scene, folder: Path, shining: bool) -> None:
        self.scene, self.folder, self.shining = scene, folder, shining
        self.scale = LENGTH / scene.extent()
        self.text: list[str] = []
        self.curved: list[tuple[str, Mesh]] = []
        self.materials: list[str] = []

    def write(self) -> tuple[Path, Path | None]:
        """The description, and the meshes as OBJ with their materials beside it (materials.rad), if there are any."""
        (self.folder / "normal.cal").write_text(NORMAL_MAP)
        for number, mesh in enumerate(self.scene.meshes):
            self._mesh(number, mesh)
        if self.shining:
            self.text += [self._light(number, light) for number, light in enumerate(self.scene.lights)]
        elif self.scene.background is not None:
            self.text.append(self._sky(self.scene.background))
        materials = "\n".join(self.materials)
        description = self.folder / "scene.rad"
        obj = None
        if self.curved:
            obj = self.folder / "mesh.obj"
            obj.write_text(self._wavefront())
            (self.folder / "materials.rad").write_text(materials)
            self.text.append(f"void mesh curved\n1 {self.folder / 'mesh.rtm'}\n0\n0\n")
        description.write_text("\n".join([materials, *self.text]))
        return description, obj

    def _mesh(self, number: int, mesh: Mesh) -> None:
        material = mesh.material
        if mesh.colours is not None and not (mesh.colours[:, :3] == 1).all():
            raise refuse(material, "Radiance's meshes carry no vertex colours")
        if material.emits():
            self._emitter(number, mesh)
            return
        plain = material.base is None and material.normal is None
        if plain and mesh.is_flat():
            self.materials.append(self._material(f"m{number}", "void", material))
            self.text.append(self._polygons(f"m{number}", f"s{number}", [mesh.positions[t] for t in mesh.triangles]))
            return
        if material.normal is None or mesh.tangents is None:
            self.materials.append(self._material(f"m{number}", "void", material))
            self.curved.append((f"m{number}", mesh))
            return
        self._bumps(number, material.normal)
        for k, (part, tangent, across) in enumerate(_by_tangents(mesh)):
            name = f"m{number}.{k}"
            files = " ".join(str(self.folder / f"n{number}{axis}.dat") for axis in "xyz")
            u, v = (self._place(material, material.normal, axis) for axis in (0, 1))
            bump = f"void texdata t{name}\n9 xbend ybend zbend {files} {self.folder / 'normal.cal'} {v} {u}\n0\n"
            self.materials.append(f"{bump}6 {_numbers(tangent)} {_numbers(across)}\n")
            self.materials.append(self._material(name, f"t{name}", material))
            self.curved.append((name, part))

    def _material(self, name: str, modifier: str, material: Material) -> str:
        lines = []
        if material.base is not None:
            picture = self._picture(f"{name}.hdr", material.base.texture.colour())
            place = self._in_picture(material, material.base)
            lines.append(f"{modifier} colorpict p{name}\n7 red green blue {picture} . {place}\n0\n0\n")
            modifier = f"p{name}"
        present = material.mask()
        solid = name if present is None else f"solid{name}"
        lines.append(f"{modifier} plastic {solid}\n0\n0\n5 {_numbers(material.albedo)} 0 0\n")
        if present is not None:
            picture = self._picture(f"{name}.mask.hdr", np.repeat(present[..., None], 3, 2).astype(np.float32))
            place = self._in_picture(material, material.base)
            lines.append(f"void mixpict {name}\n7 {solid} void red {picture} . {place}\n0\n0\n")
        return "\n".join(lines)

    def _picture(self, name: str, texels: NDArray[np.float32]) -> Path:
        file = self.folder / name
        file.write_bytes(_rgbe(texels))
        return file

    def _place(self, material: Material, use: Use, axis: int) -> str:
        """A texture's u or v (downwards) within the texture, from the mesh's."""
        first = _first(material)
        if use.set != first.set:
            raise refuse(material, "Radiance's meshes carry one set of texture coordinates, and it reads two")
        matrix = use.transform @ np.linalg.inv(first.transform)
        own = ("Lu", "(1-Lv)")
        if np.allclose(matrix, np.eye(3), atol=1e-9):
            at = own[axis]
        else:
            at = f"({matrix[axis, 0]:.9g}*{own[0]}+{matrix[axis, 1]:.9g}*{own[1]}+{matrix[axis, 2]:.9g})"
        wrap = use.texture.wrap[axis]
        return {"repeat": f"frac({at})", "clamp": f"bound(0,{at},1)", "mirror": f"(1-abs(1-2*frac(.5*{at})))"}[wrap]

    def _in_picture(self, material: Material, use: Use) -> str:
        """The same as coordinates of a picture: v upwards, 1 along the shorter side."""
        height, width = use.texture.pixels.shape[:2]
        u, v = (self._place(material, use, axis) for axis in (0, 1))
        return f"{max(width / height, 1):.9g}*{u} {max(height / width, 1):.9g}*(1-{v})"

    def _bumps(self, number: int, use: Use) -> None:
        """A normal map's vectors as data over v and u, a texel wider on each side so that it is smooth where it wraps."""
        scale = self.scene.meshes[number].material.normal_scale
        vectors = use.texture.vectors() * [scale, scale, 1.0]
        vectors /= np.maximum(np.linalg.norm(vectors, axis=2, keepdims=True), 1e-9)
        height, width = vectors.shape[:2]
        modes = {"repeat": "wrap", "clamp": "edge", "mirror": "symmetric"}
        for axis, wrap in ((0, use.texture.wrap[1]), (1, use.texture.wrap[0])):
            around = [(1, 1) if k == axis else (0, 0) for k in range(3)]
            vectors = np.pad(vectors, around, mode=modes[wrap])
        head = "2\n" + "".join(f"{-0.5 / n:.9g} {1 + 0.5 / n:.9g} {n + 2}\n" for n in (height, width))
        for k, axis in enumerate("xyz"):
            values = "\n".join(f"{value:.5g}" for value in vectors[..., k].ravel())
            (self.folder / f"n{number}{axis}.dat").write_text(head + values + "\n")

    def _emitter(self, number: int, mesh: Mesh) -> None:
        material = mesh.material
        if not self.shining:
            self.materials.append(f"void plastic m{number}\n0\n0\n5 0 0 0 0 0\n")
            self.text.append(self._polygons(f"m{number}", f"s{number}", polygons_of(mesh)))
            return
        if material.emission_texture is not None or material.mask() is not None:
            raise refuse(material, "Radiance's light sources are polygons, which carry no texture coordinates")
        polygons = []
        for corners in polygons_of(mesh):
            polygons.append(corners)
            if material.two_sided:
                normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
                polygons.append(corners[::-1] - 1e-5 * LENGTH / self.scale * normal / np.linalg.norm(normal))
        self.materials.append(f"void light m{number}\n0\n0\n3 {_numbers(material.emission)}\n")
        self.text.append(self._polygons(f"m{number}", f"s{number}", polygons))

    def _polygons(self, material: str, name: str, polygons: list[Floats]) -> str:
        return "\n".join(
            f"{material} polygon {name}.{k}\n0\n0\n{corners.size} {_numbers(self.scale * corners.ravel())}\n"
            for k, corners in enumerate(polygons)
        )

    def _light(self, number: int, light: Light) -> str:
        if light.kind == "directional":
            solid_angle = 2 * np.pi * (1 - np.cos(np.radians(SUN_DEGREES / 2)))
            shape = f"source l{number}\n0\n0\n4 {_numbers(-light.direction)} {SUN_DEGREES}\n"
            return f"void light e{number}\n0\n0\n3 {_numbers(light.colour / solid_angle)}\ne{number} {shape}"
        pattern, modifier = "", "void"
        if light.kind == "spot":
            # Dx, Dy, Dz: from the surface to the light.
            cos = "+".join(f"{-part:.9g}*D{axis}" for part, axis in zip(light.direction, "xyz", strict=True))
            edge = f"bound(0,({cos}-{light.cos_outer:.9g})/{light.cos_inner - light.cos_outer:.9g},1)^2"
            pattern, modifier = f"void brightfunc f{number}\n2 {edge} .\n0\n0\n", f"f{number}"
        radius = 1e-4 * LENGTH
        radiance = light.colour * self.scale**2 / (np.pi * radius**2)
        shape = f"sphere l{number}\n0\n0\n4 {_numbers(self.scale * light.position)} {radius:.9g}\n"
        return f"{pattern}{modifier} light e{number}\n0\n0\n3 {_numbers(radiance)}\ne{number} {shape}"

    def _sky(self, radiance: Floats) -> str:
        around = "sky source around\n0\n0\n4 0 0 1 360\n"
        if radiance.ndim == 1:
            return f"void glow sky\n0\n0\n4 {_numbers(radiance)} 0\n{around}"
        height, width = radiance.shape[:2]
        picture = self._picture("sky.hdr", radiance.astype(np.float32))
        u = f"{max(width / height, 1):.9g}*frac(.5+atan2(Dx,-Dz)/(2*PI))"
        v = f"{max(height / width, 1):.9g}*(1-acos(bound(-1,Dy,1))/PI)"
        pattern = f"void colorpict skypicture\n7 red green blue {picture} . {u} {v}\n0\n0\n"
        return f"{pattern}skypicture glow sky\n0\n0\n4 1 1 1 0\n{around}"

    def _wavefront(self) -> str:
        """Wavefront OBJ of many meshes; glTF's v runs down the picture, Radiance's up."""
        lines: list[str] = []
        vertices = uvs = normals = 1  # OBJ counts each kind on its own, from 1
        for name, mesh in self.curved:
            first, is_flat = _first(mesh.material), mesh.is_flat()
            lines.append(f"usemtl {name}")
            lines += [f"v {_numbers(self.scale * p)}" for p in mesh.positions]
            corner = "{v}/" + ("{t}" if first else "") + ("" if is_flat else "/{n}")
            if first:
                places = np.hstack([mesh.uvs[first.set], np.ones((len(mesh.positions), 1))]) @ first.transform.T
                lines += [f"vt {u:.9g} {1 - v:.9g}" for u, v in places[:, :2]]
                uvs_used = len(places)
            else:
                uvs_used = 0
            if not is_flat:
                lines += [f"vn {_numbers(n)}" for n in mesh.normals]
            lines += [
                "f " + " ".join(corner.format(v=vertices + k, t=uvs + k, n=normals + k) for k in triangle)
                for triangle in mesh.triangles.tolist()
            ]
            vertices += len(mesh.positions)
            uvs += uvs_used
            normals += 0 if is_flat else len(mesh.normals)
        return "\n".join(lines) + "\n"


def _first(material: Material) -> Use | None:
    return material.base or material.normal


def _by_tangents(mesh: Mesh) -> list[tuple[Mesh, Floats, Floats]]:
    """Groups of triangles with nearly the same tangents, and these: along u, and across in the map's own sense."""
    corners = mesh.triangles
    a, b, c = (mesh.positions[corners[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    tangent = mesh.tangents[corners].mean(axis=1)
    along = tangent[:, :3] - normal * np.einsum("tc,tc->t", normal, tangent[:, :3])[:, None]
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-12)
    across = np.cross(normal, along) * np.where(tangent[:, 3] < 0, -1.0, 1.0)[:, None]
    frames = np.hstack([along, across])
    _, group = np.unique(np.round(frames * 64).astype(int), axis=0, return_inverse=True)
    if group.max() >= MOST_TANGENTS:
        raise refuse(mesh.material, f"Radiance's normal maps know no tangents, and it has more than {MOST_TANGENTS}")
    parts = []
    for k in range(group.max() + 1):
        mean = frames[group == k].mean(axis=0)
        parts.append((mesh.part(group == k), mean[:3], mean[3:]))
    return parts


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


def _numbers(values: Floats) -> str:
    return " ".join(f"{value:.9g}" for value in np.asarray(values).ravel())
