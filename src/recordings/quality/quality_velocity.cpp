// Checks of recorded velocities against recorded positions, on the first rows of a recording.
#include <algorithm>
#include <cmath>

#include "recordings/quality/quality_checks.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::quality {
namespace {

// Fit of dq = factor * d/dt q, over windows of 0.1 s.
struct VelocityFit {
  int joint = 0;
  double factor = 1.0;
  double spread = 0.0;  // half the interquartile range of the ratios of the windows
  bool clear = false;   // there are enough windows with motion, and their ratios agree
  bool zero = false;    // there are enough windows with motion, and dq is zero in them
  double correlation = 1.0;  // correlation of dq and the derivative of q over the windows with motion
};

// The change of a position in a window, and the integral of a velocity.
struct Window {
  double moved, integrated;
};

// All windows without a gap; each is listed by the row at which it ends.
std::vector<Window> windows_of(const Head& head, int joint, int recorded) {
  const VectorXd& time = head.rows.time;
  const auto q = head.rows.q.col(joint), dq = head.rows.dq.col(recorded);
  const int window = window_rows(head);
  VectorXd angle = VectorXd::Zero(time.size());  // integral of dq
  std::vector<Window> windows;
  int last_gap = -1;  // windows must begin after this row
  for (int k = 0; k < time.size(); ++k) {
    const double dt = k > 0 ? time[k] - time[k - 1] : 0.0;
    if (k > 0) {
      const double step = 0.5 * dt * (dq[k] + dq[k - 1]);
      angle[k] = angle[k - 1] + (std::isnan(step) ? 0.0 : step);
    }
    if (dt > numbers.gap * head.step || std::isnan(dq[k]) || std::isnan(q[k])) last_gap = k;
    if (k - window > last_gap) windows.push_back({q[k] - q[k - window], angle[k] - angle[k - window]});
  }
  return windows;
}

// Fit of the velocity column `recorded` to the position of a joint.
VelocityFit velocity_fit(const Head& head, int joint, int recorded) {
  std::vector<Window> windows = windows_of(head, joint, recorded);
  std::vector<double> sizes, ratios;
  for (const Window& w : windows) sizes.push_back(std::abs(w.moved));
  const double fast = numbers.fast * quantile(std::move(sizes), 1.0 - numbers.fastest);
  windows.erase(std::remove_if(windows.begin(), windows.end(), [fast](const Window& w) { return !(std::abs(w.moved) > fast); }), windows.end());
  VelocityFit fit;
  fit.joint = joint;
  if (static_cast<int>(windows.size()) < numbers.fewest_windows) return fit;
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

Channel velocity_of(int joint) {
  return {&kRecordingSignals[1], joint};
}

// Reports a delay of the velocity; true if there is one.
bool check_delay(const Head& head, int joint, Findings* findings) {
  const std::optional<double> delay = velocity_delay(head, joint);
  if (!delay || std::abs(*delay) < numbers.delay_rows * head.step) return false;
  const Channel dq = velocity_of(joint);
  findings->add(Severity::kWarning, QualityKind::kVelocityDelay, dq.place(), {kNone, *delay, "s"},
                text("The velocity of ", dq.name(), " comes ", number(1e3 * std::abs(*delay)),
                     " ms ", *delay > 0.0 ? "later" : "earlier", " than its position says",
                     *delay > 0.0 ? ": a filter, or positions that were commanded and not measured?" : "."));
  return true;
}

// Reports quantisation of dq, by its steps between rows; stale rows and the rows after them are excluded.
void check_quantised(const Head& head, const VelocityFit& fit, double range, Findings* findings) {
  const Channel channel = velocity_of(fit.joint);
  const auto dq = channel.of(head.rows);
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
  const bool biased = !fit.clear || std::abs(fit.factor - 1.0) > numbers.scale_error;
  findings->add(biased ? Severity::kWarning : Severity::kInfo, QualityKind::kVelocityQuantised, channel.place(), {step / range, step, channel.unit()},
                text("The velocity of ", channel.name(), " goes in steps of about ", number(step), ", ", percent(step / range), " of its range",
                     biased ? ": take it from the position instead." : ", but right on average."));
}

// Reports noise by second differences, which are small for smooth motion, of the velocity and of the
// position's derivative. Windows with stale rows are excluded.
void check_noise(const Head& head, int joint, double range, Findings* findings) {
  constexpr int kReach = 2;  // rows to either side that affect a second difference of a derivative
  const VectorXd& time = head.rows.time;
  const Channel channel = velocity_of(joint);
  const auto q = head.rows.q.col(joint), dq = channel.of(head.rows);
  const auto derivative = [&](int k) { return (q[k + 1] - q[k - 1]) / (time[k + 1] - time[k - 1]); };
  double recorded = 0.0, derived = 0.0;
  int windows = 0;
  for (int k = kReach; k + kReach < time.size(); ++k) {
    const auto first = head.stale.begin() + (k - kReach);
    if (std::find(first, first + 2 * kReach + 1, true) != first + 2 * kReach + 1) continue;
    const double of_dq = dq[k + 1] - 2.0 * dq[k] + dq[k - 1];
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
  findings->add(Severity::kInfo, QualityKind::kVelocityNoise, channel.place(), {noise / range, noise, channel.unit()},
                text("The velocity of ", channel.name(), " has noise of ", number(noise), ", ", number(ratio),
                     " times that of its position's derivative."));
}

// True if a factor equals `unit` within QualityNumbers::degree_error.
bool is_near(double factor, double unit) {
  return std::abs(factor / unit - 1.0) < numbers.degree_error;
}

void report_joint_scale(const VelocityFit& fit, Findings* findings) {
  const double f = fit.factor;
  const auto add = [&](Severity severity, QualityKind kind, const char* signal, const std::string& sentence) {
    findings->add(severity, kind, {signal, JointIndex{fit.joint}}, {kNone, f, ""}, sentence);
  };
  const std::string velocity = "The velocity of " + velocity_of(fit.joint).name();
  if (fit.zero) return add(Severity::kFault, QualityKind::kVelocityScale, "dq", velocity + " is zero while its position moves: take it from the position.");
  if (std::abs(f + 1.0) < numbers.sign_error)
    return add(Severity::kFault, QualityKind::kVelocitySign, "dq", velocity + " has the opposite sign of its position's derivative.");
  const std::string times = text(velocity, " is ", number(f), " times its position's derivative: ");
  if (is_near(std::abs(f), kDegrees)) return add(Severity::kFault, QualityKind::kDegrees, "dq", times + "deg/s instead of rad/s.");
  if (is_near(std::abs(f) * kDegrees, 1.0))
    return add(Severity::kFault, QualityKind::kDegrees, "q", text("The position of joint ", fit.joint + 1, " changes ", number(1.0 / f),
                                                      " times faster than its velocity says: degrees instead of rad."));
  add(std::abs(f - 1.0) > numbers.far_off ? Severity::kFault : Severity::kWarning, QualityKind::kVelocityScale, "dq", times + "take it from the position.");
}

// Reports factors of the velocities. The same factor on all joints is attributed to the clock (or the unit),
// different ones to single channels.
// @param related  the velocity of every joint is that of its position: no clock explains others.
void report_scales(const Head& head, const std::vector<VelocityFit>& fits, bool related, Findings* findings) {
  if (fits.empty()) return;
  std::vector<double> factors;
  for (const VelocityFit& fit : fits) factors.push_back(fit.factor);
  const auto [low, high] = std::minmax_element(factors.begin(), factors.end());
  const double common = quantile(factors, 0.5);
  // With a single joint, a factor near one may be the fault of its sensor rather than of the clock.
  const double threshold = fits.size() > 1 ? numbers.scale_error : numbers.clock_error;
  const bool clock = related && common > 0.0 && *high - *low < numbers.one_clock * common && std::abs(common - 1.0) > threshold &&
                     std::abs(common / kDegrees - 1.0) > numbers.degree_error && std::abs(common * kDegrees - 1.0) > numbers.degree_error;
  if (!clock) {
    for (const VelocityFit& fit : fits) {
      if (std::abs(fit.factor - 1.0) > numbers.scale_error) report_joint_scale(fit, findings);
    }
    return;
  }
  findings->add(Severity::kFault, QualityKind::kRateContradiction, {}, {kNone, common, ""},
                text("Recorded velocities are ", number(common), " times the derivative of the positions on every moving joint: ",
                     is_near(common, kMinute)          ? "turns, and turns a minute? --units q=rev,dq=rpm."
                     : is_near(common, kTurnsAMinute) ? std::string("turns a minute? --units dq=rpm.")
                                                      : text("the clock is off, and the true rate is ", number(common / head.step), " Hz rather than ",
                                                             number(1.0 / head.step), " Hz (or all velocities are in another unit).")));
}

// Reports a velocity that is not the derivative of its joint's position, and the joint whose velocity is.
void report_unrelated(const Head& head, const VelocityFit& fit, Findings* findings) {
  const Channel dq = velocity_of(fit.joint);
  std::string way = "take it from the position.";
  for (int other = 0; other < head.rows.joints(); ++other) {
    if (velocity_fit(head, fit.joint, other).clear)
      way = text("that of joint ", other + 1, " is; --map dq", fit.joint + 1, "=dq", other + 1, " mends it.");
  }
  findings->add(Severity::kFault, QualityKind::kVelocityUnrelated, dq.place(), {kNone, fit.correlation, ""},
                text("The velocity of ", dq.name(), " is not the derivative of its position (correlation ", number(fit.correlation), "): ", way));
}

}  // namespace

void check_velocities(const Head& head, Findings* findings) {
  std::vector<VelocityFit> fits;
  bool related = true;
  for (int j = 0; j < head.rows.dq.cols(); ++j) {
    if (!head.moves[j]) continue;
    const VelocityFit fit = velocity_fit(head, j, j);
    // A recording of poses at rest is excluded, since successive poses are no motion.
    const bool steady = head.step < numbers.window && mean_step_product(head.rows.q.col(j)) > 0.0;
    if (fit.zero && steady) report_joint_scale(fit, findings);
    const double range = range_of(head.rows.dq.col(j));
    check_quantised(head, fit, range, findings);
    if (!fit.clear && std::abs(fit.correlation) < numbers.related && steady) {
      report_unrelated(head, fit, findings);
      related = false;
    }
    if (!fit.clear) continue;
    if (std::abs(fit.factor - 1.0) <= numbers.scale_error) check_noise(head, j, range, findings);
    // A delay reduces the factor, by the cosine of its phase at the frequency of the motion.
    const bool delayed = check_delay(head, j, findings);
    if (!delayed || fit.factor >= 1.0 || fit.factor <= 1.0 - numbers.clock_error) fits.push_back(fit);
  }
  report_scales(head, fits, related, findings);
}

}  // namespace veridyn::quality
