"""Options are the command line's."""

import inspect
import json

import numpy as np
import pytest
import ringsplat as rs
from conftest import blob
from ringsplat._table import OPTIONS, options_for

SMALL = blob((6, 7, 8))


@pytest.mark.parametrize(
    "options, error, text",
    [
        (dict(azimut=3), TypeError, "did you mean azimuth"),
        (dict(cmap="viridis"), TypeError, "did you mean colours"),
        (dict(output="x.png"), TypeError, "output"),
        (dict(azimuth="north"), rs.InputError, "azimuth"),
        (dict(quality="paper", engine="sheets"), rs.InputError, "contradict"),
        (dict(size=(1, 2, 3)), TypeError, "size"),
        (dict(clip="0:5"), rs.InputError, "three"),
        (dict(azimuth=[]), TypeError, "empty"),
        (dict(azimuth=[1, 2], zoom=[1, 2, 3]), TypeError, "one length"),
        (dict(azimuth=[1, 2], view="top"), rs.InputError, "view"),
        (dict(tf=[[1, 2]]), TypeError, "rows"),
        (dict(azimuth=True), TypeError, "number"),
        (dict(clip=[slice(0, 9, 2), None, None]), TypeError, "step"),
    ],
)
def test_errors_are_the_command_lines_or_name_the_argument(options, error, text):
    with pytest.raises(error, match=text):
        rs.render(SMALL, **options)


def test_none_and_false_are_as_if_not_given():
    assert np.array_equal(
        np.asarray(rs.render(SMALL, size=32, azimuth=None, annotate=False, tf=None)),
        np.asarray(rs.render(SMALL, size=32)),
    )


def test_numbers_keep_every_digit():
    angle = 1 / 3
    image = rs.render(SMALL, size=np.int64(32), azimuth=np.float64(angle), zoom=np.float32(0.1))
    assert image.settings["camera"]["azimuth"] == angle
    assert image.settings["camera"]["zoom"] == float(np.float32(0.1))


def test_a_transfer_function_may_be_points_or_paraviews_json(tmp_path):
    rows = [(0.1, 0, 0, 1, 0), (0.5, 0, 1, 0, 0.2), (1, 1, 0, 0, 0.9)]
    one = rs.render(SMALL, size=32, tf=rows)
    paraview = {
        "Name": "mine",
        "RGBPoints": [n for r in rows for n in r[:4]],
        "ColorSpace": "RGB",
        "Points": [n for r in rows for n in (r[0], r[4], 0.5, 0)],
    }
    (tmp_path / "tf.json").write_text(json.dumps([paraview]))
    for tf in (paraview, [paraview], tmp_path / "tf.json", str(tmp_path / "tf.json"), np.array(rows)):
        assert np.array_equal(np.asarray(rs.render(SMALL, size=32, tf=tf)), np.asarray(one))
    assert np.asarray(one)[..., 3].max() > 0.1


def test_the_types_for_editors_are_those_of_the_table():
    from ringsplat._options import PictureOptions

    assert PictureOptions.__annotations__.keys() == {option.name for option in options_for(session=False)}


def test_help_has_every_option_with_its_type():
    names = inspect.signature(rs.render).parameters
    assert {"volume", "spacing", "azimuth", "no_opacity_correction", "tf"} <= set(names)
    assert not {"output", "path", "stats", "gps"} & set(names)
    for option in options_for(session=False):
        assert f"{option.name} : {option.annotation}" in rs.render.__doc__
    assert "max_error" not in [o.name for o in options_for(session=True)]
    assert OPTIONS["size"].default == "512x512"


def test_presets_and_colour_maps_are_listed():
    assert "mr-skin" in rs.presets() and rs.presets()["auto"]
    assert "viridis" in rs.colour_maps()
