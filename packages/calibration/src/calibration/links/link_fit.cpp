#include "calibration/links/link_fit.hpp"

#include <algorithm>
#include <cmath>

#include "calibration/deviations.hpp"
#include "calibration/least_squares.hpp"

namespace veridyn::internal {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kHuber = 2.5;       // standard deviations, of a residual of three components
constexpr double kLeastNoise = 1e-9; // [m], [rad] lower bound of the noise
constexpr int kRounds = 3;

using Rows = Eigen::Matrix<double, 6, 1>;

// Rotation vector [rad], zero if not oriented, and translation [m] from the measured pose to the model's.
Rows error_of(const Isometry3d& model, const Isometry3d& measured, bool oriented) {
  Rows e = Rows::Zero();
  if (oriented)
    e.head<3>() = rotation_vector(measured.linear().transpose() * model.linear());
  e.tail<3>() = model.translation() - measured.translation();
  return e;
}

// Converts J from the derivative of the pose to that of error_of(), which is e.
void convert_to_error_derivative(const Rows& e, const Isometry3d& measured, MatrixXd& J) {
  const Matrix3d L =
      left_jacobian_inverse(e.head<3>()) * measured.linear().transpose();
  J.topRows<3>() = (L * J.topRows<3>()).eval();
}

// A copy of x in which entry active[k] is values[k].
VectorXd with_active_values(const VectorRef& x, const std::vector<int>& active, const double* values) {
  VectorXd out = x;
  for (std::size_t k = 0; k < active.size(); ++k) out[active[k]] = values[k];
  return out;
}

}  // namespace

VectorXd fitted_links(LinkChain& chain, const LinkData& data, const std::vector<int>& active,
                      const VectorRef& x, double huber) {
  if (active.empty()) return x;
  const VectorXd start = x;
  const bool oriented = data.poses->has_orientation;
  VectorXd values(active.size());
  for (std::size_t k = 0; k < active.size(); ++k)
    values[static_cast<Eigen::Index>(k)] = start[active[k]];
  LeastSquares problem;
  const int block = problem.add_unknown(values);
  const int size = oriented ? 6 : 3;
  for (const int row : data.rows) {
    if (data.is_outlier[row] != 0) continue;
    const Residual residual = [&, row](const double* const* v, double* r, double* const* J) {
      const VectorXd now = with_active_values(start, active, v[0]);
      if (now != chain.x()) chain.set(now);
      const Isometry3d& measured = data.poses->poses[row];
      const bool wanted = J != nullptr && J[0] != nullptr;
      MatrixXd by;
      const VectorXd q = data.poses->q.row(row);
      Rows e = error_of(chain.pose(q, wanted ? &by : nullptr), measured, oriented);
      Rows weight;
      weight << Vector3d::Constant(1.0 / data.noise.angle),
          Vector3d::Constant(1.0 / data.noise.position);
      if (wanted && oriented) convert_to_error_derivative(e, measured, by);
      for (int c = 0; c < size; ++c) {
        const int of = oriented ? c : c + 3;
        r[c] = weight[of] * e[of];
        if (!wanted) continue;
        for (std::size_t k = 0; k < active.size(); ++k)
          J[0][static_cast<std::size_t>(c) * active.size() + k] = weight[of] * by(of, active[k]);
      }
    };
    problem.add({{block}, size, residual, huber, true});
  }
  problem.minimise(1, 40);
  return with_active_values(start, active, problem.value(block).data());
}

VectorXd robustly_fitted_links(LinkChain& chain, LinkData& data, const std::vector<int>& active,
                               const VectorRef& x, double outlier) {
  VectorXd now = x;
  for (int round = 0; round <= kRounds; ++round) {
    const LinkErrors errors = link_errors(chain, data, now);
    data.noise.position =
        std::max(kLeastNoise, robust_deviation_of_lengths(errors.position));
    data.noise.angle = std::max(kLeastNoise, robust_deviation_of_lengths(errors.angle));
    for (std::size_t k = 0; k < data.rows.size(); ++k) {
      const bool far = errors.position[k] > outlier * std::sqrt(3.0) * data.noise.position;
      const bool turned = data.poses->has_orientation &&
                          errors.angle[k] > outlier * std::sqrt(3.0) * data.noise.angle;
      data.is_outlier[data.rows[k]] =
          round > 1 && (far || turned) ? 1 : 0;
    }
    if (round == kRounds) break;
    now = fitted_links(chain, data, active, now, round > 1 ? 0.0 : kHuber);
  }
  return now;
}

LinkErrors link_errors(LinkChain& chain, const LinkData& data, const VectorRef& x) {
  chain.set(x);
  LinkErrors out;
  for (const int row : data.rows) {
    const VectorXd q = data.poses->q.row(row);
    const Rows e = error_of(chain.pose(q, nullptr), data.poses->poses[row],
                            data.poses->has_orientation);
    out.angle.push_back(e.head<3>().norm());
    out.position.push_back(e.tail<3>().norm());
  }
  return out;
}

LinkNormal link_normal(LinkChain& chain, const LinkData& data, const VectorRef& x) {
  chain.set(x);
  const int p = chain.parameters().size();
  LinkNormal out{MatrixXd::Zero(p, p), VectorXd::Zero(p), 0.0, 0};
  const bool oriented = data.poses->has_orientation;
  MatrixXd J;
  for (const int row : data.rows) {
    if (data.is_outlier[row] != 0) continue;
    const Isometry3d& measured = data.poses->poses[row];
    const VectorXd q = data.poses->q.row(row);
    Rows e = error_of(chain.pose(q, &J), measured, oriented);
    if (oriented) convert_to_error_derivative(e, measured, J);
    J.topRows<3>() /= data.noise.angle;
    J.bottomRows<3>() /= data.noise.position;
    e.head<3>() /= data.noise.angle;
    e.tail<3>() /= data.noise.position;
    if (!oriented) J.topRows<3>().setZero();
    out.N.noalias() += J.transpose() * J;
    out.g.noalias() += J.transpose() * e;
    out.chi2 += e.squaredNorm();
    out.residuals += oriented ? 6 : 3;
  }
  return out;
}

double rms_of(const std::vector<double>& errors, const LinkData& data, bool with_outliers) {
  double sum = 0.0;
  double count = 0.0;
  for (std::size_t k = 0; k < errors.size(); ++k) {
    if (!with_outliers && data.is_outlier[data.rows[k]] != 0) continue;
    sum += errors[k] * errors[k];
    count += 1.0;
  }
  return count > 0.0 ? std::sqrt(sum / count) : 0.0;
}

void estimate_attached_poses(const Model& arm, FrameIndex frame, const PoseCapture& poses, bool base_free,
                 bool tool_free, Isometry3d& base, Isometry3d& tool) {
  base = Isometry3d::Identity();
  tool = Isometry3d::Identity();
  if (!base_free && !tool_free) return;
  const LinkParameters none(arm, frame, false, false, true);
  const LinkChain chain(none, base, tool);
  Isometries T;
  for (int k = 0; k < poses.frames(); ++k) T.push_back(chain.pose(poses.q.row(k), nullptr));
  const auto n = static_cast<Eigen::Index>(T.size());
  if (poses.has_orientation && base_free && tool_free) {
    // M tool^-1 = base T.
    const HandAndWorld both = hand_and_world(poses.poses, T);
    base = both.Y;
    tool = both.X.inverse();
    return;
  }
  if (poses.has_orientation) {
    Matrix3d sum = Matrix3d::Zero();
    Vector3d shift = Vector3d::Zero();
    for (std::size_t k = 0; k < T.size(); ++k)
      sum += base_free ? Matrix3d(poses.poses[k].linear() * T[k].linear().transpose())
                       : Matrix3d(T[k].linear().transpose() * poses.poses[k].linear());
    Isometry3d& one = base_free ? base : tool;
    one.linear() = nearest_rotation(sum);
    for (std::size_t k = 0; k < T.size(); ++k) {
      const Isometry3d left = base_free ? poses.poses[k] * T[k].inverse()
                                        : T[k].inverse() * poses.poses[k];
      shift += left.translation() / static_cast<double>(n);
    }
    one.translation() = shift;
    return;
  }
  // R' p - R_k t - o_k - R' b = 0: linear in R' (row by row), t and R' b.
  MatrixXd A = MatrixXd::Zero(3 * n, 15);
  VectorXd b(3 * n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const auto at = static_cast<std::size_t>(k);
    for (int c = 0; c < 3; ++c)
      A.block<1, 3>(3 * k + c, 3 * c) = poses.poses[at].translation().transpose();
    A.block<3, 3>(3 * k, 9) = -T[at].linear();
    A.block<3, 3>(3 * k, 12) = -Matrix3d::Identity();
    b.segment<3>(3 * k) = T[at].translation();
  }
  if (!base_free) {
    Vector3d shift = Vector3d::Zero();
    for (std::size_t k = 0; k < T.size(); ++k)
      shift += T[k].inverse() * poses.poses[k].translation() / static_cast<double>(n);
    tool.translation() = shift;
    return;
  }
  if (!tool_free) {
    MatrixXd from(3, n);
    MatrixXd to(3, n);
    for (Eigen::Index k = 0; k < n; ++k) {
      from.col(k) = T[k].translation();
      to.col(k) = poses.poses[k].translation();
    }
    base = fitted_pose(from, to);
    return;
  }
  const VectorXd x = A.completeOrthogonalDecomposition().solve(b);
  Matrix3d R_transposed;
  R_transposed << x.segment<3>(0).transpose(), x.segment<3>(3).transpose(),
      x.segment<3>(6).transpose();
  base.linear() = nearest_rotation(R_transposed).transpose();
  tool.translation() = x.segment<3>(9);
  Vector3d shift = Vector3d::Zero();
  for (std::size_t k = 0; k < T.size(); ++k)
    shift += (poses.poses[k].translation() - base.linear() * (T[k] * tool.translation())) /
             static_cast<double>(n);
  base.translation() = shift;
}

}  // namespace veridyn::internal
