#!/usr/bin/env python3
"""Error of the indirect light with and without gradients, at the same number of records.

  tools/equal_records.py SCENE.gltf E.exr [ACCURACY ...]     E.exr: a path-traced reference with layers b1 and mask

For each accuracy (default .6, .3) the scene is rendered with both gradients; then without, at the accuracy that gives the
same number of records within 1 %, found by bisection. Without gradients R is the harmonic mean distance, for the second
derivatives say nothing of what constant irradiance leaves out. Prints both errors and their ratio.
"""
import json
import math
import re
import subprocess
import sys
import tempfile
from pathlib import Path

HEMICUBE = Path(__file__).resolve().parent.parent / "target/release/hemicube"


def measure(scene, reference, size, gradients, accuracy):
    """Records, and mean absolute error over the mean."""
    with tempfile.TemporaryDirectory() as folder:
        picture, stats = Path(folder) / "out.exr", Path(folder) / "stats.json"
        subprocess.run([HEMICUBE, "render", scene, "-q", "-o", picture, "--layers", "irradiance", "--stats", stats,
                        "--width", str(size[0]), "--height", str(size[1]), "--gradients", gradients,
                        "--accuracy", f"{accuracy:.5f}"], check=True, stdout=subprocess.DEVNULL)
        compared = subprocess.run([HEMICUBE, "compare", picture, reference, "--layer", "irradiance=b1", "--mask", "mask",
                                   "--no-flip", "--json", "-"], check=True, capture_output=True, text=True)
        return json.loads(stats.read_text())["records"], json.loads(compared.stdout)["layers"][0]["mae"]


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
    scene, reference = sys.argv[1:3]
    found = re.search(r"(\d+)x(\d+)\.exr$", reference)
    if not found:
        sys.exit(f"{reference}: the name must end in WIDTHxHEIGHT.exr")
    run = lambda gradients, accuracy: measure(scene, reference, found.groups(), gradients, accuracy)
    print("accuracy  records   error  without: accuracy  records   error  ratio")
    for accuracy in map(float, sys.argv[3:] or ["0.6", "0.3"]):
        records, error = run("both", accuracy)
        without = at_equal_records(run, records)
        print(f"{accuracy:8.3f} {records:8d} {error:7.4f} {without[0]:18.3f} {without[1]:8d} {without[2]:7.4f}"
              f" {without[2] / error:6.2f}", flush=True)


if __name__ == "__main__":
    main()
