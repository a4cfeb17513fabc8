"""The page with several channels: their list, and what it makes of the picture."""

import json
import time
import types

from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

import browser_test
from browser_test import WithPage, jack
from channel_cases import make_channels
from viewer_page import wait_for_file


def cells():
    return make_channels(types.SimpleNamespace(scratch=browser_test.scratch))


class Channels(WithPage):
    volume, options = staticmethod(cells), ("--channel", "0,1,2")

    def field(self, name):
        return self.page.driver.find_element(By.CSS_SELECTOR, f"#channel-list [aria-label='{name}']")

    def put(self, name, value):
        self.page.js("const [f, value] = arguments; f.value = value; f.dispatchEvent(new Event(f.type === 'number' ? 'change' :"
                     "'input', {bubbles: true}))", self.field(name), value)
        self.page.settle()

    def tick(self, k):
        self.page.js("document.querySelectorAll('#channel-list [type=checkbox]')[arguments[0]].click()", k)
        self.page.settle()

    def look(self, k):
        return self.page.facts(f"state.channels[{k}]")

    def test_a_legend_of_what_is_seen_lies_over_the_picture(self):
        def cyan():
            self.page.settle()
            time.sleep(0.1)
            return self.page.js(
                "const c = document.getElementById('overlay'), q = c.getContext('2d').getImageData(0, 0, c.width, c.height).data;"
                "let n = 0; for (let i = 0; i < q.length; i += 4) n += q[i] === 0 && q[i + 1] === 255 && q[i + 2] === 255 && q[i + 3] === 255;"
                "return n")

        self.assertGreater(cyan(), 100)
        self.page.press("g")
        self.assertEqual(cyan(), 0)
        self.page.press("g")
        self.tick(0)
        self.assertEqual(cyan(), 0)
        self.tick(0)
        self.assertGreater(cyan(), 100)

    def test_a_channel_is_hidden_coloured_windowed_and_put_back(self):
        words = [row.text for row in self.page.driver.find_elements(By.CSS_SELECTOR, "#channel-list li")]
        self.assertEqual(words, ["channel 0", "channel 1", "channel 2"])
        self.assertFalse(self.page.find("curve").is_displayed())
        first = self.page.measure()["mean"]
        self.tick(1)
        self.tick(2)
        red, green, blue = self.page.measure()["mean"]
        self.assertLess(red, 5)
        self.assertAlmostEqual(green, blue, delta=5)  # cyan alone
        self.put("Colour of channel 0", "#ff0000")
        red, green, blue = self.page.measure()["mean"]
        self.assertGreater(red, 20)
        self.assertLess(max(green, blue), 5)
        self.put("channel 0 from, value", 3150)
        self.assertLess(self.page.measure()["n"], 300)
        self.put("channel 0 to, value", 100)  # not past the other end
        self.assertEqual(self.look(0)["window"][0], 3150)
        self.assertGreater(self.look(0)["window"][1], 3150)
        self.tick(0)
        self.assertEqual(self.page.measure()["n"], 0)
        self.page.click("undo")
        self.assertTrue(self.look(0)["visible"])
        self.page.press_button("reset-channels")
        self.assertEqual(self.page.facts("state.channels"), self.page.facts("hello.state.channels"))
        self.assertEqual(self.page.measure()["mean"], first)

    def test_keys_move_a_window_and_the_address_and_a_file_keep_it(self):
        slider = self.field("channel 1 from")
        self.page.js("arguments[0].focus()", slider)
        self.page.keys(Keys.ARROW_RIGHT, Keys.ARROW_RIGHT)
        self.page.settle()
        looks = self.page.facts("state.channels")
        self.assertGreater(looks[1]["window"][0], self.page.facts("hello.channels[1].windows.mip[0]"))
        self.page.wait("location.hash.includes('channels')")
        self.page.show(self.server.url + "&" + self.page.js("return location.hash.slice(1)"))
        self.assertAlmostEqual(self.look(1)["window"][0], looks[1]["window"][0], places=2)
        self.page.press("k")
        self.page.click("save-state")
        with open(wait_for_file(f"{self.folder}/cells-scene.json"), encoding="utf-8") as file:
            scene = json.load(file)
        self.assertEqual([len(s["channels"]) for s in (scene, *scene["key_frames"])], [3, 3])

    def test_modes_have_windows_of_their_own(self):
        self.put("channel 2 to, value", 2000)
        self.page.put("mode", "surface")
        self.assertEqual(self.look(2)["window"], self.page.facts("hello.channels[2].windows.surface"))
        self.assertFalse(self.field("channel 2 to").is_displayed())
        before = self.page.measure()["n"]
        self.put("channel 2 from, value", 3000)
        self.assertEqual(self.look(2)["window"], [3000, 3000])
        self.assertNotEqual(self.page.measure()["n"], before)
        self.page.put("mode", "mip")
        self.assertEqual(self.look(2)["window"][1], 2000)

    def test_light_can_be_that_of_materials(self):
        self.assertFalse(self.page.find("materials").is_displayed())
        self.page.put("mode", "composite")
        self.page.settle()
        added = self.page.measure()["mean"]
        self.page.click("materials")
        self.page.settle()
        self.assertTrue(self.page.facts("state.materials"))
        mixed = self.page.measure()["mean"]
        self.assertLess(sum(mixed), 0.97 * sum(added))
        self.page.click("undo")
        self.page.settle()
        self.assertEqual(self.page.measure()["mean"], added)

    def test_a_probe_tells_the_first_visible_channels_value(self):
        self.tick(0)
        self.page.press(Keys.ENTER)
        self.page.wait("ringsplat.probe")
        self.assertRegex(self.page.text("probe"), r"^channel 1 \d")

    def test_a_scene_of_another_volume_leaves_the_channels_alone(self):
        self.page.show(self.server.url + "&state=%7B%22channels%22%3A%5B%5D%2C%22light%22%3A%5B1%2C0%2C0%5D%7D")
        self.assertEqual(self.page.facts("state.light"), [1, 0, 0])
        self.assertEqual(self.page.facts("state.channels"), self.page.facts("hello.state.channels"))
        self.assertEqual(self.page.messages(), "")

    def test_fingers_find_the_list(self):
        driver = self.page.driver
        driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride",
                               {"width": 390, "height": 780, "deviceScaleFactor": 2, "mobile": True})
        try:
            self.page.show(self.server.url)
            self.page.js("document.getElementById('unfold').click()")
            boxes = self.page.js("return [...document.querySelectorAll('#channel-list :is(.tick, [type=color], [type=number], .dual)')]"
                                 ".map(e => e.getBoundingClientRect()).map(b => [b.width, b.height])")
            self.assertEqual(len(boxes), 15)
            self.assertGreaterEqual(min(min(box) for box in boxes), 24)
            self.assertLessEqual(self.page.js("return document.documentElement.scrollWidth"), 390)
        finally:
            self.page.js("localStorage.clear()")
            driver.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


class OneChannel(WithPage):
    volume, options = staticmethod(jack), ("--tf", "grey")

    def test_one_volume_has_no_list(self):
        self.assertFalse(self.page.find("channel-list").is_displayed())
        self.assertFalse(self.page.find("reset-channels").is_displayed())
        self.assertTrue(self.page.find("curve").is_displayed())
