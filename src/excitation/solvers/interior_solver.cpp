// A primal-dual interior point in the notation of Nocedal and Wright, Numerical Optimization, 2006,
// sections 19.2 and 19.3. There are two bounds where the book has one:
//
//   minimise f(x)  subject to  c(x) - s = 0,  l <= s <= u                                      (1)
//
// with multipliers z_l, z_u >= 0 of the bounds. The conditions of optimality, perturbed by mu:
//
//   grad f(x) - A(x)' z = 0,  z = z_l - z_u                                                   (2a)
//   c(x) - s = 0                                                                              (2b)
//   z_l (s - l) = mu,  z_u (u - s) = mu                                                       (2c)
//
// Newton's step (p_x, p_s, p_z) of (2), with a quasi-Newton matrix B for the Hessian of
// f(x) - z' c(x). Everything but p_x is eliminated, which leaves a matrix of the size of x:
//
//   Sigma = z_l / (s - l) + z_u / (u - s)                                                     (3a)
//   (B + A' Sigma A) p_x = -grad f + A' (mu / (s - l) - mu / (u - s) - Sigma (c - s))         (3b)
//   p_s = A p_x + c - s                                                                       (3c)
//   z_l + p_zl = (mu - z_l p_s) / (s - l),  z_u + p_zu = (mu + z_u p_s) / (u - s)             (3d)
//
// Steps keep the share 1 - tau of every distance to a bound (the fraction to the boundary):
//
//   alpha_s = max{alpha <= 1 : s + alpha p_s - l >= (1 - tau) (s - l), and so for u - s, z     (4)
//
// and halve alpha until the merit function
//
//   phi(x, s) = f - mu sum log(s - l) - mu sum log(u - s) + nu |c - s|_1                      (5)
//
// has decreased by the share eta of what its slope predicts. The penalty nu is large enough for the
// slope to be negative (18.36 of the book):
//
//   nu >= (grad f' p_x + slope of the logarithms + p_x' B p_x / 2) / ((1 - rho) |c - s|_1)    (6)

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "excitation/solvers/nonlinear_program.hpp"
#include "excitation/solvers/sparse_rows.hpp"

namespace veridyn {
namespace {

constexpr double kFirstMu = 1e-2;
constexpr double kMuShrinks = 0.9;  // factor of mu in every step with alpha > kLongStep
constexpr double kLongStep = 0.3;
constexpr double kTau = 0.99;
constexpr double kEta = 1e-4;
constexpr double kRho = 0.1;
constexpr int kHalvings = 12;
constexpr double kFirstStep = 0.1;   // length of p_x before any curvature is known
constexpr double kNearCentre = 1e4;  // z stays within this factor of mu / distance
constexpr int kPatience = 15;        // iterations in which f may decrease by less than kSmallGain
constexpr double kSmallGain = 3e-5;

// One side of l <= s <= u. Components without a bound have distance 1 and multiplier 0.
struct BoundSide {
  Eigen::ArrayXd exists;  // 1 if the component has a bound, else 0
  Eigen::ArrayXd bound;
  double sign;  // distance = sign (bound - s)
  Eigen::ArrayXd z{};
  Eigen::ArrayXd z_next{};  // z + p_z

  BoundSide(const VectorXd& limits, double direction)
      : exists(limits.array().isFinite().cast<double>()),
        bound(limits.array().isFinite().select(limits.array(), 0.0)),
        sign(direction) {}

  // Distance of s from the bounds; 1 where there is none.
  Eigen::ArrayXd distance(const VectorXd& s) const {
    return exists * (sign * (bound - s.array())) + (1.0 - exists);
  }
  double sum_of_logs(const VectorXd& s) const { return distance(s).log().sum(); }

  // Evaluates equation (4), for s and for z.
  double longest_step(const VectorXd& s, const VectorXd& p_s) const {
    return longest_fraction((exists * sign * p_s.array() / distance(s)).maxCoeff());
  }
  double longest_dual_step() const {
    return longest_fraction((exists * (z - z_next) / (z + (1.0 - exists))).maxCoeff());
  }

 private:
  // @param decrease  largest relative decrease in a full step.
  static double longest_fraction(double decrease) { return decrease > kTau ? kTau / decrease : 1.0; }
};

}  // namespace

void update_hessian(MatrixXd& B, const VectorXd& s_k, const VectorXd& y_k, bool first) {
  const double s_y = s_k.dot(y_k);
  if (first && s_y > 0.0) B.diagonal().setConstant(y_k.squaredNorm() / s_y);
  const VectorXd B_s = B * s_k;
  const double s_B_s = s_k.dot(B_s);
  if (!(s_B_s > 0.0)) return;
  const double theta = s_y < 0.2 * s_B_s ? 0.8 * s_B_s / (s_B_s - s_y) : 1.0;
  const VectorXd r_k = theta * y_k + (1.0 - theta) * B_s;
  B += r_k * r_k.transpose() / s_k.dot(r_k) - B_s * B_s.transpose() / s_B_s;
}

namespace {

class InteriorPoint {
 public:
  InteriorPoint(NonlinearProgram& program, const VectorXd& start, const SolverOptions& options)
      : program_(program),
        options_(options),
        n_(start.size()),
        m_(program.lower().size()),
        A_(program.pattern(), m_),
        lower_(program.lower(), -1.0),
        upper_(program.upper(), 1.0),
        x_(start) {}

  SolverResult run() {
    c_ = program_.constraints(x_);
    f_ = program_.objective(x_);
    evaluate_derivatives();
    start_slacks();
    B_ = first_hessian();
    SolverResult out;
    double best = f_;
    int idle = 0;
    bool first = true;
    for (; out.iterations < options_.iterations; ++out.iterations) {
      if (options_.stop && options_.stop()) break;
      if (error() < options_.tolerance) {
        out.converged = true;
        break;
      }
      if (!newton_step()) break;
      const VectorXd x_before = x_;
      const VectorXd z_next = (lower_.z_next - upper_.z_next).matrix();
      const VectorXd gradient_before = lagrangian_gradient(z_next);
      if (!line_search()) {
        if (first) break;
        B_ = first_hessian();
        first = true;
        continue;
      }
      update_hessian(B_, x_ - x_before, lagrangian_gradient(z_next) - gradient_before, first);
      first = false;
      const bool feasible = (c_ - s_).lpNorm<Eigen::Infinity>() < 1e-6;
      const bool better = f_ < best - kSmallGain * std::max(1.0, std::abs(best));
      if (better || !feasible || mu_ > 10.0 * least_mu()) idle = 0;
      if (feasible) best = std::min(best, f_);
      if (++idle > kPatience) {
        out.converged = true;
        break;
      }
    }
    out.x = x_;
    return out;
  }

 private:
  double least_mu() const { return 0.1 * options_.tolerance; }
  MatrixXd first_hessian() const {
    return MatrixXd::Identity(n_, n_) * std::max(1e-6, grad_f_.norm() / kFirstStep);
  }
  VectorXd lagrangian_gradient(const VectorXd& z) const {
    return grad_f_ - A_.transposed_times(z, n_);
  }

  void evaluate_derivatives() {
    grad_f_ = program_.gradient(x_);
    A_.set(program_.jacobian(x_));
  }

  // Sets s = c(x), moved inside the bounds by a hundredth of their distance; z from (2c).
  void start_slacks() {
    s_ = c_;
    for (Eigen::Index i = 0; i < m_; ++i) {
      const double l = program_.lower()[i];
      const double u = program_.upper()[i];
      const double edge = std::isfinite(u - l) ? 1e-2 * (u - l) : 1e-2;
      if (std::isfinite(l)) s_[i] = std::max(s_[i], l + edge);
      if (std::isfinite(u)) s_[i] = std::min(s_[i], u - edge);
    }
    for (BoundSide* side : {&lower_, &upper_})
      side->z = side->exists * mu_ / side->distance(s_);
  }

  // The residual of (2) with mu = 0 (19.10 of the book).
  double error() const {
    const VectorXd z = (lower_.z - upper_.z).matrix();
    return std::max({lagrangian_gradient(z).lpNorm<Eigen::Infinity>(),
                     (c_ - s_).lpNorm<Eigen::Infinity>(),
                     (lower_.z * lower_.distance(s_)).maxCoeff(),
                     (upper_.z * upper_.distance(s_)).maxCoeff()});
  }

  // Solves equations (3). False if the matrix is not numerically positive definite.
  bool newton_step() {
    const Eigen::ArrayXd s_l = lower_.distance(s_);
    const Eigen::ArrayXd u_s = upper_.distance(s_);
    const VectorXd Sigma = (lower_.z / s_l + upper_.z / u_s).matrix();
    const VectorXd centring = (mu_ * (lower_.exists / s_l - upper_.exists / u_s)).matrix();
    const VectorXd residual = c_ - s_;
    MatrixXd K = B_;
    A_.add_normal(Sigma, K);
    const Eigen::LLT<MatrixXd, Eigen::Lower> llt(K);
    if (llt.info() != Eigen::Success) return false;
    p_x_ = llt.solve(A_.transposed_times(centring - Sigma.cwiseProduct(residual), n_) - grad_f_);
    if (!p_x_.allFinite()) return false;
    p_s_ = A_.times(p_x_) + residual;
    lower_.z_next = lower_.exists * (mu_ - lower_.z * p_s_.array()) / s_l;
    upper_.z_next = upper_.exists * (mu_ + upper_.z * p_s_.array()) / u_s;
    return true;
  }

  // Evaluates equation (5).
  double merit(double f, const VectorXd& s, const VectorXd& c) const {
    return f - mu_ * (lower_.sum_of_logs(s) + upper_.sum_of_logs(s)) + nu_ * (c - s).lpNorm<1>();
  }

  // Raises nu_ to satisfy (6); returns the slope of the merit function along the step.
  double merit_slope() {
    const double infeasibility = (c_ - s_).lpNorm<1>();
    const double slope_of_logs = mu_ * (upper_.exists * p_s_.array() / upper_.distance(s_) -
                                        lower_.exists * p_s_.array() / lower_.distance(s_))
                                           .sum();
    const double slope = grad_f_.dot(p_x_) + slope_of_logs;
    if (infeasibility > 0.0) {
      const double needed =
          (slope + 0.5 * p_x_.dot(B_ * p_x_)) / ((1.0 - kRho) * infeasibility);
      if (needed > nu_) nu_ = 1.5 * needed;
    }
    return slope - nu_ * infeasibility;
  }

  bool line_search() {
    const double slope = merit_slope();
    const double phi = merit(f_, s_, c_);
    const double rounding = 1e-12 * std::max(1.0, std::abs(phi));
    double alpha = std::min(lower_.longest_step(s_, p_s_), upper_.longest_step(s_, p_s_));
    for (int k = 0; k < kHalvings; ++k, alpha *= 0.5) {
      const VectorXd x = x_ + alpha * p_x_;
      const VectorXd s = s_ + alpha * p_s_;
      const VectorXd c = program_.constraints(x);
      const double f = program_.objective(x);
      if (!(merit(f, s, c) <= phi + kEta * alpha * std::min(0.0, slope) + rounding)) continue;
      x_ = x;
      s_ = s;
      c_ = c;
      f_ = f;
      evaluate_derivatives();
      update_multipliers();
      if (alpha > kLongStep) mu_ = std::max(least_mu(), kMuShrinks * mu_);
      return true;
    }
    return false;
  }

  void update_multipliers() {
    for (BoundSide* side : {&lower_, &upper_}) {
      side->z += side->longest_dual_step() * (side->z_next - side->z);
      const Eigen::ArrayXd centre = side->exists * mu_ / side->distance(s_);
      side->z = side->z.max(centre / kNearCentre).min(centre * kNearCentre);
    }
  }

  NonlinearProgram& program_;
  const SolverOptions& options_;
  Eigen::Index n_, m_;  // variables and constraints
  SparseRows A_;        // Jacobian of c
  BoundSide lower_, upper_;
  double mu_ = kFirstMu;
  double nu_ = 1.0;
  VectorXd x_, s_, c_, grad_f_, p_x_, p_s_;
  double f_ = 0.0;
  MatrixXd B_;
};

}  // namespace

SolverResult solve_with_interior_point(NonlinearProgram& program, const VectorXd& start,
                                       const SolverOptions& options) {
  return InteriorPoint(program, start, options).run();
}

}  // namespace veridyn
