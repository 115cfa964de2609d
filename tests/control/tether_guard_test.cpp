#include "veridyn/control/tether_guard.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "veridyn/math/require.hpp"

// Two ends on a line: one is moved by somebody else, the other does what the guard says.

namespace veridyn {
namespace {

using Eigen::Vector3d;

constexpr double kPeriod = 1e-3;

struct Line {
  explicit Line(double stiffness = 20000.0) : guard(2, {{0, 1, stiffness}}, {}) {
    for (int k = 0; k < 2000; ++k) guard.update_length(0, 0.1 + 5.0 / stiffness, 5.0);
  }

  // The other end is at `x`. @returns the member's length.
  double step(const Vector3d& x) {
    const TetherGuard::Motion& own = guard.motion(0);
    positions = {own.position, x};
    guard.update(positions, healthy, 5.0);
    return (x - own.position).norm();
  }

  TetherGuard guard;
  std::vector<Vector3d> positions;
  std::vector<char> healthy{1, 0};
};

TEST(TetherGuard, EstimatesTheUnloadedLength) {
  const Line line;
  EXPECT_NEAR(line.guard.free_length(0), 0.1, 1e-9);
}

// What it learned first gives way to what it feels later.
TEST(TetherGuard, TheFreeLengthConvergesToAChangedLength) {
  Line line;
  double before = line.guard.free_length(0);
  for (int k = 0; k < 20000; ++k) {
    line.guard.update_length(0, 0.102 + 5.0 / 20000.0, 5.0);
    ASSERT_GE(line.guard.free_length(0), before);
    before = line.guard.free_length(0);
  }
  EXPECT_NEAR(before, 0.102, 1e-6);
}

// A string that has been slack keeps its margin; a strut that was compressed comes back to its length.
TEST(TetherGuard, AStringKeepsItsSlackMarginAndAStrutDoesNot) {
  for (const bool pushes : {false, true}) {
    Line line;
    if (pushes) line.guard.detect_compression(0, -1.0);
    for (int k = 0; k < 2000; ++k) line.step({0.1 - 0.01 * std::sin(M_PI * k / 2000), 0.0, 0.0});
    EXPECT_EQ(line.guard.motion(0).position.x() > 1e-3, !pushes) << line.guard.motion(0).position.x();
  }
}

// An end that first comes near, so that the string is slack, and then falls away at 10 m/s^2: the
// string never becomes tight again. Without the guard it would be tight after 0.1 s at 0.8 m/s.
TEST(TetherGuard, AFallingEndDoesNotTightenASlackString) {
  Line line;
  double longest = 0.0;
  for (int k = 0; k < 300; ++k) {
    const double t = kPeriod * k;
    const double x = 0.1 - 0.3 * t + 0.5 * 10.0 * t * t;
    longest = std::max(longest, line.step({x, 0.0, 0.0}));
  }
  EXPECT_GT(line.guard.motion(0).position.x(), 0.2);
  EXPECT_LE(longest, 0.1);  // as it begins
}

// Sideways: a pendulum that swings by tightens the string by its path's curvature alone.
TEST(TetherGuard, AnEndMovingSidewaysDoesNotTightenASlackString) {
  Line line;
  double longest = 0.0;
  for (int k = 0; k < 300; ++k) {
    const double t = kPeriod * k;
    longest = std::max(longest, line.step({0.088, 0.8 * t, 0.0}));
  }
  EXPECT_LT(longest, 0.1);
}

// A taut member of known stiffness is stretched by no more than what twice the force does.
TEST(TetherGuard, AGuardedTautMemberIsStretchedByAtMostTwiceItsForce) {
  Line line(2000.0);
  double longest = 0.0;
  for (int k = 0; k < 400; ++k) {
    const double t = kPeriod * k;
    longest = std::max(longest, line.step({0.1025 + 0.5 * 2.0 * t * t, 0.0, 0.0}));
  }
  EXPECT_LT(longest, 0.1 + 2.0 * 5.0 / 2000.0 + 1e-4);
  EXPECT_GT(longest, 0.104);
}

// Members that have pushed are not crushed; strings, which cannot push, are left alone.
TEST(TetherGuard, OnlyCompressibleMembersAreProtectedFromCompression) {
  for (const bool pushes : {false, true}) {
    Line line(2000.0);
    if (pushes) line.guard.detect_compression(0, -1.0);
    double shortest = 1.0;
    for (int k = 0; k < 200; ++k) {
      const double t = kPeriod * k;
      shortest = std::min(shortest, line.step({0.1 - 0.5 * 2.0 * t * t, 0.0, 0.0}));
    }
    if (pushes) {
      EXPECT_GT(shortest, 0.1 - 2.0 * 5.0 / 2000.0 - 1e-4);
    } else {
      EXPECT_EQ(line.guard.motion(0).position, Vector3d::Zero());
      EXPECT_LT(shortest, 0.07);
    }
  }
}

TEST(TetherGuard, AnUnloadedOrFaultyMemberIsNotMoved) {
  Line line;
  for (int k = 0; k < 1000; ++k)
    line.step({0.10025 + 1e-7 * std::sin(0.1 * k), 0.0, 0.0});
  EXPECT_LT(line.guard.motion(0).position.norm(), 1e-9);
  line.healthy[0] = 0;  // one that does not follow is told nothing
  line.step({0.2, 0.0, 0.0});
  EXPECT_LT(line.guard.motion(0).acceleration.norm(), 1e-6);
}

TEST(TetherGuard, NamesInvalidOptions) {
  EXPECT_THROW(TetherGuard(2, {{0, 2, 1.0}}, {}), InvalidInput);
  TetherGuardOptions bad;
  bad.horizon = 0.0;
  EXPECT_THROW(TetherGuard(2, {{0, 1, 1.0}}, bad), InvalidInput);
}

}  // namespace
}  // namespace veridyn
