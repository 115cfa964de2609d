#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cstring>
#include <iomanip>
#include <memory>
#include <sstream>

#include "support/mujoco_model.hpp"
#include "support/near.hpp"
#include "support/sample_arms.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"

// The same arms in MuJoCo, an independent engine, from a model written on the spot.

namespace veridyn {
namespace {

constexpr double kRelative = 1e-9;

Eigen::Matrix3d eigen(const Mat3d& R) {
  Eigen::Matrix3d M;
  M << R.row0.x, R.row0.y, R.row0.z, R.row1.x, R.row1.y, R.row1.z, R.row2.x, R.row2.y, R.row2.z;
  return M;
}

std::string pose_attributes(const Posed& T) {
  const Eigen::Quaterniond q(eigen(T.R));
  std::ostringstream out;
  out << std::setprecision(17) << " pos='" << T.p.x << ' ' << T.p.y << ' ' << T.p.z << "' quat='"
      << q.w() << ' ' << q.x() << ' ' << q.y() << ' ' << q.z() << '\'';
  return out.str();
}

/// Mass, centre and principal inertia in the joint's frame: MuJoCo's body frame turns with the
/// joint and stands before B. (It would find the principal axes of `fullinertia` itself, but only
/// to 1e-8.)
std::string inertial_element(const InertialParameters& phi, const Posed& B) {
  const double m = phi[0];
  const Eigen::Vector3d c = phi.segment<3>(1) / m;
  Eigen::Matrix3d L;
  L << phi[4], phi[5], phi[7], phi[5], phi[6], phi[8], phi[7], phi[8], phi[9];
  const Eigen::Matrix3d about_com =
      L - m * (c.dot(c) * Eigen::Matrix3d::Identity() - c * c.transpose());
  const Eigen::Matrix3d R = eigen(B.R);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal(R * about_com * R.transpose());
  Eigen::Matrix3d axes = principal.eigenvectors();
  if (axes.determinant() < 0) axes.col(0) *= -1;
  const Eigen::Vector3d com = R * c + Eigen::Vector3d(B.p.x, B.p.y, B.p.z);
  const Eigen::Quaterniond q(axes);
  const Eigen::Vector3d& I = principal.eigenvalues();
  std::ostringstream out;
  out << std::setprecision(17) << "<inertial pos='" << com.x() << ' ' << com.y() << ' ' << com.z()
      << "' quat='" << q.w() << ' ' << q.x() << ' ' << q.y() << ' ' << q.z() << "' mass='" << m
      << "' diaginertia='" << I.x() << ' ' << I.y() << ' ' << I.z() << "'/>\n";
  return out.str();
}

// The frames that hang on `parent`; T_before is the parent's B, which MuJoCo's body does not know.
void write_children(const Model& arm, std::optional<FrameIndex> parent, const Posed& T_before, std::ostream& out) {
  for (int k = 0; k < static_cast<int>(arm.frames().size()); ++k) {
    const Frame& frame = arm.frames()[k];
    if (frame.parent != parent) continue;
    const bool turns = frame.type == JointType::kRevolute;
    const double s0 = frame.variable.offset;
    const Posed at_zero = turns ? Posed{rotation_z(s0), {0, 0, 0}} : Posed{identity3(), {0, 0, s0}};
    out << "<body name='" << frame.name << '\'' << pose_attributes(T_before * frame.A * at_zero)
        << ">\n<joint name='" << arm.coordinates()[main_coordinate(frame.variable).value].name
        << "' type='" << (turns ? "hinge" : "slide") << "' axis='0 0 1'/>\n"
        << inertial_element(*frame.body->phi, frame.B);
    write_children(arm, FrameIndex{k}, frame.B, out);
    out << "</body>\n";
  }
}

std::string mjcf(const Model& arm) {
  std::ostringstream out;
  out << std::setprecision(17)
      << "<mujoco><compiler angle='radian' inertiafromgeom='false'/>\n<option gravity='"
      << arm.gravity().x() << ' ' << arm.gravity().y() << ' ' << arm.gravity().z()
      << "'><flag constraint='disable' contact='disable'/></option>\n<worldbody>\n";
  write_children(arm, std::nullopt, identity_pose(), out);
  out << "</worldbody></mujoco>\n";
  return out.str();
}

class Engine {
 public:
  explicit Engine(const Model& arm) : arm_(arm), engine_(mjcf(arm)) {}

  VectorXd inverse_dynamics(const State& s) {
    set(s);
    mj_inverse(model_.get(), data_.get());
    return from_engine(data_->qfrc_inverse);
  }

  MatrixXd mass_matrix(const State& s) {
    set(s);
    mj_forward(model_.get(), data_.get());
    const int n = arm_.joints();
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> dense(n, n);
    mj_fullM(model_.get(), dense.data(), data_->qM);
    MatrixXd M(n, n);
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) M(i, j) = dense(index(i), index(j));
    }
    return M;
  }

 private:

  // MuJoCo orders joints depth first.
  int index(int coordinate) const {
    return model_->jnt_dofadr[mj_name2id(model_.get(), mjOBJ_JOINT,
                                         arm_.coordinates()[coordinate].name.c_str())];
  }

  void set(const State& s) {
    for (int i = 0; i < arm_.joints(); ++i) {
      data_->qpos[index(i)] = s.q[i];
      data_->qvel[index(i)] = s.dq[i];
      data_->qacc[index(i)] = s.ddq[i];
    }
  }

  VectorXd from_engine(const double* values) const {
    VectorXd v(arm_.joints());
    for (int i = 0; i < arm_.joints(); ++i) v[i] = values[index(i)];
    return v;
  }

  const Model& arm_;
  MujocoModel engine_;
  const std::unique_ptr<mjModel, MujocoModel::Free>& model_ = engine_.model;
  const std::unique_ptr<mjData, MujocoModel::Free>& data_ = engine_.data;
};

class MujocoOnArms : public testing::TestWithParam<std::string> {
 protected:
  Model arm_ = GetParam() == "branched" ? branched_tree(93) : random_serial(GetParam(), 94);
  Engine engine_{arm_};
  std::vector<State> states_ = test_states(arm_.joints(), 95);
};

TEST_P(MujocoOnArms, InverseDynamicsAgree) {
  for (const State& s : states_) {
    const VectorXd expected = engine_.inverse_dynamics(s);
    EXPECT_TRUE(
        near(inverse_dynamics(arm_, s.q, s.dq, s.ddq), expected, kRelative * expected.norm()));
  }
}

TEST_P(MujocoOnArms, MassMatrixAgrees) {
  for (const State& s : states_) {
    const MatrixXd expected = engine_.mass_matrix(s);
    EXPECT_TRUE(near(mass_matrix(arm_, s.q), expected, kRelative * expected.norm()));
  }
}

INSTANTIATE_TEST_SUITE_P(Random, MujocoOnArms,
                         testing::Values("branched", "R", "RR", "RRP", "PRRPR", "RRRRRRR",
                                         "RPRPRPRR"),
                         sample_arm_name);

}  // namespace
}  // namespace veridyn
