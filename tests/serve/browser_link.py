"""What the page says when there is no token, when ranks stand still, when the job warns, and while it loads."""

import os
import signal
import types

from selenium.webdriver.common.keys import Keys

import browser_test
from browser_test import WithPage, jack
from coarse_cases import gated, make_large, open_gates
from viewer_client import Server, ranks_of

LINK = "document.getElementById('link').textContent"


class Link(WithPage):
    volume, options = staticmethod(jack), ("--tf", "grey")  # not the labels that a mask has otherwise

    def setUp(self):
        pass

    def test_an_address_without_its_token_says_so(self):
        page, address = self.page, self.server.url.split("#")[0]
        page.driver.get(address)
        page.js("sessionStorage.clear()")
        for there, words in (("", "lacks its token"), ("#" + 32 * "0", "not the server's")):
            page.driver.get("about:blank")
            page.driver.get(address + there)
            page.wait("ringsplat?.connection === 'refused'")
            self.assertIn(words, page.messages())
            self.assertIn("Open the whole address", page.messages())
        page.js("location.hash = arguments[0]", self.server.url.split("#")[1])  # as by typing it
        page.settle()
        self.assertEqual(page.messages(), "")

    def test_ranks_that_stand_still_are_told_after_a_second(self):
        page = self.page
        page.show(self.server.url)
        ranks = ranks_of(self.server.process.pid)  # all of them, as some may be idle
        for rank in ranks:
            os.kill(rank, signal.SIGSTOP)
        try:
            page.focus_picture()
            page.keys(Keys.ARROW_RIGHT)
            page.wait(f"{LINK} === 'waiting for the ranks'")
        finally:
            for rank in ranks:
                os.kill(rank, signal.SIGCONT)
        page.settle()
        page.wait(f"{LINK} === 'connected'")

    def test_coarse_data_is_said_to_be_shown_until_the_volume_is_loaded(self):
        page, arguments = self.page, browser_test.arguments
        volume = make_large(types.SimpleNamespace(program=arguments.ringsplat, scratch=self.folder))
        server = Server(["env", *gated(self.folder, arguments.faults), arguments.ringsplat, "serve", volume, "--coarse-above", "0"])
        self.addCleanup(server.stop)
        page.driver.get("about:blank")
        page.driver.get(server.url)
        page.wait("ringsplat?.driving && !document.getElementById('loading').hidden")
        self.assertIn("Coarse data", page.text("loading"))
        for gate in (1, 2):
            shown = page.js("const {seq} = ringsplat; document.getElementById('picture').dispatchEvent("
                            "new KeyboardEvent('keydown', {key: 'ArrowRight', bubbles: true})); return seq")
            page.wait(f"ringsplat.seq > {shown}")
            open_gates(self.folder, gate)
            page.wait(f"ringsplat.shown.at(-1)?.seq > {shown}")
            self.assertIn("coarse data", page.text("facts"))
        open_gates(self.folder, *range(3, 12))
        page.settle()
        self.assertFalse(page.find("loading").is_displayed())
        self.assertIn("full quality", page.text("facts"))
