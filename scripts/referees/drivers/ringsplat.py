"""Ringsplat itself:  ringsplat.py SCENE PICTURE [RENDER_OPTION...]. RINGSPLAT names the program."""
import os
import subprocess
import sys
import tempfile

import numpy
from referees.files import read_exr
from referees.scene import Scene, write_picture


def view(camera):
    """The camera's words; an orthographic one is a matrix from the world to pixels, as the program's own fits the volume."""
    side = camera["size"][0]
    words = ["--size", side]
    if camera["projection"] == "perspective":
        placed = [word for key in ("eye", "target", "up") for word in ("--" + key, *camera[key])]
        return [*words, "--projection", "perspective", "--fov", camera["fov"], *placed]
    eye, target, up = (numpy.array(camera[key]) for key in ("eye", "target", "up"))
    back = (eye - target) / numpy.linalg.norm(eye - target)
    rows = side / camera["height"] * numpy.array([numpy.cross(up, back), -up, -back])
    return [*words, "--matrix", *numpy.column_stack([rows, numpy.array([side / 2, side / 2, 0]) - rows @ target]).ravel()]


def words(folder, camera):
    return map(str, [folder / "volume.nrrd", "--tf", folder / "function.json", "--shading", "none", *view(camera)])


if __name__ == "__main__":
    scene = Scene(sys.argv[1])
    with tempfile.TemporaryDirectory() as scratch:
        picture = os.path.join(scratch, "picture.exr")
        command = [os.environ["RINGSPLAT"], "render", *words(scene.folder, scene.world), *sys.argv[3:], "-o", picture]
        ended = subprocess.run(command, capture_output=True, text=True)
        if ended.returncode:
            sys.exit(ended.stderr)
        write_picture(sys.argv[2], read_exr(picture))
    print(subprocess.run([os.environ["RINGSPLAT"], "--version"], capture_output=True, text=True).stdout.split("\n")[0])
