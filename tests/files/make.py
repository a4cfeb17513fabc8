#!/usr/bin/env python3
"""Writes the files of tests/files by the libraries that users write theirs with: make.py FOLDER [WRITER...]

Makes a virtual environment in FOLDER/venv with requirements.txt from PyPI, then runs each write_*.py (or those
named) in it, into FOLDER/volumes/WRITER. What has been written by the same scripts and requirements stays.
Exits with 77, and says so, where PyPI cannot be reached.
"""
import hashlib
import pathlib
import shutil
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
SKIPPED = 77


def digest(*files):
    return hashlib.sha256(b"".join(file.read_bytes() for file in files)).hexdigest()


def is_made(stamp, text):
    return stamp.exists() and stamp.read_text() == text


def make_environment(venv):
    requirements = HERE / "requirements.txt"
    stamp = venv / "made"
    if is_made(stamp, digest(requirements)):
        return True
    print(f"installing {requirements.name} into {venv}", flush=True)
    shutil.rmtree(venv, ignore_errors=True)
    python = "/usr/bin/python3" if pathlib.Path("/usr/bin/python3").exists() else sys.executable
    for command in ([python, "-m", "venv", venv],
                    [venv / "bin/pip", "install", "-q", "--disable-pip-version-check", "-r", requirements]):
        if subprocess.run([str(word) for word in command]).returncode != 0:
            return False
    stamp.write_text(digest(requirements))
    return True


def write(writer, folder, venv):
    folder = folder / writer.stem.removeprefix("write_")
    text = digest(writer, HERE / "cases.py", HERE / "requirements.txt")
    if is_made(folder / "made", text):
        return True
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    done = subprocess.run([str(venv / "bin/python"), "-B", str(writer), str(folder)], cwd=HERE)
    if done.returncode == 0:
        (folder / "made").write_text(text)
    return done.returncode == 0


def main():
    target = pathlib.Path(sys.argv[1]).resolve()
    target.mkdir(parents=True, exist_ok=True)
    if not make_environment(target / "venv"):
        print("skipped: the Python packages that write the files cannot be installed", flush=True)
        return SKIPPED
    writers = [HERE / f"write_{name}.py" for name in sys.argv[2:]] or sorted(HERE.glob("write_*.py"))
    failed = [writer.name for writer in writers if not write(writer, target / "volumes", target / "venv")]
    if failed:
        print(f"failed: {', '.join(failed)}", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
