#include "identification/check/quick_fit.hpp"

#include <algorithm>
#include <cmath>

#include "effects/plain_friction.hpp"
#include "identification/estimation/least_squares.hpp"
#include "identification/base_solution.hpp"
#include "math/median.hpp"
#include "veridyn/effects/effect.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/identification/compressed_recording.hpp"
#include "veridyn/identification/regressor_columns.hpp"
#include "veridyn/identification/base_parameters.hpp"

namespace veridyn {
namespace {

// The arm with all parameters free, because known values of the file are invalid for wrongly recorded
// signals.
Model with_everything_open(const Model& arm) {
  ModelDescription d = arm.description();
  for (EffectTerm& term : d.effects) term.fixed = false;
  for (Frame& frame : d.frames) {
    if (frame.body) frame.body->fixed = false;
  }
  d.identified.reset();
  return Model(std::move(d));
}

// Least squares A x ~ b from the products [A, b]' [A, b]; columns may be dependent.
VectorXd solution(const MatrixXd& products) {
  const Eigen::Index size = products.rows() - 1;
  const VectorXd scale = products.diagonal().head(size).cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  MatrixXd G = scale.asDiagonal() * products.topLeftCorner(size, size) * scale.asDiagonal();
  G.diagonal().array() += checking::kRidge;
  return scale.cwiseProduct(normal_solution(G, scale.cwiseProduct(products.col(size).head(size))));
}

double sum_of_logs(const VectorXd& shares) {
  return shares.cwiseMax(checking::kSmallestShare * checking::kSmallestShare).array().log().sum();
}

// || A x - b ||^2
double residual2(const MatrixXd& products, VectorXd x) {
  x.conservativeResize(x.size() + 1);
  x[x.size() - 1] = -1.0;
  return std::max(0.0, x.dot(products * x));
}

// Products of (A M, b) from those of (A, b), or of (A, B M) from those of (A, B).
MatrixXd changed(const MatrixXd& products, const MatrixXd& left, const MatrixXd& right) {
  MatrixXd map = MatrixXd::Zero(left.rows() + right.rows(), left.cols() + right.cols());
  map.topLeftCorner(left.rows(), left.cols()) = left;
  map.bottomRightCorner(right.rows(), right.cols()) = right;
  return map.transpose() * products * map;
}

}  // namespace

QuickFitter::QuickFitter(const Model& arm, const PreprocessingOptions& options, const RecordedFacts& facts)
    : given_(arm), arm_(with_everything_open(with_effect_of_all_joints(with_plain_friction(arm), kRotorInertia))), options_(options), facts_(facts), has_values_(arm.inertial_values().has_value()) {
  options_.excluded_intervals.clear();
  options_.first_row = 0;
  options_.row_count.reset();
  options_.min_speed = 0.0;
  const double grid = std::max(checking::kGrid, checking::kRowsAWave * options_.cutoff);
  if (grid == checking::kGrid || grid < facts.rate) options_.rate = grid;
  parameters_ = standard_parameters(arm_);
  base_ = base_parameters(arm_);
  VectorXd values = VectorXd::Zero(base_.K.cols());
  std::vector<int> effects;
  for (int j = 0; j < base_.K.cols(); ++j) {
    if (parameters_[j].effect) effects.push_back(j);
    else if (std::isfinite(parameters_[j].value)) values[j] = parameters_[j].value;
  }
  known_.resize(base_.size(), 1 + static_cast<Eigen::Index>(effects.size()));
  known_ << base_.K * values, base_.K(Eigen::all, effects);
}

std::tuple<int, int, double> QuickFitter::rank_and_condition(const Recording& recording) const {
  // Rotor inertia is left out, since a motion hardly separates it from the inertia of the first links.
  const Model plain = with_everything_open(with_plain_friction(given_));
  const std::vector<CompressedRecording> c = {compress(plain, recording, options_)};
  const std::vector<StandardParameter> parameters = standard_parameters(plain);
  const std::vector<std::string> names = parameter_names(parameters);
  const int all = base_parameters(plain).size();
  if (c[0].rows == 0.0) return {0, all, 0.0};
  const VectorXd weights = range_weights(c);
  const BaseParameters found = base_parameters(weighted_total(joint_totals(c), weights, names), preferred_columns(parameters));
  return {found.size(), all, solve_base(c, weights, found, names).condition_number_scaled};
}

std::shared_ptr<const RegressorMoments> QuickFitter::moments(const Recording& recording) const {
  const int n = arm_.joints();
  const RegressorColumns columns(arm_, options_);
  const auto out = std::make_shared<RegressorMoments>();
  std::vector<std::vector<int>> own(static_cast<std::size_t>(n));  // indices of the base columns among those of a joint
  out->columns.resize(own.size());
  for (int i = 0; i < n; ++i) {
    const std::vector<int>& all = columns.parameters_of({i});
    for (int j = 0; j < base_.size(); ++j) {
      const auto there = std::find(all.begin(), all.end(), base_.independent[j]);
      if (there == all.end()) continue;
      own[i].push_back(static_cast<int>(there - all.begin()));
      out->columns[i].push_back(j);
    }
  }
  std::vector<MatrixXd> none;
  for (const std::vector<int>& mine : own) none.push_back(MatrixXd::Zero(static_cast<int>(mine.size()) + n, static_cast<int>(mine.size()) + n));
  out->products.assign(checking::kFolds, none);
  out->power = MatrixXd::Zero(n, base_.size());
  out->speed2 = VectorXd::Zero(n);
  // Folds divide the time from the end of the start-up to the last torque, so that no fold is empty. Segments count from the first one.
  double begin = 0.0, duration = 0.0;
  for (Eigen::Index k = 0; k < recording.tau.rows(); ++k) {
    if (!recording.tau.row(k).array().isFinite().any()) continue;
    if (duration == 0.0) begin = recording.time[k];
    duration = std::max(recording.time[k] - begin, checking::kShortestStep);
  }
  const bool repeats = facts_.period > 0.0 && duration >= facts_.period;
  const auto fold_of = [&](double time) {
    const double turns = repeats ? time / facts_.period : (time - options_.drop_start) / std::max(duration - options_.drop_start, checking::kShortestStep);
    return std::clamp(static_cast<int>(checking::kFolds * (repeats ? turns - std::floor(turns) : turns)), 0, checking::kFolds - 1);
  };
  const auto add = [&](const Segment& s) {
    const std::vector<JointRows> rows = columns.rows(s);
    const VectorXd& time = rows.front().time;
    std::vector<Eigen::Index> kept;  // rows of the segment
    for (Eigen::Index k = 0, at = s.core_begin; k < time.size(); kept.push_back(at), ++k) {
      while (s.time[at] - s.start < time[k]) ++at;
    }
    const MatrixXd tau = columns.filtered_torque(s)(kept, Eigen::all);
    add_power(s.dq(kept, Eigen::all), *out);
    for (Eigen::Index first = 0, end = 0; first < time.size(); first = end) {
      const int f = fold_of(time[first]);
      while (end < time.size() && fold_of(time[end]) == f) ++end;
      for (int i = 0; i < n; ++i) {
        MatrixXd rows_of(end - first, out->products[f][i].cols());
        rows_of << rows[i].A(Eigen::seqN(first, end - first), own[i]), tau.middleRows(first, end - first);
        out->products[f][i].selfadjointView<Eigen::Lower>().rankUpdate(rows_of.transpose());
      }
    }
  };
  try {
    for_each_segment(arm_, recording, options_, add);
  } catch (const InvalidInput&) {
    return nullptr;  // a transformation has produced numbers that no recording can have
  }
  for (std::vector<MatrixXd>& fold : out->products) {
    for (MatrixXd& products : fold) {
      products = MatrixXd(products.selfadjointView<Eigen::Lower>());
      if (!products.allFinite() || products.bottomRightCorner(n, n).isZero(0.0)) return nullptr;
    }
  }
  return out;
}

QuickFit QuickFitter::fit(const std::shared_ptr<const RegressorMoments>& moments, const MatrixXd& torques) const {
  const int n = arm_.joints(), size = base_.size();
  QuickFit out;
  out.moments = moments;
  out.shares = out.fitted = VectorXd::Ones(n);
  out.folds = MatrixXd::Ones(n, checking::kFolds);
  out.friction = out.friction_significance = out.ratios = out.noise2 = out.alone = out.together = VectorXd::Zero(n);
  for (int i = 0; i < n; ++i) {
    Eigen::Index from = 0;
    torques.col(i).cwiseAbs().maxCoeff(&from);
    out.noise2[i] = facts_.noise2[from];
  }
  if (moments == nullptr) return out;
  // Products of the columns and the torque, for each fold and joint, and their sum.
  std::vector<std::vector<MatrixXd>> folds = moments->products;
  std::vector<MatrixXd> sums(static_cast<std::size_t>(n));
  VectorXd all(n), left = VectorXd::Zero(n);
  for (int i = 0; i < n; ++i) {
    const auto own = static_cast<Eigen::Index>(moments->columns[i].size());
    sums[i] = MatrixXd::Zero(own + 1, own + 1);
    for (std::vector<MatrixXd>& fold : folds) sums[i] += fold[i] = changed(fold[i], MatrixXd::Identity(own, own), torques.col(i));
    all[i] = sums[i](own, own);
    if (has_values_) out.ratios[i] = ratio(sums[i], moments->columns[i]);
  }
  const VectorXd weights = (all.array() > 0.0).select(all.array().inverse(), 0.0);
  std::vector<MatrixXd> of_fold(checking::kFolds, MatrixXd::Zero(size + 1, size + 1));
  MatrixXd total = of_fold[0], of_torque = MatrixXd::Zero(size, n);
  for (int i = 0; i < n; ++i) {
    std::vector<int> places = moments->columns[i];
    of_torque(places, i) = weights[i] * sums[i].col(sums[i].cols() - 1).head(sums[i].cols() - 1);
    places.push_back(size);
    for (int f = 0; f < checking::kFolds; ++f) of_fold[f](places, places) += weights[i] * folds[f][i];
    total(places, places) += weights[i] * sums[i];
  }
  for (int f = 0; f < checking::kFolds; ++f) {
    const VectorXd beta = solution(total - of_fold[f]);
    for (int i = 0; i < n; ++i) {
      const double error2 = residual2(folds[f][i], beta(moments->columns[i]));
      out.folds(i, f) = error2 / std::max(folds[f][i].bottomRightCorner<1, 1>().value(), 1e-300);
      left[i] += error2;
    }
  }
  // The unexplained share of a joint without torque is zero.
  out.shares = (all.array() > 0.0).select(left.cwiseQuotient(all.cwiseMax(1e-300)).cwiseMin(1.0), 0.0);
  const auto solved = [&](const VectorXd& rhs) {
    total.col(size).head(size) = rhs;
    return solution(total);
  };
  const VectorXd beta = solution(total);
  for (int i = 0; i < n; ++i) out.fitted[i] = all[i] > 0.0 ? residual2(sums[i], beta(moments->columns[i])) / all[i] : 0.0;
  const double rho = std::sqrt(residual2(total, beta));
  for (int i = 0; i < n; ++i) {
    const VectorXd power = moments->power.row(i).transpose() / std::max(std::sqrt(all[i] * moments->speed2[i]), 1e-300);
    out.friction[i] = power.dot(beta);
    out.friction_significance[i] = std::abs(out.friction[i]) / std::max(std::sqrt(std::max(0.0, power.dot(solved(power)))) * rho, 1e-300);
  }
  // Squared residuals as a quadratic form in one factor for each joint's torque, with all other parameters
  // fitted. A joint whose torque depends on its own parameters only does not determine a factor.
  MatrixXd Q = MatrixXd::Identity(n + 1, n + 1);
  for (int i = 0; i < n; ++i) Q.col(i).head(n) -= of_torque.transpose() * solved(of_torque.col(i));
  for (int i = 0; i < n; ++i) {
    out.alone[i] = 1.0 - Q.row(i).head(n).sum() / std::max(Q(i, i), 1e-300);
    if (Q(i, i) > checking::kPoorFit * checking::kPoorFit) continue;
    out.alone[i] = out.ratios[i] != 0.0 ? 1.0 / out.ratios[i] : 1.0;
    Q.row(i).setZero();
    Q.col(i).setZero();
    Q(i, i) = 1.0;
  }
  out.together = VectorXd::Ones(n);  // the eigenvector of the smallest eigenvalue
  for (int k = 0; k < checking::kPowers; ++k) {
    Q.col(n).head(n) = out.together;
    out.together = solution(Q).normalized();
  }
  if (out.together.sum() < 0.0) out.together *= -1.0;
  out.contradictions = contradiction_cost(out);
  out.misfit = sum_of_logs(out.shares) + out.contradictions;
  out.fitted_misfit = sum_of_logs(out.fitted) + out.contradictions;
  out.values = beta;
  return out;
}

double QuickFitter::misfit_of(const VectorXd& values, const RegressorMoments& moments, const MatrixXd& torques) const {
  VectorXd shares = VectorXd::Zero(torques.cols());
  for (int i = 0; i < arm_.joints(); ++i) {
    const auto own = static_cast<Eigen::Index>(moments.columns[i].size());
    MatrixXd sum = MatrixXd::Zero(own + 1, own + 1);
    for (const std::vector<MatrixXd>& fold : moments.products) sum += changed(fold[i], MatrixXd::Identity(own, own), torques.col(i));
    if (sum(own, own) > 0.0) shares[i] = residual2(sum, values(moments.columns[i])) / sum(own, own);
  }
  return sum_of_logs(shares);
}

// Sum over the joints of the costs of friction that clearly feeds power, and of torques that have the opposite sign or
// another magnitude than the file's values imply.
double QuickFitter::contradiction_cost(const QuickFit& fit) const {
  double out = 0.0;
  for (Eigen::Index i = 0; i < fit.shares.size(); ++i) {
    const double rest = checking::kFrictionAboveRest * std::sqrt(fit.shares[i]);
    const bool gives = -fit.friction[i] > std::max(checking::kFrictionShare, rest) && fit.friction_significance[i] > checking::kFrictionSignificance;
    out += gives ? checking::kNegativeFrictionCost : 0.0;
    if (fit.ratios[i] == 0.0) continue;
    const double off = fit.ratios[i] < 0.0 ? checking::kMostOff : std::abs(std::log(fit.ratios[i])) / std::log(checking::kTorqueFactor) - 1.0;
    out += std::clamp(off, 0.0, checking::kMostOff);
  }
  return out;
}

RecordedFacts facts_of(const Recording& recording, const PreprocessingOptions& options) {
  RecordedFacts out{1.0 / std::max(median_step(recording.time), checking::kShortestStep), detect_period(recording).seconds, VectorXd::Zero(recording.tau.cols())};
  const double rate = std::min(checking::kGrid, out.rate);
  for (Eigen::Index j = 0; j < recording.tau.cols(); ++j) {
    // Noise by the median of second differences, which ignores reversals of friction.
    std::vector<double> second;
    double torque2 = 0.0;
    for (Eigen::Index k = 2; k < recording.time.size(); ++k) {
      const double value = std::abs(recording.tau(k, j) - 2.0 * recording.tau(k - 1, j) + recording.tau(k - 2, j));
      if (!std::isfinite(value)) continue;
      second.push_back(value);
      torque2 += recording.tau(k, j) * recording.tau(k, j);
    }
    const double passed = options.cutoff > 0.0 ? std::min(1.0, 2.0 * options.cutoff / rate) : 1.0;
    const double deviation = kMadToDeviation * median(second);
    const double noise2 = deviation * deviation / checking::kSecondDifference * static_cast<double>(second.size());
    if (torque2 > 0.0) out.noise2[j] = passed * noise2 / torque2;
  }
  return out;
}

VectorXd QuickFitter::independent_spring_shares(const Recording& recording) const {
  const Model plain = with_everything_open(with_plain_friction(given_));
  const Model sprung = with_everything_open(with_effect_of_all_joints(plain, kJointSpring));
  const std::vector<CompressedRecording> c = {compress(sprung, recording, options_)};
  const std::vector<StandardParameter> parameters = standard_parameters(sprung);
  const std::vector<std::string> names = parameter_names(parameters), of_plain = parameter_names(standard_parameters(plain));
  const SquareRootInformation total = weighted_total(joint_totals(c), range_weights(c), names);
  std::vector<std::string> base;
  for (const int j : base_parameters(plain).independent) base.push_back(of_plain[static_cast<std::size_t>(j)]);
  VectorXd out = VectorXd::Ones(arm_.joints());
  for (std::size_t p = 0; p < parameters.size(); ++p) {
    if (!parameters[p].effect || sprung.effects()[static_cast<std::size_t>(*parameters[p].effect)].effect != kJointSpring) continue;
    const JointIndex joint = main_coordinate(sprung.effects()[static_cast<std::size_t>(*parameters[p].effect)].axis);
    const auto last = [&](std::vector<std::string> columns) {
      columns.push_back(names[p]);
      const MatrixXd R = total.restricted(columns).R();
      return std::abs(R(R.rows() - 1, R.cols() - 1));
    };
    std::vector<std::string> offset;
    for (std::size_t k = 0; k < parameters.size(); ++k) {
      if (!parameters[k].effect) continue;
      const EffectTerm& term = sprung.effects()[static_cast<std::size_t>(*parameters[k].effect)];
      if (term.effect == kPlainOffset && main_coordinate(term.axis) == joint) offset = {names[k]};
    }
    out[joint.value] = last(base) / std::max(last(offset), 1e-300);
  }
  return out;
}

// Ratio of the recorded torques to those of the file's values, with friction and rotor inertia, which files
// do not contain, fitted in addition.
double QuickFitter::ratio(const MatrixXd& products, const std::vector<int>& columns) const {
  const MatrixXd H = changed(products, known_(columns, Eigen::all), MatrixXd::Ones(1, 1));
  if (H(0, 0) < 1e-300) return 0.0;
  const MatrixXd without = H.bottomRightCorner(H.rows() - 1, H.cols() - 1);
  const VectorXd x = solution(H);
  return residual2(H, x) < checking::kFileTorquesUsable * residual2(without, solution(without)) ? x[0] : 0.0;
}

// Adds the power that plain friction along an axis s = c . q dissipates, with constant torque and with torque
// proportional to ds; several axes may act on one joint.
void QuickFitter::add_power(const MatrixXd& dq, RegressorMoments& out) const {
  for (int j = 0; j < base_.size(); ++j) {
    const StandardParameter& p = parameters_[base_.independent[j]];
    if (!p.effect) continue;
    const EffectTerm& term = arm_.effects()[*p.effect];
    const EffectTraits traits = find_effect(term.effect).traits();
    if (!traits.elementary || traits.role != EffectRole::kFriction) continue;
    const VectorXd ds = dq * term.axis.coefficients;
    const VectorXd shape = traits.dry == DryFriction::kConstant ? VectorXd(ds.cwiseSign()) : ds;
    out.power.col(j) += term.axis.coefficients.cwiseProduct(dq.transpose() * shape);
  }
  out.speed2 += dq.colwise().squaredNorm().transpose();
}

}  // namespace veridyn
