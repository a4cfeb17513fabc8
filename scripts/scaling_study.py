#!/usr/bin/env python3
"""Strong and weak scaling on simulated clusters, and what tokens alone cost.

    scripts/scaling_study.py -o FOLDER [--most-ranks 1024] [--machine mpi_configs/machines/infiniband-fat-tree.toml]

Writes FOLDER/scaling.csv and FOLDER/scaling.png. A volume of n³ voxels is rendered by the counts of one of 128 × 128 × n, whose voxels
stand for (n / 128)² each (docs/simulation.md). 64 ranks take about half a minute, 1,024 ranks some minutes and 4 GB.
"""
import argparse
import csv
import os
import sys
import tempfile

from simulation import MACHINES, build, nodes, program, simulate, step_function, threshold_for

try:
    import matplotlib
except ImportError:
    sys.exit("this needs matplotlib: apt-get install python3-matplotlib, and the python3 it belongs to")

matplotlib.use("Agg")
import matplotlib.pyplot as plt

# An odd number of Renderers spreads a square picture's regions evenly: with a divisor of the regions in a row, each would own columns.
STRONG = [(9, 7), (33, 31), (129, 127), (769, 255)]
WEAK = [(256, 9, 7), (512, 65, 63), (1024, 769, 255)]
FIELDS = ["study", "voxels", "ranks", "gps", "renderers", "seconds", "gp_computing", "renderer_drawing", "renderer_drawing_most",
          "tokens", "payload_gigabytes"]


class Study:
    def __init__(self, folder, machine):
        self.folder = folder
        self.machine = machine

    def volume(self, n, visible):
        """A ball of which 32 % of the cube's voxels are visible, or nothing is, as arguments; made once."""
        width = f"{n / 128:g}"
        path = os.path.join(self.folder, f"ball{n}_128x128x{n}_uint8.raw")
        curve = os.path.join(self.folder, "ball.json")
        if not os.path.exists(path):
            program("synth", "ball", "-o", os.path.join(self.folder, f"ball{n}.raw"), "--dims", f"128x128x{n}", "--spacing", f"{width}x{width}x1")
            step_function(curve, threshold_for(path, round(0.32 * 128 * 128 * n)))
        if not visible:
            curve = step_function(os.path.join(self.folder, "nothing.json"), 0, opacity=0)
        weight = (n / 128) ** 2 if visible else 1
        return [path, "--spacing", f"{width}x{width}x1", "--tf", curve, "--voxel-weight", f"{weight:g}", "--size", f"{n}x{n}"]

    def row(self, study, n, gps, renderers, visible=True):
        settings = {"machine": self.machine, "gps": gps, "renderers": renderers, "frames-in-flight": 1}
        # From above every slice lies flat on the screen; zoomed so that the cube fills the picture.
        view = ["--azimuth", 0, "--elevation", 90, "--zoom", 1.7, "--region", 64, "--radius", 0.5, "--shading", "none", "--count-only"]
        frame = simulate(settings, *self.volume(n, visible), *view)[0]
        drawing = [node["seconds"]["drawing"] for node in nodes(frame, "Renderer")]
        computing = [node["seconds"]["computing"] for node in nodes(frame, "GP")]
        row = dict(zip(FIELDS, [study, f"{n}^3", gps + renderers, gps, renderers, frame["seconds"], sum(computing) / gps,
                                sum(drawing) / renderers, max(drawing), frame["total"]["tokens_passed"],
                                frame["total"]["payload_bytes_sent"] / 1e9]))
        print(*(f"{v:.4g}" if isinstance(v, float) else v for v in row.values()), flush=True)
        return row


def draw(rows, path):
    figure, panel = plt.subplots(figsize=(6, 4), layout="constrained")
    for study, marker in {"strong": "o", "weak": "s", "tokens": "^"}.items():
        points = [(r["ranks"], 1e3 * r["seconds"]) for r in rows if r["study"] == study]
        if points:
            panel.loglog(*zip(*points), marker=marker, label=study)
    panel.set(xlabel="ranks", ylabel="milliseconds a frame")
    panel.grid(alpha=0.3, which="both")
    panel.legend()
    figure.savefig(path + ".part.png", dpi=110)
    os.replace(path + ".part.png", path)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", required=True, help="a folder")
    parser.add_argument("--most-ranks", type=int, default=1024)
    parser.add_argument("--machine", default=os.path.join(MACHINES, "infiniband-fat-tree.toml"))
    arguments = parser.parse_args()
    os.makedirs(arguments.output, exist_ok=True)
    build()
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        study = Study(folder, os.path.abspath(arguments.machine))
        print(*FIELDS)
        for gps, renderers in STRONG:
            if gps + renderers <= arguments.most_ranks:
                rows.append(study.row("strong", 1024, gps, renderers))
                rows.append(study.row("tokens", 1024, gps, renderers, visible=False))
        rows += [study.row("weak", n, g, r) for n, g, r in WEAK if g + r <= arguments.most_ranks]
    target = os.path.join(arguments.output, "scaling.csv")
    with open(target + ".part", "w", newline="", encoding="utf-8") as file:
        out = csv.DictWriter(file, FIELDS)
        out.writeheader()
        out.writerows(rows)
    os.replace(target + ".part", target)
    draw(rows, os.path.join(arguments.output, "scaling.png"))


if __name__ == "__main__":
    main()
