"""Reads what `ringsplat render --trace` wrote; shared by the scripts that plot it. Times are milliseconds."""
import json
from collections import defaultdict
from typing import NamedTuple

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


def read_json(path):
    """One JSON document, or the objects of a .jsonl. Ends the program with a message when there is none."""
    try:
        with open(path, encoding="utf-8") as file:
            text = file.read()
        if path.endswith(".jsonl"):
            return [json.loads(line) for line in text.splitlines() if line.strip()]
        return json.loads(text)
    except (OSError, ValueError) as error:
        raise SystemExit(f"{path} cannot be read as JSON: {error}") from error


def is_trace(document):
    return isinstance(document, dict) and "traceEvents" in document
