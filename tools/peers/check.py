#!/usr/bin/env python3
"""Checks what the other renderers are given: small rooms, one a feature, lit the same in all three programs.

  tools/peers/check.py [NAME...]

For each room direct irradiance and irradiance after one bounce of Radiance and Mitsuba are held against hemicube
reference, and a Markdown table of the differences is printed: energy, and mean absolute difference of averages over
4 × 4 pixels. Radiance is compared where no normal map bends the normal that is seen (see radiance.py). Ends with 1 where one is above its limit. A peer that cannot say a feature must refuse it with a line.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import environment

SIDE = 48
# Energy, and 4 × 4 averages: noise, Radiance's interpolation between records, and shadow edges within a block.
LIMITS = {("radiance", 0): (0.01, 0.02), ("radiance", 1): (0.01, 0.02), ("mitsuba", 0): (0.005, 0.01), ("mitsuba", 1): (0.005, 0.02)}
RADIANCE = {"ad": 2048, "as": 1024, "aa": 0.1, "ar": 256}
# Mitsuba's normal maps reflect nothing to where the bent surface is seen from behind, hemicube's do: 1.2 % here.
NORMAL_MAP = 0.02
# Without a cache: seen through it, what a sky lights is some per cent too bright (its records far from the eye are coarser).
RADIANCE_SKY = {"ad": 800, "as": 0, "aa": 0}
MITSUBA = {"spp": 1024, "sampler": "multijitter"}


def images(peer: str, scene: Any, folder: Path) -> list[Any]:
    """Direct irradiance, and that after one bounce."""
    if peer == "mitsuba":
        import mitsuba_path

        program = mitsuba_path.export(scene, folder)
        if program is None:
            raise SystemExit(1)
        return [program.irradiance(bounces, 2, MITSUBA)[0] for bounces in (0, 1)]
    import radiance

    program = radiance.export(scene, folder)
    settings = RADIANCE_SKY if program.has_sky() else RADIANCE
    direct, whole = (program.irradiance(bounces, 2, settings)[0] for bounces in (0, 1))
    return [direct, whole - direct]


def main() -> int:
    """Runs the rooms that are named, or all."""
    environment.enter()
    import check_scenes
    import exr
    import metrics
    import scene as scenes

    folder = environment.WORK / "check"
    folder.mkdir(parents=True, exist_ok=True)
    exr.write(folder / "sky.exr", check_scenes.sky_map(), layer="")
    bad = 0
    print("| room | peer | direct: energy | 4×4 | one bounce: energy | 4×4 |\n|---|---|--:|--:|--:|--:|", flush=True)
    for name, build, background, refusing in check_scenes.SCENES:
        if sys.argv[1:] and name not in sys.argv[1:]:
            continue
        room = check_scenes.Room()
        build(room)
        file = folder / f"{name.replace(' ', '-')}.gltf"
        room.write(file)
        sky = [] if background is None else ["--background", background if "," in background else folder / background]
        truth_file = folder / "truth.exr"
        environment.hemicube(
            "reference", file, "-o", truth_file, "--width", SIDE, "--height", SIDE, "--spp", 1024, "--bounces", 1, "-q", *sky
        )
        truth = exr.read(truth_file)
        environment.export(file, folder / "scene", (SIDE, SIDE), background=str(sky[1]) if sky else None)
        for peer in ("radiance", "mitsuba"):
            scene = scenes.load(folder / "scene")
            cells = []
            try:
                made = images(peer, scene, folder / peer)
            except SystemExit as refusal:
                bad += peer not in refusing
                print(f"| {name} | {peer} | {'refused' if peer in refusing else 'REFUSED'}: {refusal} | | | |", flush=True)
                continue
            bad += peer in refusing
            for bounces, layer in enumerate(("dir", "b1")):
                mask = truth["mask"][..., 0] > 0.5
                if peer == "radiance":
                    mask &= ~scene.points.bent().reshape(SIDE, SIDE)
                found = metrics.compare(made[bounces], truth[layer], mask)
                energy, blocks = LIMITS[peer, bounces]
                energy = max(energy, NORMAL_MAP if name == "normal map" else 0)
                above = abs(found["energy"] - 1) > energy or found["block_mae"] > blocks
                bad += above
                mark = " !" if above else ""
                cells += [f"{100 * (found['energy'] - 1):+.2f} %", f"{100 * found['block_mae']:.2f} %{mark}"]
            print(f"| {name} | {peer} | {' | '.join(cells)} |", flush=True)
    if bad:
        print(f"{bad} above their limits", file=sys.stderr)
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
