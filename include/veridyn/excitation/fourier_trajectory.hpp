#pragma once

#include "veridyn/math/motion_samples.hpp"
#include "veridyn/math/types.hpp"

namespace veridyn {

/// Sines and cosines of all harmonics at given instants, for all trajectories of one frequency.
struct FourierBasis {
  /// @param time  (rows) [s]; frequency [Hz].
  FourierBasis(VectorXd time, double frequency, int harmonics);

  VectorXd time;
  VectorXd omega;  ///< (harmonics) l w_f [rad/s]
  MatrixXd sine;   ///< (rows x harmonics)
  MatrixXd cosine;
};

/// `count` evenly spaced instants over one period; the end, equal to the start, is not repeated.
VectorXd period_instants(double frequency, int count);

/// Bounds of a whole motion, (n) each, valid between samples as well.
struct MotionBounds {
  VectorXd lower;         ///< lower bound of q
  VectorXd upper;         ///< upper bound of q
  VectorXd velocity;      ///< bound of |dq|
  VectorXd acceleration;  ///< bound of |ddq|
};

/// Periodic motion of every joint i in harmonics l = 1 .. L of one frequency:
///
///   q_i(t) = q0_i + sum_l  a_il / (w_f l) sin(w_f l t)  -  b_il / (w_f l) cos(w_f l t)
///
/// with w_f = 2 pi frequency. Source: thesis (5.28) with its errata: the sum runs over the
/// harmonics, the frequency is in Hz; Swevers et al., IEEE Trans. Robotics and Automation 13(5),
/// 1997.
///
/// The motion rests at t = 0 and so at the end of every period if for every joint
///
///   dq(0) = sum_l a_il = 0   and   ddq(0) = w_f sum_l l b_il = 0,
///
/// see rest_at_start(). The arm then starts, repeats its period and stops without a jump of
/// velocity or acceleration; nothing needs to be blended in or out, and every period is the same.
class FourierTrajectory {
 public:
  /// @param a, b  (n x harmonics) [rad/s] or [m/s]; q0 (n).
  /// @throws InvalidInput  sizes differ, no harmonics, or a frequency that is not positive.
  FourierTrajectory(double frequency, MatrixXd a, MatrixXd b, VectorXd q0);

  double frequency() const { return frequency_; }  ///< [Hz]
  double period() const { return 1.0 / frequency_; }
  int joints() const { return static_cast<int>(a_.rows()); }
  int harmonics() const { return static_cast<int>(a_.cols()); }
  const MatrixXd& a() const { return a_; }
  const MatrixXd& b() const { return b_; }
  const VectorXd& q0() const { return q0_; }

  /// Position, velocity and acceleration at any instants.
  MotionSamples samples(const VectorRef& time) const;

  /// Position, velocity and acceleration at the instants of a basis with this frequency and number of harmonics.
  MotionSamples samples(const FourierBasis& basis) const;

  /// Whole periods sampled at `rate` [Hz] from t = 0 on. The last row is the first instant at or
  /// after the end, with the arm at its start.
  MotionSamples motion(int periods, double rate) const;

  /// This path at a share of its speed: velocities are multiplied by `share`, accelerations by its square.
  FourierTrajectory at_speed(double share) const { return {share * frequency_, share * a_, share * b_, q0_}; }

  /// Bounds from 256 samples per shortest wave, enlarged by the largest curvature between them, h^2 / 8
  /// max|f''|.
  MotionBounds bounds() const;

 private:
  double frequency_;
  MatrixXd a_, b_;
  VectorXd q0_;
};

/// Projects the coefficients onto those for which the motion rests at the start of its period.
void rest_at_start(MatrixXd& a, MatrixXd& b);

}  // namespace veridyn
