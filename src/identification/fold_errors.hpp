#pragma once

#include "identification/hold_out.hpp"
#include "veridyn/identification/identification.hpp"

namespace veridyn {

/// Squared errors of every joint on parts of the training recordings, each predicted by the arm that
/// the other parts give. The parts are whole recordings; of three or two the halves of each, of one
/// its eighths (phases of its period where it repeats).
struct FoldErrors {
  MatrixXd error2;   ///< (parts x n)
  VectorXd torque2;  ///< (n) squared torque over all parts

  /// (n) ||error|| / ||torque|| over all parts.
  VectorXd relative() const { return (error2.colwise().sum().transpose().array() / torque2.array().max(1e-300)).sqrt(); }
};

/// @param fitted  with factors and series of its training recordings, and a model.
FoldErrors fold_errors(const Identification& fitted, const IdentificationOptions& options, const HoldOut& hold_out);

}  // namespace veridyn
