#!/usr/bin/env python3
"""Compares real runs on this machine with simulated ones:  compare_simulated.py MACHINE.toml [REPETITIONS] [--quality best] [--csv FILE]

MACHINE is what scripts/calibrate.sh wrote here; nothing else should run. Prints a Markdown table: median seconds of a frame of the
head at 512x512 pixels over an orbit of eight views without the first, which still allocates, one frame in flight, for layouts of 2 to 24 ranks.
"""
import argparse
import csv
import json
import os
import statistics
import subprocess
import sys
import tempfile

from simulation import BUILD, HEAD, REPO, build, simulate

VIEW = ["--tf", "mr-soft", "--size", "512x512", "--orbit", "8", "--elevation", "25", "--axes", "all"]
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


def run_really(layout, quality, folder):
    """Seconds of each frame on this machine's own MPI."""
    stats = os.path.join(folder, "real.json")
    options = [word for key, value in layout.items() for word in (f"--{key}", str(value))]
    command = ["bash", "-c", f'source "{REPO}/scripts/lib.sh"; run_ranks "$@"', "bash", str(ranks_of(layout)), os.path.join(BUILD, "ringsplat"),
               "render", HEAD, *VIEW, "--quality", quality, "--frames-in-flight", "1", *options, "--stats", stats]
    ended = subprocess.run(command, capture_output=True, text=True)
    if ended.returncode != 0:
        sys.exit(f"{name_of(layout)} failed:\n{ended.stderr}")
    with open(stats, encoding="utf-8") as file:
        return [frame["seconds"] for frame in json.load(file)][1:]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("machine")
    parser.add_argument("repetitions", nargs="?", type=int, default=5)
    parser.add_argument("--csv")
    parser.add_argument("--quality", default="paper", help="draft, normal and best draw sheets")
    arguments = parser.parse_args()
    build()
    layouts = LAYOUTS if arguments.quality == "paper" else SHEET_LAYOUTS
    real = [[] for _ in layouts]
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(arguments.repetitions):
            for seconds, layout in zip(real, layouts):
                seconds += run_really(layout, arguments.quality, folder)
    rows = []
    for seconds, layout in zip(real, layouts):
        settings = {"quality": arguments.quality, "machine": os.path.abspath(arguments.machine), "frames-in-flight": 1, **layout}
        simulated = [frame["seconds"] for frame in simulate(settings, HEAD, "--count-only", *VIEW)][1:]
        rows.append((name_of(layout), ranks_of(layout), statistics.median(seconds), statistics.median(simulated)))
    print("| GPs + Renderers | ranks | real ms | simulated ms | simulated / real |\n|---|---|---|---|---|")
    for name, ranks, a, b in rows:
        print(f"| {name} | {ranks} | {1e3 * a:.1f} | {1e3 * b:.1f} | {b / a:.2f} |")
    print(f"\nMedian of simulated / real: {statistics.median(b / a for _, _, a, b in rows):.2f}")
    if arguments.csv:
        with open(arguments.csv + ".part", "w", newline="", encoding="utf-8") as file:
            csv.writer(file).writerows([("layout", "ranks", "real_seconds", "simulated_seconds"), *rows])
        os.replace(arguments.csv + ".part", arguments.csv)


if __name__ == "__main__":
    main()
