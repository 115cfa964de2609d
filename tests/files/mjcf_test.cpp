#include "veridyn/files/mjcf.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>

#include "support/mujoco_model.hpp"
#include "support/near.hpp"
#include "support/stranger_files.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"
#include "veridyn/effects/effect.hpp"
#include "veridyn/kinematics/kinematics.hpp"
#include "files/output_file.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/simulation/joint_torques.hpp"
#include "veridyn/simulation/plausible_model.hpp"

// MuJoCo, which nobody here wrote, reads the exported file and computes the same torques.

namespace veridyn {
namespace {

constexpr double kRelative = 1e-9;

class Exported : public MujocoModel {
 public:
  explicit Exported(const Model& arm) : MujocoModel(to_mjcf(arm)) {
    S = MatrixXd::Zero(model->nv, arm.joints());
    for (int i = 0; i < arm.joints(); ++i) S(dof_of(arm.coordinates()[i].name), i) = 1.0;
    for (int e = 0; e < model->neq; ++e) take_coupling(model->eq_obj1id[e]);
  }

  int dof_of(const std::string& name) const {
    const int joint = mj_name2id(model.get(), mjOBJ_JOINT, name.c_str());
    require(joint >= 0, "no joint is called ", name);
    return model->jnt_dofadr[joint];
  }

  // What a joint is where a tendon keeps it: the joints of coordinates come after it.
  void take_coupling(int tendon) {
    const int first = model->tendon_adr[tendon];
    const int own = model->jnt_dofadr[model->wrap_objid[first]];
    ASSERT_EQ(model->wrap_prm[first], 1.0);
    for (int w = first + 1; w < first + model->tendon_num[tendon]; ++w) {
      const int other = model->jnt_dofadr[model->wrap_objid[w]];
      S.row(own) -= model->wrap_prm[w] * S.row(other);
    }
  }

  // Along the couplings, without the constraints that hold them; what the motors must add to what
  // they do without a control.
  VectorXd inverse_dynamics(const VectorXd& q, const VectorXd& dq, const VectorXd& ddq) {
    model->opt.disableflags |= mjDSBL_CONSTRAINT;
    VectorXd::Map(data->qpos, model->nq) = S * q;
    VectorXd::Map(data->qvel, model->nv) = S * dq;
    VectorXd::Map(data->qacc, model->nv) = S * ddq;
    mj_inverse(model.get(), data.get());
    mj_fwdActuation(model.get(), data.get());
    model->opt.disableflags &= ~mjDSBL_CONSTRAINT;
    return S.transpose() * (VectorXd::Map(data->qfrc_inverse, model->nv) -
                            VectorXd::Map(data->qfrc_actuator, model->nv));
  }

  MatrixXd S;  // joints of MuJoCo per coordinate
};

// Without what MuJoCo makes a constraint (dry friction) or has no word for. Constants stay.
Model smooth(const Model& arm) {
  ModelDescription d = arm.description();
  std::vector<EffectTerm> kept;
  for (const EffectTerm& term : d.effects) {
    const BoundEffect effect(arm, term);
    const EffectTraits traits = effect.effect().traits(effect.shape());
    if (traits.affine && !traits.depends_on_time) kept.push_back(term);
  }
  d.effects = kept;
  return Model(std::move(d));
}

class Mjcf : public testing::TestWithParam<std::string> {};

TEST_P(Mjcf, HasTheTorquesOfTheArm) {
  const Model arm = smooth(plausible_model(read_model(GetParam()), 3).arm);
  Exported exported(arm);
  std::srand(5);
  for (int k = 0; k < 20; ++k) {
    const VectorXd q = 0.5 * VectorXd::Random(arm.joints());
    const VectorXd dq = VectorXd::Random(arm.joints());
    const VectorXd ddq = VectorXd::Random(arm.joints());
    const VectorXd tau = joint_torques(arm, q, dq, ddq);
    const VectorXd theirs = exported.inverse_dynamics(q, dq, ddq);
    EXPECT_TRUE(near(theirs, tau, kRelative * (1.0 + tau.cwiseAbs().maxCoeff())));
  }
}

// Every frame of the arm is a site of MuJoCo's at the same place.
TEST_P(Mjcf, HasTheFramesOfTheArm) {
  const Model arm = plausible_model(read_model(GetParam()), 3).arm;
  Exported exported(arm);
  std::srand(6);
  const VectorXd q = 0.5 * VectorXd::Random(arm.joints());
  VectorXd::Map(exported.data->qpos, exported.model->nq) = exported.S * q;
  mj_kinematics(exported.model.get(), exported.data.get());
  for (int k = 0; k < static_cast<int>(arm.frames().size()); ++k) {
    const Frame& frame = arm.frames()[k];
    const int site = mj_name2id(exported.model.get(), mjOBJ_SITE, frame.name.c_str());
    ASSERT_GE(site, 0) << frame.name;
    const Eigen::Isometry3d T = frame_pose(arm, q, {k});
    const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> R(exported.data->site_xmat + 9 * site);
    EXPECT_TRUE(near(Eigen::Vector3d(exported.data->site_xpos + 3 * site), Eigen::Vector3d(T.translation()), 1e-9));
    EXPECT_TRUE(near(Eigen::Matrix3d(R), Eigen::Matrix3d(T.linear()), 1e-9)) << frame.name;
  }
}

// A rotor that turns with two coordinates at once has no joint of the arm: it gets one.
TEST(MjcfOfARotor, DrivenByTwoCoordinatesHasTheTorquesOfTheArm) {
  ModelDescription d = plausible_model(read_model("planar-2r"), 3).arm.description();
  EffectTerm rotor;
  rotor.effect = "rotor_inertia";
  rotor.axis.coefficients = Eigen::Vector2d(0.7, -1.3);
  rotor.values = {{"inertia", 0.4}};
  d.effects = {rotor};
  const Model arm(std::move(d));
  Exported exported(arm);
  const Eigen::Vector2d zero(0.0, 0.0);
  Eigen::Matrix2d M;
  for (int i = 0; i < 2; ++i) {
    M.col(i) = exported.inverse_dynamics(zero, zero, Eigen::Vector2d::Unit(i)) -
               exported.inverse_dynamics(zero, zero, zero);
  }
  const Eigen::Vector2d c(0.7, -1.3);
  EXPECT_TRUE(near(M, mass_matrix(arm, zero) + 0.4 * c * c.transpose(), 1e-9));
}

// The motors hold gravity for a quarter of a second: nothing blows up, couplings hold.
TEST_P(Mjcf, IsHeldAgainstGravityInMujoco) {
  const Model arm = plausible_model(read_model(GetParam()), 3).arm;
  Exported exported(arm);
  mjModel* m = exported.model.get();
  mjData* d = exported.data.get();
  VectorXd q(arm.joints());
  for (int i = 0; i < arm.joints(); ++i) {
    const Limits& limits = arm.coordinates()[i].limits;
    q[i] = std::isfinite(limits.lower + limits.upper) ? 0.5 * (limits.lower + limits.upper) : 0.1;
  }
  VectorXd::Map(d->qpos, m->nq) = exported.S * q;
  const VectorXd zero = VectorXd::Zero(arm.joints());
  for (int k = 0; k < 250; ++k) {
    VectorXd now(arm.joints());
    for (int i = 0; i < arm.joints(); ++i) {
      const int joint = mj_name2id(m, mjOBJ_JOINT, arm.coordinates()[i].name.c_str());
      now[i] = d->qpos[m->jnt_qposadr[joint]];
    }
    VectorXd::Map(d->ctrl, m->nu) = inverse_dynamics(arm, now, zero, zero);
    mj_step(m, d);
  }
  const VectorXd state = VectorXd::Map(d->qpos, m->nq);
  ASSERT_TRUE(state.allFinite());
  VectorXd end(arm.joints());
  for (int i = 0; i < arm.joints(); ++i) {
    const int joint = mj_name2id(m, mjOBJ_JOINT, arm.coordinates()[i].name.c_str());
    end[i] = d->qpos[m->jnt_qposadr[joint]];
  }
  EXPECT_TRUE(near(state, VectorXd(exported.S * end), 2e-3));
  EXPECT_TRUE(near(end, q, 0.1));
}

INSTANTIATE_TEST_SUITE_P(Robots, Mjcf,
                         testing::Values("planar-2r", "psm-3dof", "psm-wrist", "mtm", "ur10e",
                                         "kuka-lwr4", "scara"),
                         [](const auto& robot) {
                           std::string name = robot.param;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

// MuJoCo computes from a stranger's file what the model that is read from it computes; dry friction
// is a constraint there and compared by its number elsewhere.
TEST(ForeignMjcf, HasTheTorquesAndFramesOfMujoco) {
  const std::string path = testing::TempDir() + "veridyn_stranger_in_mujoco.xml";
  write_file(path, kStrangerMjcf);
  const Model read = read_model(path);
  std::remove(path.c_str());
  const Model arm = smooth(read);
  MujocoModel mujoco(kStrangerMjcf);
  mjModel* m = mujoco.model.get();
  mjData* d = mujoco.data.get();
  ASSERT_EQ(m->nv, 5);
  MatrixXd S = MatrixXd::Zero(5, 4);  // the follower comes last
  S.topRows(4).setIdentity();
  S(4, 3) = -0.5;
  const VectorXd s0 = 0.03 * VectorXd::Unit(5, 4);
  m->opt.disableflags |= mjDSBL_CONSTRAINT;
  std::srand(12);
  for (int trial = 0; trial < 20; ++trial) {
    const VectorXd q = VectorXd::Random(4), dq = VectorXd::Random(4), ddq = VectorXd::Random(4);
    VectorXd::Map(d->qpos, 5) = S * q + s0;
    VectorXd::Map(d->qvel, 5) = S * dq;
    VectorXd::Map(d->qacc, 5) = S * ddq;
    mj_inverse(m, d);
    VectorXd theirs = S.transpose() * VectorXd::Map(d->qfrc_inverse, 5);
    theirs[3] -= 3.0;  // the bias of the last actuator, 2 * 1.5, helps the motor
    const VectorXd tau = joint_torques(arm, q, dq, ddq);
    EXPECT_TRUE(near(theirs, tau, kRelative * (1.0 + tau.cwiseAbs().maxCoeff())));
    for (const char* name : {"upper", "fore", "slider", "finger"}) {
      const int body = mj_name2id(m, mjOBJ_BODY, name);
      const Eigen::Isometry3d T = frame_pose(arm, q, *arm.find_frame(name));
      const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> R(d->xmat + 9 * body);
      EXPECT_TRUE(near(Eigen::Vector3d(d->xpos + 3 * body), Eigen::Vector3d(T.translation()), 1e-12)) << name;
      EXPECT_TRUE(near(Eigen::Matrix3d(R), Eigen::Matrix3d(T.linear()), 1e-12)) << name;
    }
    const int mark = mj_name2id(m, mjOBJ_SITE, "mark");
    const Eigen::Isometry3d T = frame_pose(arm, q, *arm.find_frame("mark"));
    const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> R(d->site_xmat + 9 * mark);
    EXPECT_TRUE(near(Eigen::Matrix3d(R), Eigen::Matrix3d(T.linear()), 1e-12));
  }
}

TEST(MjcfExport, OfImpossibleBodiesIsRefused) {
  ModelDescription d = plausible_model(read_model("planar-2r"), 3).arm.description();
  for (Frame& frame : d.frames) {
    if (frame.body) (*frame.body->phi)[9] *= -1.0;
  }
  EXPECT_THROW(to_mjcf(Model(d)), InvalidInput);
  EXPECT_THROW(to_mjcf(read_model("psm-3dof")), InvalidInput);
}

}  // namespace
}  // namespace veridyn
