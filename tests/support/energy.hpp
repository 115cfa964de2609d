#pragma once

#include <array>
#include <vector>

#include "support/random.hpp"
#include "math/dual.hpp"
#include "veridyn/model/model.hpp"

// Energy of an arm, written down from poses alone and without any of the library's recursions:
//
//   E_kin = 1/2 sum trace(dT/dt J dT/dt'),   E_pot = - sum m g' p_com
//
// T is the homogeneous pose of a body in the world, a product of 4 x 4 matrices, and J its
// pseudo-inertia (4 x 4). Source: Uicker 1965; Paul, Robot Manipulators, 1981, ch. 6.

namespace veridyn {

template <typename S>
using Homogeneous = std::array<std::array<S, 4>, 4>;

template <typename S>
Homogeneous<S> operator*(const Homogeneous<S>& a, const Homogeneous<S>& b) {
  Homogeneous<S> c{};
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      c[i][j] = S(0.0);
      for (int k = 0; k < 4; ++k) c[i][j] += a[i][k] * b[k][j];
    }
  }
  return c;
}

template <typename S>
Homogeneous<S> homogeneous(const Posed& T) {
  // clang-format off
  return {{{S(T.R.row0.x), S(T.R.row0.y), S(T.R.row0.z), S(T.p.x)},
           {S(T.R.row1.x), S(T.R.row1.y), S(T.R.row1.z), S(T.p.y)},
           {S(T.R.row2.x), S(T.R.row2.y), S(T.R.row2.z), S(T.p.z)},
           {S(0.0), S(0.0), S(0.0), S(1.0)}}};
  // clang-format on
}

/// T_world_frame of every frame.
template <typename S>
std::vector<Homogeneous<S>> world_poses(const Model& arm, const std::vector<S>& q) {
  std::vector<Homogeneous<S>> T_world;
  for (const Frame& frame : arm.frames()) {
    S s(frame.variable.offset);
    for (int i = 0; i < arm.joints(); ++i) s += S(frame.variable.coefficients[i]) * q[i];
    Homogeneous<S> J = homogeneous<S>(identity_pose());
    if (frame.type == JointType::kRevolute) {
      S sine{};
      S cosine{};
      sine_cosine(s, sine, cosine);
      J[0][0] = cosine;
      J[0][1] = -sine;
      J[1][0] = sine;
      J[1][1] = cosine;
    } else if (frame.type == JointType::kPrismatic) {
      J[2][3] = s;
    }
    const Homogeneous<S> T_parent_frame = homogeneous<S>(frame.A) * J * homogeneous<S>(frame.B);
    T_world.push_back(frame.parent ? T_world[frame.parent->value] * T_parent_frame : T_parent_frame);
  }
  return T_world;
}

template <typename S>
struct Energy {
  S kinetic, potential;
};

template <typename S>
Energy<S> energy(const Model& arm, const std::vector<S>& q, const std::vector<S>& dq) {
  std::vector<Dual<S>> path(q.size());
  for (size_t i = 0; i < q.size(); ++i) path[i] = {q[i], dq[i]};
  const std::vector<Homogeneous<Dual<S>>> T_world = world_poses(arm, path);
  Energy<S> sum{S(0.0), S(0.0)};
  for (const auto [k] : arm.bodies()) {
    const InertialParameters& phi = *arm.frames()[k].body->phi;
    const double half_trace = 0.5 * (phi[4] + phi[6] + phi[9]);
    // clang-format off
    const double J[4][4] = {{half_trace - phi[4], -phi[5], -phi[7], phi[1]},
                            {-phi[5], half_trace - phi[6], -phi[8], phi[2]},
                            {-phi[7], -phi[8], half_trace - phi[9], phi[3]},
                            {phi[1], phi[2], phi[3], phi[0]}};
    // clang-format on
    for (int row = 0; row < 3; ++row) {
      for (int a = 0; a < 4; ++a) {
        const Dual<S>& T_a = T_world[k][row][a];
        sum.potential -= S(arm.gravity()[row] * J[a][3]) * T_a.value;
        for (int b = 0; b < 4; ++b) {
          sum.kinetic += S(0.5 * J[a][b]) * T_a.derivative * T_world[k][row][b].derivative;
        }
      }
    }
  }
  return sum;
}

/// Lagrange's equations:  tau_i = d/dt dE_kin/d(dq_i) - dE_kin/dq_i + dE_pot/dq_i
///
/// The inner derivative runs along the motion, the outer one along coordinate i.
inline Eigen::VectorXd torques_of_lagrange(const Model& arm, const State& s) {
  using D1 = Dual<double>;
  using D2 = Dual<D1>;
  const int n = arm.joints();
  Eigen::VectorXd tau(n);
  for (int i = 0; i < n; ++i) {
    std::vector<D2> q(n);
    std::vector<D2> dq(n);
    std::vector<D1> q_i(n);
    std::vector<D1> dq_i(n);
    for (int j = 0; j < n; ++j) {
      q[j] = D2(D1(s.q[j], s.dq[j]), D1(0.0));
      dq[j] = D2(D1(s.dq[j], s.ddq[j]), D1(i == j ? 1.0 : 0.0));
      q_i[j] = D1(s.q[j], i == j ? 1.0 : 0.0);
      dq_i[j] = D1(s.dq[j]);
    }
    const Energy<D1> along_q = energy(arm, q_i, dq_i);
    tau[i] = energy(arm, q, dq).kinetic.derivative.derivative - along_q.kinetic.derivative +
             along_q.potential.derivative;
  }
  return tau;
}

}  // namespace veridyn
