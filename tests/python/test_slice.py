"""One slice as a picture and as numbers."""

import numpy as np
import pytest
import ringsplat as rs

SHAPE = (9, 12, 15)  # z, y, x
TURN = np.array([[0, 0, 1], [1, 0, 0], [0, 1, 0]])  # columns: the world directions of x, y and z


def volume(dtype="float32"):
    return np.random.default_rng(3).integers(1, 200, SHAPE).astype(dtype)


def numbers(array, place, size, **options):
    """What the slice's pixels hold, row by row from the top."""
    made = rs.render(array, slice=place, values=True, size=size, **options)
    pixels = np.asarray(made)
    assert np.all(pixels[..., 3] == 1)
    return pixels[..., 0]


@pytest.mark.parametrize("dtype", ["uint8", "int16", "float32", "float64"])
def test_pixels_as_large_as_voxels_are_the_array(dtype):
    array = volume(dtype)
    for z in (0, 4, 8):
        assert np.allclose(numbers(array, f"z={z}", (15, 12))[::-1], array[z], rtol=1e-6)
    assert np.allclose(numbers(array, "y=11", (15, 9))[::-1], array[:, 11], rtol=1e-6)
    assert np.allclose(numbers(array, "x=7", (12, 9))[::-1], array[:, :, 7], rtol=1e-6)


def test_between_voxels_values_are_linear():
    array = volume()
    seen = numbers(array, "z=4", (30, 24))[::-1]
    x, y = (np.arange(30) + 0.5) / 2 - 0.5, (np.arange(24) + 0.5) / 2 - 0.5
    rows = np.stack([np.interp(x, np.arange(15), row) for row in array[4]])
    expected = np.stack([np.interp(y, np.arange(12), column) for column in rows.T], axis=1)
    inside = (slice(1, -1), slice(1, -1))
    assert np.allclose(seen[inside], expected[inside], rtol=1e-6)


def test_distances_and_turned_lattices():
    array = volume()
    spaced = numbers(array, "z=11mm", (15, 12), spacing=(2, 2, 2.5))
    assert np.allclose(spaced[::-1], array[4], rtol=1e-6)
    # The lattice's z axis runs along the world's x, so its slices are seen from there, with y up and x to the right.
    turned = numbers(array, "z=4", (15, 12), direction=TURN)
    assert np.allclose(turned[::-1], array[4], rtol=1e-6)


@pytest.mark.parametrize(
    "place, words",
    [("x", "names no slice"), ("q=3", "names no slice"), ("x=3.5", "no whole number"), ("x=15", "within the volume"),
     ("x=-1", "within the volume"), ("x=nan", "names no slice"), ("x=1:2", "names no slice"), ("x=40mm", "within the volume")],
)
def test_what_is_no_slice_is_refused(place, words):
    with pytest.raises(rs.InputError, match=words):
        rs.render(volume(), slice=place)


def test_a_slice_contradicts_other_views():
    for options in (dict(clip="0:3,,"), dict(mode="mip"), dict(view="left"), dict(azimuth=20), dict(interpolation="nearest")):
        with pytest.raises(rs.InputError, match="leave one out"):
            rs.render(volume(), slice="x=3", **options)
