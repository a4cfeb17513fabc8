"""Each control does what it says, by pixels."""

import json
import os
import time

from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.keys import Keys

from browser_test import WithPage, jack
from viewer_page import wait_for_file


class Controls(WithPage):
    volume, options = staticmethod(jack), ("--tf", "grey")  # not the labels that a mask has otherwise

    def tf(self):
        return self.page.facts("state.transfer_function")

    def put_tf(self, opacities, colours=((0, 1, 1, 1), (255, 1, 1, 1))):
        """By the page's own reading of a ParaView map. Each has a name of its own, by which it is seen to be there."""
        self.maps = getattr(self, "maps", 0) + 1
        name = f"test {self.maps}"
        text = json.dumps([{"ColorSpace": "RGB", "Name": name, "RGBPoints": [v for p in colours for v in p],
                            "Points": [v for value, opacity in opacities for v in (value, opacity, 0.5, 0)]}])
        path = os.path.join(self.folder, "map.json")
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
        self.page.open_file("import-tf", path)
        self.page.wait("ringsplat.state.transfer_function.name === '" + name + "'")
        self.page.settle()

    def test_an_opacity_point_can_be_added_dragged_and_deleted(self):
        curve, points = self.page.find("curve"), len(self.tf()["opacities"])
        before = self.page.measure()
        self.page.js("document.getElementById('curve').scrollIntoView({block: 'center'})")
        self.page.drag(curve, (70, -40), (0, 0))
        self.page.settle()
        self.assertEqual(len(self.tf()["opacities"]), points + 1)
        self.page.drag(curve, (70, -40), (0, 80))
        self.page.settle()
        moved = self.tf()["opacities"]
        self.assertEqual(len(moved), points + 1)
        self.assertNotEqual(self.page.measure()["mean"], before["mean"])
        self.page.click("point-delete")
        self.assertEqual(len(self.tf()["opacities"]), points)

    def test_opacity_shows_and_hides_the_volume(self):
        self.put_tf([(0, 0), (20, 0), (40, 0.9), (255, 0.9)])
        self.assertGreater(self.page.measure()["n"], 1000)
        self.put_tf([(0, 0), (255, 0)])
        self.assertEqual(self.page.measure()["n"], 0)

    def test_a_stops_colour_is_the_pictures(self):
        self.put_tf([(0, 0), (20, 0), (40, 0.9), (255, 0.9)])
        for key in (Keys.HOME, Keys.END):
            self.page.js("document.getElementById('strip').focus()")
            self.page.keys(key)
            self.page.fill("point-colour", "#ff0000")
        self.page.js("document.getElementById('shading').checked && document.getElementById('shading').click()")
        self.page.settle()
        red, green, blue = self.page.measure()["mean"]
        self.assertGreater(red, 100)
        self.assertLess(max(green, blue), 0.2 * red)

    def test_presets_maps_undo_and_redo(self):
        first = self.tf()
        self.page.fill("presets", "mr-soft")
        soft = self.tf()
        self.assertEqual(soft["name"], "mr-soft")
        self.page.put("maps", "viridis")
        self.assertEqual(len(self.tf()["colours"]), 10)
        self.page.click("undo")
        self.assertEqual(self.tf(), soft)
        self.page.focus_picture()
        ActionChains(self.page.driver).key_down(Keys.CONTROL).send_keys("z").key_up(Keys.CONTROL).perform()
        self.assertEqual(self.tf(), first)
        self.page.click("redo")
        self.assertEqual(self.tf(), soft)

    def test_the_selected_points_fields_edit_it(self):
        self.page.js("document.getElementById('curve').focus()")
        self.page.keys(Keys.HOME)
        self.page.fill("point-opacity", 0.25)
        self.assertEqual(self.tf()["opacities"][0][1], 0.25)
        self.page.js("document.getElementById('curve').focus()")
        self.page.keys(Keys.ARROW_UP, Keys.ARROW_UP)
        self.assertAlmostEqual(self.tf()["opacities"][0][1], 0.27)

    def test_proved_errors_lie_over_the_picture_until_it_changes(self):
        button = self.page.find("errors")
        self.page.js("document.getElementById('errors').closest('details').open = true")
        words = "document.getElementById('errors-words').textContent"
        for ends in (lambda: self.page.fill("azimuth", 41), lambda: self.page.click("errors")):
            self.page.click("errors")
            self.page.wait("app.errors.shown", 60)
            self.assertRegex(self.page.js(f"return {words}"), r"^No pixel of \d+ x \d+ errs more than [\d.]+/255, [\d.]+ % at most 1\. ")
            self.assertEqual(button.get_attribute("aria-pressed"), "true")
            ends()
            self.page.wait(f"!app.errors.shown && {words} === ''")
            self.assertEqual(button.get_attribute("aria-pressed"), "false")
            self.page.settle()

    def test_slices_lie_beside_the_volume_and_meet_in_one_voxel(self):
        def at():
            return self.page.facts("slices.at")

        def await_value():
            self.page.wait("ringsplat.slices.words.length > 0")
            return self.page.text("probe-words")

        wide = self.page.js("return document.getElementById('picture').clientWidth")
        self.page.focus_picture()
        self.page.keys("q")
        self.page.wait("ringsplat.slices.drawn")
        self.assertLess(self.page.js("return document.getElementById('picture').clientWidth"), 0.51 * wide)
        dims = self.page.facts("hello.volume.dims")
        self.assertEqual(at(), [count // 2 for count in dims])
        panes = self.page.driver.find_elements("css selector", "#slices canvas")  # across z, y and x
        ActionChains(self.page.driver).move_to_element_with_offset(panes[0], 40, 30).click().perform()
        x, y, z = at()
        self.assertEqual(z, dims[2] // 2)
        self.assertNotIn(dims[0] // 2, (x,))
        self.assertNotIn(dims[1] // 2, (y,))
        self.assertIn(f"voxel {x}, {y}, {z}; value ", await_value())
        self.page.js("arguments[0].focus()", panes[0])
        self.page.keys(Keys.PAGE_UP, Keys.PAGE_UP, Keys.PAGE_DOWN)
        self.assertEqual(at(), [x, y, z + 1])
        self.page.js("arguments[0].dispatchEvent(new WheelEvent('wheel', { deltaY: 100, cancelable: true }))", panes[2])
        self.assertEqual(at(), [x + 1, y, z + 1])
        # Across the view: a click right of the cross goes along the picture's right, a turn shows another slice.
        self.page.click("show-oblique")
        self.page.wait("ringsplat.slices.drawn && app.slices.panes[3].bitmap")
        self.assertTrue(self.page.js("return arguments[0].hidden", panes[2]))
        self.page.press("1")  # +x is right
        self.page.js("app.slices.goTo([24, 24, 24])")
        cross = self.page.js("return app.slices.panes[3].cross()")
        width, height = self.page.js("return [arguments[0].clientWidth, arguments[0].clientHeight]", panes[3])
        ActionChains(self.page.driver).move_to_element_with_offset(
            panes[3], round(cross[0] - width / 2 + 30), round(cross[1] - height / 2 - 20)).click().perform()
        self.assertGreater(at()[0], 25)
        self.assertEqual(at()[1], 24)
        self.assertGreater(at()[2], 24)
        self.page.js("arguments[0].focus()", panes[3])
        self.page.keys(Keys.PAGE_UP)
        self.assertNotEqual(at()[1], 24)
        self.page.click("show-oblique")
        self.page.js("app.slices.goTo([arguments[0], arguments[1], arguments[2]])", x + 1, y, z + 1)
        # A place of the volume that was asked for is where they meet.
        ActionChains(self.page.driver).double_click(self.page.find("picture")).perform()
        self.page.wait("ringsplat.probe !== null")
        self.assertTrue(self.page.facts("probe.hit"))
        self.assertEqual(at(), [round(v) for v in self.page.facts("probe.voxel")])
        self.page.focus_picture()
        self.page.keys("q")
        self.assertEqual(self.page.js("return document.getElementById('picture').clientWidth"), wide)

    def test_the_right_button_sets_window_and_level(self):
        before = self.tf()["opacities"]
        self.page.drag(self.page.find("picture"), (0, 0), (120, 0), button=2)
        wide = self.tf()["opacities"]
        self.assertGreater(wide[-1][0] - wide[0][0], 1.1 * (before[-1][0] - before[0][0]))
        self.page.drag(self.page.find("picture"), (0, 0), (0, -80), button=2)
        for high, low in zip(self.tf()["opacities"], wide):
            self.assertGreater(high[0], low[0])
        self.page.settle()

    def test_a_map_is_saved_as_paraview_reads_it(self):
        self.page.click("export-tf")
        path = wait_for_file(os.path.join(self.folder, self.tf()["name"] + ".json"))
        with open(path, encoding="utf-8") as file:
            only, = json.load(file)
        self.assertEqual(only["ColorSpace"], "RGB")
        self.assertEqual(only["Points"][2:4], [0.5, 0])
        self.assertEqual(len(only["RGBPoints"]), 4 * len(self.tf()["colours"]))

    def test_light_from_the_other_side_lights_the_other_side(self):
        self.put_tf([(0, 0), (20, 0), (40, 0.95), (255, 0.95)])
        grab = ("const c = document.getElementById('picture'), q = c.getContext('2d').getImageData(0, 0, c.width, c.height).data;"
                "let s = 0; for (let i = 0; i < q.length; i += 4) s += q[i]; return s / (q.length / 4)")
        for field, value in (("light-right", 0), ("light-up", 0), ("light-front", 1)):
            self.page.fill(field, value)
        self.page.settle()
        front = self.page.js(grab)
        pad = self.page.find("light-pad")
        self.page.js("document.getElementById('light-pad').scrollIntoView({block: 'center'})")
        self.page.drag(pad, (0, 0), (40, 0))
        self.page.settle()
        self.assertGreater(self.page.facts("state.light")[0], 0.8)
        self.assertLess(self.page.js(grab), 0.93 * front)

    def test_clip_sliders_numbers_and_handles_cut_the_volume(self):
        whole = self.page.measure()
        self.page.press("1")
        self.page.press_button("clip-on")
        self.assertEqual(self.page.facts("state.clip"), [[0, 48]] * 3)
        self.assertAlmostEqual(self.page.measure()["n"], whole["n"], delta=0.01 * whole["n"] + 5)
        number = self.page.driver.find_element("css selector", "[aria-label='Clip x to, voxels']")
        self.page.js("arguments[0].value = 24; arguments[0].dispatchEvent(new Event('change'))", number)
        self.page.settle()
        self.assertEqual(self.page.facts("state.clip")[0], [0, 24])
        cut = self.page.measure()
        self.assertLess(cut["box"][2], 0.5 * cut["width"] + 3)  # nothing is left of the long arm along +x
        handle = self.page.driver.find_element("css selector", "#clip-handles [title='x to']")
        self.page.drag(handle, (0, 0), (-60, 0))
        self.page.settle()
        self.assertLess(self.page.facts("state.clip")[0][1], 22)
        self.page.click("clip-whole")
        self.assertEqual(self.page.facts("state.clip"), [[0, 48]] * 3)

    def test_clip_planes_stand_across_the_view_and_are_moved_along_it(self):
        self.page.press("1")
        whole = self.page.measure()["n"]
        self.page.press_button("add-plane")
        self.assertEqual([round(number, 6) + 0 for number in self.page.facts("state.clip_planes")[0]], [0, 1, 0, 0])
        slider = self.page.driver.find_element("css selector", "[aria-label='Plane 1, its distance']")
        self.page.js("arguments[0].value = arguments[0].max; arguments[0].dispatchEvent(new Event('input'))", slider)
        self.page.settle()
        self.assertLess(self.page.measure()["n"], 0.05 * whole)
        self.page.press("2")
        self.page.press_button("add-plane")
        self.assertEqual(len(self.page.facts("state.clip_planes")), 2)
        self.assertTrue(self.page.js("return document.getElementById('add-plane').disabled"))
        for _ in range(2):
            self.page.js("document.querySelector(\"[aria-label='Remove plane 1']\").click()")
        self.page.press("1")
        self.assertEqual(self.page.facts("state.clip_planes"), [])
        self.assertAlmostEqual(self.page.measure()["n"], whole, delta=0.01 * whole + 5)

    def test_the_volume_is_cut_open_where_the_slices_meet(self):
        self.page.press("6")  # from below
        whole = self.page.measure()["n"]
        self.page.put("cut", "2")
        at = self.page.facts("slices.at")
        self.assertEqual(self.page.facts("state.cut"), [2, *at])
        self.assertNotEqual(self.page.measure()["n"], whole)
        self.page.js("const f = document.getElementById('cut-place'); f.value = 3; f.dispatchEvent(new Event('input'))")
        self.page.settle()
        self.assertEqual(self.page.facts("state.cut"), [2, at[0], at[1], 3])
        self.page.js("app.slices.goTo([1, 2, 40])")
        self.page.settle()
        self.assertEqual(self.page.facts("state.cut"), [2, 1, 2, 40])
        self.page.put("cut", "3")
        self.assertFalse(self.page.find("cut-place").is_displayed())
        ActionChains(self.page.driver).key_down(Keys.CONTROL).send_keys("z").key_up(Keys.CONTROL).perform()
        self.page.settle()
        self.assertEqual(self.page.facts("state.cut")[0], 2)
        self.page.put("cut", "")
        self.assertIsNone(self.page.facts("state.cut"))
        self.assertEqual(self.page.measure()["n"], whole)

    def test_background_is_the_corners_colour(self):
        self.page.put("background", "#405060")
        for channel, wanted in zip(self.page.measure()["corner"], (0x40, 0x50, 0x60)):
            self.assertAlmostEqual(channel, wanted, delta=2)

    def test_perspective_shows_near_things_larger(self):
        self.page.press("5")
        flat = self.page.measure()
        self.page.press("p")
        self.assertGreater(self.page.facts("state.camera.fov"), 0)
        deep = self.page.measure()
        self.assertNotEqual(flat["box"], deep["box"])
        self.page.put("fov", 60)
        self.assertEqual(self.camera()["fov"], 60)
        self.page.press("p")
        self.assertEqual(self.page.measure()["box"], flat["box"])

    def test_shading_off_shows_the_plain_colours(self):
        self.put_tf([(0, 0), (20, 0), (40, 1), (255, 1)])
        lit = self.page.measure()["mean"]
        self.page.press("s")
        self.assertEqual(self.page.facts("state.shading"), "none")
        self.assertGreater(min(self.page.measure()["mean"]), max(lit) + 10)

    def test_modes_have_functions_of_their_own(self):
        lit = self.page.measure()["mean"]
        before = self.page.facts("state.transfer_function")
        self.page.put("mode", "mip")
        self.assertEqual(self.page.facts("state.mode"), "mip")
        self.assertTrue(all(point[1] == 1 for point in self.page.facts("state.transfer_function.opacities")))
        brightest = self.page.measure()["mean"]
        self.assertNotEqual(lit, brightest)
        self.page.put("mode", "surface")
        value = self.page.facts("state.isovalue")
        surface = self.page.measure()["box"]
        self.page.put("isovalue", 2 * value)
        self.assertNotEqual(self.page.measure()["box"], surface)
        self.page.put("mode", "composite")
        self.assertEqual(self.page.facts("state.transfer_function"), before)
        self.page.press_button("undo")
        self.assertEqual(self.page.facts("state.mode"), "surface")

    def test_overlays_can_be_switched_off(self):
        inked = ("const c = document.getElementById('overlay'), q = c.getContext('2d').getImageData(0, 0, c.width, c.height).data;"
                 "let n = 0; for (let i = 3; i < q.length; i += 4) n += q[i] > 0; return n")
        everything = self.page.js(inked)
        self.page.press("b")
        time.sleep(0.1)
        without_scale = self.page.js(inked)
        self.page.press("g")
        time.sleep(0.1)
        self.assertGreater(everything, without_scale)
        self.assertEqual(self.page.js(inked), 0)
        self.page.press("o")
        time.sleep(0.1)
        self.assertFalse(self.page.find("cube").is_displayed())
        self.page.press("b", "g", "o")

    def test_a_click_on_the_cube_looks_at_that_side(self):
        self.page.put("azimuth", 45)
        ActionChains(self.page.driver).move_to_element_with_offset(self.page.find("cube"), 18, 0).click().perform()
        self.page.settle()
        self.assertEqual(self.camera()["azimuth"], 90)
