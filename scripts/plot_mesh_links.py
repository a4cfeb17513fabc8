#!/usr/bin/env python3
"""Draws a heat map of a mesh's links from what `ringsplat render ... --stats FILE` wrote.

    scripts/plot_mesh_links.py STATS.json -o links.png [--frame N] [--what bytes]

Every GP is a square, every Renderer a circle at its row's end; every directed link is an arrow, as wide
and as dark as it was busy. In a mesh that wraps, the links between the bottom and the top row leave the picture.
"""
import argparse
import json
import sys

from figures import matplotlib, plt, write_figure
from matplotlib.colors import Normalize

WHAT = {
    "bytes": "MiB",
    "payload_bytes": "MiB of splat messages",
    "messages": "messages",
    "payloads": "splat messages",
    "shared": "messages that met another one on the link",
    "waited": "messages that waited for a slot",
    "wait_seconds": "milliseconds waited",
}
SCALE = {"bytes": 2.0**-20, "payload_bytes": 2.0**-20, "wait_seconds": 1e3}
STEP = {"W": (-1, 0), "E": (1, 0), "N": (0, -1), "S": (0, 1)}
SIDE = 0.17  # from the middle of a node to its rim
ASIDE = 0.07  # keeps the two directions of a link apart


def read_frames(path):
    """The frames of a --stats file: a JSON array, or an object a line in a .jsonl."""
    with open(path, encoding="utf-8") as file:
        text = file.read()
    if path.endswith(".jsonl"):
        return [json.loads(line) for line in text.splitlines() if line.strip()]
    frames = json.loads(text)
    return frames if isinstance(frames, list) else [frames]


def place(rank, layout):
    """Column and row of a rank; Renderers stand one column beyond the edge."""
    columns, rows = layout["mesh"]
    if rank < layout["gps"]:
        return rank % columns, rank // columns
    renderer = rank - layout["gps"]
    return (-1, renderer) if renderer < rows else (columns, renderer - rows)


def draw(frame, what):
    layout = frame["layout"]
    columns, rows = layout["mesh"]
    figure, axes = plt.subplots(figsize=(1.3 * (columns + 2) + 2.6, 1.3 * (rows + 1) + 0.9), layout="constrained")
    values = [link[what] * SCALE.get(what, 1) for link in frame["links"]]
    colours = plt.get_cmap("viridis_r")
    norm = Normalize(0, max(values) or 1)
    for link, value in zip(frame["links"], values):
        x, y = place(link["from"], layout)
        dx, dy = STEP[link["link"][-1]]
        aside = (-dy * ASIDE, dx * ASIDE)
        start = (x + dx * SIDE + aside[0], y + dy * SIDE + aside[1])
        end = (x + dx * (1 - SIDE) + aside[0], y + dy * (1 - SIDE) + aside[1])
        arrow = {
            "arrowstyle": "-|>,head_width=0.25,head_length=0.45",
            "color": colours(norm(value)) if value else "0.85",
            "linewidth": 1 + 4 * norm(value),
            "shrinkA": 0,
            "shrinkB": 0,
        }
        axes.annotate("", xy=end, xytext=start, arrowprops=arrow)
    for rank in range(layout["ranks"]):
        x, y = place(rank, layout)
        gp = rank < layout["gps"]
        axes.plot(x, y, "s" if gp else "o", markersize=22, color="white", markeredgecolor="0.3", zorder=3)
        axes.text(x, y, str(rank) if gp else f"R{rank - layout['gps']}", ha="center", va="center", fontsize=9, zorder=4)
    axes.set_xlim(-1.5, columns + 0.5)
    axes.set_ylim(rows - 0.1, -0.9)
    axes.set_aspect("equal")
    axes.set_axis_off()
    axes.set_title(f"{columns}×{rows} GPs, {layout['renderers']} Renderers, frame {frame['frame']}", fontsize=11)
    figure.colorbar(matplotlib.cm.ScalarMappable(norm, colours), ax=axes, label=WHAT[what], shrink=0.8)
    return figure


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("stats", help="written by ringsplat render --stats")
    parser.add_argument("-o", "--output", required=True, help="PNG")
    parser.add_argument("--frame", type=int, default=0)
    parser.add_argument("--what", choices=WHAT, default="bytes")
    arguments = parser.parse_args()
    try:
        frames = {frame["frame"]: frame for frame in read_frames(arguments.stats)}
    except (OSError, ValueError, TypeError, KeyError) as error:
        sys.exit(f"{arguments.stats} cannot be read as statistics: {error}")
    if arguments.frame not in frames:
        sys.exit(f"{arguments.stats} has no frame {arguments.frame}; it has {len(frames)} frame(s)")
    frame = frames[arguments.frame]
    if "links" not in frame:
        sys.exit(f"{arguments.stats} has no links: render with --topology mesh and --routing manhattan")
    write_figure(draw(frame, arguments.what), arguments.output)


if __name__ == "__main__":
    main()
