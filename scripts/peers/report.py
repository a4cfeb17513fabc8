"""Tables of scripts/bench_peers.sh:  report.py FOLDER RINGSPLAT TRUTH_FOLDER TRUTH_VIEW...

Reads the seconds of all frames (PROGRAM-FUNCTION-SHADING.seconds; ringsplat's from its statistics) and compares the
pictures of some views with the truth.
"""
import json
import math
import statistics
import subprocess
import sys
from pathlib import Path

PROGRAMS = {"ringsplat": ".exr", "vtk": ".pfm", "volpack": ".pfm"}
NAMES = {"ringsplat": "ringsplat, 2 colocated ranks", "vtk": "VTK fixed-point, all cores", "volpack": "VolPack, one core"}


def frame_seconds(folder, program, case):
    """Of all rounds; a round's first frame, which still allocates, was left out."""
    return [float(line) for line in (folder / f"{program}-{case}.seconds").read_text().split()]


def rmse(ringsplat, picture, truth):
    """Over red, green and blue of linear colour over black, in 1/255."""
    out = subprocess.run([ringsplat, "compare", picture, truth, "--json"], check=True, capture_output=True, text=True).stdout
    channels = json.loads(out)["channels"]
    return math.sqrt(statistics.mean(channels[c]["rmse"] ** 2 for c in ("red", "green", "blue")))


def error(folder, ringsplat, truths, program, case, views):
    pictures = [(folder / f"{program}-{case}-{v:04}{PROGRAMS[program]}", truths / f"{case}-{k:04}.exr") for k, v in enumerate(views)]
    return math.sqrt(statistics.mean(rmse(ringsplat, *pair) ** 2 for pair in pictures))


def main():
    folder, ringsplat, truths = Path(sys.argv[1]), sys.argv[2], Path(sys.argv[3])
    views = list(map(int, sys.argv[4:]))
    scene = json.loads((folder / "scene.json").read_text())
    print("| transfer function | shading | program | ms a frame | slower than ringsplat | RMSE, 1/255 |")
    print("|---|---|---|---|---|---|")
    for function in scene["functions"]:
        for shading in ("phong", "none"):
            case = f"{function}-{shading}"
            ours = statistics.median(frame_seconds(folder, "ringsplat", case))
            for program in PROGRAMS:
                median = statistics.median(frame_seconds(folder, program, case))
                apart = error(folder, ringsplat, truths, program, case, views)
                visible = f"{100 * scene[function + ' visible']:.1f} %"
                print(f"| {function}, {visible} | {shading} | {NAMES[program]} | {1e3 * median:.1f} | {median / ours:.2f} | {apart:.2f} |")


if __name__ == "__main__":
    main()
