#pragma once

#include "veridyn/identification/identification.hpp"

namespace veridyn {

/// Share of the removable error (held out, above the noise floor) that disappears between two
/// held-out errors, (n) each; negative if it grows.
double explained_share(const VectorXd& before, const VectorXd& after,
                       const Identification& baseline);

/// The same above another floor than that between repeats, (n).
double explained_share(const VectorXd& before, const VectorXd& after, const VectorXd& errors, const VectorXd& floor);

}  // namespace veridyn
