#pragma once

#include <string>
#include <vector>

#include "veridyn/math/types.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// Base parameters of a model: from the statistics in its file or, if it has no valid ones, from its values.
/// Each row of K has a one in the column of its leading parameter and zeros in the columns of the others'.
struct BaseNumbers {
  std::vector<std::string> names;        ///< (base) of the leading standard parameters
  std::vector<std::string> expressions;  ///< (base)
  std::vector<std::string> units;        ///< (base)
  std::vector<int> leading;              ///< (base) indices of standard parameters
  MatrixXd K;                            ///< (base x standard)
  VectorXd free;                         ///< (base)
  MatrixXd scatter;                      ///< (base x any), covariance = scatter * scatter'
  MatrixXd motion;                       ///< (clusters x n) as in IdentifiedBase, or empty
  int clusters = 0;                      ///< 0: no statistics, scatter is (base x 0)
  std::string note;                      ///< reason if the statistics of the file are not used
};

/// @throws InvalidInput  a body or an effect has no values.
BaseNumbers base_numbers(const Model& arm);

/// True if both were identified from the same motion, so that their clusters are pairs.
bool same_motion(const BaseNumbers& a, const BaseNumbers& b);

/// One base parameter of `before` that both models determine.
struct MatchedParameter {
  int row = 0;  ///< row in the base parameters of `before`
  double before = 0.0, after = 0.0;
  VectorXd scatter_before, scatter_after;
};

struct MatchedBase {
  std::vector<MatchedParameter> parameters;
  std::vector<std::string> only_before, only_after;  ///< expressions that have no counterpart in the other model
};

/// Every base parameter k of `before` that is a linear combination of those of `after`: k = w' K.
///
/// @param scale  (standard of before) size of every standard parameter's column; columns are scaled
/// by it before entries are compared with zero.
MatchedBase matched_base(const Model& before, const BaseNumbers& a, const Model& after,
                         const BaseNumbers& b, const VectorRef& scale_before,
                         const VectorRef& scale_after);

}  // namespace veridyn
