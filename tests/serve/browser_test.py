#!/usr/bin/env python3
"""Drives the viewer's page in headless Chromium with a real server: browser_test.py --ringsplat BINARY [--launch "mpirun -n 4"]"""

import argparse
import base64
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
import unittest

SKIPPED = 77  # CTest's SKIP_RETURN_CODE
try:
    from selenium.webdriver.common.keys import Keys
except ImportError:
    Keys = None

arguments = None
scratch = None
HEAD = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "data", "head.nrrd")


def run(*command):
    return subprocess.run([arguments.ringsplat, *command], check=True, capture_output=True, text=True).stdout


def serve(volume, *options):
    from viewer_client import Server
    return Server([*shlex.split(arguments.launch), arguments.ringsplat, "serve", volume, *options])


def jack():
    """A volume with unequal arms along +x, +y and +z and a letter F, in patient coordinates."""
    path = os.path.join(scratch, "jack.nrrd")
    if not os.path.exists(path):
        run("synth", "jack", "-o", path, "--dims", "48x48x48")
    return path


class WithPage(unittest.TestCase):
    """One server and one browser for all tests of a class."""
    volume, options, size = staticmethod(jack), (), (1100, 800)

    @classmethod
    def setUpClass(cls):
        from viewer_page import Page
        cls.folder = tempfile.mkdtemp(dir=scratch)
        cls.server = serve(cls.volume(), *cls.options)
        cls.addClassCleanup(cls.server.stop)
        cls.page = Page(cls.size, cls.folder)
        cls.addClassCleanup(cls.page.quit)

    def setUp(self):
        self.page.show(self.server.url)
        self.page.wait("ringsplat.driving")
        self.page.settle()

    def camera(self):
        return self.page.facts("state.camera")


def pyramid():
    run("synth", "shell", "-o", os.path.join(scratch, "shell.nrrd"), "--dims", "96x96x96")
    run("pyramid", os.path.join(scratch, "shell.nrrd"), os.path.join(scratch, "shell.zarr"))
    return os.path.join(scratch, "shell.zarr")


class Parts(WithPage):
    volume, options = staticmethod(pyramid), ("--memory", "500K")

    def test_what_is_seen_is_shown_more_finely_and_the_whole_again(self):
        self.assertEqual(self.page.facts("hello.volume.dims"), [48, 48, 48])
        self.assertFalse(self.page.find("whole").is_displayed())
        self.page.put("azimuth", 10)
        self.page.put("zoom", 1.2)
        self.page.click("finer")
        self.page.wait("ringsplat.hello?.part === 1 && ringsplat.driving")
        self.assertIn("does not fit into the memory at a finer level", self.page.messages())
        self.assertEqual(self.camera()["zoom"], 1.2)
        self.page.put("zoom", 6)
        self.page.click("finer")
        self.page.wait("ringsplat.hello?.part === 2 && ringsplat.driving")
        self.page.settle()
        self.assertEqual(self.page.facts("hello.volume.spacing"), [1, 1, 1])
        self.assertLess(max(self.page.facts("hello.volume.dims")[::2]), 60)
        self.assertEqual(self.camera()["azimuth"], 10)
        self.assertLess(self.camera()["zoom"], 3)  # it fills the page
        self.assertGreater(self.page.measure()["n"], 1000)
        self.assertFalse(self.page.find("finer").is_displayed())
        self.page.click("whole")
        self.page.wait("ringsplat.hello?.part === 3 && ringsplat.driving")
        self.assertEqual(self.page.facts("hello.volume.dims"), [48, 48, 48])


class TheHead(WithPage):
    volume = staticmethod(lambda: HEAD)
    options = ("--tf", "mr-skin", "--background", "#20242c")

    def test_the_page_loads_without_a_console_message_or_another_request(self):
        self.assertEqual(self.page.log(), [])
        for name in self.page.js("return performance.getEntriesByType('resource').map(e => e.name)"):
            self.assertTrue(name.startswith(("data:", "blob:")), name)
        self.assertNotIn("#", self.page.js("return location.href"))

    def test_the_picture_at_rest_is_the_programs(self):
        self.page.fill("azimuth", 40)
        self.page.put("zoom", 1.3)
        data = self.page.js("return document.getElementById('picture').toDataURL('image/png')")
        shown, rendered = os.path.join(self.folder, "shown.png"), os.path.join(self.folder, "rendered.png")
        with open(shown, "wb") as file:
            file.write(base64.b64decode(data.split(",")[1]))
        size = self.page.js("const c = document.getElementById('picture'); return `${c.width}x${c.height}`")
        run("render", HEAD, "-o", rendered, "--quality", "best", "--size", size, "--tf", "mr-skin", "--background", "#20242c",
            "--azimuth", "40", "--fit", "sphere", "--zoom", "1.3")
        psnr = float(re.search(r"^all +\S+ +(\S+)", run("compare", shown, rendered), re.M).group(1))
        self.assertGreaterEqual(psnr, 45)

    def test_orientation_letters_of_a_patient_turn_with_the_hand(self):
        front = self.page.facts("letters")
        self.assertAlmostEqual(front["A"][2], 1)
        self.assertAlmostEqual(front["L"][0], 1)  # the patient's left is at the right of the picture
        self.page.pull((-100, 0), (200, 0))
        self.assertGreater(self.page.facts("letters")["A"][0], 0.3)

    def test_a_probe_tells_the_value_under_the_cursor(self):
        self.page.press(Keys.ENTER)
        self.page.wait("ringsplat.probe")
        found = self.page.facts("probe")
        self.assertTrue(found["hit"])
        self.assertTrue(all(0 <= v <= n for v, n in zip(found["voxel"], (128, 128, 124))), found)
        self.assertIn("value", self.page.text("probe-words"))

    def test_the_scale_bar_has_the_volumes_unit(self):
        bar, side = self.page.facts("scale"), min(self.page.measure()[k] for k in ("width", "height"))
        diagonal = sum((n * s) ** 2 for n, s in zip((128, 128, 124), self.page.facts("hello.volume.spacing"))) ** 0.5
        self.assertAlmostEqual(bar["pixels"], bar["length"] * side / diagonal * self.camera()["zoom"], delta=0.5)


class Turning(WithPage):
    def test_a_drag_to_the_right_turns_the_volume_to_the_right(self):
        self.page.press("6", "5")  # from above: +x to the right, +y up
        before = self.page.measure()
        self.page.press("1")
        for turning in ("trackball", "turntable"):
            self.page.js("document.querySelector(`[value=${arguments[0]}]`).click()", turning)
            self.page.press("1")
            self.page.pull((-60, 0), (120, 0))
            letters = self.page.facts("letters")
            self.assertGreater(letters["A"][0], 0.2, turning)  # the side that faced the viewer went right
            self.assertLess(self.camera()["azimuth"], -5, turning)
            self.page.pull((0, -40), (0, 80))
            self.assertLess(self.page.facts("letters")["A"][1], -0.1, turning)  # and now down
        self.assertGreater(before["n"], 0)

    def test_pixels_move_as_the_letters_do(self):
        self.page.press("1")  # the longest arm, +x, points right
        right = self.page.measure()
        self.page.press("2")
        left = self.page.measure()
        middle = 0.5 * right["width"]
        self.assertGreater(right["box"][2] - middle, middle - right["box"][0])
        self.assertAlmostEqual(right["box"][2] - middle, middle - left["box"][0], delta=6)
        self.page.press("1")
        for _ in range(4):
            self.page.drag(self.page.find("picture"), (-100, 0), (100, 0))
        self.page.settle()
        angle = self.camera()["azimuth"]
        self.page.fill("azimuth", 0)
        self.assertLess(angle, -30)

    def test_turning_by_a_drag_and_back_ends_where_it_began(self):
        begin = self.page.facts("letters")
        for shift in ((110, 0), (0, 70), (0, -70), (-110, 0)):
            self.page.drag(self.page.find("picture"), (0, 0), shift)
        for letter, place in self.page.facts("letters").items():
            for now, then in zip(place, begin[letter]):
                self.assertAlmostEqual(now, then, places=4)

    def test_six_views_look_from_six_sides(self):
        seen = []
        for key, letter in zip("123456", "APLRHF"):
            self.page.press(key)
            self.assertAlmostEqual(self.page.facts("letters")[letter][2], 1, places=4)
            seen.append(tuple(self.page.measure()["box"]))
        self.assertGreater(len(set(seen)), 4)
        self.page.js("document.querySelector('#six-views button:nth-child(3)').click()")
        self.page.settle()
        self.assertEqual(self.camera()["azimuth"], 90)

    def test_pan_zoom_and_roll_move_the_picture(self):
        start = self.page.measure()
        self.page.pull((0, 0), (100, 50), modifier=Keys.SHIFT)
        panned = self.page.measure()
        self.assertAlmostEqual((panned["x"] - start["x"]) * start["width"], 100, delta=3)
        self.assertAlmostEqual((panned["y"] - start["y"]) * start["height"], 50, delta=3)
        self.page.press("r", "+", "+", "+")
        zoomed = self.page.measure()
        self.assertAlmostEqual(zoomed["n"] / start["n"], 1.1 ** 6, delta=0.2)
        self.page.press("r")
        self.page.put("roll", 90)
        box = self.page.measure()["box"]  # clockwise: what was right is down
        self.assertAlmostEqual(box[3] - start["height"] / 2, start["box"][2] - start["width"] / 2, delta=3)

    def test_the_wheel_zooms_to_the_cursor(self):
        from selenium.webdriver.common.actions.wheel_input import ScrollOrigin
        from selenium.webdriver.common.action_chains import ActionChains
        before = self.camera()
        origin = ScrollOrigin.from_element(self.page.find("picture"), 120, -60)
        ActionChains(self.page.driver).scroll_from_origin(origin, 0, -300).perform()
        self.page.settle()
        after, side = self.camera(), min(self.page.measure()[k] for k in ("width", "height"))
        factor = after["zoom"] / before["zoom"]
        self.assertGreater(factor, 1.3)
        for k, cursor in enumerate((120, -60)):
            self.assertAlmostEqual(after["pan"][k], cursor / side * (1 - factor), delta=0.004)

    def test_a_pan_shows_at_once_as_the_server_draws_it_later(self):
        grab = "return [...document.getElementById('picture').getContext('2d').getImageData(300, 200, 200, 200).data]"
        self.page.pull((0, 0), (40, 20), modifier=Keys.SHIFT)
        real = self.page.js(grab)
        self.page.press("r")
        # The server's answers are held back: what is seen is the page's own transform.
        self.page.js("window.blocked = createImageBitmap; window.createImageBitmap = () => new Promise(() => {})")
        self.page.drag(self.page.find("picture"), (0, 0), (40, 20), modifier=Keys.SHIFT)
        time.sleep(0.2)
        preview = self.page.js(grab)
        self.page.js("window.createImageBitmap = window.blocked")
        error = sum((a - b) ** 2 for a, b in zip(real, preview)) / len(real)
        self.assertLess(error, 12)


def have_browser():
    missing = [name for name, there in (("python3-selenium", Keys), ("chromium", shutil.which("chromium") or
                                        shutil.which("chromium-browser")),
                                        ("chromium-driver", shutil.which("chromedriver"))) if not there]
    if missing:
        print("skipped: install " + ", ".join(missing))
    return not missing


def main():
    global arguments, scratch
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--ringsplat", required=True, help="the program")
    parser.add_argument("--faults", help="what is preloaded to make files do as a test wants")
    parser.add_argument("--launch", default="", help="what starts it, such as 'mpirun -n 4'")
    parser.add_argument("--screenshots", metavar="DIR", help="write pictures of the page there instead of testing")
    parser.add_argument("tests", nargs="*", help="names of tests; all without")
    arguments = parser.parse_args()
    if not have_browser():
        return SKIPPED
    sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
    sys.modules["browser_test"] = sys.modules["__main__"]
    import browser_channels
    import browser_compare
    import browser_controls
    import browser_link
    import browser_page
    import browser_series
    import browser_session
    with tempfile.TemporaryDirectory(prefix="ringsplat-browser-") as scratch_folder:
        scratch = scratch_folder
        if arguments.screenshots:
            import browser_screenshots
            browser_screenshots.write(arguments.screenshots)
            return 0
        loader = unittest.defaultTestLoader
        modules = [sys.modules["__main__"], browser_channels, browser_compare, browser_controls, browser_link, browser_page, browser_series, browser_session]
        suite = unittest.TestSuite(loader.loadTestsFromModule(module) for module in modules)
        if arguments.tests:
            suite = unittest.TestSuite(test for test in flat(suite) if any(name in test.id() for name in arguments.tests))
        result = unittest.TextTestRunner(verbosity=2).run(suite)
        return 0 if result.wasSuccessful() else 1


def flat(suite):
    for test in suite:
        if isinstance(test, unittest.TestSuite):
            yield from flat(test)
        else:
            yield test


if __name__ == "__main__":
    sys.exit(main())
