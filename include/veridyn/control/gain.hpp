#pragma once

#include <initializer_list>

#include "veridyn/math/types.hpp"

namespace veridyn {

/// One number for all joints (or directions of a task), or one number for each:
///
///   Gain stiff = 400;  Gain each = {25, 20, 75};  Gain stored = some_vector;
class Gain {
 public:
  Gain(double of_all) : values_(VectorXd::Constant(1, of_all)) {}  // NOLINT: a number is a gain
  Gain(std::initializer_list<double> of_each);
  template <typename Vector>
  Gain(const Eigen::MatrixBase<Vector>& of_each) : values_(of_each) {}  // NOLINT: so is a vector

  /// The gains (n). @param what  name of the gain, for messages.
  /// @throws InvalidInput  neither one number nor n; a number that is below zero or not finite.
  VectorXd expand(Eigen::Index n, const char* what) const;

 private:
  VectorXd values_;
};

}  // namespace veridyn
