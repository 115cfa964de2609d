#!/usr/bin/env python3
"""What the tool gives on real recordings: held-out errors, findings, intervals, processor time.

Usage: real_recordings.py TOOL DATA OUT.json [NAME...]
       real_recordings.py --compare BEFORE.json AFTER.json

TOOL is the program to run, DATA the folder with the recordings. --compare prints what differs and
fails where a held-out error is worse by more than 0.3 points or a finding has gone.
"""
import json
import os
import resource
import subprocess
import sys
import tempfile

FOURIER = "psm1-thesis/fourier-{}.csv"
SETS = {
    "psm-3dof": ("psm-3dof", [FOURIER.format(k) for k in (1, 2, 3, 4)],
                 [FOURIER.format(k) for k in (5, 6)], []),
    "psm-3dof-one": ("psm-3dof", [FOURIER.format(1)], [FOURIER.format(5)], []),
    "psm-wrist": ("psm-wrist", ["psm-wrist/one.csv"], ["psm-wrist/two.csv"], []),
    "mtm": ("mtm", ["mtm/one.csv"], ["mtm/two.csv"], []),
    "ur10e": ("ur10e", ["ur10e/free-14harm50s-2020-02-19.csv"],
              ["ur10e/free-12harm30s-2020-02-10.csv"], []),
}


def run(tool, command, data, name):
    robot, train, test, more = SETS[name]
    place = lambda files: [os.path.join(data, f) for f in files]
    with tempfile.TemporaryDirectory() as folder:
        out = os.path.join(folder, "out.json")
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        words = [tool, command, robot, "--train", *place(train), "--test", *place(test), *more,
                 "--threads", "1", "--quiet", "--json", out]
        done = subprocess.run(words, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        if not os.path.exists(out):
            return {"status": done.returncode, "error": done.stderr.strip()}
        with open(out) as stream:
            result = json.load(stream)
    seconds = after.ru_utime - before.ru_utime
    return {"status": done.returncode, "user_seconds": round(seconds, 2), **digest(result)}


def digest(result):
    if result["command"] == "identify":
        return {"test": result["test"]["relative_error"],
                "base": [[b["expression"], b["value"], b["std"]]
                         for b in result["base_parameters"]]}
    return {"test": result["baseline"]["test"]["relative_error"],
            "extended": result["extended"]["test"]["relative_error"],
            "next": result.get("next_experiment"),
            "findings": [{"cause": "%s:%s" % (f["effect"], f.get("frame") or f["joint"]),
                          "parameters": f["parameters"],
                          "rivals": ["%s:%s" % (r["effect"], r["joint"]) for r in f["rivals"]]}
                         for f in result["findings"]]}


def compare(before, after):
    worse = 0
    for name in sorted(set(before) & set(after)):
        a, b = before[name], after[name]
        for key in ("test", "extended"):
            for joint, (x, y) in enumerate(zip(a.get(key) or [], b.get(key) or []), 1):
                if abs(x - y) > 1e-6:
                    print(f"{name}: {key} of joint {joint}: {100 * x:.3f} % -> {100 * y:.3f} %")
                worse += y > x + 0.003
        causes = lambda r: [f["cause"] for f in r.get("findings", [])]
        if causes(a) != causes(b):
            print(f"{name}: findings\n  before {causes(a)}\n  after  {causes(b)}")
            worse += len(set(causes(a)) - set(causes(b)))
        for f, g in zip(a.get("findings", []), b.get("findings", [])):
            for key in f["parameters"]:
                x, y = f["parameters"][key], g["parameters"].get(key)
                if y is not None and abs(x["value"] - y["value"]) > 1e-4 * abs(x["value"]):
                    print(f"{name}: {f['cause']} {key}: {x} -> {y}")
        print(f"{name}: {a.get('user_seconds')} s -> {b.get('user_seconds')} s of processor time")
    return 1 if worse else 0


def main():
    if sys.argv[1] == "--compare":
        before, after = (json.load(open(path)) for path in sys.argv[2:4])
        return compare(before, after)
    tool, data, out = sys.argv[1:4]
    results = {}
    for name in sys.argv[4:] or SETS:
        for command in ("identify", "diagnose"):
            results[f"{command} {name}"] = run(tool, command, data, name)
            with open(out, "w") as stream:
                json.dump(results, stream, indent=1)
    return 0


if __name__ == "__main__":
    sys.exit(main())
