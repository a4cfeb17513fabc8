"""Pictures have the bits of the program's."""

import numpy as np
import pytest
import ringsplat as rs
from conftest import HEAD, blob, program, saved

PICTURES = [
    {"quality": "best"},
    {"quality": "paper", "azimuth": 30, "elevation": -20, "zoom": 1.3},
    {"quality": "draft", "view": "top", "roll": 15},
]


def words_of(options):
    return [word for name, value in options.items() for word in (f"--{name.replace('_', '-')}", str(value))]


@pytest.mark.parametrize("picture", PICTURES)
@pytest.mark.parametrize("kind", ["head", "float32", "int16"])
def test_a_picture_has_the_bits_of_the_programs(kind, picture, exr_of, npy, tmp_path):
    options = {"size": 96, **picture}
    if kind == "head":
        volume, file = HEAD, HEAD
    else:
        volume = blob((20, 24, 28), kind)
        file = npy(volume)
    theirs = exr_of(file, *words_of(options))
    image = rs.render(volume, **options)
    assert saved(rs.render(file, **options), tmp_path / "file.exr") == theirs
    rs_array = np.asarray(image)
    assert np.array_equal(rs_array, np.asarray(rs.render(file, **options)))
    assert rs_array[..., 3].max() > 0.1


def test_labels_are_drawn_as_by_the_program(exr_of, npy, tmp_path):
    labels = (blob((24, 24, 24)) * 4).astype(np.uint8)
    file = npy(labels)
    assert saved(rs.render(file, size=64, labels=True), tmp_path / "l.exr") == exr_of(file, "--size", 64, "--labels")
    assert rs.render(labels, size=64).settings["engine"] == rs.render(file, size=64).settings["engine"]


def test_channels_are_added_as_by_the_program(exr_of, npy, tmp_path):
    file = npy(np.stack([blob((16, 20, 24), seed=seed) for seed in range(2)], axis=-1))
    image = rs.render(file, size=64, channel=[0, 1], annotate=True)
    theirs = exr_of(file, "--size", 64, "--channel", "0,1", "--annotate")
    assert saved(image, tmp_path / "c.exr") == theirs
    assert [each["name"] for each in image.settings["channels"]] == ["channel 0", "channel 1"]
    pictures = rs.render(file, size=64, channel="1=red,0", azimuth=[0, 90])
    alone = rs.render(file, size=64, channel="0,1=red", azimuth=90)
    assert len(pictures) == 2 and np.asarray(pictures[1]).shape == np.asarray(alone).shape
    with pytest.raises(rs.InputError, match="several channels has no error"):
        image.error()
    with pytest.raises(rs.InputError, match="an array is a volume by itself"):
        rs.render(blob((8, 8, 8)), size=16, channel=[0, 1])


def test_other_options_mean_the_same(exr_of, npy, tmp_path):
    file = npy(blob((16, 20, 24)))
    image = rs.render(
        file,
        size=(80, 60),
        range=(0.1, 0.9),
        opacity=2,
        colours="viridis",
        clip=[slice(2, 20), None, (4, None)],
        background="white",
        shading="phong",
        light=(-0.4, 0.2, 1),
        undersample=2,
        prefilter=True,
        spacing=(1, 1.5, 2),
    )
    words = "--size 80x60 --range=0.1:0.9 --opacity 2 --colours viridis --clip=2:20,:,4: --background white --light -0.4 0.2 1"
    words += " --undersample 2 --prefilter --spacing 1x1.5x2"
    assert saved(image, tmp_path / "o.exr") == exr_of(file, *words.split())


def test_annotations_and_metadata_are_the_programs(npy, tmp_path):
    file = npy(blob((16, 16, 16)))
    program("render", file, "-o", tmp_path / "p.png", "--size", 256, "--annotate", "--background", "black")
    image = rs.render(file, size=256, annotate=True, background="black")
    assert saved(image, tmp_path / "i.png") == (tmp_path / "p.png").read_bytes()
    assert image._repr_png_() == (tmp_path / "p.png").read_bytes()


def test_views_in_a_list_are_those_of_a_path(npy, tmp_path):
    file = npy(blob((16, 20, 24)))
    (tmp_path / "path.txt").write_text("0 10\n30 10\n75.5 10\n")
    program("render", file, "-o", tmp_path / "p.exr", "--size", 64, "--path", tmp_path / "path.txt")
    images = rs.render(file, size=64, azimuth=[0, 30, 75.5], elevation=[10, 10, 10])
    for number, image in enumerate(images):
        assert saved(image, tmp_path / "i.exr") == (tmp_path / f"p-{number:04d}.exr").read_bytes()


def test_an_error_budget_is_kept_and_its_error_measured():
    # Which settings are the cheapest is a matter of measured seconds, so that two runs may differ.
    image = rs.render(blob((16, 20, 24)), size=64, max_error=1, error_pixels=200)
    assert image.error().pixels == 200 and image.error().rms <= 1
    assert image.settings["error"]["rmse"] == image.error().rms


def test_pictures_over_the_error_budget_are_drawn_again(npy):
    views = dict(azimuth=[0, 20, 10], zoom=[0.4, 0.4, 1.5])  # the last has more of what errs
    images = rs.render(npy(blob((48, 60, 64))), size=240, tf="grey", shading="none", max_error=2, **views)
    assert all(image.error().rms <= 2 for image in images)
    exact, coarse = ({**image.settings, "camera": 0, "error": 0} for image in (images[2], images[0]))
    assert exact != coarse
