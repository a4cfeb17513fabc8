#!/usr/bin/env python3
"""Compares predicted frame times with simulated ones:  scripts/compare_predicted.py [RANKS] [MACHINE.toml] [--choices]

For every split of the ranks into GPs and Renderers, all ranks colocated and every mesh: what `ringsplat info --ranks N --machine FILE` says, and
the frame simulated on that machine. The head at 512x512 pixels, one frame in flight. Prints a Markdown table, by predicted time.

--choices: six volumes and functions instead, with splats and sheets, and what the program chooses beside a handful of other layouts.
"""
import argparse
import json
import os
import statistics
import subprocess
import tempfile

from simulation import BUILD, HEAD, MACHINES, build, program, simulate

VIEW = ["--tf", "mr-soft", "--size", "512x512", "--azimuth", "30", "--elevation", "25", "--fit", "sphere", "--shading", "none"]


def settings_of(layout):
    if layout["topology"] == "mesh":
        columns, rows = layout["mesh"]
        return {"topology": "mesh", "mesh": f"{columns}x{rows}", "renderers": layout["renderers"], "routing": "manhattan"}
    return {key: layout[key] for key in ("gps", "renderers", "roles")}


def predictions(volume, ranks, machine):
    said = subprocess.run([os.path.join(BUILD, "ringsplat"), "info", *map(str, volume), "--ranks", str(ranks), "--machine", machine, "--json"],
                          check=True, capture_output=True, text=True).stdout
    return json.loads(said)["prediction"]["layouts"]


def simulated_seconds(volume, layout, machine):
    settings = {"machine": os.path.abspath(machine), "frames-in-flight": 1, **settings_of(layout)}
    return simulate(settings, *volume, "--count-only")[0]["seconds"]


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
    print("| volume and function | method | ranks | chosen | predicted ms | simulated ms | fastest of others | ms | chosen / fastest |\n"
          "|---|---|---|---|---|---|---|---|---|", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        for name, volume in six_volumes(folder).items():
            for method, quality in (("splats", "paper"), ("sheets", "best")):
                for ranks in (16, 64):
                    volume_there = [*volume, "--quality", quality]
                    layouts = handful(predictions(volume_there, ranks, machine), ranks)
                    seconds = [simulated_seconds(volume_there, layout, machine) for layout in layouts]
                    other = min(range(1, len(layouts)), key=lambda k: seconds[k])
                    print(f"| {name} | {method} | {ranks} | {layouts[0]['layout']} | {1e3 * layouts[0]['seconds']:.2f} | {1e3 * seconds[0]:.2f} | "
                          f"{layouts[other]['layout']} | {1e3 * seconds[other]:.2f} | {seconds[0] / min(seconds):.2f} |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("ranks", nargs="?", type=int, default=16)
    parser.add_argument("machine", nargs="?", default=os.path.join(MACHINES, "infiniband-fat-tree.toml"))
    parser.add_argument("--choices", action="store_true")
    arguments = parser.parse_args()
    build()
    if arguments.choices:
        choices(arguments.machine)
        return
    print("| layout | predicted ms | limit | simulated ms | simulated / predicted |\n|---|---|---|---|---|", flush=True)
    both = []
    volume = [HEAD, *VIEW, "--quality", "paper"]
    for layout in predictions(volume, arguments.ranks, arguments.machine):
        simulated = simulated_seconds(volume, layout, arguments.machine)
        predicted = layout["seconds"]
        both.append((predicted, simulated, layout["layout"]))
        print(f"| {layout['layout']} | {1e3 * predicted:.2f} | {layout['limit']} | {1e3 * simulated:.2f} | {simulated / predicted:.2f} |", flush=True)
    ratios = [simulated / predicted for predicted, simulated, _ in both]
    best = min(both, key=lambda b: b[1])
    print(f"\nSimulated / predicted: median {statistics.median(ratios):.2f}, from {min(ratios):.2f} to {max(ratios):.2f}. The fastest simulated is "
          f"{best[2]} with {1e3 * best[1]:.2f} ms; the fastest predicted, {both[0][2]}, takes {both[0][1] / best[1]:.2f} times that.")


if __name__ == "__main__":
    main()
