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

COMPILED_IN = ["libeigen3-dev", "libcli11-dev", "nlohmann-json3-dev", "libcpp-httplib-dev"]
IN_PAGES = ["libjs-dygraphs", "libjs-three"]


def output(*command):
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    return done.stdout


def linked(tool):
    """Packages of the shared libraries of a program, and whether it names them itself; a library of no package by its file."""
    own = set(re.findall(r"NEEDED\s+(\S+)", output("objdump", "-p", tool)))
    libraries = [(name, path) for name, path in re.findall(r"(\S+) => (/\S+)", output("ldd", tool)) if not name.startswith("libveridyn")]
    # A file may be packaged with or without /usr, and behind a link.
    places = {path: [path, os.path.realpath(path), re.sub("^/usr", "", path), "/usr" + path] for _, path in libraries}
    owners = dict(reversed(re.split(r"(?::\w+)?: ", line, maxsplit=1)) for line in
                  output("dpkg", "-S", *sum(places.values(), [])).splitlines() if ": /" in line)
    found = {}
    for name, path in libraries:
        owner = next((owners[place] for place in places[path] if place in owners), path)
        found[owner] = found.get(owner, False) or name in own
    return found


def licence(package):
    if "/" in package:
        return "unknown: no package has this file"
    path = f"/usr/share/doc/{package}/copyright"
    try:
        with open(path, encoding="utf-8", errors="replace") as file:
            text = file.read()
    except OSError:
        return "unknown: the package has no copyright file"
    whole = re.search(r"^Files:\s*\*[^\n]*\n(?:(?!\n\n).)*?^License:\s*(\S[^\n]*)", text, re.S | re.M)
    return whole.group(1).strip() if text.startswith("Format:") and whole else f"in words in {path}"


def component(package, use):
    version = output("dpkg-query", "-W", "-f", "${Version}", package) if "/" not in package else "of no package"
    if not version:
        return None
    return {"type": "library", "bom-ref": package, "name": package, "version": version,
            **({} if "/" in package else {"purl": f"pkg:deb/debian/{package}@{version}"}),
            "licenses": [{"license": {"name": licence(package)}}],
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
