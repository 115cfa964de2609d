"""The notebooks run from their first cell to their last, and show what is stored in them."""

import pathlib
import sys

import pytest

nbformat = pytest.importorskip("nbformat", reason="python3-nbformat is not installed")
pytest.importorskip("nbclient", reason="python3-nbclient is not installed")
pytest.importorskip("ipykernel", reason="python3-ipykernel is not installed")
pytest.importorskip("matplotlib", reason="python3-matplotlib is not installed")

from conftest import real_data  # noqa: E402

NOTEBOOKS = pathlib.Path(__file__).resolve().parents[1] / "notebooks"
sys.path.insert(0, str(NOTEBOOKS))

from run import run  # noqa: E402


def kinds(book):
    """Of every code cell what it shows: text on standard output, pictures, values."""
    return [
        sorted({kind for o in cell.outputs for kind in (o.get("data", {}) or {o.output_type: 0}) if kind != "text/html"})
        for cell in book.cells if cell.cell_type == "code"
    ]


@pytest.mark.parametrize("name", sorted(path.stem for path in NOTEBOOKS.glob("*.ipynb")))
def test_notebook(name, monkeypatch, tmp_path):
    if "dask" in name:
        pytest.importorskip("distributed", reason="python3-distributed is not installed")
    for variable in ("JUPYTER_PATH", "PYTHONPATH"):  # restored afterwards
        monkeypatch.setenv(variable, "")
    if real_data() is not None:
        monkeypatch.setenv("VERIDYN_REAL_DATA", str(real_data()))
    shown = kinds(run(NOTEBOOKS / f"{name}.ipynb", tmp_path))
    there = kinds(nbformat.read(NOTEBOOKS / f"{name}.ipynb", as_version=4))
    assert there == shown, "the stored outputs are those of an earlier notebook: make notebooks"
    if "dask" not in name:
        assert any("image/png" in one for one in there)
