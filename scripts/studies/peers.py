"""Other volume renderers beside ringsplat, on the same scene: `peers` on two ranks or cores, `paraview` on 1 to 6 ranks.

The repository's head, 512x512, orthographic, with the opacities of mr-soft (about 32 % of the voxels visible) and mr-surface (about 11 %)
in white, as VolPack's fast path is grey and programs differ in the space in which they mix colours. tests/peers has the programs that
draw with the others. Errors are against the field's truth,
at three views, one for each slice set; the truths take minutes and are kept in build/peers/truth.
"""
import contextlib
import hashlib
import json
import math
import os
import shutil
import subprocess
import time
from collections import defaultdict
from pathlib import Path

import numpy
from referees.files import read_exr

from .output import median, ms, plotting, print_head, print_row, read_csv, rms, write_csv, write_figure
from .run import AHEAD, COLOCATED, HEAD, REPO, Bench, fail, on_ranks, output_of, parser, program, repeat, say
from .volumes import Volume

PROGRAMS = REPO / "tests/peers"
KEPT = REPO / "build/peers"
VTK_PYTHON = KEPT / "venv/bin/python"
FUNCTIONS, SHADINGS = ("soft", "surface"), ("phong", "none")
VIEWS, TRUTH_VIEWS = 24, (0, 2, 8)
PARAVIEW_HINT = "apt-get install --no-install-recommends paraview python3-paraview xvfb xauth (90 MB to download, 630 MB installed)"
MIB = 1 << 20


def fade(voxels, width=3):
    """To 0 towards the lattice's ends: the neck is cut there, and programs differ in where the field ends."""
    faded = voxels.astype(float)
    for axis, n in enumerate(voxels.shape):
        ramp = numpy.minimum(1, numpy.minimum(numpy.arange(n), numpy.arange(n)[::-1]) / width)
        faded *= numpy.expand_dims(ramp, [a for a in range(3) if a != axis])
    return numpy.rint(faded).astype(numpy.uint8)


class Peers:
    """The scene in a folder, as every program takes it: head.raw (x fastest, axes along the world's), scene.json, views.txt (azimuth and
    elevation), and for each transfer function NAME.json for ringsplat and NAME.opacity, one number a value, for VolPack."""

    def __init__(self, bench, size, synth=None):
        self.bench, self.size = bench, size
        voxels, spacing = self.head() if synth is None else self.synthetic(*synth.split(":"))
        voxels.tofile(bench.path("head.raw"))
        dims = list(voxels.shape[::-1])
        self.dims, self.spacing = dims, spacing
        self.volume = (bench.path("head.raw"), "--dims", "x".join(map(str, dims)), "--type", "uint8", "--spacing", "x".join(map(str, spacing)))
        self.visible, functions = {}, {}
        for name in FUNCTIONS:
            functions[name], opacity = self.whiten(name)
            self.visible[name] = float((opacity[voxels] > 0).mean())
        bench.write("scene.json", json.dumps({"dims": dims, "spacing": spacing, "size": size, "functions": functions}))
        # Once around, up and down so steeply that all three slice sets are traversed.
        views = [f"{360.0 * k / VIEWS:.6f} {70 * math.sin(2 * math.pi * k / 8):.6f}\n" for k in range(VIEWS)]
        self.views = bench.write("views.txt", "".join(views))
        self.truth_views = bench.write("truth_views.txt", "".join(views[k] for k in TRUTH_VIEWS))

    @staticmethod
    def head():
        head = Volume(HEAD)
        steps = [step[k] for k, step in enumerate(head.directions)]
        voxels = fade(numpy.flip(head.voxels, [2 - k for k, step in enumerate(steps) if step < 0]))
        return voxels, [float(abs(step)) for step in steps]

    def synthetic(self, name, side):
        side = int(side)
        file = self.bench.path(f"synth_{side}x{side}x{side}_uint8.raw")
        program("synth", name, "--dims", side, "-o", file)
        return numpy.fromfile(file, numpy.uint8).reshape(side, side, side), [1.0] * 3

    def whiten(self, name):
        """The opacity's points, and a table of it."""
        file = self.bench.path(f"mr-{name}.json")
        program("render", HEAD, "--tf", f"mr-{name}", "--tf-out", file, "--quality", "paper", "--size", 16, "-o", self.bench.path("x.exr"))
        function = json.loads(file.read_text())[0]
        points = list(zip(function["Points"][::4], function["Points"][1::4]))
        function["RGBPoints"] = [c for end in (points[0][0], points[-1][0]) for c in (end, 1, 1, 1)]
        function["ColorSpace"] = "RGB"
        self.bench.write(f"{name}.json", json.dumps([function]))
        opacity = numpy.interp(numpy.arange(256), *zip(*points))
        self.bench.write(f"{name}.opacity", "\n".join(f"{o:.9g}" for o in opacity) + "\n")
        return points, opacity

    def make_truths(self, scenes):
        """Of (function, shading)s; kept as long as what they are made from is the same."""
        made_from = ("head.raw", "soft.json", "surface.json", "truth_views.txt")
        key = hashlib.sha256(b"".join(self.bench.path(name).read_bytes() for name in made_from) + bytes(str(self.size), "ascii")).hexdigest()[:16]
        self.truths = KEPT / "truth" / key
        self.truths.mkdir(parents=True, exist_ok=True)
        for function, shading in scenes:
            done = self.truths / f"{function}-{shading}.done"
            if done.exists():
                continue
            say(f"the field's truth: {function}, {shading}")
            program("reference", *self.volume, "--truth", "field", "--tolerance", "1e-4", "--path", self.truth_views, "--size", self.size,
                    "--tf", self.bench.path(f"{function}.json"), "--shading", shading, "-o", self.truths / f"{function}-{shading}.exr")
            done.touch()

    def ringsplat(self, ranks, function, shading, views, *options):
        return self.bench.run(ranks, *self.volume, *AHEAD, "--size", self.size, "--tf", self.bench.path(f"{function}.json"), "--shading", shading,
                              "--path", views, *options)

    def paraview(self, ranks, function, shading, mode, *prefix):
        """The frames' seconds. An X server that was slow to answer ends ParaView, so it gets further chances."""
        command = on_ranks(ranks, "pvbatch", "--sym", PROGRAMS / "paraview_frames.py", self.bench.folder, function, shading, mode, *prefix)
        for _ in range(2):
            ended = subprocess.run([str(word) for word in command], capture_output=True, text=True, env=SOFTWARE)
            if ended.returncode == 0:
                return floats(ended.stdout)
            say("ParaView failed and is tried again")
        return floats(output_of(*command, env=SOFTWARE))

    def error(self, stem, function, shading, numbers):
        """RMSE over red, green and blue of linear colour over black, in 1/255, at the truths' views, which are these of the pictures."""
        squares = []
        for k, number in enumerate(numbers):
            channels = compared(picture(stem, number), self.truths / f"{function}-{shading}-{k:04}.exr")["channels"]
            squares += [channels[c]["rmse"] for c in ("red", "green", "blue")]
        return rms(squares)


SOFTWARE = {**os.environ, "LIBGL_ALWAYS_SOFTWARE": "1"}


def floats(text):
    return [float(line) for line in text.split()]


def picture(stem, number):
    """A view's picture; the programs write their own formats."""
    return next(path for path in (Path(f"{stem}-{number:04}{kind}") for kind in (".exr", ".pfm")) if path.exists())


def compared(one, other):
    return json.loads(program("compare", one, other, "--threshold", 0, "--json"))


def has_paraview():
    return shutil.which("pvbatch") and shutil.which("Xvfb")


@contextlib.contextmanager
def display():
    """ParaView of Debian draws only where there is an X server; its own, so that no graphics card is used."""
    number = next(n for n in range(100, 200) if not Path(f"/tmp/.X11-unix/X{n}").exists() and not Path(f"/tmp/.X{n}-lock").exists())
    server = subprocess.Popen(["Xvfb", f":{number}", "-screen", "0", "1024x1024x24", "-nolisten", "tcp", "-noreset"],
                              stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        for _ in range(100):
            if Path(f"/tmp/.X11-unix/X{number}").exists():
                break
            time.sleep(0.1)
        SOFTWARE["DISPLAY"] = f":{number}"
        yield
    finally:
        server.kill()
        server.wait()


# peers: two ranks or cores

SETTINGS = {
    "best": ("ringsplat, sheets, best", (*COLOCATED, "--quality", "best")),
    "normal": ("ringsplat, sheets, normal", (*COLOCATED, "--quality", "normal")),
    "draft": ("ringsplat, sheets, draft", (*COLOCATED, "--quality", "draft")),
    "screen": ("ringsplat, splats", (*COLOCATED, "--quality", "paper")),
}
OTHERS = {"vtk": "VTK fixed-point, all cores", "vtk-gpu": "VTK GPU on Mesa's llvmpipe, all cores",
          "paraview": "ParaView, pvbatch on two ranks, llvmpipe", "volpack": "VolPack, one core"}


def prepare_vtk():
    if subprocess.run([VTK_PYTHON, "-c", "import vtk, numpy"], capture_output=True).returncode == 0 if VTK_PYTHON.exists() else False:
        return
    say(f"installing VTK into {VTK_PYTHON.parents[1]}")
    output_of("python3", "-m", "venv", VTK_PYTHON.parents[1])
    output_of(VTK_PYTHON, "-m", "pip", "install", "-q", "vtk>=9.4,<10", "numpy")


def other_programs(peers):
    """What is there of the others: {name: seconds(function, shading, *prefix)}."""
    def vtk(name):
        def frames(function, shading, *prefix):
            return floats(output_of(VTK_PYTHON, PROGRAMS / "vtk_frames.py", peers.bench.folder, function, shading, name, *prefix,
                                    env={key: value for key, value in SOFTWARE.items() if key != "DISPLAY"}))
        return frames

    def volpack(function, shading, *prefix):
        return floats(output_of(KEPT / "volpack_frames", peers.bench.folder, function, shading, *peers.dims, *peers.spacing, peers.size, *prefix[:1]))

    prepare_vtk()
    there = {"vtk": vtk("vtk")}
    if subprocess.run([VTK_PYTHON, PROGRAMS / "vtk_frames.py", peers.bench.folder, "soft", "none", "vtk-gpu"], capture_output=True).returncode == 0:
        there["vtk-gpu"] = vtk("vtk-gpu")
    else:
        say("VTK's GPU ray caster is left out: it does not run on Mesa's software rasteriser (apt-get install libegl1 libgl1-mesa-dri)")
    if has_paraview():
        there["paraview"] = lambda function, shading, *prefix: peers.paraview(2, function, shading, "smart", *prefix)
    else:
        say(f"ParaView is left out: {PARAVIEW_HINT}")
    compile_it = ["cc", "-std=gnu11", "-O3", "-march=native", PROGRAMS / "volpack_frames.c", "-o", KEPT / "volpack_frames", "-lvolpack", "-lm"]
    if subprocess.run(compile_it, capture_output=True).returncode == 0:
        there["volpack"] = volpack
    else:
        say("VolPack is left out: apt-get install libvolpack1-dev")
    return there


def main(words):
    """Time and error beside VTK's ray casters, VolPack and ParaView: Phong and unshaded, 24 views that traverse all three slice sets; ringsplat
with two colocated ranks, splats and sheets of all three qualities; of the head, or of an analytic volume. The programs take turns;
figures are medians over all frames of all rounds. Prints a table and draws it, the numbers are in build/peers/speed-error.csv. VTK comes from PyPI into build/peers (about 400 MB), VolPack from
libvolpack1-dev. VTK's GPU ray caster is measured where Mesa's software rasteriser is: libegl1 and libgl1-mesa-dri, or libosmesa6."""
    arguments = parser(main.__doc__)
    repeat(arguments, 3)
    arguments.add_argument("-o", "--output", default=KEPT / "speed-error.png", metavar="PNG")
    arguments.add_argument("--draw", action="store_true", help="only draws the numbers again")
    arguments.add_argument("--size", type=int, default=512)
    arguments.add_argument("--synth", metavar="NAME:SIDE", help="an analytic volume (ringsplat synth --list) instead of the head: gaussians:512")
    choose_scenes(arguments)
    arguments.add_argument("render_options", nargs="*", metavar="-- RENDER_OPTION", help="for all of ringsplat's runs")
    options = arguments.parse_args(words)
    KEPT.mkdir(parents=True, exist_ok=True)
    table = KEPT / "speed-error.csv"
    if not options.draw:
        with Bench() as bench, display() if has_paraview() else contextlib.nullcontext():
            write_csv(table, measure_peers(Peers(bench, options.size, options.synth), options))
    rows = read_csv(table)
    print_peers(rows)
    write_figure(draw(plotting(), rows), options.output)


def choose_scenes(arguments):
    arguments.add_argument("--functions", nargs="+", choices=FUNCTIONS, default=FUNCTIONS)
    arguments.add_argument("--shadings", nargs="+", choices=SHADINGS, default=SHADINGS)


def measure_peers(peers, options):
    others = other_programs(peers)
    rounds, more = options.repeat, options.render_options
    scenes = [(function, shading) for function in options.functions for shading in options.shadings]
    peers.make_truths(scenes)
    seconds = defaultdict(list)

    def stem(name, function, shading):
        return peers.bench.path(f"{name}-{function}-{shading}")

    for k in range(rounds):
        say(f"round {k + 1} of {rounds}")
        for function, shading in scenes:
            for name, (_, how) in SETTINGS.items():
                # One frame in flight: from the announcement to the finished picture, as the others' are from call to return.
                frames = peers.ringsplat(2, function, shading, peers.views, *how, *more, "--frames-in-flight", 1)
                seconds[name, function, shading] += [frame["seconds"] for frame in frames[1:]]
                if k == 0:
                    peers.ringsplat(2, function, shading, peers.truth_views, *how, *more, "-o", f"{stem(name, function, shading)}.exr")
            for name, draw_all in others.items():
                seconds[name, function, shading] += draw_all(function, shading, *([stem(name, function, shading)] if k == 0 else []))[1:]
    return [{"function": function, "visible": peers.visible[function], "shading": shading, "program": name,
             "seconds": median(seconds[name, function, shading]),
             "rmse": peers.error(stem(name, function, shading), function, shading, range(3) if name in SETTINGS else TRUTH_VIEWS)}
            for function, shading in scenes for name in [*SETTINGS, *others]]


def print_peers(rows):
    names = {name: text for name, (text, _) in SETTINGS.items()} | OTHERS
    vtk = {(row["function"], row["shading"]): float(row["seconds"]) for row in rows if row["program"] == "vtk"}
    print_head("transfer function", "shading", "program", "ms a frame", "times as fast as VTK", "RMSE, 1/255")
    for row in rows:
        seconds = float(row["seconds"])
        print_row(f"{row['function']}, {100 * float(row['visible']):.1f} %", row["shading"], names[row["program"]], ms(seconds),
                  f"{vtk[row['function'], row['shading']] / seconds:.2f}", f"{float(row['rmse']):.2f}")


# Okabe and Ito's colours, told apart by the colour-blind; shapes tell the families apart without colours.
FAMILIES = {  # colour, marker, line, and the programs in the line's order
    "sheets: draft, normal, best": ("#0072B2", "o", "-", ("draft", "normal", "best")),
    "splats (paper)": ("#009E73", "s", "none", ("screen",)),
    "VTK fixed-point": ("#D55E00", "^", "none", ("vtk",)), "VTK GPU on llvmpipe": ("#B8860B", "D", "none", ("vtk-gpu",)),
    "ParaView, 2 ranks": ("#56B4E9", "P", "none", ("paraview",)), "VolPack": ("#A5407D", "v", "none", ("volpack",)),
}


def draw(plt, rows):
    """A panel for each transfer function; points further left are faster, lower ones nearer to the field."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    functions = list(dict.fromkeys(row["function"] for row in rows))
    figure, panels = plt.subplots(1, len(functions), figsize=(5.4 * len(functions), 5.6), sharex=True, sharey=True, squeeze=False)
    panels = panels[0]
    for panel, function in zip(panels, functions):
        of = {(row["shading"], row["program"]): (1e3 * float(row["seconds"]), float(row["rmse"])) for row in rows if row["function"] == function}
        for name, (colour, marker, line, programs) in FAMILIES.items():
            for shading, face in (("phong", colour), ("none", "white")):
                points = [of[shading, p] for p in programs if (shading, p) in of]
                if points:
                    panel.plot(*zip(*points), color=colour, marker=marker, linestyle=line, markersize=8, markerfacecolor=face, markeredgewidth=1.5,
                               label=name if shading == "phong" else None)
        visible = next(100 * float(row["visible"]) for row in rows if row["function"] == function)
        panel.set(xscale="log", yscale="log", xlabel="milliseconds a frame", title=f"{function.capitalize()}: {visible:.0f} % of the voxels visible")
        panel.grid()
        for axis in (panel.xaxis, panel.yaxis):
            axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
            axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
            axis.set_minor_formatter(NullFormatter())
    panels[0].set_ylabel("RMSE against the field, 1/255")
    figure.legend(*panels[0].get_legend_handles_labels(), loc="lower center", ncols=3)
    figure.tight_layout(rect=(0, 0.1, 1, 0.97))
    figure.suptitle("Filled: Phong; open: unshaded. Lower left is better.", fontsize=10)
    return figure


# paraview: seams, memory and time by ranks

RANKS = (1, 2, 3, 4, 6)
RACERS = {"best": "ringsplat, sheets, best", "paper": "ringsplat, splats on the screen", "smart": "ParaView, GPU caster on llvmpipe",
          "ghosts": "ParaView, GPU caster, two ghost layers", "cast": "ParaView, fixed-point caster"}


def paraview(words):
    """Seams, memory, time and error beside ParaView, on 1, 2, 3, 4 and 6 ranks: pvbatch with IceT between its processes, with both of its ray
casters, and ringsplat's colocated ranks. The table has the pixels that differ from the same program's picture on one rank, and by how much
at most; the error against the field's truth; the median time of a frame; and the peak memory of the largest rank and of all. Numbers go
to build/peers/paraview.csv; with -o the pictures of the first view on 1 and 6 ranks, and how they differ, go to a picture."""
    arguments = parser(paraview.__doc__)
    repeat(arguments, 3)
    arguments.add_argument("-o", "--output", type=Path, metavar="FILE.png")
    choose_scenes(arguments)
    arguments.add_argument("--size", type=int, default=512)
    options = arguments.parse_args(words)
    if not has_paraview():
        fail(f"ParaView is missing: {PARAVIEW_HINT}")
    KEPT.mkdir(parents=True, exist_ok=True)
    with Bench() as bench, display():
        peers = Peers(bench, options.size)
        peers.make_truths([(function, shading) for function in options.functions for shading in options.shadings])
        # Three views for the errors, and three for more times; the first is drawn twice.
        lines = peers.views.read_text().splitlines(keepends=True)
        peers.views.write_text(peers.truth_views.read_text() + "".join(lines[k] for k in (4, 12, 20)))
        rows = measure_ranks(peers, options)
        if options.output:
            write_figure(seams_figure(peers, options.functions[0], options.shadings[0]), options.output)
    write_csv(KEPT / "paraview.csv", rows)
    print_head("transfer function", "shading", "program", "ranks", "pixels that differ from 1 rank's, %", "most, 1/255",
               "RMSE against the field, 1/255", "ms a frame", "MiB, largest rank", "MiB, all ranks")
    for r in rows:
        print_row(r["function"], r["shading"], RACERS[r["program"]], r["ranks"], f"{100 * r['differing']:.2f}", f"{r['largest']:.1f}",
                  f"{r['rmse']:.2f}", ms(r["seconds"]), f"{r['memory_most'] / MIB:.0f}", f"{r['memory_sum'] / MIB:.0f}")


def seams_figure(peers, function, shading):
    """ParaView's and ringsplat's first view on 1 and 6 ranks, and where these differ, made visible; where something is shown."""
    plt = plotting()
    figure, rows = plt.subplots(2, 3, figsize=(9, 6.6), facecolor="black")
    for (name, title), panels in zip({"smart": "ParaView", "best": "Ringsplat"}.items(), rows):
        stems = [stem_of(peers, function, shading, name, ranks) for ranks in (1, 6)]
        one, six = (colours_of(picture(stem, 0)) for stem in stems)
        differing = compared(*(picture(stem, 0) for stem in stems))["fraction_over"]
        shown = [slice(*places[[0, -1]]) for places in (numpy.flatnonzero(one.any(axis=(axis, 2))) for axis in (1, 0))]
        for panel, image, text in zip(panels, (one, six, 8 * abs(one - six)), (f"{title}, 1 rank", "6 ranks", f"difference × 8: {100 * differing:.1f} %")):
            panel.imshow(encoded(image[tuple(shown)]))
            panel.set_title(text, color="white", fontsize=10)
            panel.axis("off")
    figure.tight_layout()
    return figure


def colours_of(path):
    """Linear red, green and blue of a picture over black, the top row first."""
    if path.suffix == ".exr":
        return read_exr(path)[:, :, :3]
    head, size, scale, data = path.read_bytes().split(b"\n", 3)
    width, height = map(int, size.split())
    assert head == b"PF" and float(scale) < 0, f"{path} is no PFM as ParaView's driver writes it"
    return numpy.frombuffer(data, "<f4").reshape(height, width, 3)[::-1]


def encoded(linear):
    """sRGB."""
    part = linear.clip(0, 1)
    return numpy.where(part <= 0.0031308, 12.92 * part, 1.055 * part ** (1 / 2.4) - 0.055)


def measure_ranks(peers, options):
    seconds, memory = defaultdict(list), {}
    for k in range(options.repeat):
        for function in options.functions:
            for shading in options.shadings:
                say(f"round {k + 1} of {options.repeat}: {function}, {shading}")
                for ranks in RANKS:
                    for name in RACERS:
                        key = (function, shading, name, ranks)
                        times, memory[key] = race(peers, *key)
                        seconds[key] += times[1:]
    return [ranks_row(peers, seconds[function, shading, name, ranks], memory[function, shading, name, ranks], function, shading, name, ranks)
            for function in options.functions for shading in options.shadings for name in RACERS for ranks in RANKS]


def stem_of(peers, function, shading, name, ranks):
    return peers.bench.path(f"{name}-{function}-{shading}-{ranks}")


def race(peers, function, shading, name, ranks):
    """Seconds of the frames, and each rank's largest memory."""
    stem = stem_of(peers, function, shading, name, ranks)
    if name not in ("best", "paper"):
        for old in peers.bench.folder.glob(f"{stem.name}.memory.*"):
            old.unlink()
        times = peers.paraview(ranks, function, shading, name, stem)
        return times, [int(file.read_text()) for file in peers.bench.folder.glob(f"{stem.name}.memory.*")]
    frames = peers.ringsplat(ranks, function, shading, peers.views, "--roles", "colocated", "--gps", ranks, "--renderers", ranks, "--quality", name,
                             "--frames-in-flight", 1, "-o", f"{stem}.exr")
    gps = [node for node in frames[-1]["nodes"] if node["node"].startswith("GP")]
    return [frame["seconds"] for frame in frames], [node["peak_memory"] for node in gps]


def ranks_row(peers, seconds, memory, function, shading, name, ranks):
    stem, first = (stem_of(peers, function, shading, name, n) for n in (ranks, 1))
    seams = [compared(picture(stem, k), picture(first, k)) for k in range(len(TRUTH_VIEWS))]
    return {"function": function, "shading": shading, "program": name, "ranks": ranks,
            "differing": sum(s["fraction_over"] for s in seams) / len(seams), "largest": max(s["largest"] for s in seams),
            "rmse": peers.error(stem, function, shading, range(len(TRUTH_VIEWS))), "seconds": median(seconds),
            "memory_most": max(memory), "memory_sum": sum(memory)}
