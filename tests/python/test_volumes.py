"""Arrays of every kind, xarray and paths."""

import pathlib

import numpy as np
import pytest
import ringsplat as rs
import xarray as xr
from conftest import HEAD, blob

SIZE = dict(size=48, quality="draft")


def pixels(volume, **options):
    return np.asarray(rs.render(volume, **{**SIZE, **options}))


def same(a, b, **options):
    return np.array_equal(pixels(a, **options), pixels(b, **options))


@pytest.mark.parametrize(
    "change",
    [
        lambda a: np.asfortranarray(a),
        lambda a: a[::-1][::-1],
        lambda a: np.repeat(a, 2, axis=2)[:, :, ::2],
        lambda a: a.astype(">f4"),
        lambda a: a.transpose(2, 1, 0).copy().transpose(2, 1, 0),
        lambda a: a.tolist(),
        lambda a: memoryview(a),
    ],
)
def test_strides_byte_order_and_containers_change_nothing(change):
    array = blob((10, 12, 14))
    assert same(array, change(array), range=(0.1, 1))


def test_negative_strides_reverse_and_zero_strides_repeat():
    array = blob((10, 12, 14))
    assert same(array[::-1, :, ::-1], np.ascontiguousarray(array[::-1, :, ::-1]))
    plane = array[5]
    assert same(np.broadcast_to(plane, (9, 12, 14)), np.stack([plane] * 9))


def test_an_unaligned_and_read_only_array_is_read():
    records = np.zeros((8, 9, 10), dtype=[("flag", "u1"), ("value", "<f4")])
    records["value"] = blob((8, 9, 10))
    view = records["value"]
    view.flags.writeable = False
    assert same(view, view.copy())


@pytest.mark.parametrize(
    "dtype",
    ["bool", "int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64", "float16", "float32", "float64"],
)
def test_all_types_of_numbers_are_drawn(dtype):
    array = blob((10, 12, 14), "int8" if dtype != "bool" else "float32")
    array = array > 0.4 if dtype == "bool" else array.astype(dtype)
    expected = array.astype(
        {"bool": "uint8", "int64": "int32", "uint64": "int32", "float16": "float32"}.get(dtype, dtype)
    )
    assert same(array, expected)
    assert pixels(array)[..., 3].max() > 0


def test_large_whole_numbers_are_doubles_where_that_loses_nothing():
    array = blob((6, 7, 8), "int64") * 2**40
    assert same(array, array.astype("float64"))
    with pytest.raises(rs.InputError, match="more than a volume can hold exactly"):
        rs.render(array + 2**60 + 1)


@pytest.mark.parametrize(
    "volume, error, text",
    [
        (np.zeros((3, 3, 3), complex), TypeError, "abs"),
        (np.zeros((2, 2, 2), "U1"), TypeError, "numbers"),
        (np.zeros((2, 0, 2)), rs.InputError, "size from 1"),
        (np.zeros(5), rs.InputError, r"axes \[z, y, x\]"),
        (np.zeros((2, 3, 4, 5)), rs.InputError, "component"),
        (np.full((3, 3, 3), np.nan), rs.InputError, "no finite value"),
        (np.ma.masked_less(np.arange(8.0).reshape(2, 2, 2), 3), rs.InputError, "filled"),
        (None, TypeError, "numbers"),
        ("no/such/file.nrrd", rs.InputError, "no/such/file.nrrd"),
        ("a\0b.nrrd", rs.InputError, "NUL"),
    ],
)
def test_what_is_no_volume_is_refused_with_what_to_do(volume, error, text):
    with pytest.raises(error, match=text):
        rs.render(volume, **SIZE)


def test_spacing_and_direction_place_an_array(tmp_path):
    array = blob((10, 12, 14))
    np.save(tmp_path / "a.npy", array)
    assert np.array_equal(pixels(array, spacing=(1, 2, 0.5)), pixels(tmp_path / "a.npy", spacing=(1, 2, 0.5)))
    assert same(array, array, spacing=2)
    turned = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
    assert not np.allclose(pixels(array, direction=turned), pixels(array), atol=1e-2)
    assert np.allclose(pixels(array, direction=turned, azimuth=90), pixels(array, azimuth=0), atol=1e-2)
    header = (
        "NRRD0004\ntype: float\ndimension: 3\nspace dimension: 3\nsizes: 14 12 10\nspace origin: (5,6,7)\n"
        "space directions: (0,1,0) (-2,0,0) (0,0,1)\nendian: little\nencoding: raw\n\n"
    )
    (tmp_path / "a.nrrd").write_bytes(header.encode() + array.tobytes())
    assert np.array_equal(
        pixels(array, direction=turned, spacing=(1, 2, 1), origin=(5, 6, 7)), pixels(tmp_path / "a.nrrd")
    )


@pytest.mark.parametrize(
    "bad",
    [dict(spacing=0), dict(spacing=float("nan")), dict(origin=(0, 0, float("inf"))), dict(direction=np.zeros((3, 3)))],
)
def test_a_bad_place_is_an_input_error(bad):
    with pytest.raises(rs.InputError):
        rs.render(blob((4, 5, 6)), **SIZE, **bad)


def test_a_data_arrays_coordinates_place_it():
    array = blob((10, 12, 14))
    data = xr.DataArray(
        array,
        dims=("z", "y", "x"),
        name="heat",
        attrs={"units": "K", "long_name": "temperature"},
        coords={"z": 3 + 2.0 * np.arange(10), "y": np.linspace(0, 5.5, 12), "x": np.arange(14)[::-1]},
    )
    expected = pixels(array[:, :, ::-1], spacing=(1, 0.5, 2), origin=(0, 0, 3))
    assert np.array_equal(pixels(data), expected)
    assert np.array_equal(pixels(data.transpose("y", "x", "z")), expected)
    assert rs.render(data, **SIZE).settings["volume"] == "heat"


def test_coordinates_may_be_a_little_uneven_and_not_more():
    places = np.arange(10.0)
    for shift, fits in ((0.5e-4, True), (2e-3, False)):
        moved = places.copy()
        moved[4] += shift
        data = xr.DataArray(blob((10, 6, 6)), dims=("z", "y", "x"), coords={"z": moved})
        if fits:
            pixels(data)
        else:
            with pytest.raises(rs.InputError, match="evenly"):
                pixels(data)
            pixels(data, spacing=1)


def test_a_dataset_and_times_are_refused():
    data = xr.DataArray(blob((3, 6, 6)), dims=("time", "y", "x"), coords={"time": np.arange(3).astype("datetime64[D]")})
    with pytest.raises(TypeError, match="Dataset"):
        rs.render(data.to_dataset(name="a"))
    with pytest.raises(rs.InputError, match="isel"):
        rs.render(data)


def test_options_of_files_are_refused_for_arrays():
    for option in (dict(frame=1), dict(channel=0), dict(series="a"), dict(type="uint8"), dict(crop="0:4,:,:")):
        with pytest.raises(rs.InputError, match="an array is a volume by itself"):
            rs.render(blob((6, 7, 8)), size=16, **option)


@pytest.mark.parametrize("dtype, offset", [("float32", 300), ("float64", 1e5), ("float64", 1e8)])
def test_an_offset_changes_no_picture(dtype, offset):
    volume = blob((20, 22, 24), dtype)
    for options in (dict(tf="grey"), dict(mode="mip"), dict(mode="surface", isovalue=0.4), dict(slice="z=8")):
        options["range"] = (0, 1.5)
        moved = {**options, "range": (offset, 1.5 + offset)}
        if "isovalue" in options:
            moved["isovalue"] += offset
        shown = np.asarray(rs.render(volume, size=48, **options))
        other = np.asarray(rs.render((volume + offset).astype(dtype), size=48, **moved))
        assert np.abs(shown - other).max() < 0.01, options


def test_numbers_are_the_same_in_all_qualities():
    volume = 200 + 100 * blob((20, 22, 24), "float32")
    best, draft = (np.asarray(rs.render(volume, size=48, mode="mip", values=True, quality=q)) for q in ("best", "draft"))
    assert np.array_equal(best, draft) and best.max() > 200


def test_paths_take_the_options_of_files(tmp_path):
    array = np.stack([blob((6, 7, 8), seed=seed) for seed in range(5)])
    np.save(tmp_path / "series.npy", array)
    assert np.array_equal(pixels(tmp_path / "series.npy", frame=3), pixels(array[3]))
    raw = tmp_path / "bytes.bin"
    array[0].astype(">f4").tofile(raw)
    assert np.array_equal(pixels(str(raw), dims=(8, 7, 6), type="float32", endian="big"), pixels(array[0]))
    assert isinstance(HEAD, pathlib.Path) and pixels(HEAD)[..., 3].max() > 0.5
    with pytest.raises(TypeError, match="origin"):
        rs.render(HEAD, origin=(0, 0, 0))


def test_what_speaks_dlpack_only_is_read():
    class Tensor:
        def __init__(self, array):
            self.array = array

        def __dlpack__(self, **options):
            return self.array.__dlpack__(**options)

        def __dlpack_device__(self):
            return self.array.__dlpack_device__()

    array = blob((10, 12, 14))
    assert same(array, Tensor(array))
