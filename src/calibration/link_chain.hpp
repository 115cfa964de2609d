#pragma once

#include "link_parameters.hpp"
#include "veridyn/model/joint_sensors.hpp"

namespace veridyn::internal {

/// The pose of the tracked body in the cameras' frame from joint readings, and how it changes with
/// every parameter.
class LinkChain {
 public:
  /// @param base, tool  the poses that the parameters of base and tool move.
  LinkChain(const LinkParameters& parameters, const Eigen::Isometry3d& base,
            const Eigen::Isometry3d& tool);

  const LinkParameters& parameters() const { return parameters_; }

  /// Numbers of the robot at the parameters x; poses below use them until the next call.
  void set(const VectorRef& x);
  const VectorXd& x() const { return x_; }

  Eigen::Isometry3d base() const { return base_; }
  Eigen::Isometry3d tool() const { return tool_; }

  /// @param q  as recorded.
  /// @param J  null, or (6 x parameters): the turn [rad] and the shift [m] of the body in the
  ///           cameras' frame per parameter, turn first.
  Eigen::Isometry3d pose(const VectorRef& q, MatrixXd* J) const;

 private:
  const LinkParameters& parameters_;
  JointSensors sensors_;
  Eigen::Isometry3d base_start_, tool_start_;
  Eigen::Isometry3d base_, tool_;
  VectorXd x_;
  VectorXd values_;       // of the entries
  MatrixXd by_constant_;  // (entries x parameters)
  std::vector<int> entry_parameter_;  // by entry; -1: none of its own
  std::vector<int> zero_parameter_;   // by coordinate; -1
  std::vector<int> constants_;        // parameters that are named constants
  std::vector<Eigen::Isometry3d> rest_;  // by path frame: what follows the origin of a placement
};

}  // namespace veridyn::internal
