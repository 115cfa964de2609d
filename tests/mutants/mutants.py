"""Mutants of sources: small breaks, each of which the tests of its folder must notice.

    mutants.py BUILD [WORD...]    those whose file or test has one of the words; all without words
    mutants.py list               counts them: what they change must be in the sources

A mutant is a file, a piece of it that occurs once, what takes its place, and the test programs one of
which has to fail. MUTANTS are chosen by hand; GENERATED says how many operators of a file are turned
into others, evenly over its lines. The tree and BUILD stay as they are: the changed file is compiled
into BUILD/mutants and linked in front of the library; what survives is compiled once more with the
other files of its unit, where the compiler may have inlined it. The status is the number of survivors.
MUTANTS_LAUNCHER is put in front of compilers.
"""
import glob
import json
import os
import re
import shlex
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
LONGEST = 1800  # [s] of a test program, some of which take 370 s on a busy machine; a mutant that does not end is caught

MUTANTS = [
    ("dvrk/protocol/crc.cpp", "return ~crc;", "return crc;", ["dvrk_io"]),
    ("dvrk/protocol/crc.cpp", "for (; k < bytes.size; ++k) crc", "for (; k + 1 < bytes.size; ++k) crc", ["dvrk_io"]),
    ("dvrk/protocol/feedback.cpp", "if (firmware >= 7) {\n      channel", "if (firmware >= 8) {\n      channel", ["dvrk_io"]),
    ("dvrk/protocol/feedback.cpp", "if (firmware >= 8) channel.motor", "if (firmware >= 7) channel.motor", ["dvrk_io"]),
    ("dvrk/protocol/feedback.cpp", "static_cast<std::uint16_t>(analog >> 16)", "static_cast<std::uint16_t>(analog >> 15)", ["dvrk_io"]),
    ("dvrk/protocol/hub_block.cpp", "header.sequence == (sequence & 0xFF) && !header.mismatch", "header.sequence == (sequence & 0xFF)", ["dvrk_io"]),
    ("dvrk/protocol/hub_block.cpp", "h.mismatch = (word & 0x8000U) != 0;", "h.mismatch = false;", ["dvrk_io"]),
    ("dvrk/protocol/hub_block.cpp", "word & (firmware >= 9 ? kTime15 : kTime14)", "word & kTime14", ["dvrk_io"]),
    ("diagnosis/watch/noise.cpp", "a[0] = std::clamp(a[0], -numbers_.largest_pole * (1.0 - a[1]), numbers_.largest_pole * (1.0 - a[1]));", "", ["watch"]),
    ("diagnosis/watch/noise.cpp", "a[1] = std::clamp(a[1], -numbers_.largest_pole, numbers_.largest_pole);", "", ["watch"]),
    ("diagnosis/watch/noise.cpp", "0.5 * novelty(step, j) > deviation_[j]", "false", ["watch"]),
    ("diagnosis/watch/noise.cpp", "steps[k]->rest_friction2[j] <= 0.0", "true", ["watch"]),
    ("diagnosis/watch/noise.cpp", "!steps[k]->follows || !steps[k - 1]->follows || ", "", ["watch"]),
    ("diagnosis/watch/noise.cpp", "scale_[j] / speed_of_[p]", "scale_[j]", ["watch"]),
    ("diagnosis/watch/evidence.cpp", "const double fitted = std::pow(1.0 + 1.0 / windows, 2);", "const double fitted = 1.0;", ["watch"]),
    ("diagnosis/watch/evidence.cpp", "if (windows < 1.0) continue;", "", ["watch"]),
    ("diagnosis/watch/evidence.cpp", "A > kNothing ? std::clamp(b / A, least, largest) : 0.0", "A > kNothing ? b / A : 0.0", ["watch"]),
    ("diagnosis/watch/evidence.cpp", "if (step->time > latest || gain", "if (gain", ["watch"]),
    ("diagnosis/watch/change.cpp", "c.score.onset -= blindness.set_back;", "c.score.onset -= 0.0;", ["watch"]),
    ("diagnosis/watch/smoothed_rows.cpp", "back_last_ - back_first_ >= numbers_.jump_reach) restart();", "back_last_ < back_first_) restart();", ["watch"]),
    ("diagnosis/watch/change.cpp", "above_ < numbers_.above_in_a_row", "above_ < 1", ["watch"]),
    ("diagnosis/watch/change.cpp", "refractory_until_ = step.time + numbers_.refractory_time;", "refractory_until_ = step.time;", ["watch"]),
    ("diagnosis/watch/change.cpp", "change_->alarm, numbers_.push_ends - 0.5 * options_.step, push_price()", "change_->alarm, 80.0, push_price()", ["watch"]),
    ("diagnosis/watch/change.cpp", "explained && best.gain - next > odds()", "explained", ["watch"]),
    ("recordings/kept_recordings.cpp", "wanted < 0 || wanted > bytes_left_", "wanted < 0", ["recordings", "diagnosis"]),
    ("recordings/kept_recordings.cpp", "bytes_left_ -= wanted;", "", ["recordings", "diagnosis"]),
    ("recordings/files/whole_file.cpp", "size_ <= kLargestRead", "false", ["recordings"]),
    ("identification/shortfall.cpp", "travel = std::max(travel, r.joints[i].travel())", "travel = r.joints[i].travel()", ["identification"]),
    ("identification/many/factor_set.cpp", "require(version == kVersion", "require(true", ["identification"]),
    ("identification/many/factor_set.cpp", "require(a.settings == b.settings", "require(true", ["identification"]),
    ("control/momentum_observer.cpp", "- (arm.bias() - arm.rigid_bias())", "- 0.0 * (arm.bias() - arm.rigid_bias())", ["control"]),
    ("control/momentum_observer.cpp", "std::exp(-options_.bandwidth * dt)", "std::exp(-2.0 * options_.bandwidth * dt)", ["control"]),
    ("control/momentum_observer.cpp", "return frames_[a] > frames_[b];", "return frames_[a] < frames_[b];", ["control"]),
    ("control/cooperative/object_impedance.cpp", "now_.velocity = drift - now_.spin", "now_.velocity = drift + now_.spin", ["control"]),
    ("control/cooperative/object_impedance.cpp", "I * alpha + now.spin.cross(Vector3d(I * now.spin)) - moment", "I * alpha - moment", ["control"]),
    ("control/cooperative/object_impedance.cpp", "o.mass * (a - o.gravity) - force", "o.mass * (a - o.gravity)", ["control"]),
    ("control/cooperative/object_impedance.cpp", "wanted.spin_rate.cross(r) + wanted.spin.cross(wanted.spin.cross(r))", "wanted.spin_rate.cross(r)", ["control"]),
    ("control/cooperative/object_impedance.cpp", "Vector3d(N - middle.cross(F))", "Vector3d(N)", ["control"]),
    ("control/task_inverse.cpp", "(r < 3 ? unit / length_ : unit)", "(r < 3 ? unit * length_ : unit)", ["control"]),
    ("control/friction_compensation.cpp", "wanted * dt - axis.force * (axis.s - axis.before)", "wanted * dt + axis.force * (axis.s - axis.before)", ["control"]),
    ("control/friction_compensation.cpp", "x.s = axis.s - direction * kFar;", "x.s = axis.s + direction * kFar;", ["control"]),
    ("control/friction_compensation.cpp", "dot_product(axis.along, arm.rigid_bias()) / axis.squared", "dot_product(axis.along, arm.rigid_bias())", ["control"]),
    ("control/sensors/force_channel.cpp", "return options_.latency + filter;", "return filter;", ["load_cells"]),
    ("control/sensors/force_channel.cpp", "now - changed_ > options_.stuck_after", "now - begun_ > options_.stuck_after", ["load_cells"]),
    ("control/sensors/force_channel.cpp", "heard_ = !number_ ? at : std::max(heard_, at);", "heard_ = at;", ["load_cells"]),
    ("control/cooperative/teleoperation.cpp", "(R.transpose() * filtered_)", "(R * filtered_)", ["control"]),
    ("control/cooperative/teleoperation.cpp", "std::min(1.0, since_ / options_.ramp)", "1.0", ["control"]),
    ("control/safety/safety_supervisor.cpp", "std::max(since_sound_ + input.sensor_age_range, 0.0)", "std::max(input.dt, 0.0)", ["control"]),
    ("control/safety/safety_supervisor.cpp", "const double newer = input.dt + age_ - input.sensor_age;", "const double newer = input.sensor_age < input.dt ? input.dt : 0.0;", ["control"]),
    ("control/safety/safety_supervisor.cpp", "since_sound_ > kNewer * input.dt || !seen_", "true", ["control"]),
    ("control/sensors/load_cell_calibration.cpp", "slope_interval / (slope * slope)", "slope_interval / slope", ["load_cells"]),
    ("control/sensors/load_cell_calibration.cpp", "1.0 / n + f_mean * f_mean / ff", "1.0 / n", ["load_cells"]),
    ("cooperation/motion_plan.cpp", "tips_[arm].force += wall.drag *", "tips_[arm].force -= wall.drag *", ["cooperation"]),
    ("cooperation/motion_plan.cpp", "a.head<3>() -= arm.state.tip().jacobian_rate()", "a.head<3>() += arm.state.tip().jacobian_rate()", ["cooperation"]),
    ("cooperation/motion_plan.cpp", "member_vector(seen, m).norm() - force / m.stiffness", "member_vector(seen, m).norm() + force / m.stiffness", ["cooperation"]),
    ("cooperation/phase_figures.cpp", "off.bottomRows<1>().norm()", "off.topRows<1>().norm()", ["cooperation"]),
    ("cooperation/phase_figures.cpp", "f.mean_error = error.tail(last).mean();", "f.mean_error = error.mean();", ["cooperation"]),
    ("cooperation/loop_gains.cpp", "scenario.seed + 2000 + static_cast<unsigned>(wall + 1000 * channel)", "scenario.seed + 2000", ["cooperation"]),
    ("cooperation/stability/deadband_swing.cpp", "out.amplitude = 0.5 * (most - least);", "out.amplitude = most - least;", ["cooperation"]),
    ("cooperation/stability/deadband_swing.cpp", "out.frequency = 0.5 * turns / kLast;", "out.frequency = turns / kLast;", ["cooperation"]),
    ("cooperation/stability/linear_arm.cpp", "(odd(2.0 * kSlow) - odd(kSlow)) / kSlow", "odd(kSlow) / kSlow", ["cooperation"]),
    ("cooperation/stability/sample_pattern.cpp", "cycles = std::lcm(cycles, one.below)", "cycles = std::max(cycles, one.below)", ["cooperation"]),
    ("cooperation/waiting_lines.cpp", "lines_.clear();", "", ["cooperation"]),
    ("cooperation/stability/linear_arm.cpp", "return state.bias() - state.tip()", "return state.bias() + state.tip()", ["cooperation"]),
    ("cooperation/held_object.cpp", "target.position += target.force / hand_stiffness_;", "target.position -= target.force / hand_stiffness_;", ["cooperation"]),
    ("identification/rest_poses.cpp", "if (piece.rows() > 0 || one_pose) return false;", "if (piece.rows() > 0) return false;", ["identification"]),
    ("identification/rest_poses.cpp", "last[j] = r.dq(k, j) > 0.0 ? 1.0 : -1.0", "last[j] = r.dq(k, j) > 0.0 ? -1.0 : 1.0", ["identification"]),
    ("identification/identify_at_rest.cpp", "kBallRadius * kBallRadius;", "kBallRadius / kBallRadius;", ["identification"]),
    ("identification/velocity_choice.cpp", "std::min(how.row_count.value_or(identifying::kLookedAt), identifying::kLookedAt)", "how.row_count.value_or(identifying::kLookedAt)", ["identification"]),
    ("identification/velocity_choice.cpp", "reading.first_row = std::max(0L, how.first_row);", "reading.first_row = 0;", ["identification"]),
    ("identification/results/friction_curve.cpp", "kNormal95 * (F.transpose() * columns).norm()", "(F.transpose() * columns).norm()", ["identification"]),
    ("identification/results/friction_curve.cpp", "c * q + effect.term().axis.offset +", "c * q +", ["identification"]),
    ("identification/drive_gains/gain_data.cpp", "is_lasting(effect) ? p.name", "true ? p.name", ["identification"]),
    ("identification/fleet/fleet_spreads.cpp", "q.usual > 0.0 ? std::max(1.0, q.uncertain[a] / q.usual) : 1.0", "1.0", ["identification"]),
    ("identification/fleet/fleet_spreads.cpp", "prior.unlike - trigamma(0.5 * freedom)", "prior.unlike", ["identification"]),
    ("identification/validation.cpp", "seconds * arm.joints() / id.effective_samples", "seconds / id.effective_samples", ["identification"]),
    ("diagnosis/preparation/torque_signs.cpp", "std::pow(size * fit.std[at], 2)", "std::abs(size * fit.std[at])", ["diagnosis"]),
    ("diagnosis/search/vibration.cpp", "0.5 * amplitude * amplitude / mean_square(signal)", "amplitude * amplitude / mean_square(signal)", ["diagnosis"]),
    ("diagnosis/search/vibration.cpp", "if (share_of_line(x.time, centred(signal), frequency) > limits.line_of_motion * share) return std::nullopt;", "", ["diagnosis"]),
    ("recordings/quality/quality_saturation.cpp", "percent(kStepToDeviation * step / rms)", "percent(step / rms)", ["recordings"]),
    ("identification/portable_model.cpp", "wanted += rows.b - rows.A * found.x;", "", ["identification"]),
    ("dvrk/arms/psm_kinematics.cpp", "std::abs(n.x()) < 0.7 ? Eigen::Vector3d::UnitX()", "std::abs(n.x()) >= 0.7 ? Eigen::Vector3d::UnitX()", ["dvrk"]),
    ("dvrk/arms/joint_ranges.cpp", "q[k] - kTurn * std::ceil(above / kTurn) >= lower[k] - kSlack", "true", ["dvrk"]),
    ("dvrk/arms/joint_ranges.cpp", "else if (below > 0.0 &&", "else if (false &&", ["dvrk"]),
    ("dvrk/config/io_config_check.cpp", "std::min(amps_to_bits.offset, kMostBits - amps_to_bits.offset)", "std::max(amps_to_bits.offset, kMostBits - amps_to_bits.offset)", ["dvrk"]),
    ("dvrk/arms/arm_units.cpp", "(encoder_counts(raw.encoder.position) - previous) / raw.seconds", "(previous - encoder_counts(raw.encoder.position)) / raw.seconds", ["dvrk"]),
    ("dvrk/arms/arm_units.cpp", "effort_[i] = command.current[i] / actuators_[k].effort_to_amps;", "effort_[i] = command.current[i] * actuators_[k].effort_to_amps;", ["dvrk"]),
    ("dvrk/run/motion_check.cpp", "row.head(joints).isZero() || !row.tail(n - joints).isZero()", "row.head(joints).isZero()", ["dvrk_io"]),
    ("dvrk/run/brake_driver.cpp", "now - pushed_at_ >= brake_.release_time", "now >= brake_.release_time", ["dvrk"]),
    ("dvrk/protocol/encoder_words.cpp", "acceleration * (0.5 * P + running)", "acceleration * running", ["dvrk_io", "dvrk"]),
    ("diagnosis/watch/hypotheses.cpp", "out.time = time_.mean();", "out.time = time_[0];", ["watch"]),
    ("diagnosis/watch/evidence.cpp", "solve_from(steps, score.onset + skipped,", "solve_from(steps, score.onset,", ["watch"]),
    ("diagnosis/watch/evidence.cpp", "std::max(0.0, b[i] * b[i] / A[i] - price)", "std::max(0.0, b[i] * b[i] / A[i])", ["watch"]),
    ("diagnosis/watch/hypotheses.cpp", "std::abs(s.ds) < std::max(numbers_.rest_share * dry->fastest, spacing * std::abs(s.dds))", "std::abs(s.ds) < 0.0", ["watch"]),
    ("simulation/plant/infeasibility.cpp", "kSpread = 2000;", "kSpread = 20;", ["simulation"]),
    ("simulation/world/force_sensor.cpp", "require(under_way < kMostUnderWay", "require(true", ["cooperation"]),
    ("files/simulators/mjcf_elements.cpp", "group < first_group_ || group > last_group_", "group < first_group_", ["files"]),
    ("files/simulators/mjcf_reader.cpp", "std::min(most, std::max(std::abs(range[0]), std::abs(range[1]))", "std::min(most, std::abs(range[1])", ["files"]),
    ("simulation/plant/mujoco_engine.cpp", "std::min(kLongestStep, stable_step())", "kLongestStep", ["simulation"]),
    ("simulation/plant/mujoco_engine.cpp", "std::max(1, static_cast<int>(std::ceil(left / longest - 1e-9)))", "1", ["simulation"]),
    ("files/urdf/urdf_writer.cpp", "damping != 0.0 || level != 0.0", "damping != 0.0 && level != 0.0", ["files"]),
    ("files/urdf/urdf_writer.cpp", "if (here) sum += term.values.begin()->second;", "if (here) sum = term.values.begin()->second;", ["files"]),
    ("files/urdf/urdf_reader.cpp", "if (value < 0.0) xml_.fail(joint.node", "if (value < -1e9) xml_.fail(joint.node", ["files"]),
    ("files/urdf/urdf_reader.cpp", "effort > 0.0 && effort < kUnlimited", "effort > 0.0", ["files"]),
    ("files/mesh_file.cpp", "static_cast<long>(out.points.size()) + number", "-1 - number", ["files"]),
    ("dvrk/config/config_tree.cpp", "member.line > 0 ? text(\":\", member.line)", "false ? text(\":\", member.line)", ["dvrk"]),
    ("dvrk/run/run_json.cpp", "run.power == OffState::kConfirmed ?", "run.power != OffState::kNotAsked ?", ["dvrk_io"]),
    ("dvrk/boards/board_session.cpp", "(blind && in_state > kBlind && in_state < kBlind + kBite * options_.watchdog)", "false", ["dvrk_io"]),
    ("dvrk/boards/board_session.cpp", "  bus_.check_all_for_restart();\n", "", ["dvrk_io"]),
    ("dvrk/boards/board_bus.cpp", "protocol_ == CycleProtocol::kBroadcast && !silent_", "protocol_ == CycleProtocol::kBroadcast", ["dvrk_io"]),
    ("dvrk/boards/board_write.cpp", "state_ == BusState::kRunning && !exchange_.generation_changed();", "true;", ["dvrk_io"]),
    ("dvrk/arms/arm_file.cpp", "check_io_config(nominal_config(facts), source_.file);", "", ["dvrk"]),
    ("dvrk/arms/gravity_chain.cpp", "const bool overlap = lower < upper;", "const bool overlap = true;", ["dvrk"]),
    ("cooperation/scenario/scenario_objects.cpp", "if (!impedance || body.grasps.size() < 2)", "if (false)", ["cooperation"]),
    ("cooperation/scenario/teleoperation_reader.cpp", "refuse_unused_keys(root, out.scenario);", "", ["cooperation"]),
    ("dvrk/boards/board_session.cpp", "require(std::isfinite(seconds) && seconds > 0.0", "require(seconds > 0.0", ["dvrk_io"]),
]

# Mutants of each file, and the test program that has to notice them.
GENERATED = {
    "watch": {"diagnosis/watch/noise.cpp": 4, "diagnosis/watch/evidence.cpp": 5, "diagnosis/watch/smoothed_rows.cpp": 4, "diagnosis/watch/hypotheses.cpp": 4, "diagnosis/watch/held_signals.cpp": 3,
              "diagnosis/watch/change.cpp": 4},
    "identification": {"identification/feasible/pseudo_inertia.cpp": 3, "identification/velocity_choice.cpp": 4,
                       "identification/period_fold.cpp": 2, "identification/base_solution.cpp": 4,
                       "identification/rest_poses.cpp": 2, "identification/identify_at_rest.cpp": 2, "identification/instrumental.cpp": 3,
                       "identification/drive_gains/gain_problem.cpp": 3, "identification/results/verdict.cpp": 3, "identification/portable_model.cpp": 4},
    "diagnosis": {"diagnosis/preparation/errors_in_variables.cpp": 3,
                  "diagnosis/preparation/torque_signs.cpp": 3, "diagnosis/load_fit.cpp": 3,
                  "diagnosis/comparison/model_comparison.cpp": 1, "diagnosis/comparison/estimates.cpp": 2,
                  "diagnosis/comparison/standard_torque.cpp": 2},
    "control": {"control/adaptive_friction.cpp": 3, "control/computed_torque.cpp": 2, "control/cooperative/force_law.cpp": 2, "control/momentum_observer.cpp": 3, "control/velocity_observer.cpp": 2,
                "control/quintic_interpolator.cpp": 3, "control/impedance.cpp": 2, "control/model_error_observer.cpp": 3,
                "control/cooperative/tether_guard.cpp": 3},
    "load_cells": {"control/sensors/force_channel.cpp": 1, "control/sensors/load_cell_decoder.cpp": 1},
    "dvrk": {"dvrk/arms/psm_kinematics.cpp": 3, "dvrk/arms/mtm_kinematics.cpp": 3, "dvrk/arms/arm_units.cpp": 3,
             "dvrk/protocol/encoder_words.cpp": 3, "dvrk/arms/gravity_chain.cpp": 3, "dvrk/config/io_config_check.cpp": 3,
             "dvrk/arms/joint_ranges.cpp": 2, "dvrk/arms/gravity_file.cpp": 1, "dvrk/config/io_config_reader.cpp": 2},
    "cooperation": {"cooperation/motion_plan.cpp": 3, "cooperation/loop_gains.cpp": 2, "cooperation/held_object.cpp": 3,
                    "cooperation/phase_figures.cpp": 2, "cooperation/stability/small_gain.cpp": 3},
    "files": {"files/c_code/c_code.cpp": 3, "files/simulators/known_effects.cpp": 2, "files/simulators/mjcf.cpp": 4,
              "files/simulators/sdf.cpp": 3, "files/simulators/simulation_file.cpp": 4, "files/c_code/traced.cpp": 4},
}

# An operator and what takes its place. Blanks around them tell them from templates, signs and references.
OPERATORS = {" < ": " >= ", " > ": " <= ", " <= ": " > ", " >= ": " < ", " && ": " || ", " || ": " && ", " + ": " - ", " - ": " + ",
             " * ": " / ", " / ": " * ", " += ": " -= ", " == ": " != ", " != ": " == ", "std::max(": "std::min(", "std::min(": "std::max("}


def path_of(source):
    """A source of the library or of a package."""
    found = [path for path in glob.glob(os.path.join(ROOT, "packages", "*", "src", source)) + [os.path.join(ROOT, "src", source)]
             if os.path.exists(path)]
    if len(found) != 1:
        sys.exit(f"{source}: found {found or 'no such file'}, expected one source of the library or of a package")
    return found[0]


def generated(source, count):
    """`count` breaks of a file as (offset, length, replacement, line), evenly over its operators."""
    content = read(path_of(source))
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
        content = read(path_of(source))
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
    original = path_of(source)
    group = [(unit, command) for unit, command in commands(build)
             if unit == original or "/Unity/unity_files" in unit and original in read(unit)]
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
    if sys.argv[1:] == ["list"]:
        print(f"{len(list(all_mutants([])))} mutants")
        sys.exit()
    sys.exit(main(sys.argv[1], sys.argv[2:]))
