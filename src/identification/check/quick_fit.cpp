#include "identification/check/quick_fit.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "effects/plain_friction.hpp"
#include "identification/estimation/least_squares.hpp"
#include "identification/base_solution.hpp"
#include "math/dense.hpp"
#include "math/median.hpp"
#include "veridyn/effects/effect.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/identification/compressed_recording.hpp"
#include "veridyn/identification/base_parameters.hpp"

namespace veridyn {
namespace {

// The arm with all parameters free: facts of the file do not
// hold for wrongly recorded signals.
Model with_everything_open(const Model& arm) {
  ModelDescription d = arm.description();
  for (EffectTerm& term : d.effects) term.fixed = false;
  for (Frame& frame : d.frames) {
    if (frame.body) frame.body->fixed = false;
  }
  d.identified.reset();
  return Model(std::move(d));
}

// Values of a factor's columns; those without one are zero.
VectorXd values_of(const SquareRootInformation& factor, const std::unordered_map<std::string, double>& values) {
  VectorXd out = VectorXd::Zero(factor.size());
  for (int j = 0; j < factor.size(); ++j) {
    const auto known = values.find(factor.columns()[j]);
    if (known != values.end()) out[j] = known->second;
  }
  return out;
}

// The blocks of a joint, merged into folds.
std::vector<std::vector<SquareRootInformation>> folds_of(const CompressedRecording& c, int joints) {
  std::vector<std::vector<SquareRootInformation>> out(checking::kFolds, std::vector<SquareRootInformation>(static_cast<std::size_t>(joints)));
  for (std::size_t k = 0; k < c.blocks.size(); ++k) {
    for (std::size_t i = 0; i < c.blocks[k].size(); ++i) out[checking::kFolds * k / c.blocks.size()][i].merge(c.blocks[k][i]);
  }
  return out;
}

}  // namespace

// Plain friction along an axis s = c . q: constant against ds, or proportional to it.
struct QuickFitter::Friction {
  VectorXd axis;
  Eigen::Index parameter;  // index among the base parameters
  bool dry;
};

QuickFitter::QuickFitter(const Model& arm, const PreprocessingOptions& options)
    : given_(arm), arm_(with_everything_open(with_effect_of_all_joints(with_plain_friction(arm), kRotorInertia))), options_(options), has_values_(arm.inertial_values().has_value()) {
  options_.excluded_intervals.clear();
  options_.first_row = 0;
  options_.row_count.reset();
  options_.min_speed = 0.0;
  if (options_.cutoff <= checking::kGrid / checking::kRowsAWave) options_.rate = checking::kGrid;
  parameters_ = standard_parameters(arm_);
  names_ = parameter_names(parameters_);
  const BaseParameters base = base_parameters(arm_);
  for (const int j : base.independent) base_columns_.push_back(names_[j]);
}

std::tuple<int, int, double> QuickFitter::determined(const Recording& recording) const {
  // Without rotor inertia, which a motion hardly separates from the inertia of the first links.
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

QuickFit QuickFitter::fit(const Recording& recording) const {
  const int n = arm_.joints();
  QuickFit out;
  out.shares = VectorXd::Ones(n);
  out.folds = MatrixXd::Ones(n, checking::kFolds);
  out.noise2 = noise2(recording);
  out.friction = out.friction_significance = out.ratios = VectorXd::Zero(n);
  std::vector<CompressedRecording> compressed;
  try {
    compressed.push_back(compress(arm_, recording, options_));
  } catch (const InvalidInput&) {
    return out;  // numbers that no recording has, after a transformation
  }
  const CompressedRecording& c = compressed.front();
  if (c.blocks.size() < checking::kFolds) return out;
  const VectorXd weights = range_weights(compressed);
  const auto folds = folds_of(c, n);
  std::vector<SquareRootInformation> base;  // of every fold
  for (const auto& fold : folds) base.push_back(weighted_total(fold, weights, names_).restricted(base_columns_));
  const MatrixXd without = solutions_without(base);
  SquareRootInformation total(base_columns_);
  for (const SquareRootInformation& one : base) total.merge(one);
  const VectorXd beta = least_squares(total);
  VectorXd left = VectorXd::Zero(n), all = left;
  for (int f = 0; f < checking::kFolds; ++f) {
    std::unordered_map<std::string, double> values;
    for (int j = 0; j < base_size(); ++j) values[base_columns_[static_cast<std::size_t>(j)]] = without(j, f);
    for (int i = 0; i < n; ++i) {
      const SquareRootInformation& rows = folds[static_cast<std::size_t>(f)][static_cast<std::size_t>(i)];
      const double residual2 = rows.residual2(values_of(rows, values));
      out.folds(i, f) = residual2 / std::max(rows.rhs_norm2(), 1e-300);
      left[i] += residual2;
      all[i] += rows.rhs_norm2();
    }
  }
  out.shares = left.cwiseQuotient(all.cwiseMax(1e-300)).cwiseMin(1.0);
  for (int i = 0; i < n; ++i) {
    SquareRootInformation rows(names_);
    for (const auto& fold : folds) rows.merge(fold[static_cast<std::size_t>(i)]);
    if (has_values_) out.ratios[i] = ratio(rows);
  }
  const MatrixXd power = friction_power(recording);
  out.friction = power * beta;
  const MatrixXd spread = total.R().triangularView<Eigen::Upper>().transpose().solve(power.transpose());
  for (int i = 0; i < n; ++i)
    out.friction_significance[i] = std::abs(out.friction[i]) / std::max(spread.col(i).norm() * std::sqrt(total.rho2()), 1e-300);
  out.misfit = out.shares.cwiseMax(checking::kSmallestShare * checking::kSmallestShare).array().log().sum();
  out.contradictions = contradictions(out);
  out.misfit += out.contradictions;
  return out;
}

double QuickFitter::contradictions(const QuickFit& fit) const {
  double out = 0.0;
  for (Eigen::Index i = 0; i < fit.shares.size(); ++i) {
    const double rest = checking::kFrictionAboveRest * std::sqrt(fit.shares[i]);
    const bool gives = -fit.friction[i] > std::max(checking::kFrictionShare, rest) && fit.friction_significance[i] > checking::kFrictionSignificance;
    out += gives ? checking::kGivesEnergy : 0.0;
    if (fit.ratios[i] == 0.0) continue;
    const double off = fit.ratios[i] < 0.0 ? checking::kMostOff : std::abs(std::log(fit.ratios[i])) / std::log(checking::kTorqueFactor) - 1.0;
    out += std::clamp(off, 0.0, checking::kMostOff);
  }
  return out;
}

VectorXd QuickFitter::noise2(const Recording& recording) const {
  const double rate = std::min(checking::kGrid, 1.0 / std::max(median_step(recording.time), checking::kShortestStep));
  VectorXd out = VectorXd::Zero(arm_.joints());
  for (Eigen::Index j = 0; j < recording.tau.cols(); ++j) {
    // The median of second differences: friction that reverses is no noise.
    std::vector<double> second;
    double torque2 = 0.0;
    for (Eigen::Index k = 2; k < recording.time.size(); ++k) {
      const double value = std::abs(recording.tau(k, j) - 2.0 * recording.tau(k - 1, j) + recording.tau(k - 2, j));
      if (!std::isfinite(value)) continue;
      second.push_back(value);
      torque2 += recording.tau(k, j) * recording.tau(k, j);
    }
    const double passed = options_.cutoff > 0.0 ? std::min(1.0, 2.0 * options_.cutoff / rate) : 1.0;
    const double deviation = kMadToDeviation * median(second);
    const double noise2 = deviation * deviation / checking::kSecondDifference * static_cast<double>(second.size());
    if (torque2 > 0.0) out[j] = passed * noise2 / torque2;
  }
  return out;
}

VectorXd QuickFitter::springs_apart(const Recording& recording) const {
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
    const int joint = main_coordinate(sprung.effects()[static_cast<std::size_t>(*parameters[p].effect)].axis);
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
    out[joint] = last(base) / std::max(last(offset), 1e-300);
  }
  return out;
}

// Factor between the torques of the file's values and the recorded ones, beside friction and rotor inertia, which
// files lack.
double QuickFitter::ratio(const SquareRootInformation& joint) const {
  std::vector<Eigen::Index> open;
  VectorXd phi = VectorXd::Zero(joint.size());
  for (std::size_t j = 0; j < parameters_.size(); ++j) {
    if (parameters_[j].effect) open.push_back(static_cast<Eigen::Index>(j));
    else if (std::isfinite(parameters_[j].value)) phi[static_cast<Eigen::Index>(j)] = parameters_[j].value;
  }
  const MatrixXd R = joint.R();
  MatrixXd columns(R.rows(), 1 + static_cast<Eigen::Index>(open.size()));
  columns.col(0) = R * phi;
  for (std::size_t k = 0; k < open.size(); ++k) columns.col(1 + static_cast<Eigen::Index>(k)) = R.col(open[k]);
  const VectorXd norms = columns.colwise().norm().transpose().cwiseMax(1e-300);
  if (columns.col(0).norm() < 1e-300) return 0.0;
  const MatrixXd scaled = columns * norms.cwiseInverse().asDiagonal();
  const MatrixXd others = scaled.rightCols(scaled.cols() - 1);
  const VectorXd x = least_norm(scaled, joint.z());
  const double with = (scaled * x - joint.z()).squaredNorm() + joint.rho2();
  const double without = (others * least_norm(others, joint.z()) - joint.z()).squaredNorm() + joint.rho2();
  return with < checking::kTelling * without ? x[0] / norms[0] : 0.0;
}

std::vector<QuickFitter::Friction> QuickFitter::frictions() const {
  std::vector<Friction> out;
  for (std::size_t j = 0; j < base_columns_.size(); ++j) {
    const auto known = std::find(names_.begin(), names_.end(), base_columns_[j]);
    const StandardParameter& p = parameters_[known - names_.begin()];
    if (!p.effect) continue;
    const EffectTerm& term = arm_.effects()[*p.effect];
    const EffectTraits traits = find_effect(term.effect).traits();
    if (!traits.elementary || traits.role != EffectRole::kFriction) continue;
    out.push_back({term.axis.coefficients, static_cast<Eigen::Index>(j),
                   traits.dry == DryFriction::kConstant});
  }
  return out;
}

// Power that friction takes from each joint, by base parameter (joints x base), relative to rms
// torque times rms speed; several axes may share a joint.
MatrixXd QuickFitter::friction_power(const Recording& recording) const {
  const std::vector<Friction> all = frictions();
  MatrixXd power = MatrixXd::Zero(arm_.joints(), base_size());
  VectorXd speed2 = VectorXd::Zero(arm_.joints());
  VectorXd torque2 = speed2;
  for (Eigen::Index k = 1; k < recording.time.size(); ++k) {
    VectorXd v = recording.q.row(k) - recording.q.row(k - 1);
    v /= recording.time[k] - recording.time[k - 1];
    if (recording.dq.size() > 0) v = recording.dq.row(k);
    const VectorXd tau = recording.tau.row(k);
    if (!v.allFinite() || !tau.allFinite()) continue;
    for (const Friction& f : all) {
      const double ds = f.axis.dot(v);
      const double shape = f.dry ? (ds > 0.0 ? 1.0 : ds < 0.0 ? -1.0 : 0.0) : ds;
      power.col(f.parameter) += shape * f.axis.cwiseProduct(v);
    }
    speed2 += v.cwiseAbs2();
    torque2 += tau.cwiseAbs2();
  }
  for (int i = 0; i < arm_.joints(); ++i) {
    const double scale = std::sqrt(torque2[i] * speed2[i]);
    power.row(i) *= scale > 0.0 ? 1.0 / scale : 0.0;
  }
  return power;
}

}  // namespace veridyn
