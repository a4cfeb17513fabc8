"""What studies share: the program, ranks to start it on, and the statistics that it writes."""
import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from .output import median

REPO = Path(__file__).resolve().parents[2]
BUILD = Path(os.environ.get("RINGSPLAT_BUILD") or REPO / "build/release")
PROGRAM = BUILD / "ringsplat"
HEAD = REPO / "tests/data/head.nrrd"
MACHINES = REPO / "mpi_configs/machines"
MPIEXEC = os.environ.get("RINGSPLAT_MPIEXEC", "mpirun")
FILES = {"ringsplat_cli": "ringsplat", "ringsplat_smpi": "ringsplat_smpi.so", "ringsplat_platform": "ringsplat_platform.so",
         "sort_last_smpi": "sort_last_smpi.so"}

# What --frames-in-flight 1 leaves to run ahead: slices, payloads and tokens.
AHEAD = ("--look-ahead", 4, "--slots", 16, "--send-ahead", 16)
# What two ranks do.
DEDICATED = ("--gps", 1, "--renderers", 1)
COLOCATED = ("--roles", "colocated", "--gps", 2, "--renderers", 2)


def say(text):
    print(f"ringsplat: {text}", file=sys.stderr, flush=True)


def fail(text):
    sys.exit(f"ringsplat: {text}")


def parser(doc):
    return argparse.ArgumentParser(description=doc, formatter_class=argparse.RawDescriptionHelpFormatter)


def count(text):
    """An argument that is a number of times."""
    if not text.isdigit() or int(text) == 0:
        raise argparse.ArgumentTypeError(f"'{text}' is no number of times")
    return int(text)


def repeat(arguments, default):
    arguments.add_argument("--repeat", type=count, default=default, metavar="N", help=f"how often all is measured (default {default})")


def shell(command, *words):
    """The words that run one of scripts/lib.sh's functions."""
    return ["bash", "-c", f'source "{REPO}/scripts/lib.sh"; {command} "$@"', command, *map(str, words)]


def build(*targets):
    if BUILD != REPO / "build/release":
        fail("--build is for build/release, not for what RINGSPLAT_BUILD names")
    if targets and subprocess.run(shell("build_ringsplat", *targets)).returncode != 0:
        fail(f"this could not be built: {' '.join(targets)}")


def need(study, *targets):
    """Studies build nothing unasked."""
    missing = [target for target in targets if not (BUILD / FILES.get(target, target)).exists()]
    if missing:
        fail(f"{BUILD} has no {', '.join(FILES.get(target, target) for target in missing)}; hint: scripts/study --build {study}, "
             f"or cmake --preset release && cmake --build --preset release --target {' '.join(missing)}")


def output_of(*command, **how):
    """What a command printed. Ends the study when it fails."""
    ended = subprocess.run([str(word) for word in command], capture_output=True, text=True, **how)
    if ended.returncode != 0:
        fail(f"this failed: {' '.join(map(str, command))}\n{ended.stdout}{ended.stderr}")
    return ended.stdout


def program(*arguments):
    return output_of(PROGRAM, *arguments)


def on_ranks(ranks, *command):
    """The words that start a command on so many ranks of this machine; 0: without a launcher."""
    return shell("run_ranks", ranks, *command) if ranks else list(command)


def read_json(path):
    """One JSON document, or the objects of a .jsonl."""
    try:
        text = Path(path).read_text(encoding="utf-8")
        if str(path).endswith(".jsonl"):
            return [json.loads(line) for line in text.splitlines() if line.strip()]
        return json.loads(text)
    except (OSError, ValueError) as error:
        fail(f"{path} cannot be read as JSON: {error}")


def read_frames(path):
    """The frames of a --stats file."""
    frames = read_json(path)
    return frames if isinstance(frames, list) else [frames]


def nodes(frame, role):
    return [node for node in frame["nodes"] if node["node"].startswith(role)]


def node_seconds(frame, role, *parts):
    return sum(node["seconds"][part] for node in nodes(frame, role) for part in parts)


class Bench:
    """Runs of the program by name, whose frames are kept in a folder that goes at the end."""

    def __enter__(self):
        self.folder = Path(tempfile.mkdtemp())
        self.line = ()
        self.others = []
        return self

    def __exit__(self, *_):
        for other in self.others:
            other.kill()
        shutil.rmtree(self.folder)

    def busy(self, processes):
        """Keeps so many processes busy with something else."""
        self.others = [subprocess.Popen(("sh", "-c", "while :; do :; done")) for _ in range(processes)]

    def path(self, name):
        return self.folder / name

    def write(self, name, text):
        self.path(name).write_text(text, encoding="utf-8")
        return self.path(name)

    def transfer_function(self, name, *points):
        """A grey one, from values and opacities."""
        flat = [number for value, opacity in points for number in (value, opacity, 0.5, 0)]
        return self.write(name + ".json", json.dumps([{"Name": name, "ColorSpace": "RGB", "NanColor": [1, 0, 0],
                                                       "RGBPoints": [0, 0, 0, 0, 255, 1, 1, 1], "Points": flat}]))

    def make_line(self, slices):
        """Options that render 2 x 2 voxels a slice with a transfer function that shows the value between theirs. A token goes through
        every slice, because each might show something, and frames cost only that."""
        header = f"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 {slices}\nencoding: ascii\n\n"
        volume = self.write("line.nrrd", header + "0 2 2 0\n" * slices)
        function = self.transfer_function("gap", (0, 0), (1, 1), (2, 0))
        return volume, "--tf", function, "--size", 64, "--elevation", 90

    def run(self, ranks, *options):
        """The frames of one run, a thread a rank, so that figures are of one core."""
        stats = self.path("one.jsonl")
        output_of(*on_ranks(ranks, PROGRAM, "render", *options, "--stats", stats))
        return read_frames(stats)

    def render(self, ranks, name, *options, quality="paper"):
        """Adds the frames of a run to those of the name."""
        frames = self.run(ranks, "--quality", quality, "--threads-per-rank", 1, *options)
        with open(self.path(name + ".jsonl"), "a", encoding="utf-8") as file:
            file.writelines(json.dumps(frame) + "\n" for frame in frames)

    def frames(self, name, first=1):
        """Of all runs of the name; without each run's first frames, which still allocate."""
        return [frame for frame in read_frames(self.path(name + ".jsonl")) if frame["frame"] >= first]

    def by_run(self, name):
        """As frames(), a list for each run."""
        runs = []
        for frame in self.frames(name, 0):
            if frame["frame"] == 0:
                runs.append([])
            else:
                runs[-1].append(frame)
        return runs

    def median(self, name, of, first=1):
        return median(of(frame) for frame in self.frames(name, first))
