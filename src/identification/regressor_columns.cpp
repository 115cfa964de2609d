#include "veridyn/identification/regressor_columns.hpp"

#include <algorithm>
#include <cmath>

#include "regressor/effect_along.hpp"
#include "veridyn/effects/channel_effect.hpp"
#include "veridyn/math/zero_phase_filter.hpp"

namespace veridyn {
RegressorColumns::RegressorColumns(const Model& arm, const PreprocessingOptions& options)
    : arm_(arm), options_(options), bodies_(arm), parameters_(standard_parameters(arm)) {
  for (int i = 0; i < arm.joints(); ++i) {
    std::vector<int> mine = bodies_.columns(i);
    for (size_t p = 0; p < parameters_.size(); ++p) {
      const int e = parameters_[p].effect;
      if (e < 0) continue;
      const EffectTerm& term = arm.effects()[e];
      const ChannelEffect* channel = channel_effect(term.effect);
      if (channel != nullptr ? channel->acts_on(i, channel_joint(*channel, term))
                             : term.axis.coefficients[i] != 0.0)
        mine.push_back(static_cast<int>(p));
    }
    of_joint_.push_back(std::move(mine));
  }
}

std::vector<MatrixXd> RegressorColumns::raw_columns(const Stretch& s) const {
  const int n = arm_.joints();
  const Eigen::Index rows = s.q.rows();
  std::vector<MatrixXd> Y(static_cast<size_t>(n));
  std::vector<MatrixXd> body_columns(static_cast<size_t>(n));
  bodies_.evaluate(s.q, s.dq, s.ddq, body_columns);
  for (int i = 0; i < n; ++i) {
    Y[i].resize(rows, static_cast<Eigen::Index>(of_joint_[i].size()));
    Y[i].leftCols(body_columns[i].cols()) = body_columns[i];
  }
  std::vector<Eigen::Index> at(static_cast<size_t>(n));
  for (int i = 0; i < n; ++i) at[i] = body_columns[i].cols();
  MatrixXd load;
  ArmTerms of_arm;
  for (const EffectTerm& term : arm_.effects()) {
    if (const ChannelEffect* channel = channel_effect(term.effect)) {
      of_arm.emplace_back(&term, at);
      for (int i = 0; i < n; ++i) {
        if (!channel->acts_on(i, channel_joint(*channel, term))) continue;
        const auto own = static_cast<Eigen::Index>(channel->parameters().size());
        Y[i].middleCols(at[i], own).setZero();
        at[i] += own;
      }
      continue;
    }
    const BoundEffect effect(arm_, term);
    const MotionView motion(s.time, s.q, s.dq, s.ddq);
    if (effect.traits().uses_load && load.size() == 0) {
      load = rigid_load(arm_, bodies_, motion);
      smooth_load(load, s.dt);
    }
    const MatrixXd columns = columns_along(effect, motion, load, s.start);
    for (int i = 0; i < n; ++i) {
      const double c = term.axis.coefficients[i];
      if (c == 0.0) continue;
      Y[i].middleCols(at[i], columns.cols()) = c * columns;
      at[i] += columns.cols();
    }
  }
  if (!of_arm.empty()) fill_channel_errors(s, of_arm, Y);
  return Y;
}

// Derivatives of what the arm's own values ask for, which all other columns together give.
void RegressorColumns::fill_channel_errors(const Stretch& s, const ArmTerms& terms,
                                           std::vector<MatrixXd>& Y) const {
  const auto n = static_cast<int>(Y.size());
  const auto phi = arm_.inertial_values();
  MatrixXd effort(s.q.rows(), n);
  for (int i = 0; i < n; ++i) {
    VectorXd mine(Y[i].cols());
    for (Eigen::Index p = 0; p < mine.size(); ++p)
      mine[p] = parameters_[static_cast<size_t>(of_joint_[i][static_cast<size_t>(p)])].value;
    effort.col(i) = Y[i] * mine;
  }
  if (!phi) return;
  const ChannelMotion motion{arm_, bodies_, *phi, s.q, s.dq, s.ddq, effort, s.dt};
  for (const auto& [term, at] : terms) {
    const ChannelEffect& channel = *channel_effect(term->effect);
    const int joint = channel_joint(channel, *term);
    const std::vector<MatrixXd> columns = channel.columns(motion, joint);
    for (int i = 0; i < n; ++i) {
      if (!channel.acts_on(i, joint)) continue;
      for (size_t p = 0; p < columns.size(); ++p)
        Y[i].col(at[i] + static_cast<Eigen::Index>(p)) = columns[p].col(i);
    }
  }
}

// See rigid_load().
void RegressorColumns::smooth_load(MatrixXd& load, double dt) const {
  if (options_.filtering != Filtering::kMatched || options_.cutoff <= 0.0) return;
  ZeroPhaseFilter(kLoadCutoffShare * options_.cutoff, options_.order, 1.0 / dt).apply(load);
}

void RegressorColumns::filter(MatrixXd& columns, double dt) const {
  if (options_.filtering != Filtering::kMatched || options_.cutoff <= 0.0) return;
  ZeroPhaseFilter(options_.cutoff, options_.order, 1.0 / dt).apply(columns);
}

bool RegressorColumns::left_out(int joint, double time) const {
  return std::any_of(options_.left_out.begin(), options_.left_out.end(), [&](const LeftOut& part) {
    return (part.joint < 0 || part.joint == joint) && time >= part.from && time <= part.to;
  });
}

std::vector<Eigen::Index> RegressorColumns::kept_samples(const Stretch& s,
                                                         Eigen::Index joint) const {
  const int step = decimation(options_, s.dt);
  std::vector<Eigen::Index> kept;
  for (Eigen::Index k = s.core_begin; k < s.core_end; ++k) {
    // Counted on the time grid, so that it does not matter where a stretch begins.
    const long index = std::lround((s.time[k] - s.start) / s.dt);
    if (s.use[static_cast<size_t>(k)] == 0 || index % step != 0) continue;
    if (left_out(static_cast<int>(joint), s.time[k] - s.start)) continue;
    if (std::abs(s.dq(k, joint)) >= options_.min_speed) kept.push_back(k);
  }
  return kept;
}

std::vector<JointRows> RegressorColumns::rows(const Stretch& s) const {
  std::vector<MatrixXd> Y = raw_columns(s);
  std::vector<JointRows> out(Y.size());
  for (size_t i = 0; i < Y.size(); ++i) {
    // Facts go to the other side.
    MatrixXd both(Y[i].rows(), Y[i].cols() + 1);
    both.rightCols(1) = s.tau.col(static_cast<Eigen::Index>(i));
    Eigen::Index columns = 0;
    for (size_t p = 0; p < of_joint_[i].size(); ++p) {
      const StandardParameter& parameter = parameters_[static_cast<size_t>(of_joint_[i][p])];
      if (parameter.fixed) {
        both.rightCols(1) -= parameter.value * Y[i].col(static_cast<Eigen::Index>(p));
      } else {
        both.col(columns++) = Y[i].col(static_cast<Eigen::Index>(p));
        out[i].parameters.push_back(of_joint_[i][p]);
      }
    }
    both.col(columns) = VectorXd(both.rightCols(1));
    both.conservativeResize(Eigen::NoChange, columns + 1);
    filter(both, s.dt);
    const std::vector<Eigen::Index> kept = kept_samples(s, static_cast<Eigen::Index>(i));
    out[i].A.resize(static_cast<Eigen::Index>(kept.size()), columns);
    out[i].time.resize(static_cast<Eigen::Index>(kept.size()));
    out[i].b.resize(static_cast<Eigen::Index>(kept.size()));
    for (Eigen::Index c = 0; c < columns; ++c) {
      for (size_t k = 0; k < kept.size(); ++k)
        out[i].A(static_cast<Eigen::Index>(k), c) = both(kept[k], c);
    }
    for (size_t k = 0; k < kept.size(); ++k) {
      out[i].b[static_cast<Eigen::Index>(k)] = both(kept[k], columns);
      out[i].time[static_cast<Eigen::Index>(k)] = s.time[kept[k]] - s.start;
    }
    Y[i].resize(0, 0);
  }
  return out;
}

MatrixXd RegressorColumns::filtered_torque(const Stretch& s) const {
  MatrixXd tau = s.tau;
  filter(tau, s.dt);
  return tau;
}

RegressorColumns::Prediction RegressorColumns::predict(const Stretch& s,
                                                       const VectorRef& values) const {
  const std::vector<MatrixXd> Y = raw_columns(s);
  Prediction out{s.tau, MatrixXd::Zero(s.tau.rows(), s.tau.cols())};
  for (size_t i = 0; i < Y.size(); ++i) {
    VectorXd mine(static_cast<Eigen::Index>(of_joint_[i].size()));
    for (size_t p = 0; p < of_joint_[i].size(); ++p)
      mine[static_cast<Eigen::Index>(p)] = values[of_joint_[i][p]];
    out.modelled.col(static_cast<Eigen::Index>(i)) = Y[i] * mine;
  }
  filter(out.measured, s.dt);
  filter(out.modelled, s.dt);
  return out;
}

}  // namespace veridyn
