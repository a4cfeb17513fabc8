"""Tables of scripts/bench_peers.sh:  report.py FOLDER RINGSPLAT TRUTH_FOLDER TRUTH_VIEW...

Reads the seconds of all frames (PROGRAM-FUNCTION-SHADING.seconds; ringsplat's from its statistics) and compares the
pictures of some views with the truth. Ringsplat's pictures are of these views only, the others' of all views.
"""
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
    "volpack": "VolPack, one core",
}
PEERS = ("vtk", "volpack")


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


def main():
    folder, ringsplat, truths = Path(sys.argv[1]), sys.argv[2], Path(sys.argv[3])
    views = list(map(int, sys.argv[4:]))
    scene = json.loads((folder / "scene.json").read_text())
    print("| transfer function | shading | program | ms a frame | times as fast as VTK | RMSE, 1/255 |")
    print("|---|---|---|---|---|---|")
    for function in scene["functions"]:
        for shading in ("phong", "none"):
            case = f"{function}-{shading}"
            vtk = statistics.median(frame_seconds(folder, "vtk", case))
            for program in NAMES:
                median = statistics.median(frame_seconds(folder, program, case))
                apart = error(folder, ringsplat, truths, program, case, views)
                visible = f"{100 * scene[function + ' visible']:.1f} %"
                print(f"| {function}, {visible} | {shading} | {NAMES[program]} | {1e3 * median:.1f} | {vtk / median:.2f} | {apart:.2f} |")


if __name__ == "__main__":
    main()
