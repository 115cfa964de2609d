#include "hide_and_seek/sweep_board.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <memory>

#include "hide_and_seek/board.hpp"
#include "hide_and_seek/outside.hpp"

namespace veridyn::seek {
namespace {

constexpr double kPause = 5.0;        // [s] of rest before and after a motion
constexpr double kSnagTorque = 0.6;   // of a place that sticks, share of its joint's rms torque
constexpr double kSnagWidth = 0.1;    // share of the travel

struct Hidden {
  const char* arm;
  std::vector<std::string> effects;
  const char* about;
  Mode mode = Mode::kBare;
  Trouble trouble = Trouble::kNone;
};

const std::vector<Hidden>& listed_causes() {
  static const char* const kScara = "pick-scara";
  static const char* const kPsm = "psm-3dof";
  static const std::vector<Hidden> kCases = {
      {kScara, {"backlash"}, "selection"}, {kPsm, {"encoder_offset"}, "selection constant"},
      {kScara, {"torque_gain"}, "selection"}, {kScara, {"coupling_error"}, "constant"},
      {kPsm, {"gravity_tilt"}, "selection constant"}, {kPsm, {"external_contact"}, "contact snag"},
      {kPsm, {"torque_ripple", "presliding_hysteresis"}, "selection ripple"}, {kScara, {}, "nothing"},
      {kPsm, {"payload"}, "selection change", Mode::kChanged},
      {kScara, {"coulomb_friction"}, "selection change", Mode::kChanged},
      {kPsm, {}, "nothing change", Mode::kChanged},
      {kScara, {}, "change", Mode::kChanged, Trouble::kTemperatureDrift}};
  return kCases;
}

// What is said, without numbers.
std::string said_by(const Diagnosis& d) {
  std::string out;
  const std::vector<NamedFinding> named = named_by(d);
  for (size_t k = 0; k < named.size(); ++k) {
    const NamedFinding& f = named[k];
    out += fmt::format("{}@{}{} {}", f.effect, f.joint, f.frame, name_of(d.findings[k].status));
    if (d.findings[k].shape) out += fmt::format(" {}", fmt::join(d.findings[k].shape->signals, " "));
    for (const Named& r : f.rivals) out += fmt::format(" or {}@{}{}", r.effect, r.joint, r.frame);
    out += d.findings[k].main ? ", " : " small, ";
  }
  for (const JointVerdict& v : d.joints) out += fmt::format("{} ", name_of(v.state));
  for (const RecordingQuality& q : d.data_quality) {
    for (const QualityFinding& f : q.findings) out += fmt::format("{}@{} ", f.finding, f.joint);
  }
  for (const std::vector<int>& group : d.moving_as_one) out += fmt::format("one {} ", fmt::join(group, " "));
  return out + fmt::format("{} left out, worse {}", d.excluded_intervals.size(), fmt::join(d.summary.worse_joints, " "));
}

std::string new_folder(const std::string& folder, const std::string& name) {
  const std::filesystem::path out = std::filesystem::path(folder) / name;
  std::filesystem::create_directories(out);
  return out.string();
}

SweepCase listed_case(const Hidden& asked, unsigned seed, const std::string& folder) {
  const HiddenCase hidden = hide({asked.arm, asked.effects, seed, 0.1, asked.mode, asked.trouble});
  std::string name = asked.effects.empty() ? "none" : fmt::format("{}", fmt::join(asked.effects, "+"));
  if (asked.trouble != Trouble::kNone) name += fmt::format(" {}", name_of(asked.trouble));
  if (asked.mode == Mode::kChanged) name += " since a MODEL";
  name += fmt::format(" {}", asked.arm);
  if (!hidden.observable) return {name, {}, {}};
  const std::string place = new_folder(folder, name);
  const CaseFiles files = write_case(hidden, place);
  const auto arm = std::make_shared<Model>(known_arm(hidden, files, place, DiagnosisOptions().identification));
  return {name, asked.about, [hidden, files, arm](const DiagnosisOptions& options) {
            const Diagnosis d = diagnose(*arm, files.train, files.test, options);
            const Verdict v = judge(hidden, d);
            return SweepAnswer{v.named_rival == v.hidden && v.extras == 0, said_by(d)};
          }};
}

SweepCase outside_case(const std::string& arm, const std::string& cause, unsigned seed, int train,
                       const std::string& folder) {
  const std::string name = fmt::format("{}{} {}", cause, train == 1 ? " in one recording" : "", arm);
  const OutsideFiles files = write_outside(arm, cause, seed, OutsideRequest().share, new_folder(folder, name), train);
  const VectorXd clean = files.clean_error(DiagnosisOptions().identification);
  return {name, "unnamed", [files, clean](const DiagnosisOptions& options) {
            const Diagnosis d = files.diagnosed(options);
            const OutsideScore s = score_outside(files.cause, d, clean);
            return SweepAnswer{s.joint && (s.signals || s.worded) && s.false_names == 0, said_by(d)};
          }};
}

// Recordings in which the torque of the second joint has the wrong sign.
void wrong_sign(int, const Bench&, IdealRecording& x) { x.tau.col(1) *= -1.0; }

// The first joint sticks at one place in the second recording.
void snag(int number, const Bench&, IdealRecording& x) {
  if (number != 2) return;
  const VectorXd q = x.rows.q.col(0);
  const double travel = q.maxCoeff() - q.minCoeff(), middle = q.mean();
  const double level = kSnagTorque * x.tau.col(0).norm() / std::sqrt(static_cast<double>(q.size()));
  for (Eigen::Index r = 0; r < q.size(); ++r) {
    if (std::abs(q[r] - middle) < 0.5 * kSnagWidth * travel) x.tau(r, 0) += level * direction(x.rows.dq(r, 0));
  }
}

// The arm rests before and after the motion, where friction is any force.
void rests(int, const Bench& bench, IdealRecording& x) {
  const auto pause = static_cast<Eigen::Index>(kPause * kRate);
  const Eigen::Index rows = x.tau.rows();
  const auto padded = [&](const MatrixXd& m, bool hold) {
    MatrixXd out = MatrixXd::Zero(rows + 2 * pause, m.cols());
    if (hold) out.topRows(pause).rowwise() = m.row(0);
    if (hold) out.bottomRows(pause).rowwise() = m.row(rows - 1);
    out.middleRows(pause, rows) = m;
    return out;
  };
  x.rows.time = VectorXd::LinSpaced(rows + 2 * pause, 0.0, static_cast<double>(rows + 2 * pause - 1) / kRate);
  x.rows.q = padded(x.rows.q, true);
  x.rows.dq = padded(x.rows.dq, false);
  x.rows.ddq = padded(x.rows.ddq, false);
  x.rigid = padded(x.rigid, true);
  x.q = padded(x.q, true);
  x.tau = padded(x.tau, true);
  for (Eigen::Index i = 0; i < x.tau.cols(); ++i) {
    x.tau.col(i).head(pause).array() += bench.friction[i].coulomb;
    x.tau.col(i).tail(pause).array() -= bench.friction[i].coulomb;
  }
}

// Something is wrong with the recordings and not with the arm.
SweepCase faulty_case(const char* name, unsigned seed, void (*change)(int, const Bench&, IdealRecording&),
                      const char* fault, const char* about, const std::string& folder) {
  const Bench bench = make_bench("psm-3dof", seed);
  const std::string place = new_folder(folder, name);
  std::vector<std::string> train;
  for (int k = 1; k <= kBareTrain + 1; ++k) {
    IdealRecording ideal = ideal_recording(bench, {}, Motion(bench.robot, seed, k), k);
    change(k, bench, ideal);
    train.push_back(fmt::format("{}/recording-{}.csv", place, k));
    write_recording(bench, ideal, seed, k, train.back());
  }
  const std::vector<std::string> test = {train.back()};
  train.pop_back();
  return {std::string(name) + " psm-3dof", about, [bench, train, test, fault](const DiagnosisOptions& options) {
            const Diagnosis d = diagnose(bench.robot, train, test, options);
            bool said = *fault == '\0';
            for (const RecordingQuality& q : d.data_quality)
              said = said || std::any_of(q.findings.begin(), q.findings.end(),
                                         [&](const QualityFinding& f) { return f.finding == fault; });
            return SweepAnswer{said && (*fault != '\0' || d.findings.empty()), said_by(d)};
          }};
}

}  // namespace

std::vector<SweepCase> sweep_board(unsigned seed, const std::string& folder) {
  std::vector<SweepCase> out;
  for (const Hidden& asked : listed_causes()) {
    SweepCase one = listed_case(asked, seed, folder);
    if (one.ask) out.push_back(std::move(one));
  }
  for (const char* cause : {"end_stop", "torque_limit"})
    out.push_back(outside_case("psm-3dof", cause, seed, 4, folder));
  for (const char* cause : {"distant_friction", "counterbalance_lever"})
    out.push_back(outside_case("pick-scara", cause, seed, 4, folder));
  out.push_back(outside_case("psm-3dof", "magnet_detent", seed, 1, folder));
  out.push_back(faulty_case("wrong sign", seed, wrong_sign, "torque_sign", "sign", folder));
  out.push_back(faulty_case("snag", seed, snag, "snag", "snag contact motion", folder));
  out.push_back(faulty_case("rests", seed, rests, "", "motion", folder));
  return out;
}

bool concerns(const SweepCase& one, const std::string& number) {
  static const std::vector<std::pair<const char*, std::vector<const char*>>> kQuestions = {
      {"contact", {"contact_"}},
      {"snag", {"snag_"}},
      {"ripple", {"ripple_"}},
      {"constant", {"constant_", "commoner_cause", "weaker_rival", "kept_constants"}},
      {"unnamed", {"unnamed_", "small_beside_unnamed", "at_floor", "withdrawals"}},
      {"motion", {"still_", "moving_share", "shortest_rest", "move_as_one"}},
      {"change", {"smallest_change", "impossible_fall"}},
      {"sign", {"negative_friction"}}};
  const auto asks = [&one](const char* about) { return one.about.find(about) != std::string::npos; };
  if (asks("nothing")) return true;
  for (const auto& [about, numbers] : kQuestions) {
    for (const std::string begin : numbers) {
      if (number.rfind(begin, 0) == 0) return asks(about);
    }
  }
  return asks("selection");
}

}  // namespace veridyn::seek
