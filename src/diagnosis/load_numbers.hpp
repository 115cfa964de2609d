#pragma once

#include <cstddef>

namespace veridyn::loads {

// Numbers of the fit of a load and of its report.

constexpr double kReach = 1.0;          // [m] of a load's centre from its frame, if the robot file has no bound
constexpr double kSameSpan = 1e-5;      // of squares: two loads whose columns span the same torques
constexpr double kFelt = 1e-12;         // of squares: a column below it has no torque
constexpr double kOutside = 0.05;       // probability outside of an interval that is printed
// Rows of a recording for each independent one: five are kept per period of the filter's cut-off, and a
// model's errors are slower than noise.
constexpr double kRowsPerSample = 30.0;
constexpr int kTurns = 6;               // between friction and load, where a CAD model has no friction
constexpr int kMostClusters = 64;       // of all recordings together
// A joint is explained if the residual of its torque is at most this.
constexpr double kOfOwnError = 3.0;     // times the model's error in its own training, or the band of dry friction at rest
constexpr double kErrorOfDrawing = 0.3; // where it is not known
constexpr double kNoGravity = 1e-12;    // of the largest squared torque: rounding
// poses >= kPosesPerUnknown * kUnknowns, a load's mass and centre: an error is held out.
constexpr double kPosesPerUnknown = 2.0, kUnknowns = 4.0;
constexpr std::size_t kNumberWidth = 8;
constexpr double kAtEnd = 0.999;  // of the heaviest load: the search ended there
constexpr double kWidestMass = 1.5;  // of a mass: with an interval wider than from half to twice of it the mass is undetermined
constexpr double kUniform = 3.0;         // variance of a uniform distribution = half its width squared / 3

// Numbers of the descent.
constexpr double kRidge = 1e-11;      // relative, so that equal columns can be solved for
constexpr double kTiny = 1e-300;
constexpr int kSteps = 80;            // of a descent, which ends before where it has converged
constexpr double kConverged = 1e-13;  // relative change of the cost
constexpr double kStartPlace = 0.3;   // of the reach: places from which descents start
constexpr double kStartMasses[] = {0.03, 0.15, 0.6, 2.5, 10.0};  // [kg] that give the moment a lever
constexpr double kMoreDamping = 8.0, kLessDamping = 0.2, kMostDamping = 1e8;
constexpr double kAtBound = 0.999;    // of the reach
constexpr double kSeen = 0.5;         // of the reach: with a deviation below it the place is determined
constexpr double kGrowth = 1.25;      // ratio of the masses tried in the search for the end of an interval
constexpr int kBisections = 40;
constexpr double kNearZero = 1e-3;    // share of the best mass, below which a load counts as zero
constexpr double kFirstDamping = 1e-3, kLeastDamping = 1e-12;
constexpr double kUntoldRidge = 1e-6;  // of the diagonal

}  // namespace veridyn::loads
