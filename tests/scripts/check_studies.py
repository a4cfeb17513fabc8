#!/usr/bin/env python3
"""Checks that every study starts, says what it does, and builds nothing unasked; exits with 77 where NumPy is missing.

usage: check_studies.py FOLDER_OF_SCRIPTS SCRATCH
"""
import importlib
import os
import subprocess
import sys

SCRIPTS, SCRATCH = (os.path.abspath(path) for path in sys.argv[1:3])
DEBIANS = "/usr/bin/python3"
try:
    import numpy  # noqa: F401
except ImportError:
    # Debian's NumPy belongs to Debian's own Python.
    if os.access(DEBIANS, os.X_OK) and os.path.realpath(DEBIANS) != os.path.realpath(sys.executable):
        os.execv(DEBIANS, [DEBIANS, "-B", *sys.argv])
    print("skipped: NumPy is missing")
    sys.exit(77)

sys.dont_write_bytecode = True
sys.path.insert(0, SCRIPTS)
from studies.__main__ import STUDIES  # noqa: E402


def study(*words):
    environment = {**os.environ, "RINGSPLAT_BUILD": SCRATCH}
    return subprocess.run([os.path.join(SCRIPTS, "study"), *words], env=environment, capture_output=True, text=True)


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
    print(f"{len(STUDIES)} studies start")


if __name__ == "__main__":
    main()
