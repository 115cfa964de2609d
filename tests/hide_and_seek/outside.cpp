#include "hide_and_seek/outside.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include "hide_and_seek/draw.hpp"
#include "hide_and_seek/trouble.hpp"
#include "hide_and_seek/visibility.hpp"
#include "veridyn/effects/cause.hpp"

namespace veridyn::seek {
namespace {

constexpr int kTrain = 4;
constexpr double kStep = 1e-5;  // of numerical derivatives of positions
constexpr double kSoftest = 2.5;  // times 3 to 8 mrad: the linear model of the base holds up to about a degree

double rms(const VectorXd& x) {
  return std::sqrt(x.squaredNorm() / static_cast<double>(x.size()));
}

std::string signal(const char* letter, int joint) {
  return letter + std::to_string(joint + 1);
}

// A spring between a point of the link and one of the frame before it, always under tension.
double lever(double angle) {
  const double a = 0.35;
  const double b = 1.0;
  const double length = std::sqrt(a * a + b * b + 2.0 * a * b * std::cos(angle));
  return -a * b * std::sin(angle) * (1.0 - 0.55 / length);
}

// The end of the longest chain; the last link of a tree may be a balance weight.
size_t tip_of(const LagrangeArm& arm) {
  std::vector<int> depth;
  for (const Link& link : arm.links) depth.push_back(link.parent < 0 ? 0 : depth[static_cast<size_t>(link.parent)] + 1);
  return static_cast<size_t>(std::max_element(depth.rbegin(), depth.rend()).base() - depth.begin() - 1);
}

// J(tip)' force, by differences.
VectorXd tip_torque(const LagrangeArm& arm, const VectorXd& q, const Vector3d& force) {
  const auto tip = [&arm, end = tip_of(arm)](const VectorXd& at) { return Vector3d(arm.poses(at)[end].col(3).head<3>()); };
  VectorXd out(q.size());
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    VectorXd more = q;
    VectorXd less = q;
    more[i] += kStep;
    less[i] -= kStep;
    out[i] = force.dot(tip(more) - tip(less)) / (2.0 * kStep);
  }
  return out;
}

// Torque of unit size that is added to one joint.
VectorXd added(const OutsideCause& c, const IdealRecording& x) {
  const VectorXd q = x.rows.q.col(c.joint);
  const VectorXd dq = x.rows.dq.col(c.joint);
  VectorXd out = VectorXd::Zero(q.size());
  for (Eigen::Index r = 0; r < q.size(); ++r) {
    const double u = (q[r] - c.place) / c.width;
    if (c.name == "end_stop") out[r] = u > 0.0 ? u + 2.0 * u * u : 0.0;
    if (c.name == "counterbalance_lever") out[r] = lever(q[r] / c.width - c.place);
    if (c.name == "magnet_detent") out[r] = u * std::exp(-u * u);
    if (c.name == "distant_friction")
      out[r] = (1.0 + (x.rows.q(r, c.from) - c.place) / c.width) * (dq[r] > 0.0 ? 1.0 : -1.0) * 0.5;
    if (c.name == "one_way_damper") out[r] = dq[r] > c.place ? std::pow((dq[r] - c.place) / c.width, 2) : 0.0;
    if (c.name == "crosstalk") out[r] = x.tau(r, c.from);
  }
  return out;
}

bool is_added(const std::string& name) {
  return name != "torque_dead_zone" && name != "torque_limit" && name != "elastic_base" &&
         name != "tip_force";
}

struct Range {
  double low = 1e9, high = -1e9, fastest = 0.0;
  double middle() const { return 0.5 * (low + high); }
  double travel() const { return high - low; }
};

}  // namespace

const std::vector<std::string>& outside_causes() {
  static const std::vector<std::string> kAll = {
      "end_stop",  "counterbalance_lever", "torque_dead_zone", "torque_limit",   "elastic_base",
      "tip_force", "crosstalk",            "magnet_detent",    "distant_friction", "one_way_damper"};
  return kAll;
}

void apply_outside(const Bench& bench, const OutsideCause& c, IdealRecording& x) {
  if (c.name == "elastic_base") {
    x.tau += elastic_base_torque(bench.arm, bench.seed, x.rows, c.size);
  } else if (c.name == "tip_force") {
    const Vector3d force = c.size * Vector3d(std::cos(c.place), std::sin(c.place), c.width);
    for (Eigen::Index r = 0; r < x.tau.rows(); ++r)
      x.tau.row(r) += tip_torque(bench.arm, x.rows.q.row(r).transpose(), force).transpose();
  } else if (c.name == "torque_dead_zone") {
    for (double& t : x.tau.col(c.joint)) t = std::copysign(std::max(0.0, std::abs(t) - c.size), t);
  } else if (c.name == "torque_limit") {
    for (double& t : x.tau.col(c.joint)) t = c.size * std::tanh(t / c.size);
  } else {
    x.tau.col(c.joint) += c.size * added(c, x);
  }
}

OutsideCause draw_outside(const Bench& bench, const std::string& name, unsigned seed, double share) {
  Draw draw(seed, "outside " + name + bench.robot.name());
  std::vector<IdealRecording> plain;
  for (int k = 1; k <= 2; ++k)
    plain.push_back(ideal_recording(bench, {}, Motion(bench.robot, bench.seed, k), k));
  const int n = bench.arm.joints;
  std::vector<Range> range(n);
  for (const IdealRecording& x : plain) {
    for (int i = 0; i < n; ++i) {
      Range& r = range[i];
      r.low = std::min(r.low, x.rows.q.col(i).minCoeff());
      r.high = std::max(r.high, x.rows.q.col(i).maxCoeff());
      r.fastest = std::max(r.fastest, x.rows.dq.col(i).cwiseAbs().maxCoeff());
    }
  }
  OutsideCause c;
  c.name = name;
  const bool whole = name == "elastic_base" || name == "tip_force";
  if (!whole) c.joint = draw.below(n);
  if (name == "crosstalk" || name == "distant_friction")
    c.from = (c.joint + 1 + draw.below(n - 1)) % n;
  const Range own = range[std::max(c.joint, 0)];
  if (name == "end_stop") {
    c.place = own.low + draw.in(0.7, 0.85) * own.travel();
    c.width = 0.2 * own.travel();
    c.words = {"end_stop", "position_force", "joint_spring"};
  } else if (name == "counterbalance_lever") {
    c.width = own.travel() / 2.5;
    c.place = own.middle() / c.width - draw.in(-2.0, 2.0);
    c.words = {"position_force", "joint_spring"};
  } else if (name == "magnet_detent") {
    c.place = own.low + draw.in(0.3, 0.7) * own.travel();
    c.width = draw.in(0.06, 0.1) * own.travel();
    c.words = {"position_force"};
  } else if (name == "distant_friction") {
    const Range other = range[c.from];
    c.place = other.middle();
    c.width = 0.5 * other.travel();
  } else if (name == "one_way_damper") {
    c.place = draw.in(0.1, 0.3) * own.fastest;
    c.width = own.fastest;
    c.words = {"asymmetric_friction", "quadratic_drag"};
  } else if (name == "tip_force") {
    c.place = draw.in(-M_PI, M_PI);
    c.width = draw.in(-0.5, 0.5);
    c.words = {"tip_force", "gravity_tilt", "payload"};
  } else if (name == "elastic_base") {
    c.words = {"base_compliance", "gravity_tilt"};
  } else if (name == "crosstalk") {
    c.words = {"torque_crosstalk"};
  }
  if (name == "torque_dead_zone" || name == "torque_limit") {
    c.signals = {signal("tau", c.joint)};
    c.words = {"torque_gain"};
  } else if (name == "crosstalk") {
    c.signals = {signal("tau", c.from), signal("q", c.from), signal("ddq", c.from)};
  } else if (name == "distant_friction") {
    c.signals = {signal("q", c.from)};
  } else if (name == "one_way_damper") {
    c.signals = {signal("dq", c.joint)};
  } else if (!whole) {
    c.signals = {signal("q", c.joint)};
  }
  // The requested size by bisection, since not all torques are linear in it.
  const auto size_of = [&](double size) {
    OutsideCause trial = c;
    trial.size = size;
    double most = 0.0;
    for (int i = 0; i < n; ++i) {
      double sum = 0.0;
      double torque = 0.0;
      for (const IdealRecording& before : plain) {
        IdealRecording after = before;
        apply_outside(bench, trial, after);
        sum += std::pow(rms(after.tau.col(i) - before.tau.col(i)), 2);
        torque += std::pow(rms(before.tau.col(i)), 2);
      }
      most = std::max(most, std::sqrt(sum / torque));
    }
    return most;
  };
  if (name == "elastic_base") {  // nearly linear, and dear
    c.size = 1.0;
    for (int k = 0; k < 3; ++k) c.size = std::min(kSoftest, c.size * share / size_of(c.size));
    return c;
  }
  double low = 1e-6;
  double high = 1e6;
  const bool falls = name == "torque_limit";
  for (int k = 0; k < 40; ++k) {
    const double middle = std::sqrt(low * high);
    ((size_of(middle) > share) != falls ? high : low) = middle;
  }
  c.size = std::sqrt(low * high);
  if (is_added(name) && draw.sign() < 0.0) c.size = -c.size;
  return c;
}

OutsideScore score_outside(const OutsideCause& cause, const Diagnosis& d, const VectorXd& clean) {
  OutsideScore out;
  const VectorXd& before = d.baseline.test_error.relative;
  int joint = cause.joint;
  if (joint < 0) (before.cwiseAbs2() - clean.cwiseAbs2()).maxCoeff(&joint);
  const JointVerdict& v = d.joints[joint];
  out.state = name_of(v.state);
  out.silent = v.state == JointState::kAtFloor && before[joint] > 1.3 * clean[joint];
  const double removable = before[joint] * before[joint] - clean[joint] * clean[joint];
  out.explained = std::clamp(
      (before[joint] * before[joint] - v.left * v.left) / std::max(removable, 1e-12), 0.0, 1.0);
  for (const Finding& f : d.findings) {
    const std::string effect = effect_of(f.cause);
    const bool here = !f.joint || f.joint->value == joint;
    out.joint = out.joint || here;
    if (f.shape) {
      const std::vector<std::string>& of = f.shape->signals;
      const bool right =
          cause.signals.empty()
              ? std::any_of(of.begin(), of.end(), [](const std::string& s) { return s[0] == 'q' || s[0] == 't'; })
              : std::any_of(of.begin(), of.end(), [&](const std::string& s) {
                  return std::find(cause.signals.begin(), cause.signals.end(), s) != cause.signals.end();
                });
      out.signals = out.signals || (here && right);
    } else {
      const bool fits = here && std::find(cause.words.begin(), cause.words.end(), effect) != cause.words.end();
      out.worded = out.worded || fits;
      out.false_names += fits ? 0 : 1;
    }
  }
  return out;
}

OutsideFiles write_outside(const std::string& arm, const std::string& name, unsigned seed, double share,
                           const std::string& folder, int train) {
  const auto own_seed = static_cast<unsigned>(Draw(seed, "outside " + arm + name).below(1 << 30));
  OutsideFiles out = {make_bench(arm, own_seed), {}, {}, {}};
  std::vector<IdealRecording> learned;
  const Bench& bench = out.bench;
  if (name != "none") out.cause = draw_outside(bench, name, seed, share);
  for (int k = 1; k <= train + 1; ++k) {
    IdealRecording ideal = ideal_recording(bench, {}, Motion(bench.robot, bench.seed, k), k);
    out.without.push_back(fmt::format("{}/clean-{}.csv", folder, k));
    write_recording(bench, ideal, bench.seed, k, out.without.back());
    if (name != "none") apply_outside(bench, out.cause, ideal);
    out.with.push_back(fmt::format("{}/recording-{}.csv", folder, k));
    write_recording(bench, ideal, bench.seed, k, out.with.back());
    if (k <= train) learned.push_back(std::move(ideal));
  }
  out.observable = name == "none" || visibility(bench, learned, true).observable();
  return out;
}

Diagnosis OutsideFiles::diagnosed(const DiagnosisOptions& options) const {
  return diagnose(bench.robot, std::vector<std::string>(with.begin(), with.end() - 1), std::vector<std::string>{with.back()},
                  options);
}

VectorXd OutsideFiles::clean_error(const IdentificationOptions& options) const {
  const std::vector<std::string> train(without.begin(), without.end() - 1), test = {without.back()};
  return identify(bench.robot, train, test, options).test_error.relative;
}

namespace {

struct Played {
  std::string name;
  OutsideScore score;
  std::string line = {};
};

void print_outside(const std::vector<Played>& all) {
  std::vector<std::string> names;
  for (const Played& p : all) {
    if (std::find(names.begin(), names.end(), p.name) == names.end()) names.push_back(p.name);
  }
  names.emplace_back("all");
  fmt::print("\n{:<22} {:>5} {:>6} {:>16} {:>7} {:>12} {:>10} {:>6}\n", "hidden, on no list", "cases", "joint",
             "worded or signals", "silent", "false names", "explained", "unseen");
  for (const std::string& name : names) {
    int cases = 0, joint = 0, right = 0, silent = 0, wrong = 0, unseen = 0;
    std::vector<double> explained;
    for (const Played& p : all) {
      if (name != "all" && p.name != name) continue;
      if (!p.score.observable) {
        ++unseen;
        continue;
      }
      ++cases;
      joint += p.score.joint ? 1 : 0;
      right += p.score.joint && (p.score.signals || p.score.worded) ? 1 : 0;
      silent += p.score.silent ? 1 : 0;
      wrong += p.score.false_names > 0 ? 1 : 0;
      explained.push_back(p.score.explained);
    }
    if (explained.empty()) explained.push_back(0.0);
    std::nth_element(explained.begin(), explained.begin() + static_cast<long>(explained.size() / 2), explained.end());
    fmt::print("{:<22} {:>5} {:>6} {:>16} {:>7} {:>12} {:>9.0f}% {:>6}\n", name, cases, joint, right, silent, wrong,
               100.0 * explained[explained.size() / 2], unseen);
  }
}

Played play_one(const OutsideRequest& request, const std::string& arm, const std::string& name, unsigned seed) {
  namespace fs = std::filesystem;
  const fs::path folder = request.keep.empty()
                              ? fs::temp_directory_path() / fmt::format("veridyn-outside-{}", getpid())
                              : fs::path(request.keep) / fmt::format("{}-{}-{}", name, arm, seed);
  fs::create_directories(folder);
  const OutsideFiles files = write_outside(arm, name, seed, request.share, folder.string(), kTrain);
  const OutsideCause& cause = files.cause;
  Played out{name, {}, {}};
  if (!files.observable) {
    if (request.keep.empty()) fs::remove_all(folder);
    out.score.observable = false;
    out.line = fmt::format("{:<10} {} {} on {} from {}: not observable on this arm", arm, seed, name, cause.joint + 1, cause.from + 1);
    return out;
  }
  DiagnosisOptions options = request.options;
  options.identification.threads = request.threads;
  const VectorXd clean = files.clean_error(options.identification);
  const Diagnosis d = files.diagnosed(options);
  if (request.keep.empty()) fs::remove_all(folder);
  if (name == "none") {
    out.score.false_names = static_cast<int>(d.findings.size());
    out.score.state = "at_floor";
    out.score.explained = 1.0;
  } else {
    out.score = score_outside(cause, d, clean);
  }
  std::string findings;
  for (const Finding& f : d.findings) {
    findings += fmt::format(" {}@{}{}", effect_of(f.cause), f.joint ? f.joint->value + 1 : 0,
                            f.status == FindingStatus::kConfirmed ? "" : "?");
    if (f.shape) findings += fmt::format("({} {:.0f}% {})", fmt::join(f.shape->signals, ","), 100.0 * f.shape->share, f.shape->words.substr(0, 40));
  }
  std::string states;
  for (const JointVerdict& v : d.joints) {
    const double c = clean[v.joint.value];
    states += fmt::format(" {}:{} {:.1f}/{:.1f}/{:.1f}/{:.1f}", v.joint.value + 1, name_of(v.state),
                          100.0 * v.held_out, 100.0 * v.left, 100.0 * v.floor, 100.0 * c);
  }
  out.line = fmt::format("{:<10} {} {} on {} from {}: {}{}{}{} explained {:.0f} % |{} |{} | {:.1f} s", arm, seed, name,
                         cause.joint + 1, cause.from + 1, out.score.joint ? "joint " : "JOINT MISSED ",
                         out.score.signals ? "signals " : "", out.score.worded ? "worded " : "",
                         out.score.silent ? "SILENT " : "", 100.0 * out.score.explained,
                         findings.empty() ? " none" : findings, states, d.seconds);
  return out;
}

}  // namespace

OutsideScore outside_score(const OutsideRequest& request, const std::string& arm, const std::string& cause,
                           unsigned seed) {
  return play_one(request, arm, cause, seed).score;
}

void play_outside(const OutsideRequest& request) {
  std::vector<Played> all;
  for (const std::string& name : request.causes.empty() ? outside_causes() : request.causes) {
    for (const std::string& arm : request.arms) {
      for (const unsigned seed : request.seeds) {
        try {
          all.push_back(play_one(request, arm, name, seed));
          fmt::print("{}\n", all.back().line);
          std::fflush(stdout);
        } catch (const std::exception& error) {
          fmt::print("{} {} {}: ERROR {}\n", arm, seed, name, error.what());
        }
      }
    }
  }
  print_outside(all);
}

}  // namespace veridyn::seek
