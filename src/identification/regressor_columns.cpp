#include "veridyn/identification/regressor_columns.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "regressor/effect_along.hpp"
#include "veridyn/effects/channel_effect.hpp"
#include "math/zero_phase_filter.hpp"

namespace veridyn {
namespace {

constexpr Eigen::Index kGroupEntries = 1 << 19;  // entries of columns in memory at once

}  // namespace

RegressorColumns::RegressorColumns(const Model& arm, const PreprocessingOptions& options)
    : arm_(arm),
      options_(options),
      bodies_(arm),
      parameters_(standard_parameters(arm)),
      first_of_effect_(arm.effects().size(), 0) {
  for (size_t p = 0; p < parameters_.size(); ++p) {
    if (parameters_[p].effect && parameters_[p].component == 0)
      first_of_effect_[*parameters_[p].effect] = static_cast<Eigen::Index>(p);
  }
  for (int i = 0; i < arm.joints(); ++i) {
    std::vector<int> mine = bodies_.columns({i});
    for (size_t p = 0; p < parameters_.size(); ++p) {
      if (!parameters_[p].effect) continue;
      const EffectTerm& term = arm.effects()[*parameters_[p].effect];
      const ChannelEffect* channel = channel_effect(term.effect);
      if (channel != nullptr ? channel->acts_on(i, channel_joint(*channel, term))
                             : term.axis.coefficients[i] != 0.0)
        mine.push_back(static_cast<int>(p));
    }
    of_joint_.push_back(std::move(mine));
  }
}

// Columns of the given joints; the other matrices are empty.
std::vector<MatrixXd> RegressorColumns::raw_columns(const Segment& s, Joints joints) const {
  const Eigen::Index rows = s.q.rows();
  std::vector<MatrixXd> Y(of_joint_.size());
  std::vector<Eigen::Index> at(Y.size());
  for (int i = joints.first; i < joints.end; ++i) {
    at[i] = static_cast<Eigen::Index>(bodies_.columns({i}).size());
    Y[i].resize(rows, static_cast<Eigen::Index>(of_joint_[i].size()));
  }
  bodies_.evaluate(s.q, s.body_velocities(), s.ddq, joints.first, joints.end, Y);
  MatrixXd load;
  std::vector<std::vector<Eigen::Index>> at_effect(arm_.effects().size());
  for (size_t e = 0; e < arm_.effects().size(); ++e) {
    const EffectTerm& term = arm_.effects()[e];
    if (const ChannelEffect* channel = channel_effect(term.effect)) {
      at_effect[e] = at;
      for (int i = joints.first; i < joints.end; ++i) {
        if (!channel->acts_on(i, channel_joint(*channel, term))) continue;
        const auto own = static_cast<Eigen::Index>(channel->parameters().size());
        Y[i].middleCols(at[i], own).setZero();
        at[i] += own;
      }
      continue;
    }
    if (term.axis.coefficients.segment(joints.first, joints.end - joints.first).isZero(0.0))
      continue;
    const MatrixXd columns = columns_of(term, s, load);
    for (int i = joints.first; i < joints.end; ++i) {
      const double c = term.axis.coefficients[i];
      if (c == 0.0) continue;
      Y[i].middleCols(at[i], columns.cols()) = c * columns;
      at[i] += columns.cols();
    }
  }
  for_channel_errors(s, [&](size_t e, int i, const std::vector<MatrixXd>& columns) {
    if (i < joints.first || i >= joints.end) return;
    for (size_t p = 0; p < columns.size(); ++p)
      Y[i].col(at_effect[e][i] + static_cast<Eigen::Index>(p)) = columns[p].col(i);
  });
  return Y;
}

// Columns of an effect along its axis; the load of the bodies is computed when the first effect needs it.
MatrixXd RegressorColumns::columns_of(const EffectTerm& term, const Segment& s, MatrixXd& load) const {
  const EffectFacts effect(arm_, term);
  const MotionView motion(s.time, s.q, s.dq, s.ddq);
  if (effect.traits().uses_load && load.size() == 0) {
    load = rigid_load(arm_, bodies_, motion);
    smooth_load(load, s.dt);
  }
  return columns_along(effect.bound(), motion, load, s.start);
}

// Torque of the bodies and of the effects along axes, for given parameters.
MatrixXd RegressorColumns::torque(const Segment& s, const VectorRef& values) const {
  MatrixXd tau, load;
  bodies_.torques(s.q, s.dq, s.ddq,
                  values.head(kBodyParameters * arm_.bodies().size()), tau);
  for (size_t e = 0; e < arm_.effects().size(); ++e) {
    const EffectTerm& term = arm_.effects()[e];
    if (channel_effect(term.effect) != nullptr) continue;
    const MatrixXd columns = columns_of(term, s, load);
    const VectorXd force = columns * values.segment(first_of_effect_[e], columns.cols());
    for (int i = 0; i < arm_.joints(); ++i) {
      if (term.axis.coefficients[i] != 0.0) tau.col(i) += term.axis.coefficients[i] * force;
    }
  }
  return tau;
}

// Columns of sensor errors: derivatives of the torque that the arm's own values predict. Calls put(e, i,
// columns) for every joint i on which such an effect e acts.
template <typename Put>
void RegressorColumns::for_channel_errors(const Segment& s, const Put& put) const {
  const auto phi = arm_.inertial_values();
  if (!phi) return;
  std::optional<ChannelMotion> motion;
  MatrixXd effort;
  for (size_t e = 0; e < arm_.effects().size(); ++e) {
    const EffectTerm& term = arm_.effects()[e];
    const ChannelEffect* channel = channel_effect(term.effect);
    if (channel == nullptr) continue;
    if (!motion) {
      VectorXd own(parameters_.size());
      for (size_t p = 0; p < parameters_.size(); ++p)
        own[static_cast<Eigen::Index>(p)] = parameters_[p].value;
      effort = torque(s, own);
      motion.emplace(ChannelMotion{arm_, bodies_, *phi, s.q, s.dq, s.ddq, effort, s.dt});
    }
    const std::optional<JointIndex> joint = channel_joint(*channel, term);
    motion->from = channel_source(term);
    const std::vector<MatrixXd> columns = channel->columns(*motion, joint);
    for (int i = 0; i < arm_.joints(); ++i) {
      if (channel->acts_on(i, joint)) put(e, i, columns);
    }
  }
}

// Low-passes the load, see rigid_load().
void RegressorColumns::smooth_load(MatrixXd& load, double dt) const {
  if (options_.filtering != Filtering::kMatched || options_.cutoff <= 0.0) return;
  ZeroPhaseFilter(kLoadCutoffShare * options_.cutoff, options_.order, 1.0 / dt).apply(load);
}

void RegressorColumns::filter(MatrixXd& columns, double dt) const {
  if (options_.filtering != Filtering::kMatched || options_.cutoff <= 0.0) return;
  ZeroPhaseFilter(options_.cutoff, options_.order, 1.0 / dt).apply(columns);
}

bool RegressorColumns::is_excluded(JointIndex joint, double time) const {
  return std::any_of(options_.excluded_intervals.begin(), options_.excluded_intervals.end(), [&](const ExcludedInterval& part) {
    return (!part.joint || part.joint == joint) && time >= part.from && time <= part.to;
  });
}

std::vector<Eigen::Index> RegressorColumns::kept_samples(const Segment& s,
                                                         Eigen::Index joint) const {
  const int step = decimation(options_, s.dt);
  std::vector<Eigen::Index> kept;
  for (Eigen::Index k = s.core_begin; k < s.core_end; ++k) {
    // Decimates on the time grid, so that the result does not depend on where a segment starts.
    const long index = std::lround((s.time[k] - s.start) / s.dt);
    if (s.use[k] == 0 || index % step != 0) continue;
    if (is_excluded({static_cast<int>(joint)}, s.time[k] - s.start)) continue;
    if (std::abs(s.dq(k, joint)) >= options_.min_speed) kept.push_back(k);
  }
  return kept;
}

std::vector<RegressorColumns::Joints> RegressorColumns::groups(Eigen::Index rows) const {
  std::vector<Joints> out;
  Eigen::Index columns = 0;
  for (int i = 0; i < arm_.joints(); ++i) {
    const auto mine = static_cast<Eigen::Index>(of_joint_[i].size());
    if (out.empty() || (columns + mine) * rows > kGroupEntries) {
      out.push_back({i, i});
      columns = 0;
    }
    out.back().end = i + 1;
    columns += mine;
  }
  return out;
}

std::vector<JointRows> RegressorColumns::rows(const Segment& s) const {
  std::vector<JointRows> out;
  for (const Joints joints : groups(s.q.rows())) {
    for (JointRows& joint : rows(s, joints)) out.push_back(std::move(joint));
  }
  return out;
}

std::vector<JointRows> RegressorColumns::rows(const Segment& s, Joints joints) const {
  std::vector<MatrixXd> Y = raw_columns(s, joints);
  const MatrixXd of_arm = arm_effect_torques(arm_, bodies_, s.q, s.dq, s.ddq, s.dt);
  std::vector<JointRows> out;
  for (int i = joints.first; i < joints.end; ++i) {
    MatrixXd& mine = Y[i];
    JointRows of;
    MatrixXd b = s.tau.col(i);
    if (of_arm.size() > 0) b -= of_arm.col(i);
    std::vector<Eigen::Index> free;
    for (size_t p = 0; p < of_joint_[i].size(); ++p) {
      const int own = of_joint_[i][p];
      const StandardParameter& parameter = parameters_[own];
      const auto column = static_cast<Eigen::Index>(p);
      if (parameter.fixed) {  // known values move to the right-hand side
        b -= parameter.value * mine.col(column);
        continue;
      }
      const auto next = static_cast<Eigen::Index>(free.size());
      if (next != column) mine.col(next) = mine.col(column);
      free.push_back(column);
      of.parameters.push_back(own);
    }
    const auto columns = static_cast<Eigen::Index>(free.size());
    if (columns != mine.cols()) mine.conservativeResize(Eigen::NoChange, columns);
    filter(mine, s.dt);
    filter(b, s.dt);
    const std::vector<Eigen::Index> kept = kept_samples(s, i);
    const auto rows = static_cast<Eigen::Index>(kept.size());
    of.A.resize(rows, columns);
    of.b.resize(rows);
    of.time.resize(rows);
    for (Eigen::Index c = 0; c < columns; ++c) {
      for (Eigen::Index k = 0; k < rows; ++k)
        of.A(k, c) = mine(kept[k], c);
    }
    for (Eigen::Index k = 0; k < rows; ++k) {
      of.b[k] = b(kept[k], 0);
      of.time[k] = s.time[kept[k]] - s.start;
    }
    for (Eigen::Index k = 0; !options_.weights.empty() && k < rows; ++k) {
      const double root = std::sqrt(options_.weights.begin()->second->at({i}, of.time[k]));
      of.A.row(k) *= root;
      of.b[k] *= root;
    }
    out.push_back(std::move(of));
    mine.resize(0, 0);
  }
  return out;
}

MatrixXd RegressorColumns::filtered_torque(const Segment& s) const {
  MatrixXd tau = s.tau;
  filter(tau, s.dt);
  return tau;
}

RegressorColumns::Prediction RegressorColumns::predict(const Segment& s,
                                                       const VectorRef& values) const {
  Prediction out{s.tau, torque(s, values)};
  for_channel_errors(s, [&](size_t e, int i, const std::vector<MatrixXd>& columns) {
    for (size_t p = 0; p < columns.size(); ++p)
      out.modelled.col(i) += values[first_of_effect_[e] + static_cast<Eigen::Index>(p)] * columns[p].col(i);
  });
  const MatrixXd of_arm = arm_effect_torques(arm_, bodies_, s.q, s.dq, s.ddq, s.dt);
  if (of_arm.size() > 0) out.modelled += of_arm;
  filter(out.measured, s.dt);
  filter(out.modelled, s.dt);
  return out;
}

}  // namespace veridyn
