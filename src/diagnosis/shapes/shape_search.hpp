#pragma once

#include <map>
#include <string>
#include <vector>

#include "diagnosis/shapes/candidate_data.hpp"

namespace veridyn {

/// Values of the shape constants of one hypothesis, by name.
using Shapes = std::map<std::string, double>;

/// Hypotheses with refined constants.
struct RefinedShapes {
  AugmentedModel model;                  ///< the arm with them, in their order, and with no others
  std::vector<Shapes> shapes;            ///< Shapes of every hypothesis; empty where nothing is searched
  bool anything = false;                 ///< false: none of them has a constant to search for
};

/// True if a constant of this hypothesis is searched for: a presliding distance, a Stribeck speed.
bool has_searched_shape(const CandidateData& asked, const Hypothesis& hypothesis);

/// Refines the shape constants of the accepted hypotheses, so far from a coarse grid, by variable
/// projection: the recordings are streamed again with a few values around the present ones, and
/// every constant descends to the least weighted residual. @param known  initial constants of every
/// accepted hypothesis; empty: those of the hypotheses.
RefinedShapes refine_shapes(const Identification& start, const CandidateData& asked,
                            const Selection& selection, bool changes,
                            const std::vector<std::string>& train, const IdentificationOptions& how,
                            const std::vector<Shapes>& known = {});

/// Intervals of refined constants, by a profile of the misfit over all that the recordings may leave open: a
/// second minimum far away is inside where it is as good. @param found  the constants of every accepted
/// hypothesis, as refine_shapes() gives them.
std::vector<ShapeInterval> shape_intervals(const Identification& start, const CandidateData& asked,
                                           const Selection& selection, bool changes,
                                           const std::vector<std::string>& train,
                                           const IdentificationOptions& how, const std::vector<Shapes>& found);

}  // namespace veridyn
