#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "effects/effect_support.hpp"

namespace veridyn {
namespace {

constexpr double kDistance = 0.01;
constexpr double kGap = 0.02;
constexpr double kFree = 0.8;  // documented: the share of the gap without contact

// Walks straight through the given places, `points` samples to each leg; the column at each place.
std::vector<double> walk(BoundEffect effect, const std::vector<double>& places, int points,
                         double speed) {
  std::vector<double> at_places;
  EffectColumns row{};
  AxisSample x;
  x.s = places.front();
  effect.columns(x, row);
  for (size_t leg = 1; leg < places.size(); ++leg) {
    const double way = places[leg] - places[leg - 1];
    for (int i = 1; i <= points; ++i) {
      x.s = i == points ? places[leg] : places[leg - 1] + way * i / points;
      x.ds = std::copysign(speed, way);
      x.time += std::abs(way) / points / speed;
      effect.columns(x, row);
    }
    at_places.push_back(row[0]);
  }
  return at_places;
}

// Work of column 0 on the way through the places, by the trapezoidal rule over fine steps.
double work(BoundEffect effect, const std::vector<double>& places, double step) {
  EffectColumns row{};
  effect.columns(moving(places.front(), 0), row);
  double sum = 0.0;
  double before = row[0];
  for (size_t leg = 1; leg < places.size(); ++leg) {
    const double way = places[leg] - places[leg - 1];
    const int points = std::max(1, static_cast<int>(std::ceil(std::abs(way) / step)));
    for (int i = 1; i <= points; ++i) {
      effect.columns(moving(places[leg - 1] + way * i / points, 0), row);
      sum += 0.5 * (before + row[0]) * way / points;
      before = row[0];
    }
  }
  return sum;
}

// Of work(): a corner of the force costs at most step^2 / 8 times its change of slope. The steepest
// slope is that of the teeth, 2 / gap / (1 - kFree); a leg passes four corners at most.
double work_error(size_t legs, double step) {
  return static_cast<double>(4 * legs) * step * step / 8 * (2 / kGap / (1 - kFree));
}

BoundEffect presliding() {
  return bound("presliding_hysteresis", {{"distance", kDistance}});
}
BoundEffect backlash() {
  return bound("backlash", {{"gap", kGap}});
}

std::vector<double> random_places(unsigned seed, double reach) {
  Random random(seed);
  std::vector<double> places{0.0};
  for (int i = 0; i < 60; ++i) places.push_back(random.in(-reach, reach));
  return places;
}

class RateIndependent : public testing::TestWithParam<std::string> {
 protected:
  static BoundEffect effect() { return GetParam() == "backlash" ? backlash() : presliding(); }
};
INSTANTIATE_TEST_SUITE_P(Effect, RateIndependent,
                         testing::Values("presliding_hysteresis", "backlash"), effect_case);

TEST_P(RateIndependent, TheForceDependsOnThePathAndNeitherOnSpeedNorOnSampling) {
  const std::vector<double> places = random_places(21, 2 * kDistance);
  const std::vector<double> slow = walk(effect(), places, 1000, 1e-4);
  const std::vector<double> fast = walk(effect(), places, 7, 2.0);
  for (size_t i = 0; i < slow.size(); ++i) EXPECT_NEAR(slow[i], fast[i], 1e-11) << i;
}

TEST_P(RateIndependent, TheForceIsBoundedByItsLevelForStepsOfAnySize) {
  Random random(22);
  BoundEffect e = effect();
  EffectColumns row{};
  AxisSample x;
  double largest = 0.0;
  for (int k = 0; k < 20000; ++k) {
    x.s += std::pow(10.0, random.in(-9, 0)) * (random.in(-1, 1) < 0 ? -1 : 1);
    e.columns(x, row);
    largest = std::max(largest, std::abs(row[0]));
  }
  EXPECT_LE(largest, 1.0);
  EXPECT_GT(largest, 0.99);
}

TEST_P(RateIndependent, TheMirroredPathHasTheMirroredForce) {
  std::vector<double> places = random_places(23, 2 * kDistance);
  const std::vector<double> force = walk(effect(), places, 3, 1.0);
  for (double& s : places) s = -s;
  const std::vector<double> mirrored = walk(effect(), places, 3, 1.0);
  for (size_t i = 0; i < force.size(); ++i) EXPECT_EQ(mirrored[i], -force[i]);
}

TEST_P(RateIndependent, TheForceAtTheFirstSampleIsZeroWhateverItsPosition) {
  BoundEffect e = effect();
  EffectColumns row{};
  e.columns(moving(-0.7, 2.0), row);
  EXPECT_EQ(row[0], 0.0);
}

TEST_P(RateIndependent, KeepsItsForceAtRestAndTendsToCoulombFriction) {
  BoundEffect e = effect();
  EffectColumns row{};
  for (const double s : {0.0, 0.3, 0.295}) e.columns(moving(s, 0), row);
  const double held = row[0];
  for (int k = 0; k < 100; ++k) e.columns(moving(0.295, 0), row);
  EXPECT_EQ(row[0], held);
  e.columns(moving(1.0, 0), row);
  EXPECT_NEAR(row[0], 1.0, 1e-15);
  e.columns(moving(0.0, 0), row);
  EXPECT_NEAR(row[0], -1.0, 1e-15);
}

// Whatever was done before, a closed path of force over position takes work.
TEST_P(RateIndependent, ClosedLoopsNeverGenerateEnergy) {
  const double step = kDistance / 1000;
  for (unsigned seed = 30; seed < 40; ++seed) {
    const std::vector<double> path = random_places(seed, 1.5 * kDistance);
    BoundEffect e = effect();
    EffectColumns row{};
    for (const double s : path) e.columns(moving(s, 0), row);
    // Twice the same loop: the second time the state repeats as well.
    std::vector<double> loop = random_places(seed + 100, 1.5 * kDistance);
    loop.front() = path.back();
    loop.push_back(path.back());
    const double once = work(e, loop, step);
    std::vector<double> twice = loop;
    twice.insert(twice.end(), loop.begin() + 1, loop.end());
    EXPECT_GE(work(e, twice, step) - once, -work_error(3 * loop.size(), step)) << seed;
  }
}

TEST_P(RateIndependent, FromTheUnloadedStateItNeverReturnsMoreEnergyThanItStored) {
  const double step = kDistance / 1000;
  for (unsigned seed = 50; seed < 60; ++seed) {
    const std::vector<double> path = random_places(seed, kDistance);
    for (size_t n = 2; n < path.size(); n += 5) {
      const std::vector<double> start(path.begin(), path.begin() + static_cast<long>(n));
      EXPECT_GE(work(effect(), start, step), -work_error(n, step)) << seed << " " << n;
    }
  }
}

TEST(PreslidingHysteresis, LoadsFromRestAndReversesAlongExponentials) {
  for (const double way : {1e-8, 1e-4, kDistance, 3 * kDistance}) {
    // First loading: 1 - exp(-way / distance).
    EXPECT_NEAR(walk(presliding(), {0.0, way}, 5, 1.0)[0], 1 - std::exp(-way / kDistance), 1e-14);
    // Out of full sliding: -(1 - 2 exp(-way / distance)) in the direction of the motion left.
    const double reversed = walk(presliding(), {0.0, 1.0, 1.0 - way}, 5, 1.0)[1];
    EXPECT_NEAR(reversed, 2 * std::exp(-way / kDistance) - 1, 1e-13);
  }
}

// From z it gives back at most distance * (|z| - ln(1 + |z|)); what it took beyond the change of
// that is heat.
TEST(PreslidingHysteresis, EveryStepStoresAtLeastTheRecoverableEnergy) {
  const auto available = [](double z) {
    return kDistance * (std::abs(z) - std::log1p(std::abs(z)));
  };
  Random random(24);
  BoundEffect e = presliding();
  EffectColumns row{};
  double s = 0.0;
  e.columns(moving(s, 0), row);
  for (int k = 0; k < 5000; ++k) {
    const double step = random.in(-2, 2) * kDistance;
    const double before = row[0];
    e.columns(moving(s += step, 0), row);
    // The integral of z ds over the step, from dz/ds = (1 - sgn z) / distance.
    const double taken = std::abs(step) - std::copysign(kDistance, step) * (row[0] - before);
    EXPECT_GE(taken, available(row[0]) - available(before) - 1e-15) << k;
  }
}

TEST(PreslidingHysteresis, AWideLoopDissipatesFourTimesAmplitudeMinusDistance) {
  const double A = 0.5;
  const double step = kDistance / 100;
  const double loop = work(presliding(), {0, A, -A, A}, step) - work(presliding(), {0, A}, step);
  // Trapezoidal rule: step^2 / 12 times the change of slope, 2 / distance, at both reversals.
  EXPECT_NEAR(loop, 4 * (A - kDistance), step * step / 12 * 2 * (2 / kDistance) * 1.01);
}

TEST(Backlash, ForceIsZeroInsideTheGapAndRisesTowardsItsEnds) {
  // Out of contact in front, 1 - 2 way / gap is the place in the gap.
  for (const double share : {0.0, 0.05, 0.1, 0.3, 0.5, 0.7, 0.9, 0.95, 1.0, 2.0}) {
    const double place = std::clamp(1 - 2 * share, -1.0, 1.0);
    const double contact = std::max(0.0, std::abs(place) - kFree) / (1 - kFree);
    const double force = walk(backlash(), {0.0, 1.0, 1.0 - share * kGap}, 4, 1.0)[1];
    EXPECT_NEAR(force, std::copysign(contact, place), 1e-12) << share;
  }
}

TEST(Backlash, ALoopDissipatesItsLengthMinusTheTwoGaps) {
  const double step = kGap / 1000;
  const double A = 0.05;
  const double wide = work(backlash(), {0, A, -A, A}, step) - work(backlash(), {0, A}, step);
  EXPECT_NEAR(wide, 2 * (2 * A - kGap), work_error(3, step));
  EXPECT_NEAR(work(backlash(), {0, 0.4 * kGap, -0.45 * kGap, 0}, step), 0.0, work_error(3, step));
}

TEST(FrictionWithADistance, ItsSignIsTheStateOfThePreslidingHysteresis) {
  BoundEffect z = presliding();
  BoundEffect load = bound("load_dependent_friction", {{"distance", kDistance}});
  BoundEffect place =
      bound("position_dependent_friction", {{"distance", kDistance}, {"centre", 0.1}});
  EffectColumns expected{};
  EffectColumns row{};
  for (const double s : random_places(25, kDistance)) {
    AxisSample x = moving(s, 0.0);
    x.load = -3.0;
    z.columns(x, expected);
    load.columns(x, row);
    EXPECT_EQ(row[0], 3.0 * expected[0]);
    place.columns(x, row);
    EXPECT_EQ(row[0], expected[0] * (s - 0.1));
  }
}

// The divided difference of a quadratic is exact, however the samples lie in time.
TEST(TransmissionCompliance, DifferentiatesAQuadraticLoadExactlyAtIrregularTimes) {
  BoundEffect e = bound("transmission_compliance");
  Random random(26);
  EffectColumns row{};
  AxisSample x;
  for (int k = 0; k < 50; ++k) {
    x.time += random.in(0.5, 1.5);
    x.load = 2.0 - 3.0 * x.time + 0.7 * x.time * x.time;
    e.columns(x, row);
    // Rounding: loads up to 2000, divided twice by steps of at least 0.5.
    EXPECT_NEAR(row[0], k < 2 ? 0.0 : 1.4, 2000 * 2.2e-16 * 32) << k;
  }
}

TEST(TransmissionCompliance, IsTheSecondDerivativeOfTheLoadOneSampleBefore) {
  constexpr double kW = 20.0;
  constexpr double kDt = 1e-3;
  BoundEffect e = bound("transmission_compliance");
  EffectColumns row{};
  AxisSample x;
  for (int k = 0; k < 300; ++k) {
    x.time = k * kDt;
    x.load = std::sin(kW * x.time);
    e.columns(x, row);
    if (k < 2) continue;
    const double expected = -kW * kW * std::sin(kW * (x.time - kDt));
    EXPECT_NEAR(row[0], expected, std::pow(kW, 4) * kDt * kDt / 12 + 4 * 2.2e-16 / (kDt * kDt));
  }
}

TEST(TransmissionCompliance, ARepeatedSampleGivesTheSameValue) {
  BoundEffect e = bound("transmission_compliance");
  EffectColumns row{};
  AxisSample x;
  for (int k = 0; k < 5; ++k) {
    x.time = k;
    x.load = 0.5 * k * k;
    e.columns(x, row);
    const double once = row[0];
    e.columns(x, row);
    EXPECT_EQ(row[0], once);
  }
  EXPECT_NEAR(row[0], 1.0, 1e-14);
}

TEST(Memory, AResetEffectActsLikeANewOne) {
  for (const std::string& name : axis_effect_names()) {
    BoundEffect fresh = bound(name);
    BoundEffect used = bound(name);
    EffectColumns row{};
    for (const AxisSample& x : random_samples(27)) used.columns(x, row);
    used.reset();
    for (const AxisSample& x : random_samples(28)) {
      EffectColumns expected{};
      fresh.columns(x, expected);
      row = {};
      used.columns(x, row);
      EXPECT_EQ(row, expected) << name;
    }
  }
}

}  // namespace
}  // namespace veridyn
