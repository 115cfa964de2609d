#include "hand_eye_fit.hpp"

#include <fmt/format.h>

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "deviations.hpp"
#include "least_squares.hpp"

namespace veridyn::internal {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using RowMajor3 = Eigen::Matrix<double, 3, 6, Eigen::RowMajor>;

constexpr double kLeastNoise = 1e-9;  // [m], [rad] lower bound of the noise
constexpr double kHuber = 2.5;        // standard deviations, of a residual of three components
constexpr double kOutlier = 5.0;      // standard deviations beyond which a pair is an outlier
constexpr int kRounds = 4;            // fits, each with the noise estimated by the previous one
constexpr double kNarrow = 0.01;  // width per length below which points count as collinear

// Robust fit of A_k X = Y B_k in one of its forms.
class PairProblem {
 public:
  PairProblem(const Isometries& A, const Isometries& B, HandEyeForm form)
      : A_(A), B_(B), form_(form), oriented_(form != HandEyeForm::kCommonPoints) {
    if (form == HandEyeForm::kEyeInHand) {
      for (Isometry3d& T : B_) T = T.inverse();
    }
  }

  PairFit fit() {
    set_initial_poses();
    update_residuals();
    out_.is_outlier.assign(A_.size(), 0);
    for (int round = 0; round < kRounds; ++round) {
      solve(round + 1 == kRounds ? 0.0 : kHuber);
      update_residuals();
      if (round + 2 == kRounds) mark_outliers();
    }
    return std::move(out_);
  }

 private:
  // True if X is unknown and independent of Y.
  bool has_second_pose() const {
    return form_ == HandEyeForm::kTwoBases || form_ == HandEyeForm::kEyeInHand;
  }
  bool is_hand_eye() const { return form_ == HandEyeForm::kHandEye; }

  // Sets X and Y from closed forms.
  void set_initial_poses() {
    if (has_second_pose() || is_hand_eye()) {
      const HandAndWorld both = hand_and_world(A_, B_);
      out_.Y = both.Y;
      out_.X = both.X;
      if (is_hand_eye()) out_.X = out_.Y = solve_hand_eye(A_, B_);
      return;
    }
    const auto n = static_cast<Eigen::Index>(A_.size());
    MatrixXd a(3, n);
    MatrixXd b(3, n);
    Matrix3d sum = Matrix3d::Zero();
    for (Eigen::Index k = 0; k < n; ++k) {
      const auto at = static_cast<std::size_t>(k);
      a.col(k) = A_[at].translation();
      b.col(k) = B_[at].translation();
      sum += A_[at].linear() * B_[at].linear().transpose();
    }
    out_.Y = fitted_pose(b, a);
    if (!oriented_) return;
    out_.Y.linear() = nearest_rotation(sum);
    out_.Y.translation() = a.rowwise().mean() - out_.Y.linear() * b.rowwise().mean();
  }

  Vector3d position_error(std::size_t k) const {
    return A_[k] * out_.X.translation() - out_.Y * B_[k].translation();
  }

  Vector3d rotation_error(std::size_t k) const {
    return rotation_vector((out_.Y.linear() * B_[k].linear()).transpose() * A_[k].linear() *
                           out_.X.linear());
  }

  // Recomputes the residuals and the noise [m], [rad] from them.
  void update_residuals() {
    std::vector<double> lengths;
    std::vector<double> angles;
    out_.residuals.clear();
    for (std::size_t k = 0; k < A_.size(); ++k) {
      out_.residuals.push_back(position_error(k));
      lengths.push_back(out_.residuals.back().norm());
      angles.push_back(oriented_ ? rotation_error(k).norm() : 0.0);
    }
    out_.noise = std::max(kLeastNoise, robust_deviation_of_lengths(lengths));
    out_.noise_angle = std::max(kLeastNoise, robust_deviation_of_lengths(angles));
    out_.angles = angles;
  }

  void mark_outliers() {
    for (std::size_t k = 0; k < A_.size(); ++k) {
      const bool far = out_.residuals[k].norm() > kOutlier * std::sqrt(3.0) * out_.noise;
      const bool turned =
          oriented_ && out_.angles[k] > kOutlier * std::sqrt(3.0) * out_.noise_angle;
      out_.is_outlier[k] = far || turned ? 1 : 0;
    }
  }

  // Updates X and Y by least squares with Huber's loss; with huber = 0, squares, and their covariances too.
  void solve(double huber) {
    LeastSquares problem;
    const int Y = problem.add_unknown(VectorXd::Zero(6));
    const int X = has_second_pose() ? problem.add_unknown(VectorXd::Zero(6)) : -1;
    const Isometry3d X0 = out_.X;
    const Isometry3d Y0 = out_.Y;
    for (std::size_t k = 0; k < A_.size(); ++k) {
      if (out_.is_outlier[k] != 0) continue;
      std::vector<int> unknowns = {Y};
      if (has_second_pose()) unknowns.push_back(X);
      problem.add({unknowns, 3, position_residual(k, X0, Y0), huber, true});
      if (oriented_) problem.add({unknowns, 3, rotation_residual(k, X0, Y0), huber, true});
    }
    problem.minimise();
    out_.Y = moved_pose(Y0, problem.value(Y).data());
    if (has_second_pose()) out_.X = moved_pose(X0, problem.value(X).data());
    if (is_hand_eye()) out_.X = out_.Y;
    if (huber > 0.0) return;
    const Information information(problem);
    double chi2 = 0.0;
    for (const Observation& o : problem.observations()) chi2 += problem.residual(o).squaredNorm();
    out_.degrees_of_freedom = std::max(1.0, 1.0 * information.residuals() - information.unknowns());
    const double scale = chi2 / out_.degrees_of_freedom;
    MatrixXd pick = MatrixXd::Zero(6, problem.shared_size());
    pick.leftCols<6>().setIdentity();
    out_.covariance_Y = scale * information.covariance(pick);
    if (!has_second_pose()) return;
    pick.setZero();
    pick.rightCols<6>().setIdentity();
    out_.covariance_X = scale * information.covariance(pick);
  }

  // Applies the unknowns, a rotation vector and a translation, to a pose: R exp(w), t + v.
  static Isometry3d moved_pose(const Isometry3d& T, const double* x) {
    Isometry3d out = T;
    out.linear() = T.linear() * rotation_of(Eigen::Map<const Vector3d>(x));
    out.translation() += Eigen::Map<const Vector3d>(x + 3);
    return out;
  }

  // A t_X + t_A - R_Y t_B - t_Y, per standard deviation.
  Residual position_residual(std::size_t k, const Isometry3d& X0, const Isometry3d& Y0) const {
    const double weight = 1.0 / out_.noise;
    const bool free_X = has_second_pose();
    const bool one = is_hand_eye();
    return [=, &A = A_[k], &B = B_[k]](const double* const* x, double* r, double* const* J) {
      const Isometry3d Y = moved_pose(Y0, x[0]);
      const Isometry3d X = one ? Y : free_X ? moved_pose(X0, x[1]) : X0;
      const Vector3d error = A * X.translation() - Y * B.translation();
      Eigen::Map<Vector3d> out(r);
      out = weight * error;
      if (J == nullptr) return;
      if (J[0] != nullptr) {
        Eigen::Map<RowMajor3> J_Y(J[0]);
        const Vector3d w = Eigen::Map<const Vector3d>(x[0]);
        J_Y << weight * Y.linear() * cross_matrix(B.translation()) * right_jacobian(w),
            -weight * Matrix3d::Identity();
        if (one) J_Y.rightCols<3>() += weight * A.linear();
      }
      if (!free_X || J[1] == nullptr) return;
      Eigen::Map<RowMajor3> J_X(J[1]);
      J_X << Matrix3d::Zero(), weight * A.linear();
    };
  }

  // log((R_Y R_B)' R_A R_X), per standard deviation.
  Residual rotation_residual(std::size_t k, const Isometry3d& X0, const Isometry3d& Y0) const {
    const double weight = 1.0 / out_.noise_angle;
    const bool free_X = has_second_pose();
    const bool one = is_hand_eye();
    return [=, &A = A_[k], &B = B_[k]](const double* const* x, double* r, double* const* J) {
      const Isometry3d Y = moved_pose(Y0, x[0]);
      const Isometry3d X = one ? Y : free_X ? moved_pose(X0, x[1]) : X0;
      const Vector3d phi = rotation_vector((Y.linear() * B.linear()).transpose() * A.linear() *
                                           X.linear());
      Eigen::Map<Vector3d> out(r);
      out = weight * phi;
      if (J == nullptr) return;
      const Matrix3d by_X = left_jacobian_inverse(-phi);
      if (J[0] != nullptr) {
        Eigen::Map<RowMajor3> J_Y(J[0]);
        J_Y.setZero();
        const Matrix3d right = right_jacobian(Eigen::Map<const Vector3d>(x[0]));
        J_Y.leftCols<3>() =
            -weight * left_jacobian_inverse(phi) * B.linear().transpose() * right;
        if (one) J_Y.leftCols<3>() += weight * by_X * right;
      }
      if (!free_X || J[1] == nullptr) return;
      Eigen::Map<RowMajor3> J_X(J[1]);
      J_X.setZero();
      J_X.leftCols<3>() = weight * by_X * right_jacobian(Eigen::Map<const Vector3d>(x[1]));
    };
  }

  Isometries A_, B_;
  HandEyeForm form_;
  bool oriented_;
  PairFit out_;
};

// Reason why this form is not identifiable from these poses, or empty.
std::string unidentifiable_reason(const Isometries& A, HandEyeForm form, double smallest_swing) {
  const bool common = form == HandEyeForm::kCommonPoses || form == HandEyeForm::kCommonPoints;
  const std::size_t needed = common ? 3 : 4;
  if (A.size() < needed)
    return fmt::format("too few pairs: {} of poses, and {} or more are needed", A.size(), needed);
  if (form == HandEyeForm::kCommonPoints) {
    MatrixXd a(3, static_cast<Eigen::Index>(A.size()));
    for (std::size_t k = 0; k < A.size(); ++k)
      a.col(k) = A[k].translation();
    a.colwise() -= VectorXd(a.rowwise().mean());
    const VectorXd s = Eigen::JacobiSVD<MatrixXd>(a).singularValues();
    if (s[1] < std::max(1e-6, kNarrow * s[0]))
      return "the points lie on one line: a point beside it is missing";
  }
  if (common) return "";
  const RotationSpread spread = rotation_spread(A);
  const double most = std::sqrt(spread.eigenvalues[1]) / kDegree;
  const double least = std::sqrt(spread.eigenvalues[0]) / kDegree;
  if (most < smallest_swing)
    return fmt::format("the poses hardly turn ({:.2g} deg rms): turns about two axes are missing",
                       most);
  if (least < smallest_swing)
    return fmt::format(
        "the poses turn about one axis only ({:.3g} deg rms about it, {:.2g} deg across): turns "
        "about a second axis are missing",
        most, least);
  return "";
}

}  // namespace

PairFit fit_pairs(const Isometries& A, const Isometries& B, HandEyeForm form,
                  double smallest_swing) {
  PairFit none;
  none.reason = unidentifiable_reason(A, form, smallest_swing);
  if (!none.reason.empty()) return none;
  return PairProblem(A, B, form).fit();
}

}  // namespace veridyn::internal
