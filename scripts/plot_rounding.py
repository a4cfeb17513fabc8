#!/usr/bin/env python3
"""Draws the renderer's roundings against size.

    build/release/measure_roundings > roundings.csv
    scripts/plot_rounding.py roundings.csv -o docs/accuracy-rounding.png
"""

import argparse
import csv
import pathlib
import sys
from collections import defaultdict

try:
    import matplotlib
except ImportError:
    sys.exit("this needs matplotlib: apt-get install python3-matplotlib, and the python3 it belongs to")

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

PANELS = {
    "drift": ("Positions along a row", "voxels in the row", "largest error (pixels)"),
    "quadratic": ("The quadratic Q, 1 pixel a voxel", "distance of a fixed origin (pixels)", "largest error of Q"),
    "kernel": ("The quadratic Q", "pixels a voxel", "largest error of Q"),
    "composite": ("The composite", "slices", "largest error (values in 0..1)"),
}


def read_lines(path):
    """{rounding: {line: [(size, error)]}}"""
    lines = defaultdict(lambda: defaultdict(list))
    with open(path, newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            lines[row["rounding"]][row["line"]].append((float(row["size"]), float(row["error"])))
    missing = PANELS.keys() - lines.keys()
    if missing:
        sys.exit(f"{path} has nothing of {', '.join(sorted(missing))}; hint: build/release/measure_roundings > {path}")
    return lines


def draw(lines):
    figure, axes = plt.subplots(1, len(PANELS), figsize=(4.2 * len(PANELS), 3.8))
    for axis, (rounding, (title, x, y)) in zip(axes, PANELS.items()):
        for line, points in lines[rounding].items():
            style = {"color": "0.4", "linestyle": "--"} if line == "bound" else {"marker": "o", "markersize": 3}
            # A logarithmic axis has no zero: an exact result is drawn where its line would leave the picture.
            axis.plot([p[0] for p in points], [max(p[1], 1e-17) for p in points], label=line, linewidth=1, **style)
        axis.set(title=title, xlabel=x, ylabel=y, xscale="log", yscale="log")
        low, high = axis.get_ylim()
        if high < 1e3 * low:  # a line that hardly changes is to look so
            axis.set_ylim(low / 30, high * 30)
        axis.grid(alpha=0.3)
        axis.legend(fontsize=7)
    return figure


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("csv", type=pathlib.Path)
    parser.add_argument("-o", "--output", type=pathlib.Path, default=pathlib.Path("rounding.png"))
    options = parser.parse_args()
    figure = draw(read_lines(options.csv))
    figure.tight_layout()
    part = options.output.with_name(options.output.stem + ".part" + options.output.suffix)
    figure.savefig(part, dpi=110)
    part.rename(options.output)
    print(options.output)


if __name__ == "__main__":
    main()
