#include "identification/fleet/fleet_fit.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <unsupported/Eigen/SpecialFunctions>

#include "math/numbers.hpp"
#include "veridyn/effects/cause.hpp"
#include "veridyn/effects/channel_effect.hpp"

namespace veridyn {
namespace {

// Name of the cause that scales a joint's recorded torque.
std::string gain_name(const Model& arm, int joint) {
  for (const ChannelEffect* effect : channel_effects()) {
    const auto* sensor = dynamic_cast<const SensorError*>(effect);
    if (sensor != nullptr && sensor->scales_torque())
      return to_text(arm, ChannelError{effect->name(), JointIndex{joint}});
  }
  return arm.coordinates()[joint].name;
}

double digamma(double x) { return Eigen::numext::digamma(x); }
double trigamma(double x) { return Eigen::numext::polygamma(1.0, x); }

// One quantity with its values on all arms.
struct Quantity {
  FleetSpread spread;
  JointIndex joint{};
  std::vector<double> all, uncertain;
  double usual = 0.0;  // median of `uncertain`
};

// Prior of the spreads of one kind of quantities, estimated from all of them: a scaled inverse chi-square
// distribution of the square, since few arms determine a single spread badly. Spreads are compared in units
// of their noise (equal arms) or of their medians (arms that vary by some percent), whichever makes them more
// alike. Source: Smyth, Statistical Applications in Genetics and Molecular Biology 3(1), 2004 (moderated t).
struct SpreadPrior {
  double freedom = 0.0;
  double square = 0.0;        // squared spread, in squared units of `unit`
  double unlike = kInfinity;  // variance of the logarithms of the squares
  double (*unit)(const Quantity&) = nullptr;

  // The spread of a quantity whose robust deviation has `own` degrees of freedom.
  double spread_of(const Quantity& q, double own) const {
    const double part = unit != nullptr ? freedom * square * std::pow(unit(q), 2) : 0.0;
    return std::sqrt((own * std::pow(q.spread.spread, 2) + part) / (own + freedom));
  }
};

// Prior of spreads with these degrees of freedom each.
SpreadPrior prior_in(double (*unit)(const Quantity&), const std::vector<Quantity>& quantities,
                     double freedom) {
  SpreadPrior prior;
  std::vector<double> logs;
  for (const Quantity& q : quantities)
    if (q.spread.arms >= fleets::numbers.fewest && q.spread.spread > 0.0 && unit(q) > 0.0)
      logs.push_back(2.0 * std::log(q.spread.spread / unit(q)));
  if (static_cast<int>(logs.size()) < fleets::numbers.fewest_spreads) return prior;
  const auto count = static_cast<double>(logs.size());
  double mean = 0.0;
  for (const double x : logs) mean += x / count;
  prior.unlike = 0.0;
  for (const double x : logs) prior.unlike += std::pow(x - mean, 2) / (count - 1.0);
  const double between = prior.unlike - trigamma(0.5 * freedom);
  double least = 0.0;
  double most = fleets::numbers.most_prior;
  while (trigamma(0.5 * most) < between && most - least > fleets::kWidth) {
    const double middle = 0.5 * (least + most);
    (trigamma(0.5 * middle) > between ? least : most) = middle;
  }
  prior.unit = unit;
  prior.freedom = most;
  prior.square = std::exp(mean - digamma(0.5 * freedom) + std::log(0.5 * freedom) +
                          digamma(0.5 * most) - std::log(0.5 * most));
  return prior;
}

SpreadPrior prior_of(const std::vector<Quantity>& kind, double freedom) {
  const SpreadPrior noise = prior_in([](const Quantity& q) { return q.usual; }, kind, freedom);
  const SpreadPrior share =
      prior_in([](const Quantity& q) { return std::abs(q.spread.median); }, kind, freedom);
  return noise.unlike <= share.unlike ? noise : share;
}

Quantity quantity_of(const Model& arm, const FleetFit& fit, const Fleet& fleet, int k) {
  const int own = static_cast<int>(fit.own());
  Quantity out;
  for (const FleetMember& m : fleet.members) out.all.push_back(m.own[k]);
  FleetSpread& spread = out.spread;
  if (k < own) {
    const StandardParameter& p = fit.own_parameter(k);
    spread.name = p.name;
    spread.unit = p.unit;
    out.joint = main_coordinate(arm.effects()[*p.effect].axis);
  } else {
    spread.name = gain_name(arm, k - own);
    out.joint = JointIndex{k - own};
  }
  std::tie(spread.median, spread.spread) = median_and_spread(out.all);
  spread.arms = static_cast<int>(
      std::count_if(out.all.begin(), out.all.end(), [](double x) { return std::isfinite(x); }));
  // The noise of this value on one arm, relative to that on most arms, weights its deviation. Noise is not
  // white, so that the spread of the fleet sets the scale.
  for (size_t a = 0; a < out.all.size(); ++a)
    out.uncertain.push_back(std::isfinite(out.all[a]) ? fit.arms()[a].uncertain[k] : kNaN);
  out.usual = median_and_spread(out.uncertain).first;
  return out;
}

// Reports the arms that are outliers in a quantity of one kind.
void add_outliers(const std::vector<Quantity>& kind, const FleetFit& fit, Fleet& fleet) {
  const double freedom = fit.degrees_of_freedom();
  const SpreadPrior prior = prior_of(kind, freedom);
  const double far = fit.threshold(fit.tested(), prior.freedom);
  for (const Quantity& q : kind) {
    const FleetSpread& spread = q.spread;
    const double width = prior.spread_of(q, freedom);
    for (size_t a = 0; a < q.all.size() && spread.arms >= fleets::numbers.fewest && spread.spread > 0.0; ++a) {
      const double wider = q.usual > 0.0 ? std::max(1.0, q.uncertain[a] / q.usual) : 1.0;
      const double deviations = (q.all[a] - spread.median) / (wider * width);
      // Differences below this share of the median are not reported, even if the fleet varies less.
      const bool noticeable =
          std::abs(q.all[a] - spread.median) > fleets::numbers.noticeable * std::abs(spread.median);
      if (std::isfinite(q.all[a]) && noticeable && std::abs(deviations) > far)
        fleet.outliers.push_back(
            {fleet.members[a].name, spread.name, q.joint, q.all[a], spread.median, deviations});
    }
  }
}

}  // namespace

void add_spreads(const Model& arm, const FleetFit& fit, Fleet& fleet) {
  const int own = static_cast<int>(fit.own());
  std::vector<Quantity> effects;
  std::vector<Quantity> gains;
  for (int k = 0; k < own + fleet.joints; ++k) {
    std::vector<Quantity>& kind = k < own ? effects : gains;
    kind.push_back(quantity_of(arm, fit, fleet, k));
    fleet.spreads.push_back(kind.back().spread);
  }
  add_outliers(effects, fit, fleet);
  add_outliers(gains, fit, fleet);
}

}  // namespace veridyn
