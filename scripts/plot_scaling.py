#!/usr/bin/env python3
"""Draws what scripts/scaling_study.py wrote:  scripts/plot_scaling.py scaling.csv -o docs/scaling.png"""
import argparse
import csv
import os
import sys

try:
    import matplotlib
except ImportError:
    sys.exit("this needs matplotlib: apt-get install python3-matplotlib, and the python3 it belongs to")

matplotlib.use("Agg")
import matplotlib.pyplot as plt

NAMES = {("splats", "ring"): "ring, fat tree", ("splats", "mesh"): "mesh", ("sheets", "ring"): "sheets, ring, fat tree"}
COLOURS = {("splats", "ring"): "tab:blue", ("splats", "mesh"): "tab:orange", ("sheets", "ring"): "tab:green"}
WORDS = {"strong": "1024³", "large": "4096³", "weak": "weak: a million voxels a rank"}
STYLES = {"strong": "-o", "large": "-^", "weak": ":s"}


def points(rows, x, y, **wanted):
    chosen = [r for r in rows if all(r[key] == value for key, value in wanted.items())]
    return zip(*sorted((float(r[x]), float(r[y])) for r in chosen)) if chosen else None


def scaling(panel, rows):
    for study, style in STYLES.items():
        for (method, topology), name in NAMES.items():
            line = points(rows, "ranks", "seconds", study=study, topology=topology, method=method)
            if line:
                panel.loglog(*line, style, color=COLOURS[method, topology], label=f"{WORDS[study]}, {name}")
    panel.set(xlabel="ranks", ylabel="seconds a frame", title="Strong and weak scaling")
    panel.set_xticks([16, 64, 256, 1024], ["16", "64", "256", "1024"])


def tokens(panel, rows):
    """Frames of ever smaller slices."""
    some = [r | {"width": float(r["voxels_a_slice"]) ** 0.5} for r in rows if r["study"] == "tokens" and float(r["voxels"]) > 0]
    for colour, machine in zip(("tab:blue", "tab:orange", "tab:green"), sorted({(r["machine"], r["layout"], r["renderers"]) for r in some})):
        of = [r for r in some if (r["machine"], r["layout"], r["renderers"]) == machine]
        name = f"{machine[0].removesuffix('.toml')}, {machine[1]} + {machine[2]}"
        panel.loglog(*points(of, "width", "seconds"), "-o", color=colour, label=name)
        panel.loglog(*points(of, "width", "renderer_drawing_most"), ":", color=colour, label="its busiest Renderer's drawing")
    widths = sorted({r["width"] for r in some})
    panel.set_xticks(widths, [f"{width:.0f}²" for width in widths])
    panel.minorticks_off()
    panel.set(xlabel="voxels of each of 1024 slices", ylabel="seconds a frame", title="Where tokens are the limit")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("csv")
    parser.add_argument("-o", "--output", required=True, help="PNG")
    arguments = parser.parse_args()
    with open(arguments.csv, encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    figure, panels = plt.subplots(1, 2, figsize=(11, 4.5), layout="constrained")
    for panel, draw in zip(panels, (scaling, tokens)):
        draw(panel, rows)
        panel.grid(alpha=0.3, which="both")
        panel.margins(y=0.3)
        if panel.get_legend_handles_labels()[0]:
            panel.legend(fontsize=8)
    beside = arguments.output + ".part.png"
    figure.savefig(beside, dpi=110)
    os.replace(beside, arguments.output)


if __name__ == "__main__":
    main()
