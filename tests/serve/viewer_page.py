"""A headless Chromium that shows a server's page, for the tests beside this file."""

import os
import shutil
import socket
import threading
import time

from selenium import webdriver
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By

from viewer_client import PATIENCE, deadline


class Wire:
    """Passes bytes between the page and a server, and can be cut as a network is."""

    def __init__(self):
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port = self.listener.getsockname()[1]
        self.target, self.whole, self.open = None, True, []
        threading.Thread(target=self.accept, daemon=True).start()

    def accept(self):
        while True:
            try:
                near = self.listener.accept()[0]
                if not self.whole:
                    near.close()
                    continue
                far = socket.create_connection(("127.0.0.1", self.target))
            except OSError:
                return
            self.open += [near, far]
            for a, b in ((near, far), (far, near)):
                threading.Thread(target=self.copy, args=(a, b), daemon=True).start()

    @staticmethod
    def copy(source, sink):
        try:
            while data := source.recv(65536):
                sink.sendall(data)
        except OSError:
            pass
        for end in (source, sink):
            try:
                end.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass

    def cut(self):
        self.whole = False
        for end in self.open:
            try:
                end.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass
        self.open = []

    def mend(self):
        self.whole = True

    def close(self):
        self.cut()
        self.listener.close()


# What the page shows, as `ringsplat`, from its `app`. Letters: where the cube's sides look to, right, up and to the viewer.
FACTS = """
const shown = [];
const letters = () => {
  const turned = document.querySelector('#cube div'), matrix = (part) => new DOMMatrix(getComputedStyle(part).transform);
  return Object.fromEntries([...turned.children].map((side) => {
    const { m31, m32, m33 } = matrix(turned).multiply(matrix(side));
    return [side.textContent, [m31, -m32, m33]];
  }));
};
let started;
Object.defineProperty(window, 'app', { get: () => started, set(app) {
  started = app;
  const { pictureShown, probing } = app, { show } = probing;
  let probed;
  probing.show = (answer) => show.call(probing, probed = answer);
  app.pictureShown = (picture, latency) => {
    shown.push({ ...picture, blob: undefined });
    pictureShown.call(app, picture, latency);
  };
  window.ringsplat = {
    shown,
    get state() { return app.scene.state; },
    get hello() { return app.hello; },
    get connection() { return app.connection.status; },
    get driving() { return app.driving; },
    get seq() { return app.sender.seq; },
    get settled() {  // the present view's final picture is on the canvas
      const { connection, sender, stage, driving } = app, last = shown.at(-1);
      return connection.status === 'open' && !sender.moving && !sender.request.waits && !stage.draw.waits &&
             last !== undefined && last.atRest && (!driving || last.seq === sender.seq);
    },
    get letters() { return letters(); },
    get scale() { return app.scale; },
    get probe() { return document.getElementById('probe').hidden ? null : probed; },
    get slices() { return { at: app.slices.at, words: app.slices.words,
                            drawn: app.slices.panes.every(({ canvas, bitmap, asks }) => canvas.hidden || (bitmap && !asks)) }; },
    get frame() { return app.series.seen; },
    get playing() { return app.series.playing; },
    get keyFrames() { return app.film.frames.length; },
  };
} });
"""

MEASURE = """
const canvas = document.getElementById('picture'), {width, height} = canvas;
const data = canvas.getContext('2d').getImageData(0, 0, width, height).data;
const back = ringsplat.state.background.map(c => 255 * c);
let n = 0, x = 0, y = 0, box = [width, height, 0, 0]; const mean = [0, 0, 0];
for (let i = 0; i < width * height; ++i) {
  const rgb = [data[4 * i], data[4 * i + 1], data[4 * i + 2]];
  if (Math.max(...rgb.map((c, k) => Math.abs(c - back[k]))) < 24) continue;
  const px = i % width, py = (i - px) / width;
  ++n; x += px; y += py; rgb.forEach((c, k) => mean[k] += c);
  box = [Math.min(box[0], px), Math.min(box[1], py), Math.max(box[2], px), Math.max(box[3], py)];
}
return {n, x: x / n / width, y: y / n / height, mean: mean.map(c => c / n), box, corner: [...data.slice(0, 3)], width, height};
"""


class Page:
    """A tab with the page."""

    def __init__(self, size=(1100, 800), folder=None):
        options = webdriver.ChromeOptions()
        options.binary_location = shutil.which("chromium") or shutil.which("chromium-browser") or ""
        for argument in ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--hide-scrollbars",
                         "--force-device-scale-factor=1", f"--window-size={size[0]},{size[1]}"):
            options.add_argument(argument)
        if folder:
            options.add_experimental_option("prefs", {"download.default_directory": folder})
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        self.driver = webdriver.Chrome(service=Service(shutil.which("chromedriver")), options=options)
        self.driver.set_script_timeout(60 * PATIENCE)
        self.driver.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": FACTS})

    def quit(self):
        self.driver.quit()

    def js(self, script, *arguments):
        return self.driver.execute_script(script, *arguments)

    def facts(self, expression):
        return self.js(f"return ringsplat.{expression}")

    def module(self, name, expression):
        """An expression's value with a module of the page at hand as `m`, after those that it needs."""
        script = self.js("return document.querySelector('script').textContent")
        module = "in_" + name.removesuffix(".js")
        end = script.index("\n})();\n", script.index(f"const {module} =")) + len("\n})();\n")
        return self.driver.execute_async_script(
            script[:end] + "const done = arguments[0], m = %s; (async () => (%s))()"
            ".then(done, error => done('failed: ' + error));" % (module, expression))

    def wait(self, expression, seconds=20.0):
        end = deadline(seconds)
        while time.monotonic() < end:
            if self.js(f"return Boolean({expression})"):
                return
            time.sleep(0.03)
        raise AssertionError(f"not within {seconds} s: {expression}; last picture {self.facts('shown.at(-1)')}, "
                             f"seq {self.facts('seq')}, messages {self.messages()}")

    def settle(self, seconds=8.0):
        self.wait("window.ringsplat?.settled", seconds)

    def show(self, url):
        """A fresh visit: no scene of the page before, but its settings."""
        self.driver.get("about:blank")
        self.driver.get(url)
        self.settle()

    def find(self, element_id):
        return self.driver.find_element(By.ID, element_id)

    def messages(self):
        return self.text("messages")

    def log(self):
        return [entry["message"] for entry in self.driver.get_log("browser")]

    def keys(self, *keys):
        ActionChains(self.driver).send_keys(*keys).perform()

    def focus_picture(self):
        self.js("document.getElementById('picture').focus()")

    def press(self, *keys):
        """Keys on the picture, until its final picture is there."""
        self.focus_picture()
        self.keys(*keys)
        self.settle()

    def key_frames_of_film(self, seconds, width, height):
        """Two key frames, and a film of them with four pictures a second."""
        self.press("1", "k")
        self.press("3", "k")
        for field, value in (("seconds", seconds), ("rate", 4), ("width", width), ("height", height)):
            self.fill("film-" + field, value)

    def measure(self):
        return self.js(MEASURE)

    def drag(self, element, start, shift, button=0, modifier=None, release=True):
        """From `start`, pixels from the element's middle, by `shift` in ten steps."""
        chain = ActionChains(self.driver, duration=10)
        if modifier:
            chain.key_down(modifier)
        chain.move_to_element_with_offset(element, *start)
        chain.w3c_actions.pointer_action.pointer_down(button)
        for _ in range(10):
            chain.move_by_offset(shift[0] // 10, shift[1] // 10)
        if release:
            chain.w3c_actions.pointer_action.pointer_up(button)
        if modifier:
            chain.key_up(modifier)
        chain.perform()

    def pull(self, start, shift, modifier=None):
        """Drags on the picture, until its final one is there."""
        self.drag(self.find("picture"), start, shift, modifier=modifier)
        self.settle()

    def fill(self, element_id, value):
        """A field's new value, as by typing and leaving it."""
        self.js("const f = document.getElementById(arguments[0]); f.closest('details')?.setAttribute('open', '');"
                "f.value = arguments[1]; f.dispatchEvent(new Event('input', {bubbles: true}));"
                "f.dispatchEvent(new Event('change', {bubbles: true}));", element_id, value)

    def open_file(self, button, path):
        """A chooser of files cannot be driven: the field that it would fill is kept and filled."""
        self.js("HTMLInputElement.prototype.click = function() { this.id = 'chosen'; }")
        self.js("document.getElementById(arguments[0]).click()", button)
        self.find("chosen").send_keys(path)

    def put(self, element_id, value):
        """As fill, until the final picture is there."""
        self.fill(element_id, value)
        self.settle()

    def press_button(self, element_id):
        """As click, until the final picture is there."""
        self.click(element_id)
        self.settle()

    def text(self, element_id):
        return self.js("return document.getElementById(arguments[0]).textContent", element_id)

    def click(self, element_id):
        self.js("const f = document.getElementById(arguments[0]); f.closest('details')?.setAttribute('open', '');"
                "f.scrollIntoView({block: 'center'})", element_id)
        self.find(element_id).click()


def wait_for_file(path, seconds=30.0):
    end = deadline(seconds)
    while time.monotonic() < end:
        if os.path.exists(path) and os.path.getsize(path) > 0:  # the browser makes an empty one first
            return path
        time.sleep(0.05)
    raise AssertionError(f"{path} was not downloaded; there are {os.listdir(os.path.dirname(path))}")
