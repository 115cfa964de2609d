#!/usr/bin/env python3
"""What `veridyn check ROBOT REC` says of recordings of real arms, as they are and with a mistake in
their columns: every joint's torque turned round, all of them, torques, motions or both of neighbouring
joints exchanged, positions (and velocities) in degrees.

    check_benchmark.py TOOL DATA [--only NAME,...]

DATA is the folder of real recordings (VERIDYN_REAL_DATA of the tests). A mistake counts as
recognised if a fault of its kind names its joint, and no other fault stands beside it; a sound
recording must have none. Prints what is missed, and a line for each recording.
"""

import argparse
import csv
import itertools
import json
import math
import os
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor

ROWS = 5100  # check compares the first 5000 with the robot
KINDS = {"torque_sign", "swapped_joints", "degrees", "current"}


def read(path):
    with open(path) as file:
        rows = list(itertools.islice(csv.reader(file), ROWS + 1))
    return [name.strip() for name in rows[0]], [[float(x) for x in row] for row in rows[1:]]


def mistakes(names):
    """Name, finding, joint (0: the whole arm) and columns to exchange or factors."""
    n = sum(name.startswith("tau") for name in names)
    column = {name: k for k, name in enumerate(names)}
    velocities = "dq1" in column
    for i in range(1, n + 1):
        yield "sign of %d" % i, {"torque_sign:%d" % i}, [], {column["tau%d" % i]: -1.0}
    yield ("all signs", {"torque_sign:%d" % i for i in range(1, n + 1)}, [],
           {column["tau%d" % i]: -1.0 for i in range(1, n + 1)})
    for i in range(1, n):
        j = i + 1
        motion = [(column[s % i], column[s % j]) for s in (["q%d", "dq%d"] if velocities else ["q%d"])]
        torque = [(column["tau%d" % i], column["tau%d" % j])]
        for what, pairs in ("torques", torque), ("motions", motion), ("both", motion + torque):
            yield "%s of %d and %d" % (what, i, j), {"swapped_joints:%d" % i}, pairs, {}


def degrees(names, turning):
    for letters in (("q",), ("q", "dq")):
        columns = {k: 180.0 / math.pi for k, name in enumerate(names)
                   for i in turning if name in [s + str(i) for s in letters]}
        if letters == ("q", "dq") and "dq1" not in names:
            continue
        yield "degrees of " + " and ".join(letters), {"degrees:0"}, [], columns


def faults(tool, robot, path):
    with tempfile.TemporaryDirectory() as folder:
        result = os.path.join(folder, "check.json")
        done = subprocess.run([tool, "check", robot, path, "--threads", "1", "--quiet", "--json", result],
                              capture_output=True, text=True)
        if not os.path.exists(result):
            sys.exit("check %s %s: %s" % (robot, path, done.stderr))
        with open(result) as file:
            recordings = json.load(file)["recordings"]
    found = [f for r in recordings for f in r["findings"] if f["finding"] in KINDS and f["severity"] == "fault"]
    return {"%s:%d" % (f["finding"], f.get("joint") or 0) for f in found}


def is_right(found, expected):
    """Degrees are also told joint by joint from positions beyond a turn."""
    if expected == {"degrees:0"}:
        return bool(found) and all(f.startswith("degrees:") for f in found)
    return found == expected


def play(tool, name, robot, path, turning):
    names, rows = read(path)
    cases = [("as recorded", set(), [], {})] + list(mistakes(names)) + list(degrees(names, turning))

    def one(case):
        what, expected, pairs, factors = case
        with tempfile.NamedTemporaryFile("w", suffix=".csv") as file:
            file.write(",".join(names) + "\n")
            for row in rows:
                row = list(row)
                for a, b in pairs:
                    row[a], row[b] = row[b], row[a]
                for k, factor in factors.items():
                    row[k] *= factor
                file.write(",".join(map(repr, row)) + "\n")
            file.flush()
            return what, expected, faults(tool, robot, file.name)

    with ThreadPoolExecutor(2) as pool:
        answers = list(pool.map(one, cases))
    sound = answers[0][2]
    right = sum(is_right(found, expected) for _, expected, found in answers[1:])
    missed = sum(not found for _, _, found in answers[1:])
    for what, expected, found in answers[1:]:
        if not is_right(found, expected):
            print("  %s, %s: %s" % (name, what, ", ".join(sorted(found)) or "nothing"))
    print("%-12s %3d of %3d recognised, %d met nothing; as recorded: %s"
          % (name, right, len(answers) - 1, missed, ", ".join(sorted(sound)) or "no fault"), flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tool")
    parser.add_argument("data")
    parser.add_argument("--only", default="")
    args = parser.parse_args()
    panda = os.path.join(os.path.dirname(os.path.abspath(__file__)), "robots", "panda.yaml")
    boards = {
        "psm-3dof": ("psm-3dof", "psm1-thesis/fourier-1.csv", [1, 2]),
        "psm-3dof/5": ("psm-3dof", "psm1-thesis/fourier-5.csv", [1, 2]),
        "psm-wrist": ("psm-wrist", "psm-wrist/one.csv", [1, 2, 4, 5, 6, 7]),
        "mtm": ("mtm", "mtm/one.csv", [1, 2, 3, 4, 5, 6, 7]),
        "panda": (panda, "panda/panda-1.csv", [1, 2, 3, 4, 5, 6, 7]),
    }
    for name, (robot, path, turning) in boards.items():
        if not args.only or name in args.only.split(","):
            play(args.tool, name, robot, os.path.join(args.data, path), turning)


if __name__ == "__main__":
    main()
