#!/usr/bin/env python3
"""Finds what waiting takes ranks that share cores: fit_waiting.py FOLDER MACHINE.toml puts message.wake into the machine.

It is such that frames of more ranks than cores, which scripts/calibrate.sh timed (shared-GPS-RENDERERS.jsonl), take as long simulated, in the
median of their layouts.
"""
import os
import re
import statistics
import sys
import tempfile
from pathlib import Path

from bench_report import frames
from simulation import HEAD, build, simulate

VIEW = ("--tf", "mr-soft", "--size", "512x512", "--orbit", "8", "--elevation", "25", "--axes", "all")
LONGEST = 2e-3


def typical(shown):
    return statistics.median(f["seconds"] for f in shown)


def with_wake(machine, seconds):
    return re.sub(r"(?m)^(receive = .*)$", rf"\1\nwake = {seconds:.3g}", machine, count=1)


def main():
    folder, path = sys.argv[1:3]
    build()
    with open(path, encoding="utf-8") as file:
        machine = file.read()
    real = {}
    for name in sorted(os.listdir(folder)):
        if match := re.fullmatch(r"shared-(\d+)-(\d+)\.jsonl", name):
            real[tuple(map(int, match.groups()))] = typical(frames(Path(folder), match[0].removesuffix(".jsonl")))

    def ratio(seconds):
        """Of simulated to real."""
        with tempfile.TemporaryDirectory() as work:
            described = os.path.join(work, "machine.toml")
            with open(described, "w", encoding="utf-8") as file:
                file.write(with_wake(machine, seconds))
            return statistics.median(
                typical(simulate({"machine": described, "frames-in-flight": 1, "gps": gps, "renderers": renderers}, HEAD, "--count-only", *VIEW)[1:])
                / taken for (gps, renderers), taken in real.items())

    wake, low, high = 0.0, 0.0, 20e-6
    if ratio(0) < 1:
        while ratio(high) < 1 and high < LONGEST:
            low, high = high, 2 * high
        for _ in range(5):
            wake = 0.5 * (low + high)
            low, high = (wake, high) if ratio(wake) < 1 else (low, wake)
    with open(path + ".part", "w", encoding="utf-8") as file:
        file.write(with_wake(machine, wake))
    os.replace(path + ".part", path)
    print(f"ranks that wait on shared cores: {1e6 * wake:.0f} µs", file=sys.stderr)


if __name__ == "__main__":
    main()
