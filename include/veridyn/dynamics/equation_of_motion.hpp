#pragma once

#include <memory>

#include "veridyn/math/types.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// M(q) and h(q, dq) = C(q, dq) dq + g(q) of one state, at the price of little more than one
/// inverse dynamics: that of rest and those of all unit accelerations run side by side, one in each
/// lane of a vector,
///
///   h = tau(q, dq, 0),   M e_j = tau(q, dq, e_j) - h
///
/// Owns its workspace: after the constructor nothing allocates, and one object serves one thread.
class EquationOfMotion {
 public:
  /// @param phi  (10 * bodies) of all bodies, ten of each in the order of InertialParameters;
  ///             `*arm.inertial_values()` where the file or MODEL has them.
  /// @throws InvalidInput  phi has the wrong size.
  EquationOfMotion(const Model& arm, const VectorRef& phi);
  ~EquationOfMotion();
  EquationOfMotion(EquationOfMotion&&) noexcept;
  EquationOfMotion& operator=(EquationOfMotion&&) noexcept;

  /// @param q, dq  n entries each. @param M (n x n), @param h (n): of the right size.
  void evaluate(const VectorXd& q, const VectorXd& dq, MatrixXd& M, VectorXd& h) noexcept;

  /// True if evaluate_with_slopes() costs no more than evaluate(): its lanes would be idle.
  bool slopes_are_free() const noexcept;

  /// Also D = dh/ddq (n x n), from forward differences. Only where slopes_are_free().
  void evaluate_with_slopes(const VectorXd& q, const VectorXd& dq, MatrixXd& M, VectorXd& h,
                            MatrixXd& D) noexcept;

  /// The same for the next one.
  bool surroundings_are_free() const noexcept;

  /// Also by how much M ddq + h changes over a small way `way` to first order, (n). Only where
  /// surroundings_are_free().
  void evaluate_surroundings(const VectorXd& q, const VectorXd& dq, const VectorXd& ddq,
                             const VectorXd& way, MatrixXd& M, VectorXd& h, MatrixXd& D,
                             VectorXd& change) noexcept;

 private:
  struct Lanes;
  std::unique_ptr<Lanes> lanes_;
};

}  // namespace veridyn
