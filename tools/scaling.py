#!/usr/bin/env python3
"""How the cost of a record grows with the scene's triangles: the same surface cut finer and finer.

  tools/scaling.py SCENE.gltf -o chart.svg [--levels 3] [--runs 3] [--rough 0.001] [-- OPTIONS]

Cuts the scene by tools/tessellate.py into 4, 16, 64, … times the triangles, renders each at 64 × 64 pixels with default
settings (and OPTIONS of `hemicube render`), in turns, and prints a table: triangles, records, microseconds a record of all
passes that capture and integrate (least of the runs), how many times the scene's own, device memory. Draws the same as a chart.
"""
import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

from frame import HEMICUBE

PASSES = {"cull", "capture", "capture_compute", "integrate"}
WIDTH, HEIGHT, MARGIN = 480, 300, 50


def measure(scene, options, folder):
    """Triangles, records, µs a record, bytes."""
    stats = folder / "stats.json"
    subprocess.run([HEMICUBE, "render", scene, "-q", "-o", folder / "out.exr", "--width", "64", "--height", "64",
                    "--stats", stats, *options], check=True, stdout=subprocess.DEVNULL)
    said = json.loads(stats.read_text())
    spent = sum(p["total_ms"] for p in said["passes"] if p["name"] in PASSES)
    return said["scene"]["triangles"], said["records"], spent * 1e3 / said["records"], said["memory"]["gpu_bytes"]


def chart(points):
    """An SVG: µs a record over triangles, every 4 × to the right, from 0 up."""
    most = 1.15 * max(cost for _, cost in points)
    x = lambda i: MARGIN + i * (WIDTH - 2 * MARGIN) / max(len(points) - 1, 1)
    y = lambda cost: HEIGHT - MARGIN - cost / most * (HEIGHT - 2 * MARGIN)
    text = lambda x, y, words: f'<text x="{x:.0f}" y="{y:.0f}" text-anchor="middle">{words}</text>'
    line = " ".join(f"{x(i):.1f},{y(cost):.1f}" for i, (_, cost) in enumerate(points))
    marks = [text(x(i), HEIGHT - MARGIN + 20, f"{n:,}") + text(x(i), y(cost) - 10, f"{cost:,.0f} µs")
             + f'<circle cx="{x(i):.1f}" cy="{y(cost):.1f}" r="3"/>' for i, (n, cost) in enumerate(points)]
    floor = HEIGHT - MARGIN
    return "\n".join([f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" font-family="sans-serif" font-size="12">',
                      f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>',
                      f'<polyline points="{line}" fill="none" stroke="#1f77b4" stroke-width="2"/>',
                      f'<path d="M{MARGIN / 2} {floor}H{WIDTH - MARGIN / 2}" stroke="black"/>', *marks,
                      text(WIDTH / 2, HEIGHT - 8, "triangles"), text(WIDTH / 2, 20, "time of a record"), "</svg>\n"])


def main():
    split = sys.argv.index("--") if "--" in sys.argv else len(sys.argv)
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", type=Path)
    parser.add_argument("-o", "--output", type=Path, required=True, help="chart to write, SVG")
    parser.add_argument("--levels", type=int, default=3, help="finest: 4^LEVELS times the triangles (3)")
    parser.add_argument("--runs", type=int, default=3, help="runs of each (3)")
    parser.add_argument("--rough", type=float, default=0.0, help="what tools/tessellate.py moves vertices by, of each finer one (0)")
    arguments = parser.parse_args(sys.argv[1:split])
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        scenes = [arguments.scene]
        for level in range(1, arguments.levels + 1):
            scenes.append(folder / f"{4 ** level}.gltf")
            subprocess.run([sys.executable, Path(__file__).with_name("tessellate.py"), arguments.scene.resolve(), "-o", scenes[-1],
                            "--levels", str(level), "--rough", str(arguments.rough)], check=True, stdout=subprocess.DEVNULL)
        runs = [[measure(scene, sys.argv[split + 1:], folder) for scene in scenes] for _ in range(arguments.runs)]
    best = [min(column, key=lambda run: run[2]) for column in zip(*runs, strict=True)]
    print("| triangles | records | µs a record | | device memory |\n|--:|--:|--:|--:|--:|")
    for triangles, records, cost, memory in best:
        print(f"| {triangles:,} | {records:,} | {cost:,.0f} | {cost / best[0][2]:.2f} × | {memory / 1e6:,.0f} MB |")
    arguments.output.write_text(chart([(triangles, cost) for triangles, _, cost, _ in best]))


if __name__ == "__main__":
    main()
