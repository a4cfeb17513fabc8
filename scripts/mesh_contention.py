#!/usr/bin/env python3
"""How long payloads wait for one another on a mesh's links, and what that costs a frame:  scripts/mesh_contention.py

Simulates a frame with its tokens moving freely, freely on links where nothing waits for anything, and in step: the head on meshes of
Pixel-Planes 5's nodes, and the cube of scripts/scaling_study.py on a larger one. Prints a Markdown table; sums are over payloads. Takes some minutes.
"""
import csv
import os
import re
import sys
import tempfile

from scaling_study import FROM_ABOVE, Study
from simulation import HEAD, MACHINES, build, simulate

VIEW = ["--size", "256x256", "--elevation", "20", "--azimuth", "30", "--fit", "sphere", "--tf", "mr-soft", "--count-only", "--shading", "none"]


def table_of(path):
    with open(path, encoding="utf-8") as file:
        return list(csv.DictReader(file))


def measure(folder, arguments, machine, mesh, renderers, step_seconds=0, uncontended=False):
    files = {name: os.path.join(folder, name + ".csv") for name in ("links", "transfers")}
    settings = {"machine": machine, "topology": "mesh", "mesh": mesh, "renderers": renderers, "routing": "direct", "frames-in-flight": 1}
    if step_seconds:
        settings["step-seconds"] = step_seconds
    frame = simulate(settings, *arguments, monitors={**files, **({"uncontended": "1"} if uncontended else {})})[0]
    transfers = table_of(files["transfers"])
    waits = [float(t["taken"]) - float(t["alone"]) for t in transfers]
    return {"seconds": frame["seconds"], "payloads": len(waits), "slowed": sum(w > 1e-9 for w in waits), "waiting": sum(waits),
            "longest": max(waits), "alone": sum(float(t["alone"]) for t in transfers),
            "met": sum(int(link["overlaps"]) for link in table_of(files["links"]))}


def in_step(*job):
    """The shortest of these steps in which no payload meets another."""
    for milliseconds in (5, 6, 8, 10, 15, 20, 30, 50):
        measured = measure(*job, step_seconds=milliseconds / 1e3)
        if measured["met"] == 0:
            return f"in step, {milliseconds} ms", measured
    sys.exit("payloads meet in steps of 50 ms too")


def with_bandwidth(folder, machine, bandwidth):
    """The machine with other links."""
    with open(os.path.join(MACHINES, machine), encoding="utf-8") as file:
        text = file.read()
    path = os.path.join(folder, f"{bandwidth:g}-{machine}")
    with open(path, "w", encoding="utf-8") as file:
        file.write(re.sub(r"^bandwidth = .*", f"bandwidth = {bandwidth:g}", text, flags=re.MULTILINE))
    return path


def report(name, bandwidth, tokens, m):
    speed = f"{bandwidth / 1e9:g} GB/s" if bandwidth >= 1e9 else f"{bandwidth / 1e6:g} MB/s"
    print(f"| {name} | {speed} | {tokens} | {1e3 * m['seconds']:.1f} | {m['payloads']:,} | {m['slowed']:,} | {1e3 * m['alone']:.1f} "
          f"| {1e3 * abs(m['waiting']):.2f} | {1e3 * m['longest']:.2f} |", flush=True)


def rows(folder, volume, machine, bandwidth, mesh, renderers, steps):
    job = (folder, volume, with_bandwidth(folder, machine, bandwidth), mesh, renderers)
    name = f"{mesh} + {renderers}"
    report(name, bandwidth, "free", measure(*job))
    report(name, bandwidth, "free, uncontended", measure(*job, uncontended=True))
    if steps:
        report(name, bandwidth, *in_step(*job))


def main():
    build()
    print("| mesh | links | tokens | ms a frame | payloads | slowed | transfers alone, ms | waiting, ms | longest, ms |\n" + "|---" * 9 + "|", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        for mesh, renderers, region in (("4x4", 8, 64), ("8x8", 16, 32)):
            head = [HEAD, *VIEW, "--region", region, "--payload", "words"]
            for bandwidth in (80e6, 10e6):
                rows(folder, head, "pixel-planes-5-mesh.toml", bandwidth, mesh, renderers, steps=True)
        ball = Study(folder, folder, 1024).volume(1024, 1024, True) + FROM_ABOVE
        for bandwidth in (12.5e9, 1.25e9):
            rows(folder, ball, "mesh.toml", bandwidth, "16x16", 31, steps=False)


if __name__ == "__main__":
    main()
