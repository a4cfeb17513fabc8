"""What the page says when there is no token, when ranks stand still, and when the job warns."""

import os
import signal

from selenium.webdriver.common.keys import Keys

from browser_test import WithPage, jack
from viewer_client import ranks_of

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
