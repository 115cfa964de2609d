#!/usr/bin/env python3
"""What `veridyn identify` and `diagnose` give on recordings of real arms: held-out errors, base
parameters, findings, times.

    diagnosis_benchmark.py run TOOL DATA -o RESULT.json [--only NAME,...] [--identify]
    diagnosis_benchmark.py compare BEFORE.json AFTER.json

DATA is the folder of real recordings (VERIDYN_REAL_DATA of the tests). `run` diagnoses every case
(with --identify it identifies each as well), prints a table and keeps findings and intervals;
names that end in /defaults have no options. `compare` prints both results of every case below one
another, and ends with status 1 where a held-out error is worse by more than 0.3 points or a cause
is no longer found. Times are processor seconds of the process and its threads, which a busy machine
disturbs least.
"""

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile


def cases(data):
    fourier = [os.path.join(data, "psm1-thesis", "fourier-%d.csv" % k) for k in range(1, 7)]
    thesis = ["--filter-cutoff", "3.5", "--filter-order", "8"]

    def wrist(name):
        return os.path.join(data, "psm-wrist", name)

    def panda(name):
        return os.path.join(data, "panda", name)

    def lwr(numbers):
        return [os.path.join(data, "lwr4", "lwr-%d.npz" % k) for k in numbers]

    panda_robot = os.path.join(os.path.dirname(os.path.abspath(__file__)), "robots", "panda.yaml")

    def ur(name):
        return os.path.join(data, "ur10e", name)

    ur_settings = ["--rows", "635:3510", "--test-rows", "700:4200", "--filter-cutoff", "7",
                   "--resample", "100"]
    return {
        "psm-3dof/5": ["psm-3dof", "--train"] + fourier[:4] + ["--test", fourier[4]] + thesis,
        "psm-3dof/6": ["psm-3dof", "--train"] + fourier[:4] + ["--test", fourier[5]] + thesis,
        "psm-3dof": ["psm-3dof", "--train"] + fourier[:4] + ["--test"] + fourier[4:] + thesis,
        "psm-3dof-printed": ["psm-3dof-printed", "--train"] + fourier[:4] + ["--test"]
        + fourier[4:] + thesis,
        "psm-wrist": ["psm-wrist", "--train", wrist("one.csv"), "--test", wrist("two.csv"),
                      "--filter-cutoff", "5.4"],
        "mtm": ["mtm", "--train", os.path.join(data, "mtm", "one.csv"), "--test",
                os.path.join(data, "mtm", "two.csv"), "--filter-cutoff", "5.65"],
        "ur10e": ["ur10e", "--train", ur("free-12harm30s-2020-02-10.csv"), "--test",
                  ur("free-point-to-point-2020-01-17.csv")] + ur_settings,
        # The motion of another day, without the rests at its ends; above, joint 6 rests half of the time.
        "ur10e/50s": ["ur10e", "--train", ur("free-12harm30s-2020-02-10.csv"), "--test",
                      ur("free-14harm50s-2020-02-19.csv"), "--rows", "635:3510", "--test-rows",
                      "260:4960", "--filter-cutoff", "7", "--resample", "100"],
        "panda/2": [panda_robot, "--train", panda("panda-1.csv"), "--test", panda("panda-2.csv")],
        "panda/1": [panda_robot, "--train", panda("panda-2.csv"), "--test", panda("panda-1.csv")],
        "lwr4/3": ["kuka-lwr4", "--train"] + lwr([1, 2]) + ["--test"] + lwr([3]),
        "lwr4/1": ["kuka-lwr4", "--train"] + lwr([2, 3]) + ["--test"] + lwr([1]),
        "psm-3dof/defaults": ["psm-3dof", "--train"] + fourier[:4] + ["--test"] + fourier[4:],
        "psm-3dof-one/defaults": ["psm-3dof", "--train", fourier[0], "--test", fourier[4]],
        "psm-wrist/defaults": ["psm-wrist", "--train", wrist("one.csv"), "--test",
                               wrist("two.csv")],
        "mtm/defaults": ["mtm", "--train", os.path.join(data, "mtm", "one.csv"), "--test",
                         os.path.join(data, "mtm", "two.csv")],
        "ur10e/defaults": ["ur10e", "--train", ur("free-14harm50s-2020-02-19.csv"), "--test",
                           ur("free-12harm30s-2020-02-10.csv")],
    }


def percents(errors):
    return [round(100.0 * e, 2) for e in errors]


def held_out(model):
    """Every figure of the held-out recordings, under the name it has in the JSON."""
    test = model["test"]
    out = {"test": percents(test["relative_error"])}
    for name in ("as_recorded", "repaired", "without_excluded"):
        if name in test:
            out[name] = percents(test[name]["relative_error"])
    return out


def play(tool, command, arguments):
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "out.json")
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        done = subprocess.run([tool, command] + arguments + ["--json", path, "--quiet"],
                              stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        if done.returncode != 0:
            return {"failed": done.stderr.strip()}
        with open(path) as file:
            d = json.load(file)
    times = {"processor_seconds": round(after.ru_utime - before.ru_utime
                                        + after.ru_stime - before.ru_stime, 2)}
    if command == "identify":
        return {"baseline": held_out(d), "findings": [], **times,
                "base": [[b["expression"], b["value"], b["std"]] for b in d["base_parameters"]]}
    findings = []
    for f in d["findings"]:
        findings.append({"effect": f["effect"], "joint": f["joint"], "frame": f.get("frame", ""),
                         "explains": f["explains"], "status": f.get("status", ""),
                         "parameters": f["parameters"]})
    return {"baseline": held_out(d["baseline"]), "extended": held_out(d["extended"]),
            "findings": findings, "hypotheses": d["hypotheses"], **times,
            "seconds": round(d["seconds"], 2)}


def show(name, result):
    if "failed" in result:
        print("%-18s FAILED: %s" % (name, result["failed"]))
        return
    print("%-18s %.1f s of processor, %d findings" % (
        name, result["processor_seconds"], len(result["findings"])))
    for model in ("baseline", "extended"):
        for figure, values in result.get(model, {}).items():
            print("  %-9s %-17s %s" % (model, figure, " ".join("%7.2f" % v for v in values)))
    words = []
    for f in result["findings"]:
        mark = " (not confirmed)" if f["status"] == "not_confirmed" else ""
        words.append("%s:%s %.0f %%%s" % (f["effect"], f["frame"] or f["joint"],
                                          100.0 * (f["explains"] or 0.0), mark))
    if words:
        print("  " + ", ".join(words))


def run(arguments):
    results = {}
    for name, words in cases(arguments.data).items():
        if arguments.only and name not in arguments.only.split(","):
            continue
        played = [(name, "diagnose")]
        if arguments.identify and "printed" not in name:
            played.append((name + " identified", "identify"))
        for title, command in played:
            results[title] = play(arguments.tool, command, words)
            show(title, results[title])
            sys.stdout.flush()
    if arguments.output:
        with open(arguments.output, "w") as file:
            json.dump(results, file, indent=1)


def causes(result):
    return {(f["effect"], f["frame"] or f["joint"]) for f in result.get("findings", [])}


def worse(before, after):
    """In words, where a result is worse than the one before: failures, errors, lost causes."""
    if "failed" in after:
        return [] if "failed" in before else ["fails"]
    if "failed" in before:
        return []
    out = ["%s:%s is no longer found" % cause for cause in sorted(causes(before) - causes(after),
                                                                   key=str)]
    for model in ("baseline", "extended"):
        pairs = zip(before.get(model, {}).get("test", []), after.get(model, {}).get("test", []))
        for joint, (x, y) in enumerate(pairs, 1):
            if y > x + 0.3:
                out.append("%s, joint %d: %.2f %% -> %.2f %%" % (model, joint, x, y))
    return out


def compare(arguments):
    with open(arguments.before) as file:
        before = json.load(file)
    with open(arguments.after) as file:
        after = json.load(file)
    complaints = []
    for name in after:
        if name in before:
            show(name + " before", before[name])
            complaints += [name + ": " + one for one in worse(before[name], after[name])]
        show(name + " after", after[name])
    for one in complaints:
        print("WORSE " + one)
    return 1 if complaints else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    command = commands.add_parser("run")
    command.add_argument("tool")
    command.add_argument("data")
    command.add_argument("-o", dest="output")
    command.add_argument("--only")
    command.add_argument("--identify", action="store_true")
    command.set_defaults(act=run)
    command = commands.add_parser("compare")
    command.add_argument("before")
    command.add_argument("after")
    command.set_defaults(act=compare)
    arguments = parser.parse_args()
    return arguments.act(arguments)


if __name__ == "__main__":
    sys.exit(main())
