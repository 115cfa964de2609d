#pragma once

#include "veridyn/identification/identification.hpp"

namespace veridyn {

/// Share of the removable error (held out, above the noise floor) that disappears between two held-out
/// errors, (n) each; negative if the error grows.
double explained_share(const VectorXd& before, const VectorXd& after,
                       const Identification& baseline);

/// The same, above a given floor (n) instead of the difference between repeats.
double explained_share(const VectorXd& before, const VectorXd& after, const VectorXd& errors, const VectorXd& floor);

}  // namespace veridyn
