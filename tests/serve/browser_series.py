"""The page with a series of volumes: the slider, its keys, playing, and the address."""

import os
import time

from selenium.webdriver.common.keys import Keys

import browser_test
from browser_test import WithPage, run

SHAPES = ("gaussians", "shell", "ball", "box")


def series():
    """One after the other in the folder of all tests."""
    for number, shape in enumerate(SHAPES):
        path = os.path.join(browser_test.scratch, f"step_{number}.nrrd")
        if not os.path.exists(path):
            run("synth", shape, "-o", path, "--dims", "40x40x40")
    return os.path.join(browser_test.scratch, "step_*.nrrd")


class Series(WithPage):
    volume, options = staticmethod(series), ("--frames", "all", "--tf", "mr-soft")

    def pixels(self):
        self.page.settle()
        return self.page.js("return document.getElementById('picture').toDataURL('image/png')")

    def test_the_slider_shows_each_volume(self):
        seen = []
        for frame in range(len(SHAPES)):
            self.page.fill("frame", frame)
            self.page.wait(f"ringsplat.frame === {frame}")
            seen.append(self.pixels())
            self.assertIn(f"step_{frame}.nrrd", self.page.text("frame-name"))
        self.assertEqual(len(set(seen)), len(SHAPES))
        self.page.fill("frame", 1)
        self.assertEqual(self.pixels(), seen[1])
        self.assertEqual(self.page.text("frame-words"), "")

    def test_keys_step_through_the_volumes_and_stop_at_the_ends(self):
        self.page.press("]", "]")
        self.assertEqual(self.page.facts("state.frame"), 2)
        self.page.press("]", "]", "]")
        self.assertEqual(self.page.facts("state.frame"), len(SHAPES) - 1)
        self.page.press("[")
        self.assertEqual(self.page.facts("state.frame"), len(SHAPES) - 2)
        self.page.js("document.getElementById('frame').focus()")
        self.page.keys(Keys.ARROW_LEFT)
        self.page.settle()
        self.assertEqual(self.page.facts("state.frame"), len(SHAPES) - 3)
        self.assertIn("step_1.nrrd", self.page.find("frame").get_attribute("aria-valuetext"))

    def test_playing_shows_every_volume_and_begins_again(self):
        self.page.fill("frame-rate", 20)
        self.page.js("window.seen = new Set(); window.watch = setInterval(() => seen.add(ringsplat.frame), 5)")
        self.page.click("frame-play")
        self.page.wait(f"seen.size === {len(SHAPES)}", 30)
        self.assertEqual(self.page.find("frame-play").get_attribute("aria-pressed"), "true")
        self.page.wait("ringsplat.frame === 1", 30)
        self.page.click("frame-play")
        self.page.js("clearInterval(watch)")
        self.page.settle()
        frame = self.page.facts("frame")
        time.sleep(0.3)
        self.assertEqual(self.page.facts("state.frame"), frame)

    def test_the_address_has_the_frame_and_one_beyond_the_end_shows_the_last(self):
        self.page.fill("frame", 2)
        self.page.wait("location.hash.includes('frame')")
        expected = self.pixels()
        self.page.show(self.server.url + "&" + self.page.js("return location.hash.slice(1)"))
        self.assertEqual(self.page.facts("state.frame"), 2)
        self.assertEqual(self.pixels(), expected)
        self.page.show(self.server.url + "&state=%7B%22frame%22%3A99%7D")
        self.assertEqual(self.page.facts("state.frame"), len(SHAPES) - 1)

    def test_a_film_goes_through_the_volumes(self):
        self.page.press("k", "]", "]", "k")
        frames = self.page.module("spline.js", "[0, 0.2, 0.5, 0.8, 1].map(t => m.sceneAt([{...ringsplat.state, frame: 0},"
                                  "{...ringsplat.state, frame: 2}], t, [40, 40, 40]).frame)")
        self.assertEqual(frames, [0, 0, 1, 2, 2])
        self.page.fill("film-seconds", 0.4)
        self.page.focus_picture()
        self.page.press("[", " ")
        self.page.wait("document.getElementById('play').getAttribute('aria-pressed') === 'false'")
        self.page.settle()
        self.assertEqual(self.page.facts("frame"), 2)


class OneVolume(WithPage):
    def test_a_single_volume_has_no_slider(self):
        self.assertFalse(self.page.find("series").is_displayed())
        self.page.press("]", "l")
        self.assertEqual(self.page.facts("state.frame"), 0)
        self.assertFalse(self.page.facts("playing"))
