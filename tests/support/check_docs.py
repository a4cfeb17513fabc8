#!/usr/bin/env python3
"""Checks what *.md files say:  check_docs.py REPOSITORY PROGRAM

Lines are no wider than 120 columns, README.md's 100 (it has no more than 120 lines); of tables, which cannot be broken, only README.md's.
Links lead to files and headings that are there, and sources and scripts that are named as code are there. docs/options.md is what docs/option_page.py makes of the program's manual page, and
options that are named as code are the program's.
"""
import os
import re
import subprocess
import sys
from pathlib import Path

WIDTH, README_WIDTH, README_LINES = 120, 100, 120
# Other programs' options.
FOREIGN = {"--oversubscribe", "--map-by", "--mca", "--preset", "--build", "--target", "--install", "--prefix", "--strip", "--sym", "--drawing", "--list",
           "--release", "--mpich", "--repeat", "--only", "--choices", "--user", "--cpus-per-task", "--help", "--help-all", "--version"}
SKIPPED = {"build", "out", "dist", ".git", ".cache"}


def pages(root):
    for folder, folders, files in os.walk(root):
        folders[:] = sorted(f for f in folders if f not in SKIPPED)
        yield from (Path(folder, f) for f in sorted(files) if f.endswith(".md"))


def without_code(text):
    return re.sub(r"(?ms)^ *```.*?^ *```", "", text)


def anchors(page):
    titles = re.findall(r"(?m)^#+ (.*)$", without_code(page.read_text(encoding="utf-8")))
    return {re.sub(r"[^\w\- ]", "", title.replace("`", "").lower()).strip().replace(" ", "-") for title in titles}


def too_wide(page, text, readme):
    width = README_WIDTH if readme else WIDTH
    for number, line in enumerate(text.splitlines(), 1):
        if len(line) > width and (readme or not line.startswith("|")):
            yield f"{page}:{number} has {len(line)} columns, {width} are enough"
    if readme and text.count("\n") > README_LINES:
        yield f"{page} has {text.count(chr(10))} lines, {README_LINES} are enough"


def broken_links(page, text):
    for target in re.findall(r"\]\(([^)\s]+)\)", without_code(text)):
        if re.match(r"[a-z]+:", target):
            continue
        path, _, anchor = target.partition("#")
        file = (page.parent / path).resolve() if path else page
        if not file.exists():
            yield f"{page}: {target} leads nowhere"
        elif anchor and file.suffix == ".md" and anchor not in anchors(file):
            yield f"{page}: {target} names no heading"


def missing_files(page, text, root):
    for name in re.findall(r"`((?:[a-z_]+/)+[a-z_]+\.(?:hpp|cpp|js|py|sh))`", text):
        if not any((root / folder / name).exists() for folder in ("", "src", "include", "include/ringsplat", "tests")):
            yield f"{page}: there is no {name}"


def unknown_options(page, text, known):
    for code in re.findall(r"`(--[a-z][^`]*)`", without_code(text)):
        for option in re.findall(r"--[a-z][a-z-]*", code):
            if option not in known:
                yield f"{page}: the program has no {option}"


def main():
    root, program = Path(sys.argv[1]).resolve(), sys.argv[2]
    manual = subprocess.run([program, "--man"], check=True, capture_output=True, text=True).stdout
    known = FOREIGN | set(re.findall(r"--[a-z][a-z-]*", manual.replace("\\-", "-")))
    problems = []
    for page in pages(root):
        text = page.read_text(encoding="utf-8")
        problems += too_wide(page, text, page == root / "README.md")
        problems += broken_links(page, text)
        problems += missing_files(page, text, root)
        if page.parent in (root, root / "docs", root / "docs/measured") and page.name != "CHANGELOG.md":
            problems += unknown_options(page, text, known)
    made = subprocess.run([sys.executable, "-B", root / "docs/option_page.py"], input=manual, check=True, capture_output=True, text=True).stdout
    if made != (root / "docs/options.md").read_text(encoding="utf-8"):
        problems.append(f"docs/options.md is out of date; hint: {program} --man | docs/option_page.py > docs/options.md")
    print("\n".join(map(str, problems)))
    sys.exit(bool(problems))


if __name__ == "__main__":
    main()
