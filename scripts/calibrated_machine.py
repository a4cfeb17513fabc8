#!/usr/bin/env python3
"""Turns the statistics that scripts/calibrate.sh gathered into a machine: calibrated_machine.py FOLDER CORES"""
import json
import os
import statistics
import sys


def frames(folder, name):
    with open(os.path.join(folder, name + ".jsonl"), encoding="utf-8") as file:
        return [json.loads(line) for line in file]


def typical(values):
    """What real frames are compared by as well: the least of many would be of a machine without disturbances."""
    return max(0.0, statistics.median(values))


def solved(rows):
    """x, y, z with a x + b y + c z = d for each (a, b, c, d), by Cramer's rule."""
    def determinant(m):
        (a, b, c), (d, e, f), (g, h, i) = m
        return a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)

    whole = determinant([row[:3] for row in rows])
    return [determinant([row[:k] + row[3:] + row[k + 1:3] for row in rows]) / whole for k in range(3)]


def sheet_costs(folder):
    """Each cost of sheets by its field's name."""
    large, small, many, few, wide, tiny = (frames(folder, "sheets" + name) for name in ("", "_small", "_many", "_few", "_wide", "_tiny"))

    def total(some, count):
        return typical(f["total"][count] for f in some)

    def seconds(some, part):
        return typical(f["total"]["seconds"][part] for f in some)

    def looked(some, role):
        return typical(sum(node["blocks"] for node in f["nodes"] if node["node"].startswith(role)) for f in some)

    costs = {"table": seconds(tiny, "drawing")}
    costs["sample"] = (seconds(large, "drawing") - seconds(small, "drawing")) / (total(large, "samples") - total(small, "samples"))

    def row(some):
        """Payloads, blocks looked at and blocks placed, and the seconds that they took together."""
        drawing = sum(node["payloads_drawn"] > 0 for node in some[0]["nodes"] if node["node"].startswith("Renderer"))
        return [total(some, "payloads_drawn"), looked(some, "Renderer"), total(some, "splats_drawn"),
                seconds(some, "drawing") - drawing * costs["table"] - costs["sample"] * total(some, "samples")]

    # Between few and many Renderers the same is painted, whatever a sample of that volume costs.
    rows = [row(small), [a - b for a, b in zip(row(many), row(small))], [a - b for a, b in zip(row(wide), row(few))]]
    costs["slice"], costs["look"], costs["place"] = (max(0.0, cost) for cost in solved(rows))
    costs["copy"] = max(0.0, (seconds(wide, "computing") - costs["look"] * looked(wide, "GP")) / total(wide, "splats_sent"))
    return costs


def main():
    folder, cores = sys.argv[1:3]
    head, empty, tiny, line, hop = (frames(folder, name) for name in ("head", "empty", "tiny", "line", "hop"))
    voxels = 128 * 128 * 124

    # What a frame costs whatever is in it: eight voxels.
    gp_frame = typical(f["total"]["seconds"]["computing"] for f in tiny)
    transparent = typical((f["total"]["seconds"]["computing"] - gp_frame) / voxels for f in empty)
    visible = typical((f["total"]["seconds"]["computing"] - gp_frame - transparent * (voxels - f["total"]["visible_voxels"]))
                    / f["total"]["visible_voxels"] for f in head)
    splat = typical(f["total"]["seconds"]["drawing"] / f["total"]["splats_sent"] for f in head)
    composite = typical(f["total"]["seconds"]["compositing"] / f["total"]["payloads_drawn"] for f in head)
    pixel = typical(f["total"]["seconds"]["delivering"] / (f["total"]["tile_bytes"] / 16) for f in head)
    slice_cost = typical((f["total"]["seconds"]["computing"] - gp_frame) / f["total"]["slices"] for f in line)
    # Each of the 4096 slices passes the token on, to the same rank: what is not encoding.
    token = typical((f["seconds"] - f["total"]["seconds"]["computing"]) / 4096 for f in line)
    # The same from rank to rank: both sides' software and the way between them, in equal parts.
    message = typical(f["seconds"] / 4096 - slice_cost - token for f in hop) / 3

    sheets = sheet_costs(folder)

    print(f'''# Measured by scripts/calibrate.sh on this machine: one GP and one Renderer, the head at 512x512 pixels.
name = "Two cores"
# The program's bounded pieces of work.
poll_interval = 200e-6

[gp]
visible_voxel = {visible:.4g}
transparent_voxel = {transparent:.4g}
slice = {slice_cost:.4g}
frame = {gp_frame:.4g}
token = {token:.4g}

[renderer]
splat = {splat:.4g}
slice = {composite:.4g}
pixel = {pixel:.4g}

[sheets]
look = {sheets["look"]:.4g}
copy = {sheets["copy"]:.4g}
place = {sheets["place"]:.4g}
slice = {sheets["slice"]:.4g}
sample = {sheets["sample"]:.4g}
table = {sheets["table"]:.4g}

[message]
# From what a token takes between two ranks on cores of their own.
send = {message:.4g}
receive = {message:.4g}

[platform]
# All ranks share the cores of one host; messages go through its memory.
kind = "backbone"
bandwidth = 1e10
latency = {message:.4g}
local_bandwidth = 4e9
local_latency = {message:.4g}
hosts = 1
cores = {cores}''')


if __name__ == "__main__":
    main()
