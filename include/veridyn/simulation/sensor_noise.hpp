#pragma once

#include <string>
#include <vector>

#include "veridyn/math/motion_samples.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// An amount for revolute and for prismatic joints.
struct JointAmount {
  double revolute = 0.0;   ///< [rad], [rad/s]
  double prismatic = 0.0;  ///< [m], [m/s]
};

/// Imperfections of a controller and its sensors. Torque noise is a share of the joint's rms
/// torque.
struct SensorNoise {
  /// Rms deviation from the wanted motion: twelve waves of 0.05 to 0.5 Hz.
  JointAmount tracking;
  JointAmount encoder_step;      ///< positions are multiples of it; 0: exact
  JointAmount velocity;          ///< standard deviation of white noise
  double torque_white = 0.0;     ///< standard deviation of white noise
  double torque_coloured = 0.0;  ///< standard deviation of a first-order autoregressive process
  double colour_seconds = 0.1;   ///< [s] correlation time of that process
  double delay = 0.0;            ///< [s] lag of all signals behind the rows' times
  /// [s] standard deviation of an additional random lateness of the rows, as of a publisher without its own
  /// clock.
  double late = 0.0;
  double stale_rows = 0.0;   ///< share of rows that repeat the previous row in all signals except the time
  double stale_run = 1.0;    ///< mean number of repeats in a row; 1: isolated rows
  double dropouts = 0.0;     ///< share of rows without any number but the time
  double dropout_run = 1.0;  ///< mean length of a dropout in rows; 1: isolated rows
};

/// Presets of sensor noise. none: ideal. low: a good laboratory arm. dvrk and ur: like recordings of a da Vinci
/// Research Kit arm and of a UR10e (their encoder steps, high-frequency torque noise and stale
/// rows). dvrk-late: like a kit whose publisher fell behind, with 12 % repeated rows and the others
/// late by milliseconds.
///
/// Amounts may follow: "dvrk:stale_rows=0.1,stale_run=2,dropouts=0.01,dropout_run=20,delay=0.005,
/// late=0.001,torque_white=0.05,torque_coloured=0.02".
/// @throws InvalidInput  no such preset or amount.
SensorNoise sensor_noise(const std::string& asked);

/// Names of the presets.
const std::vector<std::string>& sensor_noise_names();

/// Text for help: "tracking 1 mrad, ...".
std::string describe(const SensorNoise& noise);

/// The true motion of the arm: the wanted one plus the tracking deviation, whose velocity and
/// acceleration are its exact derivatives. The deviation fades in and out within a second at either
/// end. Joints at rest in the wanted motion stay at rest.
MotionSamples with_tracking_deviation(const Model& arm, const MotionSamples& wanted,
                                      const SensorNoise& noise, unsigned seed);

/// Turns true signals into measured ones, in place: delay, steps, noise, stale and missing rows.
/// tau (rows x n).
void measure(const Model& arm, const SensorNoise& noise, unsigned seed, MotionSamples& motion,
             MatrixXd& tau);

}  // namespace veridyn
