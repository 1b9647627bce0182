"""Measured points as CSV: the columns that `hemicube convergence` writes too, which mean the same there."""

from __future__ import annotations

import csv
from pathlib import Path

Point = dict[str, str]

COLUMNS = (
    "scene width height bounces method settings threads repeats records setup_cpu_s cpu_s wall_s wall_spread_s "
    "indirect_cpu_s indirect_wall_s indirect_cpu_spread_s mae rms relmse p95 p99 max energy block_mae block_rms "
    "non_finite_test reference version"
).split()
KEY = ["scene", "width", "height", "bounces", "method", "settings", "threads"]


def read(path: Path) -> list[Point]:
    """Points of earlier runs."""
    if not path.is_file():
        return []
    with path.open(newline="") as file:
        points = list(csv.DictReader(file))
    if any(column not in point for point in points for column in KEY):
        raise SystemExit(f"{path}: these are not points: columns are missing; choose another file")
    return points


def append(path: Path, point: Point) -> None:
    """Adds a line, so that a run that is broken off keeps what it has."""
    is_new = not path.is_file()
    with path.open("a", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS)
        if is_new:
            writer.writeheader()
        writer.writerow(point)
