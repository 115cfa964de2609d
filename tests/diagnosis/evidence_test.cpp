#include <gtest/gtest.h>

#include <Eigen/QR>
#include <random>

#include "diagnosis/evidence/examiner.hpp"
#include "diagnosis/evidence/folds.hpp"
#include "diagnosis/evidence/held_out.hpp"
#include "diagnosis/evidence/normal_blocks.hpp"
#include "diagnosis/evidence/numerics.hpp"
#include "math/clustered_statistics.hpp"
#include "math/student_t.hpp"

// What stands under the selection, on columns of one joint whose rows are known.

namespace veridyn {
namespace {

constexpr int kRows = 30;

const std::vector<std::string>& names() {
  static const std::vector<std::string> kNames = {"base", "cause", "idle", "copy"};
  return kNames;
}

// What differs between recordings.
struct Unlike {
  double spread = 0.0;  // the cause is larger by it in every second recording, and smaller in the others
  int acting = 1000;    // recordings in which the cause acts, the first ones
};

// Rows of several recordings in blocks: tau = base + cause + noise; copy = 3 base.
class Rows {
 public:
  Rows(int recordings, int blocks, double cause = 1.0, const Unlike& unlike = {}) {
    std::mt19937 random(11);
    std::normal_distribution<double> gauss;
    for (int r = 0; r < recordings; ++r) {
      CompressedRecording one;
      one.joints.resize(1);
      for (int b = 0; b < blocks; ++b) {
        MatrixXd A(kRows, 4);
        for (Eigen::Index k = 0; k < A.size(); ++k) A.data()[k] = gauss(random);
        A.col(3) = 3.0 * A.col(0);
        if (r >= unlike.acting) A.col(1).setZero();
        VectorXd tau = A.col(0) + (cause + (r % 2 == 0 ? unlike.spread : -unlike.spread)) * A.col(1);
        for (double& t : tau) t += 0.3 * gauss(random);
        SquareRootInformation factor(names());
        factor.absorb(A, tau);
        one.blocks.push_back({factor});
        A_.push_back(A);
        tau_.push_back(tau);
      }
      recordings_.push_back(one);
    }
  }

  NormalBlocks blocks() const { return NormalBlocks(recordings_, names()); }

  // Plain least squares on all rows but those of one cluster (-1: all), in the columns' own units.
  VectorXd fitted(const ColumnSet& set, int without) const {
    const auto [A, tau] = stacked(set, without, false);
    return Eigen::ColPivHouseholderQR<MatrixXd>(A).solve(tau);
  }

  double residual2(const ColumnSet& set, const VectorXd& x, int cluster) const {
    const auto [A, tau] = stacked(set, cluster, true);
    return (tau - A * x).squaredNorm();
  }

 private:
  std::pair<MatrixXd, VectorXd> stacked(const ColumnSet& set, int cluster, bool alone) const {
    std::vector<size_t> chosen;
    for (size_t c = 0; c < A_.size(); ++c) {
      if (cluster < 0 || alone == (static_cast<int>(c) == cluster)) chosen.push_back(c);
    }
    MatrixXd A(kRows * static_cast<Eigen::Index>(chosen.size()),
               static_cast<Eigen::Index>(set.size()));
    VectorXd tau(A.rows());
    for (size_t k = 0; k < chosen.size(); ++k) {
      const auto at = kRows * static_cast<Eigen::Index>(k);
      A.middleRows(at, kRows) = A_[chosen[k]](Eigen::all, set);
      tau.segment(at, kRows) = tau_[chosen[k]];
    }
    return {A, tau};
  }

  std::vector<CompressedRecording> recordings_;
  std::vector<MatrixXd> A_;
  std::vector<VectorXd> tau_;
};

TEST(NormalBlocks, SolveAsTheRowsDoWithAndWithoutACluster) {
  const Rows rows(2, 3);
  const NormalBlocks data = rows.blocks();
  ASSERT_EQ(data.clusters(), 6);
  EXPECT_EQ(data.recording_of(2), 0);
  EXPECT_EQ(data.recording_of(3), 1);
  const ColumnSet set = {0, 1};
  const VectorXd w = VectorXd::Ones(1);
  for (const int without : {-1, 4}) {
    const VectorXd x = data.solve(set, w, data.total(),
                                  without < 0 ? nullptr : &data.cluster(without));
    const VectorXd own_units = x.cwiseQuotient(data.scale()(set));
    const VectorXd truth = rows.fitted(set, without);
    EXPECT_LT((own_units - truth).norm(), 1e-8) << without;
    EXPECT_NEAR(data.residual2(set, x, data.cluster(4))[0], rows.residual2(set, truth, 4), 1e-7);
  }
}

const HoldOut kFour{4, 1e-6};

TEST(Folds, AreWholeRecordingsHalvesOrPhases) {
  using Folds = std::vector<std::vector<int>>;
  EXPECT_EQ(make_folds(Rows(1, 3).blocks(), kFour), (Folds{{0}, {1}, {2}}));
  EXPECT_EQ(make_folds(Rows(2, 4).blocks(), kFour), (Folds{{0, 1}, {2, 3}, {4, 5}, {6, 7}}));
  EXPECT_EQ(make_folds(Rows(4, 2).blocks(), kFour), (Folds{{0, 1}, {2, 3}, {4, 5}, {6, 7}}));
  const NormalBlocks data = Rows(2, 4).blocks();
  const NormalBlocks::Sums sums = summed(data, {1, 2});
  EXPECT_DOUBLE_EQ(sums.b2[0], data.cluster(1).b2[0] + data.cluster(2).b2[0]);
  EXPECT_DOUBLE_EQ(sums.rows[0], 2.0 * kRows);
}

TEST(Folds, TheGainIsTheMeanFallOfTheHeldOutError) {
  const Rows rows(1, 5);
  const NormalBlocks data = rows.blocks();
  double expected = 0.0;
  for (int c = 0; c < 5; ++c) {
    const double before = rows.residual2({0}, rows.fitted({0}, c), c);
    const double after = rows.residual2({0, 1}, rows.fitted({0, 1}, c), c);
    expected += std::log(before / after) / 5.0;
  }
  EXPECT_GT(expected, 1.0);
  EXPECT_NEAR(fold_gain(data, {0}, data, {0, 1}, kFour), expected, 1e-6);
  const VectorXd x = rows.fitted({0}, -1);
  EXPECT_NEAR(joint_weights(data, {0})[0] * rows.residual2({0}, x, -1), 5.0 * kRows, 1e-5);
}

std::vector<Hypothesis> hypotheses(ParameterSign sign) {
  std::vector<Hypothesis> out(3);
  for (size_t k = 0; k < out.size(); ++k) {
    out[k].cause = NewEffect{names()[k + 1], {0}};
    out[k].columns = {names()[k + 1]};
    out[k].signs = {sign};
  }
  return out;
}

TEST(Examiner, TellsACauseFromWhatIsIdleAndWhatIsThereAlready) {
  const NormalBlocks data = Rows(4, 4).blocks();
  const ColumnSet base = {0};
  const std::vector<Hypothesis> asked = hypotheses(ParameterSign::kAny);
  DiagnosisOptions options;
  options.identification.threads = 1;
  const Examiner examiner(data, base, asked, options);
  const std::vector<Evidence> all = examiner.evaluate_all({});
  EXPECT_TRUE(examiner.passes(all[0]));
  EXPECT_TRUE(all[0].consistent);
  EXPECT_FALSE(examiner.passes(all[1]));
  EXPECT_LT(all[1].gain, options.thresholds.smallest_gain);
  EXPECT_TRUE(all[2].collinear);
  const auto baseline = examiner.baseline({});
  const auto without_cluster = examiner.without_clusters(*baseline);
  EXPECT_LT(examiner.p_value(0, *baseline, without_cluster), 1e-6);
  EXPECT_GT(examiner.p_value(1, *baseline, without_cluster), examiner.limit(1));
  EXPECT_TRUE(examiner.evaluate_all({0})[0].accepted);
  EXPECT_EQ(examiner.set_with({0}), (ColumnSet{0, 1}));
}

// The columns' standard deviation is 1, the noise's 0.3.
TEST(Examiner, DeviationsAreThoseOfLeastSquares) {
  const NormalBlocks data = Rows(1, 40).blocks();
  const ColumnSet base = {0, 1};
  const std::vector<Hypothesis> none;
  const Examiner examiner(data, base, none, DiagnosisOptions());
  const VectorXd s = examiner.deviations(base, VectorXd::Ones(1), 39.0);
  const double expected = 0.3 / std::sqrt(40.0 * kRows);
  EXPECT_NEAR(s[0] / data.scale()[0], expected, 0.35 * expected);
  EXPECT_NEAR(s[1] / data.scale()[1], expected, 0.35 * expected);
}

// What differs from recording to recording counts as their number, and not as that of all blocks.
TEST(Examiner, DeviationsAreThoseBetweenRecordings) {
  const double spread = 0.5;
  const NormalBlocks data = Rows(4, 4, 1.0, {spread}).blocks();
  const ColumnSet base = {0, 1};
  const std::vector<Hypothesis> none;
  const Examiner examiner(data, base, none, DiagnosisOptions());
  const double s = examiner.deviations(base, VectorXd::Ones(1), 15.0)[1] / data.scale()[1];
  EXPECT_GT(s, spread / std::sqrt(3.0));  // of the mean of four; of sixteen it would be spread / sqrt(15)
}

// Of several parameters the best alone counts as often as there are parameters.
TEST(Examiner, OneOfTwoParametersIsTwoTests) {
  const Rows rows(1, 4, 0.05);
  const NormalBlocks data = rows.blocks();
  std::vector<Hypothesis> asked = hypotheses(ParameterSign::kAny);
  asked[0].columns = {"cause", "idle"};
  asked[0].signs = {ParameterSign::kAny, ParameterSign::kAny};
  const ColumnSet base = {0};
  const Examiner examiner(data, base, asked, DiagnosisOptions());
  const auto baseline = examiner.baseline({});
  const VectorXd x = rows.fitted({0, 1, 2}, -1).tail(2);
  MatrixXd without(2, 4);
  for (int c = 0; c < 4; ++c) without.col(c) = rows.fitted({0, 1, 2}, c).tail(2);
  const VectorXd deviation = jackknife_deviations(without);
  const double best = std::min(student_t_two_sided(x[0] / deviation[0], 3), student_t_two_sided(x[1] / deviation[1], 3));
  EXPECT_NEAR(examiner.p_value(0, *baseline, examiner.without_clusters(*baseline)), std::min(1.0, 2.0 * best), 1e-4);
}

// Recordings in which an end stop, say, is never touched do not disagree with it.
TEST(Examiner, FoldsInWhichACauseNeverActsSayNothing) {
  const NormalBlocks data = Rows(8, 4, 1.0, {0.0, 4}).blocks();
  const std::vector<Hypothesis> asked = hypotheses(ParameterSign::kAny);
  const ColumnSet base = {0};
  const Examiner examiner(data, base, asked, DiagnosisOptions());
  EXPECT_TRUE(examiner.evaluate(0, *examiner.baseline({})).consistent);
}

TEST(Examiner, ASignThatNatureForbidsIsNoAnswer) {
  const NormalBlocks data = Rows(4, 4, -1.0).blocks();
  const ColumnSet base = {0};
  for (const ParameterSign sign : {ParameterSign::kAny, ParameterSign::kNonnegative}) {
    const std::vector<Hypothesis> asked = hypotheses(sign);
    const Examiner examiner(data, base, asked, DiagnosisOptions());
    const Evidence e = examiner.evaluate(0, *examiner.baseline({}));
    EXPECT_EQ(e.infeasible_sign, sign == ParameterSign::kNonnegative);
    EXPECT_EQ(examiner.passes(e), sign == ParameterSign::kAny);
  }
  std::vector<Hypothesis> change = hypotheses(ParameterSign::kAny);
  change[0].lowest = {-0.5};  // what there is cannot fall by one
  const Examiner examiner(data, base, change, DiagnosisOptions());
  EXPECT_TRUE(examiner.evaluate(0, *examiner.baseline({})).infeasible_sign);
}

TEST(HeldOut, TheShareIsOfWhatLiesAboveTheNoise) {
  Identification baseline;
  baseline.test_error.relative = (VectorXd(2) << 0.5, 0.1).finished();
  baseline.noise_floor = VectorXd::Constant(2, 0.1);
  const VectorXd after = (VectorXd(2) << 0.3, 0.1).finished();
  EXPECT_NEAR(explained_share(baseline.test_error.relative, after, baseline), 0.16 / 0.24, 1e-12);
  EXPECT_NEAR(explained_share(after, baseline.test_error.relative, baseline), -0.16 / 0.24, 1e-12);
  EXPECT_EQ(explained_share(after, {}, baseline), 0.0);
  baseline.noise_floor = VectorXd::Constant(2, 0.6);
  EXPECT_EQ(explained_share(baseline.test_error.relative, after, baseline), 0.0);
}

}  // namespace
}  // namespace veridyn
