#pragma once

#include "identification/hold_out.hpp"
#include "veridyn/identification/identification.hpp"

namespace veridyn {

/// Squared errors of every joint on parts of the training recordings, each predicted by a fit to the other
/// parts. A part is a whole recording; of two or three recordings it is half of one, of a single recording an
/// eighth (a phase of its period, if it repeats).
struct FoldErrors {
  MatrixXd error2;   ///< (parts x n)
  VectorXd torque2;  ///< (n) squared torque over all parts

  /// (n) ||error|| / ||torque|| over all parts.
  VectorXd relative() const { return (error2.colwise().sum().transpose().array() / torque2.array().max(1e-300)).sqrt(); }
};

/// @param fitted  with factors and series of its training recordings, and a model.
FoldErrors fold_errors(const Identification& fitted, const IdentificationOptions& options, const HoldOut& hold_out);

}  // namespace veridyn
