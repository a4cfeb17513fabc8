"""The table of scripts/bench_paraview.sh:  paraview_report.py FOLDER RINGSPLAT TRUTH_FOLDER CSV

FOLDER has PROGRAM-FUNCTION-SHADING-RANKS.seconds and .memory and pictures of which the first three have truths.
"""
import csv
import json
import math
import statistics
import subprocess
import sys
from pathlib import Path

NAMES = {"best": "ringsplat, sheets, best", "paper": "ringsplat, splats on the screen",
         "smart": "ParaView, GPU caster on llvmpipe", "cast": "ParaView, fixed-point caster"}
VIEWS = 3
MIB = 1 << 20
COLUMNS = ("function", "shading", "program", "ranks", "differing", "largest", "rmse", "seconds", "memory_most", "memory_sum")


def compared(ringsplat, one, other):
    command = [ringsplat, "compare", one, other, "--threshold", "0", "--json"]
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def picture(stem, k):
    """The view's picture; the programs write their own formats."""
    return next(path for path in (Path(f"{stem}-{k:04}.exr"), Path(f"{stem}-{k:04}.pfm")) if path.exists())


def measured(stem, first, truth, ringsplat):
    """What one program did on so many ranks, `first` being its pictures on one rank."""
    seams = [compared(ringsplat, picture(stem, k), picture(first, k)) for k in range(VIEWS)]
    squares = []
    for k in range(VIEWS):
        channels = compared(ringsplat, picture(stem, k), f"{truth}-{k:04}.exr")["channels"]
        squares += [channels[c]["rmse"] ** 2 for c in ("red", "green", "blue")]
    memory = [int(line) for line in Path(f"{stem}.memory").read_text().split()]
    seconds = [float(line) for line in Path(f"{stem}.seconds").read_text().split()]
    return {"differing": statistics.mean(s["fraction_over"] for s in seams), "largest": max(s["largest"] for s in seams),
            "rmse": math.sqrt(statistics.mean(squares)), "seconds": statistics.median(seconds),
            "memory_most": max(memory), "memory_sum": sum(memory)}


def main():
    folder, ringsplat, truths, table = Path(sys.argv[1]), sys.argv[2], Path(sys.argv[3]), sys.argv[4]
    rows = []
    for path in sorted(folder.glob("*-*-*-*.seconds"), key=lambda p: (p.stem.split("-")[1:3], list(NAMES).index(p.stem.split("-")[0]), p.stem)):
        program, function, shading, ranks = path.stem.split("-")
        stem, first = folder / path.stem, folder / f"{program}-{function}-{shading}-1"
        what = {"function": function, "shading": shading, "program": program, "ranks": int(ranks)}
        rows.append(what | measured(stem, first, truths / f"{function}-{shading}", ringsplat))
    with open(table, "w", newline="", encoding="utf-8") as file:
        out = csv.DictWriter(file, COLUMNS)
        out.writeheader()
        out.writerows(rows)
    print("| transfer function | shading | program | ranks | pixels that differ from 1 rank's, % | most, 1/255 | RMSE against the field, 1/255 "
          "| ms a frame | MiB, largest rank | MiB, all ranks |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    for r in rows:
        print(f"| {r['function']} | {r['shading']} | {NAMES[r['program']]} | {r['ranks']} | {100 * r['differing']:.2f} | {r['largest']:.1f} "
              f"| {r['rmse']:.2f} | {1e3 * r['seconds']:.1f} | {r['memory_most'] / MIB:.0f} | {r['memory_sum'] / MIB:.0f} |")


if __name__ == "__main__":
    main()
