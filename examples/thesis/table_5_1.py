#!/usr/bin/env python3
"""Table 5.1 of the thesis beside what this project makes of the same six recordings:

    python3 examples/thesis/table_5_1.py FOLDER [veridyn]

FOLDER holds fourier-1.csv to fourier-6.csv. Rows: condition numbers of designed motions (`excite`), then condition numbers and
residual sums of squares of the three estimators on the recordings (`identify`), with the Denavit-Hartenberg table as printed and
as corrected (docs/thesis.md, Table 4.3). Columns are divided by their norms (5.26), signals are filtered
as in the thesis, and every sample counts.
"""
import json
import pathlib
import subprocess
import sys
import tempfile

FREQUENCIES = [0.1, 0.12, 0.13, 0.14, 0.16, 0.2]
THESIS = {
    "excite": [145.92, 136.97, 128.74, 129.61, 111.19, 110.87],
    "condition ols": [236.90, 240.00, 159.66, 179.50, 178.94, 158.54],
    "condition wls": [1198.50, 1024.80, 297.98, 606.24, 389.43, 349.75],
    "residual ols": [1440, 1161.8, 1034, 1252.5, 1181.1, 1492.3],
    "residual wls": [1917.5, 1466.5, 1208, 2146.5, 1311.4, 1792.4],
    "residual feasible": [1434.0, 1154.6, 1387, 1243.6, 1169.4, 1485.3],
}
ROBOTS = [("as printed", "psm-3dof-printed"), ("corrected", "psm-3dof")]


def run(tool, *words):
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "out.json"
        done = subprocess.run([tool, *words, "--quiet", "--json", str(out)], capture_output=True, text=True, check=False, cwd=folder)
        if not out.exists():
            sys.exit(f"{' '.join(words)}: {done.stderr.strip()}")
        return json.loads(out.read_text())


def row(name, numbers, digits=1):
    print(f"{name:<46}" + "".join(f"{n:>9.{digits}f}" for n in numbers))


def main():
    data = pathlib.Path(sys.argv[1]).resolve()
    tool = sys.argv[2] if len(sys.argv) > 2 else "veridyn"
    files = [str(data / f"fourier-{k}.csv") for k in range(1, 7)]
    row("base frequency, Hz", FREQUENCIES, 2)
    row("condition number, designed: thesis", THESIS["excite"])
    for share in ("1", "default"):
        limits = [] if share == "default" else ["--limit-share", share]
        made = [run(tool, "excite", "psm-3dof", "-o", "motion.csv", "--criterion", "condition", "--frequency", str(f),
                    "--harmonics", "5", "--duration", "30", *limits) for f in FREQUENCIES]
        where = "within the limits" if limits else "with the supervisor's margin"
        row(f"  veridyn, {where}", [m["condition_number"] for m in made])
    for method, residual in (("ols", "least squares"), ("wls", "weighted least squares"), ("feasible", "feasible (SDP)")):
        fits = {robot: [run(tool, "identify", robot, "--train", f, "--method", method, "--filtering", "signals", "--decimation", "1",
                            "--velocity", "recorded") for f in files] for _, robot in ROBOTS}
        if f"condition {method}" in THESIS:
            row(f"condition number, {residual}: thesis", THESIS[f"condition {method}"])
            for words, robot in ROBOTS:
                row(f"  veridyn, table {words}", [f["condition_number"] for f in fits[robot]])
        row(f"residual, {residual}: thesis", THESIS[f"residual {method}"], 0)
        for words, robot in ROBOTS:
            row(f"  veridyn, table {words}", [f["objective"] for f in fits[robot]], 2 if method != "ols" else 0)
            if method == "feasible":
                row("    the same rows without constraints", [f["unconstrained_objective"] for f in fits[robot]], 2)


main()
