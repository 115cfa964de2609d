#include "veridyn/simulation/plausible_model.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "effect_sizes.hpp"
#include "math/random_numbers.hpp"
#include "veridyn/effects/effect.hpp"
#include "veridyn/math/vector3.hpp"

namespace veridyn {
namespace {

// Lower bound of the effort for joints that carry no body: without rotor and friction their inertia would be zero.
constexpr double kLeastEffort = 0.1;  // [N m] or [N]

double with_upper_bound(double value, double bound) {
  return bound > 0.0 ? std::min(value, bound) : value;
}

InertialParameters random_body(RandomNumbers& random, const ParameterBox& box) {
  const double heaviest = with_upper_bound(3.0, box.mass_max);
  const double lightest = std::min(0.2, 0.5 * heaviest);
  const double mass = lightest * std::pow(heaviest / lightest, random.uniform());
  const double reach = with_upper_bound(0.1, box.com_reach);
  Eigen::Vector3d com;
  for (double& c : com) c = random.uniform(-reach, reach);
  const double a2 = std::pow(random.uniform(0.03, 0.12), 2);
  const double b2 = std::pow(random.uniform(0.03, 0.12), 2);
  const double c2 = std::pow(random.uniform(0.03, 0.12), 2);
  const Mat3d R = rotation_z(random.uniform(-M_PI, M_PI)) *
                  rotation_y(random.uniform(-M_PI, M_PI)) * rotation_x(random.uniform(-M_PI, M_PI));
  // Moments of a solid ellipsoid about its centre: m/5 (b^2 + c^2) and so on.
  const double k = mass / 5.0;
  const Mat3d I =
      R * Mat3d{{k * (b2 + c2), 0, 0}, {0, k * (a2 + c2), 0}, {0, 0, k * (a2 + b2)}} * transpose(R);
  Eigen::Matrix<double, 6, 1> inertia;
  inertia << I.row0.x, I.row0.y, I.row1.y, I.row0.z, I.row1.z, I.row2.z;
  return inertial_parameters(mass, com, inertia);
}

bool lacks_values(const EffectTerm& term) {
  for (const EffectParameter& p : find_effect(term.effect).parameters()) {
    if (term.values.count(p.name) == 0) return true;
  }
  return false;
}

}  // namespace

PlausibleModel plausible_model(const Model& arm, unsigned seed) {
  PlausibleModel out{arm};
  ModelDescription description = arm.description();
  for (size_t k = 0; k < description.frames.size(); ++k) {
    std::optional<Body>& body = description.frames[k].body;
    if (!body || body->phi) continue;
    RandomNumbers random(seed, static_cast<unsigned>(k));
    ParameterBox box = description.box;
    if (body->box.mass_max > 0.0) box.mass_max = body->box.mass_max;
    if (body->box.com_reach > 0.0) box.com_reach = body->box.com_reach;
    body->phi = random_body(random, box);
    ++out.bodies;
  }
  out.effects = static_cast<int>(
      std::count_if(description.effects.begin(), description.effects.end(), lacks_values));
  out.arm = with_sensible_effects(Model(std::move(description)), kLeastEffort);
  return out;
}

}  // namespace veridyn
