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

NAMES = {"ring": "ring, fat tree", "mesh": "mesh"}
COLOURS = {"ring": "tab:blue", "mesh": "tab:orange"}
WORDS = {"strong": "1024³", "large": "4096³", "weak": "weak: a million voxels a rank"}
STYLES = {"strong": "-o", "large": "-^", "weak": ":s"}


def points(rows, x, y, **wanted):
    chosen = [r for r in rows if all(r[key] == value for key, value in wanted.items())]
    return zip(*sorted((float(r[x]), float(r[y])) for r in chosen)) if chosen else None


def scaling(panel, rows):
    for study, style in STYLES.items():
        for topology, name in NAMES.items():
            line = points(rows, "ranks", "seconds", study=study, topology=topology)
            if line:
                panel.loglog(*line, style, color=COLOURS[topology], label=f"{WORDS[study]}, {name}")
    panel.set(xlabel="ranks", ylabel="seconds a frame", title="Strong and weak scaling")
    panel.set_xticks([16, 64, 256, 1024], ["16", "64", "256", "1024"])


def tokens(panel, rows):
    """Frames of ever smaller slices."""
    for topology, name in NAMES.items():
        of = [r | {"width": float(r["voxels_a_slice"]) ** 0.5} for r in rows
              if r["topology"] == topology and r["study"] == "tokens" and float(r["voxels"]) > 0]
        if of:
            most = of[0]["ranks"]
            panel.loglog(*points(of, "width", "seconds"), "-o", color=COLOURS[topology], label=f"frame, {name}, {most} ranks")
            panel.loglog(*points(of, "width", "renderer_drawing_most"), ":", color=COLOURS[topology], label="busiest Renderer's drawing")
            panel.set_xticks([r["width"] for r in of], [f"{r['width']:.0f}²" for r in of])
    panel.minorticks_off()
    panel.set(xlabel="voxels of each of 1024 slices", ylabel="seconds", title="Where tokens are the limit")


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
        if panel.get_legend_handles_labels()[0]:
            panel.legend(fontsize=8)
    beside = arguments.output + ".part.png"
    figure.savefig(beside, dpi=110)
    os.replace(beside, arguments.output)


if __name__ == "__main__":
    main()
