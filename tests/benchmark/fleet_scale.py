#!/usr/bin/env python3
"""A fleet of simulated arms by factor files on one machine: time and memory of every part, and from these what a
cluster would take.

    fleet_scale.py TOOL [--arms 1000] [--machines 100] [--jobs 2] [--json RESULT.json]

The arms are one chain of seven joints with friction of their own (10 % spread); the arm in the middle has twice the
Coulomb friction on its third joint. Every arm is simulated, its recording becomes a factor file and is deleted, and
`fleet` reads the factor files. Seconds are those of the processor, so that they hold on a busy machine.
"""

import argparse
import concurrent.futures
import json
import os
import random
import re
import subprocess
import sys
import tempfile

import growth

JOINTS = 7
SPREAD = 0.1  # of the arms' friction
NETWORK = 1e9 / 8  # [bytes/s] between the cluster's machines


def run(command):
    """Seconds of the processor and the largest resident MB of a command that must succeed."""
    error = tempfile.TemporaryFile()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=error)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = status
    if status != 0:
        error.seek(0)
        sys.exit("%s\n%s" % (" ".join(command), error.read().decode()))
    return usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024.0


def arm_file(model, folder, number, odd):
    """The identified model with friction of its own."""
    draw = random.Random(number)

    def own(match):
        head, joint, parameter, value = match.groups()
        value = float(value) * max(0.2, draw.gauss(1.0, SPREAD))
        if number == odd and joint == "j3" and "coulomb" in head:
            value *= 2.0
        return "%s%s: 1}, %s: %.6g}" % (head, joint, parameter, value)

    path = os.path.join(folder, "arm-%d.yaml" % number)
    text = re.sub(r"(- \{effect: \w+_friction, axis: \{)(j\d+): 1\}, (level|coefficient): ([-\d.e+]+), std: \{.*?\}\}",
                  own, model)
    with open(path, "w") as out:
        out.write(text)
    return path


def one_arm(tool, robot, model, trajectory, folder, number, odd):
    """Simulates arm `number` and makes its factor file: seconds and MB of both, bytes of both files."""
    arm = arm_file(model, folder, number, odd)
    recording = os.path.join(folder, "arm-%d.csv" % number)
    factors = os.path.join(folder, "arm-%d.factors" % number)
    simulated = run([tool, "simulate", arm, "--trajectory", trajectory, "-o", recording, "--noise", "low",
                     "--seed", str(number), "--quiet"])
    compressed = run([tool, "identify", robot, "--train", recording, "--factor-out", factors, "--method", "ols",
                      "--velocity", "derived", "--threads", "1", "--quiet"])
    sizes = os.path.getsize(recording), os.path.getsize(factors)
    os.remove(recording)
    os.remove(arm)
    return simulated, compressed, sizes


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("tool")
    parser.add_argument("--arms", type=int, default=1000)
    parser.add_argument("--machines", type=int, default=100)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--json")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        robot = growth.robot(folder, JOINTS)
        trajectory = os.path.join(folder, "motion.csv")
        growth.motion(trajectory, JOINTS, 1)
        odd = (options.arms + 1) // 2
        first, found = os.path.join(folder, "first.csv"), os.path.join(folder, "first.yaml")
        run([options.tool, "simulate", robot, "--trajectory", trajectory, "-o", first, "--noise", "low", "--quiet"])
        run([options.tool, "identify", robot, "--train", first, "--model-out", found, "--quiet"])
        with open(found) as f:
            model = f.read()
        with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
            arms = list(pool.map(lambda k: one_arm(options.tool, robot, model, trajectory, folder, k, odd),
                                 range(1, options.arms + 1)))
        mean = lambda values: sum(values) / len(values)
        result = {
            "arms": options.arms, "joints": JOINTS, "rows": growth.ROWS,
            "simulate_s": mean([a[0][0] for a in arms]), "simulate_mb": max(a[0][1] for a in arms),
            "factors_s": mean([a[1][0] for a in arms]), "factors_mb": max(a[1][1] for a in arms),
            "recording_bytes": mean([a[2][0] for a in arms]), "factor_bytes": mean([a[2][1] for a in arms]),
            "fleet": []}
        for count in sorted({n for n in (10, 100, 300, options.arms) if n <= options.arms}):
            listed = os.path.join(folder, "list.csv")
            # Always with the odd one.
            numbers = list(range(1, count)) + [odd] if odd >= count else list(range(1, count + 1))
            with open(listed, "w") as f:
                f.writelines("arm-%d,arm-%d.factors\n" % (k, k) for k in numbers)
            out = os.path.join(folder, "fleet.json")
            seconds, megabytes = run([options.tool, "fleet", robot, listed, "--velocity", "derived", "--json", out,
                                      "--threads", "1", "--quiet"])
            with open(out) as f:
                answer = json.load(f)
            named = sorted({d["arm"] for d in answer["outliers"]})
            result["fleet"].append({"arms": count, "s": seconds, "mb": megabytes, "named": named,
                                    "odd": "arm-%d" % odd})
    print("%(arms)d arms, %(joints)d joints, %(rows)d rows each" % result)
    print("one arm: simulated in %(simulate_s).2f s (%(simulate_mb).0f MB); recording of %(recording_bytes).0f bytes "
          "to factors of %(factor_bytes).0f bytes in %(factors_s).2f s (%(factors_mb).0f MB)" % result)
    for f in result["fleet"]:
        print("fleet of %(arms)4d: %(s).2f s, %(mb).0f MB; named: %(named)s (other friction: %(odd)s)" % f)
    last = result["fleet"][-1]
    per_arm = last["s"] / last["arms"]
    hours = options.machines * 3600.0 / result["factors_s"]
    print("a cluster of %d machines, one core each, by these parts: %.0f recordings an hour to factors; for %d recordings of %d "
          "arms: factors %.1f s, transfer of %.0f MB in %.1f s at 1 Gbit/s, fleet on one machine %.1f s"
          % (options.machines, hours, 100 * options.arms, options.arms,
             100 * options.arms * result["factors_s"] / options.machines,
             100 * options.arms * result["factor_bytes"] / 1e6,
             100 * options.arms * result["factor_bytes"] / NETWORK, 100 * per_arm * options.arms))
    if options.json:
        with open(options.json, "w") as f:
            json.dump(result, f, indent=1)


if __name__ == "__main__":
    main()
