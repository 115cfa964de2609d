#pragma once

#include "veridyn/math/types.hpp"

namespace veridyn {

/// A motion at instants; matrices are (rows x n), one contiguous column a joint.
struct MotionSamples {
  VectorXd time;  ///< (rows) [s]
  MatrixXd q;     ///< [rad], [m] where the joint is prismatic
  MatrixXd dq;    ///< [rad/s], [m/s]
  MatrixXd ddq;   ///< [rad/s^2], [m/s^2]

  Eigen::Index rows() const { return q.rows(); }
  Eigen::Index joints() const { return q.cols(); }
};

}  // namespace veridyn
