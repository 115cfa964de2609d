#!/usr/bin/env python3
"""Blocks of commands and their output in the pages, made and checked.

    blocks.py write PAGE.md FOLDER    runs every block's commands and writes their output into the page
    blocks.py check PAGE.md FOLDER    runs them and compares; exit status 1 names what differs

A block is made by this script if a comment stands before it:

    <!-- made by `make readme` -->        or  <!-- made by `make readme`: 1-3, /errors/-/held out/ -->
    ```
    $ veridyn check out/demo/train.csv
    ...
    ```

A comment `<!-- prepare: COMMAND -->` runs a command whose output nobody sees. Lines that begin with "$ " are run by bash, one
after the other, in FOLDER (which is emptied first; the tool is on the PATH), with their continuations ("\\" at the end). The
ranges keep those lines of the last command's output, by number or from the first line that a pattern matches, with "..." for what
is left out; /from/+4 keeps the line and the four behind it. Long lines are wrapped between words. A comparison allows numbers
to differ by 5 %, and seconds by anything.
"""

import os
import re
import shutil
import subprocess
import sys
import textwrap

WIDTH = 130
BLOCK = re.compile(r"<!-- prepare: (?P<prepare>.*?) -->|(?P<head><!-- made by `make readme`(?::(?P<options>[^>]*?))? -->\n```[a-z]*\n)(?P<body>.*?)(?=^```$)", re.S | re.M)
END = r"(\d+|/[^/]+/)"
RANGE = re.compile(END + r"(?:-" + END + r"|\+(\d+))?")
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


def place_of(end, lines, after=0):
    """The index of the line that an end of a range names, or None."""
    if end.isdigit():
        return int(end) - 1
    return next((k for k in range(after, len(lines)) if re.search(end[1:-1], lines[k])), None)


def kept(lines, options):
    """Those of an output's lines that the options name."""
    ranges = list(RANGE.finditer(options or ""))
    if not ranges:
        return lines
    out, last = [], 0
    for one in ranges:
        first = place_of(one[1], lines)
        if first is None:
            out.append(f"(no line has {one[1]})")
            continue
        end = first + int(one[3]) if one[3] else place_of(one[2], lines, first) if one[2] else first
        end = min(len(lines) - 1, first if end is None else end)
        if first > last:
            out.append("...")
        out += lines[first:end + 1]
        last = end + 1
    if last < len(lines):
        out.append("...")
    return out


def wrapped(line):
    indent = " " * (len(line) - len(line.lstrip()) + 4)
    return [line] if len(line) <= WIDTH else textwrap.wrap(line, WIDTH, subsequent_indent=indent, drop_whitespace=False,
                                                          break_long_words=False, break_on_hyphens=False)


def run(body, options, folder):
    out = []
    for command in commands_of(body):
        done = subprocess.run(["bash", "-c", command[2:]], cwd=folder, stdout=subprocess.PIPE,
                              stderr=subprocess.DEVNULL, text=True, timeout=600)
        if done.returncode not in (0, 4):
            sys.exit(f"blocks: status {done.returncode} of: {command[2:]}")
        lines = kept([line.rstrip() for line in done.stdout.rstrip("\n").splitlines()], options)
        out += command.splitlines() + [part.rstrip() for line in lines for part in wrapped(line)]
    return "\n".join(out) + "\n"


def words(text):
    text = TIMES.sub("TIME", re.sub(r"\s+", " ", text))
    return NUMBER.split(text), [float(n) for n in NUMBER.findall(text)]


def same(a, b):
    text_a, numbers_a = words(a)
    text_b, numbers_b = words(b)
    if text_a != text_b or len(numbers_a) != len(numbers_b):
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
        if not same(match["body"], new):  # where lines are wrapped does not count
            wrong.append(f"{page}: found\n{match['body']}\nexpected, as the commands print it,\n{new}")
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
