#pragma once

#include "hinge_bundle.hpp"

namespace veridyn::internal {

/// One hinge of a fitted bundle in the frame of the cameras, with its uncertainty.
CalibratedAxis axis_result(const HingeBundle& bundle, const std::vector<RigidBody>& bodies,
                           int hinge);

/// Geometry between two hinges of one body (-1: the frame of the cameras); indices of hinges are
/// those of the bundle.
CalibratedLink link_result(const HingeBundle& bundle, int first, int second, int body);

}  // namespace veridyn::internal
