#!/usr/bin/env python3
"""README's blocks of commands and their output, made and checked.

    blocks.py write README.md FOLDER    runs every block's commands and writes their output into the page
    blocks.py check README.md FOLDER    runs them and compares; exit status 1 names what differs

A block is made by this script if a comment stands before it:

    <!-- made by `make readme` -->            or  <!-- made by `make readme`: lines 1-20, 31-34 -->
    ```
    $ veridyn check out/demo/train.csv
    ...
    ```

A comment `<!-- prepare: COMMAND -->` runs a command whose output nobody sees. Lines that begin with "$ " are run by bash, one after the other, in FOLDER (which is emptied first; the tool is on the PATH), with their
continuations ("\\" at the end). "lines" keeps those of the last command's output, with "..." for what is left out. Lines longer
than 150 characters are cut. A comparison allows numbers to differ by 5 %, and seconds by anything.
"""

import os
import re
import shutil
import subprocess
import sys

WIDTH = 150
BLOCK = re.compile(r"<!-- prepare: (?P<prepare>.*?) -->|(?P<head><!-- made by `make readme`(?::(?P<options>[^>]*?))? -->\n```[a-z]*\n)(?P<body>.*?)(?=^```$)", re.S | re.M)
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
TIMES = re.compile(r"\b\d+(?:\.\d+)?(?:e[-+]?\d+)? (?:s|ms|us)\b|0x[0-9a-f]+|p = \S+|t = \S+|rank gap \S+")


def commands_of(body):
    """The commands of a block, each with its continuation lines."""
    found = []
    for line in body.splitlines():
        if line.startswith("$ "):
            found.append(line)
        elif found and found[-1].endswith("\\"):
            found[-1] += "\n" + line
    return found


def kept(lines, options):
    """Those of an output's lines that the options name."""
    ranges = re.findall(r"(\d+)-(\d+)", options or "")
    if not ranges:
        return lines
    out, last = [], 0
    for first, end in ((int(a), int(b)) for a, b in ranges):
        if first > last + 1:
            out.append("...")
        out += lines[first - 1:end]
        last = end
    if last < len(lines):
        out.append("...")
    return out


def run(body, options, folder):
    out = []
    for command in commands_of(body):
        done = subprocess.run(["bash", "-c", command[2:]], cwd=folder, stdout=subprocess.PIPE,
                              stderr=subprocess.DEVNULL, text=True, timeout=600)
        if done.returncode not in (0, 4):
            sys.exit(f"blocks: status {done.returncode} of: {command[2:]}")
        lines = [line.rstrip()[:WIDTH] for line in done.stdout.rstrip("\n").splitlines()]
        out += command.splitlines() + kept(lines, options)
    return "\n".join(out) + "\n"


def words(line):
    line = TIMES.sub("TIME", line)
    return NUMBER.split(line), [float(n) for n in NUMBER.findall(line)]


def same(a, b):
    text_a, numbers_a = words(a)
    text_b, numbers_b = words(b)
    squeeze = [re.sub(r"\s+", " ", t) for t in text_a], [re.sub(r"\s+", " ", t) for t in text_b]
    if squeeze[0] != squeeze[1] or len(numbers_a) != len(numbers_b):
        return False
    # A digit of the last place printed, or 5 %.
    return all(abs(x - y) <= 0.05 * max(abs(x), abs(y)) + 0.011 for x, y in zip(numbers_a, numbers_b))


def main():
    mode, page, folder = sys.argv[1:]
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    with open(page, encoding="utf-8") as file:
        text = file.read()
    data = os.environ.get("VERIDYN_REAL_DATA", os.path.join(os.environ["VERIDYN_SOURCE"], "..", "shared", "data"))
    if "VERIDYN_REAL_DATA" in text and not os.path.isdir(data):
        print(f"{page}: skipped: there are no real recordings in {data}")
        sys.exit(77)
    wrong = []

    def made(match):
        if match["prepare"]:
            subprocess.run(["bash", "-c", match["prepare"]], cwd=folder, check=True, stdout=subprocess.DEVNULL, timeout=600)
            return match[0]
        new = run(match["body"], match["options"], folder)
        old_lines, new_lines = match["body"].splitlines(), new.splitlines()
        for k in range(max(len(old_lines), len(new_lines))):
            a = old_lines[k] if k < len(old_lines) else "(nothing)"
            b = new_lines[k] if k < len(new_lines) else "(nothing)"
            if not same(a, b):
                wrong.append(f"{page}: found\n  {a}\nexpected, as the command prints it,\n  {b}")
        return match["head"] + new

    new_text = BLOCK.sub(made, text)
    blocks = sum(1 for m in BLOCK.finditer(text) if m["head"])
    if mode == "write":
        with open(page + ".new", "w", encoding="utf-8") as file:
            file.write(new_text)
        os.replace(page + ".new", page)
        print(f"{page}: {blocks} blocks written")
        return
    print("\n".join(wrong) if wrong else f"{page}: {blocks} blocks are what their commands print")
    sys.exit(1 if wrong or blocks == 0 else 0)


main()
