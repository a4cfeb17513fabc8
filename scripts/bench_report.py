#!/usr/bin/env python3
"""Tables of scripts/bench.sh: bench_report.py FOLDER reads the --stats lines it wrote."""
import json
import statistics
import sys
from pathlib import Path


def frames(folder: Path, name: str) -> list[dict]:
    """A run's frames without each run's first, which still allocates."""
    lines = (folder / f"{name}.jsonl").read_text().splitlines()
    return [f for f in map(json.loads, lines) if f["frame"] > 0]


def median(values) -> float:
    return statistics.median(list(values))


def node_seconds(frame: dict, role: str, *parts: str) -> float:
    return sum(n["seconds"][p] for n in frame["nodes"] if n["node"].startswith(role) for p in parts)


def rates(folder: Path) -> None:
    print("| picture | Renderer: M splats/s | of it compositing | GP: M visible voxels/s | GP: M voxels/s | splats | MB a frame |")
    print("|---|---|---|---|---|---|---|")
    for size in (256, 512, 1024):
        rows = frames(folder, f"draw-{size}")
        splats = [f["total"]["splats_drawn"] for f in rows]
        drawing = [node_seconds(f, "Renderer", "drawing", "compositing") for f in rows]
        compositing = [node_seconds(f, "Renderer", "compositing") for f in rows]
        computing = [node_seconds(f, "GP", "computing") for f in rows]
        visible = [f["total"]["visible_voxels"] for f in rows]
        voxels = 128 * 128 * 124
        print(
            f"| {size}² | {median(s / t for s, t in zip(splats, drawing)) / 1e6:.1f} "
            f"| {100 * median(c / t for c, t in zip(compositing, drawing)):.0f} % "
            f"| {median(v / t for v, t in zip(visible, computing)) / 1e6:.1f} "
            f"| {median(voxels / t for t in computing) / 1e6:.0f} "
            f"| {median(splats):,.0f} | {median(f['total']['payload_bytes_sent'] for f in rows) / 1e6:.1f} |"
        )


def hops(folder: Path) -> None:
    print("\n| ranks | µs a token hop |\n|---|---|")
    for path in sorted(folder.glob("hop-*.jsonl"), key=lambda p: int(p.stem.split("-")[1])):
        rows = frames(folder, path.stem)
        print(f"| {path.stem.split('-')[1]} | {1e6 * median(f['seconds'] / (f['traversal']['slices'] - 1) for f in rows):.2f} |")


def layouts(folder: Path) -> None:
    # One frame in flight: from the announcement to the last tile, nothing else going on.
    print("\n| picture | GPs + Renderers on this machine | ms a frame | against 1 + 1 |\n|---|---|---|---|")
    for size in (256, 512):
        base = None
        for name in ("1+1", "12+4"):
            seconds = 1e3 * median(f["seconds"] for f in frames(folder, f"layout-{size}-{name}"))
            base = base or seconds
            print(f"| {size}² | {name.replace('+', ' + ')} | {seconds:.1f} | {seconds / base:.2f} |")


if __name__ == "__main__":
    where = Path(sys.argv[1])
    rates(where)
    layouts(where)
    hops(where)
