#!/usr/bin/env python3
"""Tables of scripts/bench_ranks.sh: bench_ranks_report.py FOLDER reads the --stats lines and seconds it wrote."""
import json
import statistics
import sys
from pathlib import Path


class Runs:
    """The repetitions of one command."""

    def __init__(self, folder: Path, name: str) -> None:
        frames = [[json.loads(line) for line in file.read_text().splitlines()] for file in folder.glob(f"{name}-[0-9].jsonl")]
        # The first frame still allocates.
        self.picture = statistics.median(statistics.mean(f["period"] for f in run[1:]) for run in frames)
        self.whole = statistics.median(float(file.read_text()) for file in folder.glob(f"{name}-[0-9].seconds"))
        layout = frames[0][0]["layout"]
        self.ranks, self.idle = layout["ranks"], layout["idle"]
        self.nodes = f"{layout['gps']} + {layout['renderers']}" + (" colocated" if layout["roles"] == "colocated" else "")


def typed(folder: Path) -> None:
    print("| `ringsplat render tests/data/head.nrrd --orbit 24 -o x.png` | works as | ms a picture | of one process | s in all |\n|---|---|---|---|---|")
    for quality, option in (("best", ""), ("paper", " `--quality paper`")):
        alone = Runs(folder, f"typed-{quality}-0")
        for ranks in (0, 2, 4, 16, 64):
            runs = Runs(folder, f"typed-{quality}-{ranks}")
            launch = f"`mpirun -n {ranks}{' --oversubscribe' if ranks > 2 else ''}`" if ranks else "one process"
            nodes = f"{runs.nodes}, {runs.idle} idle" if runs.idle else runs.nodes
            print(f"| {launch}{option} | {nodes if ranks else 'all cores'} | {1e3 * runs.picture:.1f} "
                  f"| {runs.picture / alone.picture:.2f} | {runs.whole:.2f} |")


def configs(folder: Path) -> None:
    print("\n| configuration | ranks | GPs + Renderers | ms a picture |\n|---|---|---|---|")
    for file in sorted(folder.glob("config-*-0.jsonl")):
        name = file.stem.removesuffix("-0")
        runs = Runs(folder, name)
        print(f"| `{name.removeprefix('config-')}.toml` | {runs.ranks} | {runs.nodes} | {1e3 * runs.picture:.1f} |")


if __name__ == "__main__":
    work = Path(sys.argv[1])
    if list(work.glob("typed-*")):
        typed(work)
    if list(work.glob("config-*")):
        configs(work)
