"""Neumann 1992, section 4, by the program on a simulated Pixel-Planes 5."""
import os
import statistics
import tempfile

from .output import plotting, print_head, print_row, write_csv, write_figure
from .run import nodes, parser, read_json
from .simulation import COUNTED, PAPER, PaperVolumes, simulate

GPS = [1, 2, 3, 4, 6, 8, 10, 12, 15, 20, 25, 30, 35, 40]
SIZES = {4: 256, 9: 384, 16: 512}


def frame(volume, gps, renderers, size, *options, **settings):
    return simulate({**PAPER, "gps": gps, "renderers": renderers, "size": f"{size}x{size}", **settings}, *volume, *COUNTED, *options)[0]


def published(words):
    """The figures that Neumann 1992, section 4, publishes, with the program on a simulated Pixel-Planes 5: ours, the paper's, their ratio."""
    parser(published.__doc__).parse_args(words)
    with tempfile.TemporaryDirectory() as folder:
        volumes = PaperVolumes(folder)
        one = frame(volumes.full, 20, 1, 128)
        four = frame(volumes.full, 20, 4, 256)
        head = frame(volumes.head, 10, 4, 256)
        half = frame(volumes.undersampled, 10, 4, 256)
    voxels = 128**3
    rows = [
        ("128³, all voxels, one Renderer's own work (computed)", "s", nodes(one, "Renderer")[0]["seconds"]["drawing"], 4.09),
        ("128³, all voxels, 20 GPs + 1 Renderer", "s", one["seconds"], 4.38),
        ("the same, throughput", "voxels/s", voxels / one["seconds"], 478e3),
        ("128³, all voxels, 20 GPs + 4 Renderers", "s", four["seconds"], 1.29),
        ("the same, throughput", "voxels/s", voxels / four["seconds"], 1.622e6),
        (f"head 128×128×124, {head['total']['visible_voxels']:,} visible voxels, 10 GPs + 4 Renderers", "Hz", 1 / head["seconds"], 0.93),
        (f"the same undersampled to 64×64×62, {half['total']['visible_voxels']:,} visible", "Hz", 1 / half["seconds"], 6.15),
    ]
    print_head("case", "ours", "paper", "ratio")
    for case, unit, ours, paper in rows:
        text = [f"{value:,.0f} {unit}" if value > 1000 else f"{value:.3g} {unit}" for value in (ours, paper)]
        print_row(case, *text, f"{ours / paper:.3f}")


def gp_scaling(words):
    """Figs. 7 and 9 of Neumann 1992: frame rate against GPs on a simulated Pixel-Planes 5. The head (a third of the voxels visible) and an
isosurface (11 %) with four, nine and sixteen Renderers, whose images have 256², 384² and 512² pixels. Takes some minutes."""
    arguments = parser(gp_scaling.__doc__)
    arguments.add_argument("-o", "--output", required=True, help="PNG")
    arguments.add_argument("--csv", help="also write the numbers")
    arguments.add_argument("--most-gps", type=int, default=GPS[-1])
    options = arguments.parse_args(words)
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        volumes = PaperVolumes(folder)
        for name, volume in {"head": volumes.head, "isosurface": volumes.isosurface}.items():
            for renderers in SIZES:
                of = [scaling_row(name, volume, gps, renderers) for gps in GPS if gps <= options.most_gps]
                print(name, renderers, "Renderers:", *(f"{r['gps']}:{r['hertz']:.2f}" for r in of), "Hz", flush=True)
                rows += of
    if options.csv:
        write_csv(options.csv, rows)
    write_figure(draw_scaling(plotting(), rows), options.output)


def scaling_row(name, volume, gps, renderers):
    shown = frame(volume, gps, renderers, SIZES[renderers])
    drawing = [n["seconds"]["drawing"] for n in nodes(shown, "Renderer")]
    return {"volume": name, "gps": gps, "renderers": renderers, "hertz": 1 / shown["seconds"],
            "gp_computing": statistics.mean(n["seconds"]["computing"] for n in nodes(shown, "GP")),
            "gp_waiting_for_token": statistics.mean(n["seconds"]["waiting_for_token"] for n in nodes(shown, "GP")),
            "renderer_drawing": statistics.mean(drawing), "renderer_drawing_most": max(drawing)}


def draw_scaling(plt, rows):
    titles = {"head": "Head, a third visible (Fig. 7)", "isosurface": "Isosurface, 11 % visible (Fig. 9)"}
    figure, panels = plt.subplots(1, 2, figsize=(10, 4), layout="constrained", sharex=True)
    for panel, (name, title) in zip(panels, titles.items()):
        for renderers, marker in zip(SIZES, "os^"):
            points = [(r["gps"], r["hertz"]) for r in rows if r["volume"] == name and r["renderers"] == renderers]
            panel.plot(*zip(*points), marker=marker, markersize=4, label=f"{renderers} Renderers, {SIZES[renderers]}² pixels")
        panel.set(title=title, xlabel="GPs", ylabel="frames per second", xlim=(0, 41), ylim=0)
        panel.grid()
        panel.legend()
    return figure


def first_tokens(words):
    """How long GPs wait for their first tokens (Neumann 1992, section 4.3): simulates a frame of the head on Pixel-Planes 5 and says from its
timeline how long GPs wait from their first slice being ready until its tokens come, in sum over all GPs."""
    arguments = parser(first_tokens.__doc__)
    arguments.add_argument("gps", nargs="?", type=int, default=30)
    arguments.add_argument("renderers", nargs="?", type=int, default=4)
    options = arguments.parse_args(words)
    gps, renderers = options.gps, options.renderers
    with tempfile.TemporaryDirectory() as folder:
        volumes = PaperVolumes(folder)
        for slots in (4, 1):
            trace = os.path.join(folder, "trace.json")
            shown = frame(volumes.head, gps, renderers, 256, "--trace", trace, slots=slots)
            first = first_slices(trace, gps)
            last_token = sum(max(0, max(times) - ready) for ready, times in first)
            each_token = sum(max(0, time - ready) for ready, times in first for time in times)
            without = sum(node["seconds"]["waiting_for_token"] for node in nodes(shown, "GP"))
            print(f"{gps} GPs + {renderers} Renderers, {slots} slots: a frame takes {shown['seconds']:.3f} s; first slices wait {last_token:.3f} s "
                  f"in sum for their last token, {each_token:.3f} s for each; all slices {without:.3f} s without any token")


def first_slices(trace, gps):
    """For each GP's first slice when it was ready and when each Renderer's token came, in seconds."""
    events = read_json(trace)["traceEvents"]
    ready, tokens = {}, {}
    for event in events:
        step = event.get("args", {}).get("step", gps)
        if step >= gps:
            continue
        if event["name"] == "slice" and event["ph"] == "X":
            ready[step] = (event["ts"] + event["dur"]) / 1e6
        elif event["name"] == "token" and event["ph"] == "f":
            tokens.setdefault(step, []).append(event["ts"] / 1e6)
    return [(ready[step], tokens[step]) for step in ready if step in tokens]
