#include "veridyn/identification/fleet.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <mutex>
#include <sstream>
#include <unsupported/Eigen/SpecialFunctions>
#include <utility>

#include "estimation/least_squares.hpp"
#include "math/excerpt.hpp"
#include "identification/fleet/fleet_problem.hpp"
#include "identification/many_recordings.hpp"
#include "math/clustered_statistics.hpp"
#include "math/input_file.hpp"
#include "math/median.hpp"
#include "math/numbers.hpp"
#include "math/parallel.hpp"
#include "math/student_t.hpp"
#include "identification/fleet/fleet_numbers.hpp"
#include "identification/shortfall.hpp"
#include "identification/velocity_choice.hpp"
#include "veridyn/effects/cause.hpp"
#include "veridyn/effects/channel_effect.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

double median_of(std::vector<double> v) {
  return v.empty() ? kNaN : median(std::move(v));
}

// Median and robust standard deviation of the finite values.
std::pair<double, double> centre_of(const std::vector<double>& all) {
  std::vector<double> finite;
  for (const double x : all)
    if (std::isfinite(x)) finite.push_back(x);
  const double centre = median_of(finite);
  for (double& x : finite) x = std::abs(x - centre);
  return {centre, kMadToDeviation * median_of(finite)};
}

ArmFactor arm_factor(const Model& arm, const FactorSet& set, const std::string& name) {
  ArmFactor out;
  out.name = name;
  out.still = still_joints(arm, set.recordings);
  for (const CompressedRecording& r : set.recordings) {
    ++out.recordings;
    out.rows += r.rows;
    for (const auto& block : r.blocks) {
      if (out.joints.empty()) {
        out.joints = block;
        continue;
      }
      for (size_t i = 0; i < block.size(); ++i) out.joints[i].merge(block[i]);
    }
  }
  return out;
}

// One arm with its factor, its own values and its residuals.
struct Fitted {
  SquareRootInformation factor;
  VectorXd eta;                // own parameters, then gains as shares
  VectorXd uncertain;          // standard deviation of each own value for white noise
  VectorXd telling;            // share of each own column outside the span of the others
  VectorXd residual2, alone2;  // per joint, with the fleet's bodies and with its own
  bool odd = false;            // its bodies differ from the fleet's
  double excess = 0.0;         // see excess(), at that decision
  double deviations = 0.0;     // of it, from the fleet's median
};

class FleetSolver {
 public:
  FleetSolver(const Model& arm, const std::vector<ArmFactor>& arms, const FleetOptions& options)
      : problem_(arm, arms), arms_(arms), options_(options), fitted_(arms.size()) {}

  void solve() {
    VectorXd weights(problem_.joints());
    for (int i = 0; i < problem_.joints(); ++i) {
      weights[i] = 1.0 / std::max(1e-300, scale_of(i, [&](size_t a) {
                                    const auto& f = arms_[a].joints[i];
                                    return f.rhs_norm2() / std::max(1.0, f.rows());
                                  }));
    }
    for (int round = 0; round < fleet_numbers::kRounds; ++round) {
      const VectorXd at_beta = beta_;
      each_arm([&](size_t a) {
        fitted_[a].factor = problem_.of_arm(a, weights, at_beta, fitted_[a].eta);
      });
      SquareRootInformation total(problem_.shared());
      for (const Fitted& f : fitted_)
        if (!f.odd) total.merge(problem_.over_shared(f.factor));
      beta_ = least_squares(total);
      each_arm([&](size_t a) { fit_arm(a, at_beta); });
      for (int i = 0; i < problem_.joints(); ++i) {
        weights[i] = 1.0 / std::max(1e-300, scale_of(i, [&](size_t a) {
                                      const auto& f = arms_[a].joints[i];
                                      return fitted_[a].residual2[i] / std::max(1.0, f.rows());
                                    }));
      }
      // Outliers found in the last round were excluded from the last fit.
      if (round + 1 < fleet_numbers::kRounds) find_odd();
    }
  }

  double median_excess() const { return median_excess_; }

  // Robust distance of every arm's bodies from the fleet's, in ln of the squares that its own
  // bodies explain.
  std::vector<double> excess() const {
    std::vector<double> out;
    for (const Fitted& f : fitted_) {
      const Eigen::ArrayXd ratio = f.residual2.array() / f.alone2.array().max(1e-300);
      out.push_back(std::log(std::max(ratio.maxCoeff(), 1.0)));
    }
    return out;
  }

  double threshold(double looked_at, double more_freedom = 0.0) const {
    return student_t_quantile(options_.significance / std::max(1.0, looked_at),
                              std::min(fleet_numbers::kFreedom, freedom() + more_freedom));
  }

  // Degrees of freedom of a robust deviation over the arms.
  double freedom() const { return fleet_numbers::kEfficiency * (static_cast<double>(arms_.size()) - 1.0); }

  // Number of tested quantities: every own value and the bodies of every arm.
  double looked_at() const {
    return static_cast<double>(arms_.size()) *
           (static_cast<double>(problem_.own().size()) + problem_.joints() + 1.0);
  }

  // Deviations of beta by leaving out one group of arms at a time.
  VectorXd deviations() const {
    const size_t groups = std::min<size_t>(fleet_numbers::kGroups, arms_.size());
    std::vector<SquareRootInformation> of_group(groups, SquareRootInformation(problem_.shared()));
    for (size_t a = 0; a < arms_.size(); ++a)
      if (!fitted_[a].odd) of_group[a % groups].merge(problem_.over_shared(fitted_[a].factor));
    MatrixXd without(beta_.size(), static_cast<Eigen::Index>(groups));
    std::vector<SquareRootInformation> after(groups, SquareRootInformation(problem_.shared()));
    for (size_t g = groups - 1; g > 0; --g) {
      after[g - 1] = after[g];
      after[g - 1].merge(of_group[g]);
    }
    SquareRootInformation before(problem_.shared());
    for (size_t g = 0; g < groups; ++g) {
      SquareRootInformation rest = before;
      rest.merge(after[g]);
      without.col(g) = least_squares(rest);
      before.merge(of_group[g]);
    }
    return jackknife_deviations(without);
  }

  const FleetProblem& problem() const { return problem_; }
  const VectorXd& beta() const { return beta_; }
  const Fitted& fitted(size_t a) const { return fitted_[a]; }

 private:
  template <typename Do>
  void each_arm(const Do& act) {
    parallel_for(static_cast<int>(arms_.size()), options_.threads,
                 [&](int a) { act(static_cast<size_t>(a)); });
  }

  template <typename MeanSquare>
  double scale_of(int, const MeanSquare& mean_square) const {
    std::vector<double> all;
    for (size_t a = 0; a < arms_.size(); ++a) all.push_back(mean_square(a));
    return std::sqrt(median_of(std::move(all)));
  }

  void fit_arm(size_t a, const VectorXd& at_beta) {
    Fitted& f = fitted_[a];
    const VectorXd at_eta = f.eta;
    f.eta = problem_.own_values(f.factor, beta_);
    f.residual2 = problem_.residual2(a, beta_, f.eta, at_beta, at_eta);
    const VectorXd alone = least_squares(f.factor);
    const Eigen::Index own = alone.size() - beta_.size();
    const VectorXd bodies = alone.tail(beta_.size());
    f.alone2 = problem_.residual2(a, bodies, alone.head(own), at_beta, at_eta);
    f.uncertain = f.factor.R()
                      .topLeftCorner(own, own)
                      .triangularView<Eigen::Upper>()
                      .solve(MatrixXd::Identity(own, own))
                      .rowwise()
                      .norm();
    // The part of own columns outside the span of those before them: the diagonal of R. Own columns
    // are few.
    const VectorXd norms = f.factor.column_norms();
    f.telling = f.factor.R().diagonal().head(own).cwiseAbs().cwiseQuotient(
        norms.head(own).cwiseMax(1e-300));
  }

  void find_odd() {
    const std::vector<double> all = excess();
    const auto [median, spread] = centre_of(all);
    const double far = threshold(static_cast<double>(arms_.size()));
    median_excess_ = median;
    size_t count = 0;
    for (size_t a = 0; a < arms_.size(); ++a) {
      fitted_[a].excess = all[a];
      fitted_[a].deviations = (all[a] - median) / std::max(spread, fleet_numbers::kLeastSpread);
      fitted_[a].odd = all[a] > fleet_numbers::kLeastExcess && fitted_[a].deviations > far;
      count += static_cast<size_t>(fitted_[a].odd);
    }
    if (2 * count < arms_.size()) return;
    for (Fitted& f : fitted_) f.odd = false;  // half of a fleet cannot be outliers
  }

  FleetProblem problem_;
  const std::vector<ArmFactor>& arms_;
  const FleetOptions& options_;
  std::vector<Fitted> fitted_;
  VectorXd beta_;
  double median_excess_ = 0.0;
};

// Name of the cause that scales a joint's recorded torque.
std::string gain_name(const Model& arm, int joint) {
  for (const ChannelEffect* effect : channel_effects()) {
    const auto* sensor = dynamic_cast<const SensorError*>(effect);
    if (sensor != nullptr && sensor->scales_torque())
      return to_text(arm, ChannelError{effect->name(), JointIndex{joint}});
  }
  return arm.coordinates()[joint].name;
}

int joint_of(const Model& arm, const std::string& parameter,
             const std::vector<StandardParameter>& parameters) {
  for (const StandardParameter& p : parameters) {
    if (p.name == parameter && p.effect)
      return 1 + main_coordinate(arm.effects()[*p.effect].axis);
  }
  return 0;
}

void add_members(const std::vector<ArmFactor>& arms, const FleetSolver& solver, Fleet& fleet) {
  for (size_t a = 0; a < arms.size(); ++a) {
    const Fitted& f = solver.fitted(a);
    FleetMember member{arms[a].name, arms[a].recordings, arms[a].rows, f.eta, {}, {}};
    for (Eigen::Index k = 0; k < f.eta.size(); ++k)
      if (f.telling[k] < fleet_numbers::kTelling) member.own[k] = kNaN;
    member.own.tail(fleet.joints).array() += 1.0;  // gains as factors
    member.relative_error.resize(fleet.joints);
    member.alone_error.resize(fleet.joints);
    for (int i = 0; i < fleet.joints; ++i) {
      const double torque2 = std::max(1e-300, arms[a].joints[i].rhs_norm2());
      member.relative_error[i] = std::sqrt(f.residual2[i] / torque2);
      member.alone_error[i] = std::sqrt(f.alone2[i] / torque2);
    }
    fleet.rows += arms[a].rows;
    fleet.members.push_back(std::move(member));
  }
}

void add_other_bodies(const FleetSolver& solver, Fleet& fleet) {
  for (size_t a = 0; a < fleet.members.size(); ++a) {
    const Fitted& f = solver.fitted(a);
    if (!f.odd) continue;
    const FleetMember& member = fleet.members[a];
    Eigen::Index joint = 0;
    member.relative_error.cwiseQuotient(member.alone_error.cwiseMax(1e-300)).maxCoeff(&joint);
    fleet.other_bodies.push_back({member.name, static_cast<int>(joint) + 1,
                                  member.relative_error[joint], member.alone_error[joint], f.excess,
                                  solver.median_excess(), f.deviations});
  }
  std::stable_sort(
      fleet.other_bodies.begin(), fleet.other_bodies.end(),
      [](const FleetLeftOut& a, const FleetLeftOut& b) { return a.deviations > b.deviations; });
}

double digamma(double x) {
  return Eigen::numext::digamma(x);
}
double trigamma(double x) {
  return Eigen::numext::polygamma(1.0, x);
}

// One quantity over the arms.
struct Quantity {
  FleetSpread spread;
  int joint = 0;
  std::vector<double> all, uncertain;
  double usual = 0.0;  // median of `uncertain`
};

// What the spreads of quantities of one kind say of the spread of each: a scaled inverse chi-square
// prior of its square, where few arms say little of a spread by themselves. Spreads are compared in
// units of their noise (equal arms) or of their medians (arms that vary by some percent), whichever
// makes them more alike. Source: Smyth, Statistical Applications in Genetics and Molecular Biology
// 3(1), 2004 (moderated t).
struct SpreadPrior {
  double freedom = 0.0;
  double square = 0.0;        // in squared units of `unit`
  double unlike = kInfinity;  // variance of the logarithms of the squares
  double (*unit)(const Quantity&) = nullptr;

  // The spread of a quantity whose robust deviation has `own` degrees of freedom.
  double spread_of(const Quantity& q, double own) const {
    const double part = unit != nullptr ? freedom * square * std::pow(unit(q), 2) : 0.0;
    return std::sqrt((own * std::pow(q.spread.spread, 2) + part) / (own + freedom));
  }
};

SpreadPrior prior_in(double (*unit)(const Quantity&), const std::vector<Quantity>& quantities,
                     double freedom) {
  SpreadPrior prior;
  std::vector<double> logs;
  for (const Quantity& q : quantities)
    if (q.spread.arms >= fleet_numbers::kFewest && q.spread.spread > 0.0 && unit(q) > 0.0)
      logs.push_back(2.0 * std::log(q.spread.spread / unit(q)));
  if (logs.size() < fleet_numbers::kFewestSpreads) return prior;
  const auto count = static_cast<double>(logs.size());
  double mean = 0.0;
  for (const double x : logs) mean += x / count;
  prior.unlike = 0.0;
  for (const double x : logs) prior.unlike += std::pow(x - mean, 2) / (count - 1.0);
  const double between = prior.unlike - trigamma(0.5 * freedom);
  double least = 0.0;
  double most = fleet_numbers::kMostPrior;
  while (trigamma(0.5 * most) < between && most - least > fleet_numbers::kWidth) {
    const double middle = 0.5 * (least + most);
    (trigamma(0.5 * middle) > between ? least : most) = middle;
  }
  prior.unit = unit;
  prior.freedom = most;
  prior.square = std::exp(mean - digamma(0.5 * freedom) + std::log(0.5 * freedom) +
                          digamma(0.5 * most) - std::log(0.5 * most));
  return prior;
}

SpreadPrior prior_of(const std::vector<Quantity>& kind, double freedom) {
  const SpreadPrior noise = prior_in([](const Quantity& q) { return q.usual; }, kind, freedom);
  const SpreadPrior share =
      prior_in([](const Quantity& q) { return std::abs(q.spread.median); }, kind, freedom);
  return noise.unlike <= share.unlike ? noise : share;
}

Quantity quantity(const Model& arm, const FleetSolver& solver, const Fleet& fleet, int k) {
  const FleetProblem& problem = solver.problem();
  const auto own = static_cast<int>(problem.own().size());
  Quantity out;
  for (const FleetMember& m : fleet.members) out.all.push_back(m.own[k]);
  FleetSpread& spread = out.spread;
  spread.name = k < own ? problem.own()[k] : gain_name(arm, k - own);
  for (const StandardParameter& p : problem.parameters())
    if (p.name == spread.name) spread.unit = p.unit;
  std::tie(spread.median, spread.spread) = centre_of(out.all);
  spread.arms = static_cast<int>(
      std::count_if(out.all.begin(), out.all.end(), [](double x) { return std::isfinite(x); }));
  // Precision of this value on one arm relative to most arms, which weights its deviation. The
  // noise is not white, so that the spread of the fleet sets the scale.
  for (size_t a = 0; a < out.all.size(); ++a)
    out.uncertain.push_back(std::isfinite(out.all[a]) ? solver.fitted(a).uncertain[k] : kNaN);
  out.usual = centre_of(out.uncertain).first;
  out.joint = k < own ? joint_of(arm, spread.name, problem.parameters()) : k - own + 1;
  return out;
}

// Names the arms that are far off in a quantity of one kind.
void add_outliers(const std::vector<Quantity>& kind, const FleetSolver& solver, Fleet& fleet) {
  const double freedom = solver.freedom();
  const SpreadPrior prior = prior_of(kind, freedom);
  const double far = solver.threshold(solver.looked_at(), prior.freedom);
  for (const Quantity& q : kind) {
    const FleetSpread& spread = q.spread;
    const double width = prior.spread_of(q, freedom);
    for (size_t a = 0; a < q.all.size() && spread.arms >= fleet_numbers::kFewest && spread.spread > 0.0; ++a) {
      const double wider = q.usual > 0.0 ? std::max(1.0, q.uncertain[a] / q.usual) : 1.0;
      const double deviations = (q.all[a] - spread.median) / (wider * width);
      // Differences below this share of the median are not reported, however narrow the
      // distribution is.
      const bool noticeable =
          std::abs(q.all[a] - spread.median) > fleet_numbers::kNoticeable * std::abs(spread.median);
      if (std::isfinite(q.all[a]) && noticeable && std::abs(deviations) > far)
        fleet.outliers.push_back(
            {fleet.members[a].name, spread.name, q.joint, q.all[a], spread.median, deviations});
    }
  }
}

void add_spreads(const Model& arm, const FleetSolver& solver, Fleet& fleet) {
  const auto own = static_cast<int>(solver.problem().own().size());
  std::vector<Quantity> effects;
  std::vector<Quantity> gains;
  for (int k = 0; k < own + fleet.joints; ++k) {
    std::vector<Quantity>& kind = k < own ? effects : gains;
    kind.push_back(quantity(arm, solver, fleet, k));
    fleet.spreads.push_back(kind.back().spread);
  }
  add_outliers(effects, solver, fleet);
  add_outliers(gains, solver, fleet);
}

void add_parameters(const Model& arm, const FleetSolver& solver, Fleet& fleet) {
  const FleetProblem& problem = solver.problem();
  const std::vector<StandardParameter>& parameters = problem.parameters();
  fleet.parameters = VectorXd::Zero(parameters.size());
  const VectorXd std = solver.deviations();
  Eigen::Index shared = 0;
  size_t own = 0;
  for (int j = 0; j < problem.base().size(); ++j) {
    const int at = problem.base().independent[j];
    const StandardParameter& p = parameters[at];
    if (p.effect) {
      const double median = fleet.spreads[own++].median;
      fleet.parameters[at] = std::isfinite(median) ? median : 0.0;
      continue;
    }
    fleet.parameters[at] = solver.beta()[shared];
    fleet.base.push_back({problem.base().names[j],
                          problem.base().expressions[j], p.unit,
                          solver.beta()[shared], std[shared]});
    ++shared;
  }
  for (size_t p = 0; p < parameters.size(); ++p)
    if (parameters[p].fixed) fleet.parameters[static_cast<Eigen::Index>(p)] = parameters[p].value;
  fleet.model =
      with_values(arm, fleet.parameters, VectorXd::Constant(fleet.parameters.size(), kNaN));
}

// Removes the arms whose own recordings do not determine their bodies: bodies of its own would
// explain everything on such an arm, so that it would always seem to differ.
std::vector<UndeterminedArm> take_undetermined(const Model& arm, std::vector<ArmFactor>& arms) {
  const FleetProblem problem(arm, arms);
  std::vector<UndeterminedArm> out;
  std::vector<ArmFactor> rest;
  for (ArmFactor& one : arms) {
    const bool without_torque = std::all_of(one.joints.begin(), one.joints.end(), [](const auto& joint) {
      return joint.rhs_norm2() == 0.0;
    });
    const std::string why = without_torque ? "its torques are zero throughout" : problem.shortfall_of(one);
    if (why.empty()) {
      rest.push_back(std::move(one));
    } else {
      out.push_back({one.name, why});
    }
  }
  arms = std::move(rest);
  return out;
}

// Reason for a missing result with too few arms.
std::string too_few(size_t left, const std::vector<UndeterminedArm>& undetermined) {
  std::string out = text("found ", left, left == 1 ? " arm" : " arms",
                         undetermined.empty() ? "" : " whose recordings determine the bodies",
                         ", expected ", fleet_numbers::kFewest, " at least");
  if (!undetermined.empty())
    out += "; " + undetermined.front().arm + ": " + undetermined.front().why;
  return out;
}

Fleet solved_fleet(const Model& arm, std::vector<ArmFactor> arms,
                   std::vector<UnusedRecording> unusable_recordings, const FleetOptions& options) {
  arms.erase(
      std::remove_if(arms.begin(), arms.end(), [](const ArmFactor& a) { return a.joints.empty(); }),
      arms.end());
  require(static_cast<int>(arms.size()) >= fleet_numbers::kFewest || unusable_recordings.empty(), "fleet: found ",
          arms.size(), " arms with usable recordings, expected ", fleet_numbers::kFewest,
          " at least; the first that is not: ", unusable_recordings.empty() ? "" : unusable_recordings.front().why);
  if (options.progress) options.progress("solving", fleet_numbers::kReading);
  Fleet fleet;
  fleet.robot = arm.name();
  if (!arms.empty()) fleet.undetermined = take_undetermined(arm, arms);
  if (static_cast<int>(arms.size()) < fleet_numbers::kFewest) {
    fleet.reason = too_few(arms.size(), fleet.undetermined);
    fleet.unusable_recordings = std::move(unusable_recordings);
    return fleet;
  }
  FleetSolver solver(arm, arms, options);
  solver.solve();
  fleet.joints = arm.joints();
  fleet.unusable_recordings = std::move(unusable_recordings);
  add_members(arms, solver, fleet);
  add_other_bodies(solver, fleet);
  add_spreads(arm, solver, fleet);
  std::stable_sort(fleet.outliers.begin(), fleet.outliers.end(),
                   [](const FleetOutlier& a, const FleetOutlier& b) {
                     return std::abs(a.deviations) > std::abs(b.deviations);
                   });
  add_parameters(arm, solver, fleet);
  return fleet;
}

}  // namespace

std::vector<FleetArm> read_fleet(const std::string& path) {
  std::istringstream file(content_of_file(path, "a list of arms and their files"));
  const auto slash = path.find_last_of('/');
  const std::string folder = slash == std::string::npos ? "" : path.substr(0, slash + 1);
  std::vector<FleetArm> out;
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    line = line.substr(0, line.find('#'));
    std::replace_if(
        line.begin(), line.end(), [](char c) { return c == ',' || c == '\r'; }, ' ');
    std::istringstream words(line);
    std::string name;
    std::string recording;
    std::string more;
    if (!(words >> name)) continue;
    words >> recording;
    require(!recording.empty() && !(words >> more), path, ":", number, ": found '", excerpt(line),
            "', expected ARM,FILE.");
    if (out.empty() && name == "arm" && recording == "file") continue;
    if (recording.front() != '/') recording = folder + recording;
    const auto known =
        std::find_if(out.begin(), out.end(), [&](const FleetArm& arm) { return arm.name == name; });
    if (known != out.end()) {
      known->files.push_back(recording);
    } else {
      out.push_back({name, {recording}});
    }
  }
  require(!out.empty(), path, ": found no arm, expected lines ARM,FILE.");
  return out;
}

namespace {

// The factors of one file. A velocity that is no derivative of its position is taken from the
// position, as in identify(), which `remarks` says.
FactorSet factors_of_file(const Model& arm, const std::string& path,
                          const PreprocessingOptions& preprocessing,
                          std::vector<std::string>& remarks) {
  if (is_factor_file(path)) {
    FactorSet set = read_factors(path);
    require_factors_of(arm, set, preprocessing);
    return set;
  }
  IdentificationOptions how;
  how.preprocessing = preprocessing;
  how.threads = 1;
  for (const std::string& remark : remarks_on(leave_wrong_velocities_out(arm, {path}, {}, how), arm))
    remarks.push_back(path + ": " + remark);
  FactorSet set = compress(arm, std::vector<std::string>(), preprocessing, 1);
  set.recordings = compress(arm, std::vector<std::string>{path}, how.preprocessing, 1).recordings;
  return set;
}

}  // namespace

Fleet identify_fleet(const Model& file, const std::vector<FleetArm>& arms,
                     const FleetOptions& options) {
  const Model arm = with_friction(file, JointFriction::kAuto);
  std::vector<ArmFactor> factors(arms.size());
  std::vector<std::vector<UnusedRecording>> unused(arms.size());
  std::vector<std::vector<std::string>> remarks(arms.size());
  std::mutex guard;
  size_t done = 0;
  parallel_for(static_cast<int>(arms.size()), options.threads, [&](int k) {
    const auto at = static_cast<size_t>(k);
    FactorSet set;
    for (const std::string& path : arms[at].files) {
      try {
        FactorSet one = factors_of_file(arm, path, options.preprocessing, remarks[at]);
        for (CompressedRecording& r : one.recordings) {
          require(r.rows > 0.0, r.source, ": found no usable samples.");
          merge_blocks(r, 1);
        }
        set = merge(std::move(set), one);
      } catch (const InvalidInput& error) {
        unused[at].push_back({path, error.what()});
      }
    }
    factors[at] = arm_factor(arm, set, arms[at].name);
    const std::lock_guard<std::mutex> lock(guard);
    ++done;
    if (options.progress)
      options.progress("compressing",
                       fleet_numbers::kReading * static_cast<double>(done) / static_cast<double>(arms.size()));
  });
  std::vector<UnusedRecording> unusable_recordings;
  for (const auto& of_arm : unused) unusable_recordings.insert(unusable_recordings.end(), of_arm.begin(), of_arm.end());
  Fleet fleet = solved_fleet(arm, std::move(factors), std::move(unusable_recordings), options);
  for (const auto& of_arm : remarks)
    fleet.remarks.insert(fleet.remarks.end(), of_arm.begin(), of_arm.end());
  return fleet;
}

Fleet identify_fleet(const Model& file, const std::vector<std::string>& names,
                     const std::vector<FactorSet>& factors, const FleetOptions& options) {
  const Model arm = with_friction(file, JointFriction::kAuto);
  require(names.size() == factors.size(), "fleet: found ", names.size(), " names and ",
          factors.size(), " factor sets, expected one of each per arm.");
  std::vector<ArmFactor> arms;
  std::vector<UnusedRecording> empty;
  for (size_t k = 0; k < names.size(); ++k) {
    require_factors_of(arm, factors[k], options.preprocessing);
    arms.push_back(arm_factor(arm, factors[k], names[k]));
    if (arms.back().joints.empty())
      empty.push_back({names[k], names[k] + ": found no usable samples."});
  }
  return solved_fleet(arm, std::move(arms), std::move(empty), options);
}

}  // namespace veridyn
