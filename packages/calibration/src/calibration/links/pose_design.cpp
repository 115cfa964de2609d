#include "veridyn/calibration/pose_design.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "veridyn/kinematics/motion_limits.hpp"
#include "calibration/links/link_selection.hpp"
#include "veridyn/math/random_numbers.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

using namespace internal;  // NOLINT: the parts of this very calibration

constexpr int kSweeps = 20;         // largest number of exchange sweeps
constexpr double kWorth = 1e-6;     // increase of the log determinant below which the exchange ends
constexpr double kSmallest = 1e-9;  // share of the candidates' information that keeps N regular

using RowsOfPose = MatrixXd;  // (6 x constants), divided by the standard deviations

class ExchangeDesign {
 public:
  ExchangeDesign(const std::vector<RowsOfPose>& rows, int poses, RandomNumbers& random) : rows_(rows) {
    const auto p = rows.front().cols();
    MatrixXd all = MatrixXd::Zero(p, p);
    for (const RowsOfPose& r : rows) all.noalias() += r.transpose() * r;
    scale_ = all.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    prior_ = kSmallest * MatrixXd::Identity(p, p);
    for (int k = 0; k < poses; ++k)
      chosen.push_back(static_cast<int>(random.uniform() * static_cast<double>(rows.size())));
    random_start_ = log_determinant(chosen);
  }

  // Replaces each pose in turn by the candidate that raises the determinant most.
  void improve() {
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
      bool better = false;
      for (std::size_t k = 0; k < chosen.size(); ++k) better = replace_pose(k) || better;
      if (!better) return;
    }
  }

  // Factor by which the geometric mean of the deviations falls.
  double gain() const {
    return std::exp(0.5 * (log_determinant(chosen) - random_start_) / static_cast<double>(scale_.size()));
  }

  MatrixXd information(const std::vector<int>& which) const {
    MatrixXd N = prior_;
    for (const int k : which) {
      const MatrixXd r = rows_[k] * scale_.asDiagonal();
      N.noalias() += r.transpose() * r;
    }
    return N;
  }

  std::vector<int> chosen;

 private:
  // Logarithm of the determinant of the information of these poses.
  double log_determinant(const std::vector<int>& which) const {
    const VectorXd d = information(which).ldlt().vectorD();
    return d.cwiseMax(1e-300).array().log().sum();
  }

  // Replaces chosen pose k by the best candidate, by det(N + r'r) = det(N) det(I + r N^-1 r'); false: it is the
  // best.
  bool replace_pose(std::size_t k) {
    std::vector<int> rest = chosen;
    rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(k));
    const Eigen::LDLT<MatrixXd> solver(information(rest));
    const auto worth = [&](int candidate) {
      const MatrixXd r = rows_[candidate] * scale_.asDiagonal();
      const MatrixXd M = MatrixXd::Identity(r.rows(), r.rows()) + r * solver.solve(r.transpose());
      return M.ldlt().vectorD().cwiseMax(1e-300).array().log().sum();
    };
    double best = worth(chosen[k]);
    const double start = best;
    for (int c = 0; c < static_cast<int>(rows_.size()); ++c) {
      const double one = worth(c);
      if (one <= best + kWorth) continue;
      best = one;
      chosen[k] = c;
    }
    return best > start + kWorth;
  }

  const std::vector<RowsOfPose>& rows_;
  VectorXd scale_;
  MatrixXd prior_;
  double random_start_ = 0.0;
};

// Orders the poses by nearest neighbour, in seconds at full speed.
void order_poses(const MotionLimits& limits, double rest, MatrixXd q, PoseDesign& out) {
  const auto seconds = [&](const VectorXd& a, const VectorXd& b) {
    return ((a - b).cwiseAbs().array() / limits.velocity.array()).maxCoeff();
  };
  out.q.resize(q.rows(), q.cols());
  out.time.resize(q.rows());
  VectorXd at = (0.5 * (limits.lower + limits.upper)).eval();
  double now = 0.0;
  for (Eigen::Index k = 0; k < q.rows(); ++k) {
    Eigen::Index best = k;
    for (Eigen::Index i = k; i < q.rows(); ++i) {
      if (seconds(q.row(i), at) < seconds(q.row(best), at)) best = i;
    }
    q.row(k).swap(q.row(best));
    // A smooth move between rests has twice the mean speed as its peak.
    now += 2.0 * seconds(q.row(k), at) + rest;
    at = q.row(k);
    out.q.row(k) = at;
    out.time[k] = now;
  }
}

// The named frame (nullopt: no such frame), or the last of the frames that most joints move.
std::optional<FrameIndex> tracked_frame(const Model& arm, const std::string& name) {
  if (!name.empty()) return arm.find_frame(name);
  FrameIndex best;
  int most = -1;
  for (int k = 0; k < static_cast<int>(arm.frames().size()); ++k) {
    int moved = 0;
    for (int i = 0; i < arm.joints(); ++i) moved += arm.moves({k}, {i}) ? 1 : 0;
    if (moved < most) continue;
    most = moved;
    best = {k};
  }
  return best;
}

}  // namespace

PoseDesign design_poses(const Model& arm, const PoseDesignOptions& options) {
  const std::optional<FrameIndex> frame = tracked_frame(arm, options.frame);
  require(frame.has_value(), "robot '", arm.name(), "': found no frame '", options.frame, "'.");
  PoseDesign out;
  out.robot = arm.name();
  out.frame = arm.frames()[frame->value].name;
  const MotionLimits limits = motion_limits(arm);
  const VectorXd middle = 0.5 * (limits.lower + limits.upper);
  const VectorXd half = 0.5 * options.limit_share * (limits.upper - limits.lower);
  RandomNumbers random(options.seed, 17);
  const LinkParameters parameters(arm, *frame, true, true, true);
  const LinkChain chain(parameters, Eigen::Isometry3d::Identity(), Eigen::Isometry3d::Identity());
  std::vector<VectorXd> q;
  std::vector<MatrixXd> full;
  LinkNormal normal{MatrixXd::Zero(parameters.size(), parameters.size()),
                    VectorXd::Zero(parameters.size()), 0.0, 0};
  for (int k = 0; k < options.candidates; ++k) {
    VectorXd one(arm.joints());
    // A third of the values are at a limit, because extremes have the most information.
    for (int i = 0; i < arm.joints(); ++i) {
      const double u = std::clamp(random.uniform(-1.5, 1.5), -1.0, 1.0);
      one[i] = middle[i] + u * half[i];
    }
    MatrixXd J;
    chain.pose(one, &J);
    J.topRows<3>() /= options.angle_noise;
    J.bottomRows<3>() /= options.position_noise;
    normal.N.noalias() += J.transpose() * J;
    q.push_back(std::move(one));
    full.push_back(std::move(J));
  }
  const LinkChoice choice = identifiable_links(parameters, normal);
  out.constants = static_cast<int>(choice.independent.size());
  if (6 * options.poses < out.constants) {
    out.reason = fmt::format("too few poses: {} for {} constants, and {} or more are needed",
                             options.poses, out.constants, (out.constants + 5) / 6);
    return out;
  }
  std::vector<RowsOfPose> rows;
  for (const MatrixXd& J : full) {
    rows.emplace_back(J.rows(), out.constants);
    for (int c = 0; c < out.constants; ++c)
      rows.back().col(c) = J.col(choice.independent[c]);
  }
  ExchangeDesign exchange(rows, options.poses, random);
  exchange.improve();
  out.gain = exchange.gain();
  MatrixXd poses(options.poses, arm.joints());
  LinkNormal designed{MatrixXd::Zero(parameters.size(), parameters.size()),
                      VectorXd::Zero(parameters.size()), 0.0, 0};
  for (int k = 0; k < options.poses; ++k) {
    const auto at = static_cast<std::size_t>(exchange.chosen[k]);
    poses.row(k) = q[at];
    designed.N.noalias() += full[at].transpose() * full[at];
  }
  const VectorXd s = standard_deviations(designed, choice.independent);
  for (int c = 0; c < out.constants; ++c) {
    const LinkParameter& p =
        parameters.all()[choice.independent[c]];
    out.predictions.push_back({p.frame.empty() ? p.name : p.name + " of " + p.frame, p.unit, s[c]});
  }
  order_poses(limits, options.rest, poses, out);
  out.status = CalibrationStatus::kDone;
  return out;
}

std::string PoseDesign::report() const {
  if (status != CalibrationStatus::kDone) return "Poses: " + reason + ".\n";
  std::string text = fmt::format(
      "{} poses of {} in {:.0f} s, for frame {}: {} constants; deviations {:.2f} times smaller than "
      "of as many random poses\n",
      q.rows(), robot, time[time.size() - 1], frame, constants, gain);
  for (const Prediction& p : predictions) {
    const bool metres = p.unit == "m";
    const bool angle = p.unit == "rad";
    text += fmt::format("  {:<28}+- {:.4f} {}\n", p.name,
                        p.deviation * (metres ? 1e3 : angle ? 180.0 / M_PI : 1.0),
                        metres ? "mm" : angle ? "deg" : "");
  }
  return text;
}

}  // namespace veridyn
