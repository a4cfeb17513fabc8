"""Draws speed against error, ringsplat and its peers:  plot.py SPEED_ERROR.csv -o PNG

The CSV is report.py's. A panel for each transfer function; points further left are faster, lower ones nearer to the
field. Names stand beside the points of the shaded pictures.
"""
import argparse
import csv
import math
import sys
from collections import defaultdict
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from figures import plt, write_figure  # noqa: E402

from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter  # noqa: E402

# Okabe and Ito's colours, told apart by the colour-blind; shapes tell the families apart without colours.
FAMILIES = {  # colour, marker, and the names of its programs in the order of the joining line
    "sheets": ("#0072B2", "o", {"draft": "sheets, draft", "normal": "normal", "best": "best"}),
    "splats": ("#009E73", "s", {"screen": "splats (paper)", "slices": "in slices' plane", "sharp": "radius 1.1"}),
    "vtk": ("#D55E00", "^", {"vtk": "VTK fixed-point"}),
    "vtk-gpu": ("#B8860B", "D", {"vtk-gpu": "VTK GPU on llvmpipe"}),
    "paraview": ("#56B4E9", "P", {"paraview": "ParaView, 2 ranks"}),
    "volpack": ("#A5407D", "v", {"volpack": "VolPack"}),
}
TITLES = {"soft": "Soft", "surface": "Surface"}
# Where a name may stand: offset from its point in points, and alignment.
PLACES = [(9, 0, "left", "center"), (-9, 0, "right", "center"), (0, 9, "center", "bottom"), (0, -9, "center", "top"),
          (7, 7, "left", "bottom"), (-7, 7, "right", "bottom"), (7, -7, "left", "top"), (-7, -7, "right", "top"),
          (0, 20, "center", "bottom"), (0, -20, "center", "top"), (14, 16, "left", "bottom"), (-14, -16, "right", "top"),
          (14, -16, "left", "top"), (-14, 16, "right", "bottom"), (20, 30, "left", "bottom"), (-20, -30, "right", "top"),
          (20, -30, "left", "top"), (-20, 30, "right", "bottom")]
NEAR = 12  # names further away, in points, are joined to their points by a line


def read_scenes(path):
    """{function: {"visible": share, shading: {program: (milliseconds, RMSE)}}}, of the FAMILIES' programs."""
    scenes = defaultdict(lambda: {"phong": {}, "none": {}})
    with open(path, newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            scene = scenes[row["function"]]
            scene["visible"] = float(row["visible"])
            if any(row["program"] in programs for *_, programs in FAMILIES.values()):
                scene[row["shading"]][row["program"]] = (1e3 * float(row["seconds"]), float(row["rmse"]))
    if not scenes:
        sys.exit(f"{path} has no measurement")
    return scenes


def draw_points(panel, scene):
    """Shaded ones are filled. Returns the shaded ones to be named: (point, name, colour)."""
    names = []
    for family, (colour, marker, programs) in FAMILIES.items():
        for shading, face, line in (("phong", colour, "-"), ("none", "white", "--")):
            points = [(scene[shading][p], name) for p, name in programs.items() if p in scene[shading]]
            if not points:
                continue
            panel.plot(*zip(*(point for point, _ in points)), color=colour, marker=marker, markersize=8, markerfacecolor=face,
                       markeredgewidth=1.5, linewidth=1.5, linestyle=line if family == "sheets" else "none", zorder=3)
            if shading == "phong":
                names += [(*point, colour) for point in points]
    return names


def along_line(points):
    """Points that stand for the line through these, in the picture's pixels."""
    return [(a[0] + (b[0] - a[0]) * k / 20, a[1] + (b[1] - a[1]) * k / 20) for a, b in zip(points, points[1:]) for k in range(21)]


def obstacles(panel, scene):
    """Pixels that names should not cover: all points, and the lines through the sheets'."""
    pixels = {s: {p: panel.transData.transform(point) for p, point in scene[s].items()} for s in ("phong", "none")}
    lines = [along_line([of[p] for p in FAMILIES["sheets"][2] if p in of]) for of in pixels.values()]
    return [point for of in pixels.values() for point in of.values()], sum(lines, [])


def write_names(panel, names, scene):
    """Each where it covers least: other names, points, then lines."""
    renderer = panel.figure.canvas.get_renderer()
    taken = []
    marks, lines = obstacles(panel, scene)
    frame = panel.get_window_extent(renderer)

    def cost(box, place):
        inside = frame.x0 <= box.x0 and box.x1 <= frame.x1 and frame.y0 <= box.y0 and box.y1 <= frame.y1
        near = box.padded(8)
        covered = 30 * sum(box.overlaps(other) for other in taken) + 20 * sum(near.contains(*m) for m in marks)
        return 100 * (not inside) + covered + sum(box.contains(*p) for p in lines) + 0.1 * place

    for point, name, colour in names:
        def write(place, **how):
            dx, dy, ha, va = place
            return panel.annotate(name, point, (dx, dy), textcoords="offset points", ha=ha, va=va, color=colour, fontsize=10, **how)

        boxes = []
        for place in PLACES:
            text = write(place)
            boxes.append(text.get_window_extent(renderer))
            text.remove()
        chosen = min(range(len(PLACES)), key=lambda k: cost(boxes[k], k))
        taken.append(boxes[chosen])
        far = math.hypot(*PLACES[chosen][:2]) > NEAR
        write(PLACES[chosen], arrowprops={"arrowstyle": "-", "color": colour, "linewidth": 0.8} if far else None, zorder=4)


def scale(panel, points):
    """Room for the names around all points, and numbers at 1, 2 and 5 of each decade."""
    for values, set_limits, axis in zip(zip(*points), (panel.set_xlim, panel.set_ylim), (panel.xaxis, panel.yaxis)):
        set_limits(min(values) / 1.6, max(values) * 1.6)
        axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.set_minor_formatter(NullFormatter())


def draw(scenes):
    figure, panels = plt.subplots(1, len(scenes), figsize=(5.4 * len(scenes), 5), layout="constrained", squeeze=False, facecolor="white")
    names = []
    points = []
    for panel, (function, scene) in zip(panels[0], scenes.items()):
        panel.set(xscale="log", yscale="log", xlabel="milliseconds a frame")
        panel.set_title(f"{TITLES.get(function, function)}: {100 * scene['visible']:.0f} % of the voxels visible", fontsize=12)
        panel.grid(color="0.9")
        panel.set_axisbelow(True)
        names.append(draw_points(panel, scene))
        points += [point for shading in ("phong", "none") for point in scene[shading].values()]
    # The same scales for all panels, so that they can be compared.
    for panel in panels[0]:
        scale(panel, points)
    panels[0][0].set_ylabel("RMSE against the field, 1/255")
    figure.supxlabel("Circles: ringsplat's sheets; squares: its splats. Filled: Phong; open: unshaded. Lower left is better.", fontsize=10)
    figure.canvas.draw()
    figure.set_layout_engine("none")  # names are placed by the pixel, so nothing may move any more
    for panel, its_names, scene in zip(panels[0], names, scenes.values()):
        write_names(panel, its_names, scene)
    return figure


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("table", type=Path)
    parser.add_argument("-o", "--output", required=True)
    options = parser.parse_args()
    write_figure(draw(read_scenes(options.table)), options.output)
    print(options.output, file=sys.stderr)


if __name__ == "__main__":
    main()
