"""Runs a notebook from its first cell to its last: `python3 run.py NOTEBOOK...` stores the outputs in it.

What a page of HTML is long is not stored: whoever runs the notebook sees it.
"""

import os
import pathlib
import sys
import tempfile

import nbclient
import nbformat

LONGEST = 100_000  # characters of a page that is stored


def run(path, folder):
    """The notebook with its outputs; its kernel is this interpreter, and works in the folder."""
    kernels = pathlib.Path(folder) / "kernels" / "python3"
    kernels.mkdir(parents=True, exist_ok=True)
    (kernels / "kernel.json").write_text(
        '{"argv": ["%s", "-m", "ipykernel_launcher", "-f", "{connection_file}"],'
        ' "display_name": "Python 3", "language": "python"}' % sys.executable
    )
    os.environ["JUPYTER_PATH"] = str(folder)
    os.environ["PYTHONPATH"] = os.pathsep.join(p for p in sys.path if p)
    book = nbformat.read(path, as_version=4)
    for cell in book.cells:
        if cell.cell_type == "code":
            cell.outputs = []
    client = nbclient.NotebookClient(book, timeout=240, kernel_name="python3", resources={"metadata": {"path": str(folder)}})
    client.execute()
    return book


def stored(book):
    """Without what differs from run to run: times of execution, and pages."""
    for cell in book.cells:
        cell.metadata.pop("execution", None)
        for output in cell.get("outputs", []):
            if len(output.get("data", {}).get("text/html", "")) > LONGEST:
                del output["data"]["text/html"]
    return book


if __name__ == "__main__":
    for name in sys.argv[1:]:
        with tempfile.TemporaryDirectory() as temporary:
            nbformat.write(stored(run(name, temporary)), name)
