#include "diagnosis/load_fit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "diagnosis/load_numbers.hpp"

namespace veridyn {
namespace {

using namespace loads;

using Row10 = Eigen::Matrix<double, kBodyParameters, 1>;
using Slopes = Eigen::Matrix<double, kBodyParameters, 4>;

// Inertial parameters of a unit mass at c.
Row10 unit_mass_parameters(const Eigen::Vector3d& c) {
  Row10 p;
  p << 1.0, c, c.y() * c.y() + c.z() * c.z(), -c.x() * c.y(), c.x() * c.x() + c.z() * c.z(), -c.x() * c.z(),
      -c.y() * c.z(), c.x() * c.x() + c.y() * c.y();
  return p;
}

// Derivatives of mass * unit_mass_parameters(c) with respect to the mass and by c.
Slopes derivatives_of_placed_mass(double mass, const Eigen::Vector3d& c) {
  Slopes J = Slopes::Zero();
  J.col(0) = unit_mass_parameters(c);
  J.block<3, 3>(1, 1) = mass * Eigen::Matrix3d::Identity();
  // clang-format off
  J.block<6, 3>(4, 1) << 0.0, 2.0 * c.y(), 2.0 * c.z(),
                         -c.y(), -c.x(), 0.0,
                         2.0 * c.x(), 0.0, 2.0 * c.z(),
                         -c.z(), 0.0, -c.x(),
                         0.0, -c.z(), -c.y(),
                         2.0 * c.x(), 2.0 * c.y(), 0.0;
  // clang-format on
  J.block<6, 3>(4, 1) *= mass;
  return J;
}

// Weighted sums of the load's columns, and of the columns fitted together with it.
struct Weighted {
  MatrixXd A;
  VectorXd b;
};

// Sums over the joints of weights times squares of columns first .. first + 9 and `beside`, without those of `without`.
Weighted normal_equations_of(const std::vector<RowSquares>& rows, const std::vector<RowSquares>* without, const VectorXd& weights,
                  int first, const std::vector<int>& beside) {
  std::vector<int> set;
  for (int c = 0; c < kBodyParameters; ++c) set.push_back(first + c);
  set.insert(set.end(), beside.begin(), beside.end());
  const auto size = static_cast<Eigen::Index>(set.size());
  Weighted out{MatrixXd::Zero(size, size), VectorXd::Zero(size)};
  for (size_t i = 0; i < rows.size(); ++i) {
    const double w = weights[static_cast<Eigen::Index>(i)];
    if (w == 0.0) continue;
    out.A += w * rows[i].AA(set, set);
    out.b += w * rows[i].Ab(set);
    if (without == nullptr) continue;
    out.A -= w * (*without)[i].AA(set, set);
    out.b -= w * (*without)[i].Ab(set);
  }
  return out;
}

}  // namespace

RowSquares& RowSquares::operator+=(const RowSquares& other) {
  if (AA.size() == 0) return *this = other;
  AA += other.AA;
  Ab += other.Ab;
  bb += other.bb;
  rows += other.rows;
  return *this;
}

LoadRows::LoadRows(const std::vector<CompressedRecording>& recordings, const std::vector<std::string>& columns, int joints)
    : total_(static_cast<size_t>(joints)) {
  for (const CompressedRecording& recording : recordings) {
    for (const auto& block : recording.blocks) {
      std::vector<RowSquares> own;
      for (const SquareRootInformation& factor : block) {
        const SquareRootInformation mine = factor.restricted(columns);
        const MatrixXd R = mine.R();
        own.push_back({R.transpose() * R, R.transpose() * mine.z(), mine.rhs_norm2(), mine.rows()});
      }
      for (size_t i = 0; i < own.size(); ++i) total_[i] += own[i];
      clusters_.push_back(std::move(own));
    }
  }
}

MatrixXd solve_scaled(const MatrixXd& A, const MatrixXd& b) {
  if (A.rows() == 0) return b;
  const VectorXd s = A.diagonal().cwiseMax(kTiny).cwiseSqrt().cwiseInverse();
  MatrixXd scaled = s.asDiagonal() * A * s.asDiagonal();
  scaled.diagonal().array() += kRidge;
  return s.asDiagonal() * Eigen::LDLT<MatrixXd>(scaled).solve(s.asDiagonal() * b);
}

InertialParameters PlacedMass::phi() const { return mass * unit_mass_parameters(com); }

PlacedMass MassCost::at(double mass, const Eigen::Vector3d& com) const {
  const Row10 phi = mass * unit_mass_parameters(com);
  return {mass, com, phi.dot(A_ * phi) - 2.0 * b_.dot(phi) + com.squaredNorm() / (reach_ * reach_)};
}

// Levenberg and Marquardt.
PlacedMass MassCost::descend(PlacedMass best, bool mass_is_free) const {
  double damping = kFirstDamping;
  for (int step = 0; step < kSteps; ++step) {
    const Slopes J = derivatives_of_placed_mass(best.mass, best.com);
    Eigen::Matrix4d H = J.transpose() * A_ * J;
    Eigen::Vector4d g = J.transpose() * (b_ - A_ * (best.mass * unit_mass_parameters(best.com)));
    H.diagonal().tail<3>().array() += 1.0 / (reach_ * reach_);
    g.tail<3>() -= best.com / (reach_ * reach_);
    if (!mass_is_free) {
      H.row(0).setZero();
      H.col(0).setZero();
      H(0, 0) = 1.0;
      g[0] = 0.0;
    }
    H.diagonal() += damping * H.diagonal();
    const Eigen::Vector4d d = solve_scaled(H, g);
    const double mass = std::clamp(best.mass + d[0], -kHeaviestLoad, kHeaviestLoad);
    const Eigen::Vector3d com = (best.com + d.tail<3>()).cwiseMin(reach_).cwiseMax(-reach_);
    const PlacedMass next = at(mass, com);
    if (!(next.cost < best.cost)) {
      damping *= kMoreDamping;
      if (damping > kMostDamping) break;
      continue;
    }
    const bool small = best.cost - next.cost < kConverged * std::abs(next.cost);
    best = next;
    damping = std::max(damping * kLessDamping, kLeastDamping);
    if (small) break;
  }
  return best;
}

PlacedMass MassCost::fit() const {
  std::vector<Eigen::Vector3d> places = {Eigen::Vector3d::Zero()};
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {1.0, -1.0}) places.push_back(side * kStartPlace * reach_ * Eigen::Vector3d::Unit(axis));
  }
  const Eigen::Vector3d moment = solve_scaled(A_.block(1, 1, 3, 3), b_.segment(1, 3));
  for (const double mass : kStartMasses) {
    for (const double side : {1.0, -1.0}) places.push_back((side * moment / mass).cwiseMin(reach_).cwiseMax(-reach_));
  }
  PlacedMass best;
  for (const Eigen::Vector3d& place : places) {
    const Row10 p = unit_mass_parameters(place);
    const double mass = b_.dot(p) / std::max(p.dot(A_ * p), kTiny);
    const PlacedMass end = descend(at(std::clamp(mass, -kHeaviestLoad, kHeaviestLoad), place), true);
    if (end.cost < best.cost) best = end;
  }
  return best;
}

PlacedMass MassCost::fit(const PlacedMass& near) const { return descend(at(near.mass, near.com), true); }

PlacedMass MassCost::with_mass(double mass, const PlacedMass& near) const {
  const Eigen::Vector3d same_moment = (near.mass / mass * near.com).cwiseMin(reach_).cwiseMax(-reach_);
  const PlacedMass a = descend(at(mass, near.com), false), b = descend(at(mass, same_moment), false);
  return a.cost < b.cost ? a : b;
}

std::pair<double, double> MassCost::masses_below(double cost, const PlacedMass& best) const {
  const auto end = [&](double from, double to, PlacedMass near) {  // `from` satisfies the bound, `to` does not
    for (int k = 0; k < kBisections; ++k) {
      const double middle = 0.5 * (from + to);
      const PlacedMass there = with_mass(middle, near);
      if (there.cost <= cost) {
        from = middle;
        near = there;
      } else {
        to = middle;
      }
    }
    return from;
  };
  // Extends the interval from a mass away from zero.
  const auto outwards = [&](double mass, PlacedMass near) {
    while (std::abs(mass) < kHeaviestLoad) {
      const double next = std::clamp(kGrowth * mass, -kHeaviestLoad, kHeaviestLoad);
      const PlacedMass there = with_mass(next, near);
      if (there.cost > cost) return end(mass, next, near);
      mass = next;
      near = there;
    }
    return mass;
  };
  const double outer = outwards(best.mass, best);
  double inner = best.mass;
  PlacedMass near = best;
  while (std::abs(inner) > kNearZero * std::abs(best.mass)) {
    const double next = inner / kGrowth;
    const PlacedMass there = with_mass(next, near);
    if (there.cost > cost) {
      inner = end(inner, next, near);
      return std::minmax(inner, outer);
    }
    inner = next;
    near = there;
  }
  // Zero satisfies the bound, so that masses of the other sign may satisfy it too.
  const double across = -kNearZero * best.mass;
  const PlacedMass there = with_mass(across, {-near.mass, near.com, 0.0});
  inner = there.cost > cost ? 0.0 : outwards(across, there);
  return std::minmax(inner, outer);
}

Eigen::Matrix4d MassCost::covariance(const PlacedMass& at) const {
  const Slopes J = derivatives_of_placed_mass(at.mass, at.com);
  Eigen::Matrix4d H = J.transpose() * A_ * J;
  H.diagonal().tail<3>().array() += 1.0 / (reach_ * reach_);
  return solve_scaled(H, Eigen::Matrix4d::Identity());
}

std::array<bool, 3> MassCost::determined_axes(const PlacedMass& at) const {
  const Eigen::Matrix4d C = covariance(at);
  std::array<bool, 3> out{};
  for (int k = 0; k < 3; ++k) out[k] = C(k + 1, k + 1) < kSeen * kSeen * reach_ * reach_;
  return out;
}

bool MassCost::at_bound(const PlacedMass& at) const {
  return at.com.cwiseAbs().maxCoeff() >= kAtBound * reach_ || std::abs(at.mass) >= kAtBound * kHeaviestLoad;
}

Eigen::Matrix<double, 6, 1> MassCost::inertia_beyond_point_mass(const PlacedMass& at) const {
  MatrixXd A = A_.bottomRightCorner(6, 6);
  A.diagonal() *= 1.0 + kUndeterminedRidge;  // makes undetermined directions zero
  return solve_scaled(A, VectorXd((b_ - A_ * at.phi()).tail(6)));
}

MassCost load_cost(const std::vector<RowSquares>& rows, const std::vector<RowSquares>* without, const VectorXd& weights,
                   int first, const std::vector<int>& beside, double reach) {
  const Weighted sums = normal_equations_of(rows, without, weights, first, beside);
  const Eigen::Index n = sums.b.size() - kBodyParameters;
  MatrixXd A = sums.A.topLeftCorner(kBodyParameters, kBodyParameters);
  VectorXd b = sums.b.head(kBodyParameters);
  if (n > 0) {
    const MatrixXd C = sums.A.topRightCorner(kBodyParameters, n);
    const MatrixXd N = sums.A.bottomRightCorner(n, n);
    A -= C * solve_scaled(N, C.transpose());
    b -= C * solve_scaled(N, sums.b.tail(n));
  }
  return {std::move(A), std::move(b), reach};
}

VectorXd fitted_beside_load(const std::vector<RowSquares>& rows, const std::vector<RowSquares>* without, const VectorXd& weights,
                     int first, const std::vector<int>& beside, const InertialParameters& phi) {
  const Weighted sums = normal_equations_of(rows, without, weights, first, beside);
  const Eigen::Index n = sums.b.size() - kBodyParameters;
  return solve_scaled(sums.A.bottomRightCorner(n, n), VectorXd(sums.b.tail(n) - sums.A.bottomLeftCorner(n, kBodyParameters) * phi));
}

VectorXd residual_squares(const std::vector<RowSquares>& rows, int first, const InertialParameters& phi,
                      const std::vector<int>& beside, const VectorXd& values) {
  std::vector<int> set;
  for (int c = 0; c < kBodyParameters; ++c) set.push_back(first + c);
  set.insert(set.end(), beside.begin(), beside.end());
  VectorXd x(static_cast<Eigen::Index>(set.size()));
  x << phi, values;
  VectorXd out(static_cast<Eigen::Index>(rows.size()));
  for (size_t i = 0; i < rows.size(); ++i) {
    const double left = rows[i].bb - 2.0 * x.dot(rows[i].Ab(set)) + x.dot(rows[i].AA(set, set) * x);
    out[static_cast<Eigen::Index>(i)] = std::max(left, 0.0);
  }
  return out;
}

}  // namespace veridyn
