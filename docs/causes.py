#!/usr/bin/env python3
"""The pictures of causes.md: what each cause adds to a joint's torque, over the signal that it acts through.

    docs/causes.py TOOL            writes docs/causes/NAME.svg, by `veridyn simulate` of examples/own_robot/true-arm.yaml
    docs/causes.py TOOL --check    compares the files with what it would write; exit status 1 names what differs

Each dot is a row: the torque that the arm with the cause records, minus that of the arm without it at the recorded motion. Blue:
the joint moves forwards, orange: backwards. The arm has no friction but the cause, and moves slowly, so that shapes stand out;
of a cause of several signals one joint moves alone.
"""

import csv
import math
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
ARM = ROOT / "examples/own_robot/true-arm.yaml"
JOINT = {"base_yaw": 1, "shoulder": 2, "elbow": 3, "wrist_roll": 4}
WIDTH, HEIGHT, DOTS = 170, 84, 420
FOLDER = ROOT / "docs/causes"
OFFSET = 0.05  # of the encoder [rad]
# (amplitude [rad], frequency [Hz], phase) of the two sines of each joint; position of one that does not move.
MOTION = [[(1.2, 0.05, 0.3), (0.3, 0.17, 1.0)], [(0.8, 0.07, 0.5), (0.25, 0.19, 0.0)], [(1.0, 0.11, 2.0), (0.35, 0.06, 1.0)], [(1.5, 0.09, 0.0), (0.3, 0.2, 2.0)]]
RESTS = [0.4, 0.5, 0.6, 0.0]
ALONE = {"gravity_tilt": 0, "tip_force": 0, "base_compliance": 1}  # index of the joint that moves
BLUE, ORANGE = "#0072b2", "#d55e00"

FOREARM = "angle of the forearm"
REVERSAL = "travel since a reversal"
# name: (cause as `simulate --effect` reads it, joint whose torque is drawn, signal, its words). A signal is a column, a sum of
# columns, "d" or "dd" and a column for its derivatives, or "travel".
CAUSES = {
    "rotor_inertia": ("rotor_inertia:elbow", "elbow", "ddq3", "acceleration"),
    "joint_spring": ("joint_spring:elbow:stiffness=2", "elbow", "q3", "position"),
    "viscous_friction": ("viscous_friction:elbow:coefficient=1", "elbow", "dq3", "velocity"),
    "coulomb_friction": ("coulomb_friction:elbow:level=1", "elbow", "dq3", "velocity"),
    "torque_offset": ("torque_offset:elbow:offset=1", "elbow", "q3", "position"),
    "stribeck_friction": ("stribeck_friction:elbow:level=1,velocity=0.2", "elbow", "dq3", "velocity"),
    "presliding_hysteresis": ("presliding_hysteresis:elbow:level=1,distance=0.1", "elbow", "travel", REVERSAL),
    "asymmetric_friction": ("asymmetric_friction:elbow:level_difference=1,viscous_difference=0.5", "elbow", "dq3", "velocity"),
    "position_dependent_friction": ("position_dependent_friction:elbow", "elbow", "q3", "position"),
    "position_dependent_viscosity": ("position_dependent_viscosity:elbow", "elbow", "q3", "position"),
    "load_dependent_friction": ("load_dependent_friction:elbow", "elbow", "tau3", "torque"),
    "quadratic_drag": ("quadratic_drag:elbow", "elbow", "dq3", "velocity"),
    "sublinear_viscous": ("sublinear_viscous:elbow", "elbow", "dq3", "velocity"),
    "torque_ripple": ("torque_ripple:elbow:order=8", "elbow", "q3", "position"),
    "cable_coupling": ("cable_coupling:elbow:from=shoulder,stiffness=1,drag=0.2", "elbow", "q2", "position of the other joint"),
    "position_force": ("position_force:elbow", "elbow", "q3", "position"),
    "backlash": ("backlash:elbow:level=1,gap=0.2", "elbow", "travel", REVERSAL),
    "transmission_compliance": ("transmission_compliance:elbow", "elbow", "dd tau3", "second derivative of the torque"),
    "end_stop": ("end_stop:elbow", "elbow", "q3", "position"),
    "warm_up": ("warm_up:elbow:level=1,viscosity=0.3,time_constant=8", "elbow", "t", "time"),
    "torque_gain": ("torque_gain:elbow:gain=1.15", "elbow", "tau3", "torque"),
    "torque_drift": ("torque_drift:elbow", "elbow", "t", "time"),
    "time_delay": ("time_delay:elbow:seconds=0.02", "elbow", "d tau3", "derivative of the torque"),
    "encoder_offset": (f"encoder_offset:elbow:offset={OFFSET}", "elbow", "q2+q3", FOREARM),
    "torque_crosstalk": ("torque_crosstalk:elbow:from=shoulder,share=0.1", "elbow", "tau2", "torque of the other joint"),
    "coupling_error": ("coupling_error:forearm.x:change=0.02", "shoulder", "q2", "position"),
    "payload": ("payload:tool0:mass=0.5", "elbow", "q2+q3", FOREARM),
    "gravity_tilt": ("gravity_tilt:arm:roll=0.05,pitch=0", "elbow", "q1", "position of the first joint"),
    "base_compliance": ("base_compliance:arm:about_x=0,about_y=0.002", "shoulder", "q2", "position"),
    "tip_force": ("tip_force:arm:x=2,y=0,z=0", "elbow", "q1", "position of the first joint"),
    "external_contact": ("external_contact:elbow:from=10,to=13,effort=2", "elbow", "t", "time"),
}


def write_motion(file, alone):
    """34 s of MOTION at 100 Hz, of all joints or of one, with velocities and accelerations."""
    still = [[(rest, 0.0, math.pi / 2)] for rest in RESTS]
    motion = [sines if alone in (None, j) else still[j] for j, sines in enumerate(MOTION)]
    rows = ["t," + ",".join(f"{kind}{j + 1}" for kind in ("q", "dq", "ddq") for j in range(len(MOTION)))]
    for k in range(3401):
        t, row = k / 100, [f"{k / 100}"]
        for order in range(3):
            for sines in motion:
                row.append(f"{sum(a * (2 * math.pi * f) ** order * math.sin(2 * math.pi * f * t + p + order * math.pi / 2) for a, f, p in sines):.15g}")
        rows.append(",".join(row))
    file.write_text("\n".join(rows) + "\n", encoding="utf-8")


def columns(path):
    with open(path, encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    return {name: [float(row[name]) for row in rows] for name in rows[0]}


def recorded(tool, folder, motion, *effect):
    """Columns of a recording without noise, by name."""
    subprocess.run([tool, "simulate", folder / "arm.yaml", "--trajectory", motion, "-o", folder / "rec.csv", "--noise", "none", "--quiet",
                    *[word for one in effect for word in ("--effect", one)]], check=True, stdout=subprocess.DEVNULL)
    return columns(folder / "rec.csv")


def shifted(motion):
    """The motion that an elbow's encoder with OFFSET shows."""
    rows, out = columns(motion), motion.with_name("shifted.csv")
    rows["q3"] = [q + OFFSET for q in rows["q3"]]
    with open(out, "w", encoding="utf-8") as file:
        file.write("\n".join(",".join(map(str, row)) for row in [list(rows), *zip(*rows.values())]) + "\n")
    return out


def travel(q):
    """Travel since the last reversal."""
    out, turn, forwards = [0.0], q[0], True
    for before, now in zip(q, q[1:]):
        if now != before and (now > before) != forwards:
            turn, forwards = before, now > before
        out.append(abs(now - turn))
    return out


def derivative(values, times, half=5):
    """Differences over 0.1 s, as values are rounded."""
    inner = [(values[k + half] - values[k - half]) / (times[k + half] - times[k - half]) for k in range(half, len(values) - half)]
    return [inner[0]] * half + inner + [inner[-1]] * half


def signal_of(rows, name):
    if name == "travel":
        return travel(rows["q3"])
    if "+" in name:
        return [sum(values) for values in zip(*(rows[one] for one in name.split("+")))]
    *order, column = name.split()
    values = rows[column]
    for _ in "".join(order):
        values = derivative(values, rows["t"])
    return values


def span(values):
    ordered = sorted(values)
    cut = len(ordered) // 100  # a jump of a derivative must not flatten the picture
    low, high = ordered[cut], ordered[-1 - cut]
    return (low, high) if high > low else (low - 1.0, high + 1.0)


def picture(name, x, y, forwards, words):
    """The text of a picture."""
    (left, right), (low, high) = span(x), span(y)
    if words == REVERSAL:
        right = 0.6
    low, high = min(low, 0.0), max(high, 0.0)
    margin = 0.06 * (high - low)
    low, high = low - margin, high + margin

    def place(k):
        return (f"{6 + (x[k] - left) / (right - left) * (WIDTH - 12):.0f}", f"{2 + (high - y[k]) / (high - low) * (HEIGHT - 18):.0f}")

    dots = {BLUE: [], ORANGE: []}
    step = max(1, len(x) // DOTS)
    for k in range(len(x) // 50, len(x) - len(x) // 50, step):
        if left <= x[k] <= right and low <= y[k] <= high:
            dots[BLUE if forwards[k] else ORANGE].append("M{} {}h0".format(*place(k)))
    zero = f"{2 + high / (high - low) * (HEIGHT - 18):.0f}"
    lines = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{HEIGHT}" viewBox="0 0 {WIDTH} {HEIGHT}" role="img">',
             f"<title>{name.replace('_', ' ')}: torque over {words}</title>",
             f'<rect width="{WIDTH}" height="{HEIGHT}" fill="#fff"/><path d="M6 {zero}h{WIDTH - 12}" stroke="#999" stroke-width=".7"/>']
    for colour, marks in dots.items():
        if marks:
            lines.append(f'<path d="{"".join(sorted(set(marks)))}" stroke="{colour}" stroke-width="2" stroke-linecap="round" fill="none"/>')
    lines.append(f'<text x="{WIDTH / 2:.0f}" y="{HEIGHT - 3}" font-family="sans-serif" font-size="9" text-anchor="middle" fill="#333">{words}</text></svg>')
    return "\n".join(lines) + "\n"


def same(a, b):
    """True for equal words, and dots of which 95 % have one of the other picture's within a pixel, as on another machine."""
    def parts(text):
        colours = re.findall('d="([^"]*)" stroke="(#[0-9a-f]+)" stroke-width="2"', text)
        return re.findall(">([^<]+)<", text), {c: {tuple(map(int, m)) for m in re.findall(r"M(\d+) (\d+)", d)} for d, c in colours}

    def near(dots, others):
        return sum(any((x + i, y + j) in others for i in (-1, 0, 1) for j in (-1, 0, 1)) for x, y in dots) >= 0.95 * len(dots)

    (words, dots), (other_words, other_dots) = parts(a), parts(b)
    return words == other_words and dots.keys() == other_dots.keys() and all(
        near(dots[c], other_dots[c]) and near(other_dots[c], dots[c]) for c in dots)


def main():
    tool, check, differ = sys.argv[1], "--check" in sys.argv, []
    FOLDER.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        rigid = ARM.read_text(encoding="utf-8").split("effects:")[0]
        (folder / "arm.yaml").write_text(rigid, encoding="utf-8")
        motions, clean = {}, {}
        for alone in {None, *ALONE.values()}:
            motions[alone] = folder / f"motion-{alone}.csv"
            write_motion(motions[alone], alone)
            clean[alone] = recorded(tool, folder, motions[alone])
            clean[alone]["ddq3"] = derivative(clean[alone]["dq3"], clean[alone]["t"])
        for name, (cause, joint, signal, words) in CAUSES.items():
            alone, tau = ALONE.get(name), f"tau{JOINT[joint]}"
            motion, without = motions[alone], clean[alone]
            speed = without[f"dq{JOINT[joint] if alone is None else alone + 1}"]
            model = recorded(tool, folder, shifted(motion)) if name == "encoder_offset" else without
            added = [a - b for a, b in zip(recorded(tool, folder, motion, cause)[tau], model[tau])]
            text, file = picture(name, signal_of(without, signal), added, [v > 0 for v in speed], words), FOLDER / f"{name}.svg"
            if not check:
                file.write_text(text, encoding="utf-8")
            elif not file.exists() or not same(file.read_text(encoding="utf-8"), text):
                differ.append(name)
    if differ:
        sys.exit(f"docs/causes: {', '.join(differ)}: no longer what the tool draws; `make causes` draws them anew")


main()
