"""A bill of materials of the tool as built here, CycloneDX 1.5.

    bill_of_materials.py TOOL VERSION [OUT.json]

What the tool is linked with comes from the tool itself; what is compiled in from headers and static
libraries, or copied into the pages it writes, is listed below. Versions and licences are those of the
Debian packages: the licence of most of a package's files, or the file that has it in words.
"""
import json
import os
import re
import subprocess
import sys

COMPILED_IN = ["libeigen3-dev", "libcli11-dev", "nlohmann-json3-dev", "libcpp-httplib-dev", "libceres-dev"]
IN_PAGES = ["libjs-dygraphs", "libjs-three"]


def output(*command):
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    return done.stdout if done.returncode == 0 else ""


def linked(tool):
    """Packages of the shared libraries of a program, and whether it names them itself."""
    own = set(re.findall(r"NEEDED\s+(\S+)", output("objdump", "-p", tool)))
    found = {}
    for name, path in re.findall(r"(\S+) => (/\S+)", output("ldd", tool)):
        for place in (path, os.path.realpath(path), re.sub("^/usr", "", path), "/usr" + path):
            owner = output("dpkg", "-S", place).split(":")[0]
            if owner and "," not in owner:
                break
        else:
            sys.exit(f"{path}: found no package that has this file, expected one")
        found[owner] = found.get(owner, False) or name in own
    return found


def licence(package):
    path = f"/usr/share/doc/{package}/copyright"
    try:
        with open(path, encoding="utf-8", errors="replace") as file:
            text = file.read()
    except OSError:
        return "unknown: the package has no copyright file"
    whole = re.search(r"^Files:\s*\*[^\n]*\n(?:(?!\n\n).)*?^License:\s*(\S[^\n]*)", text, re.S | re.M)
    return whole.group(1).strip() if text.startswith("Format:") and whole else f"in words in {path}"


def component(package, use):
    version = output("dpkg-query", "-W", "-f", "${Version}", package)
    if not version:
        return None
    return {"type": "library", "bom-ref": package, "name": package, "version": version,
            "purl": f"pkg:deb/debian/{package}@{version}", "licenses": [{"license": {"name": licence(package)}}],
            "properties": [{"name": "veridyn:use", "value": use}]}


def main(tool, version, out=None):
    uses = {p: "linked" if own else "linked by another library" for p, own in linked(tool).items()}
    uses.update({p: "compiled in" for p in COMPILED_IN})
    uses.update({p: "copied into pages" for p in IN_PAGES})
    components = [component(package, use) for package, use in sorted(uses.items())]
    bill = {"bomFormat": "CycloneDX", "specVersion": "1.5", "version": 1,
            "metadata": {"component": {"type": "application", "name": "veridyn", "version": version,
                                       "licenses": [{"license": {"id": "BSD-3-Clause"}}]}},
            "components": [c for c in components if c]}
    text = json.dumps(bill, indent=1) + "\n"
    if out is None:
        sys.stdout.write(text)
    else:
        with open(out, "w") as file:
            file.write(text)


if __name__ == "__main__":
    main(*sys.argv[1:])
