#include "veridyn/identification/rest_poses.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <memory>
#include <random>
#include <sstream>

#include "cli/tool.hpp"
#include "support/refusal.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/simulation/plausible_model.hpp"

// A resting arm whose gravity, offsets and dry friction are known.

namespace veridyn {
namespace {

const VectorXd kLevel = Eigen::Vector3d(0.4, 0.3, 1.5);     // of dry friction
const VectorXd kOffset = Eigen::Vector3d(0.2, -0.1, 0.8);

class Resting : public testing::Test {
 protected:
  Resting() : truth_(plausible_model(read_model("psm-3dof"), 3).arm) {}

  // Poses at random; the torque is that of gravity, of an offset and of friction on the side that the
  // joint came from.
  Recording poses(unsigned seed, int count, double noise = 0.01) const {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> share(-0.9, 0.9);
    std::normal_distribution<double> error(0.0, noise);
    RigidBodyDynamics bodies(truth_, *truth_.inertial_values());
    Recording out;
    out.source = "poses" + std::to_string(seed);
    out.poses = true;
    out.time = VectorXd::LinSpaced(count, 0.0, count - 1.0);
    out.q.resize(count, 3);
    out.tau.resize(count, 3);
    out.dq.resize(count, 3);
    VectorXd g(3);
    for (int k = 0; k < count; ++k) {
      const Eigen::Vector3d q(share(random), 0.6 * share(random), 0.12 + 0.06 * share(random));
      bodies.gravity_torques(q, g);
      out.q.row(k) = q.transpose();
      for (int i = 0; i < 3; ++i) {
        out.dq(k, i) = random() % 2 == 0 ? 1.0 : -1.0;
        out.tau(k, i) = g[i] + kOffset[i] + kLevel[i] * out.dq(k, i) + error(random);
      }
    }
    return out;
  }

  static Recording without_approach(Recording p) {
    p.dq.setZero();
    return p;
  }

  Model truth_;
};

double coulomb_of(const Model& arm, int joint) {
  for (const EffectTerm& term : arm.effects()) {
    if (term.effect == "coulomb_friction" && term.axis.coefficients[joint] != 0.0)
      return term.values.at("level");
  }
  return 0.0;
}

// Friction is as large as a joint's torque here, and is told from gravity by the sides of the approach.
TEST_F(Resting, KnownApproachesSeparateGravityAndDryFriction) {
  const Identification id = identify(read_model("psm-3dof"), {poses(1, 60), poses(2, 60)}, {poses(3, 40)});
  ASSERT_TRUE(id.model.has_value()) << id.reason;
  EXPECT_TRUE(id.feasible);
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(coulomb_of(*id.model, i), kLevel[i], 0.01);
    EXPECT_LT(id.test_error.relative[i], 0.04);
  }
  RigidBodyDynamics found(*id.model, *id.model->inertial_values());
  RigidBodyDynamics wanted(truth_, *truth_.inertial_values());
  VectorXd g(3);
  VectorXd expected(3);
  const VectorXd a = Eigen::Vector3d(0.1, 0.2, 0.1);
  const VectorXd b = Eigen::Vector3d(-0.5, -0.4, 0.15);
  found.gravity_torques(a, g);
  wanted.gravity_torques(a, expected);
  const VectorXd change = g;
  const VectorXd expected_change = expected;
  found.gravity_torques(b, g);
  wanted.gravity_torques(b, expected);
  EXPECT_LT((change - g - expected_change + expected).norm(), 0.02 * (expected_change - expected).norm() + 0.02);
}

// One pose, however long it was held, says nothing about gravity: the recording is no table of poses.
TEST_F(Resting, ARecordingOfOnePoseIsNotAtRest) {
  TemporaryFolder folder;
  const std::string header = "t,q1,q2,q3,dq1,dq2,dq3,tau1,tau2,tau3\n";
  const std::string here = ",0.1,0.2,0.1,0,0,0,1,2,3\n", there = ",0.1,0.3,0.1,0,0,0,1,2,3\n";
  EXPECT_FALSE(is_at_rest(truth_, folder.write("one.csv", header + "0" + here + "1" + here + "2" + here), {}));
  EXPECT_TRUE(is_at_rest(truth_, folder.write("two.csv", header + "0" + here + "1" + here + "2" + there), {}));
}

// A motion whose velocities were not recorded is none either, and is identified with derived ones.
TEST_F(Resting, AMotionRecordedWithZeroVelocitiesIsNotAtRest) {
  TemporaryFolder folder;
  Recording r = read_recording(folder.write("recorded.csv", planar_recording(12.0)));
  const Model arm = read_model("planar-2r");
  const Identification with_velocities = identify(arm, r, IdentificationOptions());
  r.dq.setZero();
  const std::string path = folder.path("zero.csv");
  write_recording(r, path);
  EXPECT_FALSE(is_at_rest(arm, path, {}));
  const Identification without = identify(arm, Recordings{path});
  ASSERT_TRUE(with_velocities.model && without.model) << without.reason;
  EXPECT_EQ(without.base.size(), with_velocities.base.size());
  EXPECT_LT((without.train_error.relative - with_velocities.train_error.relative).maxCoeff(), 0.01);
  ASSERT_FALSE(without.remarks.empty());
  EXPECT_NE(without.remarks.back().find("is no derivative of q2"), std::string::npos) << without.remarks.back();
}

// Without it, no level is made up: the band says how far friction spreads the torques.
TEST_F(Resting, WithoutApproachDirectionsNoFrictionLevelIsIdentified) {
  const Identification id = identify(read_model("psm-3dof"), {without_approach(poses(1, 200))});
  ASSERT_TRUE(id.model.has_value()) << id.reason;
  for (int i = 0; i < 3; ++i) EXPECT_EQ(coulomb_of(*id.model, i), 0.0);
  ASSERT_FALSE(id.remarks.empty());
  EXPECT_NE(id.remarks.back().find("Dry friction holds"), std::string::npos);
}

// The links of a SCARA that turn about the vertical have no weight in any torque: the solver leaves them near the solid
// spheres that it begins with, whose moments of inertia are two fifths of mass times squared radius.
TEST(RestingScara, UnobservedInertiasStayNearThoseOfTheInitialSpheres) {
  const Model truth = read_model("scara");
  ModelDescription unknown = truth.description();
  for (Frame& frame : unknown.frames)
    if (frame.body) frame.body = Body{};
  RigidBodyDynamics bodies(truth, *truth.inertial_values());
  std::mt19937 random(4);
  std::uniform_real_distribution<double> share(0.1, 0.9);
  std::normal_distribution<double> error(0.0, 0.01);
  Recording poses;
  poses.source = "poses";
  poses.poses = true;
  poses.time = VectorXd::LinSpaced(40, 0.0, 39.0);
  poses.q = poses.tau = MatrixXd(40, 4);
  poses.dq = MatrixXd::Zero(40, 4);
  VectorXd g(4);
  for (int k = 0; k < 40; ++k) {
    for (int i = 0; i < 4; ++i) {
      const Limits& limits = truth.coordinates()[i].limits;
      poses.q(k, i) = limits.lower + share(random) * (limits.upper - limits.lower);
    }
    bodies.gravity_torques(poses.q.row(k).transpose(), g);
    for (int i = 0; i < 4; ++i) poses.tau(k, i) = g[i] + error(random);
  }
  const Identification id = identify(Model(std::move(unknown)), {poses});
  ASSERT_TRUE(id.model.has_value()) << id.reason;
  for (const char* name : {"inner", "outer"}) {
    for (const Frame& frame : id.model->frames()) {
      if (frame.name != name) continue;
      const InertialParameters& phi = *frame.body->phi;
      const double ball = 0.4 * phi[0] * std::pow(0.1, 2);
      EXPECT_NEAR(phi[0], 1.0, 0.01) << name;
      EXPECT_NEAR((phi[4] + phi[7] + phi[9]) / 3.0, ball, 0.5 * ball) << name;
    }
  }
}

// One joint stands still in all poses: the others tell less, and an answer is there.
TEST_F(Resting, AStationaryJointIsAccepted) {
  Recording p = poses(1, 80);
  RigidBodyDynamics bodies(truth_, *truth_.inertial_values());
  VectorXd g(3);
  for (Eigen::Index k = 0; k < p.q.rows(); ++k) {
    p.q(k, 0) = 0.3;
    bodies.gravity_torques(p.q.row(k).transpose(), g);
    p.tau.row(k) = (g + kOffset).transpose().array() + 0.01 * std::sin(7.0 * static_cast<double>(k));
  }
  p.dq.setZero();
  const Identification some = identify(read_model("psm-3dof"), {p});
  const Identification all = identify(read_model("psm-3dof"), {without_approach(poses(1, 80))});
  ASSERT_TRUE(some.model && all.model);
  EXPECT_LE(some.base.size(), all.base.size());
  EXPECT_LT(some.train_error.relative.maxCoeff(), 0.1);
}

// A file without time, its approach in columns of signs; and moments of rest within a motion.
TEST_F(Resting, PosesAreReadFromTablesAndFromRestsInAMotion) {
  TemporaryFolder folder;
  const std::string rows = folder.path("rows.csv");
  std::ofstream(rows) << "q1,q2,q3,dq1,dq2,dq3,tau1,tau2,tau3\n0.1,0.2,0.1,1,-1,0,1,2,3\n0.3,0.2,0.1,-1,0,1,4,5,6\n";
  const Recording two = read_rest_poses(truth_, rows, {});
  ASSERT_EQ(two.q.rows(), 2);
  EXPECT_EQ(two.dq.row(0), Eigen::RowVector3d(1, -1, 0));
  EXPECT_EQ(two.tau.row(1), Eigen::RowVector3d(4, 5, 6));
  EXPECT_EQ(read_rest_poses(truth_, rows, {}, -1.0).dq, Eigen::MatrixXd::Constant(2, 3, -1.0));

  const std::string motion = folder.path("motion.csv");
  std::ofstream file(motion);
  file << "t,q1,q2,q3,dq1,dq2,dq3,tau1,tau2,tau3\n";
  for (int k = 0; k < 60; ++k) {
    const double speed = k < 20 ? 0.0 : k < 30 ? 0.5 : k < 45 ? 0.0 : k < 50 ? -0.4 : 0.0;
    file << 0.01 * k << ",0.1,0.2,0.1," << speed << ",0,0," << (k < 20 ? 1 : 2) << ",0,0\n";
  }
  file.close();
  const Recording three = read_rest_poses(truth_, motion, {});
  ASSERT_EQ(three.q.rows(), 3);
  EXPECT_EQ(three.dq.col(0), Eigen::Vector3d(0, 1, -1));
  EXPECT_EQ(three.tau.col(0), Eigen::Vector3d(1, 2, 2));
  EXPECT_FALSE(is_at_rest(truth_, motion, {}));

  // Rows with gaps are left out with their velocities.
  std::istringstream lines(content_of(motion));
  std::string text, line;
  std::getline(lines, text);
  text += "\n";
  for (int k = 0; k < 10; ++k) text += std::to_string(0.01 * k - 1.0) + ",0.1,0.2,0.1,-0.5,0,0,nan,0,0\n";
  while (std::getline(lines, line)) text += line + "\n";
  const Recording again = read_rest_poses(truth_, folder.write("gaps.csv", text), {});
  EXPECT_EQ(again.dq, three.dq);
  EXPECT_EQ(again.tau, three.tau);
}

// Rests at two positions are two poses though no row shows the motion between them: its rows were left out
// (no torques), or its velocities are missing. From which side the second one was reached nobody knows.
TEST_F(Resting, RestsAtTwoPositionsAreTwoPoses) {
  TemporaryFolder folder;
  const auto read = [&](const std::string& between) {
    std::string text = "t,q1,q2,q3,dq1,dq2,dq3,tau1,tau2,tau3\n";
    const auto add = [&](int from, int count, const std::string& row) {
      for (int k = from; k < from + count; ++k) text += std::to_string(0.01 * k) + row + "\n";
    };
    add(0, 3, ",0.0,0.2,0.1,0.5,0,0,1,0,0");
    add(3, 10, ",0.1,0.2,0.1,0.001,0,0,1,0,0");
    if (!between.empty()) add(13, 10, between);
    add(23, 10, ",0.5,0.2,0.1,0.001,0,0,2,0,0");
    return read_rest_poses(truth_, folder.write("rests.csv", text), {});
  };
  for (const char* between : {"", ",0.3,0.2,0.1,1,0,0,nan,0,0"}) {
    const Recording two = read(between);
    ASSERT_EQ(two.q.rows(), 2) << between;
    EXPECT_EQ(two.q.col(0), Eigen::Vector2d(0.1, 0.5));
    EXPECT_EQ(two.tau.col(0), Eigen::Vector2d(1, 2));
    EXPECT_EQ(two.dq.col(0), Eigen::Vector2d(1, 0));
  }
  const Recording still = read(",0.3,0.2,0.1,nan,0,0,3,0,0");
  ASSERT_EQ(still.q.rows(), 2);
  EXPECT_EQ(still.tau.col(0), Eigen::Vector2d(1, 2));
}

// Without velocities every row is a pose, as where all are zero, and currents are torques by the drive gains; rows
// with gaps are none.
TEST_F(Resting, EveryCompleteRowWithoutVelocitiesIsAPose) {
  Recording r;
  r.source = "table";
  r.time = VectorXd::LinSpaced(4, 0.0, 3.0);
  r.q = r.tau = MatrixXd::Ones(4, 3);
  r.q.col(0) = Eigen::Vector4d(0.1, 0.2, 0.3, std::nan(""));
  r.tau.col(1) = Eigen::Vector4d(4.0, 5.0, 6.0, 7.0);
  const auto read = [](const Model& arm, const Recording& table) {
    PreprocessingOptions how;
    how.in_memory["table"] = std::make_shared<const Recording>(table);
    return read_rest_poses(arm, "table", how);
  };
  const Recording bare = read(truth_, r);
  ASSERT_EQ(bare.q.rows(), 3);
  EXPECT_EQ(bare.tau.col(1), Eigen::Vector3d(4.0, 5.0, 6.0));
  EXPECT_TRUE(bare.dq.isZero(0.0));
  Recording zero = r;
  zero.dq = MatrixXd::Zero(4, 3);
  EXPECT_EQ(read(truth_, zero).tau, bare.tau);
  Recording currents = r;
  currents.current = 0.5 * r.tau;
  currents.tau.resize(0, 0);
  EXPECT_TRUE(refuses_with("no drive_gain", [&] { read(truth_, currents); }));
  ModelDescription d = truth_.description();
  for (Coordinate& c : d.coordinates) c.drive_gain = 2.0;
  Eigen::Index pose = 0;
  for_each_segment(Model(d), read(Model(d), currents), {}, [&](const Segment& s) { EXPECT_EQ(s.tau, bare.tau.row(pose++)); });
  EXPECT_EQ(pose, 3);
  currents.current.resize(0, 0);
  EXPECT_TRUE(refuses_with("neither torques", [&] { read(Model(d), currents); }));
  r.q.col(1).setConstant(std::nan(""));
  EXPECT_TRUE(refuses_with("no row with finite positions", [&] { read(truth_, r); }));
}

// An arm whose bodies and offsets are facts leaves nothing to identify at rest.
TEST_F(Resting, AnArmWithOnlyFixedParametersIsRefused) {
  ModelDescription d = with_fixed_parameters(truth_).description();
  d.effects.clear();
  for (int j = 0; j < 3; ++j) {
    EffectTerm offset;
    offset.effect = "torque_offset";
    offset.axis.coefficients = VectorXd::Unit(3, j);
    offset.values["offset"] = kOffset[j];
    offset.fixed = true;
    d.effects.push_back(offset);
  }
  const Identification id = identify(Model(d), {without_approach(poses(1, 30))});
  EXPECT_FALSE(id.model.has_value());
  EXPECT_EQ(id.reason, "the poses determine no parameter");
}

TEST_F(Resting, MotionsAreRefusedAsPoses) {
  const Model file = read_model("psm-3dof");
  const Recording good = poses(1, 30);
  Recording none = good;
  none.time.resize(0);
  none.q.resize(0, 3);
  none.tau = none.dq = none.q;
  Recording gap = good;
  gap.tau(7, 1) = std::nan("");
  EXPECT_TRUE(refuses_with("found one without rows", [&] { identify(file, {none}); }));
  EXPECT_TRUE(refuses_with("found one without rows", [&] { identify(file, {good}, {none}); }));
  EXPECT_TRUE(refuses_with("not finite", [&] { identify(file, {gap}); }));
  Recording two = good;
  two.q = good.q.leftCols(2);
  EXPECT_TRUE(refuses_with("poses of 2 joints", [&] { identify(file, {two}); }));
  EXPECT_TRUE(refuses_with("no recording to train on", [&] { identify(file, Recordings{}); }));
  for (const Method method : {Method::kIv, Method::kDidim}) {
    IdentificationOptions options;
    options.method = method;
    EXPECT_TRUE(refuses_with("instruments", [&] { identify(file, {good}, {}, options); }));
  }
}

TEST_F(Resting, ACommandIdentifiesAModelForDvrkGravityCompensation) {
  TemporaryFolder folder;
  const Recording p = without_approach(poses(5, 60));
  const std::string path = folder.path("rest.csv");
  std::ofstream file(path);
  file << "t,q1,q2,q3,dq1,dq2,dq3,tau1,tau2,tau3\n";
  for (Eigen::Index k = 0; k < p.q.rows(); ++k) {
    file << k;
    for (int i = 0; i < 3; ++i) file << "," << p.q(k, i);
    file << ",0,0,0";
    for (int i = 0; i < 3; ++i) file << "," << p.tau(k, i);
    file << "\n";
  }
  file.close();
  EXPECT_TRUE(is_at_rest(truth_, path, {}));
  const std::string model = folder.path("model.yaml");
  ToolRun run = run_tool({"identify", "psm-3dof", "--train", path, "--model-out", model});
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_NE(run.out.find("poses at rest"), std::string::npos) << run.out;
  run = run_tool({"export", model, "--dvrk-gravity", folder.path("gravity.json")});
  EXPECT_EQ(run.status, 0) << run.err;
  run = run_tool({"identify", "psm-3dof", "--train", path, "--approach", "1,-1"});
  EXPECT_EQ(run.status, 2);
  EXPECT_NE(run.err.find("--approach: found 2 numbers"), std::string::npos) << run.err;
}

}  // namespace
}  // namespace veridyn
