#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "diagnosis/search/explain.hpp"
#include "math/eigen_pose.hpp"
#include "veridyn/effects/effect_facts.hpp"
#include "veridyn/identification/pseudo_inertia.hpp"

namespace veridyn::search {
namespace {

// The fixed transform from a frame to the body that moves with it.
std::optional<std::pair<int, Posed>> body_of(const Model& arm, FrameIndex frame) {
  const auto root = [&](int k) {
    Posed T = identity_pose();
    while (arm.frames()[k].type == JointType::kFixed && arm.frames()[k].parent) {
      T = arm.frames()[k].A * arm.frames()[k].B * T;
      k = arm.frames()[k].parent->value;
    }
    return std::make_pair(k, T);
  };
  const auto [own, T_root_frame] = root(frame.value);
  for (const auto [b] : arm.bodies()) {
    const auto [other, T_root_body] = root(b);
    if (other == own) return std::make_pair(b, inverse(T_root_body) * T_root_frame);
  }
  return std::nullopt;
}

// Inertial parameters of a body, written in another frame that moves with it.
InertialParameters moved(const InertialParameters& phi, const Posed& T) {
  const Eigen::Matrix3d R = eigen(T.R);
  const Eigen::Vector3d p = eigen(T.p), h = phi.segment<3>(1);
  Eigen::Matrix3d L;
  L << phi[4], phi[5], phi[7], phi[5], phi[6], phi[8], phi[7], phi[8], phi[9];
  // Second moments are a quadratic form: Sigma' = R Sigma R' + R h p' + p h' R' + m p p'.
  const Eigen::Matrix3d S = 0.5 * L.trace() * Eigen::Matrix3d::Identity() - L;
  const Eigen::Vector3d Rh = R * h;
  const Eigen::Matrix3d moved_S = R * S * R.transpose() + Rh * p.transpose() + p * Rh.transpose() + phi[0] * p * p.transpose();
  const Eigen::Matrix3d moved_L = moved_S.trace() * Eigen::Matrix3d::Identity() - moved_S;
  InertialParameters out;
  out << phi[0], Rh + phi[0] * p, moved_L(0, 0), moved_L(0, 1), moved_L(1, 1), moved_L(0, 2), moved_L(1, 2), moved_L(2, 2);
  return out;
}

}  // namespace

Model extended_arm(const Model& arm, const std::vector<Chosen>& chosen, bool changes) {
  ModelDescription d = corrected(arm, chosen).description();
  if (changes && !chosen.empty()) d.identified.reset();  // the statistics belong to values that have changed
  for (const Chosen& c : chosen) {
    if (c.term.kind == TermKind::kLoad) {
      // A load's inertia beyond that of a point mass is less certain than its mass and moments: it is dropped
      // where the sum would be physically impossible.
      InertialParameters load = load_parameters(c.term.centre) * c.values;
      const FrameIndex frame = *frame_of(c.term.cause);
      const auto body = body_of(arm, frame);
      const auto& known = body ? d.frames[body->first].body->phi : std::nullopt;
      const InertialParameters sum = load[0] < 0.0 && known ? InertialParameters(*known + moved(load, body->second)) : load;
      if (smallest_eigenvalue(pseudo_inertia(sum)) < 0.0) load.tail<6>() -= c.values.tail<6>();
      if (load[0] < 0.0 && body) {
        Body& own = *d.frames[body->first].body;
        if (own.phi) *own.phi += moved(load, body->second);
        continue;
      }
      Frame f;
      f.name = AddedLoad::kName;
      for (int count = 2; std::any_of(d.frames.begin(), d.frames.end(), [&](const Frame& other) { return other.name == f.name; }); ++count)
        f.name = std::string(AddedLoad::kName) + "_" + std::to_string(count);
      f.parent = frame;
      f.variable.coefficients = VectorXd::Zero(arm.joints());
      f.body = Body{};
      f.body->phi = load;
      d.frames.push_back(std::move(f));
    } else if (c.term.kind == TermKind::kChange) {
      EffectTerm& own = d.effects[c.term.candidate.own->value];
      const std::vector<EffectParameter> parameters = find_effect(own.effect).parameters();
      for (size_t p = 0; p < parameters.size(); ++p) {
        double& value = own.values[parameters[p].name];
        value += c.values[static_cast<Eigen::Index>(p)];
        if (parameters[p].sign == ParameterSign::kNonnegative) value = std::max(value, 0.0);
      }
      own.deviations.clear();
    } else if (c.term.kind == TermKind::kEffect) {
      EffectTerm term = c.term.effect;
      if (c.term.with_rest && !term.from) term.axis.offset += c.values[c.values.size() - 1] / c.values[0];
      const std::vector<EffectParameter> parameters = find_effect(term.effect).parameters();
      for (size_t p = 0; changes && p < parameters.size(); ++p) term.values[parameters[p].name] = c.values[static_cast<Eigen::Index>(p)];
      d.effects.push_back(std::move(term));
    }
  }
  return Model(std::move(d));
}

}  // namespace veridyn::search
