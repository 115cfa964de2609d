#include "hide_and_seek/visibility.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace veridyn::seek {
namespace {

constexpr Eigen::Index kStride = 20;  // 10 Hz
constexpr double kBand = 5.0;         // [Hz]
constexpr double kInBand = 0.40;      // share of the sensors' noise power below it
constexpr double kDoubt = 4.0;        // standard deviations: a probability of 1 / 16,000
// Samples at 10 Hz count for so many independent ones: the correlation of the coloured half of the
// noise (2 Hz) from one to the next is r = exp(-2 pi 0.2) = 0.28, and (1 - r) / (1 + r) = 0.56.
constexpr double kIndependent = 0.56;

bool has_term(const Model& robot, const char* effect, int joint) {
  return std::any_of(robot.effects().begin(), robot.effects().end(), [&](const EffectTerm& t) {
    return t.effect == effect && t.axis.coefficients[joint] == 1.0;
  });
}

// Hann window of the length whose gain is one half near the band's end.
MatrixXd low_passed(const MatrixXd& signal) {
  const auto half = static_cast<Eigen::Index>(kRate / kBand / 2.0);
  MatrixXd out = signal;
  for (Eigen::Index r = 0; r < signal.rows(); ++r) {
    Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(signal.cols());
    double weights = 0.0;
    for (Eigen::Index k = -half; k <= half; ++k) {
      if (r + k < 0 || r + k >= signal.rows()) continue;
      const double w =
          0.5 + 0.5 * std::cos(M_PI * static_cast<double>(k) / static_cast<double>(half + 1));
      sum += w * signal.row(r + k);
      weights += w;
    }
    out.row(r) = sum / weights;
  }
  return out;
}

// Torque that the bench's own parameters predict at a recorded row.
VectorXd predicted(const Bench& bench, const IdealRecording& ideal, Eigen::Index r) {
  const VectorXd dq = ideal.rows.dq.row(r);
  const VectorXd q = ideal.q.row(r);
  const bool known = ideal.nominal && ideal.q.row(r) == ideal.rows.q.row(r);
  VectorXd tau = known ? VectorXd(ideal.rigid.row(r))
                       : bench.arm.torque(q, dq, ideal.rows.ddq.row(r).transpose());
  for (int i = 0; i < bench.arm.joints; ++i) {
    const JointFriction& f = bench.friction[i];
    tau[i] += f.viscous * dq[i] + f.coulomb * direction(dq[i]) + f.offset;
  }
  return tau;
}

// What the causes add to the recorded torques, at the kept rows and without what a filter removes.
MatrixXd hidden_torque(const Bench& bench, const IdealRecording& ideal,
                       const std::vector<Eigen::Index>& kept) {
  MatrixXd out(kept.size(), bench.arm.joints);
  if (ideal.nominal && ideal.q == ideal.rows.q) {
    MatrixXd all = ideal.tau;
    for (Eigen::Index r = 0; r < all.rows(); ++r) all.row(r) -= predicted(bench, ideal, r);
    out = low_passed(all)(kept, Eigen::all);
    return out;
  }
  for (size_t k = 0; k < kept.size(); ++k)  // smooth, and dear
    out.row(k) =
        ideal.tau.row(kept[k]) - predicted(bench, ideal, kept[k]).transpose();
  return out;
}

// Rows of all joints below one another: bodies, then friction of every joint.
MatrixXd fitted_columns(const Bench& bench, const IdealRecording& ideal,
                        const std::vector<Eigen::Index>& kept) {
  const int n = bench.arm.joints;
  std::vector<MatrixXd> rows;
  for (const Eigen::Index r : kept) {
    const VectorXd dq = ideal.rows.dq.row(r);
    const MatrixXd Y =
        bench.arm.regressor(ideal.q.row(r).transpose(), dq, ideal.rows.ddq.row(r).transpose());
    MatrixXd A = MatrixXd::Zero(n, Y.cols() + 3 * n);
    A.leftCols(Y.cols()) = Y;
    for (int i = 0; i < n; ++i) {
      const Eigen::Index at = Y.cols() + 3 * i;
      if (has_term(bench.robot, "viscous_friction", i)) A(i, at) = dq[i];
      if (has_term(bench.robot, "coulomb_friction", i)) A(i, at + 1) = direction(dq[i]);
      if (has_term(bench.robot, "torque_offset", i)) A(i, at + 2) = 1.0;
    }
    rows.push_back(std::move(A));
  }
  MatrixXd out(static_cast<Eigen::Index>(rows.size()) * n, rows.front().cols());
  for (size_t k = 0; k < rows.size(); ++k)
    out.middleRows(static_cast<Eigen::Index>(k) * n, n) = rows[k];
  return out;
}

// The part of b outside of the span of the columns of A.
VectorXd left_over(MatrixXd A, const VectorXd& b) {
  for (Eigen::Index c = 0; c < A.cols(); ++c) A.col(c) /= std::max(A.col(c).norm(), 1e-12);
  Eigen::ColPivHouseholderQR<MatrixXd> qr(A);
  qr.setThreshold(1e-7);
  return b - A * qr.solve(b);
}

}  // namespace

Visibility visibility(const Bench& bench, const std::vector<IdealRecording>& ideal, bool absorb) {
  const int n = bench.arm.joints;
  VectorXd power = VectorXd::Zero(n);
  std::vector<MatrixXd> columns;
  std::vector<MatrixXd> hidden;
  Eigen::Index count = 0;
  for (const IdealRecording& one : ideal) {
    std::vector<Eigen::Index> kept;
    for (Eigen::Index r = 0; r < one.tau.rows(); r += kStride) kept.push_back(r);
    hidden.push_back(hidden_torque(bench, one, kept));
    if (absorb) columns.push_back(fitted_columns(bench, one, kept));
    power += one.tau.colwise().squaredNorm().transpose() / static_cast<double>(one.tau.rows());
    count += static_cast<Eigen::Index>(kept.size());
  }
  const VectorXd torque = (power / static_cast<double>(ideal.size())).cwiseSqrt();
  VectorXd noise(n);
  for (int i = 0; i < n; ++i)
    noise[i] = std::sqrt(kInBand) * bench.sensors[i].torque_noise * torque[i];
  VectorXd b(count * n);
  MatrixXd A(absorb ? count * n : 0, absorb ? columns.front().cols() : 0);
  Eigen::Index at = 0;
  for (size_t f = 0; f < hidden.size(); ++f) {
    for (Eigen::Index r = 0; r < hidden[f].rows(); ++r) {
      for (int i = 0; i < n; ++i, ++at) {
        b[at] = hidden[f](r, i) / noise[i];
        if (absorb) A.row(at) = columns[f].row(r * n + i) / noise[i];
      }
    }
  }
  const VectorXd rest = absorb ? left_over(A, b) : b;
  Visibility out;
  out.share = b.norm() > 0.0 ? rest.norm() / b.norm() : 0.0;
  for (int i = 0; i < n; ++i) {
    const VectorXd mine = rest(Eigen::seqN(i, count, n));
    const double square = mine.squaredNorm() / static_cast<double>(count);
    out.residue.push_back(std::sqrt(square) * noise[i] / torque[i]);
    out.best_gain += std::log1p(square);
    out.oracle_t += kIndependent * mine.squaredNorm();
  }
  out.oracle_t = std::sqrt(out.oracle_t);
  out.beyond_doubt = out.oracle_t >= kDoubt;
  return out;
}

}  // namespace veridyn::seek
