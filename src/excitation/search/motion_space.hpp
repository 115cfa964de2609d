#pragma once

#include "math/random_numbers.hpp"
#include "veridyn/excitation/fourier_trajectory.hpp"
#include "kinematics/motion_limits.hpp"

namespace veridyn {

/// The coordinates of a search: every vector x is a Fourier motion that starts and stops at rest.
///
/// A joint has 2 L - 1 of them: its mean position and the coefficients in orthonormal bases of
/// {a : sum a_l = 0} and {b : sum l b_l = 0}. Positions are linear in x; one unit is about half the
/// joint's range.
class MotionSpace {
 public:
  MotionSpace(MotionLimits limits, int harmonics, double frequency);

  int joints() const { return static_cast<int>(middle_.size()); }
  int per_joint() const { return 2 * harmonics_ - 1; }  ///< number of coordinates of one joint
  int size() const { return joints() * per_joint(); }  ///< number of coordinates
  double frequency() const { return frequency_; }  ///< [Hz]
  int harmonics() const { return harmonics_; }
  const MotionLimits& limits() const { return limits_; }

  FourierTrajectory trajectory(const VectorXd& x) const;  ///< the motion with coordinates x

  /// Motion per unit of a joint's coordinates at some instants, before its size is applied:
  /// (rows x per_joint) each.
  struct Basis {
    VectorXd time;
    MatrixXd q, dq, ddq;
  };
  Basis basis(const VectorXd& time) const;

  MotionSamples samples(const Basis& basis, const VectorXd& x) const;

  /// Chain rule: derivatives with respect to x of a function whose derivatives with respect to the samples
  /// are `slopes` (rows x 3 n).
  VectorXd gradient(const Basis& basis, const MatrixXd& slopes) const;

  /// Size of a joint's coordinates: q_i = middle_i + size_i * (basis . x_i).
  double size_of(int joint) const { return size_[joint]; }
  double middle_of(int joint) const { return middle_[joint]; }

  /// A random shape within position, speed and acceleration limits, scaled to `share` of the largest possible
  /// size.
  VectorXd random(RandomNumbers& numbers) const;

 private:
  double allowed(const VectorXd& x, int joint) const;

  MotionLimits limits_;
  int harmonics_;
  double frequency_;
  VectorXd middle_, size_;
  MatrixXd a_basis_, b_basis_;  // (harmonics x harmonics - 1)
};

}  // namespace veridyn
