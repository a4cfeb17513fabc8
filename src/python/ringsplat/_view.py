"""The viewer's page, for notebooks and browsers."""

from __future__ import annotations

import contextlib
import html
import os
import shutil
import subprocess
import sys
import tempfile
import threading
import urllib.parse
import weakref
from typing import IO, Any, Sequence

from . import _core
from ._core import InputError, RunError
from ._table import command_line
from ._volume import volume_of

# Pages of this machine, such as Jupyter's. The page's token keeps others out.
LOCAL_PAGES = ("http://localhost:*", "http://127.0.0.1:*", "https://localhost:*", "https://127.0.0.1:*")


def _end(process: subprocess.Popen, folder: str) -> None:
    with process:  # waits, and closes the pipes
        process.terminate()
        try:
            process.wait(5)
        except subprocess.TimeoutExpired:
            process.kill()
    shutil.rmtree(folder, ignore_errors=True)


class View(contextlib.AbstractContextManager["View"]):
    """A volume that is shown on a page. Its `url` is for a browser; a notebook shows the page in the output cell.

    It is served from a process of its own, which ends with close(), with this object, or with Python.
    """

    def __init__(self, command: Sequence[str], folder: str, width: str, height: int, through: str | None) -> None:
        self._size = (width, height)
        package = os.path.dirname(os.path.dirname(os.path.abspath(_core.__file__)))
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join([package, os.environ.get("PYTHONPATH", "")])}
        with tempfile.TemporaryFile("w+") as errors:
            self._process = subprocess.Popen(
                [sys.executable, "-m", "ringsplat", *command],
                stdout=subprocess.PIPE,
                stderr=errors,
                stdin=subprocess.DEVNULL,
                env=environment,
                start_new_session=True,
                text=True,
            )
            self._finalizer = weakref.finalize(self, _end, self._process, folder)
            try:
                self.url = self._read_url(errors)
                if through is not None:
                    here = urllib.parse.urlsplit(self.url)
                    self.url = f"{through.rstrip('/')}/proxy/{here.port}/#{here.fragment}"
            except BaseException:
                self.close()
                raise

    def _read_url(self, errors: IO[str]) -> str:
        """The line with the address comes when the volume is loaded."""
        out = self._process.stdout
        assert out is not None
        for line in out:
            for word in line.split():
                if word.startswith("http://"):
                    threading.Thread(target=out.read, daemon=True).start()
                    return word
        code = self._process.wait()
        errors.seek(0)
        text = errors.read().strip().removeprefix("ringsplat: error: ")
        raise (InputError if code == 2 else RunError)(text or f"the viewer ended with code {code}")

    def close(self) -> None:
        """Ends the viewer's process and removes its files."""
        self._finalizer()

    @property
    def closed(self) -> bool:
        """True when there is no viewer any more."""
        return not self._finalizer.alive or self._process.poll() is not None

    def __exit__(self, *_: Any) -> None:
        self.close()

    def _repr_html_(self) -> str:
        width, height = self._size
        return (
            f'<iframe src="{html.escape(self.url)}" width="{html.escape(str(width))}" height="{height}" '
            'style="border: 0" allow="fullscreen"></iframe>'
        )

    def __repr__(self) -> str:
        return f"<ringsplat.View {'closed' if self.closed else self.url}>"


def view(
    volume: Any,
    *,
    spacing: Any = None,
    origin: Any = None,
    direction: Any = None,
    unit: Any = None,
    width: str = "100%",
    height: int = 640,
    port: int = 0,
    frame_origins: Sequence[str] = LOCAL_PAGES,
    through: str | None = None,
    **options: Any,
) -> View:
    """Shows a volume on the viewer's page, to be turned and changed there; in a notebook in the output cell.

    `volume` and its place are those of render(); an array is written into a temporary file. `width` and `height` are the
    frame's, `port` the page's (0: any). Only pages of `frame_origins` may show it in a frame; without others these are
    pages of this machine. The notebook's browser must reach 127.0.0.1 of Python's machine, or go `through` a Jupyter
    server with jupyter-server-proxy: its address, such as "https://hub.example.org/user/anna". `options` are those of
    `ringsplat serve`: tf, azimuth, elevation, zoom, size, shading, range, opacity, colours, background, clip.
    """
    source = volume_of(volume, spacing, origin, direction, unit)
    folder = tempfile.mkdtemp(prefix="ringsplat-view-")
    try:
        path = source.name
        if source.array is not None:
            path = os.path.join(folder, "array.nrrd")
            _core.write_volume(source.core(), path)
        with command_line(options) as (words, _):
            allowed = [f"--allow-frame={one}" for one in frame_origins]
            if through is not None:
                server = urllib.parse.urlsplit(through)
                if server.scheme not in ("http", "https") or not server.hostname:
                    hint = "give its address, such as https://hub.example.org/user/anna"
                    raise InputError(f"through={through!r} is no Jupyter server; hint: {hint}")
                place = server.netloc.rpartition("@")[2].lower()
                origin_of_server = f"{server.scheme}://{place}"
                allowed += [f"--allow-host={place}"]
                allowed += [f"--allow-{what}={origin_of_server}" for what in ("origin", "frame")]
            command = ["serve", path, f"--port={port}", *allowed, *source.words, *words]
            return View(command, folder, width, height, through)
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)
        raise
