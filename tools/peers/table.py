#!/usr/bin/env python3
"""Prints measured points as Markdown tables: how long each method takes to each error, and what its usual settings give.

  tools/peers/table.py DIR/points.csv...                     as hemicube convergence and run.py write them
  tools/peers/table.py DIR/points.csv... --into src/guide/measurements.md    in place of what stands between the file's two marks

Times are those of the indirect light alone, processor seconds of all threads together / seconds on the clock, medians
over the repeats. Errors are mean absolute errors over the mean. Times to an error are interpolated in logarithms between
the points of a method that no other of its points beats; ≤ where its least exact point is better already, – where none
of them gets there.
"""

from __future__ import annotations

import argparse
import json
import math
import os
from pathlib import Path

import points
from points import Point

LEVELS = (0.1, 0.05, 0.03, 0.02, 0.01)
TIMES = ("indirect_cpu_s", "indirect_wall_s")
NAMES = {
    "splatting": "splatting", "ward": "Ward's cache, own", "path": "paths, own", "radiance": "Radiance", "mitsuba": "Mitsuba 3",
}
# What each program does when nothing else is asked of it; Mitsuba's own default of 16 samples is for a first look.
USUAL = {
    "splatting": {"accuracy": 0.3, "capture_size": 32, "gradients": "both"}, "ward": {"accuracy": 0.2, "rays": 1024},
    "path": {"spp": 256}, "radiance": {"ad": 512, "as": 128, "aa": 0.2, "ar": 64}, "mitsuba": {"spp": 256},
}
MARKS = ("<!-- tools/peers/measure.sh: -->", "<!-- end of tools/peers/measure.sh -->")
Series = tuple[str, str, str, str]


def series(point: Point) -> Series:
    """Scene with size, method, threads, and device: what a row is of."""
    scene = f"{point['scene']} {point['width']} × {point['height']}"
    return scene, point["method"], point["threads"], point.get("device") or "CPU"


def groups(all_points: list[Point]) -> dict[Series, list[Point]]:
    """Points by series: scenes as they come, methods in one order."""
    scenes = list(dict.fromkeys(series(point)[0] for point in all_points))
    found: dict[Series, list[Point]] = {}
    for point in all_points:
        found.setdefault(series(point), []).append(point)
    order = list(NAMES)
    return dict(sorted(found.items(), key=lambda item: (scenes.index(item[0][0]), order.index(item[0][1]), int(item[0][2]))))


def front(own: list[Point], time: str) -> list[tuple[float, float]]:
    """Times and errors of the points that no other is both faster and better than, by rising time."""
    pairs = sorted((float(p[time]), float(p["mae"])) for p in own if p.get(time) and float(p[time]) > 0)
    best: list[tuple[float, float]] = []
    for pair in pairs:
        if not best or pair[1] < best[-1][1]:
            best.append(pair)
    return best


def reach(points_: list[tuple[float, float]], error: float) -> str:
    """Seconds to an error."""
    after = next((k for k, (_, e) in enumerate(points_) if e <= error), None)
    if after is None:
        return "–"
    (t1, e1) = points_[after]
    if after == 0:
        return f"≤ {seconds(t1)}"
    (t0, e0) = points_[after - 1]
    return seconds(t0 * (t1 / t0) ** (math.log(e0 / error) / math.log(e0 / e1)))


def seconds(value: float) -> str:
    """Two or three digits."""
    return f"{value:.0f}" if value >= 99.5 else f"{value:.1f}" if value >= 9.95 else f"{value:.2f}"


def words(name: Series) -> list[str]:
    """First cells of a row."""
    scene, method, threads, device = name
    where = "" if device == "CPU" or "llvmpipe" in device else f" on {device}"
    return [scene, NAMES[method] + where, threads]


def reach_table(found: dict[Series, list[Point]]) -> list[str]:
    """Seconds to each of the levels."""
    head = [f"{100 * level:g} %" for level in LEVELS]
    lines = [f"| scene | method | threads | {' | '.join(head)} |", "|---|---|--:|" + "--:|" * len(head)]
    for name, own in found.items():
        fronts = [front(own, time) for time in TIMES]
        cells = []
        for level in LEVELS:
            times = [reach(points_, level) for points_ in fronts]
            cells.append("–" if set(times) == {"–"} else " / ".join(times))
        lines.append(f"| {' | '.join(words(name) + cells)} |")
    return lines


def usual_table(found: dict[Series, list[Point]]) -> list[str]:
    """Points in usual settings."""
    lines = [
        "| scene | method | threads | settings | records | CPU s | clock s, spread | error | 4 × 4 blocks | 99th percentile | energy |",
        "|---|---|--:|---|--:|--:|--:|--:|--:|--:|--:|",
    ]
    for name, own in found.items():
        wanted = USUAL[name[1]]
        for point in own:
            settings = json.loads(point["settings"])
            if name[1] == "splatting" and settings.get("capture") != capture(own):
                continue
            if all(settings.get(key) == value for key, value in wanted.items()):
                times = [seconds(float(point[time])) if point.get(time) else "–" for time in TIMES]
                times[1] += f" ± {seconds(float(point['wall_spread_s']))}" if int(point["repeats"]) > 1 else ""
                errors = [f"{100 * float(point[error]):.1f} %" for error in ("mae", "block_mae", "p99")]
                records = point["records"] if point["records"] != "0" else "–"
                energy = f"{100 * (float(point['energy']) - 1):+.1f} %"
                shown = ", ".join(f"{key} {value}" for key, value in wanted.items())
                lines.append(f"| {' | '.join([*words(name), shown, records, *times, *errors, energy])} |")
                break
    return lines


def capture(own: list[Point]) -> str:
    """The capture that most points of splatting have: the device's usual one."""
    kinds = [json.loads(point["settings"]).get("capture") for point in own]
    return max(set(kinds), key=kinds.count)


def put(into: Path, tables: str) -> None:
    """Replaces what stands between the marks."""
    text = into.read_text()
    parts = [text.partition(mark) for mark in MARKS]
    if not all(mark for _, mark, _ in parts):
        raise SystemExit(f"{into}: it has no lines {MARKS[0]} and {MARKS[1]}")
    into.write_text(f"{parts[0][0]}{MARKS[0]}\n\n{tables}\n\n{MARKS[1]}{parts[1][2]}")


def machine() -> str:
    """This machine's processor."""
    info = Path("/proc/cpuinfo")
    models = [line.split(":")[1].strip() for line in info.read_text().splitlines() if line.startswith("model name")] if info.is_file() else []
    return f"{models[0] if models else 'unknown processor'}, {os.cpu_count()} threads"


def charts(into: Path, found: dict[Series, list[Point]]) -> list[str]:
    """Lines that show assets/error-SCENE.svg, where there is one, by its path from the file."""
    lines = []
    for scene in dict.fromkeys(name[0] for name in found):
        chart = Path(f"assets/error-{scene.split()[0]}.svg")
        if chart.is_file():
            lines += [f"![{scene}: error against processor time]({os.path.relpath(chart, into.parent)})", ""]
    return lines


def main() -> None:
    """Both tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("points", type=Path, nargs="+", metavar="POINTS.csv")
    parser.add_argument("--into", type=Path, metavar="FILE.md")
    options = parser.parse_args()
    for file in options.points:
        if not file.is_file():
            parser.error(f"{file}: no such file")
    found = groups([point for file in options.points for point in points.read(file)])
    head = f"On {machine()}: processor seconds / clock seconds to a mean absolute error of"
    tables = "\n".join([head, "", *reach_table(found), "", "and in usual settings", "", *usual_table(found)])
    if options.into:
        put(options.into, "\n".join([*charts(options.into, found), tables]))
    else:
        print(tables)


if __name__ == "__main__":
    main()
