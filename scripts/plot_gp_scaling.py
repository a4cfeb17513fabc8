#!/usr/bin/env python3
"""Simulates and draws Figs. 7 and 9 of Neumann 1992: frame rate against GPs on Pixel-Planes 5.

    scripts/plot_gp_scaling.py -o docs/gp-scaling.png [--csv gp-scaling.csv]

The head (a third of the voxels visible) and an isosurface (11 %) with four, nine and sixteen Renderers, whose images have
256², 384² and 512² pixels. Takes some minutes.
"""
import argparse
import csv
import os
import sys
import tempfile

from simulation import PAPER, PaperVolumes, build, nodes, simulate

try:
    import matplotlib
except ImportError:
    sys.exit("this needs matplotlib: apt-get install python3-matplotlib, and the python3 it belongs to")

matplotlib.use("Agg")
import matplotlib.pyplot as plt

GPS = [1, 2, 3, 4, 6, 8, 10, 12, 15, 20, 25, 30, 35, 40]
SIZES = {4: 256, 9: 384, 16: 512}
FIELDS = ["volume", "gps", "renderers", "hertz", "gp_computing", "gp_waiting_for_token", "renderer_drawing", "renderer_drawing_most"]


def mean(values):
    return sum(values) / len(values)


def measure(name, volume, gps, renderers):
    settings = {**PAPER, "gps": gps, "renderers": renderers, "size": f"{SIZES[renderers]}x{SIZES[renderers]}"}
    frame = simulate(settings, *volume, "--count-only", "--shading", "none")[0]
    drawing = [n["seconds"]["drawing"] for n in nodes(frame, "Renderer")]
    return {"volume": name, "gps": gps, "renderers": renderers, "hertz": 1 / frame["seconds"],
            "gp_computing": mean([n["seconds"]["computing"] for n in nodes(frame, "GP")]),
            "gp_waiting_for_token": mean([n["seconds"]["waiting_for_token"] for n in nodes(frame, "GP")]),
            "renderer_drawing": mean(drawing), "renderer_drawing_most": max(drawing)}


def draw(rows):
    titles = {"head": "Head, a third visible (Fig. 7)", "isosurface": "Isosurface, 11 % visible (Fig. 9)"}
    figure, panels = plt.subplots(1, 2, figsize=(10, 4), layout="constrained", sharex=True)
    for panel, (name, title) in zip(panels, titles.items()):
        for renderers, marker in zip(SIZES, "os^"):
            points = [(r["gps"], r["hertz"]) for r in rows if r["volume"] == name and r["renderers"] == renderers]
            panel.plot(*zip(*points), marker=marker, markersize=4, label=f"{renderers} Renderers, {SIZES[renderers]}² pixels")
        panel.set(title=title, xlabel="GPs", ylabel="frames per second", xlim=(0, 41), ylim=0)
        panel.grid(alpha=0.3)
        panel.legend()
    return figure


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", required=True, help="PNG")
    parser.add_argument("--csv", help="also write the numbers")
    arguments = parser.parse_args()
    build()
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        volumes = PaperVolumes(folder)
        for name, volume in {"head": volumes.head, "isosurface": volumes.isosurface}.items():
            for renderers in SIZES:
                rows += [measure(name, volume, gps, renderers) for gps in GPS]
                print(name, renderers, "Renderers:", *(f"{r['gps']}:{r['hertz']:.2f}" for r in rows[-len(GPS):]), "Hz")
    if arguments.csv:
        beside = arguments.csv + ".part"
        with open(beside, "w", newline="", encoding="utf-8") as file:
            out = csv.DictWriter(file, FIELDS)
            out.writeheader()
            out.writerows(rows)
        os.replace(beside, arguments.csv)
    beside = arguments.output + ".part.png"
    draw(rows).savefig(beside, dpi=110)
    os.replace(beside, arguments.output)


if __name__ == "__main__":
    main()
