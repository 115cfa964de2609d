#!/usr/bin/env python3
"""mpirun -n 1, 2, 4 TOOL identify, factor files and one process give one answer, on noisy recordings and on such whose
velocity of a joint is no derivative of its position. Ranks leave out what cannot be read, and say so.

    mpirun.py TOOL SOURCE

TOOL is built with VERIDYN_WITH_MPI. Status 77, skipped: mpirun starts no two processes on this machine.
"""

import json
import math
import os
import subprocess
import sys
import tempfile

TOLERANCE = 1e-12


def motion(path, seed):
    with open(path, "w") as f:
        f.write("t,q1,q2\n")
        for k in range(1000):
            t = 0.01 * k
            q = [sum(math.sin(2 * math.pi * (0.13 + 0.07 * w + 0.01 * seed) * t + w + j) / (w + 1)
                     for w in range(4)) for j in range(2)]
            f.write("%.2f,%.9f,%.9f\n" % (t, *q))


def scale_velocity(path, column, factor):
    rows = [line.rstrip("\n").split(",") for line in open(path)]
    at = rows[0].index(column)
    for row in rows[1:]:
        row[at] = repr(float(row[at]) * factor)
    with open(path, "w") as f:
        f.writelines(",".join(row) + "\n" for row in rows)


def largest_difference(a, b):
    """Of all numbers under `base_parameters`, `train` and `test`, relative to the larger one."""
    if isinstance(a, dict):
        return max([largest_difference(a[k], b[k]) for k in a if k != "seconds"] + [0.0])
    if isinstance(a, list):
        assert len(a) == len(b), (a, b)
        return max([largest_difference(x, y) for x, y in zip(a, b)] + [0.0])
    if isinstance(a, float) and isinstance(b, float):
        return abs(a - b) / max(abs(a), abs(b), 1e-9)
    assert a == b, (a, b)
    return 0.0


def main(tool, source):
    # mpirun refuses a superuser, such as a container's, unless told twice.
    os.environ.update(OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")
    # Under a sanitizer: Open MPI never frees what its plug-ins allocate, and they are gone at the end, without a name.
    os.environ["ASAN_OPTIONS"] = ":".join(filter(None, [os.environ.get("ASAN_OPTIONS"), "detect_leaks=0"]))
    if subprocess.run(["mpirun", "--oversubscribe", "-n", "2", "true"], capture_output=True).returncode != 0:
        print("mpirun starts no processes here: skipped")
        sys.exit(77)
    robot = os.path.join(source, "data", "robots", "planar-2r.yaml")
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        for seed in range(6):
            motion("motion.csv", seed)
            subprocess.run([tool, "simulate", robot, "--trajectory", "motion.csv", "-o",
                            "r%d.csv" % seed, "--seed", str(seed + 1), "--quiet"], check=True,
                           stdout=subprocess.DEVNULL)
        one_answer(tool, robot)
        for seed in range(6):
            scale_velocity("r%d.csv" % seed, "dq2", 1.3)
        one_answer(tool, robot, "dq2 (")
    print("one answer")


def one_answer(tool, robot, remark=""):
    good = ["r%d.csv" % k for k in range(5)]
    tail = ["--test", "r5.csv", "--quiet", "--threads", "1", "--json"]
    subprocess.run([tool, "identify", robot, "--train"] + good + tail + ["serial.json"],
                   check=True, stdout=subprocess.DEVNULL)
    serial = json.load(open("serial.json"))
    assert len(serial["base_parameters"]) > 2
    assert any(remark in r for r in serial.get("remarks", [""])), serial.get("remarks")
    made = subprocess.run([tool, "identify", robot, "--train"] + good + ["--factor-out", "all.factors"] + tail +
                          ["factors.json"], check=True, capture_output=True, text=True)
    subprocess.run([tool, "identify", robot, "--factors", "all.factors"] + tail + ["again.json"], check=True,
                   stdout=subprocess.DEVNULL)
    for name in ("factors.json", "again.json"):
        difference = largest_difference(serial["base_parameters"], json.load(open(name))["base_parameters"])
        assert difference < TOLERANCE, (name, difference, made.stderr)
    for ranks in (1, 2, 4):
        with open("broken.csv", "w") as f:
            f.write("neither,here,nor,there\n")
        bad = good[:2] + ["broken.csv", "missing.csv"] + good[2:]
        train = good if ranks == 1 else bad
        run = subprocess.run(["mpirun", "--oversubscribe", "-n", str(ranks), tool, "identify",
                              robot, "--train"] + train + tail + ["ranks.json"],
                             check=True, capture_output=True, text=True)
        answer = json.load(open("ranks.json"))
        left_out = answer.pop("left_out_recordings", [])
        names = [entry["file"] for entry in left_out]
        assert names == ([] if ranks == 1 else ["broken.csv", "missing.csv"]), names
        for name in names:
            assert "left out: " + name in run.stderr, run.stderr
        for key in ("base_parameters", "train", "test"):
            difference = largest_difference(serial[key], answer[key])
            assert difference < TOLERANCE, (ranks, key, difference)


if __name__ == "__main__":
    main(os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2]))
