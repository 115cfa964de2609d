#include "loop_search.hpp"
#include "veridyn/math/numbers.hpp"

#include <algorithm>
#include <cmath>

namespace veridyn {
namespace {

constexpr int kHalvings = 40;
constexpr double kLargestGain = 1e3;
constexpr int kPhaseSteps = 36;      // steps of the phase in half a turn
constexpr double kTurnedUnstable = 1.0 + 1e-7;  // matrix of twice the size, with larger rounding errors
constexpr int kLongestDelay = 200;   // [cycles] end of the search for the delay margin

// Modulus per cycle, from that over `cycles` cycles.
double radius_per_cycle(double radius, int cycles) {
  return std::pow(radius, 1.0 / cycles);
}

// True if a force law has a deadband, which acts as a share of an integral gain (describing function).
bool has_deadband(const Scenario& scenario) {
  return std::any_of(scenario.members.begin(), scenario.members.end(), [](const ScenarioMember& m) {
    return m.law.kind == ForceLaw::Kind::kProportional && m.law.deadband > 0.0;
  });
}

// Largest stable value between a stable and an unstable one, to 1e-6 of it.
double stability_limit_between(const std::function<double(double)>& radius, double stable, double unstable) {
  for (int k = 0; k < kHalvings && unstable - stable > 1e-6 * unstable; ++k) {
    const double middle = 0.5 * (stable + unstable);
    (radius(middle) > kUnstable ? unstable : stable) = middle;
  }
  return stable;
}

// Eigenvalues of the loop with every reading turned by -phase: the real form of a complex map,
// [Re -Im; Im Re], from the parts of each cycle with and without readings.
class TurnedLoop {
 public:
  TurnedLoop(const LinearPoint& point, const Scenario& scenario) {
    LoopSettings none;
    none.reading_gain = 0.0;
    const ClosedLoop closed(point, scenario, {});
    const ClosedLoop open(point, scenario, none);
    cycles_ = closed.hyperperiod();
    rows_ = closed.rows();
    for (const CycleRow& row : rows_) {
      if (row.kind < static_cast<int>(without_.size())) continue;
      MatrixXd with = MatrixXd::Identity(closed.states(), closed.states());
      MatrixXd without = with;
      closed.advance(row.first, with);
      open.advance(row.first, without);
      without_.push_back(without);
      readings_.push_back(with - without);
    }
  }

  // Per cycle, with readings turned by this phase [rad].
  double spectral_radius_at(double phase) const {
    const Eigen::Index n = without_.front().rows();
    MatrixXd product = MatrixXd::Identity(2 * n, 2 * n);
    MatrixXd one(2 * n, 2 * n);
    for (const CycleRow& row : rows_) {
      const auto i = static_cast<size_t>(row.kind);
      one.topLeftCorner(n, n) = one.bottomRightCorner(n, n) =
          without_[i] + std::cos(phase) * readings_[i];
      one.topRightCorner(n, n) = std::sin(phase) * readings_[i];
      one.bottomLeftCorner(n, n) = -one.topRightCorner(n, n);
      product = ((row.count == 1 ? one : power(one, row.count)) * product).eval();
    }
    return radius_per_cycle(spectral_radius(product), cycles_);
  }

 private:
  std::vector<CycleRow> rows_;
  std::vector<MatrixXd> without_, readings_;  // by kind of cycle: map without readings, their share of it
  int cycles_ = 1;
};

}  // namespace

double loop_radius(const LinearPoint& point, const Scenario& scenario,
                   const LoopSettings& settings) {
  const auto radius = [&](const LoopSettings& s) {
    const ClosedLoop loop(point, scenario, s);
    return radius_per_cycle(spectral_radius(loop.map()), loop.hyperperiod());
  };
  double worst = radius(settings);
  if (!has_deadband(scenario)) return worst;
  for (const double share : {0.0, 0.1, 0.3, 0.6}) {
    LoopSettings part = settings;
    part.integral = share;
    worst = std::max(worst, radius(part));
  }
  return worst;
}

double first_crossing(const std::function<double(double)>& radius, double begin, double end,
                      int steps) {
  const double ratio = std::pow(end / begin, 1.0 / steps);
  double last = begin;
  for (int k = 1; k <= steps; ++k) {
    const double next = begin * std::pow(ratio, k);
    if (radius(next) > kUnstable) return stability_limit_between(radius, last, next);
    last = next;
  }
  return end;
}

// The largest phases come first, where most unstable loops fail.
bool stable_up_to_phase(const LinearPoint& point, const Scenario& scenario, double phase) {
  const TurnedLoop turned(point, scenario);
  const int steps = std::max(4, static_cast<int>(std::ceil(phase * kPhaseSteps / M_PI)));
  for (int k = steps; k > 0; --k) {
    if (turned.spectral_radius_at(phase * k / steps) > kTurnedUnstable) return false;
  }
  return true;
}

StabilityMargins loop_margins(const LinearPoint& point, const Scenario& scenario) {
  StabilityMargins out{kInfinity, kInfinity, kInfinity};
  if (point.elements.empty()) return out;
  if (loop_radius(point, scenario) > kUnstable) return {0.0, 0.0, 0.0};
  const auto with_gain = [&](double gain) {
    LoopSettings s;
    s.reading_gain = gain;
    return loop_radius(point, scenario, s);
  };
  const double gain = first_crossing(with_gain, 1.0, kLargestGain, 40);
  if (gain < kLargestGain) out.gain = gain;

  const TurnedLoop turned(point, scenario);
  double before = 0.0;
  for (int k = 1; k <= kPhaseSteps; ++k) {
    const double phase = M_PI * k / kPhaseSteps;
    if (turned.spectral_radius_at(phase) > kTurnedUnstable) {
      double stable = before, unstable = phase;
      for (int h = 0; h < 12; ++h) {
        const double middle = 0.5 * (stable + unstable);
        (turned.spectral_radius_at(middle) > kTurnedUnstable ? unstable : stable) = middle;
      }
      out.phase_deg = stable * 180.0 / M_PI;
      break;
    }
    before = phase;
  }

  const double period = 1.0 / scenario.control.rate;
  double last = loop_radius(point, scenario);
  for (int extra = 1; extra <= kLongestDelay; ++extra) {
    LoopSettings s;
    s.extra_delay = extra;
    const double radius = loop_radius(point, scenario, s);
    if (radius > kUnstable) {
      // Between whole cycles, the logarithm of the modulus is interpolated linearly.
      const double share = std::log(last) < 0.0
                               ? std::log(last) / (std::log(last) - std::log(radius))
                               : 0.0;
      out.delay = period * (extra - 1 + std::clamp(share, 0.0, 1.0));
      break;
    }
    last = radius;
  }
  return out;
}

}  // namespace veridyn
