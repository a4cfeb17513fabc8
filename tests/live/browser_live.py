"""A simulation's panel in headless Chromium: examples/heat's heat_live is held, takes a step, a number, and is recorded."""
import argparse, os, re, shutil, sys, tarfile, tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "..", "serve"))
import viewer_client as vc
from server_case import expect

SKIPPED = 77  # CTest's SKIP_RETURN_CODE
try:
    from viewer_page import Page, wait_for_file
except ImportError:
    sys.exit(SKIPPED)


def words(page):
    return page.js("return document.getElementById('run-words').textContent")


def held_step(page):
    """Pages are told that it is held before it has ended its step; only where it is held do pictures rest."""
    page.wait("document.getElementById('run-words').textContent.includes('held') && ringsplat.shown.at(-1).atRest")
    return int(re.match(r"step (\d+)", words(page)).group(1))


def held_while_it_runs(page, folder):
    """The steps of a recording that begins while the simulation runs; a second click on Stop changes nothing."""
    page.click("run-record")
    page.wait("document.getElementById('run-record').textContent === 'Stop (3)'")
    page.js("for (let k = 0; k < 2; ++k) document.getElementById('run-record').click()")
    with tarfile.open(wait_for_file(os.path.join(folder, "heat-steps (1).tar"))) as archive:
        return [int(name[5:11]) for name in archive.getnames()]


def main():
    arguments = argparse.ArgumentParser()
    for name in ("--heat", "--mpiexec"):
        arguments.add_argument(name)
    options = arguments.parse_args()
    if not (shutil.which("chromedriver") and (shutil.which("chromium") or shutil.which("chromium-browser"))):
        sys.exit(SKIPPED)
    folder = tempfile.mkdtemp()
    server = vc.Server([options.mpiexec, "-n", "2", options.heat, "32", str(10 ** 9)], {"SHARE": "0.5"})
    page = Page(folder=folder)
    try:
        page.driver.get(server.url)  # pictures never rest while it runs
        page.wait("window.ringsplat?.driving && ringsplat.shown.length > 0")
        page.click("run-pause")
        step = held_step(page)
        page.click("run-step")
        page.wait(f"document.getElementById('run-words').textContent.startsWith('step {step + 1},')")
        page.js("const f = document.querySelector('#run-parameters input'); f.value = 3; f.dispatchEvent(new Event('change'))")
        page.click("run-step")
        page.wait(f"document.getElementById('run-words').textContent.startsWith('step {step + 2},')")
        page.click("run-record")
        page.wait("document.getElementById('run-record').textContent === 'Stop (3)'")
        page.click("run-record")
        with tarfile.open(wait_for_file(os.path.join(folder, "heat-steps.tar"))) as archive:
            names = archive.getnames()
            expect(all(archive.extractfile(name).read().startswith(b"\x89PNG") for name in names), "no pictures")
        steps = [int(re.fullmatch(r"heat-(\d{6})\.png", name).group(1)) for name in names]
        expect(len(steps) >= 3 and steps == list(range(step + 2, step + 2 + len(steps))), f"{names} after step {step}")
        page.wait("!app.runs.run.paused")
        recorded = held_while_it_runs(page, folder)
        expect(recorded == list(range(recorded[0], recorded[0] + len(recorded))), f"not each step: {recorded}")
    finally:
        page.quit()
        server.kill()
        shutil.rmtree(folder)


main()
