"""The wheel of `make wheel` is made of what was built, and works where it is unpacked."""

import importlib.util
import os
import pathlib
import subprocess
import sys

import pytest

MISSING = [name for name in ("pip", "setuptools", "wheel") if importlib.util.find_spec(name) is None]

SOURCE = pathlib.Path(__file__).resolve().parents[2]
BUILD = os.environ.get("VERIDYN_BUILD_DIR")


@pytest.mark.skipif(bool(MISSING), reason=f"not installed: {MISSING}")
@pytest.mark.skipif(not BUILD, reason="VERIDYN_BUILD_DIR does not name what `make python` built")
def test_a_wheel_is_installed_without_an_index(tmp_path):
    pip = [sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check"]
    subprocess.run([*pip, "wheel", "--no-build-isolation", "--no-deps", "--no-index", "-w", tmp_path, SOURCE], check=True)
    assert not [path for path in SOURCE.iterdir() if path.suffix in (".egg-info", ".whl")]
    (wheel,) = tmp_path.glob("veridyn-*.whl")
    assert "linux" in wheel.name and "any" not in wheel.name
    subprocess.run([*pip, "install", "--no-index", "--no-deps", "--target", tmp_path / "there", wheel], check=True)
    program = (
        "import os, veridyn\n"
        f"assert veridyn.__file__.startswith({str(tmp_path)!r}), veridyn.__file__\n"
        f"assert os.environ['VERIDYN_ROBOTS'].startswith({str(tmp_path)!r})\n"
        "print(veridyn.read_model('psm-3dof').joints)\n"
    )
    environment = {k: v for k, v in os.environ.items() if k != "VERIDYN_ROBOTS"}
    environment["PYTHONPATH"] = str(tmp_path / "there")
    said = subprocess.run([sys.executable, "-c", program], check=True, capture_output=True, text=True, env=environment, cwd=tmp_path)
    assert said.stdout.strip() == "3"
