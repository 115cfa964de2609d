#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <string>

#include "support/near.hpp"
#include "veridyn/effects/effect.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/simulation/plausible_model.hpp"
#include "veridyn/veridyn.hpp"

// Objects own what they need: one that was made from a temporary Model does what one does whose
// Model lives.

namespace veridyn {
namespace {

Model arm() {
  ModelDescription description = plausible_model(read_model("psm-3dof"), 3).arm.description();
  EffectTerm friction = description.effects.front();
  friction.effect = "coulomb_friction";
  friction.values = {{"level", 0.3}};
  description.effects = {friction};
  return Model(std::move(description));
}

// Memory that was given back is written over.
void overwrite_free_memory() {
  for (size_t size = 16; size < 20000; size += 16) {
    const std::string rubbish(size, '\x7f');
    const std::vector<double> numbers(size / 8, 1e30);
    ASSERT_EQ(rubbish.size() / 8, numbers.size());
  }
}

template <typename Make, typename Use>
void expect_no_difference(const char* what, Make make, Use use) {
  const Model living = arm();
  auto from_living = make(living);
  auto from_temporary = make(arm());
  overwrite_free_memory();
  const VectorXd expected = use(from_living);
  EXPECT_TRUE(near(VectorXd(use(from_temporary)), expected, 0.0)) << what;
  EXPECT_GT(expected.norm(), 0.0) << what;
}

const VectorXd kQ = Eigen::Vector3d(0.3, -0.2, 0.11);
const VectorXd kDq = Eigen::Vector3d(0.4, 0.5, -0.1);
const VectorXd kDdq = Eigen::Vector3d(1.0, -2.0, 0.5);

TEST(ATemporaryModel, MayBeDestroyedBeforeItsDynamics) {
  expect_no_difference(
      "RigidBodyDynamics",
      [](const Model& m) { return RigidBodyDynamics(m, *m.inertial_values()); },
      [](RigidBodyDynamics& d) {
        VectorXd tau(3);
        d.inverse_dynamics(kQ, kDq, kDdq, tau);
        return tau;
      });
  expect_no_difference(
      "TorqueRegressor", [](const Model& m) { return TorqueRegressor(m); },
      [](TorqueRegressor& r) {
        MatrixXd Y(3, 10 * static_cast<int>(arm().inertial_values()->size() / 10));
        r.evaluate(kQ, kDq, kDdq, Y);
        return VectorXd(Y.reshaped());
      });
  expect_no_difference(
      "TorqueRegressor", [](const Model& m) { return TorqueRegressor(m); },
      [](TorqueRegressor& r) {
        std::vector<MatrixXd> Y;
        r.evaluate(kQ.transpose(), kDq.transpose(), kDdq.transpose(), Y);
        return VectorXd(Y[1].reshaped());
      });
}

TEST(ATemporaryModel, MayBeDestroyedBeforeItsControllers) {
  expect_no_difference(
      "GravityCompensation", [](const Model& m) { return GravityCompensation(m); },
      [](GravityCompensation& g) { return g.update(kQ); });
  expect_no_difference(
      "ArmState", [](const Model& m) { return ArmState(m, {"tool"}); },
      [](ArmState& s) {
        s.update(kQ, kDq);
        return s.bias();
      });
  expect_no_difference(
      "FrictionCompensation", [](const Model& m) { return FrictionCompensation(m); },
      [](FrictionCompensation& f) {
        ArmState state(arm(), {"tool"});
        state.update(kQ, kDq);
        return f.update(state, kDq, VectorXd::Zero(3), 1e-3);
      });
  expect_no_difference(
      "MomentumObserver", [](const Model& m) { return MomentumObserver(m, {"tool"}); },
      [](MomentumObserver& o) {
        ArmState state(arm(), {"tool"});
        for (int k = 0; k < 3; ++k) {
          state.update(kQ, kDq);
          o.update(state, kDdq, kDdq, 1e-3);
        }
        return VectorXd(o.threshold());
      });
}

TEST(ATemporaryModel, MayBeDestroyedBeforeItsPlantAndEffects) {
  expect_no_difference(
      "Plant", [](const Model& m) { return Plant(m); },
      [](Plant& p) {
        p.set_state(kQ, kDq);
        for (int k = 0; k < 5; ++k) p.step(kDdq, 1e-3);
        return p.q();
      });
  expect_no_difference(
      "BoundEffect", [](const Model& m) { return BoundEffect(m, m.effects().front()); },
      [](BoundEffect& e) {
        return VectorXd::Constant(1, e.values()[0] + static_cast<double>(e.parameter_name(0).size()));
      });
}

// The same without running anything: no member of a public class is a reference to a Model.
TEST(ATemporaryModel, IsReferredToByNoMemberOfAPublicClass) {
  static const std::regex kMember(R"(const Model\s*[&*]\s*\w+_\s*(=[^;]*)?;)");
  int files = 0;
  const std::filesystem::path root = VERIDYN_SOURCE_DIR "/include/veridyn";
  for (const auto& entry : std::filesystem::recursive_directory_iterator(root)) {
    if (entry.path().extension() != ".hpp") continue;
    ++files;
    std::ifstream stream(entry.path());
    std::string line;
    for (int number = 1; std::getline(stream, line); ++number) {
      EXPECT_FALSE(std::regex_search(line, kMember))
          << entry.path() << ":" << number << ": a temporary Model would dangle";
    }
  }
  EXPECT_GT(files, 100);
}

}  // namespace
}  // namespace veridyn
