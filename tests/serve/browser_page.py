"""What the page keeps, undoes and warns of, how it lies in windows, and lists of labels."""

import os

import browser_test
from browser_test import HEAD, WithPage, jack

RATIO = """
const panel = getComputedStyle(document.getElementById('panel')).backgroundColor;
const light = (text) => text.match(/[0-9.]+/g).slice(0, 3).map(c => c / 255)
  .map(c => c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4).reduce((sum, c, k) => sum + [0.2126, 0.7152, 0.0722][k] * c, 0);
return [...document.querySelectorAll('#panel :is(input:not([type=range], [type=radio], [type=checkbox]), select, button)')]
  .map(e => { const [a, b] = [light(getComputedStyle(e).borderTopColor), light(panel)].sort(); return (b + 0.05) / (a + 0.05); });
"""
SMALL = """
return [...document.querySelectorAll('button, input, select, summary, canvas[tabindex]')].filter(e => e.checkVisibility())
  .filter(e => Math.min(e.getBoundingClientRect().width, e.getBoundingClientRect().height) < 24).map(e => e.outerHTML);
"""


class Keeping(WithPage):
    volume = staticmethod(jack)

    def test_a_reload_keeps_key_frames_a_new_visit_does_not(self):
        self.page.press("1", "k")
        self.page.press("3", "k")
        self.page.driver.refresh()
        self.page.settle()
        self.assertEqual(self.page.facts("keyFrames"), 2)
        self.page.show(self.server.url)
        self.assertEqual(self.page.facts("keyFrames"), 0)
        self.page.driver.refresh()
        self.page.settle()
        self.assertEqual(self.page.facts("keyFrames"), 0)

    def test_leaving_asks_while_a_film_is_rendered(self):
        leave = ("const e = new Event('beforeunload', {cancelable: true}); dispatchEvent(e); return e.defaultPrevented")
        self.assertFalse(self.page.js(leave))
        self.page.key_frames_of_film(300, 64, 48)
        self.page.click("render-film")
        self.page.wait("document.getElementById('film-progress').value > 1")
        self.assertTrue(self.page.js(leave))
        self.page.click("render-film")
        self.page.wait("document.getElementById('film-words').textContent === 'cancelled'")
        self.assertFalse(self.page.js(leave))

    def test_undo_takes_back_camera_clip_and_light(self):
        start = self.page.facts("state")
        self.page.pull((0, 0), (120, 40))
        turned = self.page.facts("state")
        self.page.press("c")
        self.page.put("light-right", 0.9)
        for key in ("light", "clip"):
            self.assertNotEqual(self.page.facts("state")[key], start[key])
            self.page.click("undo")
            self.assertEqual(self.page.facts("state")[key], start[key])
        self.assertEqual(self.page.facts("state"), turned)
        self.page.click("undo")
        self.assertEqual(self.page.facts("state"), start)
        self.assertFalse(self.page.find("undo").is_enabled())
        self.page.click("redo")
        self.assertEqual(self.page.facts("state"), turned)
        self.page.settle()

    def test_a_wider_or_lower_window_keeps_transparent_values_transparent(self):
        tf = {"name": "edited", "colours": [[0, 1, 1, 1], [255, 1, 1, 1]],
              "opacities": [[0, 0], [60, 0], [120, 0.9], [200, 0]]}
        for factor, shift in ((4, 0), (1, -100), (2, 100)):
            moved = self.page.module("transfer_function.js", f"m.windowed({tf}, {factor}, {shift})")
            for value in (0, 30, 59, 201, 255):
                seen = self.page.module("transfer_function.js", f"m.opacityAt({moved}, {value})")
                self.assertEqual(seen, 0, (factor, shift, value))
        self.assertFalse([p["name"] for p in self.page.facts("hello.presets") if p["name"].startswith("ct-")])


class Layout(WithPage):
    volume, options = staticmethod(lambda: HEAD), ("--bind", "0.0.0.0")

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.server.url = f"http://127.0.0.1:{cls.server.port}/#{cls.server.url.split('#')[1]}"

    def phone(self):
        self.page.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride",
                                         {"width": 390, "height": 844, "deviceScaleFactor": 1, "mobile": True})
        self.addCleanup(self.page.driver.execute_cdp_cmd, "Emulation.clearDeviceMetricsOverride", {})
        self.page.js("localStorage.clear()")
        self.page.show(self.server.url)

    def test_the_jobs_warnings_show(self):
        self.assertIn("everybody who can reach this machine", self.page.messages())

    def test_the_first_view_fills_the_page(self):
        seen = self.page.measure()
        width, height = ((seen["box"][k + 2] - seen["box"][k]) / seen[side] for k, side in ((0, "width"), (1, "height")))
        self.assertGreater(max(width, height), 0.9)
        self.assertLess(max(width, height), 0.98)

    def test_the_status_is_in_plain_words(self):
        self.assertRegex(self.page.text("facts"), r"^\d+ ms, full quality$")

    def test_help_begins_at_its_top(self):
        self.page.click("show-help")
        top, title = self.page.js("return ['help', 'help-title'].map(id => document.getElementById(id).getBoundingClientRect().top)")
        self.assertGreaterEqual(title, top)
        self.page.js("document.getElementById('help').close()")

    def test_fields_are_seen_in_both_themes(self):
        for theme in ("dark", "light"):
            self.page.fill("theme", theme)
            self.assertGreaterEqual(min(self.page.js(RATIO)), 3, theme)
        self.page.fill("theme", "auto")

    def test_a_phone_has_nothing_covered_cut_off_or_too_small(self):
        self.phone()
        bar = self.page.facts("scale")["pixels"]
        button = self.page.find("unfold").rect
        self.assertGreater(button["x"], 16 + max(bar, 60))  # the colour bar's numbers are narrower
        cube = self.page.find("cube").rect
        self.assertLessEqual(button["x"] + button["width"], cube["x"])
        cut = "const e = document.getElementById(arguments[0]); return e.scrollWidth > e.clientWidth"
        self.assertFalse(self.page.js(cut, "status"))
        self.page.press_button("unfold")
        self.assertFalse(self.page.js(cut, "volume-facts"))
        self.page.js("document.querySelectorAll('details').forEach(e => e.setAttribute('open', ''))")
        self.assertEqual(self.page.js(SMALL), [])


def segmentation():
    """Five labels in layers, named as 3D Slicer does."""
    path = os.path.join(browser_test.scratch, "organs.seg.nrrd")
    names = ["liver", "spleen", "left kidney", "right kidney"]  # the fifth has no name
    keys = "".join(f"Segment{k}_LabelValue:={k + 1}\nSegment{k}_Name:={name}\n" for k, name in enumerate(names))
    with open(path, "wb") as file:
        file.write(f"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 24 24 24\nencoding: raw\n{keys}\n".encode())
        for z in range(24):
            file.write(bytes((1 + z // 5 if 4 <= min(x, y) and max(x, y) < 20 else 0) for y in range(24) for x in range(24)))
    return path


class Labels(WithPage):
    volume = staticmethod(segmentation)

    def rows(self):
        return self.page.js("return [...document.querySelectorAll('#label-list li')].map(r => "
                            "[r.textContent.trim(), r.querySelector('[type=checkbox]').checked])")

    def test_labels_are_listed_in_place_of_the_curve(self):
        self.assertEqual(self.rows(), [[name, True] for name in ("liver1", "spleen2", "left kidney3", "right kidney4", "label 5")])
        self.assertFalse(self.page.find("curve").is_displayed())

    def opacities(self):
        return [self.page.module("transfer_function.js", f"m.opacityAt(ringsplat.state.transfer_function, {value})")
                for value in range(6)]

    def test_a_label_is_hidden_coloured_and_shown_again(self):
        box, colour = self.page.js("const r = document.querySelectorAll('#label-list li')[1];"
                                   "return [r.querySelector('[type=checkbox]'), r.querySelector('[type=color]')]")
        box.click()
        self.page.settle()
        self.assertEqual([seen for _, seen in self.rows()], [True, False, True, True, True])
        self.assertEqual(self.opacities(), [0, 0.9, 0, 0.9, 0.9, 0.9])
        self.page.press_button("no-labels")
        self.assertEqual(self.page.measure()["n"], 0)
        box.click()
        self.page.js("document.getElementById('shading').checked && document.getElementById('shading').click();"
                     "arguments[0].value = '#ff0000'; arguments[0].dispatchEvent(new Event('change'))", colour)
        self.page.settle()
        self.assertEqual(self.opacities(), [0, 0, 0.9, 0, 0, 0])
        red, green, blue = self.page.measure()["mean"]
        self.assertGreater(red, 5 * max(green, blue))
        self.page.click("all-labels")
        self.page.wait("document.querySelectorAll('#label-list :checked').length === 5")
        self.assertEqual(self.opacities(), [0] + 5 * [0.9])


class Segments(WithPage):
    @classmethod
    def setUpClass(cls):
        cls.volume = staticmethod(lambda: cls.path)
        cls.path = os.path.join(browser_test.scratch, "scan.nrrd")
        browser_test.run("synth", "ball", "-o", cls.path, "--dims", "24x24x24")
        cls.options = ("--tf", "grey", "--shading", "none", "--mask", segmentation(), "--mask-as", "tint")
        super().setUpClass()

    def tints(self):
        return self.page.facts("state.tints")

    def rows(self, what):
        return self.page.js("return [...document.querySelectorAll('#label-list li')].map(r => r.querySelector(arguments[0]))", what)

    def test_labels_are_listed_beside_the_curve_hidden_and_coloured(self):
        self.assertTrue(self.page.find("curve").is_displayed())
        self.assertEqual([row.text for row in self.rows(".tick")],
                         ["liver", "spleen", "left kidney", "right kidney", "label 5"])
        self.assertEqual([label for label, *_ in self.tints()], [1, 2, 3, 4, 5])
        tinted = self.page.measure()["mean"]
        self.page.press_button("no-labels")
        self.assertEqual([share for *_, share in self.tints()], 5 * [0])
        red, green, blue = plain = self.page.measure()["mean"]
        self.assertNotEqual(plain, tinted)
        self.assertAlmostEqual(red, blue, delta=2)  # grey
        self.page.click("all-labels")
        for colour in self.rows("[type=color]"):
            self.page.js("arguments[0].value = '#ff0000'; arguments[0].dispatchEvent(new Event('change'))", colour)
        self.page.settle()
        red, green, blue = self.page.measure()["mean"]
        self.assertGreater(red, 1.2 * green)
        self.rows("[type=checkbox]")[2].click()
        self.page.settle()
        self.assertEqual([share > 0 for *_, share in self.tints()], [True, True, False, True, True])
        self.page.wait("/tints/.test(location.hash) && String(JSON.parse(decodeURIComponent(location.hash.split('state=')[1])).tints"
                       ".map((tint) => tint[4] > 0)) === 'true,true,false,true,true'")
        tints = self.tints()
        self.page.show(self.server.url + "&" + self.page.js("return location.hash.slice(1)"))
        self.assertEqual([round(share, 3) for *_, share in self.tints()], [round(share, 3) for *_, share in tints])
