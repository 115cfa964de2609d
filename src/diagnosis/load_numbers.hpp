#pragma once

#include <cstddef>

namespace veridyn::loads {

// Numbers that decide in the fit of a load and in its report.

constexpr double kReach = 1.0;          // [m] of a load's centre from its frame, if the robot file has no bound
constexpr double kSameSpan = 1e-5;      // share of squares, below which two loads have the same torques
constexpr double kFelt = 1e-12;         // share of squares, below which a column has no torque
constexpr double kOutside = 0.05;       // probability outside of an interval that is printed
// Rows of a recording for one independent sample: five rows are kept per period of the filter's cut-off, and
// errors of a model change more slowly than noise.
constexpr double kRowsPerSample = 30.0;
constexpr int kTurns = 6;               // alternations between the fits of friction and load, where a CAD model has no friction
constexpr int kMostClusters = 64;       // of all recordings together
// A load explains a joint if the residual of its torque is at most this.
constexpr double kOfOwnError = 3.0;     // times the model's error in its own training, or the band of dry friction at rest
constexpr double kErrorOfDrawing = 0.3; // relative error, where it is not known
constexpr double kNoGravity = 1e-12;    // share of the largest squared torque, below which gravity has none
// poses >= kPosesPerUnknown * kUnknowns, a load's mass and centre: an error is held out.
constexpr double kPosesPerUnknown = 2.0, kUnknowns = 4.0;
constexpr std::size_t kNumberWidth = 8;
constexpr double kAtEnd = 0.999;  // share of the heaviest load, at which the search ended at its bound
constexpr double kWidestMass = 1.5;  // relative width of the interval (half to twice the mass), above which the mass is undetermined
constexpr double kUniform = 3.0;         // variance of a uniform distribution = half its width squared / 3

// Numbers of the descent.
constexpr double kRidge = 1e-11;      // relative ridge, so that equal columns can be solved for
constexpr double kTiny = 1e-300;
constexpr int kSteps = 80;            // largest number of steps of a descent
constexpr double kConverged = 1e-13;  // relative change of the cost
constexpr double kStartPlace = 0.3;   // share of the reach at which descents start
constexpr double kStartMasses[] = {0.03, 0.15, 0.6, 2.5, 10.0};  // [kg] masses from which descents start
constexpr double kMoreDamping = 8.0, kLessDamping = 0.2, kMostDamping = 1e8;
constexpr double kAtBound = 0.999;    // share of the reach, from which the centre is at its bound
constexpr double kSeen = 0.5;         // share of the reach; with a smaller deviation the place is determined
constexpr double kGrowth = 1.25;      // ratio of successive masses in the search for the end of an interval
constexpr int kBisections = 40;
constexpr double kNearZero = 1e-3;    // share of the best mass, below which a load counts as zero
constexpr double kFirstDamping = 1e-3, kLeastDamping = 1e-12;
constexpr double kUndeterminedRidge = 1e-6;  // relative ridge of undetermined directions

}  // namespace veridyn::loads
