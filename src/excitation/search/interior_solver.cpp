#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "excitation/search/nonlinear_program.hpp"
#include "excitation/search/sparse_rows.hpp"

namespace veridyn {
namespace {

constexpr double kFirstBarrier = 1e-2;
constexpr double kBarrierShrinks = 0.9;  // with every step that is not
constexpr double kLongStep = 0.3;        // shorter than this share of the way
constexpr double kToTheEdge = 0.99;      // of the way to a bound, in one step
constexpr double kEnough = 1e-4;         // of the decrease that the slope promises
constexpr int kHalvings = 12;
constexpr double kFirstStep = 0.1;  // of the variables, before anything of the curvature is known
constexpr int kPatience = 15;       // iterations with hardly any gain
constexpr double kHardlyAny = 3e-5;

// One side of the bounds: the room that is left to them and the pressure on them; nothing where
// the bound is infinite.
struct Side {
  Eigen::ArrayXd there;  // 1 or 0
  Eigen::ArrayXd bound;
  double sign;  // room = sign (bound - s)
  Eigen::ArrayXd pressure{};

  Side(const VectorXd& limits, double direction)
      : there(limits.array().isFinite().cast<double>()),
        bound(limits.array().isFinite().select(limits.array(), 0.0)),
        sign(direction) {}
  // One where there is no bound.
  Eigen::ArrayXd room(const VectorXd& s) const {
    return there * (sign * (bound - s.array())) + (1.0 - there);
  }
  double log_room(const VectorXd& s) const { return room(s).log().sum(); }
  // The longest share of a step of s within kToTheEdge of the way.
  double longest(const VectorXd& s, const VectorXd& ds) const {
    const double speed = (there * sign * ds.array() / room(s)).maxCoeff();
    return speed > kToTheEdge ? kToTheEdge / speed : 1.0;
  }
};

// Powell's damped BFGS: stays positive definite whatever the curvature.
void learn(MatrixXd& H, const VectorXd& step, VectorXd change, bool first) {
  const double seen = step.dot(change);
  if (first && seen > 0.0) H.diagonal().setConstant(change.squaredNorm() / seen);
  const VectorXd Hs = H * step;
  const double expected = step.dot(Hs);
  if (!(expected > 0.0)) return;
  if (seen < 0.2 * expected) {
    const double share = 0.8 * expected / (expected - seen);
    change = share * change + (1.0 - share) * Hs;
  }
  const double curvature = step.dot(change);
  H += change * change.transpose() / curvature - Hs * Hs.transpose() / expected;
}

class InteriorPoint {
 public:
  InteriorPoint(NonlinearProgram& program, const VectorXd& start, const SolverOptions& options)
      : program_(program),
        options_(options),
        n_(start.size()),
        rows_(program.lower().size()),
        J_(program.pattern(), rows_),
        below_(program.lower(), -1.0),
        above_(program.upper(), 1.0),
        x_(start) {}

  SolverResult run() {
    look(x_);
    take_slacks();
    H_ = MatrixXd::Identity(n_, n_) * std::max(1e-6, g_.norm() / kFirstStep);
    SolverResult out;
    double best = f_;
    int idle = 0;
    bool fresh = true;
    for (; out.iterations < options_.iterations; ++out.iterations) {
      if (options_.stop && options_.stop()) break;
      if (error() < options_.tolerance) {
        out.converged = true;
        break;
      }
      if (!direction()) break;
      const VectorXd before = x_;
      const VectorXd multipliers = (above_next_ - below_next_).matrix();
      const VectorXd old_gradient = g_ + J_.transposed_times(multipliers, n_);
      if (!advance()) {
        if (fresh) break;
        H_ = MatrixXd::Identity(n_, n_) * std::max(1e-6, g_.norm() / kFirstStep);
        fresh = true;
        continue;
      }
      learn(H_, x_ - before, g_ + J_.transposed_times(multipliers, n_) - old_gradient, fresh);
      fresh = false;
      const bool held = (c_ - s_).lpNorm<Eigen::Infinity>() < 1e-6;
      const bool better = f_ < best - kHardlyAny * std::max(1.0, std::abs(best));
      if (better || !held || barrier_ > 10.0 * least_barrier()) idle = 0;
      if (held) best = std::min(best, f_);
      if (++idle > kPatience) {
        out.converged = true;
        break;
      }
    }
    out.x = x_;
    return out;
  }

 private:
  double least_barrier() const { return 0.1 * options_.tolerance; }
  // Of the bounds on the constraints: their multipliers.
  VectorXd pressure() const { return (above_.pressure - below_.pressure).matrix(); }

  void look(const VectorXd& x) {
    c_ = program_.constraints(x);
    f_ = program_.objective(x);
    g_ = program_.gradient(x);
    J_.set(program_.jacobian(x));
  }

  // Slacks: the constraints themselves, drawn a little into their bounds.
  void take_slacks() {
    s_ = c_;
    for (Eigen::Index r = 0; r < rows_; ++r) {
      const double low = program_.lower()[r];
      const double high = program_.upper()[r];
      const double edge = std::isfinite(high - low) ? 1e-2 * (high - low) : 1e-2;
      if (std::isfinite(low)) s_[r] = std::max(s_[r], low + edge);
      if (std::isfinite(high)) s_[r] = std::min(s_[r], high - edge);
    }
    below_.pressure = below_.there * barrier_ / below_.room(s_);
    above_.pressure = above_.there * barrier_ / above_.room(s_);
  }

  double error() const {
    const double slope = (g_ + J_.transposed_times(pressure(), n_)).lpNorm<Eigen::Infinity>();
    const double open = (c_ - s_).lpNorm<Eigen::Infinity>();
    const double left = std::max((below_.pressure * below_.room(s_)).maxCoeff(),
                                 (above_.pressure * above_.room(s_)).maxCoeff());
    return std::max({slope, open, left});
  }

  // Newton's step of the barrier problem, with everything but x eliminated.
  bool direction() {
    const Eigen::ArrayXd low = below_.room(s_);
    const Eigen::ArrayXd high = above_.room(s_);
    const VectorXd stiff = (below_.pressure / low + above_.pressure / high).matrix();
    const VectorXd push = (barrier_ * (above_.there / high - below_.there / low)).matrix();
    const VectorXd open = c_ - s_;
    MatrixXd A = H_;
    J_.add_normal(stiff, A);
    const Eigen::LLT<MatrixXd, Eigen::Lower> llt(A);
    if (llt.info() != Eigen::Success) return false;
    dx_ = -llt.solve(g_ + J_.transposed_times(stiff.cwiseProduct(open) + push, n_));
    if (!dx_.allFinite()) return false;
    ds_ = J_.times(dx_) + open;
    below_next_ = below_.there * (barrier_ - below_.pressure * ds_.array()) / low;
    above_next_ = above_.there * (barrier_ + above_.pressure * ds_.array()) / high;
    return true;
  }

  double merit(double f, const VectorXd& s, const VectorXd& c) const {
    return f - barrier_ * (below_.log_room(s) + above_.log_room(s)) +
           penalty_ * (c - s).lpNorm<1>();
  }

  // Along the direction, until the merit is smaller by what its slope promises.
  bool advance() {
    const double open = (c_ - s_).lpNorm<1>();
    const double barrier_slope = barrier_ * (above_.there * ds_.array() / above_.room(s_) -
                                             below_.there * ds_.array() / below_.room(s_))
                                                .sum();
    const double slope = g_.dot(dx_) + barrier_slope;
    if (open > 0.0) {
      const double wanted = (slope + 0.5 * dx_.dot(H_ * dx_)) / (0.9 * open);
      if (wanted > penalty_) penalty_ = 1.5 * wanted;
    }
    const double promised = slope - penalty_ * open;
    const double now = merit(f_, s_, c_);
    double share = std::min(below_.longest(s_, ds_), above_.longest(s_, ds_));
    for (int k = 0; k < kHalvings; ++k, share *= 0.5) {
      const VectorXd x = x_ + share * dx_;
      const VectorXd s = s_ + share * ds_;
      const VectorXd c = program_.constraints(x);
      const double f = program_.objective(x);
      const double then = merit(f, s, c);
      if (!(then <=
            now + kEnough * share * std::min(0.0, promised) + 1e-12 * std::max(1.0, std::abs(now))))
        continue;
      x_ = x;
      s_ = s;
      c_ = c;
      f_ = f;
      g_ = program_.gradient(x);
      J_.set(program_.jacobian(x));
      press(share);
      return true;
    }
    return false;
  }

  void press(double share) {
    const auto step = [](Side& side, const Eigen::ArrayXd& next) {
      // Where there is no bound nothing moves.
      const Eigen::ArrayXd falls =
          side.there * (side.pressure - next) / (side.pressure + (1.0 - side.there));
      const double speed = falls.maxCoeff();
      const double part = speed > kToTheEdge ? kToTheEdge / speed : 1.0;
      side.pressure += part * (next - side.pressure);
    };
    step(below_, below_next_);
    step(above_, above_next_);
    // Pressures stay near those of the barrier.
    const auto keep = [&](Side& side) {
      const Eigen::ArrayXd centre = side.there * barrier_ / side.room(s_);
      side.pressure = side.pressure.max(1e-4 * centre).min(1e4 * centre);
    };
    keep(below_);
    keep(above_);
    if (share > kLongStep) barrier_ = std::max(least_barrier(), kBarrierShrinks * barrier_);
  }

  NonlinearProgram& program_;
  const SolverOptions& options_;
  Eigen::Index n_, rows_;
  SparseRows J_;
  Side below_, above_;
  double barrier_ = kFirstBarrier;
  double penalty_ = 1.0;
  VectorXd x_, s_, c_, g_, dx_, ds_;
  double f_ = 0.0;
  Eigen::ArrayXd below_next_, above_next_;
  MatrixXd H_;
};

}  // namespace

SolverResult solve_with_interior_point(NonlinearProgram& program, const VectorXd& start,
                                       const SolverOptions& options) {
  return InteriorPoint(program, start, options).run();
}

}  // namespace veridyn
