"""Measures time and error of many settings: each setting of LIST.toml in each view of each scene.

LIST.toml (without it studies/settings.toml, which --list prints) may have

    repetitions, size, error_pixels, seed   how often each view is timed; render's --size, --error-pixels and --error-seed
    truths                                  "method", "field" (docs/accuracy.md)
    views, sweep                            "AZIMUTH ELEVATION [ROLL [ZOOM]]" each; in addition azimuths "FROM:TO:STEP"
    [scene.NAME]                            synth, a test volume, with dims and type; or volume, a file
    [setting.NAME]                          without engine and quality the paper's splats, without phong = true unlit

All other keys of scenes and settings are options of ringsplat render: image_plane = "slices" is --image-plane slices, true a flag, and
opacity_correction = false is --no-opacity-correction. STUDY.csv, and STUDY.json beside it, have a row for each setting, view and truth:
the median time of frames drawn one by one on one thread, what was sent, and the error on error_pixels pixels.
"""
import json
import math
import re
import subprocess
import tempfile
from pathlib import Path

from .output import median, whole_file, write_csv
from .run import PROGRAM, fail, parser, read_frames, say

DEFAULT_LIST = Path(__file__).with_name("settings.toml")
KEYS = {"repetitions": 5, "size": "256x256", "error_pixels": 4096, "seed": 1, "truths": ["method", "field"], "views": [], "sweep": "",
        "scene": {}, "setting": {}}
HINT = "hint: scripts/study settings --list prints a list that works"
# Columns: of a frame's settings, and of its error.
HOW = ("engine", "image_plane", "plane_samples", "radius", "slabs", "light_points",
       "adaptive", "opacity_correction")
ERROR = ("truth", "pixels", "rmse", "rmse_low", "rmse_high", "largest", "mean")
LIGHT = ("shading", "light", "ambient", "diffuse", "specular", "exponent")


def main(words):
    arguments = parser(__doc__)
    arguments.add_argument("path", nargs="?", type=Path, default=DEFAULT_LIST, metavar="LIST.toml")
    arguments.add_argument("-o", "--output", type=Path, metavar="STUDY.csv")
    arguments.add_argument("--keep-images", type=Path, metavar="FOLDER", help="keep pictures and the field's truths as PNG; the table names them")
    arguments.add_argument("--list", action="store_true", help="print the default list")
    options = arguments.parse_args(words)
    if options.list:
        print(DEFAULT_LIST.read_text(encoding="utf-8"), end="")
    elif options.output is None or options.output.suffix != ".csv":
        arguments.error("-o names the table to write: for instance -o study.csv")
    else:
        measure_settings(options.path, options.output, options.keep_images)


def measure_settings(path, output, pictures=None):
    """Writes the table, and the same as JSON."""
    output.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        rows = Study(path, Path(folder), pictures).rows()
    write_csv(output, [{name: value if isinstance(value, str | None) else json.dumps(value) for name, value in row.items()} for row in rows])
    with whole_file(output.with_suffix(".json")) as beside:
        Path(beside).write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
    say(f"{output}: {len(rows)} measurements")


def named(table, prefix=""):
    """{name: its keys} of all [scene.NAME]; names may contain dots."""
    own = {key.replace("_", "-"): value for key, value in table.items() if not isinstance(value, dict)}
    found = {prefix: own} if own or not table else {}
    for key, value in table.items():
        if isinstance(value, dict):
            found |= named(value, f"{prefix}.{key}" if prefix else key)
    return found


def words_of(options):
    words = []
    for key, value in options.items():
        if value is not False:
            words += ["--" + key, *([] if value is True else map(str, value if isinstance(value, list) else [value]))]
    return words


def numbers(text, between=None):
    try:
        found = [float(word) for word in str(text).split(between)]
    except ValueError:
        return []
    return found if all(map(math.isfinite, found)) else []


def as_file_name(name):
    return re.sub(r"^\.", "-.", re.sub(r"[^A-Za-z0-9._-]", "-", name))


class Study:
    """What a list says, and what is measured of it; `folder` is for files that nobody keeps."""

    def __init__(self, path, folder, pictures):
        self.path, self.folder, self.pictures, self.truths_kept = path, folder, pictures, set()
        of = KEYS | self.read()
        self.repetitions, self.size, self.truths = of["repetitions"], of["size"], of["truths"]
        self.sampling = ("--error-pixels", of["error_pixels"], "--error-seed", of["seed"])
        self.views = self.views_of(of["views"], of["sweep"])
        if not (of["scene"] and of["setting"] and self.views and self.truths and self.repetitions > 0):
            self.refuse(f"there must be at least one scene, setting, view, truth and repetition; {HINT}")
        self.settings = {name: self.setting_of(f"[setting.{name}]", setting) for name, setting in named(of["setting"]).items()}
        self.check_settings()
        self.scenes = {name: self.scene_of(name, scene) for name, scene in named(of["scene"]).items()}

    def refuse(self, problem):
        fail(f"{self.path}: {problem}")

    def ask(self, section, *command):
        """Runs the program, whose refusal ends the study."""
        ended = subprocess.run([str(word) for word in (PROGRAM, *command)], capture_output=True, text=True)
        if ended.returncode != 0:
            self.refuse(f"{section} is refused by {ended.stderr.strip()}")

    def read(self):
        import tomllib  # Python 3.11

        try:
            found = tomllib.loads(self.path.read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            self.refuse(f"this cannot be read as TOML: {error}; {HINT}")
        for key, value in found.items():
            if key not in KEYS:
                self.refuse(f"{key} is no key of a list; {HINT}")
            if type(value) is not type(KEYS[key]):
                self.refuse(f"{key} cannot be {value!r}; {HINT}")
        return found

    def views_of(self, views, sweep):
        """Lines of a --path."""
        for view in views:
            if len(numbers(view)) not in (2, 3, 4):
                self.refuse(f"views cannot have {view!r}: give azimuth and elevation [roll [zoom]]")
        if not sweep:
            return views
        ends = numbers(sweep, ":")
        if len(ends) != 3 or ends[2] <= 0 or (ends[1] - ends[0]) / ends[2] > 1e5:
            self.refuse(f"sweep cannot be {sweep!r}: give FROM:TO:STEP")
        first, last, step = ends
        return [*views, *(f"{first + k * step} 0" for k in range(math.floor((last - first) / step + 1e-9) + 1))]

    def setting_of(self, section, setting):
        """The options that a section's keys mean."""
        for key in ("phong", "opacity-correction"):
            if not isinstance(setting.get(key, True), bool):
                self.refuse(f"{section} {key} is neither true nor false")
        setting = {"shading": "phong" if setting.pop("phong", False) else "none", **setting}
        setting["no-opacity-correction"] = not setting.pop("opacity-correction", True)
        return setting if setting.keys() & {"engine", "quality"} else {"quality": "paper", **setting}

    def check_settings(self):
        """Draws a small ball with each setting, so that no study ends half-way."""
        ball = self.folder / "ball.nrrd"
        self.ask("ball", "synth", "ball", "--dims", 8, "-o", ball)
        for name, setting in self.settings.items():
            for truth in self.truths:
                self.render(f"[setting.{name}]", [ball, *words_of(setting)], self.views[:1], "--size", 8, "--error", truth, *self.sampling)

    def scene_of(self, name, scene):
        """The volume and the options of a scene, which is drawn once."""
        section, synth, volume = f"[scene.{name}]", scene.pop("synth", None), scene.pop("volume", None)
        if (synth is None) == (volume is None):
            self.refuse(f"{section} needs either synth or volume")
        if synth is not None:
            volume = self.folder / f"{as_file_name(name)}.nrrd"
            self.ask(section, "synth", synth, "-o", volume, *words_of({key: scene.pop(key) for key in ("dims", "type") if key in scene}))
        words = [volume, *words_of(scene), "--size", self.size]
        self.render(section, words, self.views[:1])
        return words

    def render(self, section, words, views, *options):
        """The frames' statistics."""
        stats = self.folder / "stats.json"
        self.ask(section, "render", *words, *self.along(views), "--stats", stats, *options)
        return read_frames(stats)

    def along(self, views):
        path = self.folder / "views.txt"
        path.write_text("\n".join(views) + "\n", encoding="utf-8")
        return "--path", path

    def rows(self):
        rows = []
        for scene in self.scenes:
            for setting in self.settings:
                say(f"{scene}, {setting}")
                rows += self.measure(scene, setting)
        return rows

    def measure(self, scene, setting):
        section, words = f"[scene.{scene}] with [setting.{setting}]", [*self.scenes[scene], *words_of(self.settings[setting])]
        frames = self.render(section, words, self.views * self.repetitions, "--threads-per-rank", 1, "--frames-in-flight", 1)
        measured = {truth: self.render(section, words, self.views, "--error", truth, *self.sampling) for truth in self.truths}
        kept = self.keep(section, words, scene, setting) if self.pictures and "field" in self.truths else {}
        return [{"scene": scene, "setting": setting, **columns_of(frames[k::len(self.views)]),
                 **{name: measured[truth][k]["error"][name] for name in ERROR},
                 **{column: kept[column][k] if kept and truth == "field" else "" for column in ("picture", "truth_picture")}}
                for k in range(len(self.views)) for truth in self.truths]

    def keep(self, section, words, scene, setting):
        """Keeps pictures, and the field's truths, which settings share that are lit alike. Returns both's names below the folder."""
        folder = self.pictures / as_file_name(scene)
        folder.mkdir(parents=True, exist_ok=True)
        light = {key: value for key, value in self.settings[setting].items() if key in LIGHT}
        picture, truth = (folder / (as_file_name(name) + ".png") for name in (setting, "-".join(map(str, ["truth-field", *light.values()]))))
        self.render(section, words, self.views, "--background", "black", "-o", picture)
        if truth not in self.truths_kept:
            self.ask(section, "reference", *self.scenes[scene], *words_of(light), *self.along(self.views), "--background", "black", "-o", truth)
            self.truths_kept.add(truth)
        return {column: [str(file.relative_to(self.pictures).with_stem(f"{file.stem}-{k:04}")) for k in range(len(self.views))]
                for column, file in (("picture", picture), ("truth_picture", truth))}


def columns_of(frames):
    """What a view's frames have in common."""
    last = frames[-1]
    settings, total = last["settings"], last["total"]
    camera = settings["camera"]
    return {**{name: settings.get(name) for name in HOW}, "phong": settings["shading"] == "phong",
            **{name: camera[name] for name in ("azimuth", "elevation", "roll", "zoom")}, "axis": last["traversal"]["axis"],
            "seconds": median(frame["seconds"] for frame in frames), "frames": len(frames), "splats": total["splats_sent"],
            "bytes": total["payload_bytes_sent"]}
