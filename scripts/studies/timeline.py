"""Timelines of frames, from what `ringsplat render --trace` wrote, drawn as Figs. 5 and 8 of Neumann 1992. Times are milliseconds."""
import os
import tempfile
from collections import defaultdict
from pathlib import Path
from typing import NamedTuple

from .output import plotting, write_figure
from .run import PROGRAM, REPO, fail, on_ranks, output_of, parser, program, read_json, say

WAITING = ("wait for token", "send")
WORK = {"GP": ("slice",), "Renderer": ("draw", "composite", "deliver")}


class Span(NamedTuple):
    name: str
    begin: float
    end: float
    busy: float
    frame: int
    step: int  # -1: not of one slice


class Flow(NamedTuple):
    """A token from GP to GP, or a payload from GP to Renderer."""

    kind: str
    frame: int
    step: int
    renderer: int
    source: str
    left: float
    destination: str
    arrived: float


class Timeline:
    """nodes: names, GPs first. spans: node -> its spans in order. frames: number -> (begin, end)."""

    def __init__(self, trace):
        rows = {e["tid"]: e["args"]["name"] for e in trace["traceEvents"] if e["ph"] == "M" and e["name"] == "thread_name"}
        self.nodes = [n for n in rows.values() if n != "frame buffer"]
        self.spans = defaultdict(list)
        self.frames = {}
        ends = defaultdict(dict)
        for e in trace["traceEvents"]:
            if e["ph"] == "M":
                continue
            arguments, time = e["args"], e["ts"] / 1e3
            if e["ph"] == "X":
                busy = arguments.get("busy_us", e["dur"]) / 1e3
                span = Span(e["name"], time, time + e["dur"] / 1e3, busy, arguments["frame"], arguments.get("step", -1))
                self.spans[rows[e["tid"]]].append(span)
            elif e["ph"] in "be":
                begin, end = self.frames.get(e["id"], (time, time))
                self.frames[e["id"]] = (min(begin, time), max(end, time))
            elif e["ph"] in "sf":
                ends[e["id"]][e["ph"]] = (rows[e["tid"]], time, e["cat"], arguments)
        self.flows = []
        for both in ends.values():
            (source, left, kind, a), (destination, arrived, _, _) = both["s"], both["f"]
            self.flows.append(Flow(kind, a["frame"], a["step"], a["renderer"], source, left, destination, arrived))

    def choose_frame(self, name):
        """The number of the frame called so, or None."""
        if name == "fastest":
            return min(self.frames, key=lambda f: self.frames[f][1] - self.frames[f][0])
        number = max(self.frames) if name == "last" else int(name) if name.isdecimal() else None
        return number if number in self.frames else None

    def work(self, node):
        names = WORK["GP" if node.startswith("GP") else "Renderer"]
        return [s for s in self.spans[node] if s.name in names]


COLOUR = {"slice": "#e9a466", "draw": "#7fa8d1", "composite": "#3f6fa8", "deliver": "#274b75"}
WAIT = {"wait for token": ("0.93", "////", "waits for a token"), "send": ("0.93", "....", "waits to be accepted")}
IDLE = ("#f7f2c8", "\\\\\\\\", "Renderer without work")
BETWEEN = "0.82"  # pieces of one slice: the rank had no core, or did something else
TOKEN = ["#b3202c", "#1d7f4f", "#6a3d9a", "#00808a", "#8c6d00", "#444444"]
HALF = 0.3  # of a bar's height
NUMBER = {"boxstyle": "round,pad=0.12", "facecolor": "white", "edgecolor": "none", "alpha": 0.75}
MANY = 24  # steps from which numbers no longer fit


def bar(axes, y, begin, end, colour, **more):
    axes.barh(y, end - begin, left=begin, height=2 * HALF, color=colour, linewidth=0, **more)


def shade(axes, y, begin, end, style):
    colour, hatch, _ = style
    axes.barh(y, end - begin, left=begin, height=2 * HALF, color=colour, hatch=hatch, edgecolor="0.65", linewidth=0)


def extents(spans, names):
    """(step, begin, end) of each slice at a node, from its first piece to its last."""
    for step in sorted({s.step for s in spans if s.name in names and s.step >= 0}):
        pieces = [s for s in spans if s.name in names and s.step == step]
        yield step, pieces[0].begin, max(s.end for s in pieces)


def draw_slices(axes, y, spans, names, numbered):
    slices = list(extents(spans, names))
    for _, begin, end in slices:
        bar(axes, y, begin, end, BETWEEN)
    for span in spans:
        if span.name in COLOUR:
            bar(axes, y, span.begin, span.end, COLOUR[span.name])
    for step, begin, end in slices:
        axes.barh(y, end - begin, left=begin, height=2 * HALF, color="none", edgecolor="0.25", linewidth=0.6, zorder=3)
        if numbered:
            axes.text((begin + end) / 2, y, step, ha="center", va="center", fontsize=9, zorder=4, bbox=NUMBER)


def draw_gp(axes, y, spans, numbered):
    for span in spans:
        if span.name in WAIT:
            shade(axes, y, span.begin, span.end, WAIT[span.name])
    draw_slices(axes, y, spans, ("slice",), numbered)


def draw_renderer(axes, y, spans, begin, numbered):
    last = begin
    for busy_from, busy_to in sorted([e[1:] for e in extents(spans, ("draw", "composite"))] + [(s.begin, s.end) for s in spans if s.name == "deliver"]):
        if busy_from > last:
            shade(axes, y, last, busy_from, IDLE)
        last = max(last, busy_to)
    draw_slices(axes, y, spans, ("draw", "composite"), numbered)


def arrow(axes, flow, rows, colour, bend, width):
    """From the edge of the one row's bar to that of the other; a token that stays at its GP needs no arc."""
    start, end = rows[flow.source], rows[flow.destination]
    if start == end:
        return
    side = HALF if start < end else -HALF
    style = {"arrowstyle": "-|>", "connectionstyle": f"arc3,rad={bend if start < end else -bend}", "shrinkA": 0, "shrinkB": 0,
             "mutation_scale": 9, "color": colour, "linewidth": width}
    axes.annotate("", (flow.arrived, end - side), (flow.left, start + side), arrowprops=style, zorder=5)


def draw_tokens(axes, flows, rows, numbered, width_ms):
    moving = [f for f in flows if rows[f.source] != rows[f.destination]]
    for flow in moving:
        colour = TOKEN[flow.renderer % len(TOKEN)]
        arrow(axes, flow, rows, colour, 0.12 + 0.1 * flow.renderer, 1.2 if numbered else 0.6)
    if not numbered:
        return
    # Tokens that leave a GP one right after the other stand beside each other.
    taken = {}
    for flow in sorted(moving, key=lambda f: f.left):
        x = max(flow.left + 0.006 * width_ms, taken.get(flow.source, 0))
        taken[flow.source] = x + 0.02 * width_ms
        y = rows[flow.source] + (0.4 if rows[flow.source] < rows[flow.destination] else -0.4)
        axes.text(x, y, f"T{flow.renderer}", color=TOKEN[flow.renderer % len(TOKEN)], fontsize=8, va="center", zorder=6)


def draw(plt, timeline, frame, title, payloads):
    from matplotlib.ticker import MaxNLocator

    begin, end = timeline.frames[frame]
    rows = {node: y for y, node in enumerate(timeline.nodes)}
    spans = {node: [s for s in timeline.spans[node] if s.frame == frame] for node in rows}
    numbered = len({s.step for all_ in spans.values() for s in all_}) <= MANY
    figure, axes = plt.subplots(figsize=(11, 0.75 * len(rows) + 1.6), layout="constrained")
    for node, y in rows.items():
        if node.startswith("GP"):
            draw_gp(axes, y, spans[node], numbered)
        else:
            draw_renderer(axes, y, spans[node], begin, numbered)
    flows = [f for f in timeline.flows if f.frame == frame]
    draw_tokens(axes, [f for f in flows if f.kind == "token"], rows, numbered, end - begin)
    if payloads:
        for flow in (f for f in flows if f.kind == "payload"):
            arrow(axes, flow, rows, "0.45", 0.0, 0.6)
    axes.set_yticks(list(rows.values()), list(rows))
    axes.set_ylim(len(rows) - 0.4, -0.6)
    axes.set_xlim(begin, end)
    ticks = [t for t in MaxNLocator(10).tick_values(0, end - begin) if 0 <= t <= end - begin]
    axes.set_xticks([begin + t for t in ticks], [f"{t:g}" for t in ticks])
    axes.set_xlabel("milliseconds since the frame was announced")
    axes.spines[["top", "right", "left"]].set_visible(False)
    axes.tick_params(axis="y", length=0)
    axes.set_title(title or f"Frame {frame}", fontsize=11, loc="left")
    add_legend(plt, axes, sum(n.startswith("Renderer") for n in rows))
    return figure


def add_legend(plt, axes, renderers):
    from matplotlib.patches import Patch

    entries = [Patch(color=COLOUR[name], label=name) for name in COLOUR]
    entries.append(Patch(color=BETWEEN, label="between a slice's pieces"))
    for colour, hatch, label in [*WAIT.values(), IDLE]:
        entries.append(Patch(facecolor=colour, hatch=hatch, edgecolor="0.65", label=label))
    for renderer in range(min(renderers, len(TOKEN))):
        entries.append(plt.Line2D([], [], color=TOKEN[renderer], label=f"T{renderer}: token of Renderer {renderer}"))
    axes.legend(handles=entries, loc="upper center", bbox_to_anchor=(0.5, -0.62 / axes.get_ylim()[0]), ncols=6, fontsize=8, frameon=False)


def is_trace(document):
    return isinstance(document, dict) and "traceEvents" in document


def main(words):
    """Draws a frame's timeline from what `ringsplat render ... --trace FILE` wrote, as Figs. 5 and 8 of Neumann 1992 do. GPs and Renderers are
rows. A GP's bar is one slice, a Renderer's one payload. Waiting is
shaded. Arcs are tokens, one colour for each Renderer."""
    arguments = parser(main.__doc__)
    arguments.add_argument("trace", help="written by ringsplat render --trace")
    arguments.add_argument("-o", "--output", required=True, help="PNG")
    arguments.add_argument("--frame", default="last", help="a number, 'last' or 'fastest'")
    arguments.add_argument("--title", help="instead of the frame's number")
    arguments.add_argument("--payloads", action="store_true", help="arrows from GPs to Renderers too")
    options = arguments.parse_args(words)
    document = read_json(options.trace)
    if not is_trace(document):
        fail(f"{options.trace} is no trace: make one with ringsplat render --trace")
    timeline = Timeline(document)
    frame = timeline.choose_frame(options.frame) if timeline.frames else None
    if frame is None:
        fail(f"{options.trace} has no frame {options.frame}; complete ones: {', '.join(map(str, sorted(timeline.frames))) or 'none'}")
    write_figure(draw(plotting(), timeline, frame, options.title, options.payloads), options.output)


def figures_of_the_paper(words):
    """Figs. 5 and 8 of Neumann 1992 from this machine's own runs: FOLDER/timeline-*.png and balance-*.png. Three GPs, two Renderers and six
slices. GP-bound: large slices, a small picture. Renderer-bound: small slices, a large picture and wide kernels, and a Renderer takes one
payload ahead. Each is rendered 40 times, as five ranks share the machine with everything else; the fastest frame is drawn."""
    from . import balance

    arguments = parser(figures_of_the_paper.__doc__)
    arguments.add_argument("folder", nargs="?", default=REPO / "docs/measured", metavar="FOLDER")
    arguments.add_argument("--frames", type=int, default=40)
    options = arguments.parse_args(words)
    # Ranks that work keep their core; those that wait sleep in any case.
    os.environ["OMPI_MCA_mpi_yield_when_idle"] = "0"
    cases = {
        "gp-bound": ("GP-bound: Renderers wait for slices (as in Fig. 5)", 1, "768x6x768", "1x64x1", ("--size", 256)),
        "renderer-bound": ("Renderer-bound: GPs wait for Renderers (as in Fig. 8)", 1.3, "192x6x192", "1x16x1",
                           ("--size", 1024, "--radius", 2.4, "--slots", 2)),
    }
    with tempfile.TemporaryDirectory() as work:
        volume, views, trace, picture = (Path(work, name) for name in ("ball.nrrd", "views", "trace.json", "picture.exr"))
        for name, (title, zoom, dims, spacing, how) in cases.items():
            program("synth", "ball", "--dims", dims, "--spacing", spacing, "-o", volume)
            views.write_text(f"20 15 0 {zoom}\n" * options.frames)
            output_of(*on_ranks(5, PROGRAM, "render", "--quality", "paper", volume, *how, "--gps", 3, "--renderers", 2, "--path", views,
                                "--tf", "grey", "--frames-in-flight", 1, "-o", picture, "--trace", trace))
            say(f"{name}, its fastest frame:")
            main([str(trace), "--frame", "fastest", "--title", title, "-o", f"{options.folder}/timeline-{name}.png"])
            balance.main([str(trace), "--frame", "fastest", "-o", f"{options.folder}/balance-{name}.png"])
