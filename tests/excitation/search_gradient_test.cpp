// What a solver sees: every criterion and every limit, by the coordinates of a search.

#include <gtest/gtest.h>

#include <cmath>

#include "excitation/search/motion_objective.hpp"
#include "excitation/search/question.hpp"
#include "excitation/search/search_program.hpp"
#include "support/sample_arms.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/simulation/plausible_model.hpp"

namespace veridyn {
namespace {

constexpr double kFrequency = 0.2;
constexpr int kHarmonics = 3;
constexpr int kInstants = 48;
constexpr double kSeconds = 10.0;

// Fourth order in the step. Large steps cross kinks (a load that changes its sign), small ones see
// rounding errors of ill-conditioned matrices: the one nearest to `expected` of three counts.
template <typename Function>
double central_difference(const Function& f, VectorXd x, Eigen::Index k, double expected) {
  const double at = x[k];
  double nearest = INFINITY;
  for (const double h : {4e-4, 2e-4, 1e-4}) {
    const auto value = [&](double step) {
      x[k] = at + step;
      return f(x);
    };
    const double slope =
        (8.0 * (value(h) - value(-h)) - (value(2.0 * h) - value(-2.0 * h))) / (12.0 * h);
    if (!(std::abs(nearest - expected) < std::abs(slope - expected))) nearest = slope;
  }
  return nearest;
}

struct Search {
  explicit Search(const Model& model)
      : arm(model),
        space(motion_limits(arm), kHarmonics, kFrequency),
        exact(arm),
        rounded(arm, kRounding) {
    RandomNumbers random(4);
    start = space.random(random);
  }
  Question question(const ExcitationOptions& options) const {
    return make_question(arm, exact, rounded, options, kSeconds);
  }

  Model arm;
  MotionSpace space;
  BaseRegressor exact, rounded;
  VectorXd start;
};

void expect_exact(const Search& s, const ExcitationOptions& options, double sharpness) {
  const Question question = s.question(options);
  const MotionObjective objective = question.objective(s.space, sharpness, kInstants);
  const VectorXd slope = objective.gradient(s.start);
  const double size = slope.cwiseAbs().maxCoeff();
  ASSERT_GT(size, 1e-6);
  const auto value = [&](const VectorXd& x) { return objective.value(x); };
  for (Eigen::Index k = 0; k < s.start.size(); ++k)
    EXPECT_NEAR(slope[k], central_difference(value, s.start, k, slope[k]), 1e-6 * size) << k;
}

MotionSamples recorded(const Search& s) {
  RandomNumbers random(9);
  return s.space.trajectory(s.space.random(random)).motion(1, 20.0);
}

class SearchGradient : public testing::TestWithParam<bool> {};

TEST_P(SearchGradient, OfTheConditionNumberMatchesCentralDifferences) {
  const Search s(read_model("psm-3dof"));
  ExcitationOptions options;
  if (GetParam()) options.given = {recorded(s)};
  options.criterion = ExcitationCriterion::kCondition;
  for (const auto scaling :
       {ColumnScaling::kNorm, ColumnScaling::kNone, ColumnScaling::kOrthogonal}) {
    options.scaling = scaling;
    expect_exact(s, options, 2.0);
    expect_exact(s, options, 16.0);
  }
}

TEST_P(SearchGradient, OfTheConfidenceEllipsoidMatchesCentralDifferences) {
  const Search s(read_model("scara"));
  ExcitationOptions options;
  if (GetParam()) options.given = {recorded(s)};
  options.criterion = ExcitationCriterion::kDOptimal;
  expect_exact(s, options, 0.0);
}

TEST_P(SearchGradient, OfTheRelativeDeviationsMatchesCentralDifferences) {
  for (const char* name : {"scara", "psm-3dof"}) {
    const Search s(read_model(name));
    ExcitationOptions options;
    if (GetParam()) options.given = {recorded(s)};
    options.criterion = ExcitationCriterion::kAOptimal;
    options.valued = plausible_model(s.arm, 1).arm;
    options.noise = TorqueNoise();
    options.noise->deviation = VectorXd::LinSpaced(s.arm.joints(), 0.02, 0.07);
    expect_exact(s, options, 0.0);
  }
}

// The criterion is what the prediction says, up to a factor that is the same for all motions; only
// what is nearly nothing is taken relative to more than itself.
TEST_P(SearchGradient, TheCriterionEqualsThePredictedDeviations) {
  const Search s(plausible_model(read_model("psm-3dof"), 2).arm);
  ExcitationOptions options;
  if (GetParam()) options.given = {recorded(s)};
  options.criterion = ExcitationCriterion::kAOptimal;
  const Question question = s.question(options);
  RandomNumbers random(6);
  const auto difference = [&] {
    const MotionSamples motion = s.space.trajectory(s.space.random(random)).motion(2, 100.0);
    const Prediction p =
        predict_identification(s.arm, motion, usual_noise(s.arm), options.given);
    double sum = 0.0;
    int floored = 0;
    for (size_t b = 0; b < p.parameters.size(); ++b) {
      const double size = question.sizes[static_cast<Eigen::Index>(b)];
      const double value = std::abs(p.parameters[b].value);
      sum += p.parameters[b].deviation / size;
      EXPECT_GE(size, value * (1.0 - 1e-12));
      if (size > value * (1.0 + 1e-12)) ++floored;
    }
    EXPECT_LE(floored, 2);
    return std::log(sum / static_cast<double>(p.parameters.size())) - question.cost(motion);
  };
  const double first = difference();
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(difference(), first, 1e-6);
}

TEST_P(SearchGradient, OfTheDiscriminationMatchesCentralDifferences) {
  const Search s(read_model("psm-3dof"));
  ExcitationOptions options;
  options.criterion = ExcitationCriterion::kDiscriminate;
  options.powered = plausible_model(s.arm, 1).arm;
  if (GetParam()) options.given = {recorded(s)};
  for (const auto& [first, second] :
       {std::pair("payload:tool", "torque_gain:2"), {"joint_spring:2", "gravity_tilt"},
        {"position_dependent_friction:1", "load_dependent_friction:1"},
        {"presliding_hysteresis:1", "stribeck_friction:1"}, {"torque_ripple:1", "inertia:tool"}}) {
    options.between = {parse_cause(s.arm, first), parse_cause(s.arm, second)};
    SCOPED_TRACE(std::string(first) + " " + second);
    expect_exact(s, options, 0.0);
  }
}

INSTANTIATE_TEST_SUITE_P(GivenRecordings, SearchGradient, testing::Bool(),
                         [](const auto& which) { return which.param ? "count" : "none"; });

TEST(SearchJacobian, OfEveryKindOfLimitAgreesWithCentralDifferences) {
  const Search s(read_model("psm-3dof"));
  ModelDescription strong = plausible_model(s.arm, 1).arm.description();
  for (Coordinate& c : strong.coordinates) c.limits.effort = 20.0;
  WorkspaceLimits workspace;
  workspace.boxes = {{"tool", {-0.3, -0.3, -0.3}, {0.3, 0.3, 0.3}}};
  workspace.pairs = {{{"tool", 0.02, {0.0, 0.0, 0.01}}, {"world", 0.05, {0.1, 0.2, -0.1}}, 0.01},
                     {{"tool", 0.02, {}}, {"upper", 0.03, {0.01, 0.0, 0.0}}, 0.0}};
  workspace.insertions = {{"tool", {0.01, 0.02, 0.0}, 0.0, 0.3}};
  const LimitSignals signals(s.arm, motion_limits(s.arm), workspace, Model(std::move(strong)), 30.0);
  EXPECT_EQ(signals.count(), 9 + 3 + 3 + 3 + 2 + 1);
  const int instants = 7;
  const GridConstraints limits(s.space, signals, instants);
  const VectorXd entries = limits.jacobian(s.start);
  MatrixXd J = MatrixXd::Zero(limits.lower().size(), s.start.size());
  for (size_t k = 0; k < limits.pattern().size(); ++k)
    J(limits.pattern()[k].first, limits.pattern()[k].second) =
        entries[static_cast<Eigen::Index>(k)];
  const double size = J.cwiseAbs().maxCoeff();
  for (Eigen::Index row = 0; row < J.rows(); ++row) {
    const auto value = [&](const VectorXd& x) { return limits.values(x)[row]; };
    for (Eigen::Index k = 0; k < s.start.size(); k += 2)
      ASSERT_NEAR(J(row, k), central_difference(value, s.start, k, J(row, k)), 1e-6 * size)
          << "row " << row << ", coordinate " << k;
  }
}

// A rival that can do all that the other one does: what the other one leaves is asked only.
TEST(Discrimination, GradientForNestedCausesMatchesCentralDifferences) {
  const Search s(read_model("planar-2r"));
  ExcitationOptions options;
  options.criterion = ExcitationCriterion::kDiscriminate;
  options.powered = plausible_model(s.arm, 1).arm;
  // A load on the second link may be a point on its axis, which is inertia about the first.
  options.between = {NewEffect{"rotor_inertia", {0}},
                     AddedLoad{{static_cast<int>(s.arm.frames().size()) - 1}}};
  const Question question = s.question(options);
  EXPECT_TRUE(question.bodies_known);
  EXPECT_GT(question.rivals.second.norm(), 0.0);
  expect_exact(s, options, 0.0);
}

}  // namespace
}  // namespace veridyn
