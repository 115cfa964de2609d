#pragma once

#include <cmath>
#include <random>
#include <vector>

#include "support/random.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"
#include "veridyn/effects/effect.hpp"
#include "veridyn/regressor/standard_parameters.hpp"
#include "veridyn/recordings/recording.hpp"

namespace veridyn {

struct MotionShape {
  double duration = 30.0;  ///< [s]
  double rate = 200.0;     ///< [Hz]
  double period = 0.0;     ///< [s]; 0: frequencies without a common period
  double highest = 1.0;    ///< [Hz] of the frequencies
  unsigned seed = 1;
};

/// Sums of five sines within a third of each joint's range, with analytic velocity; no torques yet.
inline Recording sines(const Model& arm, const MotionShape& shape, MatrixXd& ddq) {
  Random random(shape.seed);
  const auto rows = static_cast<Eigen::Index>(std::lround(shape.duration * shape.rate));
  Recording r;
  r.source = "synthetic";
  r.time = VectorXd::LinSpaced(rows, 0.0, static_cast<double>(rows - 1) / shape.rate);
  r.q.resize(rows, arm.joints());
  r.dq = MatrixXd::Zero(rows, arm.joints());
  ddq = r.dq;
  for (int i = 0; i < arm.joints(); ++i) {
    const Coordinate& c = arm.coordinates()[i];
    const bool bounded = std::isfinite(c.limits.lower) && std::isfinite(c.limits.upper);
    const double half = bounded       ? std::min(1.5, 0.5 * (c.limits.upper - c.limits.lower))
                        : c.prismatic ? 0.1
                                      : 1.0;
    r.q.col(i).setConstant(bounded ? 0.5 * (c.limits.lower + c.limits.upper) : 0.0);
    for (int k = 1; k <= 5; ++k) {
      const double f =
          shape.period > 0.0
              ? std::max(1.0, std::floor(shape.highest * shape.period * k / 5.0)) / shape.period
              : random.in(0.1, 1.0) * shape.highest;
      const double w = 2.0 * M_PI * f;
      const double size = half / 3.0 * random.in(0.2, 0.6);
      const Eigen::ArrayXd angle = w * r.time.array() + random.in(0.0, 2.0 * M_PI);
      r.q.col(i).array() += size * angle.sin();
      r.dq.col(i).array() += size * w * angle.cos();
      ddq.col(i).array() -= size * w * w * angle.sin();
    }
  }
  return r;
}

/// Rigid bodies and effects with the arm's own values, sample by sample.
inline MatrixXd torques(const Model& arm, const Recording& r, const MatrixXd& ddq) {
  MatrixXd tau(r.q.rows(), arm.joints());
  std::vector<BoundEffect> effects;
  for (const EffectTerm& term : arm.effects()) effects.emplace_back(arm, term);
  RigidBodyDynamics dynamics(arm, *arm.inertial_values());
  VectorXd row(arm.joints());
  for (Eigen::Index k = 0; k < tau.rows(); ++k) {
    const VectorXd q = r.q.row(k);
    const VectorXd dq = r.dq.row(k);
    const VectorXd a = ddq.row(k);
    dynamics.inverse_dynamics(q, dq, a, row);
    for (BoundEffect& e : effects) {
      row += e.force(e.sample(r.time[k], q.data(), dq.data(), a.data(), 1)) *
             e.term().axis.coefficients;
    }
    tau.row(k) = row;
  }
  return tau;
}

/// What an arm with values records on such a motion, without noise.
inline Recording synthetic_recording(const Model& arm, const MotionShape& shape = {}) {
  MatrixXd ddq;
  Recording r = sines(arm, shape, ddq);
  r.tau = torques(arm, r, ddq);
  return r;
}

/// White noise, each joint's standard deviation so much of its own rms.
inline MatrixXd noise_like(const MatrixXd& tau, double share, unsigned seed) {
  std::mt19937 engine(seed);
  std::normal_distribution<double> normal;
  MatrixXd noise(tau.rows(), tau.cols());
  for (Eigen::Index i = 0; i < tau.cols(); ++i) {
    const double rms = std::sqrt(tau.col(i).squaredNorm() / static_cast<double>(tau.rows()));
    for (Eigen::Index k = 0; k < tau.rows(); ++k) noise(k, i) = share * rms * normal(engine);
  }
  return noise;
}

/// All standard parameters as the arm's file has them.
inline VectorXd true_parameters(const Model& arm) {
  const std::vector<StandardParameter> parameters = standard_parameters(arm);
  VectorXd out(parameters.size());
  for (size_t j = 0; j < parameters.size(); ++j)
    out[static_cast<Eigen::Index>(j)] = parameters[j].value;
  return out;
}

/// Rows of the regressor of bodies and effects at random states.
inline MatrixXd random_regressor(const Model& arm, int states, unsigned seed) {
  Random random(seed);
  const int n = arm.joints();
  MatrixXd Y(states * n, static_cast<Eigen::Index>(standard_parameters(arm).size()));
  for (int k = 0; k < states; ++k) {
    const VectorXd q = random.vector(n, -1, 1);
    const VectorXd dq = random.vector(n, -2, 2);
    const VectorXd ddq = random.vector(n, -5, 5);
    Y.middleRows(k * n, n) = full_regressor(arm, q, dq, ddq);
  }
  return Y;
}

}  // namespace veridyn
