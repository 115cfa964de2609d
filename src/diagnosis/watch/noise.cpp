#include "diagnosis/watch/noise.hpp"

#include <algorithm>
#include <cmath>

#include "identification/estimation/least_squares.hpp"
#include "veridyn/effects/effect.hpp"

namespace veridyn::watching {

NoiseModel::NoiseModel(const Model& arm, const std::vector<Hypothesis>& hypotheses,
                       const WatchNumbers& numbers)
    : numbers_(numbers),
      n_(arm.joints()),
      ar_(MatrixXd::Zero(arm.joints(), kOrder)),
      deviation_(VectorXd::Ones(arm.joints())),
      today_(VectorXd::Zero(hypotheses.size())),
      scale_(VectorXd::Ones(arm.joints())) {
  for (size_t h = 0; h < hypotheses.size(); ++h) {
    const Hypothesis& one = hypotheses[h];
    if (!one.along_axis()) continue;
    daily_.push_back(static_cast<int>(h));
    joint_of_.push_back(one.of.joint->value);
    speed_of_.push_back(one.speed(numbers_.slow));
  }
}

VectorXd NoiseModel::rest(const Step& step, const VectorXd& known) const {
  return step.residual - step.columns * (today_ + known);
}

double NoiseModel::novelty(const Step& step, int joint) const {
  double beyond = 0.0;
  for (Eigen::Index p = 0; p < envelope_.cols(); ++p)
    beyond += std::max(0.0, step.parts(joint, p) - numbers_.beyond * envelope_(joint, p));
  return beyond;
}

bool NoiseModel::novel(const Step& step) const {
  for (int j = 0; j < n_; ++j)
    if (0.5 * novelty(step, j) > deviation_[j]) return true;
  return false;
}

void NoiseModel::fit(const std::vector<Step>& before, const std::vector<Step>& today) {
  if (before.size() + today.size() < static_cast<size_t>(numbers_.steps_for_pole * kOrder)) return;
  const std::vector<const std::vector<Step>*> all = {&before, &today};
  scale_.setZero();
  envelope_ = MatrixXd::Zero(n_, 3);
  for (const auto* part : all) {
    for (const Step& s : *part) {
      scale_ += s.torque.cwiseAbs2() / static_cast<double>(before.size() + today.size());
      envelope_ = envelope_.cwiseMax(s.parts);
    }
  }
  scale_ = scale_.cwiseSqrt();
  today_.setZero();
  ar_.setZero();
  fit_autoregression(all);
  fit_daily_offsets(today);
  fit_autoregression(all);
}

// Autoregression of every joint's residual on the two previous steps; poles are moved inside the
// unit circle.
void NoiseModel::fit_autoregression(const std::vector<const std::vector<Step>*>& quiet) {
  std::vector<VectorXd> rest;
  std::vector<const Step*> steps;
  for (const auto* part : quiet) {
    for (const Step& s : *part) {
      // Earlier days have their own differences subtracted already.
      rest.push_back(part == quiet.back() ? VectorXd(s.residual - s.columns * today_) : s.residual);
      steps.push_back(&s);
    }
  }
  for (int j = 0; j < n_; ++j) {
    Eigen::Matrix2d R = Eigen::Matrix2d::Zero();
    Eigen::Vector2d r = Eigen::Vector2d::Zero();
    double power = 0.0;
    double count = 0.0;
    const auto sound = [&](size_t k) { return steps[k]->rest_friction2[j] <= 0.0; };
    for (size_t k = kOrder; k < steps.size(); ++k) {
      if (!steps[k]->follows || !steps[k - 1]->follows || !sound(k) || !sound(k - 1) || !sound(k - 2))
        continue;
      const Eigen::Vector2d x(rest[k - 1][j], rest[k - 2][j]);
      R += x * x.transpose();
      r += x * rest[k][j];
      power += rest[k][j] * rest[k][j];
      count += 1.0;
    }
    const double least = std::max(numbers_.least_share * scale_[j], kNothing);
    ar_.row(j).setZero();
    deviation_[j] = least;
    // At rest or nearly so: only the bound of friction at rest is known.
    if (count < numbers_.steps_for_pole * kOrder) {
      double all = 0.0;
      for (const VectorXd& x : rest) all += x[j] * x[j];
      deviation_[j] = std::max(least, std::sqrt(all / static_cast<double>(rest.size())));
      continue;
    }
    const double ridge = count * least * least;
    Eigen::Vector2d a = normal_solution(R + ridge * Eigen::Matrix2d::Identity(), r);
    // Schur's condition for both poles inside the unit circle.
    a[1] = std::clamp(a[1], -numbers_.largest_pole, numbers_.largest_pole);
    a[0] = std::clamp(a[0], -numbers_.largest_pole * (1.0 - a[1]), numbers_.largest_pole * (1.0 - a[1]));
    const double left = power - 2.0 * a.dot(r) + a.dot(R * a);
    ar_.row(j) = a.transpose();
    deviation_[j] =
        std::max(least, std::sqrt(std::max(left, 0.0) / std::max(count - kOrder, 1.0)));
  }
}

// Offsets and friction of the day: generalised least squares with a prior of the size of the torque.
void NoiseModel::fit_daily_offsets(const std::vector<Step>& quiet) {
  const auto count = static_cast<Eigen::Index>(daily_.size());
  if (quiet.empty()) return;
  MatrixXd A = MatrixXd::Zero(count, count);
  VectorXd b = VectorXd::Zero(count);
  today_.setZero();
  past_.clear();
  const VectorXd none = VectorXd::Zero(today_.size());
  for (const Step& s : quiet) {
    const WhiteStep w = whiten(s, none);
    for (Eigen::Index p = 0; p < count; ++p) {
      const int h = daily_[p];
      const int j = joint_of_[p];
      b[p] += w.X(j, h) * w.e[j];
      for (Eigen::Index o = 0; o < count; ++o) A(p, o) += w.X(j, h) * w.X(j, daily_[o]);
    }
  }
  past_.clear();
  for (Eigen::Index p = 0; p < count; ++p) {
    const int j = joint_of_[p];
    const double prior = scale_[j] / speed_of_[p];
    A(p, p) += 1.0 / std::max(prior * prior, kNothing * kNothing);
  }
  const VectorXd x = normal_solution(A, b);
  for (Eigen::Index p = 0; p < count; ++p) today_[daily_[p]] = x[p];
}

WhiteStep NoiseModel::whiten(const Step& step, const VectorXd& known) {
  if (!step.follows) past_.clear();
  WhiteStep out;
  out.time = step.time;
  out.e = rest(step, known);
  out.X = step.columns;
  for (size_t l = 0; l < past_.size(); ++l) {
    const VectorXd a = ar_.col(l);
    out.e -= a.cwiseProduct(rest(past_[l], known));
    out.X -= a.asDiagonal() * past_[l].columns;
  }
  past_.push_front(step);
  if (past_.size() > kOrder) past_.pop_back();
  for (int j = 0; j < n_; ++j) {
    const double weight =
        1.0 / std::sqrt(deviation_[j] * deviation_[j] + step.rest_friction2[j] +
                        std::pow(0.5 * novelty(step, j), 2));
    out.e[j] *= weight;
    out.X.row(j) *= weight;
  }
  return out;
}

}  // namespace veridyn::watching
