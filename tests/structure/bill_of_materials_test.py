"""bill_of_materials_test.py TOOL: the bill names what the tool is linked with and what its pages hold; 77 without dpkg."""
import json
import os
import shutil
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
if shutil.which("dpkg-query") is None or shutil.which("objdump") is None:
    sys.exit(77)
bill = json.loads(subprocess.run([sys.executable, ROOT + "/cmake/bill_of_materials.py", sys.argv[1], "1.2.3"],
                                 capture_output=True, text=True, check=True).stdout)
assert bill["metadata"]["component"]["version"] == "1.2.3"
uses = {c["name"]: c["properties"][0]["value"] for c in bill["components"]}
assert uses["libc6"] == "linked" and uses["libeigen3-dev"] == "compiled in", uses
assert any(name.startswith("libyaml-cpp") and use == "linked" for name, use in uses.items()), uses
for name in ("libjs-dygraphs", "libjs-three"):
    installed = subprocess.run(["dpkg-query", "-W", name], capture_output=True).returncode == 0
    assert (uses.get(name) == "copied into pages") == installed, name
for c in bill["components"]:
    licence = c["licenses"][0]["license"]["name"]
    assert c["version"] and licence and not licence.startswith("unknown"), c
