#include "hide_and_seek/places.hpp"

#include <algorithm>
#include <cmath>

namespace veridyn::seek {
namespace {

// Links with a body, or with a descendant that has one.
std::vector<char> loaded(const LagrangeArm& arm) {
  std::vector<char> out(arm.links.size(), 0);
  for (size_t k = arm.links.size(); k-- > 0;) {
    if (arm.links[k].has_body) out[k] = 1;
    if (out[k] != 0 && arm.links[k].parent >= 0) out[arm.links[k].parent] = 1;
  }
  return out;
}

// Number of links that depend on a coordinate alone.
std::vector<int> uses(const LagrangeArm& arm) {
  std::vector<int> out(arm.joints, 0);
  for (const Link& link : arm.links) {
    for (int i = 0; i < arm.joints; ++i)
      out[i] += static_cast<int>(link.ratios[i] != 0.0);
  }
  return out;
}

// Numbers of links. The zero of a joint is left out where it is no more than that of an encoder.
std::vector<Cause> wrong_constants(const LagrangeArm& arm) {
  const std::vector<char> bears = loaded(arm);
  const std::vector<int> count = uses(arm);
  std::vector<Cause> out;
  for (size_t k = 0; k < arm.links.size(); ++k) {
    const Link& link = arm.links[k];
    if (bears[k] == 0 || link.parent < 0) continue;
    const auto add = [&](const char* constant, int joint) {
      out.push_back({"coupling_error", joint, -1, link.name, constant, {}});
    };
    bool zero_of_an_encoder = false;
    for (int i = 0; i < arm.joints; ++i) {
      const double c = link.ratios[i];
      zero_of_an_encoder |= c != 0.0 && count[i] == 1;
      if (c != 0.0 && std::abs(c) != 1.0) add("ratio", i);
    }
    add("a", -1);
    add("alpha", -1);
    if (!link.slides) add("d", -1);
    if (!zero_of_an_encoder || link.slides) add("theta", -1);
  }
  return out;
}

}  // namespace

std::vector<Cause> places_for(const std::string& effect, const Bench& bench,
                              const std::vector<Cause>& taken) {
  const LagrangeArm& arm = bench.arm;
  std::vector<Cause> out;
  if (effect == "gravity_tilt") return {Cause{effect, -1, -1, "", "", {}}};
  if (effect == "common_delay") return {Cause{"time_delay", -1, -1, "", "", {}}};
  if (effect == "common_gain") return {Cause{"torque_gain", -1, -1, "", "", {}}};
  if (effect == "large_zero" || effect == "large_delay") {
    out = places_for(effect == "large_zero" ? "encoder_offset" : "time_delay", bench, taken);
    for (Cause& c : out) c.constant = "large";
    return out;
  }
  if (effect == "coupling_error") return wrong_constants(arm);
  if (effect == "payload") {
    for (const Link& link : arm.links) {
      if (link.has_body) out.push_back({effect, -1, -1, link.name, "", {}});
    }
    return out;
  }
  for (int i = 0; i < arm.joints; ++i) {
    if (std::any_of(taken.begin(), taken.end(), [i](const Cause& c) { return c.joint == i; }))
      continue;
    const bool coupled = effect == "cable_coupling" || effect == "torque_crosstalk";
    if (!coupled) out.push_back({effect, i, -1, "", "", {}});
    for (int from = 0; coupled && from < arm.joints; ++from) {
      if (from != i) out.push_back({effect, i, from, "", "", {}});
    }
  }
  return out;
}

bool is_declared(const std::string& effect) {
  return effect == "viscous_friction" || effect == "coulomb_friction" || effect == "torque_offset";
}

void forget_friction(Bench& bench, const Cause& cause) {
  ModelDescription d = bench.robot.description();
  const auto is_it = [&](const EffectTerm& t) {
    return t.effect == cause.effect && t.axis.coefficients[cause.joint] != 0.0;
  };
  d.effects.erase(std::remove_if(d.effects.begin(), d.effects.end(), is_it), d.effects.end());
  bench.robot = Model(std::move(d));
  JointFriction& f = bench.friction[cause.joint];
  if (cause.effect == "viscous_friction") f.viscous = 0.0;
  if (cause.effect == "coulomb_friction") f.coulomb = 0.0;
  if (cause.effect == "torque_offset") f.offset = 0.0;
}

}  // namespace veridyn::seek
