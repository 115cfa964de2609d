// Checks of recorded velocities against recorded positions, on the first rows of a recording.
#include <algorithm>
#include <cmath>

#include "recordings/quality/quality_checks.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::quality {
namespace {

// dq = factor * d/dt q, over windows of 0.1 s.
struct VelocityFit {
  double factor = 1.0;
  double spread = 0.0;  // half the interquartile range of the ratios of the windows
  bool clear = false;   // there are enough windows with motion, and their ratios agree
  bool zero = false;    // there are enough windows with motion, and dq is zero in them
  double correlation = 1.0;  // correlation of dq and the derivative of q over the windows with motion
};

// Fit of the velocity column `recorded` to the position of a joint.
VelocityFit velocity_fit(const Head& head, int joint, int recorded) {
  const Recording& rows = head.rows;
  const int window = window_rows(head);
  VectorXd angle = VectorXd::Zero(rows.rows());  // integral of dq
  struct Window {
    double moved, integrated;
  };
  std::vector<Window> windows;
  for (int k = 1; k < rows.rows(); ++k) {
    const double dt = rows.time[k] - rows.time[k - 1];
    const double step = 0.5 * dt * (rows.dq(k, recorded) + rows.dq(k - 1, recorded));
    angle[k] = angle[k - 1] + (std::isnan(step) ? 0.0 : step);
  }
  int last_gap = -1;  // windows must lie after it
  for (int k = 0; k < rows.rows(); ++k) {
    const bool hole = k > 0 && rows.time[k] - rows.time[k - 1] > numbers.gap * head.step;
    if (hole || std::isnan(rows.dq(k, recorded)) || std::isnan(rows.q(k, joint))) last_gap = k;
    if (k - window <= last_gap) continue;
    windows.push_back({rows.q(k, joint) - rows.q(k - window, joint), angle[k] - angle[k - window]});
  }
  std::vector<double> sizes;
  for (const Window& w : windows) sizes.push_back(std::abs(w.moved));
  const double fast = numbers.fast * quantile(std::move(sizes), 1.0 - numbers.fastest);
  windows.erase(std::remove_if(windows.begin(), windows.end(), [fast](const Window& w) { return !(std::abs(w.moved) > fast); }), windows.end());
  VelocityFit fit;
  if (static_cast<int>(windows.size()) < numbers.fewest_windows) return fit;
  std::vector<double> ratios;
  double both = 0.0, of_q = 0.0, of_dq = 0.0;
  for (const Window& w : windows) {
    ratios.push_back(w.integrated / w.moved);
    both += w.integrated * w.moved;
    of_q += w.moved * w.moved;
    of_dq += w.integrated * w.integrated;
  }
  if (of_dq > 0.0) fit.correlation = both / std::sqrt(of_q * of_dq);
  const double middle = quantile(ratios, 0.5);
  fit.spread = 0.5 * between_quantiles(ratios, kQuartile, 1.0 - kQuartile);
  double cross = 0.0, square = 0.0;
  for (const Window& w : windows) {
    if (std::abs(w.integrated / w.moved - middle) > numbers.outlying * fit.spread + kTinyRatio) continue;
    cross += w.integrated * w.moved;
    square += w.moved * w.moved;
  }
  fit.factor = square > 0.0 ? cross / square : middle;
  fit.clear = std::abs(fit.factor) > kTinyFactor && fit.spread < numbers.agree * std::abs(fit.factor);
  fit.zero = std::abs(fit.factor) <= kTinyFactor && fit.spread <= kTinyFactor;
  return fit;
}

// Reports a delay of the velocity; true if there is one.
bool check_delay(const Head& head, int joint, Findings* findings) {
  const std::optional<double> delay = velocity_delay(head, joint);
  if (!delay || std::abs(*delay) < numbers.delay_rows * head.step) return false;
  const Place place{"dq", joint + 1};
  findings->add(Severity::kWarning, "velocity_delay", place, {kNone, *delay, "s"},
                text("The velocity of ", named(place), " comes ", number(1e3 * std::abs(*delay)),
                     " ms ", *delay > 0.0 ? "later" : "earlier", " than its position says",
                     *delay > 0.0 ? ": a filter, or positions that were commanded and not measured?" : "."));
  return true;
}

// Reports quantisation of dq, by its steps between rows; stale rows and the rows after them are excluded.
void check_quantised(const Head& head, int joint, const VelocityFit& fit, double range, Findings* findings) {
  const auto dq = head.rows.dq.col(joint);
  std::vector<double> steps;
  std::vector<double> changes;
  for (int k = 2; k < dq.size(); ++k) {
    if (head.stale[k] || head.stale[k - 1]) continue;
    steps.push_back(std::abs(dq[k] - dq[k - 1]));
    if (steps.back() > 0.0) changes.push_back(steps.back());
  }
  if (!(range > 0.0) || static_cast<int>(changes.size()) < numbers.fewest_changes) return;
  const bool grid = quantile_exceeds(changes, numbers.ends, numbers.grid_share * numbers.coarse * range);
  const bool two_kinds = quantile_exceeds(steps, 1.0 - numbers.rare, numbers.coarse * range) &&
                         quantile_exceeds(steps, 1.0 - numbers.rare, numbers.two_kinds * quantile(steps, 0.5));
  if (!grid && !two_kinds) return;
  const double step = grid ? quantile(changes, numbers.ends) : quantile(steps, 1.0 - numbers.rare);
  const Place place{"dq", joint + 1};
  const bool biased = !fit.clear || std::abs(fit.factor - 1.0) > numbers.scale_error;
  findings->add(biased ? Severity::kWarning : Severity::kInfo, "velocity_quantised", place,
                {step / range, step, unit_of("dq")},
                text("The velocity of ", named(place), " goes in steps of about ", number(step),
                     ", ", percent(step / range), " of its range",
                     biased ? ": take it from the position instead." : ", but right on average."));
}

// Reports noise by second differences, which are small for smooth motion, of the velocity and of the
// position's derivative. Windows with stale rows are excluded.
void check_noise(const Head& head, int joint, double range, Findings* findings) {
  constexpr int kReach = 2;  // rows to either side that affect a second difference of a derivative
  const Recording& rows = head.rows;
  const auto derivative = [&](int k) {
    return (rows.q(k + 1, joint) - rows.q(k - 1, joint)) / (rows.time[k + 1] - rows.time[k - 1]);
  };
  double recorded = 0.0;
  double derived = 0.0;
  int windows = 0;
  for (int k = kReach; k + kReach < rows.rows(); ++k) {
    const auto first = head.stale.begin() + (k - kReach);
    if (std::find(first, first + 2 * kReach + 1, true) != first + 2 * kReach + 1) continue;
    const double of_dq = rows.dq(k + 1, joint) - 2.0 * rows.dq(k, joint) + rows.dq(k - 1, joint);
    const double of_q = derivative(k + 1) - 2.0 * derivative(k) + derivative(k - 1);
    if (!std::isfinite(of_dq) || !std::isfinite(of_q)) continue;
    recorded += of_dq * of_dq;
    derived += of_q * of_q;
    ++windows;
  }
  if (windows < numbers.fewest_windows) return;
  // The second difference of white noise has sqrt(6) times its standard deviation.
  const double noise = std::sqrt(recorded / (kSecondDifference * windows));
  const double ratio = std::sqrt(recorded / std::max(derived, 1e-300));
  if (ratio < numbers.noisier || noise < numbers.no_noise * range) return;
  const Place place{"dq", joint + 1};
  findings->add(Severity::kInfo, "velocity_noise", place, {noise / range, noise, unit_of("dq")},
                text("The velocity of ", named(place), " has noise of ", number(noise), ", ",
                     number(ratio), " times that of its position's derivative."));
}

void report_joint_scale(const Place& place, const VelocityFit& fit, Findings* findings) {
  const Size size{kNone, fit.factor, ""};
  if (fit.zero) {
    findings->add(Severity::kFault, "velocity_scale", place, size,
                  text("The velocity of ", named(place), " is zero while its position moves: take it from the position."));
  } else if (std::abs(fit.factor + 1.0) < numbers.sign_error) {
    findings->add(Severity::kFault, "velocity_sign", place, size,
                  text("The velocity of ", named(place),
                       " has the opposite sign of its position's derivative."));
  } else if (std::abs(std::abs(fit.factor) / kDegrees - 1.0) < numbers.degree_error) {
    findings->add(Severity::kFault, "degrees", place, size,
                  text("The velocity of ", named(place), " is ", number(fit.factor),
                       " times its position's derivative: deg/s instead of rad/s."));
  } else if (std::abs(std::abs(fit.factor) * kDegrees - 1.0) < numbers.degree_error) {
    findings->add(Severity::kFault, "degrees", {"q", place.joint}, size,
                  text("The position of joint ", place.joint, " changes ", number(1.0 / fit.factor),
                       " times faster than its velocity says: degrees instead of rad."));
  } else {
    findings->add(std::abs(fit.factor - 1.0) > numbers.far_off ? Severity::kFault : Severity::kWarning,
                  "velocity_scale", place, size,
                  text("The velocity of ", named(place), " is ", number(fit.factor),
                       " times its position's derivative: take it from the position."));
  }
}

// True if a position changes in one direction from row to row. The noise of a resting joint changes its sign,
// and poses at rest do not follow each other within a window.
bool is_steady_motion(const Head& head, int joint) {
  if (head.step >= numbers.window) return false;
  const auto q = head.rows.q.col(joint);
  double onward = 0.0;
  for (int k = 2; k < q.size(); ++k) {
    const double before = q[k - 1] - q[k - 2];
    const double after = q[k] - q[k - 1];
    if (std::isfinite(before) && std::isfinite(after)) onward += before * after;
  }
  return onward > 0.0;
}

// Reports factors of the velocities: the same factor on all joints indicates the clock (or the unit), others
// single channels.
void report_scales(const Head& head, const std::vector<int>& joints,
                   const std::vector<VelocityFit>& fits, Findings* findings) {
  double low = INFINITY;
  double high = -INFINITY;
  std::vector<double> factors;
  for (const VelocityFit& fit : fits) {
    low = std::min(low, fit.factor);
    high = std::max(high, fit.factor);
    factors.push_back(fit.factor);
  }
  if (fits.empty()) return;
  const double common = quantile(factors, 0.5);
  // A single joint indicates a wrong clock only if its factor is far from one.
  const double threshold = fits.size() > 1 ? numbers.scale_error : numbers.clock_error;
  const bool clock =
      common > 0.0 && high - low < numbers.one_clock * common && std::abs(common - 1.0) > threshold &&
      std::abs(common / kDegrees - 1.0) > numbers.degree_error && std::abs(common * kDegrees - 1.0) > numbers.degree_error;
  if (clock) {
    findings->add(Severity::kFault, "rate_contradiction", {}, {kNone, common, ""},
                  text("Recorded velocities are ", number(common), " times the derivative of the positions on every moving joint: ",
                       std::abs(common / kMinute - 1.0) < numbers.degree_error ? "turns, and turns a minute? --units q=rev,dq=rpm."
                       : std::abs(common / kTurnsAMinute - 1.0) < numbers.degree_error
                           ? std::string("turns a minute? --units dq=rpm.")
                           : text("the clock is off, and the true rate is ", number(common / head.step), " Hz rather than ", number(1.0 / head.step),
                                  " Hz (or all velocities are in another unit).")));
    return;
  }
  for (std::size_t f = 0; f < fits.size(); ++f) {
    if (std::abs(fits[f].factor - 1.0) > numbers.scale_error)
      report_joint_scale({"dq", joints[f] + 1}, fits[f], findings);
  }
}

}  // namespace

void check_velocities(const Head& head, Findings* findings) {
  if (head.rows.dq.cols() == 0) return;
  std::vector<int> joints;
  std::vector<VelocityFit> fits;
  for (int j = 0; j < head.rows.joints(); ++j) {
    if (!head.moves[j]) continue;
    const VelocityFit fit = velocity_fit(head, j, j);
    if (fit.zero && is_steady_motion(head, j)) report_joint_scale({"dq", j + 1}, fit, findings);
    const double range = range_of(head.rows.dq, j);
    check_quantised(head, j, fit, range, findings);
    if (!fit.clear && std::abs(fit.correlation) < numbers.related && is_steady_motion(head, j)) {
      const Place place{"dq", j + 1};
      std::string way = "take it from the position.";
      for (int other = 0; other < head.rows.joints(); ++other) {
        if (velocity_fit(head, j, other).clear) way = text("that of joint ", other + 1, " is; --map dq", j + 1, "=dq", other + 1, " mends it.");
      }
      findings->add(Severity::kFault, "velocity_unrelated", place, {kNone, fit.correlation, ""},
                    text("The velocity of ", named(place), " is not the derivative of its position (correlation ", number(fit.correlation), "): ", way));
    }
    if (!fit.clear) continue;
    if (std::abs(fit.factor - 1.0) <= numbers.scale_error) check_noise(head, j, range, findings);
    joints.push_back(j);
    fits.push_back(fit);
    // A delay reduces the factor, by the cosine of its phase at the frequency of the motion.
    if (check_delay(head, j, findings) && fit.factor < 1.0 && fit.factor > 1.0 - numbers.clock_error) {
      joints.pop_back();
      fits.pop_back();
    }
  }
  report_scales(head, joints, fits, findings);
}

}  // namespace veridyn::quality
