"""Builds the Python module with CMake, for `pip install --no-build-isolation .`.

VERIDYN_BUILD_DIR names the build folder of `make python`, whose module is taken as it is, and nothing is written beside
the sources; otherwise one is made and the library is compiled.
"""

import atexit
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

SOURCE = pathlib.Path(__file__).resolve().parent
VERSION = re.search(r"^project\(veridyn VERSION ([0-9.]+)", (SOURCE / "CMakeLists.txt").read_text(), re.M)[1]


class BuildWithCMake(build_ext):
    def build_extension(self, ext):
        given = os.environ.get("VERIDYN_BUILD_DIR")
        folder = pathlib.Path(given or self.build_temp).resolve()
        options = [
            "-DVERIDYN_PYTHON=ON",
            "-DVERIDYN_TESTS=OFF",
            "-DVERIDYN_BENCHMARKS=OFF",
            f"-DPython3_EXECUTABLE={sys.executable}",
        ]
        if not given:
            cmake = os.environ.get("CMAKE", "cmake")
            fresh = [] if (folder / "CMakeCache.txt").exists() else ["-DCMAKE_BUILD_TYPE=Release", "-G", "Ninja"]
            subprocess.run([cmake, "-S", SOURCE, "-B", folder, *options, *fresh], check=True)
            subprocess.run([cmake, "--build", folder, "--target", "veridyn_python", "--parallel"], check=True)
        built = list((folder / "python" / "veridyn").glob("_veridyn*.so"))
        if len(built) != 1:
            raise RuntimeError(f"{folder}: found {len(built)} modules, expected one")
        target = pathlib.Path(self.get_ext_fullpath(ext.name))
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(built[0], target)


aside = {}
if os.environ.get("VERIDYN_BUILD_DIR"):
    scratch = tempfile.mkdtemp(prefix="veridyn-wheel-")
    atexit.register(shutil.rmtree, scratch, ignore_errors=True)
    aside = {"build": {"build_base": scratch}, "egg_info": {"egg_base": scratch}}

setup(
    version=VERSION,
    options=aside,
    packages=["veridyn", "veridyn.robots"],
    package_dir={"veridyn": "python/veridyn", "veridyn.robots": "data/robots"},
    package_data={"veridyn": ["*.pyi", "py.typed"], "veridyn.robots": ["*.yaml", "*.urdf"]},
    ext_modules=[Extension("veridyn._veridyn", sources=[])],
    cmdclass={"build_ext": BuildWithCMake},
)
