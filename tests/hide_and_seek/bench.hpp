#pragma once

#include <string>
#include <vector>

#include "hide_and_seek/cause.hpp"
#include "hide_and_seek/lagrange_arm.hpp"
#include "hide_and_seek/motion.hpp"
#include "hide_and_seek/trouble.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn::seek {

constexpr double kRate = 200.0;  // [Hz] of the recordings

/// Number of the first recording with the causes, where a model is identified first; recordings
/// without them are numbered from 1, so that no motion occurs twice.
constexpr int kCleanRecordings = 4;
constexpr int kFirstChanged = 100;

/// Position of a recording in the order in which they are made.
constexpr int place_in_time(int number) {
  return number < kFirstChanged ? number : number - kFirstChanged + kCleanRecordings + 1;
}

/// Friction and offset of one joint, which the robot files of the bench declare.
struct JointFriction {
  double viscous = 0.0, coulomb = 0.0, offset = 0.0;
};

/// Sensors of one joint.
struct JointSensors {
  double torque_noise = 0.0;  ///< share of the joint's rms torque; half of its power is coloured
  double encoder_step = 0.0;
  double velocity_noise = 0.0;
};

/// An arm with known parameters: a robot file without values, bodies and friction drawn at random.
struct Bench {
  Model robot;      ///< the robot file
  LagrangeArm arm;  ///< with moments
  std::vector<JointFriction> friction;
  std::vector<JointSensors> sensors;
  unsigned seed = 1;
  Trouble trouble = Trouble::kNone;  ///< that all its recordings suffer from
};

/// A recording without noise, and the true motion and torques.
struct IdealRecording {
  Motion::Rows rows;    ///< true motion
  MatrixXd rigid;       ///< (rows x n) true torque of the rigid bodies
  bool nominal = true;  ///< `rigid` is that of the bench's own bodies, geometry and gravity
  MatrixXd q;           ///< as encoders see it, without steps
  MatrixXd tau;         ///< as recorded, without noise
};

/// Names of arms: files in tests/hide_and_seek/robots or data/robots.
const std::vector<std::string>& bench_arms();

/// The arm's robot file with bodies, friction and sensors of this seed. Bodies are rods between
/// joints with an ellipsoid on them, lighter the farther out; friction is 5 to 15 % Coulomb and 3
/// to 10 % viscous of the joint's rigid torque.
Bench make_bench(const std::string& arm, unsigned seed);

/// One motion of the arm with its causes.
///
/// @param number  of the recording: contacts happen at another time in each.
/// @param rigid   torques of the bench's bodies in this motion, if known; saves most of the work.
IdealRecording ideal_recording(const Bench& bench, const std::vector<Cause>& causes,
                               const Motion& motion, int number, const MatrixXd* rigid = nullptr);

/// The time of a push in a recording: half a second to a second, somewhere in its middle.
void draw_contact_time(std::map<std::string, double>& values, double duration, unsigned seed,
                       int number);

/// CSV with t, q, dq, tau as sensors give it.
void write_recording(const Bench& bench, const IdealRecording& ideal, unsigned seed, int number,
                     const std::string& path);

/// Noise of the sensors, (rows): half of the power white, half first-order low-pass at 2 Hz.
VectorXd torque_noise(double rms, Eigen::Index rows, Draw& draw);

}  // namespace veridyn::seek
