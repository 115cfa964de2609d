#!/usr/bin/env python3
"""Noise of identifications: what real arms leave, and whether predicted deviations are reached.

    noise_benchmark.py TOOL --real DATA     residual of plain identification on real recordings
    noise_benchmark.py TOOL --simulated     deviations that `excite --noise-of` predicts against the
                                            scatter of identifications from simulated recordings

The first counts the noise that a MODEL keeps (`identified: noise`) as a share of each joint's rms
torque. The second simulates a recording, designs a motion with its noise, simulates that motion
twelve times with other noise, and divides predicted by observed standard deviations.
"""

import argparse
import csv
import json
import math
import pathlib
import re
import statistics
import subprocess
import tempfile

UR_GAINS = [12, 12, 9.82, 10.68, 10.9, 11]
REAL = (
    [("psm-3dof", f"psm1-thesis/fourier-{k}.csv", []) for k in range(1, 7)]
    + [(arm, f"{arm}/{rec}.csv", []) for arm in ("psm-wrist", "mtm") for rec in ("one", "two")]
    + [("ur10e", f"ur10e/free-{rec}.csv", UR_GAINS)
       for rec in ("12harm30s-2020-02-10", "8harm20s-2020-02-05", "14harm50s-2020-02-19")]
    + [("PANDA", f"panda/panda-{k}.csv", []) for k in (1, 2)]
)
ARMS = ["planar-2r", "scara", "psm-3dof", "psm-3dof-printed", "psm-3dof-rods", "psm-wrist", "mtm", "ur10e", "kuka-lwr4"]
RECORDINGS = 12


def run(tool, *words):
    done = subprocess.run([tool, *map(str, words), "--quiet"], capture_output=True, text=True)
    if done.returncode != 0:
        raise SystemExit(f"{' '.join(map(str, words))}: {done.stderr}")


def rms_torque(path, gains):
    with open(path) as rows:
        table = list(csv.reader(line for line in rows if not line.startswith("#")))
    columns = [i for i, name in enumerate(table[0]) if re.fullmatch(r"(tau|i)\d+", name.strip())]
    gains = gains or [1.0] * len(columns)
    return [math.sqrt(statistics.fmean((float(row[i]) * k) ** 2 for row in table[1:])) for i, k in zip(columns, gains)]


def real(tool, data, folder):
    shares = []
    panda = pathlib.Path(__file__).parent / "robots/panda.yaml"
    for arm, recording, gains in REAL:
        path = data / recording
        model = folder / "model.yaml"
        current = ["--units", "tau=A", "--drive-gains", ",".join(map(str, gains))] if gains else []
        run(tool, "identify", panda if arm == "PANDA" else arm, "--train", path, "--model-out", model, *current)
        noise = [float(v) for v in re.search(r"  noise: \[(.*?)\]", model.read_text()).group(1).split(",")]
        shares += [a / b for a, b in zip(noise, rms_torque(path, gains))]
        print(f"{recording:<36}", *(f"{100 * s:6.1f}" for s in shares[-len(noise):]))
    low, middle, high = statistics.quantiles(shares, n=4)
    print(f"{len(shares)} joints: median {100 * middle:.1f} % of the rms torque, quartiles {100 * low:.1f} and {100 * high:.1f} %")


def simulated(tool, folder, seeds):
    quick = ["--rate", 100, "--starts", 1, "--iterations", 80]
    everything = []
    for arm in ARMS:
        ratios = []
        for seed in seeds:
            first, truth, earlier, motion, rec, out = (folder / f for f in ("m0.csv", "t.yaml", "r0.csv", "m.csv", "r.csv", "o.json"))
            run(tool, "excite", arm, "-o", first, "--seed", 100 + seed, *quick)
            run(tool, "simulate", arm, "--trajectory", first, "-o", earlier, "--arm-seed", seed, "--model-out", truth, "--noise", "dvrk")
            run(tool, "excite", truth, "-o", motion, "--seed", seed, "--json", out, "--noise-of", earlier, *quick)
            expected = {p["name"]: p["std"] for p in json.loads(out.read_text())["prediction"]["base_parameters"]}
            values = {name: [] for name in expected}
            for k in range(RECORDINGS):
                run(tool, "simulate", truth, "--trajectory", motion, "-o", rec, "--noise", "dvrk", "--seed", 1000 * seed + k)
                run(tool, "identify", truth, "--train", rec, "--json", out, "--method", "wls", "--weights", "residual")
                for p in json.loads(out.read_text())["base_parameters"]:
                    values.get(p["name"], []).append(p["value"])
            ratios += [expected[name] / statistics.stdev(v) for name, v in values.items() if len(v) == RECORDINGS]
        everything += ratios
        tell(arm, ratios)
    tell("all", everything)


def tell(name, ratios):
    within = statistics.fmean(1 / 1.5 <= r <= 1.5 for r in ratios)
    print(f"{name:<18} {len(ratios):4} parameters: {100 * within:3.0f} % within 1.5 times, median ratio {statistics.median(ratios):.2f}", flush=True)


if __name__ == "__main__":
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("tool")
    options.add_argument("--real", metavar="DATA", type=pathlib.Path)
    options.add_argument("--simulated", action="store_true")
    options.add_argument("--seeds", type=int, default=3)
    asked = options.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        if asked.real:
            real(asked.tool, asked.real, pathlib.Path(scratch))
        if asked.simulated:
            simulated(asked.tool, pathlib.Path(scratch), range(1, asked.seeds + 1))
