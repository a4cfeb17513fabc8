"""Time and error of sheets' settings, of which --quality's are chosen.

Planes (screen, or slices with 1, 1.5 or 2 samples a voxel), slabs and light points, in six views of the repository's head with mr-soft
and mr-surface, and of VOLUME with TF. Errors are against the field's truth (scripts/study settings), times those of two colocated ranks;
settings take turns. FOLDER keeps both, so that a further call adds rounds only. In bold what no other setting beats in time and error.
"""
import itertools
import json
import os
import statistics
from collections import defaultdict
from pathlib import Path

from .output import median, print_head, print_row, read_csv, rms, write_csv
from .run import AHEAD, COLOCATED, HEAD, REPO, Bench, parser, repeat, say
from .settings import measure_settings

REPEATED = 4  # times each view, of which the first frame of all is left out
SAME_TIME = 1.03  # times that differ less are equal
# Of each slice set two, and all at 45 degrees or beside it.
VIEWS = ("0 0", "20 10", "45 35", "75 -15", "110 -40", "40 65")
PLANES = {"screen": {"image-plane": "screen"}, **{f"slices-{s}": {"image-plane": "slices", "samples": s} for s in (1, 1.5, 2)}}
SETTINGS = {f"{plane}-{slabs}-{points}": {**where, "slabs": slabs, "light-points": points}
            for (plane, where), slabs, points in itertools.product(PLANES.items(), (1, 2, 3), (1, 2))}


def main(words):
    arguments = parser(__doc__)
    repeat(arguments, 3)
    arguments.add_argument("--size", type=int, default=512, metavar="PIXELS")
    arguments.add_argument("folder", nargs="?", default=REPO / "build/qualities", type=Path, metavar="FOLDER")
    arguments.add_argument("other", nargs="*", metavar="VOLUME TF")
    options = arguments.parse_args(words)
    if len(options.other) not in (0, 2):
        arguments.error("a volume needs a transfer function, and only one can be given")
    scenes = {"soft": (str(HEAD), "mr-soft"), "surface": (str(HEAD), "mr-surface")}
    if options.other:
        scenes["other"] = (os.path.realpath(options.other[0]), options.other[1])
    folder = options.folder.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    measure_errors(folder, scenes, options.size)
    for k in range(options.repeat):
        say(f"round {k + 1} of {options.repeat}")
        time_settings(folder, scenes, options.size)
    print_results(folder, scenes)


def list_for_study(scenes, size):
    """What `scripts/study settings` reads."""
    lines = ["repetitions = 1", f'size = "{size}x{size}"', "error_pixels = 4096", 'truths = ["field"]', f"views = {json.dumps(VIEWS)}"]
    for scene, (volume, function) in scenes.items():
        lines += [f"[scene.{scene}]", f"volume = {json.dumps(volume)}", f"tf = {json.dumps(function)}"]
    for name, setting in SETTINGS.items():
        lines += [f'[setting."{name}"]', 'engine = "sheets"', "phong = true"]
        lines += [f"{key.replace('-', '_')} = {json.dumps(value)}" for key, value in setting.items()]
    return "\n".join(lines) + "\n"


def measure_errors(folder, scenes, size):
    listed = folder / "list.toml"
    text = list_for_study(scenes, size)
    if not listed.exists() or listed.read_text() != text:
        for kept in ("errors.csv", "times.csv"):
            (folder / kept).unlink(missing_ok=True)
        listed.write_text(text)
    if not (folder / "errors.csv").exists():
        measure_settings(listed, folder / "errors.csv")


def time_settings(folder, scenes, size):
    times = folder / "times.csv"
    rows = read_csv(times) if times.exists() else []
    with Bench() as bench:
        views = bench.write("views.txt", "".join(view + "\n" for view in VIEWS) * REPEATED)
        for scene, (volume, function) in scenes.items():
            for name, setting in SETTINGS.items():
                words = [word for key, value in setting.items() for word in ("--" + key, value)]
                frames = bench.run(2, volume, "--tf", function, "--size", size, "--fit", "sphere", "--path", views, "--frames-in-flight", 1, *AHEAD,
                                   *COLOCATED, "--shading", "phong", "--engine", "sheets", *words)
                rows += [{"scene": scene, "setting": name, "seconds": frame["seconds"]} for frame in frames[1:]]
    write_csv(times, rows)


def label(setting):
    plane = f"slices, {setting['samples']} samples" if "samples" in setting else "screen"
    return f"{plane}, {setting['slabs']} slabs, {setting['light-points']} light points"


def front(points):
    """The names of those that no other beats in both, of {name: (time, error)}."""
    def beats(a, b):
        return a[1] < b[1] and a[0] < b[0] * SAME_TIME or a[1] <= b[1] and a[0] * SAME_TIME < b[0]
    return {name for name, point in points.items() if not any(beats(other, point) for other in points.values())}


def print_results(folder, scenes):
    seconds, errors = defaultdict(list), defaultdict(list)
    for row in read_csv(folder / "times.csv"):
        seconds[row["scene"], row["setting"]].append(float(row["seconds"]))
    for row in read_csv(folder / "errors.csv"):
        errors[row["scene"], row["setting"]].append(float(row["rmse"]))
    columns = {scene: {name: (1e3 * median(seconds[scene, name]), rms(errors[scene, name])) for name in SETTINGS} for scene in scenes}
    columns["geometric mean"] = {name: tuple(statistics.geometric_mean(columns[scene][name][k] for scene in scenes) for k in (0, 1))
                                 for name in SETTINGS}
    fronts = {column: front(points) for column, points in columns.items()}
    print_head("setting", *(f"{column}: ms a frame, RMSE" for column in columns))
    for name in sorted(SETTINGS, key=lambda name: columns["geometric mean"][name][0]):
        cells = ["{:.1f}, {:.2f}".format(*points[name]) for points in columns.values()]
        print_row(label(SETTINGS[name]), *(f"**{text}**" if name in fronts[column] else text for text, column in zip(cells, columns)))
