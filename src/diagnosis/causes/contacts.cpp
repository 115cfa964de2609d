#include "diagnosis/causes/contacts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/evidence/held_out.hpp"
#include "veridyn/math/student_t.hpp"

namespace veridyn {
namespace {

constexpr double kThreshold = 5.0;     // of the residual's scatter elsewhere: a burst begins
constexpr double kPeak = 8.0;          // a burst reaches this at least
constexpr double kPush = 0.3;          // of the peak, in the mean: a push has a direction
constexpr double kTorqueShare = 0.04;  // of the largest torque: smaller bursts are friction at rest
constexpr double kFrictionShare = 1.0;  // of the friction of a joint that moves
constexpr double kRestShare = 1.6;      // of the friction of a joint at rest
constexpr double kMovingShare = 0.02;   // of the largest speed
constexpr double kMoves = 0.02;         // [rad/s] or [m/s]
constexpr double kSlow = 4.0;        // [s] on either side, of the median that follows slow errors
constexpr double kGrid = 0.25;       // [s]
constexpr double kShortest = 0.3;    // [s]
constexpr double kJoin = 0.5;        // [s] bursts nearer than this are one
constexpr double kMargin = 0.25;     // [s] left out on either side
constexpr double kMostOfTime = 0.5;  // of a recording; more is no moment
constexpr double kAlways = 5.0;      // bursts that a recording may have, however short
constexpr double kPerMinute = 12.0;  // more bursts than this belong to the motion
constexpr double kRepeats = 0.4;     // of the burst's size at the same phase of another period
constexpr double kFreedomOfContacts = 10.0;  // scatter of a residual is known from some tens of
                                             // independent moments

double median(std::vector<double> v) {
  if (v.empty()) return 0.0;
  const auto middle = v.begin() + static_cast<long>(v.size() / 2);
  std::nth_element(v.begin(), middle, v.end());
  return *middle;
}

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
  for (double t = time.front();; t += kGrid) {
    const auto begin = std::lower_bound(time.begin(), time.end(), t - kSlow) - time.begin();
    const auto end = std::upper_bound(time.begin(), time.end(), t + kSlow) - time.begin();
    at.push_back(t);
    level.push_back(median({r.begin() + begin, r.begin() + end}));
    if (t >= time.back()) break;
  }
  std::vector<double> out(r.size());
  for (size_t k = 0; k < r.size(); ++k) {
    const double u = (time[k] - time.front()) / kGrid;
    const size_t low = std::min(static_cast<size_t>(u), at.size() - 1);
    const size_t high = std::min(low + 1, at.size() - 1);
    out[k] = level[low] + (u - static_cast<double>(low)) * (level[high] - level[low]);
  }
  return out;
}

// Friction of a joint at rest is anything between its two directions; the model cannot know it.
double rest_friction(const Model& arm, size_t joint) {
  double sum = 0.0;
  for (const EffectTerm& term : arm.effects()) {
    const auto level = term.values.find("level");
    if (level == term.values.end()) continue;
    sum += std::abs(term.axis.coefficients[static_cast<Eigen::Index>(joint)] * level->second);
  }
  return sum;
}

Residual residual_of(const Model& arm, const PredictionSeries& x, size_t joint) {
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
  out.scatter = std::max(1.4826 * median(size), 1e-12);
  // Where the joint moves, what its friction does at a start or a reversal is no contact; where it
  // holds a pose, friction is part of what it holds.
  const double friction = fastest > kMoves ? rest_friction(arm, joint) : 0.0;
  const double level =
      std::max({kThreshold * out.scatter, kTorqueShare * most, kFrictionShare * friction});
  const double at_rest = kRestShare * friction;
  out.threshold.assign(n, level);
  for (size_t k = 0; k < n; ++k) {
    if (std::abs(x.dq[joint][k]) < kMovingShare * fastest)
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
    if (!out.empty() && x.time[k] - x.time[out.back().end - 1] < kJoin) {
      out.back().end = k + 1;
    } else {
      out.push_back({k, k + 1});
    }
  }
  return out;
}

bool repeats(const PredictionSeries& x, const std::vector<Residual>& joints, const Span& span,
             double period, double size, size_t joint) {
  if (period <= 0.0) return false;
  const double first = x.time.front();
  const double last = x.time.back();
  for (int turn = -20; turn <= 20; ++turn) {
    if (turn == 0) continue;
    const double from = x.time[span.begin] + turn * period;
    const double to = x.time[span.end - 1] + turn * period;
    if (from < first || to > last) continue;
    double there = 0.0;
    const auto begin = std::lower_bound(x.time.begin(), x.time.end(), from) - x.time.begin();
    const auto end = std::upper_bound(x.time.begin(), x.time.end(), to) - x.time.begin();
    for (auto k = begin; k < end; ++k)
      there = std::max(there, std::abs(joints[joint].r[static_cast<size_t>(k)]));
    if (there > kRepeats * size) return true;
  }
  return false;
}

void contacts_in(const Model& arm, const RecordingError& recording, std::vector<Contact>& out) {
  const PredictionSeries& x = recording.series;
  const size_t n = x.measured.size();
  if (x.time.size() < 50 || n == 0) return;
  std::vector<Residual> joints;
  for (size_t i = 0; i < n; ++i) joints.push_back(residual_of(arm, x, i));
  std::vector<Contact> found;
  double share = 0.0;
  const double duration = x.time.back() - x.time.front();
  for (const Span& span : bursts(x, joints)) {
    Contact c;
    c.source = recording.source;
    c.from = x.time[span.begin];
    c.to = x.time[span.end - 1];
    if (c.to - c.from < kShortest) continue;
    share += (c.to - c.from) / duration;
    c.effort = VectorXd::Zero(static_cast<Eigen::Index>(n));
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
      if (excess <= 0.0 || most < kPeak * joints[i].scatter || std::abs(mean) < kPush * most)
        continue;
      again = again || repeats(x, joints, span, recording.period, most, i);
      c.last_joint = static_cast<int>(i);
      c.deviation = joints[i].scatter;
      c.peak = std::max(c.peak, most / joints[i].scatter);
    }
    if (c.peak > 0.0 && !again) found.push_back(std::move(c));
  }
  if (share > kMostOfTime ||
      static_cast<double>(found.size()) > std::max(kAlways, kPerMinute * duration / 60.0))
    return;
  out.insert(out.end(), found.begin(), found.end());
}

}  // namespace

std::vector<Contact> find_contacts(const Identification& id) {
  std::vector<Contact> out;
  for (const RecordingError& r : id.train) contacts_in(*id.model, r, out);
  for (const RecordingError& r : id.test) {
    const bool trained =
        std::any_of(id.train.begin(), id.train.end(),
                    [&](const RecordingError& other) { return other.source == r.source; });
    if (!trained) contacts_in(*id.model, r, out);
  }
  return out;
}

std::vector<LeftOut> left_out_rows(const std::vector<Contact>& contacts) {
  std::vector<LeftOut> out;
  for (const Contact& c : contacts)
    out.push_back({c.source, -1, c.from - kMargin, c.to + kMargin, "external_contact"});
  return out;
}

void add_contacts(const std::vector<Contact>& contacts, const Identification& with,
                  const Identification& without, Diagnosis& d) {
  for (const Contact& c : contacts) {
    Finding f;
    f.rank = static_cast<int>(d.findings.size()) + 1;
    f.effect = "external_contact";
    f.joint = c.last_joint + 1;
    const Coordinate& joint = with.model->coordinates()[static_cast<size_t>(c.last_joint)];
    f.coordinate = joint.name;
    f.source = c.source;
    f.unit = effort_unit(joint);
    const double effort = c.effort[c.last_joint];
    const double half = student_t_quantile(0.05, kFreedomOfContacts) * c.deviation;
    f.parameters = {{"effort", f.unit, effort, effort - half, effort + half},
                    {"from", "s", c.from, c.from, c.from},
                    {"to", "s", c.to, c.to, c.to}};
    f.p_value = student_t_two_sided(c.peak, kFreedomOfContacts);
    f.test_before = with.test_error.relative;
    f.test_after = without.test_error.relative;
    f.explains = explained_share(f.test_before, f.test_after, with);
    f.sentence = fmt::format(
        "{}: from {:.1f} to {:.1f} s something pushes; joint {} ({}) is the last that feels it, "
        "with "
        "{:.2g} {}. These rows are left out.",
        c.source, c.from, c.to, f.joint, f.coordinate, effort, f.unit);
    d.findings.push_back(std::move(f));
  }
}

}  // namespace veridyn
