#!/usr/bin/env python3
"""Makes the virtual environment in which Python's module is built and tested: make.py FOLDER

It is FOLDER/venv, with requirements.txt from PyPI; one that was made by the same requirements stays. Exits with 77, and
says so, where PyPI cannot be reached.
"""

import hashlib
import pathlib
import shutil
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
SKIPPED = 77


def main():
    folder = pathlib.Path(sys.argv[1]).resolve()
    folder.mkdir(parents=True, exist_ok=True)
    requirements, venv = HERE / "requirements.txt", folder / "venv"
    stamp, digest = venv / "made", hashlib.sha256(requirements.read_bytes()).hexdigest()
    if stamp.exists() and stamp.read_text() == digest:
        return 0
    print(f"installing {requirements} into {venv}", flush=True)
    shutil.rmtree(venv, ignore_errors=True)
    python = "/usr/bin/python3" if pathlib.Path("/usr/bin/python3").exists() else sys.executable
    for command in (
        [python, "-m", "venv", venv],
        [venv / "bin/pip", "install", "-q", "--disable-pip-version-check", "-r", requirements],
    ):
        if subprocess.run([str(word) for word in command]).returncode != 0:
            print("skipped: the packages that Python's module needs cannot be installed", flush=True)
            return SKIPPED
    stamp.write_text(digest)
    return 0


if __name__ == "__main__":
    sys.exit(main())
