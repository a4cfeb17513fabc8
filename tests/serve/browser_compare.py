"""Two volumes in the page: side by side from one view, and their difference."""

import os
import tarfile

from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.keys import Keys

import browser_test
from browser_test import WithPage, run
from viewer_page import wait_for_file

SECOND = "document.getElementById('second')"


def two():
    """The first of two files; the tests name the other one as an option."""
    for name, shape in (("before", "shell"), ("after", "ball")):
        path = os.path.join(browser_test.scratch, f"{name}.nrrd")
        if not os.path.exists(path):
            run("synth", shape, "-o", path, "--dims", "40x40x40")
    return os.path.join(browser_test.scratch, "before.nrrd")


class Compare(WithPage):
    volume = staticmethod(two)

    @classmethod
    def setUpClass(cls):
        cls.options = (os.path.join(browser_test.scratch, "after.nrrd"), "--tf", "mr-soft")
        super().setUpClass()

    def picture(self, which):
        return self.page.js("return document.getElementById(arguments[0]).toDataURL('image/png')", which)

    def names(self):
        return [self.page.find(f"{which}-name").text for which in ("first", "second")]

    def test_two_volumes_turn_together_side_by_side(self):
        self.assertEqual(self.names(), ["before.nrrd", "after.nrrd"])
        self.page.press("a", "a")
        self.assertIsNone(self.page.facts("state.compare"))
        alone = self.page.measure()["width"]
        self.page.press("a")
        self.assertEqual(self.names(), ["before.nrrd", "after.nrrd"])
        size = self.page.js(f"return [app.stage.canvas.width, app.stage.canvas.height, {SECOND}.width, {SECOND}.height, {SECOND}.offsetLeft]")
        self.assertEqual(size[:2], size[2:4])
        self.assertAlmostEqual(size[0], alone / 2, delta=2)
        self.assertNotEqual(self.picture("picture"), self.picture("second"))
        # No picture comes without the other one of its view.
        self.page.js("window.views = []; const { take } = app.stage;"
                     "app.stage.take = async (head) => { views.push(head.pictures); return take.call(app.stage, head); }")
        before = [self.picture(which) for which in ("picture", "second")]
        for which, shift in (("picture", (120, 40)), ("second", (-60, 80))):
            self.page.drag(self.page.find(which), (0, 0), shift)
            self.page.settle()
        views = self.page.js("return views")
        self.assertEqual(set(views), {2})
        for old, which in zip(before, ("picture", "second")):
            self.assertNotEqual(old, self.picture(which))
        self.assertNotEqual(self.picture("picture"), self.picture("second"))

    def test_the_difference_is_that_of_the_two_pictures(self):
        self.page.press("a")
        self.page.wait("app.stage.shown.exact")
        self.page.settle()
        found = self.page.js("""
            const { bitmaps, width, height } = app.stage.shown, gain = Number(document.getElementById('difference').value);
            const data = (bitmap) => {
              const context = new OffscreenCanvas(width, height).getContext('2d');
              context.drawImage(bitmap, 0, 0);
              return context.getImageData(0, 0, width, height).data;
            };
            const [a, b] = bitmaps.map(data), shown = app.stage.contexts[0].getImageData(0, 0, width, height).data;
            let largest = 0, wrong = 0;
            for (let i = 0; i < a.length; ++i) {
              if (i % 4 === 3) continue;
              const d = Math.abs(a[i] - b[i]);
              largest = Math.max(largest, d);
              if (shown[i] !== Math.min(255, gain * d)) ++wrong;
            }
            return { largest, wrong, gain };""")
        self.assertEqual(found["wrong"], 0)
        self.assertGreater(found["largest"], 10)
        self.assertEqual(self.names()[0], f"|before.nrrd − after.nrrd| × {found['gain']}, largest {found['largest']} of 255")
        self.assertFalse(self.page.find("second").is_displayed())
        one = self.picture("picture")
        self.page.fill("difference", 16)
        self.page.settle()
        self.assertNotEqual(self.picture("picture"), one)
        self.assertEqual(self.page.facts("state.difference"), 16)
        # A plain picture, until the other one is there, is no difference.
        self.page.js("const { shown } = app.stage; app.stage.shown = { ...shown, bitmaps: [shown.bitmaps[0]], compare: null,"
                     "difference: undefined }; app.stage.drawNow()")
        self.assertEqual(self.names()[0], "before.nrrd")

    def test_the_control_is_reached_by_keys_and_undone(self):
        self.page.js("document.getElementById('compare').focus()")
        self.page.keys(Keys.ARROW_UP)  # not to the volume that is shown
        self.page.wait("ringsplat.state.compare === null")
        self.page.keys(Keys.ARROW_DOWN)
        self.page.wait("ringsplat.state.compare === 1")
        self.page.settle()
        self.page.keys(Keys.TAB)
        self.assertEqual(self.page.js("return document.activeElement.id"), "difference")
        self.page.keys(Keys.ARROW_DOWN)
        self.page.wait("ringsplat.state.difference === 1")
        self.page.settle()
        self.page.focus_picture()
        self.assertEqual(self.step_back(), [0, 1, 0])
        self.page.press("]")  # the two change places
        self.assertEqual(self.compared(), [1, 0, 0])
        self.assertEqual(self.names(), ["after.nrrd", "before.nrrd"])

    def step_back(self, *more):
        chain = ActionChains(self.page.driver)
        for key in (Keys.CONTROL, *more):
            chain.key_down(key)
        chain.send_keys("z")
        for key in (Keys.CONTROL, *more):
            chain.key_up(key)
        chain.perform()
        self.page.settle()
        return self.compared()

    def compared(self):
        return [self.page.facts(f"state.{key}") for key in ("frame", "compare", "difference")]

    def test_undo_never_compares_a_volume_with_itself(self):
        self.page.press("a", "]")
        self.assertEqual(self.compared(), [1, 0, 1])
        self.assertEqual(self.step_back(), [1, 0, 0])
        self.page.press("[")
        self.assertEqual(self.step_back(Keys.SHIFT), [0, 1, 1])

    def test_the_address_keeps_it_and_files_are_of_both(self):
        self.page.press("a")
        self.page.wait("location.hash.includes('difference')")
        expected = self.picture("picture")
        self.page.show(self.server.url + "&" + self.page.js("return location.hash.slice(1)"))
        self.page.settle()
        self.assertEqual(self.picture("picture"), expected)
        for key, value in (("snapshot-width", 64), ("snapshot-height", 48)):
            self.page.fill(key, value)
        self.page.press("v")
        with tarfile.open(wait_for_file(os.path.join(self.folder, "before-64x48-compared.tar"))) as archive:
            self.assertEqual(archive.getnames(), ["1-before.png", "2-after.png", "difference-x1.png"])
            for name in archive.getnames():
                self.assertEqual(archive.extractfile(name).read()[:4], b"\x89PNG")
        # As in a longer series, whose slider may come to the volume that is compared: one picture, and its colours.
        self.page.js("app.hello.frames.push('third'); app.scene.change({ compare: 0, difference: 1 })")
        self.page.settle()
        self.assertFalse(self.page.find("first-name").is_displayed())
        self.page.press("v")
        wait_for_file(os.path.join(self.folder, "before-64x48.png"))

    def test_a_value_is_of_the_picture_that_was_clicked(self):
        told = []
        for which in ("picture", "second"):
            self.page.js("app.probing.hide()")
            ActionChains(self.page.driver).double_click(self.page.find(which)).perform()
            self.page.wait("ringsplat.probe")
            told.append(self.page.find("probe").text.splitlines()[0])
        self.page.js("app.probing.hide(); document.getElementById('second').focus()")
        self.page.keys(Keys.ENTER)
        self.page.wait("ringsplat.probe")
        told.append(self.page.find("probe").text.splitlines()[0])
        self.assertEqual(told, ["before.nrrd", "after.nrrd", "after.nrrd"])

    def test_on_a_phone_one_is_above_the_other(self):
        self.page.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride",
                                         {"width": 390, "height": 780, "deviceScaleFactor": 1, "mobile": True})
        try:
            self.page.wait("app.stage.shown.bitmaps.length === 2 && app.stage.canvas.width === 390")
            self.page.settle()
            places = self.page.js(f"return [document.getElementById('picture'), {SECOND}].map(c => [c.offsetLeft, c.offsetTop, c.offsetWidth])")
            self.assertEqual([place[0] for place in places], [0, 0])
            self.assertAlmostEqual(places[1][1], self.page.js("return app.stage.canvas.clientHeight"), delta=3)
        finally:
            self.page.driver.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
