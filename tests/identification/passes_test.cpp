#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <vector>

#include "identification/period_fold.hpp"
#include "identification/read_ahead.hpp"

// Passes over a recording: segments come in order while a thread reads ahead, and repeats are compared.

namespace veridyn {
namespace {

// A pass of so many segments, at `fails` of which reading fails.
StretchPass pass_of(int segments, int fails = -1) {
  return [segments, fails](const VisitSegment& visit) {
    PreparationFacts facts;
    for (int k = 0; k < segments; ++k) {
      if (k == fails) throw std::runtime_error("reading");
      Segment s;
      s.start = k;
      visit(s);
      ++facts.samples;
    }
    return facts;
  };
}

TEST(ReadingAhead, BringsEverySegmentInOrder) {
  for (const int count : {0, 1, 50}) {
    std::vector<double> seen;
    const PreparationFacts facts = read_ahead(pass_of(count), [&](const Segment& s) { seen.push_back(s.start); });
    EXPECT_EQ(facts.samples, count);
    ASSERT_EQ(seen.size(), static_cast<size_t>(count));
    for (int k = 0; k < count; ++k) EXPECT_EQ(seen[k], k);
  }
}

// A visitor that fails ends the reading, which waits for room; a reader that fails has brought what was before.
TEST(ReadingAhead, ForwardsExceptions) {
  for (const int at : {0, 3}) {
    try {
      read_ahead(pass_of(50), [&](const Segment& s) {
        if (s.start == at) throw std::runtime_error("visiting");
      });
      ADD_FAILURE() << "no exception";
    } catch (const std::runtime_error& error) {
      EXPECT_STREQ(error.what(), "visiting");
    }
  }
  int seen = 0;
  try {
    read_ahead(pass_of(50, 5), [&](const Segment&) { ++seen; });
    ADD_FAILURE() << "no exception";
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(), "reading");
  }
  EXPECT_EQ(seen, 5);
}

// Relative floor of a joint with a period of a second, of which the second repeat differs by `difference`; the rows
// between `from` and `to` [s] are missing.
VectorXd floor_of(double difference, double from = -1.0, double to = -1.0) {
  PeriodFold fold(1, 1.0);
  MatrixXd tau(1, 1);
  for (int k = 0; k < 200; ++k) {
    const double t = 0.01 * k;
    if (t > from && t < to) continue;
    tau(0, 0) = 2.0 + (t < 1.0 ? 0.0 : difference);
    fold.add(t, tau, 0);
  }
  return fold.relative_floor();
}

TEST(Repeats, WithGapsGiveTheSameNoiseFloor) {
  ASSERT_EQ(floor_of(0.0).size(), 1);
  EXPECT_EQ(floor_of(0.0)[0], 0.0);
  // The variance of a difference is twice that of one repeat.
  const double expected = std::sqrt(0.5 * 0.01 / (0.5 * (2.0 * 2.0 + 2.1 * 2.1)));
  EXPECT_NEAR(floor_of(0.1)[0], expected, 1e-12);
  EXPECT_NEAR(floor_of(0.1, 0.3, 0.6)[0], expected, 1e-12);  // what is there repeats
  EXPECT_EQ(floor_of(0.1, 0.005, 0.995).size(), 0);          // nothing is there to compare with
  EXPECT_EQ(floor_of(0.1, 0.995, 2.0).size(), 0);
}

TEST(Repeats, WithoutAPeriodGiveNoNoiseFloor) {
  PeriodFold fold(2, 0.0);
  fold.add(0.0, MatrixXd::Ones(1, 2), 0);
  fold.add(1.0, MatrixXd::Ones(1, 2), 0);
  EXPECT_EQ(fold.relative_floor().size(), 0);
}

}  // namespace
}  // namespace veridyn
