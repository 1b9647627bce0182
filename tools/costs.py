#!/usr/bin/env python3
"""What each addition to a plain irradiance cache costs and brings, by leaving it out.

  tools/costs.py SCENE.gltf E.exr [RUNS]     E.exr: a path-traced reference with layers b1 and mask

Renders the scene with default settings and with each addition left out, in turns, RUNS times (default 3), and prints a table:
records, milliseconds on the device of each pass that records take (medians), mean absolute error, 99th percentile and energy.
"""
import statistics
import sys

from frame import frame

LEFT_OUT = {
    "default": [],
    "--contrast 0": ["--contrast", "0"],
    # Without gradients records disagree everywhere.
    "--contrast 0 --gradients none": ["--contrast", "0", "--gradients", "none"],
    "--contrast 0 --gradients rotation": ["--contrast", "0", "--gradients", "rotation"],
    "--contrast 0 --gradients translation": ["--contrast", "0", "--gradients", "translation"],
    "--radius harmonic": ["--radius", "harmonic"],
    "--neighbours free": ["--neighbours", "free"],
    "--hidden allow": ["--hidden", "allow"],
    "--weight ward": ["--weight", "ward"],
}
PASSES = {"capture_compute": "capture", "cull": "capture", "capture": "capture",
          "integrate": "integrate", "clamp_records": "clamp_records", "splat": "splat"}
COLUMNS = ["capture", "integrate", "clamp_records", "splat"]


def times(stats):
    """Milliseconds by column, and of all passes."""
    sums = dict.fromkeys(COLUMNS, 0.0)
    for spent in stats["passes"]:
        if spent["name"] in PASSES:
            sums[PASSES[spent["name"]]] += spent["total_ms"]
    return [*sums.values(), stats["gpu_ms"]]


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    runs = int(sys.argv[3]) if len(sys.argv) > 3 else 3
    measured = {name: [] for name in LEFT_OUT}
    for _ in range(runs):
        for name, options in LEFT_OUT.items():
            measured[name].append(frame(sys.argv[1], sys.argv[2], *options))
    print("| | records |", " | ".join(f"{c}, ms" for c in [*COLUMNS, "all passes"]), "| error | p99 | energy |")
    print("|---|--:|" + "--:|" * (len(COLUMNS) + 4))
    for name, frames in measured.items():
        stats, layer = frames[0]
        spent = [statistics.median(column) for column in zip(*(times(s) for s, _ in frames), strict=True)]
        print(f"| {name} | {stats['records']:,} |", " | ".join(f"{ms:,.0f}" for ms in spent),
              f"| {layer['mae']:.2%} | {layer['p99']:.1%} | {layer['energy'] - 1:+.2%} |")


if __name__ == "__main__":
    main()
