#pragma once

#include <string>
#include <vector>

#include "veridyn/math/types.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// Value and scatter of a linear combination of standard parameters.
struct Estimate {
  double value = 0.0;
  VectorXd scatter;  ///< (clusters) its squared norm is the variance; empty without statistics
};

/// The combinations K phi of standard parameters that a model file determines: the base parameters of its identification with
/// their statistics. Without valid statistics: the base parameters of its values, taken as exact. Each row of K has a one in the column of
/// its leading parameter and zeros in those of the others, so that any other combination w is
///
///   w = K' c,   c = w at the leading parameters,   value = c' values,   scatter = scatter' c
struct Estimates {
  /// @param own  (standard) 1: parameters that expressions leave out, since they follow from others.
  /// @throws InvalidInput  a body or an effect has no values.
  Estimates(const Model& arm, const VectorRef& own);

  Estimate of(const VectorRef& w) const;  ///< value and scatter of w' phi, for w (standard) in the span of the rows
  /// True if w is a combination of the rows, where entries count by the sizes (standard) of their columns.
  bool determines(const VectorRef& w, const VectorRef& sizes) const;

  int identified = 0;        ///< The first rows; the others, of a parameter each, are known by the robot file.
  std::vector<int> leading;  ///< (rows) indices of standard parameters
  MatrixXd K;                ///< (rows x standard)
  VectorXd values;           ///< (rows) of unconstrained least squares
  MatrixXd scatter;          ///< (rows x any), covariance = scatter * scatter'
  MatrixXd motion;           ///< (clusters x n) as in IdentifiedBase, or empty
  int clusters = 0;          ///< 0: no statistics, scatter is (rows x 0)
  std::string note;          ///< reason if the statistics of the file are not used
  std::vector<std::string> expressions;  ///< (identified)

 private:
  bool read(const IdentifiedBase& file, const std::vector<StandardParameter>& parameters);  ///< false: the statistics contradict the values, see note
  void make_canonical();  ///< solves for the K that is the identity in the columns `leading`
  void add_facts(const std::vector<StandardParameter>& parameters);  ///< appends a row for every known parameter
};

/// True if both were identified from the same motion, so that their clusters are pairs.
bool same_motion(const Estimates& a, const Estimates& b);

}  // namespace veridyn
