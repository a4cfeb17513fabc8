"""Frame times that are predicted, simulated and real, beside each other."""
import json
import os
import tempfile

from .output import median, ms, print_head, print_row, write_csv
from .run import HEAD, MACHINES, PROGRAM, on_ranks, output_of, parser, program, read_frames, repeat
from .simulation import simulate

ORBIT = ("--tf", "mr-soft", "--size", "512x512", "--orbit", 8, "--elevation", 25)
VIEW = ("--tf", "mr-soft", "--size", "512x512", "--azimuth", 30, "--elevation", 25, "--fit", "sphere", "--shading", "none")
LAYOUTS = (
    [{"gps": g, "renderers": r} for g, r in ((1, 1), (2, 1), (1, 2), (2, 2), (3, 1), (4, 2), (3, 3), (6, 2), (4, 4), (8, 4), (12, 4))]
    + [{"gps": 2, "renderers": 2, "roles": "colocated"}]
    + [{"topology": "mesh", "mesh": f"{n}x{n}", "renderers": r} for n, r in ((2, 2), (3, 3), (4, 8))]
)
# Where nearly all work is the Renderers'.
SHEET_LAYOUTS = ([{"gps": n, "renderers": n, "roles": "colocated"} for n in (2, 3, 4, 6)]
                 + [{"gps": g, "renderers": r} for g, r in ((1, 1), (1, 2), (2, 2), (1, 3), (2, 4))])


def ranks_of(layout):
    gps = layout.get("gps") or int(layout["mesh"][0]) ** 2
    return max(gps, layout["renderers"]) if layout.get("roles") == "colocated" else gps + layout["renderers"]


def name_of(layout):
    gps = f"mesh {layout['mesh']}" if "mesh" in layout else str(layout["gps"])
    return f"{gps} + {layout['renderers']}" + (" colocated" if "roles" in layout else "")


def simulated(words):
    """Real runs on this machine beside simulated ones. MACHINE is what `scripts/study calibrate` wrote here. Median seconds of a frame of
the head at 512x512 pixels over an orbit of eight views without the first, which still allocates, one frame in flight, for layouts of 2
to 24 ranks."""
    arguments = parser(simulated.__doc__)
    arguments.add_argument("machine", metavar="MACHINE.toml")
    repeat(arguments, 5)
    arguments.add_argument("--csv", metavar="FILE")
    arguments.add_argument("--quality", default="paper", help="draft, normal and best draw sheets")
    arguments.add_argument("--most-ranks", type=int, default=24)
    options = arguments.parse_args(words)
    layouts = [layout for layout in (LAYOUTS if options.quality == "paper" else SHEET_LAYOUTS) if ranks_of(layout) <= options.most_ranks]
    real = [[] for _ in layouts]
    with tempfile.TemporaryDirectory() as folder:
        stats = os.path.join(folder, "real.json")
        for _ in range(options.repeat):
            for seconds, layout in zip(real, layouts):
                how = [word for key, value in layout.items() for word in (f"--{key}", value)]
                output_of(*on_ranks(ranks_of(layout), PROGRAM, "render", HEAD, *ORBIT, "--quality", options.quality, "--frames-in-flight", 1, *how,
                                    "--stats", stats))
                seconds += [frame["seconds"] for frame in read_frames(stats)[1:]]
    rows = []
    print_head("GPs + Renderers", "ranks", "real ms", "simulated ms", "simulated / real")
    for seconds, layout in zip(real, layouts):
        settings = {"quality": options.quality, "machine": os.path.abspath(options.machine), "frames-in-flight": 1, **layout}
        a, b = median(seconds), median(frame["seconds"] for frame in simulate(settings, HEAD, "--count-only", *ORBIT)[1:])
        rows.append({"layout": name_of(layout), "ranks": ranks_of(layout), "real_seconds": a, "simulated_seconds": b})
        print_row(name_of(layout), ranks_of(layout), ms(a), ms(b), f"{b / a:.2f}")
    print(f"\nMedian of simulated / real: {median(r['simulated_seconds'] / r['real_seconds'] for r in rows):.2f}")
    if options.csv:
        write_csv(options.csv, rows)


def predictions(volume, ranks, machine):
    return json.loads(program("info", *volume, "--ranks", ranks, "--machine", machine, "--json"))["prediction"]["layouts"]


def simulated_seconds(volume, layout, machine):
    if layout["topology"] == "mesh":
        columns, rows = layout["mesh"]
        how = {"topology": "mesh", "mesh": f"{columns}x{rows}", "renderers": layout["renderers"], "routing": "manhattan"}
    else:
        how = {key: layout[key] for key in ("gps", "renderers", "roles")}
    return simulate({"machine": os.path.abspath(machine), "frames-in-flight": 1, **how}, *volume, "--count-only")[0]["seconds"]


def predicted(words):
    """Predicted frame times beside simulated ones. For every split of the ranks into GPs and Renderers, all ranks colocated and every mesh:
what `ringsplat info --ranks N --machine FILE` says, and the frame simulated on that machine. The head at 512x512 pixels, one frame in
flight, by predicted time."""
    arguments = parser(predicted.__doc__)
    arguments.add_argument("ranks", nargs="?", type=int, default=16)
    arguments.add_argument("machine", nargs="?", default=str(MACHINES / "infiniband-fat-tree.toml"))
    arguments.add_argument("--choices", action="store_true",
                           help="six volumes and functions instead, with splats and sheets, on 16 and 64 ranks: what the program chooses beside "
                                "a handful of other layouts")
    options = arguments.parse_args(words)
    if options.choices:
        choices(options.machine)
        return
    print_head("layout", "predicted ms", "limit", "simulated ms", "simulated / predicted")
    both = []
    volume = [HEAD, *VIEW, "--quality", "paper"]
    for layout in predictions(volume, options.ranks, options.machine):
        seconds = simulated_seconds(volume, layout, options.machine)
        both.append((layout["seconds"], seconds, layout["layout"]))
        print_row(layout["layout"], ms(layout["seconds"], 2), layout["limit"], ms(seconds, 2), f"{seconds / layout['seconds']:.2f}")
    ratios = [seconds / said for said, seconds, _ in both]
    best = min(both, key=lambda b: b[1])
    print(f"\nSimulated / predicted: median {median(ratios):.2f}, from {min(ratios):.2f} to {max(ratios):.2f}. The fastest simulated is "
          f"{best[2]} with {ms(best[1], 2)} ms; the fastest predicted, {both[0][2]}, takes {both[0][1] / best[1]:.2f} times that.")


def six_volumes(folder):
    """Each as arguments, by a name."""
    def made(name, dims, kind="uint8"):
        path = os.path.join(folder, f"{name}.nrrd")
        program("synth", name, "-o", path, "--dims", dims, "--type", kind, "--no-compression")
        return path

    turned = ["--size", 512, "--azimuth", 30, "--elevation", 25, "--fit", "sphere"]
    return {"head, skin": [HEAD, "--tf", "mr-surface", *turned], "head, soft": [HEAD, "--tf", "mr-soft", *turned],
            "head, close": [HEAD, "--tf", "mr-soft", *turned, "--zoom", 3],
            "Marschner-Lobb, 128³": [made("marschner-lobb", "128x128x128", "float32"), "--tf", "auto", *turned],
            "ball, 256 x 192 x 64": [made("ball", "256x192x64"), "--tf", "grey", *turned],
            "shell, 64 x 64 x 512": [made("shell", "64x64x512"), "--tf", "auto", *turned]}


def handful(layouts, ranks):
    """The program's choice, then others: every rank both, and a quarter, a third, a half and three quarters of the ranks as GPs."""
    rings = [layout for layout in layouts if layout["topology"] != "mesh"]
    wanted = [layout for layout in rings if layout["roles"] == "colocated"][:2]
    dedicated = [layout for layout in rings if layout["roles"] != "colocated"]
    for share in (1 / 4, 1 / 3, 1 / 2, 3 / 4):
        wanted.append(min(dedicated, key=lambda layout: abs(layout["gps"] - share * ranks)))
    return [layouts[0]] + [layout for k, layout in enumerate(wanted) if layout is not layouts[0] and layout not in wanted[:k]]


def choices(machine):
    print_head("volume and function", "method", "ranks", "chosen", "predicted ms", "simulated ms", "fastest of others", "ms", "chosen / fastest")
    with tempfile.TemporaryDirectory() as folder:
        for name, volume in six_volumes(folder).items():
            for method, quality in (("splats", "paper"), ("sheets", "best")):
                for ranks in (16, 64):
                    there = [*volume, "--quality", quality]
                    layouts = handful(predictions(there, ranks, machine), ranks)
                    seconds = [simulated_seconds(there, layout, machine) for layout in layouts]
                    other = min(range(1, len(layouts)), key=lambda k: seconds[k])
                    print_row(name, method, ranks, layouts[0]["layout"], ms(layouts[0]["seconds"], 2), ms(seconds[0], 2),
                              layouts[other]["layout"], ms(seconds[other], 2), f"{seconds[0] / min(seconds):.2f}")
