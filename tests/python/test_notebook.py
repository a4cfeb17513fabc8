"""The example notebook runs, and its pictures are those of the package."""

import base64
import io
import os
import pathlib

import nbformat
import numpy as np
import ringsplat as rs
from nbclient import NotebookClient
from PIL import Image as Pillow

NOTEBOOK = pathlib.Path(__file__).resolve().parents[2] / "examples" / "python" / "first_picture.ipynb"


def shown(cell, kind):
    """What a cell shows, of one MIME type."""
    return [output["data"][kind] for output in cell.outputs if kind in output.get("data", {})]


def test_the_notebook_runs_and_shows_its_pictures(tmp_path):
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    NotebookClient(
        notebook, timeout=120, kernel_name="python3", resources={"metadata": {"path": str(tmp_path)}}
    ).execute()
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    pictures = [base64.b64decode(png) for cell in cells for png in shown(cell, "image/png")]
    if folder := os.environ.get("RINGSPLAT_KEEP_PICTURES"):
        for number, png in enumerate(pictures):
            pathlib.Path(folder, f"notebook-{number}.png").write_bytes(png)
    assert len(pictures) == 2
    # The same cells here give the same pictures.
    here = {}
    for cell in cells[:3]:
        exec(cell.source, here)  # noqa: S102
    again = rs.render(here["volume"])._repr_png_()
    assert pictures[0] == again and pictures[1] == here["image"]._repr_png_()
    first = np.asarray(Pillow.open(io.BytesIO(pictures[0])))
    assert first.shape == (512, 512, 4) and first[..., 3].mean() > 10 and len(np.unique(first[..., 0])) > 50
    frames = [text for cell in cells for text in shown(cell, "text/html")]
    assert len(frames) == 1 and "<iframe" in frames[0] and "http://127.0.0.1:" in frames[0]
