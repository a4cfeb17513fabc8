"""Draws the scenes with every program that is there and judges the pictures."""
import contextlib
import re
from pathlib import Path

import numpy

from studies.output import print_table, write_csv
from studies.peers import SOFTWARE, display
from studies.run import fail, need, parser, say

from .files import read_picture, write_scene
from .programs import KEPT, all_programs, install
from .scenes import all_scenes
from .truth import truth_of


def main(words):
    """Fifteen scenes as NRRD, ParaView's JSON and a camera, drawn by every program that is there, and compared with closed forms and with
certified bounds. Prints a table of errors in 1/255, RMSE and the largest, and keeps scenes, pictures, truths and errors.csv below
build/referee. docs/measured/referee.md says what was found, and how a program is added."""
    arguments = parser(main.__doc__)
    arguments.add_argument("--install", action="store_true", help="installs VTK and yt from PyPI into build/referee/venv (600 MB) and ends")
    arguments.add_argument("--size", type=int, default=128, help="pixels of a picture's side (128)")
    arguments.add_argument("--scenes", nargs="+", metavar="SCENE", help="only these")
    arguments.add_argument("--programs", nargs="+", metavar="WORD", help="only programs whose names have one of these words")
    arguments.add_argument("--folder", type=Path, default=KEPT, help="where scenes and pictures go (build/referee)")
    arguments.add_argument("--kept", action="store_true", help="judges pictures that are there, and draws the others only")
    arguments.add_argument("--page", type=Path, metavar="MD", help="also puts the table into this page, in the place of its first one")
    arguments.add_argument("--write-scenes", action="store_true", help="writes the scenes and ends")
    options = arguments.parse_args(words)
    if options.install:
        return install()
    scenes = chosen(all_scenes(), options.scenes)
    for scene in scenes:
        write_scene(options.folder / "scenes" / scene.name, scene, options.size)
    if options.write_scenes:
        return None
    need("referee", "ringsplat_cli")
    programs = [p for p in there() if not options.programs or any(word.lower() in p.name.lower() for word in options.programs)]
    with display() if any("ParaView" in p.name for p in programs) else contextlib.nullcontext():
        rows = [row for scene in scenes for row in judge(scene, programs, options)]
    write_csv(options.folder / "errors.csv", rows)
    columns, table = as_table(scenes, programs, rows)
    print_table(columns, table)
    if options.page:
        put_table(options.page, columns, table)
    return None


def chosen(scenes, names):
    unknown = set(names or ()) - {scene.name for scene in scenes}
    if unknown:
        fail(f"there is no scene '{unknown.pop()}'; hint: {', '.join(scene.name for scene in scenes)}")
    return [scene for scene in scenes if not names or scene.name in names]


def there():
    for program in all_programs():
        if program.missing:
            say(f"{program.name} is left out: {program.missing}")
        else:
            yield program


def judge(scene, programs, options):
    """A row of errors for each program that draws the scene."""
    say(scene.name)
    folder, pictures = options.folder / "scenes" / scene.name, options.folder / "pictures"
    truth, said = truth_of(scene, folder, options.size, options.folder / "truth")
    pictures.mkdir(exist_ok=True)
    for program in programs:
        picture = pictures / f"{scene.name}-{program.name.replace(' ', '-').lower()}.f32"
        if (options.kept and picture.exists()) or program.draw(folder, picture, SOFTWARE):
            rmse, largest = errors(read_picture(picture, options.size), truth)
            yield {"scene": scene.name, "program": program.name, "rmse": rmse, "largest": largest, **said}


def errors(picture, truth):
    """RMSE and the largest, in 1/255, over the channels that the program gives. What is no number is wrong by all."""
    given = 3 if numpy.isnan(picture[..., 3]).all() else 4
    off = 255 * numpy.nan_to_num(numpy.abs(picture[..., :given] - truth[..., :given]), nan=1)
    return float(numpy.sqrt((off**2).mean())), float(off.max())


def as_table(scenes, programs, rows):
    cells = {(row["scene"], row["program"]): f"{row['rmse']:.2f}, {row['largest']:.0f}" for row in rows}
    drawn = [scene.name for scene in scenes if any(row["scene"] == scene.name for row in rows)]
    return ["scene", *(p.name for p in programs)], [[name, *(cells.get((name, p.name), "—") for p in programs)] for name in drawn]


def put_table(page, columns, table):
    lines = "".join("| " + " | ".join(row) + " |\n" for row in [columns, *table])
    head, rest = lines.split("\n", 1)
    made = f"{head}\n|{'---|' * len(columns)}\n{rest}"
    page.write_text(re.sub(r"(?m)(^\|.*\n)+", lambda _: made, page.read_text(encoding="utf-8"), count=1), encoding="utf-8")
