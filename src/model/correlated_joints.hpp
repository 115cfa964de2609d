#pragma once

#include <string>
#include <vector>

#include "veridyn/model/model.hpp"

namespace veridyn {

/// Groups of two or more joints with collinear positions, whose correlation with the first of the group is
/// above `least` in magnitude. Rows with NaN and joints that hardly move are ignored. @param q  (rows x n).
std::vector<std::vector<JointIndex>> correlated_joints(const MatrixXd& q, double least = 0.999);

/// The joints' numbers as text, from 1: "1, 3 and 4".
std::string numbers_from_one(const std::vector<JointIndex>& joints);

}  // namespace veridyn
