#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "hide_and_seek/bench.hpp"
#include "hide_and_seek/swept_room.hpp"
#include "recordings/quality/quality_numbers.hpp"
#include "support/clean_recording.hpp"

namespace veridyn::seek {
namespace {

constexpr double kRadiansToDegrees = 180.0 / M_PI;

// What is wrong with a recording, and the findings that say it, each with its joint. Remarks (rates, periods, noise)
// may stand beside them.
struct Fault {
  const char* name;
  std::vector<std::string> findings;
  void (*make)(Recording&);
};

double rms(const MatrixXd& m, int joint) { return m.col(joint).norm() / std::sqrt(static_cast<double>(m.rows())); }

double range(const MatrixXd& m, int joint) { return m.col(joint).maxCoeff() - m.col(joint).minCoeff(); }

void repeat_row(Recording& r, int k) {
  for (const RecordingSignal& signal : kRecordingSignals) {
    MatrixXd& values = r.*signal.values;
    if (values.size() > 0) values.row(k) = MatrixXd(values.row(k - 1));
  }
}

void repeat_rows(Recording& r, double share) {
  Draw draw(1, "rows that repeat");
  for (int k = 10; k < r.rows(); ++k) {
    if (draw.in(0.0, 1.0) < share) repeat_row(r, k);
  }
}

void thinned(Recording& r, int (*next)(int)) {
  Recording out = r;
  int count = 0;
  for (int k = 0; k < r.rows(); k = next(k), ++count) {
    out.time[count] = r.time[k];
    for (const RecordingSignal& signal : kRecordingSignals) {
      if ((r.*signal.values).size() > 0) (out.*signal.values).row(count) = (r.*signal.values).row(k);
    }
  }
  r = rows_of(out, 0, count);
}

void delay_velocity(Recording& r, int joint, double rows) {
  const VectorXd dq = r.dq.col(joint);
  for (int k = 20; k < r.rows() - 20; ++k) {
    const int before = static_cast<int>(std::floor(k - rows));
    const double share = k - rows - before;
    r.dq(k, joint) = (1.0 - share) * dq[before] + share * dq[before + 1];
  }
}

void round_to(MatrixXd& m, int joint, double step) {
  for (double& x : m.col(joint)) x = step * std::round(x / step);
}

void add_noise(MatrixXd& m, int joint, double size) {
  Draw draw(2, "noise");
  for (double& x : m.col(joint)) x += size * draw.normal();
}

// A velocity from counted ticks: between two of them it jumps from one to the other, beside a little noise.
void add_ticks(MatrixXd& m, int joint, double step) {
  Draw draw(3, "ticks");
  for (double& x : m.col(joint)) {
    const double count = std::floor(x / step + draw.in(0.0, 1.0));
    x = step * (count + 0.01 * draw.normal());
  }
}

void limit_torque(Recording& r, int joint, double share) {
  const double limit = share * r.tau.col(joint).cwiseAbs().maxCoeff();
  r.tau.col(joint) = r.tau.col(joint).cwiseMin(limit).cwiseMax(-limit);
}

void ring(Recording& r, double size, double seconds) {
  const double level = size * rms(r.tau, 1);
  for (int k = 0; r.time[k] - r.time[0] < seconds; ++k) r.tau(k, 1) += level * std::sin(60.0 * r.time[k]);
}

void hold(Recording& r, int joint) {
  r.q.col(joint) = r.q.col(joint) * 1e-4;
  r.dq.col(joint) *= 1e-4;
}

const std::vector<Fault>& faults() {
  static const std::vector<Fault> kAll = {
      {"nothing", {}, [](Recording&) {}},
      {"nothing without velocities", {}, [](Recording& r) { r.dq.resize(0, 0); }},
      {"nothing at 100 Hz", {}, [](Recording& r) { thinned(r, [](int k) { return k + 2; }); }},
      {"nothing in 120 rows", {}, [](Recording& r) { r = rows_of(r, 500, 120); }},
      {"torques of ten bits", {}, [](Recording& r) { for (int j = 0; j < 3; ++j) round_to(r.tau, j, range(r.tau, j) / 1024.0); }},
      {"torques of five bits", {}, [](Recording& r) { for (int j = 0; j < 3; ++j) round_to(r.tau, j, range(r.tau, j) / 32.0); }},
      {"a small motion", {}, [](Recording& r) { r.q *= 0.05; r.dq *= 0.05; }},
      {"friction alone", {}, [](Recording& r) { for (double& x : r.tau.col(0)) x = 0.0; for (int k = 0; k < r.rows(); ++k) r.tau(k, 0) = std::tanh(50.0 * r.dq(k, 0)); add_noise(r.tau, 0, 0.01); }},
      {"2 % of the rows repeat", {"stale_rows:0"}, [](Recording& r) { repeat_rows(r, 0.02); }},
      {"5 % of the rows repeat", {"stale_rows:0"}, [](Recording& r) { repeat_rows(r, 0.05); }},
      {"three quarters of the rows repeat", {"stale_rows:0"}, [](Recording& r) { repeat_rows(r, 0.75); }},
      {"a torque at half rate", {"stale_signal:2"}, [](Recording& r) { for (int k = 1; k < r.rows(); k += 2) r.tau(k, 1) = r.tau(k - 1, 1); }},
      {"every fifth torque is old", {"stale_signal:2"}, [](Recording& r) { for (int k = 5; k < r.rows(); k += 5) r.tau(k, 1) = r.tau(k - 1, 1); }},
      {"60 values are missing", {"gaps:3"}, [](Recording& r) { r.tau.col(2).segment(100, 60).setConstant(NAN); }},
      {"three values are missing", {"gaps:3"}, [](Recording& r) { r.tau.col(2).segment(100, 3).setConstant(NAN); }},
      {"a torque is missing", {"gaps:3"}, [](Recording& r) { r.tau.col(2).tail(3500).setConstant(NAN); }},
      {"all torques have gaps", {"gaps:0"}, [](Recording& r) { for (int k = 100; k < 160; ++k) { r.tau.row(k).setConstant(NAN); r.q(k, 0) = k > 110 ? NAN : r.q(k, 0); } }},
      {"a hole of 25 rows", {"missing_rows:0"}, [](Recording& r) { r.time.tail(2000).array() += 25.0 / kRate; }},
      {"a hole of one row", {"missing_rows:0"}, [](Recording& r) { r.time.tail(2000).array() += 1.0 / kRate; }},
      {"3 % of the rows are missing", {"missing_rows:0"}, [](Recording& r) { thinned(r, [](int k) { return k % 32 == 0 ? k + 2 : k + 1; }); }},
      {"steps of 20 and 25 ms", {"irregular_time:0"}, [](Recording& r) { thinned(r, [](int k) { return k + 4 + (k / 4) % 2; }); }},
      {"mostly 5 ms and at times 6", {"irregular_time:0"}, [](Recording& r) { double late = 0.0; for (int k = 0; k < r.rows(); ++k) { late += k % 10 == 9 ? 1e-3 : 0.0; r.time[k] += late; } }},
      {"one absurd number", {"absurd_numbers:0"}, [](Recording& r) { r.tau(2000, 1) = 1e305; }},
      {"absurd numbers in 1 % of the rows", {"absurd_numbers:0", "gaps:1"}, [](Recording& r) { for (int k = 0; k < r.rows(); k += 100) r.q(k, 0) = 3e7; }},
      {"a tooth slips", {"jumps:2"}, [](Recording& r) { r.q.col(1).tail(2500).array() += 0.1 * range(r.q, 1); }},
      {"half a tooth slips", {"jumps:2"}, [](Recording& r) { r.q.col(1).tail(2500).array() += 0.04 * range(r.q, 1); }},
      {"one wrong position", {"jumps:3"}, [](Recording& r) { r.q(1234, 2) += 0.3 * range(r.q, 2); }},
      {"an angle is wrapped", {"jumps:2"}, [](Recording& r) { r.q.col(1).tail(2500).array() += 2.0 * M_PI; }},
      {"two recordings in one", {"jumps:1", "jumps:2", "jumps:3"}, [](Recording& r) { for (int j = 0; j < 3; ++j) r.q.col(j).tail(2500).array() += 0.3 * range(r.q, j); }},
      {"torque at 60 % of its largest", {"saturation:1"}, [](Recording& r) { limit_torque(r, 0, 0.6); }},
      {"torque at 90 % of its largest", {"saturation:1"}, [](Recording& r) { limit_torque(r, 0, 0.9); }},
      {"an amplifier at its limit", {"saturation:1"}, [](Recording& r) { limit_torque(r, 0, 0.5); add_noise(r.tau, 0, 0.01 * rms(r.tau, 0)); }},
      {"an amplifier at its limit beside noise", {"saturation:1"}, [](Recording& r) { limit_torque(r, 0, 0.5); add_noise(r.tau, 0, 0.03 * rms(r.tau, 0)); }},
      {"a torque of one sign", {"saturation:1"}, [](Recording& r) { r.tau.col(0) = r.tau.col(0).cwiseMin(0.0); }},
      {"the start rings", {"start_up_transient:2"}, [](Recording& r) { ring(r, 2.0, 0.6); }},
      {"the start rings a little", {"start_up_transient:2"}, [](Recording& r) { ring(r, 0.7, 0.4); }},
      {"a clock at 93 %", {"rate_contradiction:0"}, [](Recording& r) { r.time *= 0.93; }},
      {"a clock at 102 %", {}, [](Recording& r) { r.time *= 1.02; }},
      {"a clock at twice its rate", {"rate_contradiction:0"}, [](Recording& r) { r.time *= 2.0; }},
      {"a velocity 12 % off", {"velocity_scale:3"}, [](Recording& r) { r.dq.col(2) *= 1.12; }},
      {"a velocity 4 % off", {"velocity_scale:3"}, [](Recording& r) { r.dq.col(2) *= 1.04; }},
      {"a velocity 1 % off", {}, [](Recording& r) { r.dq.col(2) *= 1.01; }},
      {"half a velocity", {"velocity_scale:3"}, [](Recording& r) { r.dq.col(2) *= 0.5; }},
      {"the only moving joint 6 % off", {"velocity_scale:1"}, [](Recording& r) { hold(r, 1); hold(r, 2); r.dq.col(0) *= 1.06; }},
      {"the only moving joint 20 % off", {"rate_contradiction:0"}, [](Recording& r) { hold(r, 1); hold(r, 2); r.dq.col(0) *= 1.2; }},
      {"a velocity backwards", {"velocity_sign:2"}, [](Recording& r) { r.dq.col(1) *= -1.0; }},
      {"a velocity backwards and 5 % off", {"velocity_sign:2"}, [](Recording& r) { r.dq.col(1) *= -1.05; }},
      {"a velocity in degrees", {"degrees:2"}, [](Recording& r) { r.dq.col(1) *= kRadiansToDegrees; }},
      {"a position in degrees", {"degrees:2"}, [](Recording& r) { r.q.col(1) *= kRadiansToDegrees; }},
      {"all of a joint in degrees", {"degrees:1"}, [](Recording& r) { r.q.col(0) = (r.q.col(0).array() + 1.0) * kRadiansToDegrees; r.dq.col(0) *= kRadiansToDegrees; }},
      {"a velocity in steps of a tenth", {"velocity_quantised:1"}, [](Recording& r) { round_to(r.dq, 0, 0.1 * range(r.dq, 0)); }},
      {"a velocity in steps of a fiftieth", {"velocity_quantised:1"}, [](Recording& r) { round_to(r.dq, 0, 0.022 * range(r.dq, 0)); }},
      {"a velocity in steps of a hundredth", {}, [](Recording& r) { round_to(r.dq, 0, 0.01 * range(r.dq, 0)); }},
      {"a velocity between two ticks", {"velocity_quantised:1"}, [](Recording& r) { add_ticks(r.dq, 0, 0.1 * range(r.dq, 0)); }},
      {"noise on a velocity", {"velocity_noise:2"}, [](Recording& r) { add_noise(r.dq, 1, 0.03 * rms(r.dq, 1)); }},
      {"a velocity seven rows late", {"velocity_delay:2"}, [](Recording& r) { delay_velocity(r, 1, 7.0); }},
      {"a velocity one row late", {"velocity_delay:2"}, [](Recording& r) { delay_velocity(r, 1, 1.0); }},
      {"a velocity 0.2 rows late", {}, [](Recording& r) { delay_velocity(r, 1, 0.2); }},
      {"a velocity early beside wrong rows", {"velocity_delay:2"}, [](Recording& r) { delay_velocity(r, 1, -3.3); for (int k = 50; k < r.rows(); k += 211) r.dq(k, 1) = 0.0; }},
      {"a joint at rest", {"joint_at_rest:3"}, [](Recording& r) { hold(r, 2); }},
      {"a joint that creeps", {}, [](Recording& r) { const double share = 8e-3 / range(r.q, 2); r.q.col(2) *= share; r.dq.col(2) *= share; }},
      {"nothing moves", {"no_motion:0"}, [](Recording& r) { for (int j = 0; j < 3; ++j) hold(r, j); }},
      {"a torque that was not measured", {"constant_signal:2"}, [](Recording& r) { r.tau.col(1).setConstant(0.25); }},
      {"40 rows", {"short_recording:0"}, [](Recording& r) { r = rows_of(r, 500, 40); }}};
  return kAll;
}

TableCase<QualityNumbers> faulty(const Fault& fault, const std::string& name, Recording r) {
  fault.make(r);
  return {name, [r, expected = fault.findings](const QualityNumbers& numbers) {
            std::vector<std::string> found;
            std::string said;
            bool others = false;
            for (const QualityFinding& f : check_recording(r, numbers).findings) {
              const std::string one = fmt::format("{}:{}", f.finding, f.joint);
              found.push_back(one);
              const bool planted = std::find(expected.begin(), expected.end(), one) != expected.end();
              others = others || (f.severity != Severity::kInfo && !planted);
              said += fmt::format("{}{} {}", said.empty() ? "" : " | ", name_of(f.severity), one);
            }
            const bool all = std::all_of(expected.begin(), expected.end(), [&](const std::string& one) {
              return std::find(found.begin(), found.end(), one) != found.end();
            });
            return SweepAnswer{all && !others, said};
          }};
}

}  // namespace

SweptRoom quality_room(unsigned seed, const std::string& folder) {
  std::filesystem::create_directories(folder);
  const Bench bench = make_bench("psm-3dof", seed);
  const std::string path = folder + "/psm-3dof.csv";
  write_recording(bench, ideal_recording(bench, {}, Motion(bench.robot, seed, 1), 1), seed, 1, path);
  const Recording arm = read_recording(path), waves = clean_recording(seed);
  std::vector<TableCase<QualityNumbers>> cases;
  for (const Fault& one : faults()) {
    cases.push_back(faulty(one, fmt::format("{} waves", one.name), waves));
    cases.push_back(faulty(one, fmt::format("{} psm-3dof", one.name), arm));
  }
  return room_of(quality_numbers(), cases);
}

}  // namespace veridyn::seek
