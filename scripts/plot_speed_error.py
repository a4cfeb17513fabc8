#!/usr/bin/env python3
"""Draws what `ringsplat study` measured: speed against error with the Pareto front marked, and error against view angle.

usage: plot_speed_error.py STUDY.csv [-o FOLDER] [--truth field]
"""

import argparse
import csv
import pathlib
import statistics
import sys
from collections import defaultdict

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
from matplotlib.lines import Line2D  # noqa: E402
from matplotlib.ticker import LogFormatter, ScalarFormatter  # noqa: E402

NUMBERS = ("seconds", "rmse", "rmse_low", "rmse_high", "largest", "mean", "azimuth", "elevation", "splats", "bytes")


def read_rows(path, truth):
    with open(path, newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["truth"] == truth]
    if not rows:
        sys.exit(f"{path} has no measurement against the {truth} truth; hint: --truth method, or add it to the study's list")
    for row in rows:
        for name in NUMBERS:
            row[name] = float(row[name])
    return rows


def pareto_front(points):
    """Names of the points (name, seconds, rmse) that no other beats in both, fastest first."""
    front, best = [], float("inf")
    for name, _, rmse in sorted(points, key=lambda p: (p[1], p[2])):
        if rmse < best:
            front.append(name)
            best = rmse
    return front


def plot_speed_error(rows, truth, folder):
    scenes = sorted({row["scene"] for row in rows})
    settings = list(dict.fromkeys(row["setting"] for row in rows))
    colours = {name: plt.get_cmap("tab20")(k % 20) for k, name in enumerate(settings)}
    figure, axes = plt.subplots(1, len(scenes), figsize=(4.2 * len(scenes) + 1.6, 4), squeeze=False)
    for axis, scene in zip(axes[0], scenes):
        by_setting = defaultdict(list)
        for row in rows:
            if row["scene"] == scene:
                by_setting[row["setting"]].append(row)
        points = [
            (name, statistics.median(r["seconds"] for r in some), (sum(r["rmse"] ** 2 for r in some) / len(some)) ** 0.5)
            for name, some in by_setting.items()
        ]
        front = pareto_front(points)
        print(f"{scene}: on the front against the {truth} truth: {', '.join(front)}")
        place = {name: (1e3 * seconds, rmse) for name, seconds, rmse in points}
        axis.plot(*zip(*(place[name] for name in front)), color="0.5", linewidth=1, zorder=1)
        for name in place:
            size = {"marker": "*", "markersize": 13} if name in front else {"marker": "o", "markersize": 6}
            axis.plot(*place[name], color=colours[name], linestyle="none", markeredgecolor="0.2", markeredgewidth=0.4, **size)
        axis.set(title=scene, xlabel="median frame time (ms)", ylabel=f"RMSE against the {truth} truth (1/255)")
        axis.set(xscale="log", yscale="log")
        for each in (axis.xaxis, axis.yaxis):
            each.set_major_formatter(ScalarFormatter())
            each.set_minor_formatter(LogFormatter(minor_thresholds=(2, 0.7)))
        axis.tick_params(which="both", labelsize=7)
        axis.grid(alpha=0.3, which="both")
    marks = [Line2D([], [], color=colours[name], marker="o", linestyle="none", label=name) for name in settings]
    marks.append(Line2D([], [], color="0.5", marker="*", markersize=11, label="Pareto front"))
    figure.legend(handles=marks, loc="center right", fontsize=7)
    save(figure, folder / f"speed-error-{truth}.png", right=1 - 1.5 / figure.get_figwidth())


def plot_angles(rows, truth, folder):
    by_line = defaultdict(list)
    for row in rows:
        if row["elevation"] == 0:
            by_line[row["scene"], row["setting"]].append((row["azimuth"], row["rmse"]))
    lines = {key: sorted(values) for key, values in by_line.items() if len(values) > 4}
    if not lines:
        return
    scenes = sorted({scene for scene, _ in lines})
    figure, axes = plt.subplots(1, len(scenes), figsize=(4.5 * len(scenes), 4), squeeze=False)
    for axis, scene in zip(axes[0], scenes):
        for (of_scene, setting), values in sorted(lines.items()):
            if of_scene == scene:
                axis.plot(*zip(*values), label=setting, linewidth=1)
        axis.set(title=scene, xlabel="azimuth (degrees)", ylabel=f"RMSE against the {truth} truth (1/255)")
        axis.axvline(45, color="0.5", linestyle=":", linewidth=1)
        axis.grid(alpha=0.3)
        axis.legend(fontsize=7)
    save(figure, folder / f"angle-error-{truth}.png")


def save(figure, path, right=1.0):
    figure.tight_layout(rect=(0, 0, right, 1))
    part = path.with_name(path.stem + ".part" + path.suffix)
    figure.savefig(part, dpi=120)
    part.rename(path)
    plt.close(figure)
    print(path)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("study", type=pathlib.Path)
    parser.add_argument("-o", "--output", type=pathlib.Path, default=pathlib.Path("."))
    parser.add_argument("--truth", choices=("method", "field", "analytic"), default="field")
    options = parser.parse_args()
    options.output.mkdir(parents=True, exist_ok=True)
    rows = read_rows(options.study, options.truth)
    plot_speed_error(rows, options.truth, options.output)
    plot_angles(rows, options.truth, options.output)


if __name__ == "__main__":
    main()
