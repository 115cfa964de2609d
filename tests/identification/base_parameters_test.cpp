#include "veridyn/identification/base_parameters.hpp"

#include <Eigen/SVD>
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "identification/synthetic_recording.hpp"
#include "support/near.hpp"
#include "math/dense.hpp"
#include "veridyn/files/model_file.hpp"

namespace veridyn {
namespace {

Model robot(const std::string& name) {
  return read_model(VERIDYN_SOURCE_DIR "/data/robots/" + name + ".yaml");
}

SquareRootInformation factor_of(const Model& arm) {
  return random_state_factor(arm, 120, 17);
}

// Columns of one size, so that kilograms and inertias of a wrist count alike.
VectorXd column_scale(const Model& arm) {
  VectorXd norms = factor_of(arm).column_norms();
  const double rounding = 1e-14 * norms.maxCoeff();
  for (double& x : norms) x = x > rounding ? 1.0 / x : 0.0;
  return norms;
}

// The row space of K, in scaled columns: an orthonormal basis (standard x base).
MatrixXd row_space(const MatrixXd& K, const VectorXd& scale) {
  return orthonormal_basis((K * scale.asDiagonal()).transpose());
}

MatrixXd independent_columns(const MatrixXd& Y, const BaseParameters& base) {
  MatrixXd out(Y.rows(), base.size());
  for (int i = 0; i < base.size(); ++i)
    out.col(i) = Y.col(base.independent[i]);
  return out;
}

class OfEveryRobot : public testing::TestWithParam<std::string> {
 protected:
  const Model arm_ = robot(GetParam());
  const BaseParameters base_ = base_parameters(arm_);
};

std::vector<std::string> robots() {
  return {"elbow-6r",         "kuka-lwr4",     "mtm",       "mtm-rods", "planar-2r", "psm-3dof",
          "psm-3dof-printed", "psm-3dof-rods", "psm-wrist", "scara",    "ur10e"};
}

std::string test_name(const testing::TestParamInfo<std::string>& info) {
  std::string name = info.param;
  for (char& c : name) c = std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
  return name;
}

INSTANTIATE_TEST_SUITE_P(Robots, OfEveryRobot, testing::ValuesIn(robots()), test_name);

// The list above is complete.
TEST(BaseParametersOf, EveryRobotFileAreTested) {
  const std::vector<std::string> here = robots();
  for (const std::string& name : robot_names())
    EXPECT_NE(std::find(here.begin(), here.end(), name), here.end()) << name;
}

// Y phi = Y(:, independent) K phi for every phi, at states that the reduction has not seen.
TEST_P(OfEveryRobot, BaseParametersReproduceAllTorques) {
  const MatrixXd Y = random_regressor(arm_, 60, 5);
  const MatrixXd reproduced = independent_columns(Y, base_) * base_.K;
  for (Eigen::Index j = 0; j < Y.cols(); ++j) {
    // Coefficients below 1e-7 of a scaled column are dropped as rounding.
    EXPECT_TRUE(near(reproduced.col(j), Y.col(j), 1e-6 * (1e-3 + Y.col(j).cwiseAbs().maxCoeff())))
        << "column " << j;
  }
}

TEST_P(OfEveryRobot, IndependentColumnsOfKAreTheIdentity) {
  ASSERT_EQ(base_.K.rows(), base_.size());
  EXPECT_TRUE(near(independent_columns(base_.K, base_),
                   MatrixXd::Identity(base_.size(), base_.size()), 0.0));
}

TEST_P(OfEveryRobot, RankAndSpanAreThoseOfTheSingularValueDecomposition) {
  const VectorXd scale = column_scale(arm_);
  const Eigen::BDCSVD<MatrixXd> svd(factor_of(arm_).R() * scale.asDiagonal(), Eigen::ComputeFullV);
  ASSERT_EQ((svd.singularValues().array() > 1e-8 * svd.singularValues()[0]).count(), base_.size());
  const MatrixXd P = row_space(base_.K, scale);
  const MatrixXd Q = svd.matrixV().leftCols(base_.size());
  ASSERT_EQ(P.cols(), base_.size());
  EXPECT_TRUE(near(P * P.transpose(), Q * Q.transpose(), 1e-6));
}

// The tolerance of 1e-8 is not a matter of taste: nothing lies anywhere near it.
TEST_P(OfEveryRobot, SingularValuesHaveALargeGapAtTheRank) {
  ASSERT_LT(base_.size(), base_.singular_values.size());
  EXPECT_GT(base_.rank_gap, 1e6);
  EXPECT_GT(base_.singular_values[base_.size() - 1], 1e-5 * base_.singular_values[0]);
  for (const unsigned seed : {2U, 3U}) {
    const SquareRootInformation other = random_state_factor(arm_, 80, seed);
    EXPECT_EQ(base_parameters(other, preferred_columns(standard_parameters(arm_))).size(),
              base_.size())
        << "seed " << seed;
  }
}

// kAlone: the torques determine the parameter itself, e_j lies in the row space of K. kNot: they do
// not depend on it.
TEST_P(OfEveryRobot, IdentifiabilityClassesMatchTheNullSpace) {
  const MatrixXd Y = random_regressor(arm_, 60, 6);
  const MatrixXd P = row_space(base_.K, column_scale(arm_));
  ASSERT_EQ(static_cast<Eigen::Index>(base_.classes.size()), Y.cols());
  for (Eigen::Index j = 0; j < Y.cols(); ++j) {
    const bool acts = Y.col(j).cwiseAbs().maxCoeff() > 1e-9;
    const bool known =
        acts && (VectorXd::Unit(Y.cols(), j) - P * P.row(j).transpose()).norm() < 1e-6;
    const Identifiability expected = !acts   ? Identifiability::kNot
                                     : known ? Identifiability::kAlone
                                             : Identifiability::kInCombination;
    EXPECT_EQ(static_cast<int>(base_.classes[j]), static_cast<int>(expected))
        << standard_parameters(arm_)[j].name;
  }
}

// Effects are named themselves where they can be, and every expression begins with the parameter it
// is named after.
TEST_P(OfEveryRobot, BaseParametersAreNamedAfterTheirIndependentParameter) {
  const std::vector<std::string> names = parameter_names(standard_parameters(arm_));
  ASSERT_EQ(base_.names.size(), static_cast<size_t>(base_.size()));
  for (size_t i = 0; i < base_.names.size(); ++i) {
    EXPECT_EQ(base_.names[i], names[base_.independent[i]]);
    EXPECT_EQ(base_.expressions[i].rfind(base_.names[i], 0), 0U) << base_.expressions[i];
    const auto terms = (base_.K.row(i).array() != 0.0).count();
    const bool plain = base_.expressions[i] == base_.names[i];
    EXPECT_EQ(plain, terms == 1) << base_.expressions[i];
  }
}

// Bodies and friction as the files declare them. psm and ur10e: counted by numpy's SVD of the same
// regressors in the prototypes; planar-2r: 6 + 4 friction, closed form below.
TEST(BaseParametersOf, KnownRobotsHaveThePublishedNumber) {
  const std::map<std::string, int> known{{"psm-3dof", 25},  {"psm-3dof-printed", 28},
                                         {"psm-wrist", 49}, {"ur10e", 58},
                                         {"kuka-lwr4", 43},  // Gaz et al., ICRA 2014
                                         {"planar-2r", 10}};
  for (const auto& [name, count] : known)
    EXPECT_EQ(base_parameters(robot(name)).size(), count) << name;
}

// The six combinations of a planar 2R in a vertical plane, as in every textbook; here for frames at
// the far ends, so that first moments and inertias about the joints are hx + l m and Lzz + 2 l hx +
// l^2 m:
//   about joint 2:  Lzz2 + 2 l2 hx2 + l2^2 m2,              hx2 + l2 m2,        hy2
//   about joint 1:  Lzz1 + 2 l1 hx1 + l1^2 (m1 + m2),       hx1 + l1 (m1 + m2), hy1
TEST(BaseParametersOf, AVerticalPlanar2RAreThoseOfTheTextbook) {
  const Model arm = robot("planar-2r");
  const BaseParameters base = base_parameters(arm);
  const double l1 = arm.description().constants.at("l1");
  const double l2 = arm.description().constants.at("l2");
  MatrixXd known = MatrixXd::Zero(10, 24);
  enum { m1, hx1, hy1, Lzz1 = 9, m2 = 10, hx2, hy2, Lzz2 = 19, friction };
  known(0, Lzz1) = 1.0;
  known(0, hx1) = 2.0 * l1;
  known(0, m1) = known(0, m2) = l1 * l1;
  known(1, hx1) = 1.0;
  known(1, m1) = known(1, m2) = l1;
  known(2, hy1) = 1.0;
  known(3, Lzz2) = 1.0;
  known(3, hx2) = 2.0 * l2;
  known(3, m2) = l2 * l2;
  known(4, hx2) = 1.0;
  known(4, m2) = l2;
  known(5, hy2) = 1.0;
  for (int k = 0; k < 4; ++k) known(6 + k, friction + k) = 1.0;
  ASSERT_EQ(base.size(), 10);
  const VectorXd ones = VectorXd::Ones(24);
  const MatrixXd P = row_space(base.K, ones);
  const MatrixXd Q = row_space(known, ones);
  EXPECT_TRUE(near(P * P.transpose(), Q * Q.transpose(), 1e-7));
}

// A preference decides which columns stand for the others and not what is determined.
TEST(BaseParametersOf, OneArmSpanTheSameSpaceForAnyColumnOrder) {
  const Model arm = robot("elbow-6r");
  const SquareRootInformation factor = factor_of(arm);
  std::vector<int> preferred = preferred_columns(standard_parameters(arm));
  const BaseParameters a = base_parameters(factor, preferred);
  std::reverse(preferred.begin(), preferred.end());
  const BaseParameters b = base_parameters(factor, preferred);
  EXPECT_NE(a.independent, b.independent);
  const MatrixXd P = row_space(a.K, column_scale(arm));
  const MatrixXd Q = row_space(b.K, column_scale(arm));
  EXPECT_TRUE(near(P * P.transpose(), Q * Q.transpose(), 1e-6));
  // Masses come last: none of them stands for anything where it need not.
  for (const std::string& name : a.names) EXPECT_NE(name.rfind("m_", 0), 0U) << name;
}

TEST(BaseParametersOf, IndependentColumnsAreAllColumns) {
  SquareRootInformation f(std::vector<std::string>{"a", "b"});
  f.absorb((MatrixXd(3, 2) << 1, 2, 3, 4, 5, 7).finished(), Eigen::Vector3d::Zero());
  const BaseParameters base = base_parameters(f, {0, 1});
  EXPECT_EQ(base.size(), 2);
  EXPECT_EQ(base.rank_gap, std::numeric_limits<double>::infinity());
  EXPECT_TRUE(near(base.K, MatrixXd::Identity(2, 2), 0.0));
  EXPECT_EQ(base.classes,
            (std::vector<Identifiability>{Identifiability::kAlone, Identifiability::kAlone}));
}

// Three columns, the third 2 a - 0.5 b in other units: K says so in words.
TEST(BaseParametersOf, DependentColumnsAreExpressedByTheOthers) {
  Random random(4);
  MatrixXd A(30, 4);
  A.col(0) = random.vector(30, -1, 1);
  A.col(1) = 1e-4 * random.vector(30, -1, 1);
  A.col(2) = 2.0 * A.col(0) - 0.5 * A.col(1);
  A.col(3).setZero();
  SquareRootInformation f(std::vector<std::string>{"a", "b", "c", "d"});
  f.absorb(A, VectorXd::Zero(30));
  const BaseParameters base = base_parameters(f, {0, 1, 2, 3});
  ASSERT_EQ(base.size(), 2);
  EXPECT_EQ(base.expressions[0], "a + 2 c");
  EXPECT_EQ(base.expressions[1], "b - 0.5 c");
  EXPECT_EQ(base.classes[3], Identifiability::kNot);
}

TEST(BaseParametersOf, ZeroColumnsAreNone) {
  EXPECT_EQ(base_parameters(SquareRootInformation(std::vector<std::string>{}), {}).size(), 0);
  SquareRootInformation zero(std::vector<std::string>{"a", "b"});
  zero.absorb(MatrixXd::Zero(5, 2), VectorXd::Ones(5));
  const BaseParameters none = base_parameters(zero, {0, 1});
  EXPECT_EQ(none.size(), 0);
  EXPECT_EQ(none.rank_gap, 0.0);
  for (const Identifiability one : none.classes) EXPECT_EQ(one, Identifiability::kNot);
}

TEST(ARandomStateFactor, KeepsGivenJointsAtRest) {
  const Model arm = robot("planar-2r");
  const std::vector<StandardParameter> parameters = standard_parameters(arm);
  const VectorXd norms = random_state_factor(arm, 50, 1, {"elbow"}).column_norms();
  for (size_t j = 0; j < parameters.size(); ++j) {
    const double norm = norms[static_cast<Eigen::Index>(j)];
    if (!parameters[j].effect) continue;
    const bool of_elbow = parameters[j].name.find("(elbow)") != std::string::npos;
    EXPECT_EQ(norm == 0.0, of_elbow) << parameters[j].name;
  }
}

}  // namespace
}  // namespace veridyn
