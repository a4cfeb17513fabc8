#!/usr/bin/env python3
"""Draws scripts/sort_last_study.py's table:  plot_sort_last.py SORT_LAST.csv -o PNG

Seconds a frame of the fastest ring and the fastest sort-last: against ranks, picture and voxels of a slice. Prints a Markdown table of
what is drawn, with the share of the ring's time that sort-last takes.
"""
import argparse
import csv
import sys
from collections import defaultdict

from figures import plt, write_figure

# Study, what is along x, its name.
PANELS = [("real", "ranks", "ranks, here"), ("strong", "ranks", "simulated ranks"), ("pictures", "picture", "width of the picture, 64 ranks"),
          ("slices", "voxels_a_slice", "voxels of a slice, 64 ranks")]
COLOURS = {"ring": "#0072B2", "sort-last": "#D55E00"}
LINES = {"here": "-", "infiniband-fat-tree.toml": "-", "ethernet-cluster.toml": "--"}
NAMES = {"here": "here", "infiniband-fat-tree.toml": "InfiniBand", "ethernet-cluster.toml": "Ethernet"}


def fastest(rows):
    """{study: {(machine, program): {x: row}}}: of each program the setting that is fastest there."""
    best = defaultdict(lambda: defaultdict(dict))
    for row in rows:
        row["seconds"] = float(row["seconds"])
        for study, key, _ in PANELS:
            # The strong study's frame on 64 ranks belongs to the others as well.
            if row["study"] != study and not (study in ("pictures", "slices") and row["study"] == "strong" and row["ranks"] == "64"):
                continue
            of = best[study][row["machine"], row["program"]]
            x = int(row[key])
            if x not in of or row["seconds"] < of[x]["seconds"]:
                of[x] = row
    return best


def draw(best):
    panels = [panel for panel in PANELS if panel[0] in best]
    figure, axes = plt.subplots(1, len(panels), figsize=(4.2 * len(panels), 4), layout="constrained", squeeze=False, facecolor="white")
    for axis, (study, _, name) in zip(axes[0], panels):
        for (machine, program), of in sorted(best[study].items()):
            xs = sorted(of)
            axis.plot(xs, [1e3 * of[x]["seconds"] for x in xs], LINES[machine], color=COLOURS[program], marker="o" if program == "ring" else "s",
                      label=f"{program}, {NAMES[machine]}")
        axis.set(xscale="log", yscale="log", xlabel=name)
        axis.grid(color="0.9", which="both")
        axis.legend(fontsize=8, handlelength=3.5)
    axes[0][0].set_ylabel("milliseconds a frame")
    return figure


def print_table(best):
    print("| study | machine | ranks | picture | voxels of a slice | ring, ms | its layout | sort-last, ms | its way | sort-last / ring |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    for study, _, _ in PANELS:
        for machine in NAMES:
            ring, sections = best[study][machine, "ring"], best[study][machine, "sort-last"]
            for x in sorted(set(ring) & set(sections)):
                r, s = ring[x], sections[x]
                if r["study"] != study:
                    continue  # in another panel's rows already
                print(f"| {study} | {NAMES[machine]} | {r['ranks']} | {r['picture']}² | {r['voxels_a_slice']} | {1e3 * r['seconds']:.1f} | {r['setting']} "
                      f"| {1e3 * s['seconds']:.1f} | {s['setting']} | {s['seconds'] / r['seconds']:.2f} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("table")
    parser.add_argument("-o", "--output", required=True)
    options = parser.parse_args()
    with open(options.table, newline="", encoding="utf-8") as file:
        best = fastest(list(csv.DictReader(file)))
    write_figure(draw(best), options.output)
    print_table({study: best[study] for study in best} | {study: defaultdict(dict) for study, _, _ in PANELS if study not in best})
    print(options.output, file=sys.stderr)


if __name__ == "__main__":
    main()
