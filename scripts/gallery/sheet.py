#!/usr/bin/env python3
"""Puts a folder's pictures, NNN.png with NNN.txt below it, into one: sheet.py FOLDER SHEET.png"""
import pathlib
import sys
import textwrap

from PIL import Image, ImageDraw

COLUMNS, SIDE, LINES, LINE = 6, 320, 7, 12
BEHIND, PAPER, INK, ALARM = (40, 44, 52), (250, 250, 248), (20, 20, 20), (190, 30, 30)


def cell(text_file):
    """One picture on a dark ground, with its words below."""
    box = Image.new("RGB", (SIDE, SIDE + LINES * LINE + 8), PAPER)
    picture = text_file.with_suffix(".png")
    box.paste(BEHIND, (0, 0, SIDE, SIDE))
    if picture.exists():
        with Image.open(picture) as image:
            image = image.convert("RGBA")
            image.thumbnail((SIDE, SIDE))
            box.paste(image, ((SIDE - image.width) // 2, (SIDE - image.height) // 2), image)
    draw = ImageDraw.Draw(box)
    wrapped = [part for line in text_file.read_text(errors="replace").splitlines()
               for part in textwrap.wrap(line, 52) or [""]]
    for number, line in enumerate(wrapped[:LINES]):
        draw.text((4, SIDE + 4 + number * LINE), line, fill=INK if picture.exists() else ALARM)
    return box


def main():
    folder, sheet = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    cells = [cell(file) for file in sorted(folder.glob("*.txt"))]
    rows = -(-len(cells) // COLUMNS)
    width, height = SIDE + 8, SIDE + LINES * LINE + 16
    whole = Image.new("RGB", (COLUMNS * width, max(rows, 1) * height), PAPER)
    for number, one in enumerate(cells):
        whole.paste(one, (number % COLUMNS * width + 4, number // COLUMNS * height + 4))
    whole.save(sheet)


if __name__ == "__main__":
    main()
