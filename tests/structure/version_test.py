"""version_test.py BUILD: the version stands in CMakeLists.txt alone, and everything else has it from there.

A ROS package.xml, whose version nothing can compute, and the newest heading of CHANGELOG.md must equal it.
"""
import os
import re
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
build = sys.argv[1]


def text(path):
    with open(os.path.join(ROOT, path), encoding="utf-8") as file:
        return file.read()


def printed(*command, **options):
    return subprocess.run(command, capture_output=True, text=True, check=True, **options).stdout.strip()


version = re.search(r"^project\(veridyn VERSION ([0-9.]+)", text("CMakeLists.txt"), re.M)[1]
assert re.search(r"^## (\S+)", text("CHANGELOG.md"), re.M)[1] == version, "CHANGELOG.md begins with another version"
for package in ("crtk_msgs", "veridyn_ros"):
    assert f"<version>{version}</version>" in text(f"packages/ros/{package}/package.xml"), package

# No other file has it.
written = re.compile(r"(?<![\d.])" + re.escape(version) + r"(?![\d.]|\d)")
for folder, folders, names in os.walk(ROOT):
    folders[:] = [f for f in folders if not (folder == ROOT and re.match(r"build|out$|data$|\.git$", f)) and f != "__pycache__"]
    for name in names:
        path = os.path.relpath(os.path.join(folder, name), ROOT)
        if path in ("CMakeLists.txt", "CHANGELOG.md") or not re.search(r"(\.(cpp|hpp|h|py|pyi|md|sh|cmake|txt|toml|in)|file)$", name):
            continue
        found = written.search(text(path))
        assert not found, f"{path}: found the version {version}, expected it in CMakeLists.txt alone"

# What was built has it.
for program in ("veridyn", "veridyn-dvrk", "veridyn-cooperate", "veridyn-calibrate"):
    if os.path.exists(f"{build}/bin/{program}"):
        assert printed(f"{build}/bin/{program}", "--version") == f"veridyn {version}", program
if os.path.isdir(f"{build}/python/veridyn"):
    said = printed("/usr/bin/python3", "-c", "import veridyn; print(veridyn.__version__)", env={**os.environ, "PYTHONPATH": f"{build}/python"})
    assert said == version, f"the Python module says {said}"
with open(f"{build}/CPackConfig.cmake", encoding="utf-8") as file:
    assert f'set(CPACK_PACKAGE_VERSION "{version}")' in file.read(), "the Debian packages have another version"
setuptools = subprocess.run([sys.executable, "setup.py", "--version"], cwd=ROOT, capture_output=True, text=True)
assert setuptools.returncode or setuptools.stdout.split()[-1] == version, f"the wheel has {setuptools.stdout}"
