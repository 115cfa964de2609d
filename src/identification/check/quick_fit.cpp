#include "identification/check/quick_fit.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "effects/plain_friction.hpp"
#include "identification/base_solution.hpp"
#include "veridyn/effects/effect.hpp"
#include "veridyn/identification/compressed_recording.hpp"
#include "veridyn/regressor/base_parameters.hpp"

namespace veridyn {
namespace {

constexpr int kHalves = 2;

// The arm with plain friction on every coordinate and all parameters free: facts of the file do not
// hold for wrongly recorded signals.
Model with_everything_open(const Model& arm) {
  ModelDescription d = with_plain_friction(arm).description();
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

// Share of a joint's squared torques that the values leave unexplained in each half of the blocks.
VectorXd shares_of_halves(const CompressedRecording& c, int joint, const VectorXd& values) {
  VectorXd left = VectorXd::Zero(kHalves);
  VectorXd all = left;
  for (std::size_t k = 0; k < c.blocks.size(); ++k) {
    const auto half = static_cast<Eigen::Index>(kHalves * k / c.blocks.size());
    left[half] += c.blocks[k][joint].residual2(values);
    all[half] += c.blocks[k][joint].rhs_norm2();
  }
  return left.cwiseQuotient(all.cwiseMax(1e-300));
}

// All rows of a joint, over the parameters that its torque depends on.
SquareRootInformation all_blocks(const CompressedRecording& c, int joint) {
  SquareRootInformation out;
  for (const auto& block : c.blocks) out.merge(block[joint]);
  return out;
}

}  // namespace

// Plain friction along an axis s = c . q: constant against ds, or proportional to it.
struct QuickFitter::Friction {
  VectorXd axis;
  Eigen::Index parameter;  // index among the base parameters
  bool dry;
};

QuickFitter::QuickFitter(const Model& arm, const PreprocessingOptions& options,
                         const CheckThresholds& limits)
    : arm_(with_everything_open(arm)), options_(options), smallest_share_(limits.smallest_share) {
  options_.excluded_intervals.clear();
  options_.first_row = 0;
  options_.row_count.reset();
  options_.min_speed = 0.0;
  parameters_ = standard_parameters(arm_);
  names_ = parameter_names(parameters_);
  const BaseParameters base = base_parameters(arm_);
  for (const int j : base.independent) base_columns_.push_back(names_[j]);
}

std::pair<int, double> QuickFitter::determined(const Recording& recording) const {
  const std::vector<CompressedRecording> c = {compress(arm_, recording, options_)};
  if (c[0].rows == 0.0) return {0, 0.0};
  const VectorXd weights = range_weights(c);
  const BaseParameters found =
      base_parameters(weighted_total(joint_totals(c), weights, names_), preferred_columns(parameters_));
  return {found.size(), solve_base(c, weights, found, names_).condition_number_scaled};
}

QuickFit QuickFitter::fit(const Recording& recording, std::vector<SquareRootInformation>* factors) const {
  const std::vector<CompressedRecording> compressed = {compress(arm_, recording, options_)};
  const CompressedRecording& c = compressed.front();
  QuickFit out;
  const VectorXd weights = range_weights(compressed);
  SquareRootInformation total(names_);
  std::vector<SquareRootInformation> joints;
  for (int i = 0; i < arm_.joints(); ++i) {
    joints.push_back(all_blocks(c, i));
    total.merge(joints.back(), weights[i]);
    if (factors == nullptr) continue;
    factors->emplace_back(names_);
    factors->back().merge(joints.back());
  }
  const SquareRootInformation base = total.restricted(base_columns_);
  const VectorXd beta = base.R().triangularView<Eigen::Upper>().solve(base.z());
  std::unordered_map<std::string, double> values;
  for (int j = 0; j < base_size(); ++j) values[base_columns_[j]] = beta[j];
  out.unexplained = base.rho2() / std::max(base.rhs_norm2(), 1e-300);
  out.halves.resize(arm_.joints(), kHalves);
  for (int i = 0; i < arm_.joints(); ++i) {
    const VectorXd own = values_of(joints[i], values);
    const double share = joints[i].residual2(own) / std::max(joints[i].rhs_norm2(), 1e-300);
    out.halves.row(i) = shares_of_halves(c, i, own).transpose();
    out.misfit += std::log(std::max(share, smallest_share_));
    out.shares.push_back(share);
  }
  const MatrixXd power = friction_power(recording);
  out.friction = power * beta;
  const MatrixXd spread = base.R().triangularView<Eigen::Upper>().transpose().solve(power.transpose());
  for (int i = 0; i < arm_.joints(); ++i)
    out.friction_significance.push_back(std::abs(out.friction[i]) /
                       std::max(spread.col(i).norm() * std::sqrt(base.rho2()), 1e-300));
  return out;
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
