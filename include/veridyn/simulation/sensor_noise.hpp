#pragma once

#include <string>
#include <vector>

#include "veridyn/math/motion_samples.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// An amount for turning and for sliding joints.
struct JointAmount {
  double revolute = 0.0;   ///< [rad], [rad/s]
  double prismatic = 0.0;  ///< [m], [m/s]
};

/// How far a controller and its sensors are from perfect. Noise of the torque is in shares of the
/// joint's rms torque.
struct SensorNoise {
  /// Rms deviation from the wanted motion: twelve waves of 0.05 to 0.5 Hz.
  JointAmount tracking;
  JointAmount encoder_step;      ///< positions are multiples of it; 0: exact
  JointAmount velocity;          ///< standard deviation of white noise
  double torque_white = 0.0;     ///< standard deviation
  double torque_coloured = 0.0;  ///< standard deviation of a first-order autoregressive process
  double colour_seconds = 0.1;   ///< its correlation time [s]
  double delay = 0.0;            ///< [s] by which all signals come later than their rows say
  /// [s]: beyond that a row is late by the size of a normal number of this standard deviation, as
  /// rows of a publisher without a clock of its own are.
  double late = 0.0;
  double stale_rows = 0.0;   ///< share of rows that repeat the row before in all signals but time
  double stale_run = 1.0;    ///< their mean number in a row; 1: each row for itself
  double dropouts = 0.0;     ///< share of rows without any number but the time
  double dropout_run = 1.0;  ///< likewise
};

/// none: ideal. low: a good laboratory arm. dvrk and ur: as the recordings of a da Vinci Research
/// Kit arm and of a UR10e look (their encoder steps, high-frequency torque noise and stale rows).
/// dvrk-late: as those of a kit whose publisher fell behind, 12 % of the rows repeats and the rest
/// late by milliseconds.
///
/// Amounts may follow: "dvrk:stale_rows=0.1,stale_run=2,dropouts=0.01,dropout_run=20,delay=0.005,
/// late=0.001,torque_white=0.05,torque_coloured=0.02".
/// @throws InvalidInput  no such preset or amount.
SensorNoise sensor_noise(const std::string& asked);

/// The names that sensor_noise() knows.
const std::vector<std::string>& sensor_noise_names();

/// "tracking 1 mrad, ..." in words, for help texts.
std::string describe(const SensorNoise& noise);

/// The motion that the arm really makes: the wanted one plus the tracking deviation, whose velocity
/// and acceleration are its exact derivatives. It fades in and out within a second at either end.
/// Joints that stand still in the wanted motion stand still.
MotionSamples with_tracking_deviation(const Model& arm, const MotionSamples& wanted,
                                      const SensorNoise& noise, unsigned seed);

/// What sensors make of true signals, in place: delay, steps, noise, stale and missing
/// rows. tau (rows x n).
void measure(const Model& arm, const SensorNoise& noise, unsigned seed, MotionSamples& motion,
             MatrixXd& tau);

}  // namespace veridyn
