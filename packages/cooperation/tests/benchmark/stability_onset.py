#!/usr/bin/env python3
"""Where does a cooperation loop begin to swing: by its eigenvalues, and in the nonlinear simulation?

Draws scenarios at random (arms, pose, object, sensor, loop, gains), asks `veridyn stability` for the stiffness of the
object at which the linear loop loses its stability, and runs `veridyn cooperate` a tenth below it, where a swing must die
away, and a tenth above it, where it must grow. Arms have no dry friction and sensors no noise, so that a swing of any size grows or dies away:

    python3 tests/benchmark/stability_onset.py build/bin/veridyn 200 [FIRST_SEED]

One line for each scenario; status 1 if any is off by more than a tenth.
"""
import json
import pathlib
import random
import re
import subprocess
import sys
import tempfile

SOURCE = pathlib.Path(__file__).resolve().parents[2]
TOLERANCE = 0.10


def arm_text(rng, name):
    """The light PSM with other masses and viscous friction, and without dry friction."""
    text = (SOURCE / "examples/dvrk/light-psm.yaml").read_text()
    text = re.sub(r"name: light-psm", "name: " + name, text)
    text = "\n".join(line for line in text.splitlines() if "coulomb_friction" not in line) + "\n"
    text = re.sub(r"mass: ([0-9.]+)", lambda m: f"mass: {float(m[1]) * rng.uniform(0.5, 2):.4f}", text)
    return re.sub(r"coefficient: ([0-9.]+)", lambda m: f"coefficient: {float(m[1]) * rng.uniform(0.5, 2):.4f}", text)


def draw(rng, folder):
    for arm in ("one", "two"):
        (folder / f"{arm}.yaml").write_text(arm_text(rng, arm))
    start = f"[{rng.uniform(-0.3, 0.3):.3f}, {rng.uniform(-0.5, 0.1):.3f}, {rng.uniform(0.08, 0.18):.3f}]"
    rate = rng.choice([500, 1000, 1500])
    sensor = rate / rng.choice([1, 2, 3])
    delay = rng.choice([0, 1, 2, 3, 4]) / rate
    damping, mass, stiffness = rng.uniform(15, 60), rng.uniform(0.2, 1.0), rng.uniform(150, 800)
    gain = 10 ** rng.uniform(-1.5, -0.3)
    law = rng.choice(["{kind: tuned}",
                      f"{{kind: proportional, gain: {gain:.4f}, damping: {rng.uniform(0.0, 0.3):.3f}, "
                      f"feed_forward: {1 / stiffness:.5f}}}"])
    lag = rng.choice([0, 0, 0.001, 0.002])
    cutoff = rng.choice([0, 0, 50, 100])
    control = rng.choice(["position", "impedance"])
    phases = "".join(f"  - {{name: rest {k}, duration: 0.2, over: 0.2, force: 1}}\n" for k in range(1, 5))
    return f"""veridyn: 1
scenario: onset
encoder: none
arms:
  - {{name: master, model: one.yaml, frame: tool, start: {start}, control: {control}}}
  - {{name: slave, model: two.yaml, position: [1.15, 0, 0], turn: [0, 0, pi], frame: tool, start: {start}, control: impedance}}
members:
  - name: spring
    kind: spring
    between: [master, slave]
    stiffness: 1000
    damping: {rng.uniform(0.5, 5):.2f}
    sensor: {{rate: {sensor:.6f}, delay: {delay:.9f}}}
    law: {law}
control: {{rate: {rate}, friction: 0, mass: [{mass:.3f}, {mass:.3f}, {mass:.3f}], damping: [{damping:.2f}, {damping:.2f}, {damping:.2f}], stiffness: [{stiffness:.1f}, {stiffness:.1f}, {stiffness:.1f}], position_frequency: {rng.uniform(6, 15):.2f}, observer: {rng.choice([0, 3, 5])}, velocity_cutoff: {rng.choice([100, 200, 400])}, motor_lag: {lag}, force_cutoff: {cutoff}, largest_force: 1e6, largest_force_error: 1e6, largest_error: 10}}
phases:
  - {{name: tension, duration: 0.6, over: 0.4, force: 1}}
{phases}"""


def run(tool, arguments, folder):
    out = folder / "out.json"
    out.unlink(missing_ok=True)
    subprocess.run([tool, *arguments, "--json", str(out), "--quiet"], capture_output=True, text=True, check=False)
    return json.loads(out.read_text()) if out.exists() else None


def swings(tool, text, stiffness, rest, folder):
    """The swing of the force in the last fifth of each of four equal times of rest; None: the run did not go on."""
    path = folder / "at.yaml"
    text = text.replace("duration: 0.2, over: 0.2", f"duration: {rest}, over: {rest}")
    path.write_text(text.replace("    stiffness: 1000\n", f"    stiffness: {stiffness:.6g}\n"))
    result = run(tool, ["cooperate", str(path)], folder)
    if result is None or result["status"] != "done" or len(result["phases"]) < 5:
        return None
    return [phase["members"][0]["oscillation"] for phase in result["phases"]][1:]


def grows(tool, text, stiffness, expected, folder):
    """Does a swing at rest grow, or go on? A short look, and a long one where that does not show what is expected."""
    for rest in (0.2, 1.2):
        found = swings(tool, text, stiffness, rest, folder)
        answer = found is None or (found[3] > 1e-8 and found[3] > 0.5 * found[1])
        if answer == expected:
            break
    return answer


def main():
    tool, wanted = str(pathlib.Path(sys.argv[1]).resolve()), int(sys.argv[2])
    seed = int(sys.argv[3]) if len(sys.argv) > 3 else 1
    agreed = early = late = skipped = 0
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        while agreed + early + late < wanted:
            rng = random.Random(seed)
            text = draw(rng, folder)
            (folder / "drawn.yaml").write_text(text)
            analysis = run(tool, ["stability", str(folder / "drawn.yaml")], folder)
            linear = analysis and analysis["linear_stable_stiffness"]
            if not analysis or not analysis["stiffness_bounded"] or not linear or linear > 2e6:
                skipped += 1  # stable up to the end of the search, or nowhere
            elif grows(tool, text, (1 - TOLERANCE) * linear, False, folder):
                early += 1
                print(f"{seed}: linear {linear:.6g} N/m, but the simulation swings at {1 - TOLERANCE:.0%} of it", flush=True)
            elif not grows(tool, text, (1 + TOLERANCE) * linear, True, folder):
                late += 1
                print(f"{seed}: linear {linear:.6g} N/m, but the simulation rests at {1 + TOLERANCE:.0%} of it", flush=True)
            else:
                agreed += 1
                print(f"{seed}: linear {linear:.6g} N/m: agreed", flush=True)
            seed += 1
    print(f"{wanted} scenarios ({skipped} more have no onset): {agreed} agree within {TOLERANCE:.0%}, {early} swing "
          f"earlier in the simulation, {late} later")
    return 0 if agreed == wanted else 1


if __name__ == "__main__":
    sys.exit(main())
