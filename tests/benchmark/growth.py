#!/usr/bin/env python3
"""How time and memory of veridyn grow: with rows, recordings, joints and bodies.

    growth.py TOOL [--beside OTHER_TOOL] [--only NAME,...] [--large] [--threads N]
              [--json RESULT.json] [--svg PLOT.svg] [--benchmark VERIDYN_BENCHMARK]
    growth.py --draw RESULT.json --svg PLOT.svg

Arms are chains of N revolute joints with viscous and Coulomb friction; recordings are made by
`TOOL simulate` along sums of sines. Longer recordings repeat one of 8,000 rows, with time going on.
Every figure is one run of the program as a user calls it: seconds of wall clock and of processor,
and the largest resident memory, from the operating system. OTHER_TOOL runs the same commands
in turn with TOOL. `--large` goes to 1e7 rows and 1,000 recordings.
"""

import argparse
import json
import math
import os
import random
import subprocess
import sys
import tempfile
import time

ROWS = 8000
RATE = 200.0
ALPHA = ["0", "-pi/2", "pi/2", "pi/2", "-pi/2", "-pi/2", "pi/2"]
OFFSET = [0.34, 0.0, 0.4, 0.0, 0.39, 0.0, 0.08]
MINUTES = 40  # a run is ended after so long


def robot(folder, joints):
    """A chain like a seven-joint arm, one after the other; long ones are as long as a short one."""
    path = os.path.join(folder, "chain-%d.yaml" % joints)
    shrink = min(1.0, 7.0 / joints)
    lines = ["veridyn: 1", "name: chain-%d" % joints, "gravity: [0, 0, -9.81]",
             "convention: modified", "coordinates:"]
    for j in range(joints):
        lines.append("  - {name: j%d, limits: {position: [-2, 2], velocity: 3, effort: 100}}"
                     % (j + 1))
    lines.append("frames:")
    for j in range(joints):
        parent = "world" if j == 0 else "link%d" % j
        lines.append("  - {name: link%d, parent: %s, dh: [%g, %s, %g, 0], revolute: {j%d: 1}, "
                     "body: true}" % (j + 1, parent, 0.01 * (j % 7) * shrink, ALPHA[j % 7],
                                      OFFSET[j % 7] * shrink, j + 1))
    lines.append("effects:")
    for j in range(joints):
        for effect in ("viscous_friction", "coulomb_friction"):
            lines.append("  - {effect: %s, axis: {j%d: 1}}" % (effect, j + 1))
    with open(path, "w") as f:
        f.write("\n".join(lines) + "\n")
    return path


def motion(path, joints, seed):
    """Two periods of 20 s of five sines for every joint."""
    draw = random.Random(seed)
    waves = [[(draw.uniform(0.1, 0.45) / k, draw.uniform(0, 2 * math.pi)) for k in range(1, 6)]
             for _ in range(joints)]
    with open(path, "w") as f:
        f.write("t," + ",".join("q%d" % (j + 1) for j in range(joints)) + "\n")
        for row in range(ROWS):
            t = row / RATE
            angle = 2 * math.pi * 0.05 * t
            q = [sum(a * math.sin(k * angle + p) for k, (a, p) in enumerate(wave, 1))
                 for wave in waves]
            f.write("%.3f," % t + ",".join("%.9f" % x for x in q) + "\n")


class Arm:
    """A robot file and recordings of it, made when they are asked for."""

    def __init__(self, tool, folder, joints):
        self.tool, self.folder, self.joints = tool, folder, joints
        self.robot = robot(folder, joints)
        self.made = {}

    def recording(self, seed):
        if seed not in self.made:
            path = os.path.join(self.folder, "chain-%d-%d.csv" % (self.joints, seed))
            trajectory = path + ".motion"
            motion(trajectory, self.joints, seed)
            subprocess.run([self.tool, "simulate", self.robot, "--trajectory", trajectory, "-o",
                            path, "--noise", "low", "--seed", str(seed), "--quiet"], check=True,
                           stdout=subprocess.DEVNULL)
            os.remove(trajectory)
            self.made[seed] = path
        return self.made[seed]

    def long(self, rows):
        """The first recording over and over."""
        if rows <= ROWS:
            return self.recording(1)
        path = os.path.join(self.folder, "chain-%d-long.csv" % self.joints)
        with open(self.recording(1)) as f:
            header = f.readline()
            rest = [line.split(",", 1)[1] for line in f]
        with open(path, "w") as f:
            f.write(header)
            for first in range(0, rows, len(rest)):
                f.write("".join("%.3f,%s" % ((first + k) / RATE, line)
                                for k, line in enumerate(rest[:rows - first])))
        return path

    def forget(self):
        for path in self.made.values():
            os.remove(path)
        self.made = {}


def measured(command):
    """One run: seconds, processor seconds, MB. None where it failed, with the last line it wrote."""
    begin = time.monotonic()
    error = tempfile.TemporaryFile()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=error)
    while True:
        pid, status, usage = os.wait4(process.pid, os.WNOHANG)
        if pid:
            break
        if time.monotonic() - begin > 60 * MINUTES:
            process.kill()
        time.sleep(0.005)
    process.returncode = status
    if status != 0:
        error.seek(0)
        last = error.read().decode(errors="replace").strip().splitlines()
        print("    ended with %d: %s" % (status, last[-1] if last else ""), flush=True)
        return None
    return {"seconds": round(time.monotonic() - begin, 3),
            "processor_seconds": round(usage.ru_utime + usage.ru_stime, 3),
            "megabytes": round(usage.ru_maxrss / 1024.0, 1)}


class Growth:
    def __init__(self, options):
        self.options = options
        self.tools = [("veridyn", options.tool)]
        if options.beside:
            self.tools.append(("beside", options.beside))
        self.results = []

    def run(self, command, axis, value, arguments):
        for name, tool in self.tools:
            # A run that failed or took long is not repeated with more to do.
            before = [r for r in self.results if (r["command"], r["axis"], r["tool"])
                      == (command, axis, name)]
            if any(r.get("seconds") is None for r in before):
                continue
            figures = measured([tool, command] + arguments + ["--quiet", "--threads",
                                                              str(self.options.threads)])
            row = {"command": command, "axis": axis, "value": value, "tool": name}
            row.update(figures or {"seconds": None})
            self.results.append(row)
            if figures:
                print("%-9s %-10s %9d  %-8s %8.2f s  %8.2f s of processor  %8.1f MB"
                      % (command, axis, value, name, figures["seconds"],
                         figures["processor_seconds"], figures["megabytes"]), flush=True)


def of_rows(growth, folder, large):
    arm = Arm(growth.options.tool, folder, 3)
    held_out = arm.recording(2)
    for rows in [10 ** 4, 10 ** 5, 10 ** 6] + ([10 ** 7] if large else []):
        path = arm.long(rows)
        arguments = [arm.robot, "--train", path, "--test", held_out]
        growth.run("identify", "rows", rows, arguments)
        if rows <= 10 ** 6:
            growth.run("diagnose", "rows", rows, arguments)
        if path != arm.recording(1):
            os.remove(path)
    arm.forget()


def of_recordings(growth, folder, large):
    arm = Arm(growth.options.tool, folder, 7)
    held_out = arm.recording(10 ** 6)
    for count in [1, 4, 16, 100] + ([1000] if large else []):
        paths = [arm.recording(k) for k in range(1, count + 1)]
        arguments = [arm.robot, "--train"] + paths + ["--test", held_out]
        growth.run("identify", "recordings", count, arguments)
        if count <= 16:
            growth.run("diagnose", "recordings", count, arguments)
    arm.forget()


def of_joints(growth, folder, _):
    for joints in (3, 7, 14, 30, 60):
        arm = Arm(growth.options.tool, folder, joints)
        arguments = [arm.robot, "--train", arm.recording(1), "--test", arm.recording(2)]
        growth.run("identify", "joints", joints, arguments)
        if joints <= 30:
            growth.run("diagnose", "joints", joints, arguments)
        arm.forget()


def of_bodies(growth, folder, _):
    """The feasible fit alone, from veridyn-benchmark."""
    if not growth.options.benchmark:
        return
    out = os.path.join(folder, "bodies.json")
    subprocess.run([growth.options.benchmark, "--benchmark_filter=^feasible_fit/",
                    "--benchmark_out=" + out, "--benchmark_out_format=json"], check=True,
                   stdout=subprocess.DEVNULL)
    with open(out) as f:
        for run in json.load(f)["benchmarks"]:
            bodies = int(run["name"].split("/")[1].split("_")[0])
            scale = {"ns": 1e-9, "us": 1e-6, "ms": 1e-3, "s": 1.0}[run["time_unit"]]
            growth.results.append({"command": "feasible fit", "axis": "bodies", "value": bodies,
                                   "tool": "veridyn", "seconds": run["real_time"] * scale,
                                   "processor_seconds": run["cpu_time"] * scale})
            print("feasible fit of %3d bodies: %.4g s" % (bodies, run["cpu_time"] * scale),
                  flush=True)


AXES = {"rows": of_rows, "recordings": of_recordings, "joints": of_joints, "bodies": of_bodies}
COLOURS = {"identify": "#1f6fb2", "diagnose": "#d2691e", "feasible fit": "#2e8b57"}


def decades(values):
    return range(math.floor(math.log10(min(values)) + 1e-9),
                 math.ceil(math.log10(max(values)) - 1e-9) + 1)


class Panel:
    """One plot with logarithmic axes."""

    WIDTH, HEIGHT, LEFT, TOP = 250, 170, 48, 30

    def __init__(self, x, y, xs, ys):
        self.x, self.y = x, y
        self.tens_x, self.tens_y = decades(xs), decades(ys)

    def at_x(self, value):
        low, high = self.tens_x[0], max(self.tens_x[-1], self.tens_x[0] + 1)
        return self.x + self.LEFT + (math.log10(value) - low) / (high - low) * (
            self.WIDTH - self.LEFT - 10)

    def at_y(self, value):
        low, high = self.tens_y[0], max(self.tens_y[-1], self.tens_y[0] + 1)
        return self.y + self.HEIGHT - 28 - (math.log10(value) - low) / (high - low) * (
            self.HEIGHT - 28 - self.TOP)

    @staticmethod
    def name(power):
        return "%g" % 10 ** power if -3 < power < 4 else "1e%d" % power

    def grid(self, title):
        out = ['<text x="%g" y="%g" class="title">%s</text>' % (self.x + self.LEFT, self.y + 18,
                                                               title)]
        left, right = self.x + self.LEFT, self.x + self.WIDTH - 10
        bottom = self.y + self.HEIGHT - 28
        for p in self.tens_y:
            y = self.at_y(10.0 ** p)
            out.append('<path class="grid" d="M%.1f %.1fH%.1f"/>' % (left, y, right))
            out.append('<text x="%.1f" y="%.1f" class="end">%s</text>' % (left - 5, y + 4,
                                                                          self.name(p)))
        for p in self.tens_x:
            x = self.at_x(10.0 ** p)
            out.append('<path class="grid" d="M%.1f %.1fV%.1f"/>' % (x, bottom,
                                                                     self.y + self.TOP))
            out.append('<text x="%.1f" y="%.1f" class="middle">%s</text>' % (x, bottom + 15,
                                                                             self.name(p)))
        return out

    def line(self, points, colour, dashed):
        places = ["%.1f %.1f" % (self.at_x(x), self.at_y(y)) for x, y in points]
        out = ['<path d="M%s" fill="none" stroke="%s" stroke-width="1.8"%s/>'
               % ("L".join(places), colour, ' stroke-dasharray="4 3"' if dashed else "")]
        for p in places:
            out.append('<circle cx="%s" cy="%s" r="2.6" fill="%s"/>' % (*p.split(), colour))
        return out


def panel(results, axis, figure, title, x, y):
    rows = [r for r in results if r["axis"] == axis and r.get(figure)]
    if not rows:
        return []
    plot = Panel(x, y, [r["value"] for r in rows], [r[figure] for r in rows])
    out = plot.grid(title)
    for command in COLOURS:
        for tool in ("beside", "veridyn"):
            points = sorted((r["value"], r[figure]) for r in rows
                            if (r["command"], r["tool"]) == (command, tool))
            if points:
                out += plot.line(points, COLOURS[command], tool == "beside")
    return out


def draw(results, path):
    axes = [a for a in AXES if any(r["axis"] == a for r in results)]
    width, height = Panel.WIDTH * len(axes) + 10, 2 * Panel.HEIGHT + 40
    out = ['<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 %d %d" font-family="sans-serif" '
           'font-size="11">' % (width, height),
           "<style>.title{font-weight:bold}.grid{stroke:#ddd}.end{text-anchor:end;fill:#555}"
           ".middle{text-anchor:middle;fill:#555}</style>",
           '<rect width="100%" height="100%" fill="#fff"/>']
    at = Panel.LEFT
    for command, colour in COLOURS.items():
        out.append('<path d="M%d 16h22" stroke="%s" stroke-width="2"/><text x="%d" y="20">%s</text>'
                   % (at, colour, at + 28, command))
        at += 110
    if any(r["tool"] == "beside" for r in results):
        out.append('<path d="M%d 16h22" stroke="#555" stroke-width="2" stroke-dasharray="4 3"/>'
                   '<text x="%d" y="20">an earlier version</text>' % (at, at + 28))
    for k, axis in enumerate(axes):
        out += panel(results, axis, "processor_seconds", "processor s by " + axis, k * Panel.WIDTH, 30)
        out += panel(results, axis, "megabytes", "MB by " + axis, k * Panel.WIDTH,
                     30 + Panel.HEIGHT)
    out.append("</svg>")
    with open(path, "w") as f:
        f.write("\n".join(out) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tool", nargs="?")
    parser.add_argument("--beside")
    parser.add_argument("--benchmark")
    parser.add_argument("--only", default=",".join(AXES))
    parser.add_argument("--large", action="store_true")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--json")
    parser.add_argument("--svg")
    parser.add_argument("--draw")
    parser.add_argument("--folder", help="for recordings (a temporary one)")
    options = parser.parse_args()
    if options.draw:
        with open(options.draw) as f:
            results = json.load(f)["growth"]
    elif options.tool:
        growth = Growth(options)
        with tempfile.TemporaryDirectory(dir=options.folder) as folder:
            for name in options.only.split(","):
                if name not in AXES:
                    sys.exit("growth.py: found %s, expected one of %s" % (name, ", ".join(AXES)))
                AXES[name](growth, folder, options.large)
        results = growth.results
        if options.json:
            with open(options.json, "w") as f:
                json.dump({"growth": results}, f, indent=1)
    else:
        parser.error("a TOOL or --draw RESULT.json is needed")
    if options.svg:
        draw(results, options.svg)


if __name__ == "__main__":
    main()
