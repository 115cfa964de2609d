#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sdf/sdf.hh>
#include <unistd.h>

#include "support/near.hpp"
#include "support/stranger_files.hpp"
#include "veridyn/files/sdf.hpp"
#include "veridyn/kinematics/kinematics.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/simulation/plausible_model.hpp"

// libsdformat, which nobody here wrote, resolves the same poses and bodies from the same file.

namespace veridyn {
namespace {

Eigen::Isometry3d eigen_pose(const ignition::math::Pose3d& pose) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() = Eigen::Vector3d(pose.Pos().X(), pose.Pos().Y(), pose.Pos().Z());
  T.linear() = Eigen::Quaterniond(pose.Rot().W(), pose.Rot().X(), pose.Rot().Y(), pose.Rot().Z()).toRotationMatrix();
  return T;
}

// All links at zero, relative to the world, and their bodies.
void expect_as_libsdformat(const Model& arm, const sdf::Model& model) {
  ignition::math::Pose3d raw;
  ASSERT_TRUE(model.SemanticPose().Resolve(raw).empty());
  const Eigen::Isometry3d T_world_model = eigen_pose(raw);
  const VectorXd zero = VectorXd::Zero(arm.joints());
  int bodies = 0;
  for (std::uint64_t k = 0; k < model.LinkCount(); ++k) {
    const sdf::Link& link = *model.LinkByIndex(k);
    std::optional<FrameIndex> frame = arm.find_frame(link.Name());
    if (!frame) frame = arm.find_frame(link.Name().substr(0, link.Name().rfind("_link")));  // see to_sdf()
    if (!frame) {  // a link between two joints of one frame
      EXPECT_LT(link.Inertial().MassMatrix().Mass(), 1e-8) << link.Name();
      continue;
    }
    ignition::math::Pose3d pose;
    ASSERT_TRUE(link.SemanticPose().Resolve(pose, "__model__").empty());
    EXPECT_TRUE(near(frame_pose(arm, zero, *frame).matrix(), (T_world_model * eigen_pose(pose)).matrix(), 1e-12)) << link.Name();
    const auto& body = arm.frames()[frame->value].body;
    if (!body) {
      EXPECT_LT(link.Inertial().MassMatrix().Mass(), 1e-8) << link.Name();
      continue;
    }
    ++bodies;
    const auto I = link.Inertial().Moi();  // about the centre of mass, in the link's axes
    const auto c = link.Inertial().Pose().Pos();
    Eigen::Matrix<double, 6, 1> inertia;
    inertia << I(0, 0), I(0, 1), I(1, 1), I(0, 2), I(1, 2), I(2, 2);
    const InertialParameters phi =
        inertial_parameters(link.Inertial().MassMatrix().Mass(), {c.X(), c.Y(), c.Z()}, inertia);
    EXPECT_TRUE(near(*body->phi, phi, 1e-12 * (1.0 + phi.cwiseAbs().maxCoeff()))) << link.Name();
  }
  EXPECT_GT(bodies, 0);
  for (std::uint64_t k = 0; k < model.JointCount(); ++k) {
    const sdf::Joint& joint = *model.JointByIndex(k);
    const std::optional<JointIndex> i = arm.find_coordinate(joint.Name());
    if (!i) {
      EXPECT_EQ(joint.Type(), sdf::JointType::FIXED) << joint.Name();
      continue;
    }
    ignition::math::Vector3d axis;
    ASSERT_TRUE(joint.Axis(0)->ResolveXyz(axis, "__model__").empty());
    VectorXd q = zero;
    q[i->value] = 0.3;
    FrameIndex moved;  // the first frame that the coordinate moves
    while (!arm.moves(moved, *i)) ++moved.value;
    const Eigen::Isometry3d T = frame_pose(arm, zero, moved);
    const Eigen::Isometry3d U = frame_pose(arm, q, moved);
    const Eigen::Vector3d u = T_world_model.linear() * Eigen::Vector3d(axis.X(), axis.Y(), axis.Z());
    if (arm.coordinates()[i->value].prismatic) {
      EXPECT_TRUE(near(Eigen::Vector3d(U.translation() - T.translation()), 0.3 * u, 1e-12)) << joint.Name();
    } else {
      EXPECT_TRUE(near(Eigen::Matrix3d(U.linear()), Eigen::AngleAxisd(0.3, u) * T.linear(), 1e-12)) << joint.Name();
      ignition::math::Pose3d at;  // a point on the line stays where it is
      ASSERT_TRUE(joint.SemanticPose().Resolve(at, "__model__").empty());
      const Eigen::Vector3d point = (T_world_model * eigen_pose(at)).translation();
      EXPECT_TRUE(near(Eigen::Vector3d(U * (T.inverse() * point)), point, 1e-12)) << joint.Name();
    }
  }
}

std::string written(const std::string& content) {
  const std::string path = testing::TempDir() + "veridyn_sdformat_" +
                           std::to_string(getpid()) + ".sdf";
  std::ofstream(path) << content;
  return path;
}

TEST(Sdformat, AForeignFileIsReadAsByLibsdformat) {
  const std::string path = written(kStrangerSdf);
  sdf::Root root;
  const sdf::Errors errors = root.Load(path);
  ASSERT_TRUE(errors.empty()) << errors.front().Message();
  const sdf::Model* model = root.WorldByIndex(0)->ModelByName("stranger");
  ASSERT_NE(model, nullptr);
  expect_as_libsdformat(read_model(path), *model);
  std::filesystem::remove(path);
}

class SdformatOnRobots : public testing::TestWithParam<std::string> {};

TEST_P(SdformatOnRobots, LoadsTheExportedFile) {
  const Model arm = plausible_model(read_model(GetParam()), 3).arm;
  const std::string path = written(to_sdf(arm));
  sdf::Root root;
  const sdf::Errors errors = root.Load(path);
  ASSERT_TRUE(errors.empty()) << errors.front().Message();
  ASSERT_NE(root.Model(), nullptr);
  expect_as_libsdformat(arm, *root.Model());
  std::filesystem::remove(path);
}

// Arms without couplings: libsdformat 12 knows no mimic.
INSTANTIATE_TEST_SUITE_P(Robots, SdformatOnRobots, testing::Values("planar-2r", "ur10e", "kuka-lwr4", "scara", "elbow-6r"),
                         [](const auto& robot) {
                           std::string name = robot.param;
                           for (char& c : name) c = std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
                           return name;
                         });

}  // namespace
}  // namespace veridyn
