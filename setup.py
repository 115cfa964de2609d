"""Builds the Python module with CMake, for `pip install --no-build-isolation .`.

VERIDYN_BUILD_DIR names a build folder to use again (that of `make python`); otherwise one is made.
"""

import os
import pathlib
import shutil
import subprocess
import sys

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

SOURCE = pathlib.Path(__file__).resolve().parent


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
        if not (folder / "CMakeCache.txt").exists():
            options += ["-DCMAKE_BUILD_TYPE=Release", "-G", "Ninja"]
        cmake = os.environ.get("CMAKE", "cmake")
        subprocess.run([cmake, "-S", SOURCE, "-B", folder, *(options if not given else options[:1])],
                       check=True)
        subprocess.run([cmake, "--build", folder, "--target", "veridyn_python", "--parallel"],
                       check=True)
        built = list((folder / "python" / "veridyn").glob("_veridyn*.so"))
        if len(built) != 1:
            raise RuntimeError(f"{folder}: found {len(built)} modules, expected one")
        target = pathlib.Path(self.get_ext_fullpath(ext.name))
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(built[0], target)


setup(
    packages=["veridyn", "veridyn.robots"],
    package_dir={"veridyn": "python/veridyn", "veridyn.robots": "data/robots"},
    package_data={"veridyn": ["*.pyi", "py.typed"], "veridyn.robots": ["*.yaml", "*.urdf"]},
    ext_modules=[Extension("veridyn._veridyn", sources=[])],
    cmdclass={"build_ext": BuildWithCMake},
)
