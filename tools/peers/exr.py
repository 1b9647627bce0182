"""EXR files by Mitsuba's reader."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from scene import Floats


def _mitsuba():  # noqa: ANN202 - the module's type is not known before it is there
    import mitsuba

    if mitsuba.variant() is None:
        mitsuba.set_variant("scalar_rgb")
    return mitsuba


def read(path: Path) -> dict[str, Floats]:
    """Layers by name, height × width × channels in the order R, G, B, or the one that they have."""
    bitmap = _mitsuba().Bitmap(str(path))
    fields, pixels = bitmap.struct_(), np.array(bitmap).astype(float)
    pixels = pixels.reshape(*pixels.shape[:2], -1)
    channels = {fields[k].name: pixels[..., k] for k in range(len(fields))}
    layers: dict[str, list[Floats]] = {}
    for name in sorted(channels, key=lambda name: (name.rpartition(".")[0], "RGBXYZ".find(name[-1]))):
        layer = name.rpartition(".")[0] if "." in name else ("" if name in "RGB" else name)
        layers.setdefault(layer, []).append(channels[name])
    return {name: np.stack(planes, axis=2) for name, planes in layers.items()}


def write(path: Path, colour: Floats, layer: str = "irradiance") -> None:
    """One layer; without a name R, G and B alone."""
    mi = _mitsuba()
    names = [f"{layer}.{c}" if layer else c for c in "RGB"]
    pixels = np.ascontiguousarray(colour, np.float32)
    mi.Bitmap(pixels, mi.Bitmap.PixelFormat.MultiChannel, channel_names=names).write(str(path))
