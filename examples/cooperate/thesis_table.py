#!/usr/bin/env python3
"""The experiments of thesis chapters 6 and 7 beside their simulation, in one table:

    python3 examples/cooperate/thesis_table.py [build/bin/veridyn]

Columns: what the thesis reports, on hardware or simulated; its own law and gains on this project's simulated arms; this
project's. Simulation is not hardware: figures stand side by side, and none replaces another.
"""
import json
import pathlib
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
NONE = "-"
TOLD = 0.1  # N; a contact that switches moves smaller errors from one processor's rounding to another's


class Runs:
    def __init__(self, tool):
        self.tool, self.done = tool, {}

    def __call__(self, name):
        if name not in self.done:
            with tempfile.TemporaryDirectory() as folder:
                out = pathlib.Path(folder) / "out.json"
                told = subprocess.run([self.tool, "cooperate", str(HERE / f"{name}.yaml"), "--json", str(out), "--quiet"],
                                      capture_output=True, text=True, check=False)
                if not out.exists():
                    sys.exit(f"{name}: {told.stderr.strip()}")
                self.done[name] = json.loads(out.read_text())
        return self.done[name]

    def phase(self, name, phase):
        found = [p for p in self(name)["phases"] if p["phase"] == phase]
        return found[0] if found else None

    def force(self, name, phase):
        one = self.phase(name, phase)
        if one is None:
            return f"held: {self(name)['reason']}"
        error = one["members"][0]["largest_error"]
        shown = f"{error:.2f} N" if error >= TOLD else f"< {TOLD} N"
        return shown + (" (held)" if self(name).get("held_at") else "")

    def swing(self, name, phase):
        return f"swings by {self.phase(name, phase)['members'][0]['oscillation']:.2f} N"

    def place(self, name, phases):
        return ", ".join(f"{1e3 * self.phase(name, p)['final_position_error']:.2f}" for p in phases) + " mm"


def rows(run):
    return [
        ("7.6.2  impedance, 5 mm in x, y, z: error at rest", "1, 0, 2 mm", NONE, NONE,
         run.place("one-arm-moves", ["x", "y", "z"])),
        ("6.4    two arms, 5 N, 10 mm: force while moving", NONE, "follows (fig. 6.8)", NONE, run.force("gazebo-y", "move")),
        ("7.7.3  increments, deadband 0.2 N", "limit cycle", NONE, run.swing("position-limit-cycle", "move"), NONE),
        ("7.7.3  increments, deadband 0.4 N", "stable", NONE, run.swing("position-stable", "move"), NONE),
        ("7.7.4  spring, 5 N: force while it rises", "1 to 2 N", NONE, run.force("thesis-spring", "tension"),
         run.force("two-arms-spring", "tension")),
        ("7.7.4  spring: force while it moves", "0.5 N", NONE, run.force("thesis-spring", "move"),
         run.force("two-arms-spring", "move")),
        ("7.7.4  string, 5 N: force while it rises", "1 to 2 N", NONE, run.force("thesis-string", "tension"),
         run.force("two-arms-string", "tension")),
        ("7.7.4  string: force while it moves", "0.5 N", NONE, run.force("thesis-string", "move"),
         run.force("two-arms-string", "move")),
        ("       spring, bases 2 mm and 10 mrad off: moving", "not told", NONE, NONE, run.force("calibration-error", "move")),
        ("       spring, links up to 3 mm off as well: moving", "not told", NONE, NONE, run.force("wrong-geometry", "move")),
    ]


def main():
    run = Runs(sys.argv[1] if len(sys.argv) > 1 else "build/bin/veridyn")
    head = ("experiment", "thesis, hardware", "thesis, simulated", "its law, simulated here", "ours, simulated")
    table = [head, *rows(run)]
    widths = [max(len(row[k]) for row in table) for k in range(len(head))]
    for row in table:
        print("  ".join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip())


if __name__ == "__main__":
    main()
