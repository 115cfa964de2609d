#include "veridyn/identification/verdict.hpp"
#include "veridyn/identification/robot_check.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <optional>
#include <utility>

#include "effects/plain_friction.hpp"
#include "identification/check/check_thresholds.hpp"
#include "identification/check/quick_fit.hpp"
#include "identification/check/signal_hypotheses.hpp"
#include "math/dense.hpp"
#include "math/numbers.hpp"
#include "math/parallel.hpp"
#include "recordings/kept_recordings.hpp"
#include "recordings/quality/quality_checks.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

std::string percent(double share) {
  return text(quality::number(100.0 * share), " %");
}

class RobotCheck {
 public:
  RobotCheck(const Model& arm, Recording recording, const PreprocessingOptions& options,
             const CheckThresholds& limits)
      : given_(arm), limits_(limits), recording_(std::move(recording)), fitter_(arm, options, limits) {
    for (const Coordinate& c : arm.coordinates()) names_.push_back(c.name);
    moves_ = quality::Head(recording_, QualityNumbers()).moves;
  }

  std::vector<QualityFinding> run() {
    tell_what_hardly_moves();
    if (!is_identifiable()) return std::move(findings_);
    fit_now();
    turned_.assign(static_cast<size_t>(joints()), 0);
    // Accepts the best hypothesis, then the best further one.
    while (static_cast<int>(findings_.size()) < joints() && accept_best(hypotheses(), limits_.better)) {
    }
    check_that_friction_dissipates();
    check_signs_by_dissipation();
    take_currents();
    compare_with_values();
    return std::move(findings_);
  }

 private:
  // True if the base parameters are identifiable; otherwise wrong signals would fit as well as
  // right ones.
  bool is_identifiable() {
    if (std::none_of(moves_.begin(), moves_.end(), [](bool moves) { return moves; })) {
      warn_of_small_efforts();
      return false;
    }
    const auto [determined, condition] = fitter_.determined(recording_);
    if (determined >= fitter_.base_size() && condition < limits_.worst_condition) return true;
    add("not_compared", 0, determined,
        text("Signs, order and units of the joints are not compared with ", given_.name(),
             ": the recording ", determined < fitter_.base_size() ? "determines " : "hardly tells apart ",
             determined, " of its ", fitter_.base_size(), " base parameters."));
    findings_.back().severity = Severity::kInfo;
    warn_of_small_efforts();
    return false;
  }

  void tell_what_hardly_moves() {
    for (int i = 0; i < joints() && recording_.rows() > 0; ++i) {
      const Limits& limits = given_.coordinates()[i].limits;
      double lowest = kInfinity, highest = -kInfinity;
      for (const double q : recording_.q.col(i)) {
        if (!std::isfinite(q)) continue;
        lowest = std::min(lowest, q);
        highest = std::max(highest, q);
      }
      const double share = (highest - lowest) / (limits.upper - limits.lower);
      if (!moves(i) || !std::isfinite(limits.upper - limits.lower) || !(share < kHardlyMoves)) continue;
      add("hardly_moves", i + 1, share,
          text("In its first ", quality::number(recording_.time[recording_.rows() - 1] - recording_.time[0]), " s ", joint(i),
               " moves over ", percent(share), " of its range: little of its friction and inertia can be identified."));
      findings_.back().severity = Severity::kWarning;
    }
  }

  int joints() const { return given_.joints(); }
  bool moves(int i) const { return moves_[i]; }
  std::string joint(int i) const { return text("joint ", i + 1, " (", names_[i], ")"); }

  // Torques may be recorded as currents, to which the options then apply.
  bool amperes() const { return recording_.current.size() > 0; }
  std::string torque_name() const { return amperes() ? "i" : "tau"; }
  std::string torque_unit(int i) const {
    if (amperes()) return "A";
    return given_.coordinates()[i].prismatic ? "N" : "Nm";
  }

  void add(const std::string& finding, int joint, double value, const std::string& sentence) {
    QualityFinding f;
    f.file = recording_.source;
    f.finding = finding;
    f.joint = joint;
    f.share = quality::kNone;
    f.value = value;
    f.severity = Severity::kFault;
    f.sentence = sentence;
    findings_.push_back(std::move(f));
  }

  void fit_now() {
    factors_.clear();
    now_ = fitter_.fit(recording_, &factors_);
  }

  QuickFit tried(const SignalHypothesis& hypothesis) const {
    Recording changed = recording_;
    hypothesis.mend(&changed);
    return fitter_.fit(changed);
  }

  void accept(const SignalHypothesis& hypothesis, const QuickFit& fit) {
    if (hypothesis.finding == "torque_sign") {  // reported at the end, after the check of friction
      turned_[hypothesis.joint - 1] ^= 1;
    } else {
      add(hypothesis.finding, hypothesis.joint, fit.unexplained,
          text(hypothesis.what, ": so the arm leaves ", percent(fit.unexplained),
               " of the torques' squares unexplained instead of ", percent(now_.unexplained), "; ",
               hypothesis.option, " mends it."));
    }
    hypothesis.mend(&recording_);
    now_ = fit;
    factors_.clear();
  }

  // Accepts the best hypothesis if it is much better than the recording as it is and than every other
  // one that excludes it. Hypotheses that come close to each other are what joints that move alike make
  // of a torque that the arm does not explain.
  bool accept_best(const std::vector<SignalHypothesis>& hypotheses, double better) {
    std::vector<QuickFit> fits(hypotheses.size());
    std::vector<char> possible(hypotheses.size());
    parallel_for(static_cast<int>(hypotheses.size()), 0, [&](int k) {
      const auto at = static_cast<size_t>(k);
      fits[at] = tried(hypotheses[at]);
      possible[at] = is_possible(hypotheses[at]) ? 1 : 0;
    });
    const auto gains = [&](size_t k) {
      return fits[k].misfit <= now_.misfit - better && fits[k].unexplained < now_.unexplained;
    };
    std::optional<size_t> best;
    for (size_t k = 0; k < hypotheses.size(); ++k) {
      const bool first = !best || possible[k] > possible[*best];
      if (gains(k) && (first || (possible[k] == possible[*best] && fits[k].misfit < fits[*best].misfit))) best = k;
    }
    if (!best) return false;
    if (possible[*best] == 0) {
      say_perhaps(hypotheses[*best], fits[*best], "as recorded, all positions lie within the limits of the joints");
      return false;
    }
    const bool sign = hypotheses[*best].finding == "torque_sign";  // the commonest mistake, for which its gain is enough
    for (size_t k = 0; !sign && k < hypotheses.size(); ++k) {
      if (k == *best || possible[k] == 0 || !hypotheses[*best].excludes(hypotheses[k])) continue;
      if (fits[k].misfit > fits[*best].misfit + better) continue;
      say_perhaps(hypotheses[*best], fits[*best], "another exchange does nearly as well, so that none of them is sure");
      return false;
    }
    if (!sign && !holds_throughout(hypotheses[*best], fits[*best])) {
      say_perhaps(hypotheses[*best], fits[*best], "a joint that it concerns is explained no better in a half of the recording");
      return false;
    }
    accept(hypotheses[*best], fits[*best]);
    return true;
  }

  // True if either half of the recording explains every joint concerned better than before.
  bool holds_throughout(const SignalHypothesis& hypothesis, const QuickFit& fit) const {
    for (const int k : {hypothesis.joint, hypothesis.second}) {
      if (k == 0) continue;
      if ((fit.halves.row(k - 1).array() > now_.halves.row(k - 1).array()).any()) return false;
    }
    return true;
  }

  // Number of joints whose positions leave their limits.
  int beyond_limits(const Recording& recording) const {
    const std::vector<Coordinate>& coordinates = given_.coordinates();
    int out = 0;
    for (size_t i = 0; i < coordinates.size(); ++i) {
      const Limits& limits = coordinates[i].limits;
      if (!std::isfinite(limits.upper - limits.lower)) continue;
      const double margin = limits_.beyond_limits * (limits.upper - limits.lower);
      const auto q = recording.q.col(i).array();
      out += (q < limits.lower - margin || q > limits.upper + margin).any() ? 1 : 0;
    }
    return out;
  }

  // The limits of the joints admit the positions that follow, no worse than those recorded; degrees also
  // need positions that are none in radians.
  bool is_possible(const SignalHypothesis& hypothesis) const {
    const int as_recorded = beyond_limits(recording_);
    if (hypothesis.finding == "degrees") return as_recorded > 0 || !has_limits();
    Recording changed = recording_;
    hypothesis.mend(&changed);
    return beyond_limits(changed) <= as_recorded;
  }

  bool has_limits() const {
    return std::any_of(given_.coordinates().begin(), given_.coordinates().end(), [](const Coordinate& c) {
      return !c.prismatic && std::isfinite(c.limits.upper - c.limits.lower);
    });
  }

  void say_perhaps(const SignalHypothesis& hypothesis, const QuickFit& fit, const std::string& but) {
    if (hypothesis.what.empty()) return;  // a sign: friction is asked next
    std::string what = hypothesis.what;
    what.front() = static_cast<char>(std::tolower(static_cast<unsigned char>(what.front())));
    add(hypothesis.finding, hypothesis.joint, fit.unexplained,
        text("Perhaps ", what, ": so the arm leaves ", percent(fit.unexplained), " of the torques' squares unexplained instead of ",
             percent(now_.unexplained), ", but ", but, "."));
    findings_.back().severity = Severity::kInfo;
  }

  // Two joints are exchanged only where the recording as it is leaves at least one of them badly explained.
  std::vector<SignalHypothesis> hypotheses() const {
    std::vector<SignalHypothesis> all = angles_in_degrees(given_, recording_);
    for (int i = 0; i < joints(); ++i)
      if (moves(i)) all.push_back(turned_torque(i));
    for (int i = 0; i < joints(); ++i) {
      for (int j = i + 1; j < joints(); ++j) {
        if (!moves(i) || !moves(j) || std::max(now_.shares[i], now_.shares[j]) <= limits_.well_fitted) continue;
        for (SignalHypothesis& swap : exchanges(i, j, joint(i) + " and " + joint(j), recording_.dq.size() > 0, torque_name()))
          all.push_back(std::move(swap));
      }
    }
    return all;
  }

  bool friction_shows(int i, int sign) const {
    const auto joint = static_cast<size_t>(i);
    const double rest = limits_.friction_above_rest * std::sqrt(now_.shares[joint]);
    return moves(i) && sign * now_.friction[i] > std::max(limits_.friction_share, rest) &&
           now_.friction_significance[joint] > limits_.friction_significance;
  }

  void check_that_friction_dissipates() {
    // Checks the sign of all torques, or of joints without coupling, by dissipation: friction takes
    // energy. A joint without visible friction follows the others if these agree.
    int taking = 0;
    int giving = 0;
    for (int i = 0; i < joints(); ++i) {
      taking += friction_shows(i, 1) ? 1 : 0;
      giving += friction_shows(i, -1) ? 1 : 0;
    }
    const bool all = taking == 0 && 2 * giving > joints();
    bool again = false;
    std::vector<char> wrong;
    for (int i = 0; i < joints(); ++i) wrong.push_back(friction_shows(i, -1) ? 1 : 0);
    for (int i = 0; i < joints(); ++i) {
      if (!moves(i) || (!all && wrong[i] == 0)) continue;
      turned_[i] ^= 1;
      recording_.tau.col(i) *= -1.0;
      again = true;
    }
    if (again) fit_now();
  }

  void check_signs_by_dissipation() {
    for (int i = 0; i < joints(); ++i) {
      if (turned_[i] == 0) continue;
      Recording back = recording_;  // with all but this joint corrected
      back.tau.col(i) *= -1.0;
      const QuickFit without = fitter_.fit(back);
      const bool fits =
          now_.misfit < without.misfit - limits_.better && now_.unexplained < without.unexplained;
      add("torque_sign", i + 1, now_.shares[i],
          text("Torques of ", joint(i), " have the wrong sign: ",
               fits ? text("turned round, the arm leaves ", percent(now_.unexplained),
                           " of the torques' squares unexplained instead of ",
                           percent(without.unexplained))
                    : "its friction would give energy instead of taking it",
               "; --units ", torque_name(), i + 1, "=-", torque_unit(i), " mends it."));
    }
  }

  bool has_gains() const {
    return std::all_of(given_.coordinates().begin(), given_.coordinates().end(),
                       [](const Coordinate& c) { return c.drive_gain > 0.0; });
  }

  bool may_be_currents() const { return has_gains() && !amperes() && joints() > 1; }

  VectorXd gains() const {
    VectorXd out(joints());
    for (int i = 0; i < joints(); ++i) out[i] = given_.coordinates()[i].drive_gain;
    return out;
  }

  bool warn_of_small_efforts() {
    if (!may_be_currents() || !look_like_currents(gains())) return false;
    add("current", 0, quality::kNone,
        text("All efforts are so small beside the limits of ", given_.name(),
             " that they may be motor currents, as the drivers of Universal Robots publish them: "
             "if they are, --units tau=A mends it."));
    findings_.back().severity = Severity::kWarning;
    return true;
  }

  void take_currents() {
    if (!may_be_currents() || warn_of_small_efforts()) return;
    const VectorXd gains = this->gains();
    // Equal gains would fit torques as well.
    if (gains.maxCoeff() < limits_.equal_gains * gains.minCoeff()) return;
    accept_best({currents(gains)}, limits_.gains_better);
  }

  // True if every joint's largest effort is below the current at its torque limit.
  bool look_like_currents(const VectorXd& gains) const {
    double nearest = 0.0;
    for (int i = 0; i < joints(); ++i) {
      const double limit = given_.coordinates()[i].limits.effort;
      if (!std::isfinite(limit) || gains[i] < limits_.least_gain) return false;
      double largest = 0.0;
      for (const double tau : recording_.tau.col(i)) {
        if (std::isfinite(tau)) largest = std::max(largest, std::abs(tau));
      }
      nearest = std::max(nearest, largest * gains[i] / limit);
    }
    return nearest < 1.0;
  }

  // Factor between the torques of an arm's values and the recorded ones, for arms without friction
  // of their own beside fitted friction: at low gravity most of a joint's torque is friction.
  double factor_beside_friction(const SquareRootInformation& f, const VectorXd& phi) const {
    std::vector<Eigen::Index> open;
    if (has_no_friction(given_)) {
      for (size_t j = 0; j < fitter_.parameters().size(); ++j)
        if (fitter_.parameters()[j].effect) open.push_back(static_cast<Eigen::Index>(j));
    }
    const MatrixXd R = f.R();
    MatrixXd columns(R.rows(), 1 + static_cast<Eigen::Index>(open.size()));
    columns.col(0) = R * phi;
    if (columns.col(0).norm() < 1e-300) return 1.0;
    for (size_t k = 0; k < open.size(); ++k)
      columns.col(1 + static_cast<Eigen::Index>(k)) = R.col(open[k]);
    const VectorXd norms = columns.colwise().norm().transpose().cwiseMax(1e-300);
    const MatrixXd scaled = columns * norms.cwiseInverse().asDiagonal();
    return least_norm(scaled, f.z())[0] / norms[0];
  }

  // Compares torques with those of an arm with values, by one factor per joint.
  void compare_with_values() {
    const bool told = std::any_of(findings_.begin(), findings_.end(),
                                  [](const QualityFinding& f) { return f.finding == "current"; });
    if (told || !given_.inertial_values()) return;
    VectorXd phi(fitter_.parameters().size());
    for (Eigen::Index j = 0; j < phi.size(); ++j) {
      const double value = fitter_.parameters()[j].value;
      phi[j] = std::isfinite(value) ? value : 0.0;
    }
    if (factors_.empty()) fit_now();
    std::vector<double> ratios;
    bool as_currents = true;
    bool alien = false;
    for (int i = 0; i < joints(); ++i) {
      const double ratio = factor_beside_friction(factors_[i], phi);
      const double gain = given_.coordinates()[i].drive_gain;
      ratios.push_back(ratio);
      as_currents = as_currents && gain > 0.0 && ratio > 0.0 && std::abs(std::log(ratio * gain)) < std::log(limits_.current_factor) &&
                    std::abs(std::log(gain)) > std::log(limits_.torque_factor);
      alien = alien || ratio * limits_.torque_factor < 1.0 || ratio > limits_.torque_factor;
    }
    if (!alien) return;
    std::string list;
    for (const double ratio : ratios) list += (list.empty() ? "" : ", ") + quality::number(ratio);
    if (as_currents) {
      add("current", 0, quality::kNone,
          text("Efforts are ", list, " times the torques of ", given_.name(),
               ", as motor currents are; --units tau=A mends it."));
    } else {
      add("torque_scale", 0, quality::kNone,
          text("Efforts are ", list, " times the torques of ", given_.name(), ", joint by joint; --units tells if they are in other units (tau=mNm, tau=A)."));
      findings_.back().severity = Severity::kWarning;
    }
  }

  const Model& given_;
  const CheckThresholds& limits_;
  Recording recording_;
  QuickFitter fitter_;
  std::vector<std::string> names_;
  QuickFit now_;
  std::vector<SquareRootInformation> factors_;  // of the fit now_, one a joint; empty until fit_now()
  std::vector<bool> moves_;   // joints that can be checked
  std::vector<char> turned_;  // joints whose torques were reversed
  std::vector<QualityFinding> findings_;
};

}  // namespace

const std::vector<TableNumber<CheckThresholds>>& check_numbers() {
  using T = CheckThresholds;
  static const std::vector<TableNumber<T>> kAll = {
      number_of<&T::most_rows>("most_rows"),
      number_of<&T::fewest_rows>("fewest_rows"),
      number_of<&T::worst_condition>("worst_condition"),
      number_of<&T::better>("better"),
      number_of<&T::gains_better>("gains_better"),
      number_of<&T::equal_gains>("equal_gains"),
      number_of<&T::well_fitted>("well_fitted"),
      number_of<&T::smallest_share>("smallest_share"),
      number_of<&T::friction_share>("friction_share"),
      number_of<&T::friction_above_rest>("friction_above_rest"),
      number_of<&T::friction_significance>("friction_significance"),
      number_of<&T::beyond_limits>("beyond_limits"),
      number_of<&T::least_gain>("least_gain"),
      number_of<&T::torque_factor>("torque_factor"),
      number_of<&T::current_factor>("current_factor")};
  return kAll;
}

std::vector<QualityFinding> check_against(const Model& arm, const std::string& path,
                                          const PreprocessingOptions& options) {
  const CheckThresholds limits;
  RecordingOptions reading = reading_of(arm, options);
  reading.first_row = std::max(0L, options.first_row);
  reading.row_count = std::min<long>(options.row_count.value_or(limits.most_rows), limits.most_rows);
  Recording recording = read_rows(path, reading, options.kept.get());
  recording.source = path;
  PreprocessingOptions rest = options;
  rest.first_row = 0;
  rest.row_count.reset();
  return check_against(arm, std::move(recording), rest, limits);
}

std::vector<QualityFinding> check_against(const Model& arm, Recording recording,
                                          const PreprocessingOptions& options) {
  return check_against(arm, std::move(recording), options, CheckThresholds());
}

std::vector<QualityFinding> check_against(const Model& arm, Recording recording, const PreprocessingOptions& options,
                                          const CheckThresholds& limits) {
  require(recording.joints() == arm.joints(), recording.source, ": found ", recording.joints(),
          " joints, but '", arm.name(), "' has ", arm.joints(),
          recording.joints() < arm.joints() ? " (files with a part of the joints each are one recording: a.csv+b.csv)." : ".");
  const long first = std::min<long>(options.first_row, recording.rows());
  const long wanted = std::min<long>(options.row_count.value_or(limits.most_rows), limits.most_rows);
  const long count = std::min(wanted, recording.rows() - first);
  if (first > 0 || count < recording.rows())
    recording = rows_of(recording, static_cast<int>(first), static_cast<int>(count));
  if (recording.rows() < limits.fewest_rows) return {};
  if (recording.tau.size() == 0 && recording.current.size() > 0) {
    // Signs, exchanged joints and angles of currents are checked through their gains.
    recording.tau = recording.current;
    for (int i = 0; i < arm.joints(); ++i) {
      const double gain = arm.coordinates()[i].drive_gain;
      if (gain > 0.0) recording.tau.col(i) *= gain;
    }
  }
  if (recording.tau.size() == 0) return {};
  return RobotCheck(arm, std::move(recording), options, limits).run();
}

}  // namespace veridyn
