#!/usr/bin/env python3
"""Turns the statistics that scripts/calibrate.sh gathered into a machine: calibrated_machine.py FOLDER CORES

What Renderers spend, and GPs on sheets, is fitted to all runs of splats-*.jsonl and sheets-*.jsonl; standard error says how well.
"""
import math
import os
import statistics
import sys
from pathlib import Path

from bench_report import frames
from least_squares import non_negative


def runs(folder, kind):
    """Names of a kind's runs: KIND-SCENE, or KIND-SCENE-VARIANT."""
    return sorted(name[:-6] for name in os.listdir(folder) if name.startswith(kind + "-") and name.endswith(".jsonl"))


def typical(values):
    """What real frames are compared by as well: the least of many would be of a machine without disturbances."""
    return max(0.0, statistics.median(values))


def seconds(stats, *parts):
    return sum(stats["seconds"][part] for part in parts)


class Fit:
    """Costs by name, from how often each was paid in how many seconds."""

    def __init__(self, what, names):
        self.what, self.names, self.rows = what, list(names), []

    def add(self, run, spent, known, whole, **counts):
        """What one role did for a frame: seconds, those of them that are known, and those that all nodes spent on the frame. An
        error counts by how much of these it is, so that each frame counts alike."""
        self.names += [name for name in counts if name not in self.names]
        self.rows.append((run, spent, known, whole, counts))

    def solve(self):
        matrix = [[counts.get(name, 0) / whole for name in self.names] for _, _, _, whole, counts in self.rows]
        costs = non_negative(matrix, [(spent - known) / whole for _, spent, known, whole, _ in self.rows])
        self.costs = dict(zip(self.names, costs))
        return self.costs

    def fitted(self, row):
        _, _, known, _, counts = row
        return known + sum(self.costs[name] * count for name, count in counts.items())

    def error(self):
        """Root mean square, as a part of a frame."""
        return math.sqrt(statistics.mean(((self.fitted(row) - row[1]) / row[3]) ** 2 for row in self.rows))

    def say(self):
        names = sorted({row[0] for row in self.rows})
        print(f"{self.what}: {len(self.rows)} parts of frames in {len(names)} runs, off by {100 * self.error():.1f} % of a frame",
              file=sys.stderr)
        for name in names:
            rows = [row for row in self.rows if row[0] == name]
            spent, fitted = sum(row[1] for row in rows), sum(self.fitted(row) for row in rows)
            print(f"  {name:24} measured {1e3 * spent:9.2f} ms   fitted {1e3 * fitted:9.2f} ms   {fitted / spent:.2f}", file=sys.stderr)


def typical_roles(folder, name):
    """For each of a run's frames what its GPs and its Renderers did together, how many of either did something, with the seconds that are
    typical of all repetitions, and the seconds of all."""
    numbered = {}
    for frame in frames(folder, name):
        numbered.setdefault(frame["frame"], []).append(frame)
    for same in numbered.values():
        roles = []
        for role in ("GP", "Renderer"):
            busy = [[node for node in f["nodes"] if node["node"].startswith(role) and node["slices"] + node["payloads_drawn"] > 0] for f in same]
            # Counts hardly differ: news of opaque tiles come when they come.
            stats = {key: sum(node[key] for node in busy[0]) for key, value in same[0]["total"].items() if isinstance(value, int)}
            stats["nodes"] = len(busy[0])
            stats["seconds"] = {part: typical(sum(node["seconds"][part] for node in nodes) for nodes in busy) for part in same[0]["total"]["seconds"]}
            roles.append(stats)
        yield *roles, sum(seconds(stats, "computing", "drawing", "compositing", "delivering") for stats in roles)


def splat_costs(folder):
    """Drawing and compositing are timed apart, and views with wide kernels have more of both: fitted together, one would pay for the other."""
    fit = Fit("splats", ("splat", "slice drawn", "slice composited", "composite"))
    for name in runs(folder, "splats"):
        for _, renderers, whole in typical_roles(folder, name):
            payloads = renderers["payloads_drawn"]
            fit.add(name, seconds(renderers, "drawing"), 0, whole, splat=renderers["splats_drawn"] + renderers["splats_clipped"],
                    **{"slice drawn": payloads})
            fit.add(name, seconds(renderers, "compositing"), 0, whole, composite=renderers["samples"], **{"slice composited": payloads})
    costs = fit.solve()
    return {**costs, "slice": costs["slice drawn"] + costs["slice composited"]}, fit


def sheet_costs(folder, gp_slice, gp_frame):
    fit = Fit("sheets", ("look", "copy", "place", "slice", "sample", "table"))
    for name in runs(folder, "sheets"):
        # What a sample costs depends on what is seen: the head's is the machine's, others have one of their own.
        scene = name.split("-")[1]
        sample = "sample" if scene == "head" else "sample of " + scene
        for gps, renderers, whole in typical_roles(folder, name):
            fit.add(name, seconds(gps, "computing"), gp_frame * gps["nodes"] + gp_slice * gps["slices"], whole,
                    look=gps["blocks"], copy=gps["splats_sent"])
            fit.add(name, seconds(renderers, "drawing", "compositing"), 0, whole, table=renderers["nodes"], slice=renderers["payloads_drawn"],
                    look=renderers["blocks"], place=renderers["splats_drawn"], **{sample: renderers["samples"]})
    return fit.solve(), fit


def main():
    folder, cores = Path(sys.argv[1]), sys.argv[2]
    head, empty, tiny, line, hop = (frames(folder, name) for name in ("splats-head", "empty", "tiny", "line", "hop"))
    voxels = 128 * 128 * 124

    # What a frame costs whatever is in it: eight voxels.
    gp_frame = typical(f["total"]["seconds"]["computing"] for f in tiny)
    transparent = typical((f["total"]["seconds"]["computing"] - gp_frame) / voxels for f in empty)
    visible = typical((f["total"]["seconds"]["computing"] - gp_frame - transparent * (voxels - f["total"]["visible_voxels"]))
                      / f["total"]["visible_voxels"] for f in head)
    pixel = typical(f["total"]["seconds"]["delivering"] / (f["total"]["tile_bytes"] / 16) for f in head)
    slice_cost = typical((f["total"]["seconds"]["computing"] - gp_frame) / f["total"]["slices"] for f in line)
    # Each of the 4096 slices passes the token on, to the same rank: what is not encoding.
    token = typical((f["seconds"] - f["total"]["seconds"]["computing"]) / 4096 for f in line)
    # The same from rank to rank: both sides' software and the way between them, in equal parts.
    message = typical(f["seconds"] / 4096 - slice_cost - token for f in hop) / 3

    splats, splats_fit = splat_costs(folder)
    sheets, sheets_fit = sheet_costs(folder, slice_cost, gp_frame)
    for fit in (splats_fit, sheets_fit):
        fit.say()

    print(f'''# Measured by scripts/calibrate.sh on this machine: the head at 512x512 pixels on up to two ranks. Costs of Renderers and of sheets are
# fitted: they are off by {100 * splats_fit.error():.1f} % of a frame of splats, {100 * sheets_fit.error():.1f} % of one of sheets.
name = "Two cores"
# The program's bounded pieces of work.
poll_interval = 200e-6

[gp]
visible_voxel = {visible:.4g}
# Where slices without a visible voxel are left out, others' transparent voxels are in the cost of visible ones.
transparent_voxel = {transparent:.4g}
slice = {slice_cost:.4g}
frame = {gp_frame:.4g}
token = {token:.4g}

[renderer]
splat = {splats["splat"]:.4g}
slice = {splats["slice"]:.4g}
composite = {splats["composite"]:.4g}
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
