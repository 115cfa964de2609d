"""Mutants of the safety supervisor: one program that holds all of them, and a run that each must fail.

    supervisor_mutants.py make SOURCE OUT    writes SOURCE with every mutant behind a number
    supervisor_mutants.py run PROGRAM        0: the tests pass; 1, 2, ...: each must make one fail

A mutant is a piece of the source and what stands in its place: a test dropped, a sign changed, a
bound doubled. VERIDYN_MUTANT chooses one when the program runs, so that all are compiled once.
"""
import concurrent.futures
import os
import subprocess
import sys

# (piece of the source, which occurs once; what takes its place)
MUTANTS = [
    ("input.sensor_age > limits_.sensor_age", "input.sensor_age > 2.0 * limits_.sensor_age"),
    ("std::abs(arm.q()[i] - q_sound_[i]) > farthest", "false"),
    ("input.dt > limits_.overrun", "input.dt > 4.0 * limits_.overrun"),
    ("leaves_range(arm.q()[i], arm.dq()[i], range, limits_.braking)", "leaves_range(arm.q()[i], 0.0, range, limits_.braking)"),
    ("std::abs(arm.dq()[i]) > share * limits_.velocity[i]", "std::abs(arm.dq()[i]) > 2.0 * share * limits_.velocity[i]"),
    ("state_ == SafetyState::kHoming ? limits_.homing_share : 1.0", "1.0"),
    ("std::abs(input.q_wanted[i] - arm.q()[i]) > limits_.tracking[i]", "std::abs(input.q_wanted[i] - arm.q()[i]) > 2.0 * limits_.tracking[i]"),
    ("const bool too_much = share > 1.0 || (stands && share >= kNearLimit)", "const bool too_much = share > 2.0"),
    ("if (saturated_[i] > limits_.torque_seconds) return {SafetyFault::kTorque", "if (saturated_[i] > 2.0 * limits_.torque_seconds) return {SafetyFault::kTorque"),
    ("!(input.force_age <= limits_.force_age)", "!(input.force_age <= 4.0 * limits_.force_age)"),
    ("input.force.norm() > limits_.force)", "input.force.norm() > 2.0 * limits_.force)"),
    ("(input.force - input.force_expected).norm() > limits_.force_disagreement", "(input.force - input.force_expected).norm() > 2.0 * limits_.force_disagreement"),
    ("disagreed_ > limits_.disagreement_seconds", "disagreed_ > 2.0 * limits_.disagreement_seconds"),
    ("std::abs(arm.dq()[i]) > limits_.runaway * limits_.velocity[i]", "false"),
    ("!brakes && !input.held", "!brakes"),
    ("energy <= 0.5 * energy_", "energy <= 2.0 * energy_"),
    ("!(slow_for_ > limits_.held_seconds)", "!(slow_for_ > 2.0 * limits_.held_seconds)"),
    ("found.fault == SafetyFault::kNone && moves) found = check_motors", "false) found = check_motors"),
    ("found.fault == SafetyFault::kNone) found = check_held", "false) found = check_held"),
    ("found.fault == SafetyFault::kNone) found = check_force", "false) found = check_force"),
    ("std::min(0.0, load_[i]) - u[i]", "std::min(0.0, load_[i]) - 2.0 * u[i] - 1.0"),
    ("std::max(0.0, load_[i]) + u[i]", "std::max(0.0, load_[i]) + 2.0 * u[i] + 1.0"),
    ("extra_[i] = std::clamp(extra_[i], least, most)", "extra_[i] = extra_[i]"),
    ("kHoldStiffness * (q_hold_ - arm.q()) - limits_.braking * arm.dq()", "kHoldStiffness * (q_hold_ - arm.q()) + limits_.braking * arm.dq()"),
    ("out_ = arm.bias() + extra_", "out_ = arm.bias() - extra_"),
    ("y_ = -limits_.braking * arm.dq();\n      out_ = arm.bias()", "y_ = limits_.braking * arm.dq();\n      out_ = arm.bias()"),
    ("std::clamp(out_[i], -limits_.torque[i], limits_.torque[i])", "std::clamp(out_[i], -2.0 * limits_.torque[i], 2.0 * limits_.torque[i])"),
    ("strength(found.fault) > strength(fault_)", "fault_ == SafetyFault::kNone && strength(found.fault) > 0"),
    ("fault_ == SafetyFault::kNone || found.fault != SafetyFault::kForceSensor", "true"),
    ("found.fault != SafetyFault::kNone) record_finding(found)", "false) record_finding(found)"),
    ("if (worse) keep_holding_torque()", "if (false) keep_holding_torque()"),
    ("since_sound_ > kNewer * input.dt || !seen_", "true"),
    ("input.dt + age_ - input.sensor_age", "(input.sensor_age < input.dt ? input.dt : 0.0)"),
    ("seen_ ? action_of(fault_) : SafetyAction::kMotorsOff", "action_of(fault_)"),
    ("kBlindBraking * limits_.braking", "-kBlindBraking * limits_.braking"),
    ("if (state_ == SafetyState::kFault) return;  // torques", "if (false) return;  // torques"),
    ("    case SafetyFault::kNotHeld:\n      return SafetyAction::kMotorsOff;", "    case SafetyFault::kNotHeld:\n      return SafetyAction::kHold;"),
]


def make(source, out):
    text = open(source).read()
    head = "#include <cstdlib>\n"
    names = ("namespace { int mutant() { static const int k = std::atoi(std::getenv(\"VERIDYN_MUTANT\") ? "
             "std::getenv(\"VERIDYN_MUTANT\") : \"0\"); return k; } }\n")
    for number, (old, new) in enumerate(MUTANTS, 1):
        if text.count(old) != 1:
            sys.exit(f"supervisor_mutants.py: found {text.count(old)} times, expected once: {old!r}")
        text = text.replace(old, f"@{number}@")
    for number, (old, new) in enumerate(MUTANTS, 1):
        text = text.replace(f"@{number}@", FORMS[number - 1].format(k=number, old=old, new=new)
                            if FORMS[number - 1] else f"(mutant() == {number} ? ({new}) : ({old}))")
    open(out, "w").write(head + text.replace("namespace veridyn {\n", "namespace veridyn {\n" + names, 1))


# Pieces that are no expressions say how they are chosen.
def form(old, new):
    if old.startswith("const bool too_much = "):
        o, n = old[len("const bool too_much = "):], new[len("const bool too_much = "):]
        return f"const bool too_much = mutant() == {{k}} ? {n} : {o}"
    if old.startswith("    case"):
        return old.replace("return SafetyAction::kMotorsOff", "return mutant() == {k} ? SafetyAction::kHold : SafetyAction::kMotorsOff")
    if "y_ = -limits_" in old:
        return old.replace("y_ = -limits_", "y_ = (mutant() == {k} ? 1.0 : -1.0) * limits_")
    if old.startswith("out_ = arm.bias() + extra_"):
        return "out_ = arm.bias() + (mutant() == {k} ? -1.0 : 1.0) * extra_"
    if old.startswith("kHoldStiffness"):
        return "kHoldStiffness * (q_hold_ - arm.q()) - (mutant() == {k} ? -1.0 : 1.0) * limits_.braking * arm.dq()"
    if old.startswith("extra_[i] = std::clamp"):
        return "extra_[i] = mutant() == {k} ? extra_[i] : std::clamp(extra_[i], least, most)"
    if old.startswith("if (worse) keep"):
        return "if (worse && mutant() != {k}) keep_holding_torque()"
    if old.startswith("if (state_ == SafetyState::kFault) return;"):
        return "if (state_ == SafetyState::kFault && mutant() != {k}) return;  // what"
    if old.startswith("if (saturated_[i] > limits_.torque_seconds) return"):
        return "if (saturated_[i] > (mutant() == {k} ? 2.0 : 1.0) * limits_.torque_seconds) return {{SafetyFault::kTorque"
    if old.endswith(") record_finding(found)") or ") found = " in old:
        condition, rest = old.split(")", 1)
        return f"mutant() != {{k}} && {condition}){rest}"
    if old.startswith("input.force.norm() > limits_.force)"):
        return "input.force.norm() > (mutant() == {k} ? 2.0 : 1.0) * limits_.force)"
    return None


FORMS = [form(old, new) for old, new in MUTANTS]


def run(program):
    def fails(number):
        done = subprocess.run([program, "--gtest_brief=1", "--gtest_fail_fast"], capture_output=True,
                              env=dict(os.environ, VERIDYN_MUTANT=str(number)), timeout=300)
        return done.returncode != 0
    if fails(0):
        sys.exit("supervisor_mutants.py: the tests fail without a mutant.")
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        caught = list(pool.map(fails, range(1, len(MUTANTS) + 1)))
    alive = [f"{k}: {old!r} -> {new!r}" for k, ((old, new), dead) in enumerate(zip(MUTANTS, caught), 1) if not dead]
    print(f"{len(caught)} mutants, {sum(caught)} caught")
    if alive:
        sys.exit("not caught:\n" + "\n".join(alive))


if __name__ == "__main__":
    make(*sys.argv[2:4]) if sys.argv[1] == "make" else run(sys.argv[2])
