#include "veridyn/files/model_json.hpp"

#include <gtest/gtest.h>

#include <unistd.h>

#include <algorithm>
#include <filesystem>

#include "support/near.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/simulation/joint_torques.hpp"
#include "veridyn/simulation/plausible_model.hpp"

namespace veridyn {
namespace {

class ModelJson : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Robots, ModelJson, testing::ValuesIn(robot_names()), [](const auto& robot) {
  std::string name = robot.param;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
});

// Facts with their arithmetic, and models with every value: what is read from JSON is what was written.
TEST_P(ModelJson, IsReadAsTheSameModel) {
  const std::string path = (std::filesystem::temp_directory_path() / ("veridyn-json-" + std::to_string(::getpid()) + ".json")).string();
  const Model facts = read_model(GetParam());
  for (const Model& arm : {facts, plausible_model(facts, 3).arm}) {
    save_model_json(arm, path);
    const Model back = read_model(path);
    ASSERT_EQ(back.joints(), arm.joints());
    for (int i = 0; i < arm.joints(); ++i) {
      const Coordinate &read = back.coordinates()[i], &written = arm.coordinates()[i];
      EXPECT_EQ(read.name, written.name);
      EXPECT_EQ(read.limits.lower, written.limits.lower) << written.name;
      EXPECT_EQ(read.limits.upper, written.limits.upper) << written.name;
      EXPECT_EQ(read.limits.effort, written.limits.effort) << written.name;
      EXPECT_EQ(read.drive_gain, written.drive_gain) << written.name;
    }
    ASSERT_EQ(back.effects().size(), arm.effects().size());
    ASSERT_EQ(back.inertial_values().has_value(), arm.inertial_values().has_value());
    if (!arm.inertial_values()) continue;
    const VectorXd q = VectorXd::LinSpaced(arm.joints(), -0.9, 0.8), dq = VectorXd::LinSpaced(arm.joints(), 0.7, -0.4);
    EXPECT_TRUE(near(joint_torques(back, q, dq, q), joint_torques(arm, q, dq, q), 1e-9));
  }
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace veridyn
