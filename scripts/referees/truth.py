"""The truth of a scene's pixels: its closed form where it has one, else the middles of certified bounds; and that both agree."""
import hashlib
import json

import numpy

from studies.run import program, read_frames

from .drivers.ringsplat import words
from .files import read_exr

LEVEL = 1 / 255
SAMPLE, SMALL = 300, 16  # pixels whose bounds are looked at; the side of the picture in which a closed form is checked


def described(scene, folder, size):
    return words(folder, {**scene.camera, "size": [size, size]})


def certified(scene, folder, size):
    picture = folder / "certified.exr"
    program("reference", *described(scene, folder, size), "--truth", "certified", "-o", picture)
    return read_exr(picture)


def widest_bounds(scene, folder, size):
    """Of a sample, in 1/255."""
    stats, picture = folder / "stats.json", folder / "bounds.exr"
    program("render", *described(scene, folder, size), "--error", "certified", "--error-pixels", SAMPLE, "--stats", stats, "-o", picture)
    return read_frames(stats)[-1]["error"]["widest"]


def closed_form(scene, size):
    cosine = abs(numpy.sin(numpy.radians(scene.view[1])))
    return scene.truth(numpy.full((size, size), cosine))


def truth_of(scene, folder, size, store):
    """Picture, and where it is from; kept in `store` as long as the scene's files are the same."""
    key = hashlib.sha256(b"".join((folder / name).read_bytes() for name in ("volume.nrrd", "function.json", "camera.json"))).hexdigest()[:16]
    kept = store / f"{scene.name}-{key}.npy"
    said = kept.with_suffix(".json")
    if not said.exists():
        kept.parent.mkdir(parents=True, exist_ok=True)
        widest = widest_bounds(scene, folder, size)
        if scene.truth:
            picture = closed_form(scene, size)
            off = numpy.abs(certified(scene, folder, SMALL) - closed_form(scene, SMALL)).max() / LEVEL
            wide = widest_bounds(scene, folder, SMALL)
            if off > wide / 2 + 1e-4:
                raise SystemExit(f"{scene.name}: the closed form is {off:.4f}/255 from the middle of bounds {wide:.4f}/255 wide")
            source = "closed form"
        else:
            picture, source, off = certified(scene, folder, size), "certified", None
        numpy.save(kept, picture)
        said.write_text(json.dumps({"source": source, "widest": widest, "off": off}))
    return numpy.load(kept), json.loads(said.read_text())
