"""All figures and pictures of docs/measured/accuracy.md: the default list of settings and its pictures, the sweep of angles, the roundings.

CSV, JSON and plots go to FOLDER (default build/accuracy), and with --docs the plots replace those of the page. Times want an idle machine.
SSIM and FLIP need two packages of PyPI, which go to build/perceptual; without a network the columns are left out.
"""
import subprocess
from collections import defaultdict
from pathlib import Path

from .output import median, plotting, print_head, print_row, read_csv, rms, write_figure
from .run import BUILD, REPO, fail, output_of, parser, say
from .settings import DEFAULT_LIST, measure_settings

ENVIRONMENT = REPO / "build/perceptual"
DOCS = REPO / "docs/measured"
PANELS = {
    "drift": ("Positions along a row", "voxels in the row", "largest error (pixels)"),
    "quadratic": ("The quadratic Q, 1 pixel a voxel", "distance of a fixed origin (pixels)", "largest error of Q"),
    "kernel": ("The quadratic Q", "pixels a voxel", "largest error of Q"),
    "composite": ("The composite", "slices", "largest error (values in 0..1)"),
}


def main(words):
    arguments = parser(__doc__)
    arguments.add_argument("folder", nargs="?", type=Path, default=REPO / "build/accuracy", metavar="FOLDER")
    arguments.add_argument("--list", type=Path, default=DEFAULT_LIST, help="another list than studies/settings.toml")
    arguments.add_argument("--angles", type=Path, default=Path(__file__).with_name("angles.toml"), help="another sweep than studies/angles.toml")
    arguments.add_argument("--docs", action="store_true")
    options = arguments.parse_args(words)
    folder = options.folder
    folder.mkdir(parents=True, exist_ok=True)
    study, angles = folder / "study.csv", folder / "angles.csv"
    measure_settings(options.list, study, folder / "pictures")
    measure_settings(options.angles, angles)
    (folder / "roundings.csv").write_text(output_of(BUILD / "measure_roundings"))
    print_results(read_rows(add_perceptual(folder) or study, "field"))
    where = DOCS if options.docs else folder
    plt = plotting()
    plot_speed_error(plt, read_rows(study, "field"), "field", where / "accuracy-speed-error.png")
    plot_angles(plt, read_rows(angles, "field"), "field", where / "accuracy-angle-error.png")
    plot_roundings(plt, read_csv(folder / "roundings.csv"), where / "accuracy-rounding.png")


def add_perceptual(folder):
    """The table with SSIM and FLIP; None where their packages cannot be had."""
    python = ENVIRONMENT / "bin/python"
    has_packages = [python, "-c", "import skimage, flip_evaluator"]
    if not python.exists():
        subprocess.run(["python3", "-m", "venv", ENVIRONMENT])
    if not python.exists() or subprocess.run(has_packages, capture_output=True).returncode != 0 and \
            subprocess.run([python, "-m", "pip", "install", "--quiet", "scikit-image", "flip-evaluator"]).returncode != 0:
        say("scikit-image and flip-evaluator could not be installed: no SSIM and FLIP")
        return None
    table = folder / "perceptual.csv"
    output_of(python, REPO / "scripts/study", "perceptual", folder / "study.csv", folder / "pictures", "-o", table)
    return table


def read_rows(path, truth):
    rows = [row for row in read_csv(path) if row["truth"] == truth]
    if not rows:
        fail(f"{path} has no measurement against the {truth} truth; hint: --truth method, or add it to the study's list")
    for row in rows:
        row.update({name: float(row[name]) for name in ("seconds", "rmse", "azimuth", "elevation")})
    return rows


def by_setting(rows, scene):
    """{setting: its rows of the scene}, in the table's order."""
    of = defaultdict(list)
    for row in rows:
        if row["scene"] == scene:
            of[row["setting"]].append(row)
    return of


def print_results(rows):
    """Over a scene's views: RMS of the RMSE, median of the frame times, and means of SSIM and FLIP where the table has them."""
    scenes = {scene: by_setting(rows, scene) for scene in dict.fromkeys(row["scene"] for row in rows)}

    def cell(some):
        parts = [f"{rms(r['rmse'] for r in some):.3g}", f"{1e3 * median(r['seconds'] for r in some):.3g} ms"]
        if some and all(r.get("flip") for r in some):
            parts += [f"{sum(float(r[name]) for r in some) / len(some):.4f}" for name in ("ssim", "flip")]
        return ", ".join(parts)

    print_head("setting", *scenes)
    for setting in dict.fromkeys(row["setting"] for row in rows):
        print_row(setting, *(cell(of[setting]) for of in scenes.values()))


def speed_error(words):
    """Draws what `scripts/study settings` measured: speed against error with the Pareto front marked, and error against the view's angle."""
    arguments = parser(speed_error.__doc__)
    arguments.add_argument("study", help="written by scripts/study settings -o STUDY.csv")
    arguments.add_argument("-o", "--output", type=Path, default=Path("."), metavar="FOLDER")
    arguments.add_argument("--truth", choices=("method", "field"), default="field")
    options = arguments.parse_args(words)
    options.output.mkdir(parents=True, exist_ok=True)
    rows, plt = read_rows(options.study, options.truth), plotting()
    plot_speed_error(plt, rows, options.truth, options.output / f"speed-error-{options.truth}.png")
    plot_angles(plt, rows, options.truth, options.output / f"angle-error-{options.truth}.png")


def plain(value, _):
    return f"{value:g}"


def pareto_front(points):
    """Names of the points {name: (seconds, rmse)} that no other beats in both, fastest first."""
    front, best = [], float("inf")
    for name, (_, rmse) in sorted(points.items(), key=lambda p: p[1]):
        if rmse < best:
            front.append(name)
            best = rmse
    return front


def plot_speed_error(plt, rows, truth, path):
    from matplotlib.ticker import FuncFormatter, LogFormatter

    scenes = sorted({row["scene"] for row in rows})
    settings = list(dict.fromkeys(row["setting"] for row in rows))
    colours = {name: plt.get_cmap("tab20" if k < 20 else "Dark2")(k % 20) for k, name in enumerate(settings)}
    figure, axes = plt.subplots(1, len(scenes), figsize=(4.2 * len(scenes) + 1.6, 4), squeeze=False)
    for axis, scene in zip(axes[0], scenes):
        places = {name: (1e3 * median(r["seconds"] for r in some), rms(r["rmse"] for r in some)) for name, some in by_setting(rows, scene).items()}
        front = pareto_front(places)
        print(f"{scene}: on the front against the {truth} truth: {', '.join(front)}")
        axis.plot(*zip(*(places[name] for name in front)), color="0.5", linewidth=1, zorder=1)
        for name, place in places.items():
            size = {"marker": "*", "markersize": 13} if name in front else {"marker": "o", "markersize": 6}
            axis.plot(*place, color=colours[name], linestyle="none", markeredgecolor="0.2", markeredgewidth=0.4, **size)
        axis.set(title=scene, xlabel="median frame time (ms)", ylabel=f"RMSE against the {truth} truth (1/255)", xscale="log", yscale="log")
        for each in (axis.xaxis, axis.yaxis):
            each.set_major_formatter(FuncFormatter(plain))
            each.set_minor_formatter(LogFormatter(minor_thresholds=(2, 0.7)))
        axis.tick_params(which="both", labelsize=7)
        axis.grid(which="both")
    marks = [plt.Line2D([], [], color=colours[name], marker="o", linestyle="none", label=name) for name in settings]
    marks.append(plt.Line2D([], [], color="0.5", marker="*", markersize=11, label="Pareto front"))
    figure.legend(handles=marks, loc="center right", fontsize=7)
    figure.tight_layout(rect=(0, 0, 1 - 1.5 / figure.get_figwidth(), 1))
    write_figure(figure, path)


def plot_angles(plt, rows, truth, path):
    from matplotlib.ticker import FuncFormatter

    lines = defaultdict(list)
    for row in rows:
        if row["elevation"] == 0:
            lines[row["scene"], row["setting"]].append((row["azimuth"], row["rmse"]))
    lines = {key: sorted(values) for key, values in lines.items() if len(values) > 4}
    if not lines:
        return
    scenes = sorted({scene for scene, _ in lines})
    figure, axes = plt.subplots(1, len(scenes), figsize=(4.5 * len(scenes) + 1.4, 4), squeeze=False)
    for axis, scene in zip(axes[0], scenes):
        for (of_scene, setting), values in sorted(lines.items()):
            if of_scene == scene:
                axis.plot(*zip(*values), label=setting, linewidth=1)
        axis.set(title=scene, xlabel="azimuth (degrees)", ylabel=f"RMSE against the {truth} truth (1/255)", yscale="log")
        axis.yaxis.set_major_formatter(FuncFormatter(plain))
        axis.axvline(45, color="0.5", linestyle=":", linewidth=1)
        axis.grid()
    figure.legend(*axes[0][0].get_legend_handles_labels(), loc="center right")
    figure.tight_layout(rect=(0, 0, 1 - 1.4 / figure.get_figwidth(), 1))
    write_figure(figure, path)


def plot_roundings(plt, rows, path):
    figure, axes = plt.subplots(1, len(PANELS), figsize=(4.2 * len(PANELS), 3.8), layout="constrained")
    for axis, (rounding, (title, x, y)) in zip(axes, PANELS.items()):
        of = [row for row in rows if row["rounding"] == rounding]
        for line in dict.fromkeys(row["line"] for row in of):
            style = {"color": "0.4", "linestyle": "--"} if line == "bound" else {"marker": "o", "markersize": 3}
            # A logarithmic axis has no zero: an exact result is drawn where its line would leave the picture.
            points = [(float(row["size"]), max(float(row["error"]), 1e-17)) for row in of if row["line"] == line]
            axis.plot(*zip(*points), label=line, linewidth=1, **style)
        axis.set(title=title, xlabel=x, ylabel=y, xscale="log", yscale="log")
        low, high = axis.get_ylim()
        if high < 1e3 * low:  # a line that hardly changes is to look so
            axis.set_ylim(low / 30, high * 30)
        axis.grid()
        axis.legend()
    write_figure(figure, path)
