#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <utility>

#include "regressor/column_source.hpp"
#include "regressor/effect_along.hpp"

namespace veridyn {
namespace {

// Pointer to one of the numbers on which a column may depend.
using Input = double AxisSample::*;
constexpr std::array<Input, 6> kInputs = {&AxisSample::s,       &AxisSample::ds,
                                          &AxisSample::dds,     &AxisSample::from_s,
                                          &AxisSample::from_ds, &AxisSample::load};
constexpr size_t kVelocity = 1;

/// Derivative of f at zero by differences of fourth order. The step is small against the shortest
/// wave of any effect and large against rounding: about ten digits are correct.
constexpr double kStep = 1e-5;

template <typename Rows>
EffectColumns central_difference(const Rows& at, int count, double step) {
  const EffectColumns far_above = at(2.0 * step);
  const EffectColumns above = at(step);
  const EffectColumns below = at(-step);
  const EffectColumns far_below = at(-2.0 * step);
  EffectColumns out{};
  for (size_t p = 0; p < static_cast<size_t>(count); ++p) {
    out[p] = (8.0 * (above[p] - below[p]) - (far_above[p] - far_below[p])) / (12.0 * step);
  }
  return out;
}

// Sum of the first `count` columns times weights that are `stride` apart.
double weighted_sum(const EffectColumns& row, const double* weights, Eigen::Index stride, int count) {
  double sum = 0.0;
  for (int p = 0; p < count; ++p) sum += row[p] * weights[p * stride];
  return sum;
}

class EffectSource final : public ColumnSource {
 public:
  EffectSource(const Model& arm, const EffectTerm& term, const VectorXd& rounding)
      : arm_(arm), bound_(arm, term), batch_(arm), phi_(arm.inertial_values()) {
    const VectorXd& c = axis();
    rounding_ = c.cwiseAbs().dot(rounding);
    step_ = is_prismatic(arm, term.axis) ? 0.1 * kStep : kStep;
    const EffectTraits& traits = bound_.traits();
    remembers_ = traits.memory;
    matters_ = {traits.uses_position, traits.uses_velocity, traits.uses_acceleration,
                traits.uses_source,   traits.uses_source,   traits.uses_load};
    if (remembers_) rounding_ = 0.0;
  }

  int count() const override { return bound_.parameter_count(); }
  bool has_memory() const override { return remembers_; }
  std::vector<int> columns(int joint) const override {
    std::vector<int> out;
    for (int p = 0; p < count() && axis()[joint] != 0.0; ++p) out.push_back(p);
    return out;
  }

  void evaluate(const MotionSamples& m, std::vector<MatrixXd>& Y) const override {
    const std::vector<AxisSample> samples = along(m);
    MatrixXd values(m.rows(), count());
    EffectState state{};
    for (Eigen::Index k = 0; k < m.rows(); ++k) {
      const EffectColumns row = rounded(samples[k], state);
      for (int p = 0; p < count(); ++p) values(k, p) = row[p];
    }
    Y.resize(m.joints());
    for (Eigen::Index i = 0; i < m.joints(); ++i) {
      MatrixXd& to = Y[i];
      if (axis()[i] == 0.0) {
        to.resize(m.rows(), 0);
      } else {
        to = axis()[i] * values;
      }
    }
  }

  void add_gradient(const MotionSamples& m, const std::vector<MatrixXd>& weights,
                    MatrixXd& slopes) const override {
    MatrixXd w = MatrixXd::Zero(m.rows(), count());
    for (Eigen::Index i = 0; i < m.joints(); ++i) {
      if (axis()[i] != 0.0) w += axis()[i] * weights[i];
    }
    const std::vector<AxisSample> samples = along(m);
    MatrixXd by_input = MatrixXd::Zero(m.rows(), static_cast<Eigen::Index>(kInputs.size()));
    if (remembers_) {
      slopes_with_memory(samples, w, by_input);
    } else {
      slopes_without_memory(samples, w, by_input);
    }
    apply_chain_rule(m, by_input, slopes);
  }

 private:
  const VectorXd& axis() const { return bound_.term().axis.coefficients; }
  bool uses_load() const { return bound_.traits().uses_load && phi_.has_value(); }

  EffectColumns columns_at(const AxisSample& x, EffectState& state) const {
    EffectColumns row{};
    bound_.effect().columns(x, bound_.shape(), state, row);
    return row;
  }

  // Columns that jump with the sign of the velocity are blended from both sides:
  //   (1 + v/r)/2 f(r) + (1 - v/r)/2 f(-r),   r = sqrt(v^2 + rounding^2).
  // Terms that are even or linear in the velocity change by rounding^2 / v^2 only.
  EffectColumns rounded(const AxisSample& x, EffectState& state) const {
    if (rounding_ <= 0.0) return columns_at(x, state);
    const double r = std::hypot(x.ds, rounding_);
    AxisSample side = x;
    side.ds = r;
    const EffectColumns forth = columns_at(side, state);
    side.ds = -r;
    const EffectColumns back = columns_at(side, state);
    EffectColumns row{};
    for (size_t p = 0; p < row.size(); ++p) {
      row[p] = 0.5 * ((1.0 + x.ds / r) * forth[p] + (1.0 - x.ds / r) * back[p]);
    }
    return row;
  }

  std::vector<AxisSample> along(const MotionSamples& m) const {
    const MatrixXd load = uses_load() ? rigid_load(arm_, batch_, m) : MatrixXd();
    return axis_samples(bound_, m, load, m.rows() > 0 ? m.time[0] : 0.0);
  }

  // Step of the numerical derivative by an input of kInputs, in its unit.
  double step_of(size_t input, const AxisSample& x) const {
    if (kInputs[input] == &AxisSample::load) return 1e-4 * (1e-3 + std::abs(x.load));
    // A small step stays on one side of the smoothed jump.
    if (input == kVelocity && rounding_ > 0.0) return 1e-2 * rounding_;
    return step_;
  }

  // Sets by_input(row, input) to the derivative of the row's columns . w by an input of kInputs.
  void slopes_without_memory(const std::vector<AxisSample>& samples, const MatrixXd& w,
                             MatrixXd& by_input) const {
    for (size_t k = 0; k < samples.size(); ++k) {
      const auto row = static_cast<Eigen::Index>(k);
      for (size_t input = 0; input < kInputs.size(); ++input) {
        if (!matters_[input]) continue;
        const auto at = [&](double step) {
          AxisSample x = samples[k];
          x.*kInputs[input] += step;
          EffectState state{};
          return rounded(x, state);
        };
        const EffectColumns d = central_difference(at, count(), step_of(input, samples[k]));
        by_input(row, static_cast<Eigen::Index>(input)) =
            weighted_sum(d, w.data() + row, w.rows(), count());
      }
    }
  }

  // The columns of a sample, and the next state, as a function of the sample and the state before it.
  struct Passed {
    EffectColumns row{};
    EffectState state{};
  };

  // Sets by_input in the same way. Adjoint pass through the memory, sample by sample: lambda is the derivative by the next state.
  void slopes_with_memory(const std::vector<AxisSample>& samples, const MatrixXd& w,
                          MatrixXd& by_input) const {
    std::vector<EffectState> before(samples.size());
    EffectState state{};
    for (size_t k = 0; k < samples.size(); ++k) {
      before[k] = state;
      columns_at(samples[k], state);
    }
    std::array<double, kMaxEffectStates> lambda{};
    for (size_t k = samples.size(); k-- > 0;) {
      const auto row = static_cast<Eigen::Index>(k);
      const auto value = [&](const AxisSample& x, const EffectState& from) {
        EffectState to = from;
        const EffectColumns columns = columns_at(x, to);
        double sum = weighted_sum(columns, w.data() + row, w.rows(), count());
        for (size_t e = 0; e < to.size(); ++e) sum += lambda[e] * to[e];
        return EffectColumns{sum};
      };
      for (size_t input = 0; input < kInputs.size(); ++input) {
        if (!matters_[input]) continue;
        const auto at = [&](double step) {
          AxisSample x = samples[k];
          x.*kInputs[input] += step;
          return value(x, before[k]);
        };
        by_input(row, static_cast<Eigen::Index>(input)) =
            central_difference(at, 1, step_of(input, samples[k]))[0];
      }
      std::array<double, kMaxEffectStates> next{};
      for (size_t e = 0; e < next.size(); ++e) {
        const auto at = [&](double step) {
          EffectState moved = before[k];
          moved[e] += step;
          return value(samples[k], moved);
        };
        next[e] = central_difference(at, 1, step_)[0];
      }
      lambda = next;
    }
  }

  // Adds to slopes (rows x 3 n) by the chain rule from the axis to the coordinates.
  void apply_chain_rule(const MotionSamples& m, const MatrixXd& by_input, MatrixXd& slopes) const {
    const Eigen::Index n = m.joints();
    for (Eigen::Index part = 0; part < 3; ++part) {
      for (Eigen::Index i = 0; i < n; ++i) {
        if (axis()[i] != 0.0) slopes.col(part * n + i) += axis()[i] * by_input.col(part);
      }
    }
    if (bound_.term().from) {
      const VectorXd& from = bound_.term().from->coefficients;
      for (Eigen::Index part = 0; part < 2; ++part) {
        for (Eigen::Index i = 0; i < n; ++i) {
          if (from[i] != 0.0) slopes.col(part * n + i) += from[i] * by_input.col(3 + part);
        }
      }
    }
    if (!uses_load()) return;
    MatrixXd by_state;
    batch_.torque_derivatives(m.q, m.dq, m.ddq, *phi_, by_state);
    const VectorXd share = axis() / axis().squaredNorm();
    for (Eigen::Index d = 0; d < 3 * n; ++d) {
      slopes.col(d).array() +=
          by_input.col(5).array() * (by_state.middleCols(d * n, n) * share).array();
    }
  }

  Model arm_;
  BoundEffect bound_;
  TorqueRegressor batch_;
  std::optional<VectorXd> phi_;
  double rounding_ = 0.0;
  double step_ = kStep;
  std::array<bool, kInputs.size()> matters_{};  // inputs of kInputs on which the columns depend
  bool remembers_ = false;
};

}  // namespace

std::unique_ptr<ColumnSource> effect_columns(const Model& arm, const EffectTerm& term,
                                             const VectorXd& rounding) {
  return std::make_unique<EffectSource>(arm, term, rounding);
}

}  // namespace veridyn
