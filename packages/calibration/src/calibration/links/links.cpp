#include "veridyn/calibration/links.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <memory>

#include "veridyn/math/median.hpp"
#include "calibration/contradiction.hpp"
#include "calibration/deviations.hpp"
#include "calibration/links/link_selection.hpp"
#include "calibration/links/links_numbers.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

using namespace internal;  // NOLINT: the parts of this very calibration
using Kind = LinkParameter::Kind;

constexpr double kSameGain = 1e-6;             // relative difference of equal gains_of_adding
constexpr int kHeldOutBlocks = 80;
constexpr double kNoise = 1e-9;  // [m] smaller differences of constants are rounding

// The last frame that no other has more joints before.
FrameIndex most_distal_frame(const Model& arm) {
  std::vector<int> depth(arm.frames().size(), 0);
  FrameIndex best;
  for (int k = 0; k < static_cast<int>(depth.size()); ++k) {
    for (int i = 0; i < arm.joints(); ++i) depth[k] += arm.moves({k}, {i}) ? 1 : 0;
    if (depth[k] >= depth[best.value]) best = {k};
  }
  return best;
}

// One hypothesis about base and tool, with its parameters and their full fit.
struct Attachment {
  bool base_free = false, tool_free = false;
  std::unique_ptr<LinkParameters> parameters;
  std::unique_ptr<LinkChain> chain;
  LinkData data;
  LinkChoice choice;
  VectorXd start, x;  // base and tool fitted alone; all identifiable parameters fitted
  std::vector<int> attached;  // parameters of base and tool
};

std::vector<int> every_row(int frames) {
  std::vector<int> out(frames);
  for (int k = 0; k < frames; ++k) out[k] = k;
  return out;
}

// Fits the robot with base and tool free or at the file's poses, and finds its identifiable constants.
Attachment fit_attachment(const Model& arm, FrameIndex frame, const PoseCapture& poses, bool base_free,
                  bool tool_free, const LinksOptions& options) {
  Attachment a;
  a.base_free = base_free;
  a.tool_free = tool_free;
  a.parameters = std::make_unique<LinkParameters>(arm, frame, base_free, tool_free,
                                                  poses.has_orientation);
  Eigen::Isometry3d base;
  Eigen::Isometry3d tool;
  estimate_attached_poses(arm, frame, poses, base_free, tool_free, base, tool);
  a.chain = std::make_unique<LinkChain>(*a.parameters, base, tool);
  a.data.poses = &poses;
  a.data.rows = every_row(poses.frames());
  a.data.is_outlier.assign(static_cast<std::size_t>(poses.frames()), 0);
  for (int k = 0; k < a.parameters->size(); ++k) {
    const Kind kind = a.parameters->all()[k].kind;
    if (kind == Kind::kBase || kind == Kind::kTool) a.attached.push_back(k);
  }
  a.start = VectorXd::Zero(a.parameters->size());
  a.start = robustly_fitted_links(*a.chain, a.data, a.attached, a.start, options.outlier);
  // Finds the identifiable constants with the noise of a full fit.
  std::fill(a.data.is_outlier.begin(), a.data.is_outlier.end(), 0);
  for (int round = 0; round < 2; ++round) {
    const LinkNormal normal = link_normal(*a.chain, a.data, round == 0 ? a.start : a.x);
    // The residual includes wrong constants at first, so that only rank decides.
    a.choice = identifiable_links(*a.parameters, normal, round > 0);
    VectorXd from = round == 0 ? a.start : a.x;
    for (int k = 0; k < from.size(); ++k) {
      if (!std::binary_search(a.choice.independent.begin(), a.choice.independent.end(), k))
        from[k] = 0.0;
    }
    a.x = robustly_fitted_links(*a.chain, a.data, a.choice.independent, from, options.outlier);
  }
  return a;
}

// True if the median errors of the unmodified robot are below near_position and near_angle.
bool is_near_file(const Model& arm, FrameIndex frame, const PoseCapture& poses) {
  const LinkParameters none(arm, frame, false, false, true);
  LinkChain chain(none, Eigen::Isometry3d::Identity(), Eigen::Isometry3d::Identity());
  LinkData data;
  data.poses = &poses;
  data.rows = every_row(poses.frames());
  LinkErrors errors = link_errors(chain, data, VectorXd::Zero(none.size()));
  return median(errors.position) < links_numbers.near_position &&
         (!poses.has_orientation || median(errors.angle) < links_numbers.near_angle);
}

// The requested assumption about base and tool; if automatic, both as in the file if that fits as well, else
// free.
Attachment chosen_attachment(const Model& arm, FrameIndex frame, const PoseCapture& poses,
                             const LinksOptions& options) {
  const auto is = [](AttachedPose p, AttachedPose q) { return p == q; };
  const bool open = is(options.base, AttachedPose::kAutomatic) ||
                    is(options.tool, AttachedPose::kAutomatic);
  const auto with = [&](bool automatic) {
    const bool base = is(options.base, AttachedPose::kAutomatic)
                          ? automatic
                          : is(options.base, AttachedPose::kFree);
    const bool tool = is(options.tool, AttachedPose::kAutomatic)
                          ? automatic
                          : is(options.tool, AttachedPose::kFree);
    return fit_attachment(arm, frame, poses, base, tool, options);
  };
  if (!open) return with(false);
  Attachment free = with(true);
  if (!is_near_file(arm, frame, poses)) return free;
  Attachment known = with(false);
  const bool as_good =
      known.data.noise.position <= links_numbers.as_good * free.data.noise.position + kNoise &&
      known.data.noise.angle <= links_numbers.as_good * free.data.noise.angle + kNoise;
  return as_good ? std::move(known) : std::move(free);
}

// The smallest set of constants, in addition to base and tool, that explains the poses as well as all of them
// do.
struct Explanation {
  bool complete = false;
  std::vector<int> named;
  std::vector<std::string> rivals;  // for each named constant: others that smallest_explanation the poses nearly as well
  VectorXd x;
};

// Both sets in ascending order.
std::vector<int> joined(const std::vector<int>& a, const std::vector<int>& b) {
  std::vector<int> out = a;
  out.insert(out.end(), b.begin(), b.end());
  std::sort(out.begin(), out.end());
  return out;
}

// Relative change of a constant. An encoder zero comes before all other constants, constants that are zero by
// design after them.
double relative_change(const LinkParameter& p, const LinkGain& gain) {
  constexpr double kNever = std::numeric_limits<double>::infinity();
  if (p.kind == Kind::kZero && std::abs(gain.step) < (p.is_angle() ? links_numbers.homed_angle : links_numbers.homed_position))
    return 0.0;
  if (std::abs(p.file) < kNoise) return kNever;
  const double change = std::abs(gain.step / p.file);
  if (p.kind != Kind::kConstant) return change;
  // A constant that would change by more than half is probably not the wrong one.
  return change > links_numbers.misplaced ? kNever : links_numbers.preferred * change;
}

// Counts how many of base and tool are at the file's poses when these parameters are fitted.
int attached_as_in_file(Attachment& a, const std::vector<int>& active, const VectorXd& x,
                        double correlation) {
  const VectorXd s = standard_deviations(link_normal(*a.chain, a.data, x), active);
  bool base = true;
  bool tool = true;
  for (std::size_t k = 0; k < active.size(); ++k) {
    const LinkParameter& p = a.parameters->all()[active[k]];
    if (p.kind != Kind::kBase && p.kind != Kind::kTool) continue;
    const Eigen::Isometry3d& T = p.kind == Kind::kBase ? a.chain->base() : a.chain->tool();
    const double off = p.index < 3 ? rotation_vector(T.linear())[p.index]
                                   : T.translation()[p.index - 3];
    if (std::abs(off) > links_numbers.significant * std::sqrt(correlation) * s[static_cast<Eigen::Index>(k)])
      (p.kind == Kind::kBase ? base : tool) = false;
  }
  return static_cast<int>(base) + static_cast<int>(tool);
}

// Index of the constant with the largest gain; -1: no gain. Among equal gains: those with which base and tool
// are at the file's poses; of these the one with the smallest relative change, named ones preferred; else the
// first in the file's order. The others are named in `rivals`.
int constant_with_largest_gain(Attachment& a, const std::vector<int>& active, const std::vector<LinkGain>& gain,
              const VectorXd& x, double correlation, std::string& rivals) {
  const std::vector<LinkParameter>& all = a.parameters->all();
  double most = 0.0;
  for (const LinkGain& g : gain) most = std::max(most, g.gain);
  rivals.clear();
  if (most == 0.0) return -1;
  std::vector<int> equal;
  for (int k = 0; k < a.parameters->size(); ++k) {
    if (gain[k].gain >= (1.0 - kSameGain) * most) equal.push_back(k);
  }
  int best = -1;
  int in_file = 0;
  double change = 0.0;
  for (const int k : equal) {
    int own_in_file = 0;
    if (equal.size() > 1 && !a.attached.empty()) {
      const std::vector<int> with = joined(active, {k});
      own_in_file = attached_as_in_file(a, with, fitted_links(*a.chain, a.data, with, x, 0.0),
                                        correlation);
    }
    const double own = relative_change(all[k], gain[k]);
    if (best >= 0 && (own_in_file < in_file || (own_in_file == in_file && !(own < change)))) continue;
    best = k;
    in_file = own_in_file;
    change = own;
  }
  for (int k = 0; k < a.parameters->size(); ++k) {
    if (k == best || gain[k].gain < links_numbers.rival * most) continue;
    rivals += (rivals.empty() ? "" : ", ") + all[k].full_name();
  }
  return best;
}

// Drops constants that a later one made superfluous.
void drop_redundant(Attachment& a, Explanation& e, double correlation) {
  for (std::size_t k = 0; k < e.named.size() && e.named.size() > 1;) {
    const std::vector<int> active = joined(a.attached, e.named);
    const VectorXd s = standard_deviations(link_normal(*a.chain, a.data, e.x), active);
    const auto at = std::find(active.begin(), active.end(), e.named[k]) - active.begin();
    if (std::abs(e.x[e.named[k]]) > links_numbers.significant * std::sqrt(correlation) * s[at]) {
      ++k;
      continue;
    }
    e.x[e.named[k]] = 0.0;
    e.named.erase(e.named.begin() + static_cast<std::ptrdiff_t>(k));
    e.rivals.erase(e.rivals.begin() + static_cast<std::ptrdiff_t>(k));
    e.x = fitted_links(*a.chain, a.data, joined(a.attached, e.named), e.x, 0.0);
    k = 0;
  }
}

Explanation smallest_explanation(Attachment& a, const LinksOptions& options, double correlation) {
  Explanation e;
  const double best = link_normal(*a.chain, a.data, a.x).chi2;
  e.x = a.start;
  for (;;) {
    const std::vector<int> active = joined(a.attached, e.named);
    e.x = fitted_links(*a.chain, a.data, active, e.x, 0.0);
    const LinkNormal normal = link_normal(*a.chain, a.data, e.x);
    const double rest = (normal.chi2 - best) / correlation;
    const double freedom =
        std::max(1.0, 1.0 * a.choice.independent.size() - 1.0 * active.size());
    const double scale =
        best / std::max(1.0, 1.0 * normal.residuals - 1.0 * a.choice.independent.size());
    if (rest / scale < freedom + 4.0 * std::sqrt(2.0 * freedom)) {
      e.complete = true;
      break;
    }
    if (static_cast<int>(e.named.size()) >= options.most_named) break;
    std::string rivals;
    const int next = constant_with_largest_gain(a, active, gains_of_adding(normal, active), e.x, correlation, rivals);
    if (next < 0) break;
    e.named.push_back(next);
    e.rivals.push_back(rivals);
  }
  if (e.complete) drop_redundant(a, e, correlation);
  return e;
}

// Frames of contiguous segments, every fourth of which is held out.
std::vector<int> segment_frames(int frames, bool held_out) {
  const int length = std::max(1, frames / kHeldOutBlocks);
  std::vector<int> out;
  for (int k = 0; k < frames; ++k) {
    if (((k / length) % 4 == 2) == held_out) out.push_back(k);
  }
  return out;
}

// Sets the held-out errors of `out`, after a fit of the active parameters to the other segments.
void evaluate_held_out(Attachment& a, const std::vector<int>& active, const VectorXd& x,
              LinksCalibration& out) {
  LinkData train = a.data;
  train.rows = segment_frames(out.frames, false);
  LinkData test = a.data;
  test.rows = segment_frames(out.frames, true);
  const VectorXd learned = fitted_links(*a.chain, train, active, x, 0.0);
  const LinkErrors errors = link_errors(*a.chain, test, learned);
  out.held_out_rms = rms_of(errors.position, test, false);
  out.held_out_rms_all = rms_of(errors.position, test, true);
  out.held_out_angle = rms_of(errors.angle, test, false);
  const VectorXd file = fitted_links(*a.chain, train, a.attached, a.start, 0.0);
  out.held_out_rms_file = rms_of(link_errors(*a.chain, test, file).position, test, false);
}

// correlation_factor() of the position residuals, without outliers.
double serial_correlation(Attachment& a) {
  const LinkErrors errors = link_errors(*a.chain, a.data, a.x);
  // Signed residuals, by component.
  std::vector<std::vector<double>> series(3);
  for (const int row : a.data.rows) {
    const auto at = static_cast<std::size_t>(row);
    const Eigen::Vector3d r =
        a.chain->pose(a.data.poses->q.row(row), nullptr).translation() -
        a.data.poses->poses[at].translation();
    for (int c = 0; c < 3; ++c)
      series[c].push_back(a.data.is_outlier[at] != 0 ? std::nan("")
                                                                              : r[c]);
  }
  return correlation_factor(series);
}

// Appends every parameter with its 95 % interval, and the reason if it is not identifiable, to out.constants.
void list_constants(const Attachment& a, const Explanation& e, const std::vector<int>& active,
                    const VectorXd& x, LinksCalibration& out) {
  const LinkNormal normal = link_normal(*a.chain, a.data, x);
  const VectorXd s = standard_deviations(normal, active);
  const std::vector<LinkGain> more = gains_of_adding(normal, active);
  const double dof =
      std::max(1.0, (normal.residuals - 1.0 * active.size()) / out.correlation);
  const double scale = std::sqrt(
      normal.chi2 / std::max(1.0, normal.residuals - 1.0 * active.size()) * out.correlation);
  for (int k = 0; k < a.parameters->size(); ++k) {
    const LinkParameter& p = a.parameters->all()[k];
    LinkConstant c;
    c.name = p.name;
    c.frame = p.frame;
    c.unit = p.unit;
    c.file = p.file;
    c.found = p.file + x[k];
    c.why = a.choice.why[k];
    const auto at = std::find(active.begin(), active.end(), k);
    double centre = c.found;
    double deviation = 0.0;
    if (at != active.end()) {
      c.why.clear();
      deviation = s[at - active.begin()];
      c.changed = p.kind != Kind::kBase && p.kind != Kind::kTool;
    } else {
      const LinkGain& one = more[k];
      centre += one.step;
      deviation = one.deviation;
    }
    if (c.why.empty() && deviation <= 0.0) {  // a named constant replaces it
      for (const int n : e.named)
        c.why += (c.why.empty() ? "cannot be told from " : ", ") +
                 a.parameters->all()[n].full_name();
    }
    c.identifiable = c.why.empty();
    const double half = deviation > 0.0 ? half_width(std::pow(scale * deviation, 2.0), dof)
                                        : std::numeric_limits<double>::infinity();
    c.low = centre - half;
    c.high = centre + half;
    for (std::size_t n = 0; n < e.named.size(); ++n) {
      if (e.complete && e.named[n] == k && !e.rivals[n].empty())
        c.why = "explains the poses no better than " + e.rivals[n] + " would";
    }
    out.constants.push_back(c);
  }
}

// Text on the first joint outside of its limits, which may be recorded in other units; empty if there is none.
std::string beyond_limits_text(const Model& arm, const PoseCapture& poses) {
  for (int i = 0; i < arm.joints(); ++i) {
    const Coordinate& c = arm.coordinates()[i];
    const double low = poses.q.col(i).minCoeff();
    const double high = poses.q.col(i).maxCoeff();
    if (low >= c.limits.lower && high <= c.limits.upper) continue;
    return fmt::format(": {} goes from {:.4g} to {:.4g} {}, beyond its limits", c.name, low, high,
                       c.prismatic ? "m" : "rad");
  }
  return "";
}

// Reason for which the fit is invalid: the poses are not those of this frame at these joint positions.
std::string wrong_frame_reason(const Model& arm, const Attachment& a, const std::string& frame, const LinkErrors& errors) {
  const auto outliers = static_cast<int>(std::count(a.data.is_outlier.begin(), a.data.is_outlier.end(), 1));
  const double angle = a.data.poses->has_orientation ? rms_of(errors.angle, a.data, false) : 0.0;
  const std::string why =
      contradiction_reason(a.data.poses->poses, {outliers, rms_of(errors.position, a.data, false), angle});
  if (why.empty()) return "";
  return why + "; they may be poses of another frame than " + frame + ", joints of other rows, or not in rad and m" +
         beyond_limits_text(arm, *a.data.poses);
}

// Reason if there is no pose, too few of them, or a joint that rests; else empty.
std::string insufficient_poses_reason(const Model& arm, const PoseCapture& poses, int fewest) {
  if (!poses.fault.empty()) return poses.fault;
  if (poses.frames() < fewest)
    return fmt::format("too few frames: {} with a pose and all joints, and {} or more are needed",
                       poses.frames(), fewest);
  const VectorXd range = poses.q.colwise().maxCoeff() - poses.q.colwise().minCoeff();
  std::string still;
  for (int i = 0; i < arm.joints(); ++i) {
    const Coordinate& c = arm.coordinates()[i];
    if (range[i] > (c.prismatic ? 1e-3 : 0.01)) return "";
    still += (still.empty() ? "" : ", ") + c.name;
  }
  return "no joint moves (" + still + "): poses that differ are missing";
}

}  // namespace

LinksCalibration calibrate_links(const Model& arm, const PoseCapture& poses, const LinksOptions& options) {
  const auto began = std::chrono::steady_clock::now();
  require(poses.q.cols() == arm.joints(), poses.source, ": found ",
          poses.q.cols() == 0 ? std::string("no columns of joints")
                              : text("joints q1 to q", poses.q.cols()),
          ", expected q1 to q", arm.joints(), " of robot '", arm.name(), "'.");
  const std::optional<FrameIndex> frame = options.frame.empty() ? most_distal_frame(arm) : arm.find_frame(options.frame);
  require(frame.has_value(), "robot '", arm.name(), "': found no frame '", options.frame, "'.");
  LinksCalibration out;
  out.robot = arm.name();
  out.source = poses.source;
  out.frame = arm.frames()[frame->value].name;
  out.frames = poses.frames();
  out.reason = insufficient_poses_reason(arm, poses, links_numbers.fewest_frames);
  if (!out.reason.empty()) return out;
  Attachment a = chosen_attachment(arm, *frame, poses, options);
  out.base_free = a.base_free;
  out.tool_free = a.tool_free;
  out.rank_gap = a.choice.rank_gap;
  out.reason = wrong_frame_reason(arm, a, out.frame, link_errors(*a.chain, a.data, a.x));
  if (!out.reason.empty()) return out;
  if (a.choice.independent.size() <= a.attached.size()) {
    out.reason = "no constant of the robot can be told from these poses: motion of more joints is "
                 "missing";
    return out;
  }
  const double unknowns = static_cast<double>(a.choice.independent.size());
  const double rows = (poses.has_orientation ? 6.0 : 3.0) * poses.frames();
  if (rows < 2.0 * unknowns) {
    out.reason = fmt::format("too few frames: {} for {} unknowns, and {} or more are needed",
                             poses.frames(), unknowns,
                             std::ceil(2.0 * unknowns * poses.frames() / rows));
    return out;
  }
  out.correlation = serial_correlation(a);
  const Explanation e = smallest_explanation(a, options, out.correlation);
  out.explained = e.complete;
  const std::vector<int> active =
      e.complete ? joined(a.attached, e.named) : joined({}, a.choice.independent);
  const VectorXd x = e.complete ? e.x : a.x;
  evaluate_held_out(a, active, x, out);
  list_constants(a, e, active, x, out);
  if (e.complete) out.named = e.named;
  const LinkErrors errors = link_errors(*a.chain, a.data, x);
  out.residuals = errors.position;
  out.residual_angles = errors.angle;
  out.rms = rms_of(errors.position, a.data, false);
  out.rms_angle = rms_of(errors.angle, a.data, false);
  out.base = a.chain->base();
  out.tool = a.chain->tool();
  out.rms_file = rms_of(link_errors(*a.chain, a.data, a.start).position, a.data, false);
  out.outliers = static_cast<int>(
      std::count(a.data.is_outlier.begin(), a.data.is_outlier.end(), 1));
  for (const Eigen::Isometry3d& T : poses.poses) out.positions.emplace_back(T.translation());
  out.joints = poses.q;
  out.model = a.parameters->arm_with(x);
  out.status = CalibrationStatus::kDone;
  out.seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  return out;
}

}  // namespace veridyn
