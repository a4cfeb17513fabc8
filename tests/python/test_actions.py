"""Pictures that a file asks for, which changes while a program runs."""

import os

import numpy as np
import pytest
import ringsplat as rs
from conftest import blob

SHAPE = (16, 18, 20)
FRONT = '[front]\nevery = 2\nfile = "front-{step}.png"\nsize = 32\ntf = "grey"\n'
SIDE = '[side]\nfirst = 3\nfile = "side.exr"\nsize = "24x20"\nazimuth = 90\nannotate = false\n'


@pytest.fixture
def session():
    session = rs.Session()
    volume = blob(SHAPE, "float32")
    session.set_grid(volume.shape, volume.dtype)
    session.add_block((0, 0, 0), volume)
    session.volume = volume
    return session


def pictures(folder):
    return sorted(p.name for p in folder.iterdir() if p.suffix in (".png", ".exr"))


def test_pictures_come_at_their_steps_and_are_renders(session, tmp_path):
    actions = tmp_path / "actions.toml"
    actions.write_text(FRONT + SIDE)
    for step in range(5):
        session.act(actions, step)
        if step == 2:
            assert pictures(tmp_path) == ["front-000000.png", "front-000002.png"]
    assert pictures(tmp_path) == ["front-000000.png", "front-000002.png", "front-000004.png", "side.exr"]
    session.render(azimuth=90, size="24x20").save(tmp_path / "again.exr")
    assert (tmp_path / "again.exr").read_bytes() == (tmp_path / "side.exr").read_bytes()
    # Of the blocks as they are.
    session.volume *= 0.5
    session.act(str(actions), 6)
    assert (tmp_path / "front-000006.png").read_bytes() != (tmp_path / "front-000004.png").read_bytes()


def test_the_file_may_change_and_be_wrong_for_a_while(session, tmp_path, caplog):
    actions = tmp_path / "actions.toml"

    def told(text, step):
        if text is not None:
            actions.write_text(text)
        caplog.clear()
        session.act(actions, step)
        return caplog.text

    assert "cannot be read" in told(None, 0)
    assert told(None, 1) == ""  # once
    assert told(FRONT, 2) == "" and pictures(tmp_path) == ["front-000002.png"]
    for wrong, words in (("[front]\nevery = 0\n", "every must be a whole number from 1"), ("[front]\n", "has no file"),
                         ("every = 2\n", "belongs to no picture"), (FRONT + 'colour = "red"\n', "'--colour=red' is not expected here"),
                         (FRONT + "azimuth = [1, 2]\n", "--azimuth needs 1 values, not 2"), ("[front\n", "belongs to no picture")):
        said = told(wrong, 4)
        assert words in said and "what it said before counts" in said, said
    assert pictures(tmp_path) == ["front-000002.png", "front-000004.png"]
    actions.write_text("# pictures\n[front]  # of the front\nevery = 2  # steps" + FRONT.removeprefix("[front]\nevery = 2"))
    assert told(None, 5) == ""
    # What is found out only when it is drawn does not end the program either, nor keep other pictures from it.
    assert "the picture lost: " in told(FRONT.replace('"front-', '"nowhere/').replace("[front]", "[lost]") + FRONT, 10)
    assert "front-000010.png" in pictures(tmp_path)
    assert "the picture front: " in told(FRONT.replace("grey", "nowhere.json"), 6)
    assert told(FRONT, 8) == "" and "front-000008.png" in pictures(tmp_path)


def test_nothing_is_read_of_the_blocks_without_a_picture(session, tmp_path):
    (tmp_path / "actions.toml").write_text(FRONT)
    session.act(tmp_path / "actions.toml", 1)
    with pytest.raises(rs.InputError, match="no volume yet"):
        session.render(size=16)
    assert np.all(session.volume == blob(SHAPE, "float32")) and os.listdir(tmp_path) == ["actions.toml"]
