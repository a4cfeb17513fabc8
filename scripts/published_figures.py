#!/usr/bin/env python3
"""Reproduces the figures that Neumann 1992, section 4, publishes, with the program on a simulated Pixel-Planes 5.

    scripts/published_figures.py        prints a Markdown table: ours, the paper's, their ratio
"""
import tempfile

from simulation import PAPER, PaperVolumes, build, nodes, simulate


def frame(volume, gps, renderers, size):
    return simulate({**PAPER, "gps": gps, "renderers": renderers, "size": f"{size}x{size}"}, *volume, "--count-only", "--shading", "none")[0]


def main():
    build()
    with tempfile.TemporaryDirectory() as folder:
        volumes = PaperVolumes(folder)
        one = frame(volumes.full, 20, 1, 128)
        four = frame(volumes.full, 20, 4, 256)
        head = frame(volumes.head, 10, 4, 256)
        half = frame(volumes.undersampled, 10, 4, 256)
    voxels = 128**3
    drawing = nodes(one, "Renderer")[0]["seconds"]["drawing"]
    rows = [
        ("128³, all voxels, one Renderer's own work (computed)", "s", drawing, 4.09),
        ("128³, all voxels, 20 GPs + 1 Renderer", "s", one["seconds"], 4.38),
        ("the same, throughput", "voxels/s", voxels / one["seconds"], 478e3),
        ("128³, all voxels, 20 GPs + 4 Renderers", "s", four["seconds"], 1.29),
        ("the same, throughput", "voxels/s", voxels / four["seconds"], 1.622e6),
        (f"head 128×128×124, {head['total']['visible_voxels']:,} visible voxels, 10 GPs + 4 Renderers", "Hz", 1 / head["seconds"], 0.93),
        (f"the same undersampled to 64×64×62, {half['total']['visible_voxels']:,} visible", "Hz", 1 / half["seconds"], 6.15),
    ]
    print("| case | ours | paper | ratio |\n|---|---|---|---|")
    for case, unit, ours, paper in rows:
        text = [f"{value:,.0f}" if value > 1000 else f"{value:.3g}" for value in (ours, paper)]
        print(f"| {case} | {text[0]} {unit} | {text[1]} {unit} | {ours / paper:.3f} |")


if __name__ == "__main__":
    main()
