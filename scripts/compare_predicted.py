#!/usr/bin/env python3
"""Compares predicted frame times with simulated ones:  scripts/compare_predicted.py [RANKS] [MACHINE.toml]

For every split of the ranks into GPs and Renderers, all ranks colocated and every mesh: what `ringsplat info --ranks N --machine FILE` says, and
the frame simulated on that machine. The head at 512x512 pixels, one frame in flight. Prints a Markdown table, by predicted time.
"""
import argparse
import json
import os
import statistics
import subprocess

from simulation import BUILD, HEAD, MACHINES, build, simulate

VIEW = ["--tf", "mr-soft", "--size", "512x512", "--azimuth", "30", "--elevation", "25", "--fit", "sphere", "--shading", "none"]


def settings_of(layout):
    if layout["topology"] == "mesh":
        columns, rows = layout["mesh"]
        return {"topology": "mesh", "mesh": f"{columns}x{rows}", "renderers": layout["renderers"], "routing": "manhattan"}
    return {key: layout[key] for key in ("gps", "renderers", "roles")}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("ranks", nargs="?", type=int, default=16)
    parser.add_argument("machine", nargs="?", default=os.path.join(MACHINES, "infiniband-fat-tree.toml"))
    arguments = parser.parse_args()
    build()
    said = subprocess.run([os.path.join(BUILD, "ringsplat"), "info", HEAD, *VIEW, "--quality", "paper", "--ranks", str(arguments.ranks), "--machine",
                           arguments.machine, "--json"], check=True, capture_output=True, text=True).stdout
    print("| layout | predicted ms | limit | simulated ms | simulated / predicted |\n|---|---|---|---|---|", flush=True)
    both = []
    for layout in json.loads(said)["prediction"]["layouts"]:
        settings = {"machine": os.path.abspath(arguments.machine), "frames-in-flight": 1, **settings_of(layout)}
        simulated = simulate(settings, HEAD, *VIEW, "--count-only")[0]["seconds"]
        predicted = layout["seconds"]
        both.append((predicted, simulated, layout["layout"]))
        print(f"| {layout['layout']} | {1e3 * predicted:.2f} | {layout['limit']} | {1e3 * simulated:.2f} | {simulated / predicted:.2f} |", flush=True)
    ratios = [simulated / predicted for predicted, simulated, _ in both]
    best = min(both, key=lambda b: b[1])
    print(f"\nSimulated / predicted: median {statistics.median(ratios):.2f}, from {min(ratios):.2f} to {max(ratios):.2f}. The fastest simulated is "
          f"{best[2]} with {1e3 * best[1]:.2f} ms; the fastest predicted, {both[0][2]}, takes {both[0][1] / best[1]:.2f} times that.")


if __name__ == "__main__":
    main()
