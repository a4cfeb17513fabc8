"""Tables of scripts/bench_peers.sh:  report.py FOLDER RINGSPLAT TRUTH_FOLDER CSV TRUTH_VIEW...

Reads the seconds of all frames (PROGRAM-FUNCTION-SHADING.seconds; ringsplat's from its statistics) and compares the
pictures of some views with the truth. Ringsplat's pictures are of these views only, the others' of all views. Prints a
Markdown table and writes its numbers to CSV, which plot.py draws.
"""
import csv
import json
import math
import statistics
import subprocess
import sys
from pathlib import Path

NAMES = {
    "best": "ringsplat, sheets, best",
    "normal": "ringsplat, sheets, normal",
    "draft": "ringsplat, sheets, draft",
    "screen": "ringsplat, on the screen",
    "slices": "ringsplat, in the slices' plane",
    "sharp": "ringsplat, in the slices' plane, radius 1.1",
    "apart": "ringsplat, in the slices' plane, one GP and one Renderer",
    "sharp-apart": "ringsplat, in the slices' plane, one GP and one Renderer, radius 1.1",
    "vtk": "VTK fixed-point, all cores",
    "vtk-gpu": "VTK GPU on Mesa's llvmpipe, all cores",
    "paraview": "ParaView, pvbatch on two ranks, llvmpipe",
    "volpack": "VolPack, one core",
}
PEERS = ("vtk", "vtk-gpu", "paraview", "volpack")
COLUMNS = ("function", "visible", "shading", "program", "seconds", "rmse")


def frame_seconds(folder, program, case):
    """Of all rounds; a round's first frame, which still allocates, was left out."""
    return [float(line) for line in (folder / f"{program}-{case}.seconds").read_text().split()]


def rmse(ringsplat, picture, truth):
    """Over red, green and blue of linear colour over black, in 1/255."""
    out = subprocess.run([ringsplat, "compare", picture, truth, "--json"], check=True, capture_output=True, text=True).stdout
    channels = json.loads(out)["channels"]
    return math.sqrt(statistics.mean(channels[c]["rmse"] ** 2 for c in ("red", "green", "blue")))


def error(folder, ringsplat, truths, program, case, views):
    squares = []
    for k, view in enumerate(views):
        picture = f"{program}-{case}-{view:04}.pfm" if program in PEERS else f"{program}-{case}-{k:04}.exr"
        squares.append(rmse(ringsplat, folder / picture, truths / f"{case}-{k:04}.exr") ** 2)
    return math.sqrt(statistics.mean(squares))


def measured(folder, ringsplat, truths, views):
    """A dictionary of COLUMNS for each program that ran, scene by scene."""
    scene = json.loads((folder / "scene.json").read_text())
    for function in scene["functions"]:
        for shading in ("phong", "none"):
            case = f"{function}-{shading}"
            for program in NAMES:
                if (folder / f"{program}-{case}.seconds").exists():
                    values = (function, scene[function + " visible"], shading, program,
                              statistics.median(frame_seconds(folder, program, case)),
                              error(folder, ringsplat, truths, program, case, views))
                    yield dict(zip(COLUMNS, values))


def main():
    folder, ringsplat, truths, table = Path(sys.argv[1]), sys.argv[2], Path(sys.argv[3]), sys.argv[4]
    rows = list(measured(folder, ringsplat, truths, list(map(int, sys.argv[5:]))))
    with open(table, "w", newline="", encoding="utf-8") as file:
        out = csv.DictWriter(file, COLUMNS)
        out.writeheader()
        out.writerows(rows)
    vtk = {(row["function"], row["shading"]): row["seconds"] for row in rows if row["program"] == "vtk"}
    print("| transfer function | shading | program | ms a frame | times as fast as VTK | RMSE, 1/255 |")
    print("|---|---|---|---|---|---|")
    for row in rows:
        times = vtk[row["function"], row["shading"]] / row["seconds"]
        print(f"| {row['function']}, {100 * row['visible']:.1f} % | {row['shading']} | {NAMES[row['program']]} "
              f"| {1e3 * row['seconds']:.1f} | {times:.2f} | {row['rmse']:.2f} |")


if __name__ == "__main__":
    main()
