#!/usr/bin/env python3
"""What scripts/qualities.sh needs computed:

qualities_study.py list LIST.toml SIZE [VOLUME TF]    the list with pictures of that size, and a scene "other" of the volume
qualities_study.py times FOLDER COMMAND...            times each setting of FOLDER/list.toml once, with a command that starts the
                                                      program on two ranks, and adds the frames to FOLDER/times.csv
qualities_study.py table FOLDER                       a Markdown table of these times and of FOLDER/errors.csv
"""
import csv
import json
import math
import re
import statistics
import subprocess
import sys
import tempfile
import tomllib
from collections import defaultdict
from pathlib import Path

# What --frames-in-flight 1 leaves to run ahead, and what two ranks do.
RUN = ["--frames-in-flight", 1, "--look-ahead", 4, "--slots", 16, "--send-ahead", 16, "--roles", "colocated", "--gps", 2, "--renderers", 2]
REPEATED = 4  # times each view, of which the first frame of all is left out
SAME_TIME = 1.03  # times that differ less are equal


def read_list(folder):
    with open(folder / "list.toml", "rb") as file:
        return tomllib.load(file)


def print_list(path, size, volume=None, function=None):
    print(re.sub(r"(?m)^size = .*$", f'size = "{size}x{size}"', Path(path).read_text(encoding="utf-8")), end="")
    if volume is not None:
        print(f"[scene.other]\nvolume = {json.dumps(volume)}\ntf = {json.dumps(function)}")


def options_of(setting):
    yield from ("--shading", "phong" if setting.get("phong") else "none")
    for key in ("engine", "quality", "image_plane", "samples", "slabs", "light_points"):
        if key in setting:
            yield from ("--" + key.replace("_", "-"), setting[key])


def time_settings(folder, command):
    study = read_list(folder)
    new = not (folder / "times.csv").exists()
    with tempfile.TemporaryDirectory() as work, open(folder / "times.csv", "a", newline="", encoding="utf-8") as file:
        out = csv.writer(file)
        if new:
            out.writerow(["scene", "setting", "seconds"])
        views, stats = Path(work, "views.txt"), Path(work, "stats.json")
        views.write_text("".join(view + "\n" for view in study["views"]) * REPEATED, encoding="utf-8")
        for scene, shown in study["scene"].items():
            for name, setting in study["setting"].items():
                words = [*command, "render", shown["volume"], "--tf", shown["tf"], "--size", study["size"], "--fit", "sphere",
                         "--path", views, *RUN, *options_of(setting), "--stats", stats]
                ended = subprocess.run([str(word) for word in words], capture_output=True, text=True)
                if ended.returncode != 0:
                    sys.exit(f"{name} of {scene} failed:\n{ended.stdout}{ended.stderr}")
                for frame in json.loads(stats.read_text(encoding="utf-8"))[1:]:
                    out.writerow([scene, name, frame["seconds"]])
                file.flush()


def read_errors(folder):
    """RMS over the views, by scene and setting."""
    squares = defaultdict(list)
    with open(folder / "errors.csv", newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            squares[row["scene"], row["setting"]].append(float(row["rmse"]) ** 2)
    return {key: math.sqrt(statistics.mean(values)) for key, values in squares.items()}


def read_times(folder):
    """The median in milliseconds, by scene and setting."""
    seconds = defaultdict(list)
    with open(folder / "times.csv", newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            seconds[row["scene"], row["setting"]].append(float(row["seconds"]))
    return {key: 1e3 * statistics.median(values) for key, values in seconds.items()}


def label(setting):
    plane = "screen" if setting["image_plane"] == "screen" else f"slices, {setting['samples']} samples"
    return f"{plane}, {setting['slabs']} slabs, {setting['light_points']} light points"


def front(points):
    """The names of those that no other beats in both, of {name: (time, error)}."""
    def beats(a, b):
        return a[1] < b[1] and a[0] < b[0] * SAME_TIME or a[1] <= b[1] and a[0] * SAME_TIME < b[0]
    return {name for name, point in points.items() if not any(beats(other, point) for other in points.values())}


def print_table(folder):
    study, errors, times = read_list(folder), read_errors(folder), read_times(folder)
    scenes = list(study["scene"])
    columns = {scene: {name: (times[scene, name], errors[scene, name]) for name in study["setting"]} for scene in scenes}
    columns["geometric mean"] = {name: tuple(statistics.geometric_mean(columns[scene][name][k] for scene in scenes) for k in (0, 1))
                                 for name in study["setting"]}
    fronts = {column: front(points) for column, points in columns.items()}
    print("| setting | " + " | ".join(f"{column}: ms a frame, RMSE" for column in columns) + " |")
    print("|---" * (len(columns) + 1) + "|")
    for name in sorted(study["setting"], key=lambda name: columns["geometric mean"][name][0]):
        cells = []
        for column, points in columns.items():
            text = "{:.1f}, {:.2f}".format(*points[name])
            cells.append(f"**{text}**" if name in fronts[column] else text)
        print(f"| {label(study['setting'][name])} | " + " | ".join(cells) + " |")


def main():
    match sys.argv[1:]:
        case ["list", path, size]:
            print_list(path, size)
        case ["list", path, size, volume, function]:
            print_list(path, size, volume, function)
        case ["times", folder, *command] if command:
            time_settings(Path(folder), command)
        case ["table", folder]:
            print_table(Path(folder))
        case _:
            sys.exit(__doc__)


if __name__ == "__main__":
    main()
