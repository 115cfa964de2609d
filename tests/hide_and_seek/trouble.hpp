#pragma once

#include <string>
#include <vector>

#include "hide_and_seek/draw.hpp"
#include "hide_and_seek/lagrange_arm.hpp"
#include "hide_and_seek/motion.hpp"

namespace veridyn::seek {

/// Common defects of recordings. The arm's model has no error in the sense of docs/contract.md, so
/// that a diagnosis of such recordings must name nothing.
enum class Trouble {
  kNone,
  kLateRows,           ///< a tenth of the rows repeats the row before
  kQuantisedVelocity,  ///< dq goes in steps of 1 to 3 % of its range
  kSaturation,         ///< the recorded torque of one joint is clipped at 85 to 95 % of its peak
  kStartUpRinging,     ///< the torque rings for 0.6 s when the recording starts
  kTemperatureDrift,   ///< viscous friction falls by 1 to 3 % from one recording to the next
  kSmoothedSign,       ///< Coulomb friction is a smooth step over 1 to 3 % of the largest speed
  kElasticBase,        ///< the base gives way by 3 to 8 mrad under the arm's largest moment on it
};

/// All but kNone.
const std::vector<Trouble>& all_troubles();
const char* name_of(Trouble trouble);
/// @throws InvalidInput  no trouble has this name.
Trouble trouble_of(const std::string& name);

/// The direction of sliding where Coulomb friction is a smooth step.
/// @param width  [rad/s] or [m/s] of the step.
double smooth_direction(double speed, double width);

/// Factor of the viscous friction in one recording.
/// @param place  position of the recording in their order.
double viscosity_factor(Trouble trouble, unsigned seed, int place);

/// Width of the step of Coulomb friction of one joint; zero: a sharp step.
double step_width(Trouble trouble, unsigned seed, int joint, double largest_speed);

/// (rows x n) torque that an elastic base adds: it gives way under the moments about x and y that the arm
/// exerts on it, by 3 to 8 mrad for each under the larger of their peaks, and the arm feels gravity turned
/// and the base's acceleration. Lagrange's equations of the arm with two more coordinates.
/// @param softer  the base's compliance as a multiple of that.
MatrixXd elastic_base_torque(const LagrangeArm& arm, unsigned seed, const Motion::Rows& rows, double softer = 1.0);

/// Changes rows as sensors or drives of this kind would; the signals have their noise already.
void trouble_rows(Trouble trouble, unsigned seed, int number, const VectorXd& time, MatrixXd& q,
                  MatrixXd& dq, MatrixXd& tau);

}  // namespace veridyn::seek
