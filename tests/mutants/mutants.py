"""Mutants of sources: small breaks, each of which the tests of its folder must notice.

    mutants.py BUILD [WORD...]    those whose file or test has one of the words; all without words

A mutant is a file, a piece of it that occurs once, what takes its place, and the test programs one of
which has to fail. MUTANTS are chosen by hand; GENERATED says how many operators of a file are turned
into others, evenly over its lines. The tree and BUILD stay as they are: the changed file is compiled
into BUILD/mutants and linked in front of the library; what survives is compiled once more with the
other files of its unit, where the compiler may have inlined it. The status is the number of survivors.
MUTANTS_LAUNCHER is put in front of compilers.
"""
import json
import os
import re
import shlex
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
LONGEST = 300  # [s] of a test program; a mutant that does not end is caught

MUTANTS = [
    ("dvrk/protocol/crc.cpp", "return ~crc;", "return crc;", ["dvrk_io"]),
    ("dvrk/protocol/crc.cpp", "for (; k < bytes.size; ++k) crc", "for (; k + 1 < bytes.size; ++k) crc", ["dvrk_io"]),
    ("dvrk/protocol/feedback.cpp", "if (firmware >= 7) {\n      channel", "if (firmware >= 8) {\n      channel", ["dvrk_io"]),
    ("dvrk/protocol/feedback.cpp", "if (firmware >= 8) channel.motor", "if (firmware >= 7) channel.motor", ["dvrk_io"]),
    ("dvrk/protocol/feedback.cpp", "static_cast<std::uint16_t>(analog >> 16)", "static_cast<std::uint16_t>(analog >> 15)", ["dvrk_io"]),
    ("dvrk/protocol/hub_block.cpp", "header.sequence == (sequence & 0xFF) && !header.mismatch", "header.sequence == (sequence & 0xFF)", ["dvrk_io"]),
    ("dvrk/protocol/hub_block.cpp", "h.mismatch = (word & 0x8000U) != 0;", "h.mismatch = false;", ["dvrk_io"]),
    ("dvrk/protocol/hub_block.cpp", "word & (firmware >= 9 ? kTime15 : kTime14)", "word & kTime14", ["dvrk_io"]),
    ("watch/noise.cpp", "a[0] = std::clamp(a[0], -kLargestPole * (1.0 - a[1]), kLargestPole * (1.0 - a[1]));", "", ["watch"]),
    ("watch/noise.cpp", "a[1] = std::clamp(a[1], -kLargestPole, kLargestPole);", "", ["watch"]),
    ("watch/noise.cpp", "round < kRounds", "round < 0", ["watch"]),
    ("watch/noise.cpp", "kUnlearned * novelty(step, j) > deviation_[j]", "false", ["watch"]),
    ("watch/noise.cpp", "steps[k]->rest_friction2[j] <= 0.0", "true", ["watch"]),
    ("watch/noise.cpp", "!steps[k]->follows || !steps[k - 1]->follows || ", "", ["watch"]),
    ("watch/evidence.cpp", "const double fitted = std::pow(1.0 + 1.0 / windows, 2);", "const double fitted = 1.0;", ["watch"]),
    ("watch/evidence.cpp", "if (windows < 1.0) continue;", "", ["watch"]),
    ("watch/evidence.cpp", "A > kNothing ? std::clamp(b / A, least, largest) : 0.0", "A > kNothing ? b / A : 0.0", ["watch"]),
    ("watch/evidence.cpp", "if (step->time > latest || gain", "if (gain", ["watch"]),
    ("watch/change.cpp", "above_ < kAboveInARow", "above_ < 1", ["watch"]),
    ("watch/change.cpp", "refractory_until_ = step.time + kRefractoryTime;", "refractory_until_ = step.time;", ["watch"]),
    ("watch/change.cpp", "open_->alarm, kPushEnds, price", "open_->alarm, 80.0, price", ["watch"]),
    ("watch/change.cpp", "open_->likely >= kLikelyInARow", "open_->likely >= 1", ["watch"]),
    ("watch/change.cpp", "< kReversalShare * std::abs", "< 0.0 * std::abs", ["watch"]),
    ("recordings/kept_recordings.cpp", "wanted < 0 || wanted > bytes_left_", "wanted < 0", ["recordings", "diagnosis"]),
    ("recordings/kept_recordings.cpp", "bytes_left_ -= wanted;", "", ["recordings", "diagnosis"]),
    ("recordings/files/whole_file.cpp", "size_ <= kLargestRead", "false", ["recordings"]),
    ("identification/shortfall.cpp", "travel = std::max(travel, r.joints[i].travel())", "travel = r.joints[i].travel()", ["identification"]),
    ("identification/many/factor_set.cpp", "require(version == kVersion", "require(true", ["identification"]),
    ("identification/many/factor_set.cpp", "require(a.settings == b.settings", "require(true", ["identification"]),
    ("diagnosis/stages/selection_stage.cpp", "constexpr int kCycles = 2;", "constexpr int kCycles = 1;", ["diagnosis"]),
    ("diagnosis/evidence/payload_fit.cpp", "out.A.diagonal().segment(1, 3).array() += unseen_curvature(out);", "", ["diagnosis"]),
    ("diagnosis/causes/geometry.cpp", "std::max(out.deviation, wider * of_recordings)", "out.deviation", ["diagnosis"]),
    ("diagnosis/causes/geometry.cpp", "if (recordings < 3) return;", "if (recordings < 1000) return;", ["diagnosis"]),
]

# Mutants of each file, and the test program that has to notice them.
GENERATED = {
    "watch": {"watch/noise.cpp": 4, "watch/evidence.cpp": 5, "watch/smoothed_rows.cpp": 4, "watch/hypotheses.cpp": 3,
              "watch/step_builder.cpp": 2, "watch/change.cpp": 4},
    "identification": {"identification/feasible/pseudo_inertia.cpp": 3, "identification/velocity_choice.cpp": 4,
                       "identification/period_fold.cpp": 2, "identification/base_solution.cpp": 4,
                       "identification/rest_poses.cpp": 4, "identification/instrumental.cpp": 3,
                       "identification/drive_gains/gain_problem.cpp": 3, "identification/results/verdict.cpp": 3},
    "diagnosis": {"diagnosis/evidence/bordered_fit.cpp": 3, "diagnosis/evidence/clustered_fit.cpp": 2,
                  "diagnosis/evidence/folds.cpp": 2,
                  "diagnosis/evidence/point_load.cpp": 3, "diagnosis/causes/snags.cpp": 3, "diagnosis/causes/contacts.cpp": 3,
                  "diagnosis/unnamed/dependence.cpp": 3},
    "control": {"control/adaptive_friction.cpp": 3, "control/computed_torque.cpp": 2, "control/cooperative/force_law.cpp": 2, "control/momentum_observer.cpp": 3, "control/velocity_observer.cpp": 2,
                "control/quintic_interpolator.cpp": 3, "control/impedance.cpp": 2, "control/model_error_observer.cpp": 3,
                "control/cooperative/tether_guard.cpp": 3},
    "dvrk": {"dvrk/arms/psm_kinematics.cpp": 3, "dvrk/arms/mtm_kinematics.cpp": 3, "dvrk/arms/arm_units.cpp": 3,
             "dvrk/protocol/encoder_words.cpp": 3, "dvrk/arms/gravity_chain.cpp": 3, "dvrk/config/io_config_check.cpp": 3,
             "dvrk/arms/joint_ranges.cpp": 2},
    "cooperation": {"cooperation/motion_plan.cpp": 3, "cooperation/loop_gains.cpp": 2, "cooperation/held_object.cpp": 3,
                    "cooperation/phase_figures.cpp": 2, "cooperation/stability/small_gain.cpp": 2},
}

# An operator and what takes its place. Blanks around them tell them from templates, signs and references.
OPERATORS = {" < ": " >= ", " > ": " <= ", " <= ": " > ", " >= ": " < ", " && ": " || ", " || ": " && ", " + ": " - ", " - ": " + ",
             " * ": " / ", " / ": " * ", " += ": " -= ", " == ": " != ", " != ": " == ", "std::max(": "std::min(", "std::min(": "std::max("}


def generated(source, count):
    """`count` breaks of a file as (offset, length, replacement, line), evenly over its operators."""
    content = read(os.path.join(ROOT, "src", source))
    pattern = re.compile("|".join(re.escape(o) for o in sorted(OPERATORS, key=len, reverse=True)))
    sites = []
    start = 0
    for line in content.splitlines(keepends=True):
        code = re.sub(r'"(\\.|[^"\\])*"', lambda m: "_" * len(m.group()), line.split("//")[0])
        if not re.match(r"\s*(#|template|using|static_assert|assert)|.*operator", code):
            sites += [(start + m.start(), len(m.group()), OPERATORS[m.group()], line.strip()) for m in pattern.finditer(code)]
        start += len(line)
    chosen = [sites[(2 * k + 1) * len(sites) // (2 * count)] for k in range(count)] if sites else []
    return content, chosen


def all_mutants(words):
    """(source, changed content, description, tests) of every mutant that has one of the words."""
    for source, old, new, tests in MUTANTS:
        if words and not any(word in source or word in tests for word in words):
            continue
        content = read(os.path.join(ROOT, "src", source))
        if content.count(old) != 1:
            sys.exit(f"{source}: found {content.count(old)} times what a mutant changes, expected it once: {old}")
        yield source, content.replace(old, new), f"{old.strip()} -> {new.strip() or 'nothing'}", tests
    for test, sources in GENERATED.items():
        for source, count in sources.items():
            if words and not any(word in source or word == test for word in words):
                continue
            content, chosen = generated(source, count)
            for at, length, new, line in chosen:
                number = content.count("\n", 0, at) + 1
                yield (source, content[:at] + new + content[at + length:],
                       f"line {number}: {content[at:at + length].strip()} -> {new.strip()} in {line}", [test])


def command_for(build, target):
    lines = subprocess.run(["ninja", "-C", build, "-t", "commands", target], capture_output=True, text=True, check=True).stdout
    return lines.strip().splitlines()[-1]


def read(path):
    with open(path) as file:
        return file.read()


def commands(build):
    """Files that are compiled, each with its command."""
    with open(os.path.join(build, "compile_commands.json")) as file:
        return [(entry["file"], entry["command"]) for entry in json.load(file)]


def compiled(build, source, content, folder, whole_unit=False):
    """The object of a changed source, with the flags of its component; None if it does not compile."""
    path = os.path.join(folder, os.path.basename(source))
    with open(path, "w") as file:
        file.write(content)
    original = os.path.join(ROOT, "src", source)
    group = [(unit, command) for unit, command in commands(build)
             if unit == original or "/Unity/unity_files" + source.split("/")[0] + "_" in unit]
    group.sort(key=lambda one: one[0] != original)
    if whole_unit:
        group = [(unit, command) for unit, command in group if unit != original and original in read(unit)]
        if not group:
            return None
        text = read(group[0][0]).replace(original, path)
        path = os.path.join(folder, "unit_" + os.path.basename(source))
        with open(path, "w") as file:
            file.write(text)
    words = shlex.split(group[0][1])
    out = path[:-4] + ".o"
    words[words.index("-o") + 1] = out
    words[words.index("-c") + 1] = path
    for flag in ("-MD", "-MT", "-MF"):
        if flag in words:
            at = words.index(flag)
            del words[at:at + (1 if flag == "-MD" else 2)]
    words = [word for word in words if word != "-Werror"] + ["-w", "-I" + os.path.dirname(original)]
    words = os.environ.get("MUTANTS_LAUNCHER", "").split() + words
    return out if subprocess.run(words, cwd=build, stderr=subprocess.DEVNULL).returncode == 0 else None


def fails(build, test, obj, folder):
    program, target = os.path.join(folder, "test_" + test), "bin/test_" + test
    command = command_for(build, target)
    command = command.replace(" -o " + target, " " + obj + " -o " + program + " -Wl,--allow-multiple-definition")
    subprocess.run(command, shell=True, cwd=build, check=True)
    try:
        return subprocess.run([program, "--gtest_fail_fast"], capture_output=True, timeout=LONGEST).returncode != 0
    except subprocess.TimeoutExpired:
        return True


def main(build, words):
    build = os.path.abspath(build)
    folder = os.path.join(build, "mutants")
    os.makedirs(folder, exist_ok=True)
    ran = survivors = 0
    for source, content, description, tests in all_mutants(words):
        caught = []
        obj = compiled(build, source, content, folder)
        if obj is None:
            print(f"does not compile: {source}: {description}", flush=True)
            continue
        caught = [test for test in tests if fails(build, test, obj, folder)]
        if not caught:
            unit = compiled(build, source, content, folder, whole_unit=True)
            caught = [test for test in tests if unit and fails(build, test, unit, folder)]
        ran += 1
        survivors += not caught
        print(f"{'caught by ' + caught[0] if caught else 'SURVIVES'}: {source}: {description}", flush=True)
    print(f"{ran} mutants, {survivors} survivors")
    return min(survivors, 100)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], sys.argv[2:]))
