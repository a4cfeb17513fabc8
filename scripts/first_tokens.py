#!/usr/bin/env python3
"""How long GPs wait for their first tokens (Neumann 1992, section 4.3):  scripts/first_tokens.py [GPS] [RENDERERS]

Simulates a frame of the head on Pixel-Planes 5, by default with 30 GPs and 4 Renderers, and says from its timeline how long GPs wait from their first
slice being ready until its tokens come, in sum over all GPs.
"""
import json
import os
import sys
import tempfile

from simulation import PAPER, PaperVolumes, build, nodes, simulate


def first_slices(trace, gps):
    """For each GP's first slice when it was ready and when each Renderer's token came, in seconds."""
    with open(trace, encoding="utf-8") as file:
        events = json.load(file)["traceEvents"]
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


def main():
    gps, renderers = (int(n) for n in (sys.argv[1:] + ["30", "4"][len(sys.argv) - 1:])[:2])
    build()
    with tempfile.TemporaryDirectory() as folder:
        volumes = PaperVolumes(folder)
        for slots in (4, 1):
            settings = {**PAPER, "gps": gps, "renderers": renderers, "size": "256x256", "slots": slots}
            trace = os.path.join(folder, "trace.json")
            frame = simulate(settings, *volumes.head, "--count-only", "--shading", "none", "--trace", trace)[0]
            first = first_slices(trace, gps)
            last_token = sum(max(0, max(times) - ready) for ready, times in first)
            each_token = sum(max(0, time - ready) for ready, times in first for time in times)
            without = sum(node["seconds"]["waiting_for_token"] for node in nodes(frame, "GP"))
            print(f"{gps} GPs + {renderers} Renderers, {slots} slots: a frame takes {frame['seconds']:.3f} s; first slices wait {last_token:.3f} s in sum for "
                  f"their last token, {each_token:.3f} s for each; all slices {without:.3f} s without any token")


if __name__ == "__main__":
    main()
