"""Measures what nodes spend on this machine and writes it as a machine to simulate.

GPs' costs are of one GP and one Renderer on a core each: the repository's head, a volume without a visible voxel, one of eight voxels, and
tokens through 4096 empty slices, on one rank and between two. Renderers' costs, and all of sheets, are fitted to runs that differ in what
is seen and in the number of Renderers. It takes the medians of all repetitions and says how far the fitted costs are off. What waiting
costs ranks that share cores is found by simulating. Nothing else should run.
"""
import itertools
import math
import os
import re
import shutil
import statistics
import tempfile
from pathlib import Path

import numpy

from .output import median, whole_file
from .run import COLOCATED, DEDICATED, HEAD, Bench, output_of, parser, program, read_frames, repeat, say, shell

ORBIT = ("--orbit", 8, "--elevation", 25)
SOFT = (HEAD, "--tf", "mr-soft", *ORBIT)
# More ranks than cores: GPs and Renderers. `scripts/study compare-simulated` times others.
SHARED = ((2, 3), (3, 2), (5, 2))
LONGEST_WAIT = 2e-3


def main(words):
    arguments = parser(__doc__)
    arguments.add_argument("output", metavar="MACHINE.toml")
    repeat(arguments, 5)
    arguments.add_argument("--keep", metavar="FOLDER", help="keeps the statistics")
    options = arguments.parse_args(words)
    with Bench() as bench:
        made = make_inputs(bench)
        for k in range(options.repeat):
            say(f"round {k + 1} of {options.repeat}")
            measure(bench, *made)
        if options.keep:
            os.makedirs(options.keep, exist_ok=True)
            for file in bench.folder.glob("*.jsonl"):
                shutil.copy(file, options.keep)
        runs = Runs(bench.folder)
        machine = with_waiting(runs, machine_of(runs, output_of(*shell("cores")).strip()))
    with whole_file(options.output) as beside:
        Path(beside).write_text(machine)
    say(f"{options.output} describes this machine")


def make_inputs(bench):
    """A function that shows nothing, the options of a line, and volumes by name."""
    volumes = {}
    for name, kind, dims in (("tiny", "constant", "2x2x2"), ("wide", "ball", "512x512x32"), ("shell", "shell", "512x512x32"),
                             ("hollow", "shell", "128x128x128"), ("long", "ball", "16x16x4096")):
        volumes[name] = bench.path(name + ".nrrd")
        program("synth", kind, "-o", volumes[name], "--dims", dims)
    return bench.transfer_function("nothing", (0, 0), (255, 0)), bench.make_line(4096), volumes


def measure(bench, nothing, line, volumes):
    in_flight = ("--frames-in-flight", 1)
    one, two = (*DEDICATED, *in_flight), (*COLOCATED, *in_flight)
    four, many = (("--gps", 1, "--renderers", n, *in_flight) for n in (4, 16))
    size, hollow = ("--size", 512), (volumes["hollow"], "--tf", "grey", *ORBIT)
    bench.render(2, "empty", HEAD, *one, "--tf", nothing, *size, *ORBIT)
    bench.render(2, "tiny", volumes["tiny"], *one, "--tf", "grey", *size, "--orbit", 5)
    bench.render(2, "line", *line, *one, "--orbit", 5)
    bench.render(2, "hop", *line, "--gps", 2, "--renderers", 1, "--roles", "colocated", *in_flight, "--orbit", 5)

    bench.render(2, "splats-head", *SOFT, *one, *size)
    bench.render(2, "splats-head-two", *SOFT, *two, *size)
    bench.render(0, "splats-head-four", *SOFT, *four, *size)
    bench.render(0, "splats-head-many", *SOFT, *many, *size)
    bench.render(2, "splats-hollow", *hollow, *one, *size)
    bench.render(0, "splats-hollow-many", *hollow, *many, *size)
    for gps, renderers in SHARED:
        bench.render(gps + renderers, f"shared-{gps}-{renderers}", *SOFT, "--gps", gps, "--renderers", renderers, *in_flight, *size)

    half, tiny = ("--clip", "0:127,0:127,0:61"), ("--clip", "60:64,60:64,60:64")
    flat = (*one, "--tf", "grey", "--size", 128, "--orbit", 3, "--elevation", 85)
    for ranks, name, options in ((2, "head", one), (2, "head-two", two), (2, "head-half", (*one, *half)), (2, "head-half-two", (*two, *half)),
                                 (2, "head-tiny", (*one, *tiny)), (0, "head-four", four)):
        bench.render(ranks, "sheets-" + name, *SOFT, *options, *size, quality="best")
    for name in ("wide", "shell", "long"):
        bench.render(2, "sheets-" + name, volumes[name], *flat, quality="best")


class Runs:
    """The statistics in a folder."""

    def __init__(self, folder):
        self.folder = Path(folder)

    def frames(self, name):
        """Without each run's first, which still allocates."""
        return [frame for frame in read_frames(self.folder / f"{name}.jsonl") if frame["frame"] > 0]

    def names(self, kind):
        """A kind's runs: KIND-SCENE, or KIND-SCENE-VARIANT."""
        return sorted(file.stem for file in self.folder.glob(kind + "-*.jsonl"))


def typical(values):
    """What real frames are compared by as well: the least of many would be of a machine without disturbances."""
    return max(0.0, median(values))


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
        say(f"{self.what}: {len(self.rows)} parts of frames in {len(names)} runs, off by {100 * self.error():.1f} % of a frame")
        for name in names:
            rows = [row for row in self.rows if row[0] == name]
            spent, fitted = sum(row[1] for row in rows), sum(self.fitted(row) for row in rows)
            say(f"  {name:24} measured {1e3 * spent:9.2f} ms   fitted {1e3 * fitted:9.2f} ms   {fitted / spent:.2f}")


def typical_roles(runs, name):
    """For each of a run's frames what its GPs and its Renderers did together, how many of either did something, with the seconds that are
    typical of all repetitions, and the seconds of all."""
    numbered = {}
    for frame in runs.frames(name):
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


def splat_costs(runs):
    """Drawing and compositing are timed apart, and views with wide kernels have more of both: fitted together, one would pay for the other."""
    fit = Fit("splats", ("splat", "slice drawn", "slice composited", "composite"))
    for name in runs.names("splats"):
        for _, renderers, whole in typical_roles(runs, name):
            payloads = renderers["payloads_drawn"]
            fit.add(name, seconds(renderers, "drawing"), 0, whole, splat=renderers["splats_drawn"] + renderers["splats_clipped"],
                    **{"slice drawn": payloads})
            fit.add(name, seconds(renderers, "compositing"), 0, whole, composite=renderers["samples"], **{"slice composited": payloads})
    costs = fit.solve()
    return {**costs, "slice": costs["slice drawn"] + costs["slice composited"]}, fit


def sheet_costs(runs, gp_slice, gp_frame):
    fit = Fit("sheets", ("look", "copy", "place", "slice", "sample", "table"))
    for name in runs.names("sheets"):
        # What a sample costs depends on what is seen: the head's is the machine's, others have one of their own.
        scene = name.split("-")[1]
        sample = "sample" if scene == "head" else "sample of " + scene
        for gps, renderers, whole in typical_roles(runs, name):
            fit.add(name, seconds(gps, "computing"), gp_frame * gps["nodes"] + gp_slice * gps["slices"], whole,
                    look=gps["blocks"], copy=gps["splats_sent"])
            fit.add(name, seconds(renderers, "drawing", "compositing"), 0, whole, table=renderers["nodes"], slice=renderers["payloads_drawn"],
                    look=renderers["blocks"], place=renderers["splats_drawn"], **{sample: renderers["samples"]})
    return fit.solve(), fit


def machine_of(runs, cores):
    """The machine's description, as TOML, but for what waiting costs."""
    head, empty, tiny, line, hop = (runs.frames(name) for name in ("splats-head", "empty", "tiny", "line", "hop"))
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

    splats, splats_fit = splat_costs(runs)
    sheets, sheets_fit = sheet_costs(runs, slice_cost, gp_frame)
    for fit in (splats_fit, sheets_fit):
        fit.say()

    described = {
        "gp": {"visible_voxel": visible, "transparent_voxel": transparent, "slice": slice_cost, "frame": gp_frame, "token": token},
        "renderer": {**{name: splats[name] for name in ("splat", "slice", "composite")}, "pixel": pixel},
        "sheets": {name: sheets[name] for name in ("look", "copy", "place", "slice", "sample", "table")},
        # From what a token takes between two ranks on cores of their own.
        "message": {"send": message, "receive": message},
    }
    rooms = "".join(f"\n[{room}]\n" + "".join(f"{name} = {cost:.4g}\n" for name, cost in costs.items()) for room, costs in described.items())
    return f'''# Measured by scripts/study calibrate on this machine: the head at 512x512 pixels on up to two ranks. Costs of Renderers and of sheets are
# fitted: they are off by {100 * splats_fit.error():.1f} % of a frame of splats, {100 * sheets_fit.error():.1f} % of one of sheets. Where slices without a visible
# voxel are left out, others' transparent voxels are in the cost of visible ones.
name = "Two cores"
# The program's bounded pieces of work.
poll_interval = 200e-6
{rooms}
[platform]
# All ranks share the cores of one host; messages go through its memory.
kind = "backbone"
bandwidth = 1e10
latency = {message:.4g}
local_bandwidth = 4e9
local_latency = {message:.4g}
hosts = 1
cores = {cores}
'''


def with_wake(machine, wake):
    return re.sub(r"(?m)^(receive = .*)$", rf"\1\nwake = {wake:.3g}", machine, count=1)


def with_waiting(runs, machine):
    """The machine with what waiting costs ranks that share cores: such that frames of more ranks than cores take as long simulated, in the
    median of their layouts."""
    from .simulation import simulate

    real = {layout: median(f["seconds"] for f in runs.frames("shared-{}-{}".format(*layout))) for layout in SHARED}

    def ratio(wake):
        """Of simulated to real."""
        with tempfile.TemporaryDirectory() as work:
            described = os.path.join(work, "machine.toml")
            Path(described).write_text(with_wake(machine, wake))
            return median(
                median(f["seconds"] for f in simulate({"machine": described, "frames-in-flight": 1, "gps": gps, "renderers": renderers}, *SOFT,
                                                      "--size", "512x512", "--count-only")[1:]) / taken
                for (gps, renderers), taken in real.items())

    wake, low, high = 0.0, 0.0, 20e-6
    if ratio(0) < 1:
        while ratio(high) < 1 and high < LONGEST_WAIT:
            low, high = high, 2 * high
        for _ in range(5):
            wake = 0.5 * (low + high)
            low, high = (wake, high) if ratio(wake) < 1 else (low, wake)
    say(f"ranks that wait on shared cores: {1e6 * wake:.0f} µs")
    return with_wake(machine, wake)


def non_negative(rows, targets):
    """The x >= 0 with the least sum of (row x - target)². Few unknowns only: it tries each choice of those that are zero."""
    matrix, right = numpy.array(rows, float), numpy.array(targets, float)
    # Columns of length one, so that units do not matter.
    lengths = numpy.linalg.norm(matrix, axis=0)
    lengths[lengths == 0] = 1
    best, least = numpy.zeros(len(lengths)), right @ right
    for count in range(1, len(lengths) + 1):
        for chosen in map(list, itertools.combinations(range(len(lengths)), count)):
            part = matrix[:, chosen] / lengths[chosen]
            x, _, rank, _ = numpy.linalg.lstsq(part, right, rcond=None)
            remainder = ((part @ x - right) ** 2).sum()
            if rank == count and x.min() >= 0 and remainder < least:
                least, best = remainder, numpy.zeros(len(lengths))
                best[chosen] = x / lengths[chosen]
    return best.tolist()
