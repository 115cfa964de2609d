"""Types are complete: mypy accepts the package, and refuses what a call does not know."""

import pathlib
import subprocess
import sys

import pytest

pytest.importorskip("mypy", reason="mypy is not installed")

SOURCE = pathlib.Path(__file__).resolve().parents[1]


RIGHT = """
import veridyn
r = veridyn.identify("a.urdf", "b.csv", test="c.csv", filter_cutoff=4.0, friction="plain")
r.save("m.yaml")
veridyn.fleet("a.urdf", {"one": "b.csv"}, significance=0.05)
veridyn.kinematics("a.urdf", workspace=10).position.mean()
veridyn.excite("a.urdf", floor=0.0, keep_out=[(0, 1, 0, 1, 0, 1)])
veridyn.read_model("a.urdf").plot_friction("elbow")
"""

WRONG = """
import veridyn
veridyn.identify("a", "b", filter_cutof=4.0)
veridyn.identify("a", "b", friction="none")
veridyn.stability("a.yaml", bounds="many")
veridyn.calibrate_links("a", "p.csv", basis="free")
veridyn.excite("a", duration="long")
veridyn.identify("a", "b").modle
"""


def test_options_have_names_and_types(tmp_path, monkeypatch):
    monkeypatch.setenv("MYPYPATH", str(SOURCE))
    (tmp_path / "right.py").write_text(RIGHT)
    (tmp_path / "wrong.py").write_text(WRONG)
    run = subprocess.run(
        [sys.executable, "-m", "mypy", "--config-file", SOURCE / "mypy.ini", "--cache-dir", "/dev/null",
         str(SOURCE / "veridyn"), "right.py", "wrong.py"],
        cwd=tmp_path, capture_output=True, text=True,
    )
    errors = [line.split(": error")[0] for line in run.stdout.splitlines() if ": error" in line]
    assert errors == [f"wrong.py:{line}" for line in range(3, 9)], run.stdout + run.stderr
