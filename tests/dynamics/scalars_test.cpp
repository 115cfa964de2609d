#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "math/dual.hpp"
#include "math/pack.hpp"
#include "support/near.hpp"
#include "support/sample_arms.hpp"
#include "veridyn/dynamics/arm_dynamics.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"
#include "veridyn/kinematics/kinematics.hpp"

// One recursion over many scalars: every algorithm over each of them against the compiled doubles.

namespace veridyn {
namespace {

// The part of CppAD or CasADi: a number on a tape, which knows its derivatives by all inputs.
struct Taped {
  struct Entry {
    int a, b;       // what it was made of
    double da, db;  // derivatives by these
  };
  inline static std::vector<Entry> tape;  // NOLINT: one tape for one test

  Taped(double x = 0.0) : value(x), at(-1) {}  // NOLINT: a constant
  Taped(double x, const Entry& entry) : value(x), at(static_cast<int>(tape.size())) {
    tape.push_back(entry);
  }
  static Taped input(double x) { return {x, {-1, -1, 0.0, 0.0}}; }

  Taped& operator+=(const Taped& b) { return *this = *this + b; }
  Taped& operator-=(const Taped& b) { return *this = *this - b; }
  friend Taped operator+(const Taped& a, const Taped& b) {
    return {a.value + b.value, {a.at, b.at, 1.0, 1.0}};
  }
  friend Taped operator-(const Taped& a, const Taped& b) {
    return {a.value - b.value, {a.at, b.at, 1.0, -1.0}};
  }
  friend Taped operator-(const Taped& a) { return {-a.value, {a.at, -1, -1.0, 0.0}}; }
  friend Taped operator*(const Taped& a, const Taped& b) {
    return {a.value * b.value, {a.at, b.at, b.value, a.value}};
  }
  friend Taped operator/(const Taped& a, const Taped& b) {
    const double q = a.value / b.value;
    return {q, {a.at, b.at, 1.0 / b.value, -q / b.value}};
  }

  // Derivatives of this number by every entry of the tape.
  std::vector<double> gradient() const {
    std::vector<double> by(tape.size(), 0.0);
    if (at >= 0) by[at] = 1.0;
    for (size_t k = tape.size(); k-- > 0;) {
      const Entry& e = tape[k];
      if (e.a >= 0) by[e.a] += by[k] * e.da;
      if (e.b >= 0) by[e.b] += by[k] * e.db;
    }
    return by;
  }

  double value;
  int at;
};

void sine_cosine(const Taped& x, Taped& sine, Taped& cosine) {
  const double s = std::sin(x.value);
  const double c = std::cos(x.value);
  sine = {s, {x.at, -1, c, 0.0}};
  cosine = {c, {x.at, -1, -s, 0.0}};
}

struct Here;
using Packed = Pack<4, Here>;

double number(double x) { return x; }
double number(float x) { return x; }
double number(const Taped& x) { return x.value; }
double number(const Packed& x) { return x.v[2]; }
template <typename S>
double number(const Dual<S>& x) {
  return number(x.value);
}

template <typename S>
MatrixXd numbers(const Eigen::Matrix<S, Eigen::Dynamic, Eigen::Dynamic>& of) {
  MatrixXd out(of.rows(), of.cols());
  for (Eigen::Index k = 0; k < of.size(); ++k) out.data()[k] = number(of.data()[k]);
  return out;
}

template <typename S>
VectorXd numbers(const Eigen::Matrix<S, Eigen::Dynamic, 1>& of) {
  VectorXd out(of.size());
  for (Eigen::Index k = 0; k < of.size(); ++k) out[k] = number(of.data()[k]);
  return out;
}

template <typename S>
Eigen::Matrix<S, Eigen::Dynamic, 1> scalars(const VectorXd& x) {
  Eigen::Matrix<S, Eigen::Dynamic, 1> out(x.size());
  for (Eigen::Index k = 0; k < x.size(); ++k) out.data()[k] = S(static_cast<typename ConstantOf<S>::type>(x[k]));
  return out;
}

class ScalarsOnEverySampleArm : public OnSampleArm {
 protected:
  // `rounding`: of a sum of some thousand products, relative to the largest entries.
  template <typename S>
  void expect_the_same(double rounding) {
    using Vector = typename ArmDynamics<S>::Vector;
    using Matrix = typename ArmDynamics<S>::Matrix;
    const int n = joints();
    const Tree tree(arm(), Tree::Keep::kMovingLinks);
    ArmDynamics<S> dynamics(tree, phi().data());
    RigidBodyDynamics expected(arm(), phi());
    for (const State& s : test_states(n, 91)) {
      Taped::tape.clear();
      const Vector q = scalars<S>(s.q);
      const Vector dq = scalars<S>(s.dq);
      const Vector ddq = scalars<S>(s.ddq);
      RigidBodyDynamics::TorqueDerivatives d;
      RigidBodyDynamics::AccelerationDerivatives a;
      VectorXd tau(n), g(n), back(n);
      MatrixXd C(n, n);
      expected.inverse_dynamics_derivatives(s.q, s.dq, s.ddq, tau, d);
      expected.gravity_torques(s.q, g);
      expected.coriolis_matrix(s.q, s.dq, C);
      ASSERT_TRUE(expected.forward_dynamics_derivatives(s.q, s.dq, tau, back, a));
      const double size = 1.0 + tau.norm() + d.by_q.norm() + d.by_dq.norm() + d.by_ddq.norm();

      Vector own(n), own_ddq(n);
      Matrix by_q(n, n), by_dq(n, n), by_last(n, n), Y(n, phi().size());
      dynamics.inverse_dynamics(q, dq, ddq, own);
      EXPECT_TRUE(near(numbers(own), tau, rounding * size));
      dynamics.gravity_torques(q, own);
      EXPECT_TRUE(near(numbers(own), g, rounding * size));
      dynamics.mass_matrix(q, by_last);
      EXPECT_TRUE(near(numbers(by_last), d.by_ddq, rounding * size));
      dynamics.coriolis_matrix(q, dq, by_last);
      EXPECT_TRUE(near(numbers(by_last), C, rounding * size));
      dynamics.inverse_dynamics_derivatives(q, dq, ddq, own, by_q, by_dq, by_last);
      EXPECT_TRUE(near(numbers(by_q), d.by_q, rounding * size));
      EXPECT_TRUE(near(numbers(by_dq), d.by_dq, rounding * size));
      EXPECT_TRUE(near(numbers(by_last), d.by_ddq, rounding * size));
      dynamics.regressor(q, dq, ddq, Y);
      EXPECT_TRUE(near(numbers(Y), torque_regressor(arm(), s.q, s.dq, s.ddq), rounding * size));
      const double condition = a.by_tau.norm() * d.by_ddq.norm();
      const double loose = rounding * condition *
                           (1.0 + back.norm() + a.by_q.norm() + a.by_dq.norm() + a.by_tau.norm() +
                            a.by_tau.norm() * size);
      ASSERT_TRUE(dynamics.forward_dynamics_derivatives(q, dq, scalars<S>(tau), own_ddq, by_q,
                                                        by_dq, by_last));
      EXPECT_TRUE(near(numbers(own_ddq), back, loose));
      EXPECT_TRUE(near(numbers(by_q), a.by_q, loose));
      EXPECT_TRUE(near(numbers(by_dq), a.by_dq, loose));
      EXPECT_TRUE(near(numbers(by_last), a.by_tau, loose));
    }
  }
};
INSTANTIATE_TEST_SUITE_P(Sample, ScalarsOnEverySampleArm, testing::ValuesIn(all_arm_names()),
                         sample_arm_name);

TEST_P(ScalarsOnEverySampleArm, DoublesGiveTheSameTorques) { expect_the_same<double>(1e-12); }
TEST_P(ScalarsOnEverySampleArm, FloatsGiveTheSameTorquesToTheirPrecision) { expect_the_same<float>(1e-3); }
TEST_P(ScalarsOnEverySampleArm, DualNumbersGiveTheDerivatives) { expect_the_same<Dual<double>>(1e-12); }
TEST_P(ScalarsOnEverySampleArm, PacksGiveTheTorquesOfEachSample) { expect_the_same<Packed>(1e-12); }
TEST_P(ScalarsOnEverySampleArm, DualsOfPacksGiveTheSameTorques) { expect_the_same<Dual<Packed>>(1e-12); }
TEST_P(ScalarsOnEverySampleArm, AUserDefinedScalarGivesTheSameTorques) { expect_the_same<Taped>(1e-12); }

// What the tape is for: all derivatives of one torque in one way back.
TEST_P(ScalarsOnEverySampleArm, TheTapeGivesTheDerivativesOfTheTorques) {
  const int n = joints();
  const Tree tree(arm(), Tree::Keep::kMovingLinks);
  ArmDynamics<Taped> dynamics(tree, phi().data());
  RigidBodyDynamics expected(arm(), phi());
  const State s = test_states(n, 92).back();
  RigidBodyDynamics::TorqueDerivatives d;
  VectorXd value(n);
  expected.inverse_dynamics_derivatives(s.q, s.dq, s.ddq, value, d);
  Taped::tape.clear();
  ArmDynamics<Taped>::Vector q(n), dq(n), ddq(n), tau(n);
  for (int i = 0; i < n; ++i) q[i] = Taped::input(s.q[i]);
  for (int i = 0; i < n; ++i) dq[i] = Taped::input(s.dq[i]);
  for (int i = 0; i < n; ++i) ddq[i] = Taped::input(s.ddq[i]);
  dynamics.inverse_dynamics(q, dq, ddq, tau);
  const double allowed = 1e-12 * (1.0 + d.by_q.norm() + d.by_dq.norm() + d.by_ddq.norm());
  for (int i = 0; i < n; ++i) {
    const std::vector<double> by = tau[i].gradient();
    const Eigen::Map<const VectorXd> first(by.data(), 3 * n);
    EXPECT_TRUE(near(first.head(n), d.by_q.row(i).transpose(), allowed));
    EXPECT_TRUE(near(first.segment(n, n), d.by_dq.row(i).transpose(), allowed));
    EXPECT_TRUE(near(first.tail(n), d.by_ddq.row(i).transpose(), allowed));
  }
}

// A wrench on a frame costs J' w, wherever the frame is.
TEST_P(ScalarsOnEverySampleArm, ExternalWrenchesAddTheTransposedJacobianTimesTheWrench) {
  const int n = joints();
  RigidBodyDynamics dynamics(arm(), phi());
  Random random(93);
  const State s = test_states(n, 94).back();
  VectorXd free(n), loaded(n);
  dynamics.inverse_dynamics(s.q, s.dq, s.ddq, free);
  for (FrameIndex frame; frame.value < static_cast<int>(arm().frames().size()); ++frame.value) {
    const Eigen::Vector3d force = random.vector(3, -5, 5);
    const Eigen::Vector3d moment = random.vector(3, -5, 5);
    dynamics.inverse_dynamics(s.q, s.dq, s.ddq, {{frame, force, moment}}, loaded);
    const Eigen::Matrix3d R = frame_pose(arm(), s.q, frame).rotation();
    VectorXd wrench(6);
    wrench << R * force, R * moment;
    const VectorXd borne = frame_jacobian(arm(), s.q, frame).transpose() * wrench;
    EXPECT_TRUE(near(free - loaded, borne, 1e-12 * (1.0 + free.norm() + borne.norm()))) << frame.value;
  }
}

}  // namespace
}  // namespace veridyn
