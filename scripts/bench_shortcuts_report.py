#!/usr/bin/env python3
"""What scripts/bench_shortcuts.sh needs computed:

bench_shortcuts_report.py front-matrix INFO_JSON SIZE N    a --path file with N times the view from in front that fills SIZE pixels
bench_shortcuts_report.py tables FOLDER ROW...             Markdown tables of the shortcuts, from the --stats lines in FOLDER
bench_shortcuts_report.py bounds FOLDER                    the table of what is held to bounds, from there
"""
import json
import math
import statistics
import sys
from pathlib import Path


def front_matrix(info: dict, size: int) -> list[float]:
    """World to screen as azimuth = elevation = 0 has it at zoom 1: the box's bounding sphere fits the picture. The
    upper left quarter of that picture is then the same matrix with half the size."""
    scale = size / math.hypot(*info["size"])
    steps = list(zip(info["directions"], info["spacing"], info["dims"]))
    middle = [o + sum(d[k] * s * (n - 1) / 2 for d, s, n in steps) for k, o in enumerate(info["origin"])]
    right = [scale, 0.0, 0.0, size / 2 - scale * middle[0]]
    down = [0.0, 0.0, -scale, size / 2 + scale * middle[2]]
    return [*right, *down, 0.0, scale, 0.0, -scale * middle[1]]


def frames(folder: Path, name: str) -> list[dict]:
    return [json.loads(line) for line in (folder / f"{name}.jsonl").read_text().splitlines()]


def milliseconds(folder: Path, name: str, field: str) -> float:
    """The median, without each run's first frame, which still allocates."""
    return 1e3 * statistics.median(f[field] for f in frames(folder, name) if f["frame"] > 0)


def by_round(folder: Path, name: str) -> list[float]:
    """Median milliseconds of each round's run, without its first frame."""
    rounds: list[list[float]] = []
    for frame in frames(folder, name):
        if frame["frame"] == 0:
            rounds.append([])
        else:
            rounds[-1].append(1e3 * frame["seconds"])
    return [statistics.median(times) for times in rounds]


def rms(folder: Path, name: str) -> float:
    return math.sqrt(statistics.mean(f["error"]["rmse"] ** 2 for f in frames(folder, name)))


def shortcuts(folder: Path, rows: list[str]) -> None:
    for function in ("soft", "surface"):
        base = milliseconds(folder, f"{function}-{rows[0]}", "period")
        print(f"| {function} | ms a frame | ms between frames | times as fast | MB a frame | RMSE, 1/255 | largest |\n|---|---|---|---|---|---|---|")
        for row in rows:
            name = f"{function}-{row}"
            period = milliseconds(folder, name, "period")
            megabytes = statistics.median(f["total"]["payload_bytes_sent"] for f in frames(folder, name)) / 1e6
            largest = max(f["error"]["largest"] for f in frames(folder, f"error-{name}"))
            print(
                f"| {row.replace('-', ' ')} | {milliseconds(folder, name, 'seconds'):.1f} | {period:.1f} | {base / period:.2f} "
                f"| {megabytes:.1f} | {rms(folder, f'error-{name}'):.3g} | {largest:.3g} |"
            )
        print()


def bounds(folder: Path) -> None:
    """Ratios that the project holds to bounds, for both image planes: medians of the rounds' ratios, since a machine's
    speed may drift from round to round."""

    def ratio(what: str, a: str, b: str, bound: str) -> None:
        cells = []
        for plane in ("screen", "slices"):
            first, second = (by_round(folder, f"held-{plane}-{name}") for name in (a, b))
            quotient = statistics.median(x / y for x, y in zip(first, second))
            cells.append(f"{statistics.median(first):.1f} of {statistics.median(second):.1f} ms | {quotient:.2f}")
        print(f"| {what} | {' | '.join(cells)} | {bound} |")

    print("| | screen | ratio | slices' plane | ratio | bound |\n|---|---|---|---|---|---|")
    ratio("surface, of soft", "surface", "2-colocated", "at most 0.33")
    ratio("in a box twice as large, of the volume alone", "padded", "2-colocated", "at most 1.10")
    ratio("full, of undersampled by 2", "2-colocated", "undersampled", "at least 5")
    ratio("prefiltered, of skipped", "prefiltered", "undersampled", "at most 1.3")
    ratio("one process, of 2 colocated ranks", "one-process", "2-colocated", "at least 1.7")
    ratio("16 colocated ranks, of 2", "16-colocated", "2-colocated", "at most 1.33")
    ratio("16 ranks with `--gps auto`, of 2", "16-auto", "2-colocated", "at most 1.33")
    few, many = (frames(folder, f"held-screen-front-{size}")[0]["total"]["splats_drawn"] for size in (256, 512))
    ratio("a quarter of the picture, of the whole", "front-256", "front-512", f"its splats: {few / many:.2f}")


if __name__ == "__main__":
    if sys.argv[1] == "front-matrix":
        view = json.dumps({"matrix": front_matrix(json.loads(sys.argv[2]), int(sys.argv[3]))})
        print("\n".join([view] * int(sys.argv[4])))
    elif sys.argv[1] == "tables":
        shortcuts(Path(sys.argv[2]), sys.argv[3:])
    else:
        bounds(Path(sys.argv[2]))
