"""Flow, connection, watching, files, keyboard, small windows, and the page's own modules."""

import io
import json
import os
import shutil
import struct
import subprocess
import tarfile
import time
import unittest

from selenium.webdriver.common.keys import Keys

import viewer_client
from browser_test import WithPage, jack, serve
from viewer_page import Page, Wire, wait_for_file


def rounded(value):
    """The digits that an address keeps."""
    return json.loads(json.dumps(value), parse_float=lambda text: float(f"{float(text):.7g}"))


class Flow(WithPage):
    volume = staticmethod(jack)

    def test_ten_quick_keys_end_in_the_tenth_view_at_full_level(self):
        self.page.focus_picture()
        azimuth, views = self.camera()["azimuth"], self.page.facts("seq")
        begin = time.monotonic()
        self.page.js("for (let i = 0; i < 10; ++i) document.getElementById('picture').dispatchEvent("
                     "new KeyboardEvent('keydown', {key: 'ArrowRight', bubbles: true}))")
        self.page.settle(3)
        self.assertLess(time.monotonic() - begin, 3 * viewer_client.PATIENCE)
        self.assertAlmostEqual(self.camera()["azimuth"], azimuth - 50, places=4)
        self.assertLessEqual(self.page.facts("seq"), views + 3)  # keys within one frame are one view
        last = self.page.facts("shown.at(-1)")
        self.assertEqual((last["level"], last["atRest"]), (last["levels"] - 1, True))

    def test_pictures_never_go_back(self):
        self.page.pull((-100, 0), (200, 0))
        order = [(p["seq"], p["level"]) for p in self.page.facts("shown")]
        self.assertEqual(order, sorted(order))

    def test_the_address_restores_the_scene_without_the_token(self):
        token = self.server.url.split("#")[1]
        self.page.fill("azimuth", 30)
        self.page.put("background", "#102030")
        self.page.wait("location.hash.includes('state=')")
        state, address = self.page.facts("state"), self.page.js("return location.href")
        self.assertNotIn(token, address)
        self.page.driver.refresh()
        self.page.settle()
        self.assertEqual(rounded(self.page.facts("state")), rounded(state))
        self.page.show(f"{self.server.url}&{address.split('#')[1]}")  # a link with both
        self.assertEqual(rounded(self.page.facts("state")), rounded(state))
        self.assertNotIn(token, self.page.js("return location.href"))

    def test_a_snapshot_has_the_size_that_was_asked_for(self):
        self.page.fill("snapshot-width", 333)
        self.page.fill("snapshot-height", 222)
        self.page.click("snapshot")
        path = wait_for_file(os.path.join(self.folder, "jack-333x222.png"))
        with open(path, "rb") as file:
            head = file.read(24)
        self.assertEqual(struct.unpack(">II", head[16:24]), (333, 222))

    def test_a_ruler_stays_with_the_scene_and_is_in_pictures(self):
        def picture():
            for side in ("width", "height"):
                self.page.fill(f"snapshot-{side}", 96)
            self.page.click("snapshot")
            path = wait_for_file(os.path.join(self.folder, "jack-96x96.png"))
            with open(path, "rb") as file:
                data = file.read()
            os.remove(path)
            return data[data.index(b"IDAT"):]  # the settings before it number the frame

        plain, places = picture(), [[4, 4, 4], [4, 7, 8], [10, 7, 8]]
        for place in places:
            self.page.js("app.probing.mark(arguments[0])", place)
        words = ["5 mm", "6 mm"]
        self.assertEqual(self.page.js("return app.probing.lengths().words"), words)
        self.assertEqual(self.page.js("return app.probing.measures()"), ["6 mm from the place before", "angle at that 90°"])
        self.assertNotEqual(picture(), plain)
        self.page.wait("location.hash.includes('ruler')")
        self.page.driver.refresh()
        self.page.settle()
        self.assertEqual(self.page.js("return app.probing.lengths().words"), words)
        self.assertEqual(json.loads(self.page.js("return app.scene.toFile([])"))["ruler"], places)
        self.page.press(Keys.ESCAPE)
        self.assertEqual(picture(), plain)

    def test_a_film_of_key_frames_is_a_tar_of_pictures(self):
        self.page.key_frames_of_film(0.5, 64, 48)
        self.assertEqual(self.page.facts("keyFrames"), 2)
        self.page.fill("film-format", "tar")
        self.page.js("for (const id of ['render-film', 'clear-keys']) document.getElementById(id).click()")
        path = wait_for_file(os.path.join(self.folder, "jack-frames.tar"))  # of the key frames that there were
        with tarfile.open(path) as archive:
            names = archive.getnames()
            pictures = [archive.extractfile(name).read() for name in names]
        self.assertEqual(names, [f"jack-{i:04}.png" for i in range(3)])
        self.assertEqual({struct.unpack(">II", p[16:24]) for p in pictures}, {(64, 48)})
        self.assertEqual(len(set(pictures)), 3)

    def begin_mp4(self, seconds):
        self.page.key_frames_of_film(seconds, 65, 48)
        self.assertEqual(self.page.js("return document.getElementById('film-format').value"), "mp4")
        self.page.click("render-film")

    @unittest.skipUnless(shutil.which("ffmpeg") and shutil.which("ffprobe"), "install ffmpeg")
    def test_a_film_of_key_frames_is_an_mp4_where_ffmpeg_is(self):
        self.begin_mp4(0.5)
        path = wait_for_file(os.path.join(self.folder, "jack.mp4"))
        found = subprocess.run(["ffprobe", "-v", "error", "-count_frames", "-show_entries",
                                "stream=width,height,nb_read_frames", "-of", "csv=p=0", path], check=True,
                               capture_output=True, text=True).stdout
        self.assertEqual(found.strip(), "66,48,3")
        self.page.wait("document.getElementById('film-words').textContent === '3 frames rendered'")

    @unittest.skipUnless(shutil.which("ffmpeg"), "install ffmpeg")
    def test_a_film_that_is_cancelled_leaves_the_server_to_others(self):
        self.begin_mp4(600)
        self.page.wait("document.getElementById('film-progress').value > 2")
        self.page.click("render-film")
        self.page.wait("document.getElementById('film-words').textContent === 'cancelled'")
        other = viewer_client.Client(self.server.port, self.server.url.split("#")[1])
        other.send({"type": "movie_frame", "id": 1, "index": 0, "count": 2, "fps": 4, "width": 64, "height": 48})
        answer = other.receive_until(lambda m: isinstance(m, dict) and m["type"] in ("movie_frame", "error"))
        self.assertEqual(answer["type"], "movie_frame", answer)
        other.close()

    def test_playing_key_frames_ends_in_the_last(self):
        self.page.press("1", "k")
        self.page.press("3", "k")
        self.page.fill("film-seconds", 0.4)
        self.page.focus_picture()
        self.page.press("1", " ")
        self.page.wait("document.getElementById('play').getAttribute('aria-pressed') === 'false'")
        self.page.settle()
        self.assertAlmostEqual(self.camera()["azimuth"], 90, places=3)

    def test_a_scene_is_saved_and_opened(self):
        self.page.fill("elevation", 33)
        self.page.press("k")
        self.page.click("save-state")
        path = wait_for_file(os.path.join(self.folder, "jack-scene.json"))
        with open(path, encoding="utf-8") as file:
            scene = json.load(file)
        self.assertEqual(scene["camera"]["elevation"], 33)
        self.assertEqual(len(scene["key_frames"]), 1)
        self.page.show(self.server.url)
        self.page.open_file("load-state", path)
        self.page.wait("ringsplat.state.camera.elevation === 33 && ringsplat.keyFrames === 1")
        self.page.settle()

    def test_a_wrong_scene_in_the_address_is_told_and_harmless(self):
        self.page.show(self.server.url + "&state=%7B%22light%22%3A%5B1%5D%7D")
        self.assertIn("light", self.page.messages())
        self.assertEqual(self.page.facts("state.light"), self.page.facts("hello.state.light"))

    def test_the_keyboard_alone_reaches_every_control(self):
        wanted = set(self.page.js("return [...document.querySelectorAll('button, input, select, summary, canvas[tabindex]')]"
                                  ".filter(e => e.checkVisibility() && !e.disabled && e.type !== 'radio').map("
                                  "e => e.outerHTML.slice(0, 60))"))
        self.page.focus_picture()
        reached = set()
        for _ in range(3 * len(wanted)):
            self.page.keys(Keys.TAB)
            reached.add(self.page.js("return document.activeElement.outerHTML.slice(0, 60)"))
            if wanted <= reached:
                break
        self.assertEqual(wanted - reached - {self.page.js("return document.getElementById('picture').outerHTML.slice(0, 60)")},
                         set())
        unnamed = self.page.js("return [...document.querySelectorAll('button, input, select')].filter(e => !(e.textContent.trim()"
                               "|| e.getAttribute('aria-label') || e.labels?.[0]?.textContent.trim())).map(e => e.outerHTML)")
        self.assertEqual(unnamed, [])

    def test_the_theme_can_be_chosen(self):
        colour = "return getComputedStyle(document.getElementById('panel')).backgroundColor"
        self.page.fill("theme", "dark")
        dark = self.page.js(colour)
        self.page.fill("theme", "light")
        self.assertNotEqual(self.page.js(colour), dark)
        self.page.fill("theme", "auto")

    def test_a_phone_shows_the_picture_and_folds_the_controls(self):
        driver = self.page.driver
        driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride",
                               {"width": 390, "height": 780, "deviceScaleFactor": 2, "mobile": True})
        driver.execute_cdp_cmd("Emulation.setTouchEmulationEnabled", {"enabled": True, "maxTouchPoints": 2})
        try:
            self.page.js("localStorage.clear()")
            self.page.show(self.server.url)
            self.assertFalse(self.page.find("panel").is_displayed())
            self.assertEqual(self.page.measure()["width"], 780)  # device pixels
            self.page.find("unfold").click()
            self.page.settle()
            self.assertTrue(self.page.find("panel").is_displayed())
            self.assertGreater(self.page.measure()["height"], 500)
            self.assertLessEqual(self.page.js("return document.documentElement.scrollWidth"), 390)
            self.touch(((100, 200), (220, 200)), ((200, 200), (300, 200)))
            self.page.settle()
            self.assertGreater(self.camera()["zoom"], 0)
            before = self.camera()
            self.touch(((150, 150), (150, 120)), ((150, 170), (150, 230)))
            self.page.settle()
            self.assertGreater(self.camera()["zoom"], 1.5 * before["zoom"])
            self.touch(((120, 150), (200, 150)))
            self.page.settle()
            self.assertNotAlmostEqual(self.camera()["azimuth"], before["azimuth"], places=1)
        finally:
            self.page.js("localStorage.clear()")
            driver.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
            driver.execute_cdp_cmd("Emulation.setTouchEmulationEnabled", {"enabled": False})

    def touch(self, *fingers, steps=8):
        """Fingers go from their first to their second place."""
        def points(t):
            return [{"x": a[0] + t * (b[0] - a[0]), "y": a[1] + t * (b[1] - a[1]), "id": i}
                    for i, (a, b) in enumerate(fingers)]
        send = self.page.driver.execute_cdp_cmd
        send("Input.dispatchTouchEvent", {"type": "touchStart", "touchPoints": points(0)})
        for step in range(1, steps + 1):
            send("Input.dispatchTouchEvent", {"type": "touchMove", "touchPoints": points(step / steps)})
        send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})

    def test_modules_compute_what_they_promise(self):
        module = self.page.module
        data = bytes(module("tar.js", "[...new Uint8Array(await m.tar([{name: 'ä.txt', bytes: new Uint8Array([1, 2, 3])},"
                                      "{name: 'b'.repeat(99) + '12', bytes: new Uint8Array(512)}], 7).arrayBuffer())]"))
        with tarfile.open(fileobj=io.BytesIO(data)) as archive:
            self.assertEqual(archive.getnames(), ["ä.txt", "b" * 98 + "12"])
            self.assertEqual(archive.extractfile("ä.txt").read(), b"\x01\x02\x03")
            self.assertEqual((archive.getmembers()[1].size, archive.getmembers()[1].mtime), (512, 7))
        for azimuth, elevation, roll in ((30, 20, 10), (-120, -70, 170), (180, 0, 0), (40, 90, 0)):
            camera = f"{{azimuth: {azimuth}, elevation: {elevation}, roll: {roll}}}"
            back = module("camera.js", f"m.anglesOf(m.basisOfQuaternion(m.quaternionOf({camera})))")
            for name, value in (("azimuth", azimuth), ("elevation", elevation), ("roll", roll)):
                self.assertAlmostEqual((back[name] - value + 180) % 360 - 180, 0, places=5)
        middle = module("spline.js", "m.sceneAt([0, 90].map(azimuth => ({...ringsplat.state, camera: {...ringsplat.state.camera,"
                                     "azimuth, zoom: azimuth ? 4 : 1}})), 0.5, [48, 48, 48]).camera")
        self.assertAlmostEqual(middle["azimuth"], 45, places=5)
        self.assertAlmostEqual(middle["zoom"], 2, places=5)


class TwoPages(WithPage):
    volume = staticmethod(jack)

    def test_one_drives_the_other_watches_and_they_change_places(self):
        other = Page((900, 700))
        self.addCleanup(other.quit)
        other.show(self.server.url)
        self.assertTrue(self.page.facts("driving"))
        self.assertFalse(other.facts("driving"))
        self.assertTrue(other.find("banner").is_displayed())
        self.page.fill("azimuth", 77)
        other.wait("ringsplat.state.camera.azimuth === 77")
        other.press(Keys.ARROW_RIGHT)  # who watches changes nothing
        self.assertEqual(self.camera()["azimuth"], 77)
        other.click("take-over")
        other.wait("ringsplat.driving")
        self.page.wait("!ringsplat.driving")
        other.settle()
        self.assertEqual(other.facts("state.camera.azimuth"), 77)
        other.put("azimuth", -20)
        self.page.wait("ringsplat.state.camera.azimuth === -20")
        self.assertTrue(self.page.find("banner").is_displayed())
        self.assertFalse(other.find("banner").is_displayed())


class LostConnection(WithPage):
    volume = staticmethod(jack)

    @classmethod
    def setUpClass(cls):
        cls.wire = Wire()
        cls.addClassCleanup(cls.wire.close)
        cls.options = ("--allow-host", f"127.0.0.1:{cls.wire.port}", "--allow-origin", f"http://127.0.0.1:{cls.wire.port}")
        super().setUpClass()
        cls.wire.target = cls.server.port

    def setUp(self):
        self.page.show(self.server.url.replace(f":{self.server.port}/", f":{self.wire.port}/"))

    def test_a_lost_connection_comes_back_and_resumes_the_scene(self):
        self.page.fill("azimuth", 50)
        self.page.js("app.slices.goTo([5, 60, 7])")
        self.page.settle()
        self.wire.cut()
        self.page.wait("ringsplat.connection === 'lost'")
        self.page.fill("elevation", 20)  # goes on while nobody listens
        self.wire.mend()
        self.page.settle(30)
        self.assertEqual((self.camera()["azimuth"], self.camera()["elevation"]), (50, 20))
        self.assertEqual(self.page.facts("slices.at"), [5, 47, 7])


class TheEnd(WithPage):
    volume = staticmethod(jack)

    def test_the_jobs_end_shows_on_the_page(self):
        server = serve(jack())
        self.addCleanup(server.stop)
        self.page.show(server.url)
        server.process.terminate()
        self.page.wait("document.getElementById('ended').open && ringsplat.connection === 'ended'")
