#include "diagnosis/watch/smoothed_rows.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "support/near.hpp"
#include "support/refusal.hpp"
#include "veridyn/files/model_file.hpp"

namespace veridyn::watching {
namespace {

constexpr double kRate = 200.0;  // [Hz]

Model file() { return read_model("planar-2r"); }

// Both joints on parabolas, with their velocities, and torques that never stay.
Recording parabolas(double seconds) {
  const auto rows = static_cast<Eigen::Index>(seconds * kRate);
  Recording r;
  r.source = "rows";
  r.time = VectorXd::LinSpaced(rows, 0.0, static_cast<double>(rows - 1) / kRate);
  r.q = r.dq = r.tau = MatrixXd::Zero(rows, 2);
  for (int j = 0; j < 2; ++j) {
    const double a = j == 0 ? 0.3 : -0.2;
    r.q.col(j) = (0.1 + a * r.time.array().square()).matrix();
    r.dq.col(j) = 2.0 * a * r.time;
    r.tau.col(j) = (j + 1.0) * r.time;
  }
  return r;
}

struct Heard {
  std::vector<SmoothedRow> rows;
  std::vector<PositionJump> jumps;
  std::vector<Blindness> blind;
  int breaks = 0;
};

Heard received_events(const Model& arm, const std::vector<Recording>& pieces, bool jumps = false) {
  static const WatchNumbers numbers;
  SmoothedRows rows(arm, numbers);
  Heard out;
  rows.on_row = [&](const SmoothedRow& row) { out.rows.push_back(row); };
  rows.on_jump = [&](const PositionJump& jump) { out.jumps.push_back(jump); };
  rows.on_blind = [&](const Blindness& blind) { out.blind.push_back(blind); };
  rows.on_break = [&] { ++out.breaks; };
  for (const Recording& piece : pieces) {
    rows.add(piece);
    if (jumps) rows.enable_jump_detection();
  }
  return out;
}

// Local polynomials are exact on parabolas, whether velocities are recorded or derived.
TEST(SmoothedRowsOfAParabola, AreExact) {
  Recording bare = parabolas(2.0);
  bare.dq.resize(0, 0);
  for (const Recording& r : {parabolas(2.0), bare}) {
    const Heard h = received_events(file(), {r});
    ASSERT_GT(h.rows.size(), 300U);
    for (const SmoothedRow& row : h.rows) {
      for (int j = 0; j < 2; ++j) {
        const double a = j == 0 ? 0.3 : -0.2;
        EXPECT_NEAR(row.dq[j], 2.0 * a * row.time, 1e-9);
        EXPECT_NEAR(row.ddq[j], 2.0 * a, 1e-7);
        EXPECT_NEAR(row.tau[j], (j + 1.0) * row.time, 1e-12);
      }
    }
    EXPECT_EQ(h.breaks, 0);
    EXPECT_TRUE(h.blind.empty());
  }
}

// A new value every 50 ms, of rows every 5 ms: positions, velocities and torques on lines are what they are between them.
TEST(SmoothedRowsOfHeldSignals, AreExactOnLines) {
  const Recording whole = parabolas(3.0);
  for (int held = 0; held < 8; ++held) {
    Recording r = whole;
    r.q = 0.2 + 0.5 * (r.time * Eigen::RowVector2d(1.0, -0.6)).array();
    r.dq.rowwise() = Eigen::RowVector2d(0.5, -0.3);
    MatrixXd* signals[] = {&r.q, &r.dq, &r.tau};
    for (int s = 0; s < 3; ++s) {
      for (Eigen::Index k = 0; (held & (1 << s)) != 0 && k < r.time.size(); ++k) signals[s]->row(k) = signals[s]->row(k - (k + 3 * s) % 10 * (k > 9)).eval();
    }
    const Heard h = received_events(file(), {r});
    EXPECT_TRUE(h.blind.empty());
    EXPECT_EQ(h.breaks, 0);
    ASSERT_GT(h.rows.size(), 400U);
    for (const SmoothedRow& row : h.rows) {
      if (row.time < 0.5) continue;  // since the first new values
      EXPECT_NEAR(row.q[1], 0.2 - 0.3 * row.time, 1e-9) << held;
      EXPECT_NEAR(row.ddq[0], 0.0, 1e-6) << held;
      EXPECT_NEAR(row.tau[1], 2.0 * row.time, 1e-9) << held;
    }
    EXPECT_GT(h.rows.back().time, 2.7);
  }
}

// The last digit of a joint at rest goes back and forth every 20 ms: that is no slow refresh, and the window stays as it is.
TEST(SmoothedRowsAtRest, FlickeringDigitsDoNotWidenTheWindow) {
  Recording still = parabolas(3.0), slow = still;
  still.q.rowwise() = still.q.row(0).eval();
  still.dq.setZero();
  for (Eigen::Index k = 0; k < still.q.rows(); ++k) {
    still.q(k, 1) += k / 4 % 2 == 0 ? 0.0 : 1e-5;
    slow.q.row(k) = slow.q.row(k - k % 4).eval();
  }
  const double first = 1.0 / kRate;  // [s] of a torque that is not zero
  EXPECT_NEAR(received_events(file(), {still}).rows.front().time, first + WatchNumbers().half_window, 1e-9);
  EXPECT_NEAR(received_events(file(), {slow}).rows.front().time, first + kHalfWindow * 4.0 / kRate, 1e-9);
}

// Currents are torques by the drive gains of the file, and nothing without them.
TEST(SmoothedRowsOfCurrents, EqualThoseOfTheirTorques) {
  Recording currents = parabolas(2.0);
  currents.current = currents.tau;
  currents.current.col(0) /= 4.0;
  currents.current.col(1) /= -0.5;
  currents.tau.resize(0, 0);
  EXPECT_TRUE(refuses_with("no drive_gain", [&] { received_events(file(), {currents}); }));
  ModelDescription d = file().description();
  d.coordinates[0].drive_gain = 4.0;
  d.coordinates[1].drive_gain = -0.5;
  const Heard one = received_events(file(), {parabolas(2.0)}), other = received_events(Model(d), {currents});
  ASSERT_EQ(one.rows.size(), other.rows.size());
  for (size_t k = 0; k < one.rows.size(); ++k) EXPECT_TRUE(near(one.rows[k].tau, other.rows[k].tau, 1e-12)) << k;
  currents.current.resize(0, 0);
  EXPECT_TRUE(refuses_with("neither torques", [&] { received_events(Model(d), {currents}); }));
}

// An arm at rest without noise repeats its rows: after a tenth of a second this is rest, and no row is lost.
TEST(SmoothedRowsAtRest, AreUsed) {
  Recording still = parabolas(3.0);
  still.q.rowwise() = still.q.row(0).eval();
  still.dq.setZero();
  still.tau.rowwise() = still.tau.row(1).eval();
  const Heard h = received_events(file(), {still});
  EXPECT_EQ(h.breaks, 0);
  EXPECT_TRUE(h.blind.empty());
  ASSERT_FALSE(h.rows.empty());
  EXPECT_GT(h.rows.back().time, 2.7);
  for (size_t k = 1; k < h.rows.size(); ++k) EXPECT_NEAR(h.rows[k].time - h.rows[k - 1].time, 1.0 / kRate, 1e-9);
}

// Absurd numbers are no torques, and a time that is no number is none.
TEST(SmoothedRows, ReportAbsurdTorquesAsUnusableAndSkipTimesThatAreNoNumber) {
  Recording r = parabolas(4.0);
  r.tau.bottomRows(400).col(1).setConstant(-2e6);
  const Heard h = received_events(file(), {r});
  ASSERT_EQ(h.blind.size(), 1U);
  EXPECT_EQ(h.blind[0].why, "tau2 (elbow) is -2e+06");
  EXPECT_NEAR(h.blind[0].since, 2.0, 0.01);
  Recording damaged = parabolas(4.0);
  damaged.time[399] = std::nan("");
  damaged.time[400] = damaged.time[395];  // one row too late
  const Heard passed = received_events(file(), {damaged});
  EXPECT_TRUE(passed.blind.empty());
  EXPECT_EQ(passed.breaks, 0);
  EXPECT_NEAR(passed.rows.back().dq[0], 0.6 * passed.rows.back().time, 1e-6);
}

// One encoder that jumps has slipped; where all jump at once rows are missing, and smoothing begins anew.
TEST(SmoothedRowsWithJumps, DistinguishSlipsFromJoinedRows) {
  const Recording whole = parabolas(6.0);
  const int cut = 800;
  const Recording before = rows_of(whole, 0, cut);
  Recording slipped = rows_of(whole, cut, whole.rows() - cut), joined = slipped;
  slipped.q.col(1).array() += 0.05;
  joined.q.col(0).array() += 0.1;
  joined.q.col(1).array() -= 0.1;
  const Heard slip = received_events(file(), {before, slipped}, true);
  ASSERT_EQ(slip.jumps.size(), 1U);
  EXPECT_EQ(slip.jumps[0].joint, 1);
  EXPECT_NEAR(slip.jumps[0].size, 0.05, 1e-6);
  EXPECT_NEAR(slip.jumps[0].time, 4.0, 0.011);
  EXPECT_EQ(slip.breaks, 0);
  EXPECT_NEAR(slip.rows.back().q[1], 0.1 - 0.2 * std::pow(slip.rows.back().time, 2), 1e-2);  // taken off
  const Heard gap = received_events(file(), {before, joined}, true);
  EXPECT_TRUE(gap.jumps.empty());
  EXPECT_EQ(gap.breaks, 1);
  // Before the noise of positions is known, nothing is a slip.
  EXPECT_TRUE(received_events(file(), {before, slipped}).jumps.empty());
}

TEST(SmoothedRowsOfDamage, AFrozenPositionIsUnusableAndNoSlip) {
  Recording r = parabolas(4.0);
  const Eigen::Index from = 400;
  r.q.col(0).segment(from, 200).setConstant(r.q(from, 0));
  const Heard heard = received_events(file(), {rows_of(r, 0, 300), rows_of(r, 300, r.rows() - 300)}, true);
  ASSERT_EQ(heard.blind.size(), 1U);
  EXPECT_EQ(heard.blind[0].why.substr(0, 19), "q1 (shoulder) stays") << heard.blind[0].why;
  EXPECT_NEAR(heard.blind[0].since, 2.0, 0.01);
  EXPECT_TRUE(heard.jumps.empty());
}

TEST(SmoothedRowsOfDamage, TorquesOfNoDriveAreUnusable) {
  for (const double noise : {0.0, 0.01}) {
    Recording r = parabolas(4.0);
    for (int k = r.rows() / 2; k < r.rows(); ++k) r.tau.row(k).setConstant(k % 2 == 0 ? noise : -noise);
    const Heard heard = received_events(file(), {r});
    ASSERT_EQ(heard.blind.size(), 1U);
    EXPECT_NE(heard.blind[0].why.find("no drive is on"), std::string::npos) << heard.blind[0].why;
    EXPECT_NEAR(heard.blind[0].since, 2.0, 0.01);
  }
}

TEST(SmoothedRowsOfDamage, FromTheFirstRowOnIsReported) {
  Recording r = parabolas(4.0);
  r.tau.setZero();
  const Heard heard = received_events(file(), {r});
  ASSERT_EQ(heard.blind.size(), 1U);
  EXPECT_NE(heard.blind[0].why.find("no drive is on"), std::string::npos) << heard.blind[0].why;
  EXPECT_NEAR(heard.blind[0].since, 0.0, 0.01);
}

// In degrees per second from 2 to 3 s, of both joints or of one: positions are right, and no encoder slips.
TEST(SmoothedRowsOfDamage, AVelocityThatContradictsItsPositionIsUnusableAndNoSlip) {
  for (const int joints : {1, 2}) {
    Recording r = parabolas(4.0);
    r.dq.rightCols(joints).middleRows(r.rows() / 2, r.rows() / 4) *= 180.0 / M_PI;
    const Heard heard = received_events(file(), {rows_of(r, 0, 300), rows_of(r, 300, r.rows() - 300)}, true);
    ASSERT_EQ(heard.blind.size(), 1U) << joints;
    const std::string contradiction = "positions and velocities contradict each other";
    EXPECT_EQ(heard.blind[0].why, contradiction + (joints > 1 ? ": velocities are too large on all joints, as by a clock that is too fast" : ""));
    EXPECT_NEAR(heard.blind[0].since, 2.0, 0.1);
    EXPECT_TRUE(heard.jumps.empty()) << joints;
    const SmoothedRow& last = heard.rows.back();
    EXPECT_GT(last.time, 3.8);
    EXPECT_NEAR(last.q[1], 0.1 - 0.2 * std::pow(last.time, 2), 1e-6) << joints;
  }
}

// Without a usable row between them, a second pause is no news.
TEST(SmoothedRowsOfDamage, LateRowsAreReportedOnce) {
  Recording r = parabolas(1.0);
  r.time *= 1000.0;
  EXPECT_EQ(received_events(file(), {r}).blind.size(), 1U);
}

// A clock that is set back is known after a quarter of a second of rows, and smoothing begins anew there.
TEST(SmoothedRowsOfASetBackClock, ContinueWithTheNewClock) {
  Recording r = parabolas(6.0);
  const int cut = 800;
  r.time.tail(r.rows() - cut).array() -= 3.5;
  const Heard h = received_events(file(), {r}, true);
  ASSERT_EQ(h.blind.size(), 1U);
  EXPECT_EQ(h.blind[0].why, "the clock was set back to 0.5 s, and the watch begins anew");
  EXPECT_NEAR(h.blind[0].since, 4.0, 0.01);
  EXPECT_NEAR(h.blind[0].time, 4.25, 0.011);
  EXPECT_NEAR(h.blind[0].set_back, 3.5, 1e-9);
  EXPECT_EQ(h.breaks, 1);
  EXPECT_TRUE(h.jumps.empty());
  EXPECT_NEAR(h.rows.back().time, 2.45, 0.02);
  for (const SmoothedRow& row : h.rows) EXPECT_NEAR(row.dq[0], 0.6 * (row.time + (row.dq[0] > 2.4 ? 3.5 : 0.0)), 1e-6);
}

// Rows that cannot be used do not hide that the clock was set back.
TEST(SmoothedRowsOfASetBackClock, AreDetectedBehindBadRows) {
  Recording r = parabolas(6.0);
  r.time.bottomRows(400).array() -= 3.5;
  r.tau.bottomRows(400).col(1).setConstant(std::nan(""));
  const Heard h = received_events(file(), {r});
  ASSERT_EQ(h.blind.size(), 2U);
  EXPECT_NEAR(h.blind[0].set_back, 3.5, 1e-9);
  EXPECT_EQ(h.blind[1].why, "tau2 (elbow) is no number");
}

// Set back by less, the clock soon catches up: what lies between is no slip of an encoder.
TEST(SmoothedRowsOfASetBackClock, SlightlyAreABreakAndNoSlip) {
  Recording r = parabolas(6.0);
  for (MatrixXd* m : {&r.q, &r.dq}) m->col(1).setConstant(0.0);
  const int cut = 800;
  Recording later = r;
  later.time.tail(r.rows() - cut).array() -= 0.1;
  const Heard h = received_events(file(), {rows_of(later, 0, cut), rows_of(later, cut, r.rows() - cut)}, true);
  EXPECT_TRUE(h.jumps.empty());
  EXPECT_TRUE(h.blind.empty());
  EXPECT_EQ(h.breaks, 1);
  EXPECT_NEAR(h.rows.back().time, 5.85, 0.02);
}

// Neither old rows that come late, nor two clocks in turn, nor one that runs backwards or stands still, is a
// clock that was set back.
TEST(SmoothedRowsOfASetBackClock, OtherUnorderedTimesAreNotASetBackClock) {
  const Recording whole = parabolas(6.0);
  const Recording late = rows_of(whole, 700, 40);
  const Heard old = received_events(file(), {rows_of(whole, 0, 800), late, rows_of(whole, 800, 400)});
  EXPECT_TRUE(old.blind.empty());
  EXPECT_NEAR(old.rows.back().time, 5.95, 0.02);
  Recording two = whole;
  for (Eigen::Index k = 401; k < two.rows(); k += 2) two.time[k] -= 1.9;
  const Heard turns = received_events(file(), {two});
  EXPECT_TRUE(turns.blind.empty());
  EXPECT_EQ(turns.breaks, 0);
  EXPECT_NEAR(turns.rows.back().time, 5.94, 0.02);
  Recording backwards = whole;
  for (Eigen::Index k = 800; k < backwards.rows(); ++k) backwards.time[k] = 8.0 - whole.time[k];
  const Heard down = received_events(file(), {backwards});
  ASSERT_EQ(down.blind.size(), 1U);
  EXPECT_EQ(down.blind[0].why, "times do not rise");
  EXPECT_EQ(down.blind[0].set_back, 0.0);
}

}  // namespace
}  // namespace veridyn::watching
