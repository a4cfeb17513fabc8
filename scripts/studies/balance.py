"""The balance of GPs and Renderers, from what `ringsplat render` wrote with --trace or --stats.

Prints, and draws with -o: what every node spent busy, waiting and idle, how far both sides were used, and from a trace, for each slice,
what was its limit. "Since the system resynchronizes every slice due to the token passing, each slice has its own load balance" (Neumann
1992, section 4.3). A payload that found its Renderer drawing was held up by the Renderer. A Renderer that had nothing to draw when the
payload came was held up by the GP when the token was there before the slice was ready, and by the token's way round when the slice waited
for it. Without --frame all frames count.
"""
import statistics
from collections import Counter, defaultdict
from typing import NamedTuple

from .output import plotting, write_figure
from .run import fail, parser, read_json
from .timeline import WAITING, Timeline, is_trace

STATS_BUSY = ("computing", "drawing", "compositing", "delivering")
STATS_WAITING = ("waiting_for_token", "sending")
PARTS = (("busy", "#d67f35"), ("waiting", "0.75"), ("idle", "#f7f2c8"))
SIDES = {"GP": "#d67f35", "Renderer": "#3f6fa8", "token": "#8c6bb1"}


class Load(NamedTuple):
    """Milliseconds of a node."""

    node: str
    busy: float
    waiting: float
    idle: float

    def share(self):
        return self.busy / max(sum(self[1:]), 1e-9)


class Margin(NamedTuple):
    """How long a slice's payload waited for its Renderer; negative: how long the Renderer waited for it."""

    frame: int
    step: int
    renderer: int
    ms: float
    limit: str


def loads_of_stats(frames):
    loads = []
    for k, node in enumerate(frames[0]["nodes"]):
        seconds = [f["nodes"][k]["seconds"] for f in frames]
        total = [1e3 * sum(s[p] for s in seconds for p in parts) for parts in (STATS_BUSY, STATS_WAITING, ("idle",))]
        loads.append(Load(node["node"], *total))
    return loads


def loads_of_trace(timeline, frames):
    """Over the time from the first frame's announcement to the last one's end."""
    begins, ends = zip(*(timeline.frames[f] for f in frames))
    window = max(ends) - min(begins)
    loads = []
    for node in timeline.nodes:
        busy = sum(s.busy for s in timeline.work(node) if s.frame in frames)
        waiting = sum(s.busy for s in timeline.spans[node] if s.name in WAITING and s.frame in frames)
        loads.append(Load(node, busy, waiting, max(0.0, window - busy - waiting)))
    return loads


def margins(timeline, frames):
    """Each payload's, in the order in which its Renderer drew them."""
    ready = {(s.frame, s.step): s.end for node in timeline.nodes for s in timeline.spans[node] if s.name == "slice"}
    token = {(f.frame, f.step, f.renderer): f.arrived for f in timeline.flows if f.kind == "token"}
    found = []
    for node in (n for n in timeline.nodes if n.startswith("Renderer")):
        work = [(s.frame, s.step if s.step >= 0 else float("inf"), s.end) for s in timeline.work(node)]
        payloads = [f for f in timeline.flows if f.kind == "payload" and f.destination == node and f.frame in frames]
        free = done = 0
        for payload in sorted(payloads, key=lambda f: (f.frame, f.step)):
            while done < len(work) and work[done][:2] < (payload.frame, payload.step):
                free = work[done][2]
                done += 1
            key = (payload.frame, payload.step)
            margin = max(free, timeline.frames[payload.frame][0]) - payload.arrived
            held_by = "Renderer" if margin > 0 else "token" if token.get((*key, payload.renderer), 0) > ready[key] else "GP"
            found.append(Margin(*key, payload.renderer, margin, held_by))
    return found


def limits(found):
    """Step -> its limit: what held its payloads up longest, over all frames and Renderers."""
    held = defaultdict(Counter)
    for m in found:
        held[m.step][m.limit] += abs(m.ms)
    return {step: by_limit.most_common(1)[0][0] for step, by_limit in sorted(held.items())}


def ranges(numbers):
    """1 2 3 7 -> '1-3 7'"""
    parts = []
    for n in numbers:
        if parts and parts[-1][1] == n - 1:
            parts[-1][1] = n
        else:
            parts.append([n, n])
    return " ".join(str(a) if a == b else f"{a}-{b}" for a, b in parts)


def print_loads(loads, count):
    print(f"{'node':<14}{'busy':>10}{'waiting':>10}{'idle':>10}  ms a frame, of {count} frame(s)")
    for load in loads:
        print(f"{load.node:<14}{load.busy / count:>10.2f}{load.waiting / count:>10.2f}{load.idle / count:>10.2f}")
    for side in ("GP", "Renderer"):
        share = statistics.mean(load.share() for load in loads if load.node.startswith(side))
        print(f"utilisation of the {side}s: {100 * share:.1f} %")


def print_limits(by_step):
    for side in SIDES:
        steps = [step for step, who in by_step.items() if who == side]
        print(f"slices limited by {side}s: {len(steps)} of {len(by_step)}{': steps ' + ranges(steps) if steps else ''}")


def draw_loads(axes, loads, count):
    rows = range(len(loads))
    left = [0.0] * len(loads)
    for part, colour in PARTS:
        widths = [getattr(load, part) / count for load in loads]
        axes.barh(rows, widths, left=left, color=colour, edgecolor="white", label=part)
        left = [a + b for a, b in zip(left, widths)]
    for row, load in zip(rows, loads):
        axes.text(left[row], row, f" {100 * load.share():.0f} %", va="center", fontsize=8)
    axes.set_yticks(rows, [load.node for load in loads])
    axes.invert_yaxis()
    axes.set_xlim(0, 1.08 * max(left))
    axes.set_xlabel("milliseconds a frame; busy share at the right")
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3, fontsize=8, frameon=False)


def draw_margins(axes, found):
    """One bar a slice and Renderer, the median over frames, coloured by what was most often the limit."""
    renderers = sorted({m.renderer for m in found})
    width = 0.8 / len(renderers)
    bars = defaultdict(list)
    for m in found:
        bars[m.step, m.renderer].append(m)
    for (step, renderer), all_ in bars.items():
        limit = Counter(m.limit for m in all_).most_common(1)[0][0]
        x = step + (renderers.index(renderer) + 0.5) * width - 0.4
        axes.bar(x, statistics.median(m.ms for m in all_), width, color=SIDES[limit], edgecolor="white", linewidth=0.3)
    axes.axhline(0, color="0.3", linewidth=0.8)
    axes.set_xlabel(f"slice, by traversal step; {len(renderers)} bar{'s' * (len(renderers) > 1)}, one a Renderer")
    axes.set_ylabel("payload waited, ms\nRenderer waited, −ms", fontsize=8)
    axes.xaxis.get_major_locator().set_params(integer=True)
    labels = {"GP": "GP-bound", "Renderer": "Renderer-bound", "token": "waited for the token"}
    handles = [axes.bar(0, 0, color=SIDES[side], label=labels[side]) for side in SIDES]
    axes.legend(handles=handles, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3, fontsize=8, frameon=False)


def draw(plt, loads, count, found):
    panels = 2 if found else 1
    height = 0.32 * len(loads) + 1.2
    figure, axes = plt.subplots(panels, 1, figsize=(9, height + 2.6 * (panels - 1)), layout="constrained", squeeze=False,
                                height_ratios=[height, 2.6][:panels])
    draw_loads(axes[0][0], loads, count)
    if found:
        draw_margins(axes[1][0], found)
    for a in axes.flat:
        a.spines[["top", "right"]].set_visible(False)
    return figure


def read(path, wanted):
    """Loads, number of frames, margins."""
    document = read_json(path)
    if is_trace(document):
        timeline = Timeline(document)
        frames = set(timeline.frames) if wanted is None else {timeline.choose_frame(wanted)}
        if not frames or None in frames:
            fail(f"{path} has no frame {wanted or 'that is complete'}")
        return loads_of_trace(timeline, frames), len(frames), margins(timeline, frames)
    try:
        frames = document if isinstance(document, list) else [document]
        if wanted is not None:
            by_name = {"last": frames[-1], "fastest": min(frames, key=lambda f: f["seconds"])}
            frames = [by_name[wanted]] if wanted in by_name else [f for f in frames if str(f["frame"]) == wanted]
        if not frames:
            fail(f"{path} has no frame {wanted}")
        return loads_of_stats(frames), len(frames), []
    except (KeyError, TypeError, IndexError):
        fail(f"{path} is neither a trace nor statistics of ringsplat render")


def main(words):
    arguments = parser(__doc__)
    arguments.add_argument("file", help="written by ringsplat render --trace or --stats")
    arguments.add_argument("-o", "--output", help="PNG")
    arguments.add_argument("--frame", help="a number, 'last' or 'fastest'")
    options = arguments.parse_args(words)
    loads, count, found = read(options.file, options.frame)
    print_loads(loads, count)
    if found:
        print_limits(limits(found))
    if options.output:
        write_figure(draw(plotting(), loads, count, found), options.output)
