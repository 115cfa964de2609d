#include "diagnosis/causes/contacts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/evidence/clustered_fit.hpp"
#include "diagnosis/evidence/numerics.hpp"
#include "veridyn/effects/cause.hpp"
#include "math/median.hpp"
#include "math/student_t.hpp"
#include "regressor/effect_along.hpp"

namespace veridyn {
namespace {

struct Residual {
  std::vector<double> r;          ///< without what changes slowly
  std::vector<double> threshold;  ///< above it a burst begins
  double scatter = 0.0;
};

// The median over some seconds around, at grid points and linear in between: what a contact is too
// short to move.
std::vector<double> slow_part(const std::vector<double>& time, const std::vector<double>& r) {
  std::vector<double> at;
  std::vector<double> level;
  for (double t = time.front();; t += numerics::kContactGrid) {
    const auto begin = std::lower_bound(time.begin(), time.end(), t - numerics::kContactMedian) - time.begin();
    const auto end = std::upper_bound(time.begin(), time.end(), t + numerics::kContactMedian) - time.begin();
    at.push_back(t);
    level.push_back(median(std::vector<double>(r.begin() + begin, r.begin() + end)));
    if (t >= time.back()) break;
  }
  std::vector<double> out(r.size());
  for (size_t k = 0; k < r.size(); ++k) {
    const double u = (time[k] - time.front()) / numerics::kContactGrid;
    const size_t low = std::min(static_cast<size_t>(u), at.size() - 1);
    const size_t high = std::min(low + 1, at.size() - 1);
    out[k] = level[low] + (u - static_cast<double>(low)) * (level[high] - level[low]);
  }
  return out;
}

// Largest friction of a joint at rest, where it may have any value between its two directions: the
// largest force of all effects with the role of friction, along a slow pass to and fro over the
// joint's recorded travel.
double rest_friction(const Model& arm, const PredictionSeries& x, size_t joint, double slow) {
  const auto i = static_cast<Eigen::Index>(joint);
  const auto [low, high] = std::minmax_element(x.q[joint].begin(), x.q[joint].end());
  const Eigen::Index samples = numerics::kPassSamples;
  const MatrixXd zero = MatrixXd::Zero(2 * samples, arm.joints());
  MotionSamples pass{VectorXd::Zero(2 * samples), zero, zero, zero};
  for (int j = 0; j < arm.joints(); ++j)
    pass.q.col(j).setConstant(median(x.q[j]));
  for (Eigen::Index k = 0; k < samples; ++k) {
    const double s = *low + (*high - *low) * static_cast<double>(k) / (samples - 1);
    pass.q(k, i) = pass.q(2 * samples - 1 - k, i) = s;
    pass.dq(k, i) = slow;
    pass.dq(2 * samples - 1 - k, i) = -slow;
  }
  const MatrixXd load = rigid_load(arm, TorqueRegressor(arm), pass);
  VectorXd sum = VectorXd::Zero(2 * samples);
  for (const EffectTerm& term : arm.effects()) {
    if (!has_axis_effect(term.effect) || term.axis.coefficients[i] == 0.0) continue;
    const EffectFacts effect(arm, term);
    if (effect.traits().role != EffectRole::kFriction) continue;
    const MatrixXd columns = columns_along(effect.bound(), pass, load, 0.0);
    for (int p = 0; p < effect.parameter_count(); ++p)
      sum += term.axis.coefficients[i] * effect.values()[p] * columns.col(p);
  }
  return sum.cwiseAbs().maxCoeff();
}

Residual residual_of(const Model& arm, const PredictionSeries& x, size_t joint,
                     const Thresholds& limits) {
  Residual out;
  const size_t n = x.time.size();
  out.r.resize(n);
  for (size_t k = 0; k < n; ++k) out.r[k] = x.measured[joint][k] - x.modelled[joint][k];
  const std::vector<double> slow = slow_part(x.time, out.r);
  std::vector<double> size(n);
  double most = 0.0;
  double fastest = 0.0;
  for (size_t k = 0; k < n; ++k) {
    out.r[k] -= slow[k];
    size[k] = std::abs(out.r[k]);
    most = std::max(most, std::abs(x.measured[joint][k]));
    fastest = std::max(fastest, std::abs(x.dq[joint][k]));
  }
  if (most == 0.0) std::fill(out.r.begin(), out.r.end(), 0.0);  // no torque was recorded
  out.scatter = std::max(kMadToDeviation * median(size), numerics::kNoise);
  // On a moving joint, friction at a start or a reversal is no contact; on a joint that holds a
  // pose, it is part of the holding torque.
  const auto [low, high] = std::minmax_element(x.q[joint].begin(), x.q[joint].end());
  const bool moves = *high - *low > limits.still(arm.coordinates()[joint].prismatic);
  const double friction = moves ? rest_friction(arm, x, joint, limits.moving_share * fastest) : 0.0;
  const double level =
      std::max({limits.contact_threshold * out.scatter, limits.contact_torque_share * most, friction});
  const double at_rest = limits.contact_rest_share * friction;
  out.threshold.assign(n, level);
  for (size_t k = 0; k < n; ++k) {
    if (std::abs(x.dq[joint][k]) < limits.moving_share * fastest)
      out.threshold[k] = std::max(level, at_rest);
  }
  return out;
}

struct Span {
  size_t begin, end;
};

// Runs of samples at which a joint is above its threshold.
std::vector<Span> bursts(const PredictionSeries& x, const std::vector<Residual>& joints) {
  std::vector<Span> out;
  for (size_t k = 0; k < x.time.size(); ++k) {
    const bool above = std::any_of(joints.begin(), joints.end(), [k](const Residual& j) {
      return std::abs(j.r[k]) > j.threshold[k];
    });
    if (!above) continue;
    if (!out.empty() && x.time[k] - x.time[out.back().end - 1] < numerics::kContactJoin) {
      out.back().end = k + 1;
    } else {
      out.push_back({k, k + 1});
    }
  }
  return out;
}

bool repeats(const PredictionSeries& x, const std::vector<Residual>& joints, const Span& span,
             double period, double size, size_t joint, const Thresholds& limits) {
  if (period <= 0.0) return false;
  const double first = x.time.front();
  const double last = x.time.back();
  for (int turn = -numerics::kPeriods; turn <= numerics::kPeriods; ++turn) {
    if (turn == 0) continue;
    const double from = x.time[span.begin] + turn * period;
    const double to = x.time[span.end - 1] + turn * period;
    if (from < first || to > last) continue;
    double there = 0.0;
    const auto begin = std::lower_bound(x.time.begin(), x.time.end(), from) - x.time.begin();
    const auto end = std::upper_bound(x.time.begin(), x.time.end(), to) - x.time.begin();
    for (auto k = begin; k < end; ++k)
      there = std::max(there, std::abs(joints[joint].r[k]));
    if (there > limits.contact_repeats * size) return true;
  }
  return false;
}

// A recording, and what the model does not explain of it.
struct Seen {
  const RecordingError* recording;
  std::vector<Residual> joints;
};

// True if most other passes of the joint through the place of a burst's largest value, in all recordings, show the
// same: it depends on the position and is no push.
bool returns_at_its_place(const std::vector<Seen>& all, const Seen& own, const Span& span, size_t joint, const Thresholds& limits) {
  const std::vector<double>& r = own.joints[joint].r;
  const auto peak = std::max_element(r.begin() + static_cast<std::ptrdiff_t>(span.begin), r.begin() + static_cast<std::ptrdiff_t>(span.end),
                                     [](double a, double b) { return std::abs(a) < std::abs(b); });
  const double place = own.recording->series.q[joint][static_cast<size_t>(peak - r.begin())];
  std::vector<double> shares;
  for (const Seen& seen : all) {
    const std::vector<double>& q = seen.recording->series.q[joint];
    for (size_t k = 1; k < q.size(); ++k) {
      if (&seen == &own && k >= span.begin && k <= span.end) continue;
      if ((q[k - 1] < place) != (q[k] < place)) shares.push_back(seen.joints[joint].r[k] / *peak);
    }
  }
  return !shares.empty() && median(shares) > limits.contact_repeats;
}

void contacts_in(const std::vector<Seen>& all, const Seen& own, const Thresholds& limits, std::vector<Contact>& out) {
  const RecordingError& recording = *own.recording;
  const PredictionSeries& x = recording.series;
  const std::vector<Residual>& joints = own.joints;
  const size_t n = joints.size();
  std::vector<Contact> found;
  double share = 0.0;
  const double duration = x.time.back() - x.time.front();
  for (const Span& span : bursts(x, joints)) {
    Contact c;
    c.source = recording.source;
    c.from = x.time[span.begin];
    c.to = x.time[span.end - 1];
    if (c.to - c.from < limits.contact_shortest) continue;
    share += (c.to - c.from) / duration;
    c.effort = VectorXd::Zero(n);
    bool again = false;
    for (size_t i = 0; i < n; ++i) {
      double most = 0.0;
      double sum = 0.0;
      double excess = 0.0;
      for (size_t k = span.begin; k < span.end; ++k) {
        const double size = std::abs(joints[i].r[k]);
        most = std::max(most, size);
        excess = std::max(excess, size - joints[i].threshold[k]);
        sum += joints[i].r[k];
      }
      const double mean = sum / static_cast<double>(span.end - span.begin);
      c.effort[static_cast<Eigen::Index>(i)] = mean;
      if (excess <= 0.0 || most < limits.contact_peak * joints[i].scatter || std::abs(mean) < limits.contact_direction * most)
        continue;
      again = again || repeats(x, joints, span, recording.period, most, i, limits) ||
              returns_at_its_place(all, own, span, i, limits);
      c.last_joint = static_cast<int>(i);
      c.deviation = joints[i].scatter;
      c.peak = std::max(c.peak, most / joints[i].scatter);
    }
    if (c.peak > 0.0 && !again) found.push_back(std::move(c));
  }
  if (share > limits.contact_most_of_time ||
      static_cast<double>(found.size()) > std::max(limits.contact_always, limits.contact_per_minute * duration / numerics::kMinute))
    return;
  out.insert(out.end(), found.begin(), found.end());
}

}  // namespace

std::vector<Contact> find_contacts(const Identification& id, const Thresholds& limits) {
  std::vector<Seen> all;
  const auto add = [&](const RecordingError& r) {
    const size_t n = r.series.measured.size();
    if (r.series.time.size() < numerics::kFewestContactSamples || n == 0) return;
    Seen seen{&r, {}};
    for (size_t i = 0; i < n; ++i) seen.joints.push_back(residual_of(*id.model, r.series, i, limits));
    all.push_back(std::move(seen));
  };
  for (const RecordingError& r : id.train) add(r);
  for (const RecordingError& r : id.test) {
    const bool trained =
        std::any_of(id.train.begin(), id.train.end(),
                    [&](const RecordingError& other) { return other.source == r.source; });
    if (!trained) add(r);
  }
  std::vector<Contact> out;
  for (const Seen& own : all) contacts_in(all, own, limits, out);
  return out;
}

std::vector<ExcludedInterval> excluded_intervals(const std::vector<Contact>& contacts) {
  std::vector<ExcludedInterval> out;
  for (const Contact& c : contacts)
    out.push_back({c.source, {}, c.from - numerics::kContactMargin,
                   c.to + numerics::kContactMargin, ExternalContact::kName});
  return out;
}

namespace {

std::string efforts_words(const Model& arm, const Contact& c) {
  std::string out;
  for (Eigen::Index i = 0; i <= c.last_joint; ++i) {
    const Coordinate& joint = arm.coordinates()[i];
    out += fmt::format("{}{:.2g} {} on joint {} ({})", i == 0 ? "" : ", ", c.effort[i],
                       effort_unit(joint), i + 1, joint.name);
  }
  return out;
}

}  // namespace

void add_contacts(const std::vector<Contact>& contacts, const Identification& seen, Diagnosis& d) {
  const Model& arm = *seen.model;
  for (const Contact& c : contacts) {
    Finding f;
    f.rank = static_cast<int>(d.findings.size()) + 1;
    f.cause = ExternalContact{{c.last_joint}};
    f.joint = JointIndex{c.last_joint};
    const Coordinate& joint = arm.coordinates()[c.last_joint];
    f.source = c.source;
    f.unit = effort_unit(joint);
    const double effort = c.effort[c.last_joint];
    const double half =
        student_t_quantile(numerics::kOutside, numerics::kContactFreedom) * c.deviation;
    f.parameters = {{"effort", f.unit, effort, effort - half, effort + half},
                    {"from", "s", c.from, c.from, c.from},
                    {"to", "s", c.to, c.to, c.to}};
    f.p_value = student_t_two_sided(c.peak, numerics::kContactFreedom);
    // A push is no error of the model: gives the held-out error with and without these intervals.
    f.test_before = seen.test_error.relative;
    f.test_after = seen.test_error.relative;
    f.test_outside = seen.test_without_excluded.relative.size() > 0
                         ? seen.test_without_excluded.relative
                         : seen.test_error.relative;
    f.phrase = fmt::format(
        "from {:.1f} to {:.1f} s something pushes the arm on link {} or beyond it: {} (mean "
        "torque that the model does not explain). These {:.1f} s are left out of the fit",
        c.from, c.to, words_of(arm, f.cause).frame, efforts_words(arm, c), c.to - c.from);
    d.findings.push_back(std::move(f));
  }
}

}  // namespace veridyn
