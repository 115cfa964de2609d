#include <gtest/gtest.h>

#include <kdl/chain.hpp>
#include <kdl/chaindynparam.hpp>
#include <kdl/chainidsolver_recursive_newton_euler.hpp>
#include <kdl/chainjnttojacsolver.hpp>

#include "support/near.hpp"
#include "support/sample_arms.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"
#include "veridyn/kinematics/kinematics.hpp"

// The same chains in the Kinematics and Dynamics Library, an independent implementation.

namespace veridyn {
namespace {

constexpr double kRelative = 1e-9;

KDL::Vector kdl(const Vec3d& a) {
  return {a.x, a.y, a.z};
}

KDL::Frame kdl(const Posed& T) {
  const Mat3d& R = T.R;
  return {KDL::Rotation(R.row0.x, R.row0.y, R.row0.z, R.row1.x, R.row1.y, R.row1.z, R.row2.x,
                        R.row2.y, R.row2.z),
          kdl(T.p)};
}

KDL::RigidBodyInertia kdl(const InertialParameters& phi) {
  const double m = phi[0];
  const Eigen::Vector3d c = phi.segment<3>(1) / m;
  const double xx = phi[4] - m * (c.y() * c.y() + c.z() * c.z());
  const double yy = phi[6] - m * (c.x() * c.x() + c.z() * c.z());
  const double zz = phi[9] - m * (c.x() * c.x() + c.y() * c.y());
  // KDL takes the inertia about the centre of mass, as xx, yy, zz, xy, xz, yz.
  return KDL::RigidBodyInertia(
      m, KDL::Vector(c.x(), c.y(), c.z()),
      KDL::RotationalInertia(xx, yy, zz, phi[5] + m * c.x() * c.y(), phi[7] + m * c.x() * c.z(),
                             phi[8] + m * c.y() * c.z()));
}

/// A fixed segment for A, then the joint about z with B and the body.
KDL::Chain kdl_chain(const Model& arm) {
  KDL::Chain chain;
  for (const Frame& frame : arm.frames()) {
    const double s0 = frame.variable.offset;
    const bool turns = frame.type == JointType::kRevolute;
    const Posed at_zero = turns ? Posed{rotation_z(s0), {0, 0, 0}} : Posed{identity3(), {0, 0, s0}};
    chain.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::None), kdl(frame.A)));
    chain.addSegment(KDL::Segment(KDL::Joint(turns ? KDL::Joint::RotZ : KDL::Joint::TransZ),
                                  kdl(at_zero * frame.B), kdl(*frame.body->phi)));
  }
  return chain;
}

KDL::JntArray kdl(const VectorXd& v) {
  KDL::JntArray a(static_cast<unsigned>(v.size()));
  a.data = v;
  return a;
}

class KdlOnSerialArms : public testing::TestWithParam<std::string> {
 protected:
  Model arm_ = random_serial(GetParam(), 91);
  KDL::Chain chain_ = kdl_chain(arm_);
  KDL::Vector gravity_{arm_.gravity().x(), arm_.gravity().y(), arm_.gravity().z()};
  std::vector<State> states_ = test_states(arm_.joints(), 92);
};

TEST_P(KdlOnSerialArms, InverseDynamicsAgree) {
  KDL::ChainIdSolver_RNE solver(chain_, gravity_);
  const KDL::Wrenches no_loads(chain_.getNrOfSegments());
  for (const State& s : states_) {
    KDL::JntArray tau(chain_.getNrOfJoints());
    ASSERT_EQ(solver.CartToJnt(kdl(s.q), kdl(s.dq), kdl(s.ddq), no_loads, tau), 0);
    EXPECT_TRUE(
        near(inverse_dynamics(arm_, s.q, s.dq, s.ddq), tau.data, kRelative * tau.data.norm()));
  }
}

TEST_P(KdlOnSerialArms, MassMatrixAgrees) {
  KDL::ChainDynParam solver(chain_, gravity_);
  for (const State& s : states_) {
    KDL::JntSpaceInertiaMatrix M(chain_.getNrOfJoints());
    ASSERT_EQ(solver.JntToMass(kdl(s.q), M), 0);
    EXPECT_TRUE(near(mass_matrix(arm_, s.q), M.data, kRelative * M.data.norm()));
  }
}

TEST_P(KdlOnSerialArms, CoriolisAndGravityTorquesAgree) {
  KDL::ChainDynParam solver(chain_, gravity_);
  RigidBodyDynamics dynamics(arm_, *arm_.inertial_values());
  VectorXd g(arm_.joints());
  for (const State& s : states_) {
    KDL::JntArray expected(chain_.getNrOfJoints());
    ASSERT_EQ(solver.JntToCoriolis(kdl(s.q), kdl(s.dq), expected), 0);
    EXPECT_TRUE(near(coriolis_matrix(arm_, s.q, s.dq) * s.dq, expected.data,
                     kRelative * (1e-6 + expected.data.norm())));
    ASSERT_EQ(solver.JntToGravity(kdl(s.q), expected), 0);
    dynamics.gravity_torques(s.q, g);
    EXPECT_TRUE(near(g, expected.data, kRelative * expected.data.norm()));
  }
}

TEST_P(KdlOnSerialArms, JacobianAgrees) {
  KDL::ChainJntToJacSolver solver(chain_);
  for (const State& s : states_) {
    KDL::Jacobian J(chain_.getNrOfJoints());
    ASSERT_EQ(solver.JntToJac(kdl(s.q), J), 0);
    const FrameIndex tip{static_cast<int>(arm_.frames().size()) - 1};
    EXPECT_TRUE(near(frame_jacobian(arm_, s.q, tip), J.data, kRelative * J.data.norm()));
  }
}

INSTANTIATE_TEST_SUITE_P(Random, KdlOnSerialArms,
                         testing::Values("R", "P", "RR", "RRP", "PRRPR", "RRRRRRR", "RPRPRPRR"),
                         sample_arm_name);

}  // namespace
}  // namespace veridyn
