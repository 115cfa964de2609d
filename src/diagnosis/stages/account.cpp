#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/evidence/held_out.hpp"
#include "diagnosis/stages/investigation.hpp"
#include "diagnosis/unnamed/dependence.hpp"
#include "math/parallel.hpp"
#include "math/signed_rank.hpp"
#include "veridyn/effects/cause.hpp"

// What is left over once all causes were asked about: how much of it the motion predicts, of which
// signals it is a function, and what a verdict says of every joint.

namespace veridyn {
namespace {

using numerics::kPercent;

double error_of(const VectorXd& relative, int joint) {
  return relative.size() > joint ? relative[joint] : 0.0;
}

bool acts_on(const Finding& f, int joint) {
  return f.status == FindingStatus::kConfirmed && (!f.joint || f.joint->value == joint);
}

// The error with so much of its mean square predicted.
double without_share(double error, double share) {
  return error * std::sqrt(std::max(0.0, 1.0 - share));
}

std::string joined(const std::vector<std::string>& words, const char* between) {
  std::string out;
  for (const std::string& w : words) out += (out.empty() ? "" : between) + w;
  return out;
}

std::string phrase_of(const UnnamedShape& shape, double share) {
  std::string out = fmt::format("{:.0f} % of what the model leaves over can be predicted from {}: {}",
                                kPercent * share, joined(shape.signals, " and "), shape.words);
  if (!shape.as_good.empty()) {
    std::vector<std::string> others;
    for (const auto& names : shape.as_good) others.push_back(joined(names, " and "));
    out += " (as well from " + joined(others, ", ") + ": these recordings cannot tell)";
  }
  return out + "; nothing on the list has that shape";
}

class Account {
 public:
  explicit Account(Investigation& x)
      : x_(x),
        d_(x.d),
        limits_(x.options.thresholds),
        signals_(motion_signals(d_.extended, limits_)),
        train_(motion_rows(d_.extended, d_.extended.train, d_.left_out, signals_)),
        test_(motion_rows(d_.extended, d_.extended.test, d_.left_out, signals_)) {}

  void run() {
    const int n = d_.extended.model->joints();
    std::vector<Dependence> found(static_cast<size_t>(n));
    std::vector<std::vector<SmoothTerm>> terms(static_cast<size_t>(n));
    parallel_for(n, x_.options.identification.threads, [&](int j) {
      const auto at = static_cast<size_t>(j);
      terms[at] = smooth_terms(signals_, j, limits_);
      found[at] = find_dependence(j, train_, test_, terms[at], limits_);
    });
    for (int j = 0; j < n; ++j) {
      const auto at = static_cast<size_t>(j);
      const double left = add_findings(found[at], terms[at]);
      d_.joints.push_back(verdict_of(j, found[at], left));
    }
  }

 private:
  // Findings of a joint's dependence; the held-out error that is left after them.
  double add_findings(const Dependence& found, const std::vector<SmoothTerm>& terms) {
    const int j = found.joint;
    const double before = error_of(d_.extended.test_error.relative, j);
    double error = before;
    if (!is_clear(found)) return error;
    double so_far = 0.0;
    for (size_t k = 0; k < found.model.chosen.size(); ++k) {
      const double share = found.predicted_of_test[k];
      UnnamedShape shape = shape_of(found, k, train_, terms);
      Finding f;
      f.cause = NewEffect{UnnamedShape::kName, JointIndex{j}};
      f.joint = JointIndex{j};
      f.unit = shape.effort;
      f.gain = found.model.chosen[k].gain;
      f.p_value = signed_rank_p_value(found.model.falls);
      f.test_before = d_.extended.test_error.relative;
      f.test_after = f.test_before;
      if (f.test_before.size() > j) {
        f.test_before[j] = without_share(before, so_far);
        f.test_after[j] = without_share(before, std::max(share, so_far));
        error = f.test_after[j];
      }
      f.status = share > so_far ? FindingStatus::kConfirmed : FindingStatus::kNotConfirmed;
      f.explains = explained_share(f.test_before, f.test_after, d_.baseline);
      shape.share = share - so_far;
      f.phrase = phrase_of(shape, shape.share);
      f.shape = std::move(shape);
      so_far = std::max(share, so_far);
      d_.findings.push_back(std::move(f));
    }
    return error;
  }

  // What the training recordings show and the held-out ones confirm, and enough of it.
  bool is_clear(const Dependence& found) const {
    if (found.model.chosen.empty()) return false;
    return std::min(found.predicted_of_folds.back(), found.predicted_of_test.back()) >
           limits_.unnamed_share;
  }

  JointVerdict verdict_of(int j, const Dependence& found, double left) const {
    JointVerdict v;
    v.joint = JointIndex{j};
    v.held_out = error_of(d_.baseline.test_error.relative, j);
    v.extended = error_of(d_.extended.test_error.relative, j);
    const bool repeats = d_.baseline.noise_floor.size() > j;
    v.source = repeats ? FloorSource::kRepeats : FloorSource::kRegression;
    v.floor = std::min(v.held_out, repeats ? d_.baseline.noise_floor[j] : left);
    v.removable = v.held_out - v.floor;
    v.left = left;
    const bool named = std::any_of(d_.findings.begin(), d_.findings.end(), [j](const Finding& f) {
      return !f.shape && acts_on(f, j);
    });
    const bool unnamed = std::any_of(d_.findings.begin(), d_.findings.end(), [j](const Finding& f) {
      return f.shape && f.joint->value == j;
    });
    const bool at_floor = left <= limits_.at_floor * v.floor;
    if (unnamed) {
      v.state = JointState::kUnnamed;
    } else if (named && (at_floor || v.held_out - v.extended > 0.5 * v.removable)) {
      v.state = JointState::kNamed;
    } else if (at_floor && v.held_out <= limits_.at_floor * v.floor) {
      v.state = JointState::kAtFloor;
    } else {
      v.state = JointState::kCannotTell;
      v.why = why_not(found, repeats);
    }
    return v;
  }

  std::string why_not(const Dependence& found, bool repeats) const {
    if (!found.model.chosen.empty()) {
      return fmt::format("the training recordings predict {:.0f} % of what is left over, the held-out ones {:.0f} %",
                         kPercent * found.predicted_of_folds.back(),
                         kPercent * std::max(0.0, found.predicted_of_test.back()));
    }
    if (repeats)
      return "it comes back with the motion, yet no signal of the recordings predicts it on rows that were held out";
    return "what the findings leave over is no function of one or two signals of the recordings";
  }

  Investigation& x_;
  Diagnosis& d_;
  const Thresholds& limits_;
  std::vector<MotionSignal> signals_;
  MotionRows train_, test_;
};

}  // namespace

void account_for_errors(Investigation& x) {
  if (!x.d.extended.model || x.d.extended.train.empty()) return;
  Account(x).run();
}

}  // namespace veridyn
