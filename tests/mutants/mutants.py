"""Mutants of sources: small breaks, each of which the tests of its folder must notice.

    mutants.py BUILD [WORD...]    those whose file or test has one of the words; all without words

A mutant is a file, a piece of it that occurs once, what takes its place, and the test programs that
have to fail. The tree and BUILD stay as they are: the changed file is compiled into BUILD/mutants and
linked in front of the library. The status is the number of survivors.
"""
import os
import shlex
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))

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
    ("watch/noise.cpp", "constexpr double kLargestPole = 0.98;", "constexpr double kLargestPole = 0.5;", ["watch"]),
    ("watch/noise.cpp", "constexpr int kRounds = 3;", "constexpr int kRounds = 0;", ["watch"]),
    ("watch/noise.cpp", "kUnlearned * novelty(step, j) > deviation_[j]", "false", ["watch"]),
    ("watch/noise.cpp", "steps[k]->rest_friction2[j] <= 0.0", "true", ["watch"]),
    ("watch/noise.cpp", "!steps[k]->follows || !steps[k - 1]->follows || ", "", ["watch"]),
    ("watch/evidence.cpp", "const double fitted = std::pow(1.0 + 1.0 / windows, 2);", "const double fitted = 1.0;", ["watch"]),
    ("watch/evidence.cpp", "if (windows < 1.0) continue;", "", ["watch"]),
    ("watch/evidence.cpp", "A > kNothing ? std::clamp(b / A, least, largest) : 0.0", "A > kNothing ? b / A : 0.0", ["watch"]),
    ("watch/evidence.cpp", "if (step->time > latest || gain", "if (gain", ["watch"]),
    ("watch/change.cpp", "constexpr int kAboveInARow = 2;", "constexpr int kAboveInARow = 1;", ["watch"]),
    ("watch/change.cpp", "constexpr double kRefractoryTime = 1.0;", "constexpr double kRefractoryTime = 0.0;", ["watch"]),
    ("watch/change.cpp", "constexpr double kPushEnds = 0.8;", "constexpr double kPushEnds = 80.0;", ["watch"]),
    ("watch/change.cpp", "constexpr int kLikelyInARow = 4;", "constexpr int kLikelyInARow = 1;", ["watch"]),
    ("watch/change.cpp", "constexpr double kReversalShare = 0.3;", "constexpr double kReversalShare = 0.0;", ["watch"]),
    ("recordings/kept_recordings.cpp", "wanted < 0 || wanted > bytes_left_", "wanted < 0", ["recordings", "diagnosis"]),
    ("recordings/kept_recordings.cpp", "bytes_left_ -= wanted;", "", ["recordings", "diagnosis"]),
    ("identification/shortfall.cpp", "travel = std::max(travel, r.joints[i].travel())", "travel = r.joints[i].travel()", ["identification"]),
    ("identification/many/factor_set.cpp", "require(version == kVersion", "require(true", ["identification"]),
    ("identification/many/factor_set.cpp", "require(a.settings == b.settings", "require(true", ["identification"]),
    ("diagnosis/stages/selection_stage.cpp", "constexpr int kCycles = 2;", "constexpr int kCycles = 1;", ["diagnosis"]),
    ("diagnosis/evidence/payload_fit.cpp", "  A.diagonal() *= 1.0 + numerics::kLoadRidge;\n", "", ["diagnosis"]),
    ("diagnosis/evidence/payload_fit.cpp", "out.A.diagonal().segment(1, 3).array() += unseen_curvature(out);", "", ["diagnosis"]),
    ("diagnosis/causes/geometry.cpp", "std::max(out.deviation, wider * of_recordings)", "out.deviation", ["diagnosis"]),
    ("diagnosis/causes/geometry.cpp", "if (recordings < 3) return;", "if (recordings < 1000) return;", ["diagnosis"]),
]


def command_for(build, target):
    lines = subprocess.run(["ninja", "-C", build, "-t", "commands", target], capture_output=True, text=True, check=True).stdout
    return lines.strip().splitlines()[-1]


def compiled(build, source, content, folder):
    """The object of a changed source, with the flags of its component."""
    with open(os.path.join(build, "compile_commands.json")) as file:
        text = file.read()
    lines = [line.strip() for line in text.splitlines() if line.strip().startswith('"command"')]
    alone = [line for line in lines if line.rstrip('",').endswith("/src/" + source)]
    group = "/Unity/unity_files" + source.split("/")[0] + "_"  # a file of the same component
    command = (alone or [line for line in lines if group in line])[0]
    words = shlex.split(command[len('"command": "'):].rstrip('",').replace('\\"', '"').replace("\\\\", "\\"))
    path = os.path.join(folder, os.path.basename(source))
    with open(path, "w") as file:
        file.write(content)
    out = path[:-4] + ".o"
    words[words.index("-o") + 1] = out
    words[words.index("-c") + 1] = path
    for flag in ("-MD", "-MT", "-MF"):
        if flag in words:
            at = words.index(flag)
            del words[at:at + (1 if flag == "-MD" else 2)]
    words = [word for word in words if word != "-Werror"] + ["-w", "-I" + os.path.dirname(os.path.join(ROOT, "src", source))]
    subprocess.run(words, cwd=build, check=True)
    return out


def fails(build, test, obj, folder):
    program, target = os.path.join(folder, "test_" + test), "bin/test_" + test
    command = command_for(build, target)
    command = command.replace(" -o " + target, " " + obj + " -o " + program + " -Wl,--allow-multiple-definition")
    subprocess.run(command, shell=True, cwd=build, check=True)
    try:
        return subprocess.run([program, "--gtest_fail_fast"], capture_output=True, timeout=900).returncode != 0
    except subprocess.TimeoutExpired:
        return True


def main(build, words):
    build = os.path.abspath(build)
    folder = os.path.join(build, "mutants")
    os.makedirs(folder, exist_ok=True)
    survivors = 0
    for source, old, new, tests in MUTANTS:
        if words and not any(word in source or word in tests for word in words):
            continue
        with open(os.path.join(ROOT, "src", source)) as file:
            content = file.read()
        if content.count(old) != 1:
            sys.exit(f"{source}: found {content.count(old)} times what a mutant changes, expected it once: {old}")
        obj = compiled(build, source, content.replace(old, new), folder)
        caught = [test for test in tests if fails(build, test, obj, folder)]
        survivors += not caught
        print(f"{'caught by ' + caught[0] if caught else 'SURVIVES'}: {source}: {old.strip()} -> {new.strip() or 'nothing'}", flush=True)
    print(f"{survivors} survivors")
    return min(survivors, 100)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], sys.argv[2:]))
