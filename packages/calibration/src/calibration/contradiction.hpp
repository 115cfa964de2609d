#pragma once

#include <string>

#include "closed_forms.hpp"

namespace veridyn::internal {

/// Residuals of a fit over its own poses.
struct FitResiduals {
  int outliers = 0;    ///< poses that the fit does not describe
  double rms = 0.0;    ///< [m] rms residual of positions, without outliers
  double angle = 0.0;  ///< [rad] the same for orientations; 0 if they are not used
};

/// Reason for which the poses contradict the fitted relation: more than half of them are outliers, or more than
/// half of their variation is residual. Empty if they agree. Causes are rows that do not correspond, another
/// frame, or a body that moves differently.
std::string contradiction_reason(const Isometries& poses, const FitResiduals& left);

}  // namespace veridyn::internal
