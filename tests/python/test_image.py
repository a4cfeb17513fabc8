"""What a picture can do."""

import io
import json

import numpy as np
import pytest
import ringsplat as rs
from conftest import blob
from PIL import Image as Pillow

VOLUME = blob((12, 14, 16))


@pytest.fixture(scope="module")
def image():
    return rs.render(VOLUME, size=(40, 30), tf="auto")


def test_it_is_an_array_of_premultiplied_linear_light(image):
    array = np.asarray(image)
    assert array.shape == image.shape == (image.height, image.width, 4) == (30, 40, 4)
    assert array.dtype == image.dtype == np.float32 and not array.flags.writeable
    assert 0 < array[..., 3].max() <= 1 and (array >= 0).all()
    assert (array[..., :3].max(axis=-1) <= 2 * array[..., 3] + 1e-6).all()


def test_copies_are_made_when_they_are_asked_for(image):
    assert np.shares_memory(np.asarray(image), np.asarray(image))
    copy = np.array(image)
    copy[:] = 0
    assert np.asarray(image).max() > 0
    assert image.__array__(copy=True).flags.writeable
    assert np.asarray(image, dtype=np.float64).dtype == np.float64
    with pytest.raises(ValueError, match="copy"):
        image.__array__(dtype=np.float64, copy=False)


def test_depths_lie_beside_its_colours(image):
    assert image.depth is None
    deep = rs.render(VOLUME, size=(40, 30), tf="auto", depth=0.2)
    assert np.array_equal(np.asarray(deep), np.asarray(image))
    assert deep.depth.shape == (30, 40) and deep.depth.dtype == np.float32
    there = np.isfinite(deep.depth)
    # Rounding apart, rays that end so opaque have a depth, inside of the volume.
    assert np.array_equal(there, np.asarray(image)[..., 3] > 0.2) and there.sum() > 100
    assert np.abs(deep.depth[there]).max() < 13 and (deep.depth[~there] == np.inf).all()


def test_its_array_outlives_it():
    array = np.asarray(rs.render(VOLUME, size=16))
    before = array.copy()
    rs.render(VOLUME, size=64)
    assert np.array_equal(array, before)


def test_its_png_is_its_srgb(image, tmp_path):
    png = Pillow.open(io.BytesIO(image._repr_png_()))
    assert png.mode == "RGBA" and np.array_equal(np.asarray(png), image.srgb())
    image.save(tmp_path / "a.png")
    assert (tmp_path / "a.png").read_bytes() == image._repr_png_()
    over = rs.render(VOLUME, size=32, background="white").srgb()
    assert over.shape == (32, 32, 3) and (over[0, 0] == 255).all()


def test_it_is_saved_by_its_ending_or_refused(image, tmp_path):
    for ending in (".png", ".exr", ".tif"):
        image.save(tmp_path / f"a{ending}")
        assert (tmp_path / f"a{ending}").stat().st_size > 100
    with pytest.raises(rs.InputError, match="ending"):
        image.save(tmp_path / "a.txt")
    with pytest.raises(rs.InputError, match="transparency"):
        image.save(tmp_path / "a.jpg")
    with pytest.raises(rs.RunError):
        image.save(tmp_path / "no" / "such" / "a.png")


def test_it_says_how_it_was_made(image):
    assert image.settings["size"] == [40, 30] and image.settings["transfer_function"]["name"]
    assert json.dumps(image.settings) and image.seconds > 0 and "40 x 30" in repr(image)


@pytest.mark.parametrize("truth", ["field", "method"])
@pytest.mark.parametrize("quality", ["best", "paper"])
def test_its_error_is_measured_when_it_is_asked_for(quality, truth):
    image = rs.render(VOLUME, size=48, quality=quality)
    error = image.error(truth, pixels=300, seed=7)
    assert error.truth == truth and error.pixels == 300 and error.seed == 7
    assert error.interval[0] <= error.rms <= error.interval[1] and error.rms <= error.max
    assert error.rms < {"field": 20, "method": 1}[truth]
    assert image.error(truth, pixels=300, seed=7).rms == error.rms
    assert str(error).startswith("error against")


def test_another_truth_is_refused(image):
    with pytest.raises(rs.InputError, match="truth"):
        image.error("beauty")


def test_an_error_that_the_options_asked_for_is_kept():
    image = rs.render(VOLUME, size=32, error="field", error_pixels=100)
    assert image.error().truth == "field" and image.error().pixels == 100
    assert image.settings["error"]["pixels"] == 100
