#!/usr/bin/env python3
"""Draws a frame's timeline from what `ringsplat render ... --trace FILE` wrote, as Figs. 5 and 8 of Neumann 1992 do.

    scripts/plot_timeline.py TRACE.json -o timeline.png [--frame N|last|fastest] [--title TEXT] [--payloads]

GPs and Renderers are rows. A GP's bar is one slice with the seconds that classifying, shading and encoding took in
sum; a Renderer's is one payload. Waiting is shaded. Arcs are tokens, one colour for each Renderer.
"""
import argparse
import sys

from figures import matplotlib, plt, write_figure
from matplotlib.patches import FancyArrowPatch, Patch
from timeline import Timeline, is_trace, read_json

COLOUR = {
    "classify": "#f4c9a0",
    "shade": "#e9a466",
    "encode": "#d67f35",
    "draw": "#7fa8d1",
    "composite": "#3f6fa8",
    "deliver": "#274b75",
}
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
    style = f"arc3,rad={bend if start < end else -bend}"
    axes.add_patch(
        FancyArrowPatch(
            (flow.left, start + side), (flow.arrived, end - side), connectionstyle=style, arrowstyle="-|>", shrinkA=0, shrinkB=0,
            mutation_scale=9, color=colour, linewidth=width, zorder=5,
        )
    )


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


def draw(timeline, frame, title, payloads):
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
    ticks = matplotlib.ticker.FuncFormatter(lambda t, _: f"{t - begin:g}")
    axes.xaxis.set_major_locator(matplotlib.ticker.FixedLocator(nice_ticks(begin, end)))
    axes.xaxis.set_major_formatter(ticks)
    axes.set_xlabel("milliseconds since the frame was announced")
    axes.spines[["top", "right", "left"]].set_visible(False)
    axes.tick_params(axis="y", length=0)
    axes.set_title(title or f"Frame {frame}", fontsize=11, loc="left")
    add_legend(axes, sum(n.startswith("Renderer") for n in rows))
    return figure


def nice_ticks(begin, end):
    steps = matplotlib.ticker.MaxNLocator(10).tick_values(0, end - begin)
    return [begin + t for t in steps if 0 <= t <= end - begin]


def add_legend(axes, renderers):
    entries = [Patch(color=COLOUR[name], label=name) for name in COLOUR]
    entries.append(Patch(color=BETWEEN, label="between a slice's pieces"))
    for colour, hatch, label in [*WAIT.values(), IDLE]:
        entries.append(Patch(facecolor=colour, hatch=hatch, edgecolor="0.65", label=label))
    for renderer in range(min(renderers, len(TOKEN))):
        entries.append(plt.Line2D([], [], color=TOKEN[renderer], label=f"T{renderer}: token of Renderer {renderer}"))
    axes.legend(handles=entries, loc="upper center", bbox_to_anchor=(0.5, -0.62 / axes.get_ylim()[0]), ncols=6, fontsize=8, frameon=False)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("trace", help="written by ringsplat render --trace")
    parser.add_argument("-o", "--output", required=True, help="PNG")
    parser.add_argument("--frame", default="last", help="a number, 'last' or 'fastest'")
    parser.add_argument("--title", help="instead of the frame's number")
    parser.add_argument("--payloads", action="store_true", help="arrows from GPs to Renderers too")
    arguments = parser.parse_args()
    document = read_json(arguments.trace)
    if not is_trace(document):
        sys.exit(f"{arguments.trace} is no trace: make one with ringsplat render --trace")
    timeline = Timeline(document)
    if not timeline.frames:
        sys.exit(f"{arguments.trace} has no complete frame")
    frame = timeline.choose_frame(arguments.frame)
    if frame is None:
        sys.exit(f"{arguments.trace} has no frame {arguments.frame}; it has {min(timeline.frames)} to {max(timeline.frames)}")
    write_figure(draw(timeline, frame, arguments.title, arguments.payloads), arguments.output)


if __name__ == "__main__":
    main()
