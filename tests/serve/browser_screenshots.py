"""Writes the documentation's pictures of the page, of the head with which the README begins."""

import os

from selenium.webdriver.common.action_chains import ActionChains

import browser_test
from viewer_page import Page

LOOK = ("--tf", "mr-skin", "--azimuth", "-35", "--elevation", "8", "--zoom", "1.2", "--background", "#20242c")


def scheme(page, name):
    page.driver.execute_cdp_cmd("Emulation.setEmulatedMedia",
                                {"features": [{"name": "prefers-color-scheme", "value": name}]})


def save(page, folder, name):
    page.settle()
    ActionChains(page.driver).move_to_element(page.find("picture")).perform()  # away from the controls
    page.js("document.activeElement.blur()")
    page.js("return new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
    page.driver.save_screenshot(os.path.join(folder, name))


def write(folder):
    os.makedirs(folder, exist_ok=True)
    server = browser_test.serve(browser_test.HEAD, *LOOK)
    page = Page((1180, 860))
    try:
        scheme(page, "light")
        page.show(server.url)
        save(page, folder, "viewer-light.png")
        scheme(page, "dark")
        page.fill("azimuth", 15)
        page.click("add-plane")
        page.fill("azimuth", -35)
        page.js("document.querySelector('details').removeAttribute('open'); document.getElementById('panel').scrollTop = 0")
        save(page, folder, "viewer-dark.png")
        page.js("document.querySelector(\"[aria-label='Remove plane 1']\").click()")
        page.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride",
                                    {"width": 390, "height": 780, "deviceScaleFactor": 1.5, "mobile": True})
        page.js("document.querySelector('details').removeAttribute('open'); document.getElementById('panel').scrollTop = 55")
        page.wait("document.getElementById('picture').width === 585")
        save(page, folder, "viewer-phone.png")
    finally:
        page.quit()
        server.stop()
