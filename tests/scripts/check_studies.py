#!/usr/bin/env python3
"""Checks that every study starts, says what it does, and builds nothing unasked, and what scripts/study settings measures and refuses.

usage: check_studies.py FOLDER_OF_SCRIPTS SCRATCH BUILD

Exits with 77 where NumPy is missing.
"""
import importlib
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

SCRIPTS, SCRATCH, BUILD = (os.path.abspath(path) for path in sys.argv[1:4])
sys.dont_write_bytecode = True
sys.path.insert(0, SCRIPTS)
from studies.debian import restart_without  # noqa: E402

if missing := restart_without("numpy", in_environments=True):
    print(f"skipped: {missing} is missing")
    sys.exit(77)
from studies.__main__ import STUDIES  # noqa: E402
from studies.output import read_csv  # noqa: E402

LEAST = """repetitions = 2
size = "40"
error_pixels = 300
views = ["20 10", "45 0 5 1.5"]
[scene.one]
synth = "ball"
dims = "20"
tf = "grey"
clip = "3:17,2:20,5:12"
[setting.radius-1.2]
radius = 1.2
opacity_correction = false
[setting.lit]
engine = "sheets"
phong = true
"""
# What is added in front of or behind it, and what is said of it.
WRONG = {
    ("speed = 3\n", ""): "speed is no key",
    ('seed = "many"\n', ""): "seed cannot be 'many'",
    ('truths = ["analytic"]\n', ""): "ringsplat reference --truth analytic",
    ('sweep = "0:90:0"\n', ""): "FROM:TO:STEP",
    ("", "colour = 1\n"): "[setting.lit] is refused by ringsplat: error: '--colour 1' is not expected here",
    ("", "radius = 1.2\n"): "[setting.lit] is refused by ringsplat: error: --radius has no effect on sheets",
    ("", "[scene.two]\ntf = 'grey'\n"): "[scene.two] needs either synth or volume",
    ("", "[scene.two]\nsynth = 'cow'\n"): "[scene.two] is refused by ringsplat: error: 'cow' is not a synthetic volume",
}


def study(*words, build=SCRATCH):
    environment = {**os.environ, "RINGSPLAT_BUILD": build}
    return subprocess.run([os.path.join(SCRIPTS, "study"), *map(str, words)], env=environment, capture_output=True, text=True)


def check_settings(folder):
    listed, table, pictures = (folder / name for name in ("list.toml", "study.csv", "pictures"))
    listed.write_text(LEAST)
    ended = study("settings", listed, "-o", table, "--keep-images", pictures, build=BUILD)
    assert ended.returncode == 0, ended.stderr
    rows, cells = json.loads(table.with_suffix(".json").read_text()), read_csv(table)
    assert [row["setting"] for row in rows] == ["radius-1.2"] * 4 + ["lit"] * 4, "settings and views"
    for row, cell in zip(rows, cells, strict=True):
        assert float(cell["rmse"]) == row["rmse"] and row["rmse_low"] <= row["rmse"] <= row["rmse_high"], row
        assert row["frames"] == 2 and row["seconds"] > 0 and row["splats"] > 0 and row["bytes"] > 0, row
        splats = row["setting"] == "radius-1.2"
        assert (row["engine"], row["radius"], row["slabs"]) == (("splats", 1.2, None) if splats else ("sheets", None, 3)), row
        assert (row["phong"], row["opacity_correction"]) == (not splats, not splats), row
        assert row["rmse"] < (1 if row["truth"] == "method" else 12), row
        for name in (row["picture"], row["truth_picture"]):
            assert not name if row["truth"] == "method" else (pictures / name).is_file(), row
    for (before, behind), said in WRONG.items():
        listed.write_text(before + LEAST + behind)
        ended = study("settings", listed, "-o", table, build=BUILD)
        assert ended.returncode != 0 and f"{listed}: " in ended.stderr and said in ended.stderr, f"{before}{behind}: {ended.stderr}"


def main():
    os.makedirs(SCRATCH, exist_ok=True)
    listed = study("--help").stdout
    for name, (module, function, targets, _) in STUDIES.items():
        assert f"  {name} " in listed, f"{name} is not listed"
        start = getattr(importlib.import_module(f"studies.{module}"), function)
        try:
            sys.stdout = open(os.devnull, "w", encoding="utf-8")
            start(["--help"])
        except SystemExit as ended:
            assert not ended.code, f"{name} --help ends with {ended.code}"
        finally:
            sys.stdout = sys.__stdout__
        if targets:
            asked = study(name)
            assert asked.returncode != 0 and "hint: scripts/study --build" in asked.stderr, f"{name} without a build: {asked.stderr}"
    assert study("nothing").returncode != 0
    assert os.listdir(SCRATCH) == [], "something was built"
    with tempfile.TemporaryDirectory() as folder:
        check_settings(Path(folder))
    print(f"{len(STUDIES)} studies start")


if __name__ == "__main__":
    main()
