#!/usr/bin/env python3
"""Error of the indirect light with and without gradients, at the same number of records.

  tools/equal_records.py SCENE.gltf E.exr [ACCURACY ...] [-- OPTIONS]

E.exr: a path-traced reference with layers b1 and mask; OPTIONS: more of `hemicube render`'s, for all frames.

For each accuracy (default .6, .3) the scene is rendered with both gradients; then without, at the accuracy that gives the
same number of records within 1 %, found by bisection. Records may disagree (--contrast 0): without gradients they do
everywhere, and no accuracy would give as few. Without gradients R is the harmonic mean distance, for the second
derivatives say nothing of what constant irradiance leaves out. Prints both errors and their ratio.
"""
import math
import sys

from frame import frame


def measure(scene, reference, options, gradients, accuracy):
    """Records, and mean absolute error over the mean."""
    stats, layer = frame(scene, reference, "--gradients", gradients, "--accuracy", f"{accuracy:.5f}",
                         "--contrast", "0", *options)
    return stats["records"], layer["mae"]


def at_equal_records(run, wanted):
    """Accuracy, records and error without gradients at `wanted` records: more of them the smaller the accuracy."""
    low, high = 0.01, 4.0
    for _ in range(14):
        accuracy = math.sqrt(low * high)
        records, error = run("none", accuracy)
        if abs(records - wanted) <= 0.01 * wanted:
            break
        low, high = (accuracy, high) if records > wanted else (low, accuracy)
    return accuracy, records, error


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    scene, reference, *rest = sys.argv[1:]
    split = rest.index("--") if "--" in rest else len(rest)
    accuracies, options = rest[:split], rest[split + 1:]
    run = lambda gradients, accuracy: measure(scene, reference, options, gradients, accuracy)
    print("accuracy  records   error  without: accuracy  records   error  ratio")
    for accuracy in map(float, accuracies or ["0.6", "0.3"]):
        records, error = run("both", accuracy)
        without = at_equal_records(run, records)
        print(f"{accuracy:8.3f} {records:8d} {error:7.4f} {without[0]:18.3f} {without[1]:8d} {without[2]:7.4f}"
              f" {without[2] / error:6.2f}", flush=True)


if __name__ == "__main__":
    main()
