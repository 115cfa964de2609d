// math/: vectors, filters, least-squares information, statistics, random numbers; without a robot.
#pragma once

#include <Eigen/Core>

namespace veridyn {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using VectorRef = Eigen::Ref<const VectorXd>;
using MatrixRef = Eigen::Ref<const MatrixXd>;

}  // namespace veridyn
