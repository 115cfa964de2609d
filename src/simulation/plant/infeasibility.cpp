#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "simulation/plant/plant_forces.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"
#include "kinematics/motion_limits.hpp"
#include "veridyn/simulation/plant.hpp"

namespace veridyn {
namespace {

constexpr int kSpread = 2000;       // number of configurations spread over the range
constexpr int kMostCorners = 1024;  // largest number of corners of the range that are tested
constexpr int kWorst = 8;           // number of configurations from which the search descends
// Ratio of the smallest to the largest eigenvalue of M below which it is singular.
constexpr double kTiny = 1e-12;
// [s] shortest time in which viscous friction alone may stop a joint.
constexpr double kShortest = 1e-7;

constexpr int kPrimes[] = {2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53};

// Halton's sequence (Numerische Mathematik 2, 1960): even coverage of a cube.
double radical_inverse(int k, int base) {
  double result = 0.0;
  for (double digit = 1.0 / base; k > 0; k /= base, digit /= base) result += digit * (k % base);
  return result;
}

struct Candidate {
  VectorXd q;
  double worth;
};

// Searches the joints' range for the configuration with the lowest value of a function `worth`.
class Range {
 public:
  explicit Range(const Model& arm) : limits_(motion_limits(arm)) {}

  // The middle, corners, and kSpread evenly spread configurations of the range.
  std::vector<VectorXd> configurations() const {
    const auto n = static_cast<int>(limits_.lower.size());
    std::vector<VectorXd> all{position_at_share(VectorXd::Constant(n, 0.5))};
    for (int corner = 0; corner < kMostCorners && (n >= 30 || corner < (1 << n)); ++corner) {
      VectorXd share(n);
      for (int i = 0; i < n; ++i) share[i] = i < 30 ? (corner >> i) & 1 : 0;
      all.push_back(position_at_share(share));
    }
    for (int k = 1; k <= kSpread; ++k) {
      VectorXd share(n);
      for (int i = 0; i < n; ++i) share[i] = radical_inverse(k, kPrimes[i % 16]);
      all.push_back(position_at_share(share));
    }
    return all;
  }

  // Searches for the lowest value, coordinate by coordinate, from the worst configurations.
  template <typename Worth>
  Candidate lowest_candidate(const Worth& worth) const {
    std::vector<Candidate> all;
    for (const VectorXd& q : configurations()) all.push_back({q, worth(q)});
    const size_t count = std::min<size_t>(kWorst, all.size());
    std::partial_sort(all.begin(), all.begin() + static_cast<long>(count), all.end(),
                      [](const Candidate& a, const Candidate& b) { return a.worth < b.worth; });
    Candidate best = all.front();
    for (size_t k = 0; k < count; ++k) {
      const Candidate found = descended(all[k], worth);
      if (found.worth < best.worth) best = found;
    }
    return best;
  }

 private:
  VectorXd position_at_share(const VectorXd& share) const {
    return limits_.lower + share.cwiseProduct(limits_.upper - limits_.lower);
  }

  // Steps along single coordinates, of 10 % of their range and less, kept where they lower `worth`.
  template <typename Worth>
  Candidate descended(Candidate from, const Worth& worth) const {
    for (double share = 0.1; share > 1e-3; share *= 0.5) {
      for (Eigen::Index i = 0; i < from.q.size(); ++i) {
        for (const double side : {-1.0, 1.0}) {
          Candidate next = from;
          next.q[i] = std::clamp(from.q[i] + side * share * (limits_.upper[i] - limits_.lower[i]),
                                 limits_.lower[i], limits_.upper[i]);
          next.worth = worth(next.q);
          if (next.worth < from.worth) from = next;
        }
      }
    }
    return from;
  }

  MotionLimits limits_;
};

std::string where(const Model& arm, const VectorXd& q) {
  std::string out;
  for (int i = 0; i < arm.joints(); ++i) {
    const Coordinate& c = arm.coordinates()[i];
    out += fmt::format("{}{} {:.4g} {}", i > 0 ? ", " : "", c.name, q[i], position_unit(c));
  }
  return out;
}

// The smallest eigenvalue (-1 if an entry is not finite) after scaling by the joints' own sizes, so that light and
// heavy joints count alike.
double smallest_scaled_share(const MatrixXd& M, const VectorXd& size) {
  const MatrixXd scaled = size.cwiseInverse().asDiagonal() * M * size.cwiseInverse().asDiagonal();
  if (!scaled.allFinite()) return -1.0;
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(scaled, Eigen::EigenvaluesOnly);
  return solver.eigenvalues()[0];
}

// One line on a joint whose friction stops it at once, empty if there is none: no identified joint has so little inertia.
std::string without_inertia(const Model& arm, RigidBodyDynamics& rigid, const PlantForces& forces,
                            const Range& range) {
  MatrixXd M(arm.joints(), arm.joints());
  int joint = 0;
  const auto seconds = [&](const VectorXd& q) {
    rigid.mass_matrix(q, M);
    double least = 1.0;
    for (int i = 0; i < arm.joints(); ++i) {
      const double damping = forces.damping()(i, i);
      if (!(damping > 0.0)) continue;
      const double time = (M(i, i) + forces.inertia()(i, i)) / damping;
      if (time >= least) continue;
      least = time;
      joint = i;
    }
    return least;
  };
  const Candidate found = range.lowest_candidate(seconds);
  if (seconds(found.q) > kShortest) return "";
  const Coordinate& c = arm.coordinates()[joint];
  return fmt::format(
      "joint {} of '{}' has {:.2g} {} of inertia at {}, too little beside its friction; expected a "
      "body or a rotor_inertia that is not zero.",
      c.name, arm.name(), M(joint, joint) + forces.inertia()(joint, joint),
      c.prismatic ? "kg" : "kg m^2", where(arm, found.q));
}

}  // namespace

std::string infeasibility(const Model& arm) {
  const int n = arm.joints();
  const auto phi = arm.inertial_values();
  if (!phi) return "the arm has bodies without values.";
  RigidBodyDynamics rigid(arm, *phi);
  PlantForces forces(arm);
  const Range range(arm);
  MatrixXd M(n, n);
  const Candidate mass = range.lowest_candidate([&](const VectorXd& q) {
    rigid.mass_matrix(q, M);
    M += forces.inertia();
    const VectorXd size = M.diagonal().cwiseAbs().cwiseMax(1e-300).cwiseSqrt();
    return M.diagonal().minCoeff() > 0.0 ? smallest_scaled_share(M, size) : -1.0;
  });
  if (mass.worth <= kTiny) {
    return fmt::format("the mass matrix of '{}' is not positive definite at {}.", arm.name(),
                       where(arm, mass.q));
  }
  const std::string massless = without_inertia(arm, rigid, forces, range);
  if (!massless.empty()) return massless;
  const VectorXd zero = VectorXd::Zero(n);
  forces.reset(zero.data(), zero.data());
  const VectorXd speeds = motion_limits(arm).velocity;
  const Candidate drive = range.lowest_candidate([&](const VectorXd& q) {
    double least = 0.0;  // [W] power at the full speed of one joint
    for (int i = 0; i < n; ++i) least = std::min(least, forces.friction_power(q, i, speeds[i]));
    return least;
  });
  if (drive.worth < 0.0) {
    return fmt::format("friction of '{}' drives the motion with {:.3g} W at {}.", arm.name(),
                       -drive.worth, where(arm, drive.q));
  }
  return "";
}

}  // namespace veridyn
