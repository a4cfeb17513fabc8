"""The mesh: `mesh` measures it here, `links` draws what its links carried."""
import sys

from .output import ms, plotting, print_head, print_row, write_figure
from .run import HEAD, Bench, parser, read_frames, repeat

# As the program numbers them: columns and rows of GPs, Renderers.
SHAPES = {"2x2+4": 8, "3x3+3": 12, "4x4+4": 20, "4x4+8": 24}
QUEUES = {"2x2+4": 8, "3x3+6": 15, "4x4+4": 20, "4x4+8": 24}
ROUTINGS = ("direct", "manhattan")


def mesh(words):
    """Ring against mesh and manhattan against direct routing on 8 to 24 ranks, what a hop costs, and how often messages meet on a link."""
    arguments = parser(mesh.__doc__)
    repeat(arguments, 3)
    options = arguments.parse_args(words)
    view = (HEAD, "--elevation", 25, "--tf", "mr-soft", "--size", "256x256", "--region", 32)
    with Bench() as bench:
        empty = (*bench.make_line(2048), "--renderers", 1, "--orbit", 4, "--frames-in-flight", 1)
        for _ in range(options.repeat):
            for shape, ranks in SHAPES.items():
                gps, renderers = shape.split("+")
                orbit = (*view, "--orbit", 8, "--renderers", renderers)
                bench.render(ranks, f"frame-{shape}-ring", *orbit, "--gps", ranks - int(renderers))
                for routing in ROUTINGS:
                    bench.render(ranks, f"frame-{shape}-{routing}", *orbit, "--topology", "mesh", "--mesh", gps, "--routing", routing)
            for gps in ("2x2", "3x3", "4x4"):
                for routing in ROUTINGS:
                    bench.render(int(gps[0]) ** 2 + 1, f"hop-{gps}-{routing}", *empty, "--topology", "mesh", "--mesh", gps, "--routing", routing)
        # Counts, not times: once is enough.
        for shape, ranks in QUEUES.items():
            gps, renderers = shape.split("+")
            for slots in (1, 4):
                queue = (*view, "--fit", "sphere", "--topology", "mesh", "--mesh", gps, "--renderers", renderers, "--link-slots", slots)
                bench.render(ranks, f"queue-{shape}-{slots}", *queue)
        print_frames(bench)
        print_hops(bench)
        print_queues(bench)


def period(bench, name):
    """Median seconds from frame to frame, without each run's first two, which fill the pipe."""
    return bench.median(name, lambda f: f["period"], first=2)


def print_frames(bench):
    print_head("mesh", "ranks", "ring", "mesh, direct", "mesh, manhattan", "messages a frame", "over links", "MiB a frame", "over links")
    for shape, ranks in SHAPES.items():
        def typical(of):
            return bench.median(f"frame-{shape}-manhattan", of, first=0)

        # A payload is answered with an accept; besides there are tokens, frame ends, tiles and reports.
        sent = typical(lambda f: 2 * f["total"]["payloads_sent"] + f["total"]["tokens_passed"] + f["total"]["tokens_retired"]
                       + f["total"]["tiles"] + len(f["nodes"]))
        print_row(shape, ranks, *(ms(period(bench, f"frame-{shape}-{way}")) + " ms" for way in ("ring", *ROUTINGS)), f"{sent:.0f}",
                  f"{typical(lambda f: f['links_total']['messages']):.0f}", f"{typical(lambda f: f['total']['payload_bytes_sent']) / 2**20:.1f}",
                  f"{typical(lambda f: f['links_total']['payload_bytes']) / 2**20:.1f}")


def print_hops(bench):
    print()
    print_head("mesh, 2048 empty slices", *ROUTINGS, "tokens", "messages over links", "one more hop costs")
    for gps in ("2x2", "3x3", "4x4"):
        direct, manhattan = (period(bench, f"hop-{gps}-{routing}") for routing in ROUTINGS)
        tokens = bench.median(f"hop-{gps}-manhattan", lambda f: f["total"]["tokens_passed"], first=0)
        messages = bench.median(f"hop-{gps}-manhattan", lambda f: f["links_total"]["messages"], first=0)
        hop = 1e6 * (manhattan - direct) / (messages - tokens)
        print_row(gps, ms(direct) + " ms", ms(manhattan) + " ms", f"{tokens:.0f}", f"{messages:.0f}", f"{hop:.1f} µs")


def print_queues(bench):
    print()
    print_head("mesh", "slots a link", "messages over links", "met another", "waited for a slot", "in sum")
    for shape in QUEUES:
        for slots in (1, 4):
            links = bench.frames(f"queue-{shape}-{slots}", 0)[0]["links_total"]
            shares = [f"{100 * links[key] / links['messages']:.1f} %" for key in ("shared", "waited")]
            print_row(shape, slots, links["messages"], *shares, ms(links["wait_seconds"]) + " ms")


WHAT = {"bytes": "MiB", "payload_bytes": "MiB of splat messages", "messages": "messages", "payloads": "splat messages",
        "shared": "messages that met another one on the link", "waited": "messages that waited for a slot",
        "wait_seconds": "milliseconds waited"}
SCALE = {"bytes": 2.0**-20, "payload_bytes": 2.0**-20, "wait_seconds": 1e3}
STEP = {"W": (-1, 0), "E": (1, 0), "N": (0, -1), "S": (0, 1)}
SIDE = 0.17  # from the middle of a node to its rim
ASIDE = 0.07  # keeps the two directions of a link apart


def links(words):
    """A heat map of a mesh's links from what `ringsplat render ... --stats FILE` wrote. Every GP is a square, every Renderer a circle at
its row's end; every directed link is an arrow, as dark as it was busy. In a mesh that wraps, the links between the bottom
and the top row leave the picture."""
    arguments = parser(links.__doc__)
    arguments.add_argument("stats", help="written by ringsplat render --stats")
    arguments.add_argument("-o", "--output", required=True, help="PNG")
    arguments.add_argument("--frame", type=int, default=0)
    arguments.add_argument("--what", choices=WHAT, default="bytes")
    options = arguments.parse_args(words)
    frame = next((f for f in read_frames(options.stats) if f.get("frame") == options.frame), None)
    if frame is None:
        sys.exit(f"ringsplat: {options.stats} has no frame {options.frame}")
    if "links" not in frame:
        sys.exit(f"ringsplat: {options.stats} has no links; hint: render with --topology mesh and --routing manhattan")
    write_figure(draw_links(plotting(), frame, options.what), options.output)


def place(rank, layout):
    """Column and row of a rank; Renderers stand one column beyond the edge."""
    columns, rows = layout["mesh"]
    if rank < layout["gps"]:
        return rank % columns, rank // columns
    renderer = rank - layout["gps"]
    return (-1, renderer) if renderer < rows else (columns, renderer - rows)


def draw_links(plt, frame, what):
    layout = frame["layout"]
    columns, rows = layout["mesh"]
    figure, axes = plt.subplots(figsize=(1.3 * (columns + 2) + 2.6, 1.3 * (rows + 1) + 0.9), layout="constrained")
    begins, ways, values = [], [], [link[what] * SCALE.get(what, 1) for link in frame["links"]]
    for link in frame["links"]:
        (x, y), (dx, dy) = place(link["from"], layout), STEP[link["link"][-1]]
        begins.append((x + dx * SIDE - dy * ASIDE, y + dy * SIDE + dx * ASIDE))
        ways.append((dx * (1 - 2 * SIDE), dy * (1 - 2 * SIDE)))
    colours = plt.get_cmap("viridis_r").with_extremes(under="0.85")
    arrows = axes.quiver(*zip(*begins), *zip(*ways), values, cmap=colours, norm=plt.Normalize(1e-9, max(values) or 1), angles="xy",
                         scale_units="xy", scale=1, width=0.05, units="xy")
    for rank in range(layout["ranks"]):
        x, y = place(rank, layout)
        gp = rank < layout["gps"]
        axes.plot(x, y, "s" if gp else "o", markersize=22, color="white", markeredgecolor="0.3", zorder=3)
        axes.text(x, y, str(rank) if gp else f"R{rank - layout['gps']}", ha="center", va="center", fontsize=9, zorder=4)
    axes.set(xlim=(-1.5, columns + 0.5), ylim=(rows - 0.1, -0.9), aspect="equal")
    axes.set_axis_off()
    axes.set_title(f"{columns}×{rows} GPs, {layout['renderers']} Renderers, frame {frame['frame']}", fontsize=11)
    figure.colorbar(arrows, ax=axes, label=WHAT[what], shrink=0.8)
    return figure
