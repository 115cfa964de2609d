#include "veridyn/recordings/stale_rows.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "veridyn/recordings/preprocessing.hpp"
#include "veridyn/files/model_file.hpp"

namespace veridyn {
namespace {

constexpr double kStep = 0.005;

// Two joints on waves, with velocities and efforts.
Recording waves(int rows) {
  Recording r;
  r.source = "waves";
  r.time = VectorXd::LinSpaced(rows, 1.0, 1.0 + kStep * (rows - 1));
  r.q = r.dq = r.tau = MatrixXd(rows, 2);
  for (int k = 0; k < rows; ++k) {
    for (int i = 0; i < 2; ++i) {
      const double w = 4.0 + i;
      r.q(k, i) = std::sin(w * r.time[k]);
      r.dq(k, i) = w * std::cos(w * r.time[k]);
      r.tau(k, i) = std::cos(3.0 * r.time[k]);
    }
  }
  return r;
}

void repeat(Recording& r, int from, int count) {
  for (int k = from; k < from + count; ++k) {
    for (MatrixXd* m : {&r.q, &r.dq, &r.tau}) m->row(k) = m->row(from - 1);
  }
}

struct Sound {
  Recording recording;
  FilledRows filled;
};

// All rows of a recording that is read and passed on in pieces of these sizes.
Sound sound_rows(const Recording& recording, int read = 1 << 20, int given = 1 << 20) {
  int at = 0;
  SoundRows rows([&](int) {
    const int count = std::min(read, recording.rows() - at);
    at += count;
    return rows_of(recording, at - count, count);
  });
  Sound out{recording, {}};
  int row = 0;
  while (true) {
    const Recording piece = rows.next(given);
    if (piece.rows() == 0) break;
    EXPECT_TRUE(piece.rows() == given || row + piece.rows() == recording.rows());
    EXPECT_EQ(piece.time, recording.time.segment(row, piece.rows()));
    for (const RecordingSignal& signal : kRecordingSignals) {
      if ((recording.*signal.values).size() > 0)
        (out.recording.*signal.values).middleRows(row, piece.rows()) = piece.*signal.values;
    }
    row += piece.rows();
  }
  EXPECT_EQ(row, recording.rows());
  out.filled = rows.filled();
  return out;
}

double largest(const MatrixXd& difference) {
  return difference.cwiseAbs().maxCoeff();
}

TEST(StaleRows, AreFilledInOnTheCubicThroughTheirNeighbours) {
  const Recording truth = waves(400);
  Recording late = truth;
  repeat(late, 50, 1);
  repeat(late, 100, 7);
  const Sound found = sound_rows(late);
  EXPECT_EQ(found.filled.count, 8);
  EXPECT_NEAR(found.filled.lateness(), kStep * (1 + 7 * 8 / 2) / 8.0, 1e-12);
  // A cubic over h errs by at most max |q''''| h^4 / 384, a straight line by |tau''| h^2 / 8.
  const double h = 8 * kStep;
  EXPECT_LT(largest(found.recording.q - truth.q), std::pow(5.0, 4) * std::pow(h, 4) / 384.0);
  EXPECT_LT(largest(found.recording.tau - truth.tau), 9.0 * h * h / 8.0 + 1e-12);
  EXPECT_GT(largest(late.q - truth.q), 0.1);
  // Nothing else changed.
  EXPECT_EQ(found.recording.q.row(49), truth.q.row(49));
  EXPECT_EQ(found.recording.q.row(107), truth.q.row(107));
}

// Positions and velocities come by one message and efforts by another: after a stale row the
// efforts are new while the positions are still old.
TEST(StaleRows, EachSignalIsFilledInUntilItsNextNewValue) {
  const Recording truth = waves(400);
  Recording late = truth;
  repeat(late, 100, 3);
  late.tau.row(102) = truth.tau.row(102);
  late.tau.row(98) = late.tau.row(99) = late.tau.row(100) = late.tau.row(101) = truth.tau.row(97);
  const Sound found = sound_rows(late);
  EXPECT_EQ(found.filled.count, 5);  // rows 98 to 102
  EXPECT_EQ(found.recording.tau.row(102), truth.tau.row(102));
  EXPECT_EQ(found.recording.q.row(98), truth.q.row(98));
  const double h = 5 * kStep;
  EXPECT_LT(largest(found.recording.tau - truth.tau), 9.0 * h * h / 8.0 + 1e-12);
  EXPECT_LT(largest(found.recording.q - truth.q), std::pow(5.0, 4) * std::pow(h, 4) / 384.0);
}

// Pieces end in the middle of repeats, and are shorter than they are.
TEST(StaleRows, AreFilledInEquallyForAnyPieceSize) {
  Recording late = waves(700);
  for (int k = 3; k < 660; k += 11 + k % 5) repeat(late, k, 1 + k % 8);
  repeat(late, 670, 12);
  const Sound whole = sound_rows(late);
  EXPECT_GT(whole.filled.count, 100);
  for (const int read : {1, 7, 64, 1000}) {
    for (const int given : {1, 10, 41, 699, 1000}) {
      const Sound found = sound_rows(late, read, given);
      EXPECT_EQ(found.recording.q, whole.recording.q) << read << " " << given;
      EXPECT_EQ(found.recording.dq, whole.recording.dq);
      EXPECT_EQ(found.recording.tau, whole.recording.tau);
      EXPECT_EQ(found.filled.count, whole.filled.count);
      EXPECT_DOUBLE_EQ(found.filled.age, whole.filled.age);
    }
  }
}

TEST(StaleRows, WithoutVelocitiesTheyAreInterpolatedLinearly) {
  Recording late = waves(100);
  late.dq.resize(0, 0);
  for (MatrixXd* m : {&late.q, &late.tau}) m->row(51) = m->row(50);
  const Eigen::RowVectorXd middle = 0.5 * (late.q.row(50) + late.q.row(52));
  EXPECT_TRUE(sound_rows(late).recording.q.row(51).isApprox(middle, 1e-14));
}

// Velocities in degrees, or in steps far above their range.
TEST(StaleRows, AWrongVelocityDoesNotDistortPositions) {
  Recording late = waves(400);
  late.dq *= 57.3;
  late.dq.col(1).array() += 50.0;
  repeat(late, 100, 3);
  const Sound found = sound_rows(late);
  EXPECT_EQ(found.filled.count, 3);
  for (int i = 0; i < 2; ++i) {
    const double low = std::min(late.q(99, i), late.q(103, i));
    const double high = std::max(late.q(99, i), late.q(103, i));
    for (int k = 100; k < 103; ++k) {
      EXPECT_GE(found.recording.q(k, i), low - 1e-12);
      EXPECT_LE(found.recording.q(k, i), high + 1e-12);
    }
  }
}

TEST(StaleRows, RestLongFreezesAndGapsAreNotInterpolated) {
  Recording r = waves(800);
  r.dq.row(399).setZero();
  repeat(r, 400, 5);   // at rest, though not for long
  repeat(r, 100, 40);  // 0.2 s
  repeat(r, 200, 2);
  for (MatrixXd* m : {&r.q, &r.dq, &r.tau}) (*m)(202, 1) = std::numeric_limits<double>::quiet_NaN();
  repeat(r, 300, 2);
  r.q(302, 0) = r.dq(302, 0) = r.tau(302, 0) = 1e305;
  repeat(r, 795, 5);  // until the end
  for (const int piece : {1000, 9}) {
    const Sound found = sound_rows(r, piece, piece);
    EXPECT_EQ(found.filled.count, 0);
    EXPECT_EQ(found.recording.tau.topRows(202), r.tau.topRows(202));
    EXPECT_EQ(found.recording.q.topRows(202), r.q.topRows(202));
    EXPECT_EQ(found.recording.q.bottomRows(597), r.q.bottomRows(597));
  }
}

// One signal alone may repeat by chance (a coarse encoder, a saturated motor).
TEST(StaleRows, ARecordingWithoutThemIsUnchangedBitForBit) {
  Recording r = waves(5000);
  r.q = (r.q.array() / 0.02).round() * 0.02;
  r.tau.middleRows(40, 100).setConstant(2.0);
  const Sound found = sound_rows(r, 512, 4096);
  EXPECT_EQ(found.filled.count, 0);
  EXPECT_EQ(found.recording.q, r.q);
  EXPECT_EQ(found.recording.tau, r.tau);
}

// What identification sees: all samples, in order.
struct Seen {
  MatrixXd q;
  PreparationFacts facts;
};

Seen seen(const Recording& r, StaleRows stale_rows) {
  PreprocessingOptions options;
  options.stale_rows = stale_rows;
  std::vector<MatrixXd> pieces;
  Seen out;
  out.facts = for_each_segment(read_model("planar-2r"), r, options, [&](const Segment& s) {
    pieces.push_back(s.q.middleRows(s.core_begin, s.core_end - s.core_begin));
  });
  out.q.resize(0, 2);
  for (const MatrixXd& piece : pieces) {
    out.q.conservativeResize(out.q.rows() + piece.rows(), 2);
    out.q.bottomRows(piece.rows()) = piece;
  }
  return out;
}

TEST(StaleRows, AreFilledInBeforeARecordingIsFiltered) {
  const Recording truth = waves(6000);
  Recording late = truth;
  for (int k = 5; k < 5990; k += 9 + k % 7) repeat(late, k, 1 + k % 3);
  const Seen wanted = seen(truth, StaleRows::kKept);
  // Bit for bit where there is nothing to fill in.
  EXPECT_EQ(seen(truth, StaleRows::kFilled).q, wanted.q);
  EXPECT_EQ(seen(truth, StaleRows::kFilled).facts.filled.count, 0);
  const Seen filled = seen(late, StaleRows::kFilled);
  const Seen kept = seen(late, StaleRows::kKept);
  EXPECT_GT(filled.facts.filled.count, 500);
  EXPECT_EQ(filled.facts.rows_read, 6000);
  EXPECT_EQ(kept.facts.filled.count, 0);
  // Of at most three repeats, a cubic that does not turn back errs by no more than a straight line.
  EXPECT_LT(largest(filled.q - wanted.q), 25.0 * std::pow(4 * kStep, 2) / 8.0);
  EXPECT_GT(largest(kept.q - wanted.q), 10.0 * largest(filled.q - wanted.q));
}

}  // namespace
}  // namespace veridyn
