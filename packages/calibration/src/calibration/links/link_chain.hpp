#pragma once

#include "calibration/links/link_parameters.hpp"
#include "veridyn/model/joint_sensors.hpp"

namespace veridyn::internal {

/// The pose of the tracked body in the cameras' frame from joint readings, and its derivatives by
/// every parameter.
class LinkChain {
 public:
  /// @param base, tool  nominal poses, to which the parameters of base and tool are arm_with.
  LinkChain(const LinkParameters& parameters, const Eigen::Isometry3d& base,
            const Eigen::Isometry3d& tool);

  const LinkParameters& parameters() const { return parameters_; }

  /// Sets the parameters x with which base(), tool() and pose() are computed.
  void set(const VectorRef& x);
  const VectorXd& x() const { return x_; }

  Eigen::Isometry3d base() const { return base_; }
  Eigen::Isometry3d tool() const { return tool_; }

  /// T_camera_body.
  /// @param q  joint readings [rad], [m] as recorded.
  /// @param J  null, or (6 x parameters): rotation [rad] and translation [m] of the body in the
  /// cameras' frame per parameter, rotation first.
  Eigen::Isometry3d pose(const VectorRef& q, MatrixXd* J) const;

 private:
  const LinkParameters& parameters_;
  JointSensors sensors_;
  Eigen::Isometry3d base_start_, tool_start_;
  Eigen::Isometry3d base_, tool_;
  VectorXd x_;
  VectorXd values_;       // values of the entries
  MatrixXd by_constant_;  // (entries x parameters)
  std::vector<int> entry_parameter_;  // parameter of every entry; -1: none
  std::vector<int> zero_parameter_;   // by coordinate: parameter of its encoder zero; -1: none
  std::vector<int> constants_;        // parameters that are named constants
  // By path frame: fixed transform after the origin of a placement.
  std::vector<Eigen::Isometry3d> rest_;
};

}  // namespace veridyn::internal
