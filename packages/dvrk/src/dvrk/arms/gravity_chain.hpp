#pragma once

#include <string>
#include <vector>

#include "dvrk/arms/arm_facts.hpp"
#include "veridyn/math/types.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn::dvrk {

/// One link of the chain in the gravity compensation of the dVRK software.
struct GravityRow {
  std::string joint;
  bool prismatic = false;
  DhRow dh;                      ///< modified
  double mass = 0.0;             ///< [kg]; see GravityChain
  Eigen::Vector3d com{0, 0, 0};  ///< [m] center of mass in the link's frame
};

/// A serial chain of DH rows with a mass and a centre in each link that has the same gravity torques as an
/// arm, parallelogram and counterweights included:
///
///   tau = d/dq sum_k m_k |g| z_k(q),   z_k the height of centre k above the remote centre
///
/// Its masses represent torques, not bodies: a counterweight that moves against the insertion reduces the
/// insertion's mass, which may become negative, and the mass of a link that turns about a fixed point is
/// arbitrary (here such that its centre is 0.1 m off, or zero without a moment).
struct GravityChain {
  std::string arm;
  double gravity = 9.81;              ///< |g| [m/s^2], downwards along z of the base
  std::vector<GravityRow> rows;       ///< Rows of all joints with DH rows, first to last
  std::vector<std::string> joints;    ///< Joints of the model, in the order of the vectors below
  VectorXd largest_torque;            ///< Largest torque of the model over random configurations [N m, N]
  VectorXd largest_error;             ///< Largest error of the chain against the model over other configurations [N m, N]
  /// Effects of the model other than gravity that hold a torque at rest.
  std::vector<std::string> left_out;
};

/// Least squares over random configurations within the limits of arm and model; exact for a PSM or
/// ECM, whose parallelogram closes.
///
/// @param model  with values for all bodies; its coordinates with names of joints of the arm are those
/// joints, the others are held still.
/// @throws InvalidInput  bodies have no values; no coordinate is a joint of the arm; the arm's coordinates
/// are motors (MTM); gravity is not along the world's z; the chain's error is above 5 % of a joint's largest
/// torque.
GravityChain fit_gravity_chain(const Model& model, const ArmFacts& arm);

/// Torques of the chain's own rows, one per row. @param q  one entry per row [rad, m].
VectorXd gravity_torques(const GravityChain& chain, const VectorRef& q);

/// The rows in the format of the dVRK software's kinematics files ("DH": {"convention": "modified", "joints":
/// [...]} with mass, cx, cy, cz; the names are from memory, no sample file was available), and next to them
/// their origin.
std::string to_gravity_json(const GravityChain& chain, const std::string& model);

/// Positions and efforts of a resting arm.
struct StaticTorques {
  MatrixXd q;    ///< (samples x n) [rad, m]
  MatrixXd tau;  ///< (samples x n) [N m, N]
};

/// Reads a static gravity recording: a header q1..qn,tau1..taun in any order (other columns are ignored), or
/// no header, positions followed by efforts (the latter is an assumption, since no file without a header was
/// available).
/// @throws InvalidInput  file and line, what was found and expected.
StaticTorques read_static_torques(const std::string& path);

}  // namespace veridyn::dvrk
