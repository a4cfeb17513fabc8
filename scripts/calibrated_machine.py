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
