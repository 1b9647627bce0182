#!/usr/bin/env python3
"""Prints the errors of several stability.csv side by side, as a Markdown table.

    tools/side_by_side.py [--short] A/stability.csv B/stability.csv ...

Each row of the suite with its error on each driver; with --short, the worst row of each kind of capture and quantity: its
error in parts of its own tolerance, and of what must not be, how often it is.
"""

import argparse
import csv
import sys
from pathlib import Path


def read(path):
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def quantity_of(row):
    """What kind of quantity a row is of: rows without a tolerance count what must not be."""
    if float(row["tolerance"]) == 0.0:
        return "what must not be"
    quantity = row["quantity"]
    if quantity.startswith(("∇", "‖∇", "dE")):
        return "gradients"
    return "1/R" if quantity == "1/R" else "E"


def all_rows(tables):
    yield ["capture", "case", "quantity", "tolerance", *tables]
    for rows in zip(*tables.values()):
        marks = [row["error"] if row["holds"] == "yes" else f"**{row['error']}**" for row in rows]
        yield [rows[0][column] for column in ("capture", "case", "quantity", "tolerance")] + marks


def worst_rows(tables):
    yield ["capture", "quantity", "rows", *tables]
    groups = {}
    for name, rows in tables.items():
        for row in rows:
            groups.setdefault((row["capture"], quantity_of(row)), {}).setdefault(name, []).append(row)
    for (capture, quantity), by_driver in groups.items():
        cells = [worst(quantity, by_driver.get(name, [])) for name in tables]
        yield [capture, quantity, max(len(rows) for rows in by_driver.values()), *cells]


def worst(quantity, rows):
    if quantity == "what must not be":
        return f"{sum(float(row['error']) != 0.0 for row in rows)}"
    share = max((float(row["error"]) / float(row["tolerance"]) for row in rows), default=float("nan"))
    out = sum(row["holds"] != "yes" for row in rows)
    return f"{share:.2f}" + (f" (**{out} out of bounds**)" if out else "")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--short", action="store_true", help="the worst row of each kind of capture and quantity")
    parser.add_argument("tables", nargs="+", type=Path, metavar="stability.csv")
    args = parser.parse_args()
    tables = {path.parent.name: read(path) for path in args.tables}
    counts = {len(rows) for rows in tables.values()}
    if len(counts) > 1:
        sys.exit(f"the tables have {sorted(counts)} rows: they are not of the same suite")
    for name, rows in tables.items():
        failed = sum(row["holds"] != "yes" for row in rows)
        print(f"{name}: {rows[0]['device']}, {len(rows)} rows, {failed} out of bounds")
    print()
    header, *lines = (worst_rows if args.short else all_rows)(tables)
    print("| " + " | ".join(header) + " |")
    print("|---|---|" + "--:|" * (len(header) - 2))
    for line in lines:
        print("| " + " | ".join(map(str, line)) + " |")


if __name__ == "__main__":
    main()
