#include "veridyn/recordings/preprocessing.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "identification/synthetic_recording.hpp"
#include "support/near.hpp"
#include "veridyn/identification/regressor_columns.hpp"
#include "veridyn/math/require.hpp"
#include "math/zero_phase_filter.hpp"
#include "veridyn/files/model_file.hpp"

namespace veridyn {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

Model robot(const std::string& name) {
  return read_model(VERIDYN_SOURCE_DIR "/data/robots/" + name + ".yaml");
}

PreprocessingOptions unfiltered() {
  PreprocessingOptions o;
  o.cutoff = 0.0;
  o.drop_start = 0.0;
  o.drop_end = 0.0;
  return o;
}

// The cores of all segments behind each other.
struct Pass {
  PreparationFacts facts;
  int segments = 0;
  VectorXd time;
  MatrixXd q, dq, ddq, tau;
  std::vector<char> use;
};

void append(MatrixXd& to, const MatrixXd& from) {
  const Eigen::Index rows = to.rows();
  to.conservativeResize(rows + from.rows(), from.cols());
  to.bottomRows(from.rows()) = from;
}

Pass pass(const Model& arm, const Recording& r, const PreprocessingOptions& options) {
  Pass p;
  p.facts = for_each_segment(arm, r, options, [&](const Segment& s) {
    const Eigen::Index n = s.core_end - s.core_begin;
    ++p.segments;
    p.time.conservativeResize(p.time.size() + n);
    p.time.tail(n) = s.time.segment(s.core_begin, n);
    append(p.q, s.q.middleRows(s.core_begin, n));
    append(p.dq, s.dq.middleRows(s.core_begin, n));
    append(p.ddq, s.ddq.middleRows(s.core_begin, n));
    append(p.tau, s.tau.middleRows(s.core_begin, n));
    p.use.insert(p.use.end(), s.use.begin() + s.core_begin, s.use.begin() + s.core_end);
  });
  return p;
}

// First and last time that is used; every sample between must be.
struct Range {
  double first = kNaN, last = kNaN;
  bool whole = true;
};
Range used(const Pass& p) {
  Range out;
  size_t first = p.use.size();
  size_t last = 0;
  for (size_t k = 0; k < p.use.size(); ++k) {
    if (p.use[k] == 0) continue;
    first = std::min(first, k);
    last = k;
  }
  if (first == p.use.size()) return out;
  out.first = p.time[static_cast<Eigen::Index>(first)];
  out.last = p.time[static_cast<Eigen::Index>(last)];
  for (size_t k = first; k <= last; ++k) out.whole = out.whole && p.use[k] != 0;
  return out;
}

// Joints move on straight lines, so that interpolation is exact: q_j = (j + 1) t, dq_j = j + 1,
// tau_j = 5 - t.
Recording lines(const VectorXd& time, int joints) {
  Recording r;
  r.source = "lines";
  r.time = time;
  r.q.resize(time.size(), joints);
  r.dq.resize(time.size(), joints);
  r.tau.resize(time.size(), joints);
  for (int j = 0; j < joints; ++j) {
    r.q.col(j) = (j + 1.0) * time;
    r.dq.col(j).setConstant(j + 1.0);
    r.tau.col(j) = 5.0 - time.array();
  }
  return r;
}

VectorXd even_time(Eigen::Index rows, double dt, double start = 0.0) {
  return VectorXd::LinSpaced(rows, start, start + static_cast<double>(rows - 1) * dt);
}

// ---- segments
// -----------------------------------------------------------------------------------------------------

// The whole recording as one segment, by the definition: filters over everything, then derivatives.
Segment one_piece(const Recording& r, const PreprocessingOptions& o) {
  Segment s;
  s.dt = r.time[1] - r.time[0];
  s.start = r.time[0];
  s.time = r.time;
  s.q = r.q;
  s.dq = r.dq;
  s.tau = r.tau;
  const bool signals = o.filtering == Filtering::kSignals;
  const ZeroPhaseFilter filter(signals ? o.cutoff : o.signal_cutoff_ratio * o.cutoff, o.order,
                               1.0 / s.dt);
  filter.apply(s.q);
  if (r.dq.size() > 0 && o.velocity == VelocitySource::kRecorded) {
    filter.apply(s.dq);
  } else {
    s.dq = differentiate(s.q, s.dt);
  }
  s.ddq = differentiate(s.dq, s.dt);
  if (signals) filter.apply(s.tau);
  s.use.assign(static_cast<size_t>(r.rows()), 1);
  s.core_begin = 0;
  s.core_end = r.rows();
  return s;
}

// A recording of more than three segments, with noise in every signal so that cuts would show.
Recording long_recording(const Model& arm) {
  MotionShape shape;
  shape.duration = 68.0;
  Recording r = synthetic_recording(arm, shape);
  r.q += noise_like(r.q, 1e-4, 1);
  r.dq += noise_like(r.dq, 1e-2, 2);
  r.tau += noise_like(r.tau, 0.3, 3);
  return r;
}

struct Variant {
  Filtering filtering;
  VelocitySource velocity;
  double cutoff;
  int order;
};

std::vector<Variant> variants() {
  return {{Filtering::kMatched, VelocitySource::kRecorded, 5.0, 6},
          {Filtering::kMatched, VelocitySource::kDerived, 3.5, 3},
          {Filtering::kSignals, VelocitySource::kRecorded, 5.0, 6},
          {Filtering::kSignals, VelocitySource::kDerived, 12.0, 10}};
}

PreprocessingOptions options_of(const Variant& v) {
  PreprocessingOptions o;
  o.filtering = v.filtering;
  o.velocity = v.velocity;
  o.cutoff = v.cutoff;
  o.order = v.order;
  o.drop_start = o.drop_end = 0.0;
  return o;
}

// A cut leaves 1e-9 of what the signals are in the core, beside the rounding of two derivatives
// over 5 ms.
TEST(Segments, SignalsEqualThoseOfARecordingInOnePiece) {
  const Model arm = robot("scara");
  const Recording r = long_recording(arm);
  for (const Variant& v : variants()) {
    const Pass p = pass(arm, r, options_of(v));
    ASSERT_GT(p.segments, 2);
    const Segment whole = one_piece(r, options_of(v));
    ASSERT_TRUE(near(p.time, whole.time, 1e-9));
    EXPECT_TRUE(near(p.q, whole.q, 1e-8));
    EXPECT_TRUE(near(p.dq, whole.dq, 1e-8 * (1.0 + whole.dq.cwiseAbs().maxCoeff())));
    EXPECT_TRUE(near(p.ddq, whole.ddq,
                     1e-8 * (1.0 + whole.ddq.cwiseAbs().maxCoeff()) /
                         (v.velocity == VelocitySource::kDerived ? 0.05 : 1.0)));
    EXPECT_TRUE(near(p.tau, whole.tau, 1e-8 * whole.tau.cwiseAbs().maxCoeff()));
  }
}

TEST(Segments, RegressorRowsEqualThoseOfARecordingInOnePiece) {
  const Model arm = robot("scara");
  const Recording r = long_recording(arm);
  for (const Variant& v : variants()) {
    const PreprocessingOptions options = options_of(v);
    const RegressorColumns columns(arm, options);
    const std::vector<JointRows> whole = columns.rows(one_piece(r, options));
    std::vector<MatrixXd> pieces(4);
    for_each_segment(arm, r, options, [&](const Segment& s) {
      const std::vector<JointRows> rows = columns.rows(s);
      for (size_t i = 0; i < 4; ++i) {
        MatrixXd both(rows[i].A.rows(), rows[i].A.cols() + 1);
        both << rows[i].A, rows[i].b;
        append(pieces[i], both);
      }
    });
    for (size_t i = 0; i < 4; ++i) {
      // A sign decided by a filtered velocity within 1e-4 of rest moves by 1e-8 / 1e-4 of one in a
      // sample, and by the filter's peak of 0.1 of that in the rows.
      const double scale = 1.0 + whole[i].A.cwiseAbs().maxCoeff();
      ASSERT_EQ(pieces[i].rows(), whole[i].A.rows());
      EXPECT_TRUE(near(pieces[i].leftCols(whole[i].A.cols()), whole[i].A,
                       v.velocity == VelocitySource::kDerived ? 2e-7 * scale : 1e-8 * scale));
      EXPECT_TRUE(
          near(pieces[i].rightCols(1), whole[i].b, 1e-8 * whole[i].b.cwiseAbs().maxCoeff()));
    }
  }
}

TEST(Segments, CoverEverySampleOnceForAnyLength) {
  const Model arm = robot("planar-2r");
  for (const Eigen::Index rows : {2, 50, 4095, 4096, 4097, 4600, 8192, 8193, 9000, 14000}) {
    for (const double cutoff : {0.0, 5.0}) {
      PreprocessingOptions o = unfiltered();
      o.cutoff = cutoff;
      const Pass p = pass(arm, lines(even_time(rows, 0.004, 3.0), 2), o);
      ASSERT_EQ(p.time.size(), rows) << "cut-off " << cutoff;
      EXPECT_TRUE(near(p.time, even_time(rows, 0.004, 3.0), 1e-9));
      EXPECT_EQ(p.facts.samples, rows);
      EXPECT_EQ(p.facts.rows_read, rows);
      EXPECT_EQ(p.facts.unused, 0);
      EXPECT_NEAR(p.facts.dt, 0.004, 1e-12);
      EXPECT_NEAR(p.facts.duration, 0.004 * static_cast<double>(rows - 1), 1e-9);
      EXPECT_EQ(std::count(p.use.begin(), p.use.end(), 1), rows);
    }
  }
}

TEST(ARecordingWithShiftedTime, GivesTheSameRegressorRows) {
  Model arm = robot("planar-2r");
  ModelDescription d = arm.description();
  EffectTerm term;
  term.effect = "warm_up";
  term.axis.coefficients = Eigen::Vector2d(1, 0);
  d.effects.push_back(term);
  arm = Model(d);
  MotionShape shape;
  shape.duration = 10.0;
  Recording r = synthetic_recording(robot("planar-2r"), shape);
  PreprocessingOptions options;
  options.decimation = 3;
  const auto rows_of = [&](const Recording& recording) {
    std::vector<JointRows> all;
    const RegressorColumns columns(arm, options);
    for_each_segment(arm, recording, options, [&](const Segment& s) { all = columns.rows(s); });
    return all;
  };
  const std::vector<JointRows> here = rows_of(r);
  for (const double shift : {0.0025, 400.0}) {
    Recording moved = r;
    moved.time.array() += shift;
    const std::vector<JointRows> there = rows_of(moved);
    ASSERT_EQ(there[0].A.rows(), here[0].A.rows()) << "shifted by " << shift;
    EXPECT_TRUE(near(there[0].A, here[0].A, 1e-8)) << "shifted by " << shift;
  }
}

// ---- time
// ----------------------------------------------------------------------------------------------------------

TEST(IrregularTime, IsResampledToEvenTime) {
  const Model arm = robot("scara");
  Random random(5);
  VectorXd time(6000);
  time[0] = 100.0;
  for (Eigen::Index k = 1; k < time.size(); ++k)
    time[k] = time[k - 1] + 0.005 * random.in(0.4, 1.6);
  const Pass p = pass(arm, lines(time, 4), unfiltered());
  EXPECT_NEAR(p.facts.dt, 0.005, 1e-4);
  EXPECT_NEAR(p.facts.duration, time[5999] - time[0], p.facts.dt);
  EXPECT_EQ(p.facts.rows_read, 6000);
  EXPECT_TRUE(near(p.time,
                   VectorXd::LinSpaced(p.time.size(), 100.0,
                                       100.0 + p.facts.dt * static_cast<double>(p.time.size() - 1)),
                   1e-9));
  for (int j = 0; j < 4; ++j) {
    EXPECT_TRUE(near(p.q.col(j), (j + 1.0) * p.time, 1e-9));
    EXPECT_TRUE(near(p.tau.col(j), (5.0 - p.time.array()).matrix(), 1e-9));
  }
  EXPECT_TRUE(near(p.ddq, MatrixXd::Zero(p.ddq.rows(), 4), 1e-9));
}

TEST(TheRate, SamplesHaveTheRateOfTheOptions) {
  const Model arm = robot("planar-2r");
  for (const double rate : {50.0, 100.0, 333.0}) {
    PreprocessingOptions o = unfiltered();
    o.rate = rate;
    const Pass p = pass(arm, lines(even_time(2001, 0.005), 2), o);
    EXPECT_EQ(p.facts.dt, 1.0 / rate);
    EXPECT_EQ(p.time.size(), static_cast<Eigen::Index>(10.0 * rate) + 1);
    EXPECT_TRUE(near(p.q.col(1), 2.0 * p.time, 1e-9));
    EXPECT_EQ(p.facts.unused, 0);
  }
}

// ---- gaps
// ----------------------------------------------------------------------------------------------------------

// One lost row is interpolated, and what is shorter than a quarter of a wave at the cut-off; of more,
// nothing between and within half a filter period is used.
TEST(Gaps, AreExcludedWithTheSamplesTheyAffect) {
  const Model arm = robot("planar-2r");
  for (const double cutoff : {0.0, 5.0}) {
    PreprocessingOptions o = unfiltered();
    o.cutoff = cutoff;
    Recording r = lines(even_time(3000, 0.005), 2);
    r.q(500, 0) = kNaN;                                      // one row
    for (int k = 1000; k < 1003; ++k) r.tau(k, 1) = kNaN;    // three rows
    for (int k = 2000; k < 2040; ++k) r.dq(k, 0) = 2e6;      // absurd
    r.q(2500, 1) = std::numeric_limits<double>::infinity();  // two rows
    r.q(2501, 1) = -std::numeric_limits<double>::infinity();
    const Pass p = pass(arm, r, o);
    ASSERT_EQ(p.time.size(), 3000);
    const double margin = cutoff > 0.0 ? 0.5 / cutoff : 0.0;
    long unused = 0;
    for (Eigen::Index k = 0; k < 3000; ++k) {
      const auto within = [&](double first, double last) {
        return k >= first - margin / 0.005 - 1e-6 && k <= last + margin / 0.005 + 1e-6;
      };
      const bool gap = within(2000, 2039) ||
                       (cutoff == 0.0 && (within(1000, 1002) || within(2500, 2501)));
      EXPECT_EQ(p.use[k] == 0, gap) << "row " << k << ", cut-off " << cutoff;
      unused += gap ? 1 : 0;
    }
    EXPECT_EQ(p.facts.unused, unused);
    EXPECT_TRUE(near(p.q.col(1), 2.0 * p.time, cutoff > 0.0 ? 1e-3 : 1e-9));
    EXPECT_TRUE(p.dq.allFinite() && p.tau.allFinite() && p.ddq.allFinite());
  }
}

// A publisher that loses three rows of ten at random leaves holes of up to some rows, far shorter than
// the waves that the filter lets through: nearly all samples count, at any rate.
TEST(Gaps, OfRowsLostAtRandomExcludeFewSamples) {
  const Model arm = robot("planar-2r");
  std::mt19937 random(5);
  for (const double dt : {0.005, 0.001}) {
    std::vector<double> times;
    for (int k = 0; k < 6000; ++k)
      if (random() % 10 >= 3) times.push_back(k * dt);
    PreprocessingOptions o = unfiltered();
    o.cutoff = 5.0;
    const VectorXd time = VectorXd::Map(times.data(), static_cast<Eigen::Index>(times.size()));
    const Pass p = pass(arm, lines(time, 2), o);
    EXPECT_LT(p.facts.unused, p.facts.samples / 20) << dt;
    EXPECT_TRUE(near(p.q.col(1), 2.0 * p.time, 1e-3));
  }
}

// Rows that are missing are known by their time.
TEST(Gaps, MissingRowsAreFoundByTheirTime) {
  const Model arm = robot("planar-2r");
  VectorXd time(200);
  for (Eigen::Index k = 0; k < 200; ++k) time[k] = 0.005 * static_cast<double>(k < 100 ? k : k + 7);
  const Pass p = pass(arm, lines(time, 2), unfiltered());
  ASSERT_EQ(p.time.size(), 207);
  for (size_t k = 0; k < 207; ++k) EXPECT_EQ(p.use[k] == 0, k >= 100 && k < 107) << k;
  EXPECT_TRUE(near(p.q.col(0), p.time, 1e-9));
}

// Velocities that are not wanted may be anything.
TEST(Gaps, OfAnUnusedSignalExcludeNoSamples) {
  const Model arm = robot("planar-2r");
  Recording r = lines(even_time(500, 0.005), 2);
  r.dq.setConstant(kNaN);
  PreprocessingOptions o = unfiltered();
  o.velocity = VelocitySource::kDerived;
  EXPECT_EQ(pass(arm, r, o).facts.unused, 0);
  r.current = MatrixXd::Constant(500, 2, kNaN);
  EXPECT_EQ(pass(arm, r, o).facts.unused, 0);
}

// ---- edges and rows
// ------------------------------------------------------------------------------------------------

// Lengths that end shortly after a segment does, and drops longer than a filter needs to settle.
TEST(Edges, AreDroppedForAnyLengthAndFilter) {
  const Model arm = robot("planar-2r");
  const double dt = 0.005;
  for (const double cutoff : {0.0, 5.0, 60.0}) {
    for (const Eigen::Index rows : {1000, 4090, 4096, 4100, 4150, 4700, 8230, 8700, 9000}) {
      for (const double drop_end : {0.0, 0.5, 3.0}) {
        PreprocessingOptions o = unfiltered();
        o.cutoff = cutoff;
        o.drop_start = 1.2;
        o.drop_end = drop_end;
        const double end = 2.0 + dt * static_cast<double>(rows - 1);
        const Range r = used(pass(arm, lines(even_time(rows, dt, 2.0), 2), o));
        EXPECT_NEAR(r.first, 3.2, 1e-6);
        EXPECT_NEAR(r.last, end - drop_end, 1e-6)
            << rows << " rows, cut-off " << cutoff << ", drop " << drop_end;
        EXPECT_TRUE(r.whole);
      }
    }
  }
}

TEST(RowsOfAFile, AreSelectedByTheOptions) {
  const Model arm = robot("planar-2r");
  struct Choice {
    long first, count;
  };
  for (const double cutoff : {0.0, 5.0}) {
    for (const Choice c : {Choice{0, 10},
                           {7, 1},
                           {100, 900},
                           {4000, 400},
                           {9000, 500},
                           {9000, -1},
                           {12999, -1},
                           {0, -1},
                           {0, 99999}}) {
      PreprocessingOptions o = unfiltered();
      o.cutoff = cutoff;
      o.first_row = c.first;
      if (c.count >= 0) o.row_count = c.count;
      const Range r = used(pass(arm, lines(even_time(13000, 0.005), 2), o));
      const long last = c.count < 0 ? 12999 : std::min(12999L, c.first + c.count - 1);
      EXPECT_NEAR(r.first, 0.005 * static_cast<double>(c.first), 1e-6)
          << c.first << ", " << c.count << ", cut-off " << cutoff;
      EXPECT_NEAR(r.last, 0.005 * static_cast<double>(last), 1e-6)
          << c.first << ", " << c.count << ", cut-off " << cutoff;
      EXPECT_TRUE(r.whole);
    }
    PreprocessingOptions o = unfiltered();
    o.cutoff = cutoff;
    o.first_row = 13000;
    EXPECT_TRUE(std::isnan(used(pass(arm, lines(even_time(13000, 0.005), 2), o)).first))
        << "rows behind the end";
  }
}

// ---- signals
// -------------------------------------------------------------------------------------------------------

TEST(Velocity, IsDerivedFromThePositionIfMissingOrIfRequested) {
  const Model arm = robot("planar-2r");
  MotionShape shape;
  shape.duration = 5.0;
  const Recording r = synthetic_recording(arm, shape);
  Recording without = r;
  without.dq.resize(0, 0);
  Recording wrong = r;
  wrong.dq.setConstant(9.0);
  PreprocessingOptions derived = unfiltered();
  derived.velocity = VelocitySource::kDerived;
  const Pass a = pass(arm, without, unfiltered());
  const Pass b = pass(arm, wrong, derived);
  const Eigen::Index inner = r.rows() - 4;
  // Fourth order at 200 Hz: (w h)^4 / 30 of the velocity, at 1 Hz 3e-8.
  EXPECT_TRUE(near(a.dq.middleRows(2, inner), r.dq.middleRows(2, inner), 1e-6));
  EXPECT_TRUE(near(a.dq, b.dq, 0.0));
  EXPECT_TRUE(near(pass(arm, wrong, unfiltered()).dq, wrong.dq, 0.0));
}

TEST(Currents, AreTorquesByTheDriveGains) {
  const Model arm = robot("ur10e");
  Recording r = lines(even_time(100, 0.01), 6);
  r.current = r.tau;
  r.current.col(3).array() += 2.0;
  Recording only = r;
  only.tau.resize(0, 0);
  const Pass p = pass(arm, only, unfiltered());
  for (int j = 0; j < 6; ++j) {
    EXPECT_TRUE(near(p.tau.col(j), arm.coordinates()[j].drive_gain * r.current.col(j), 1e-9));
  }
  EXPECT_TRUE(near(pass(arm, r, unfiltered()).tau, r.tau, 0.0)) << "torques go first";
}

TEST(Recordings, ThatDoNotFitTheArmAreRefused) {
  const Model arm = robot("planar-2r");
  const auto refused = [&](const Recording& r) {
    try {
      pass(arm, r, PreprocessingOptions{});
    } catch (const InvalidInput& e) {
      return std::string(e.what());
    }
    return std::string("accepted");
  };
  EXPECT_EQ(refused(lines(even_time(900, 0.005), 3)),
            "lines: found 3 joints, expected the 2 of robot 'planar-2r': shoulder, elbow (the others are a gripper? --map shoulder=1 takes the first 2 of them, --map NAME=NUMBER others).");
  Recording r = lines(even_time(900, 0.005), 2);
  r.tau.resize(0, 0);
  EXPECT_NE(refused(r).find("neither torques"), std::string::npos) << refused(r);
  r.current = r.q;
  EXPECT_NE(refused(r).find("no drive_gain for coordinate 'shoulder'"), std::string::npos)
      << refused(r);
  r = lines(even_time(900, 0.005), 2);
  r.q.setConstant(kNaN);
  EXPECT_NE(refused(r).find("no usable rows"), std::string::npos) << refused(r);
  EXPECT_NE(refused(r).find("q1, q2 without any."), std::string::npos) << refused(r);
  r = lines(even_time(900, 0.005), 2);
  r.dq = r.q;
  r.dq.col(1).setConstant(kNaN);
  EXPECT_NE(refused(r).find("dq2 without any; --velocity derived"), std::string::npos) << refused(r);
  // An outer join of two clocks.
  r = lines(even_time(900, 0.005), 2);
  for (int k = 0; k < 900; ++k) (k % 2 == 0 ? r.q : r.tau).row(k).setConstant(kNaN);
  EXPECT_NE(refused(r).find("no row all of them, as where two clocks share a table"), std::string::npos) << refused(r);
  EXPECT_NE(refused(lines(even_time(900, 0.005), 1)).find("--fix NAME=VALUE"), std::string::npos);
  EXPECT_NE(refused(lines(even_time(1, 0.005), 2)).find("one row"), std::string::npos);
}

TEST(Decimation, RateStaysAtLeastFourTimesTheCutOff) {
  PreprocessingOptions o;
  o.cutoff = 5.0;
  EXPECT_EQ(decimation(o, 0.005), 10);
  EXPECT_EQ(decimation(o, 0.02), 2);
  EXPECT_EQ(decimation(o, 0.1), 1);
  o.decimation = 3;
  EXPECT_EQ(decimation(o, 0.005), 3);
  o.decimation = 0;
  o.cutoff = 0.0;
  EXPECT_EQ(decimation(o, 0.005), 1);
}

}  // namespace
}  // namespace veridyn
