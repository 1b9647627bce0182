#!/usr/bin/env python3
"""Prints the errors of several stability.csv side by side, as a Markdown table.

    tools/side_by_side.py A/stability.csv B/stability.csv ...
"""

import csv
import sys
from pathlib import Path


def read(path):
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def main():
    tables = {Path(path).parent.name: read(path) for path in sys.argv[1:]}
    if not tables:
        sys.exit(__doc__)
    for name, rows in tables.items():
        failed = sum(row["holds"] != "yes" for row in rows)
        print(f"{name}: {rows[0]['device']}, {len(rows)} rows, {failed} out of bounds")
    print()
    print("| capture | case | quantity | tolerance |", " | ".join(tables), "|")
    print("|---|---|---|---|" + "---|" * len(tables))
    for rows in zip(*tables.values()):
        mark = [row["error"] if row["holds"] == "yes" else f"**{row['error']}**" for row in rows]
        print(f"| {rows[0]['capture']} | {rows[0]['case']} | {rows[0]['quantity']} | {rows[0]['tolerance']} |", " | ".join(mark), "|")


if __name__ == "__main__":
    main()
