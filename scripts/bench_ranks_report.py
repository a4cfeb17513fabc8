#!/usr/bin/env python3
"""Table of scripts/bench_ranks.sh: bench_ranks_report.py FOLDER reads the --stats lines it wrote."""
import collections
import statistics
import sys
from pathlib import Path

from bench_report import frames

METHODS = (("paper", "splats"), ("best", "sheets"))
RANKS = (1, 2, 16, 64)


def layout_of(rows: list[dict]) -> str:
    """The one that most frames had."""
    def text(layout: dict) -> str:
        colocated = f" on {layout['ranks']} ranks" if layout["roles"] == "colocated" else ""
        return f"{layout['gps']} + {layout['renderers']}{colocated}"

    return collections.Counter(text(f["layout"]) for f in rows).most_common(1)[0][0]


def main() -> None:
    folder = Path(sys.argv[1])
    print("| method | ranks | GPs + Renderers | ms a frame | as fast as one process | time against two ranks |\n|---|---|---|---|---|---|")
    for quality, method in METHODS:
        rows = {ranks: frames(folder, f"{quality}-{ranks}") for ranks in RANKS}
        taken = {ranks: statistics.median(f["seconds"] for f in rows[ranks]) for ranks in RANKS}
        for ranks in RANKS:
            what = "one process" if ranks == 1 else str(ranks)
            print(f"| {method} | {what} | {layout_of(rows[ranks])} | {1e3 * taken[ranks]:.1f} "
                  f"| {taken[1] / taken[ranks]:.2f} | {100 * (taken[ranks] / taken[2] - 1):+.0f} % |")


if __name__ == "__main__":
    main()
