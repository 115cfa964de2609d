#pragma once

#include <map>
#include <string>
#include <vector>

#include "hide_and_seek/draw.hpp"
#include "hide_and_seek/lagrange_arm.hpp"
#include "hide_and_seek/motion.hpp"

namespace veridyn::seek {

/// A hidden cause with all its parameters.
struct Cause {
  std::string effect;    ///< name in CONTRACT.md
  int joint = -1;        ///< coordinate, from 0; -1: the whole arm, or a frame
  int from = -1;         ///< source of a coupling
  std::string frame;     ///< of a payload or a wrong constant
  std::string constant;  ///< "a", "alpha", "d", "theta", or the coordinate whose ratio is wrong
  std::map<std::string, double> values;  ///< parameters and shape constants by their public names
};

/// Every name of CONTRACT.md but `none`.
const std::vector<std::string>& all_causes();

/// True for causes that change the bodies, the geometry or gravity.
bool is_structural(const std::string& effect);
/// True for causes that change recorded signals only.
bool is_channel(const std::string& effect);

/// Parameters in which the torque of an additive cause is linear.
std::vector<std::string> linear_parameters(const std::string& effect);

/// How a joint moves in the recordings; shape constants are shares of it.
struct Reach {
  double middle = 0.0, travel = 0.0, speed = 0.0, duration = 0.0;
  bool slides = false;
};

/// Draws the shape constants of an additive cause (a distance, an order, an exponent, ...).
void draw_shapes(Cause& cause, const Reach& reach, Draw& draw);

/// Columns (rows x linear_parameters) of an additive cause: motor torque of its joint per unit of
/// each parameter. Written from the definitions and not from src/effects; memories see the motion
/// every millisecond.
///
/// @param load  (rows) torque of the rigid bodies on the joint.
MatrixXd cause_columns(const Cause& cause, const Motion& motion, const Motion::Rows& rows,
                       const VectorXd& load);

/// The direction of sliding, smooth within 1e-4 rad/s of rest.
double direction(double speed);

/// The torque of a push with values from, to [s] and effort, which rises and falls within 0.1 s.
VectorXd contact_torque(const std::map<std::string, double>& values, const VectorXd& time);

/// signal(t - delay) on even times, by cubics through four neighbours.
VectorXd delayed(const VectorXd& signal, double step, double delay);

/// The arm with its structural causes; others are ignored.
LagrangeArm changed(LagrangeArm arm, const std::vector<Cause>& causes);

}  // namespace veridyn::seek
