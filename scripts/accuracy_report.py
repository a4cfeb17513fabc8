#!/usr/bin/env python3
"""Prints a study's results as the Markdown table of docs/accuracy.md.

usage: accuracy_report.py STUDY.csv [--truth field]

Over a scene's views: RMS of the RMSE, median of the frame times, and means of SSIM and FLIP where the table has them
(scripts/perceptual.py).
"""

import argparse
import csv
import statistics
import sys


def cell(rows):
    rmse = (sum(float(r["rmse"]) ** 2 for r in rows) / len(rows)) ** 0.5
    parts = [f"{rmse:.3g}", f"{1e3 * statistics.median(float(r['seconds']) for r in rows):.3g} ms"]
    if all(r.get("flip") for r in rows):
        parts += [f"{statistics.mean(float(r[name]) for r in rows):.4f}" for name in ("ssim", "flip")]
    return ", ".join(parts)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("study")
    parser.add_argument("--truth", choices=("method", "field", "analytic"), default="field")
    options = parser.parse_args()
    with open(options.study, newline="", encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["truth"] == options.truth]
    if not rows:
        sys.exit(f"{options.study} has no measurement against the {options.truth} truth; hint: add it to the study's list")
    scenes = list(dict.fromkeys(row["scene"] for row in rows))
    print("| setting | " + " | ".join(scenes) + " |")
    print("|---" * (len(scenes) + 1) + "|")
    for setting in dict.fromkeys(row["setting"] for row in rows):
        of_scene = [[r for r in rows if (r["setting"], r["scene"]) == (setting, scene)] for scene in scenes]
        print(f"| {setting} | " + " | ".join(cell(some) for some in of_scene) + " |")


if __name__ == "__main__":
    main()
