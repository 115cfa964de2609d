#include "files/simulators/simulator_frames.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "effects/effect_names.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {

std::optional<Body> body_of(const XmlFile& xml, pugi::xml_node at, double mass, const Eigen::Isometry3d& T,
                            const Eigen::Matrix3d& inertia) {
  if (mass < 0.0) xml.fail(at, text("a mass of ", mass, " kg"), "one that is not negative");
  if (mass <= kPlaceholderMass) return std::nullopt;
  const Eigen::Matrix3d I = T.linear() * inertia * T.linear().transpose();
  Eigen::Matrix<double, 6, 1> entries;
  entries << I(0, 0), I(0, 1), I(1, 1), I(0, 2), I(1, 2), I(2, 2);
  Body body;
  body.phi = inertial_parameters(mass, T.translation(), entries);
  if (!body.phi->allFinite()) xml.fail(at, "an inertial that is not finite", "finite numbers");
  return body;
}

Vec3d unit_axis(const XmlFile& xml, pugi::xml_node at, const Eigen::Vector3d& axis) {
  const double length = axis.norm();
  if (!(length > 1e-10) || !std::isfinite(length)) xml.fail(at, "no direction of the joint's axis", "one");
  return from_eigen(Eigen::Vector3d(axis / length));
}

std::vector<Axis> joint_variables(const XmlFile& xml, const std::vector<FileJoint>& joints,
                                  std::vector<Coordinate>& coordinates) {
  for (const FileJoint& joint : joints) {
    if (joint.follows) continue;
    Coordinate c;
    c.name = joint.name;
    c.limits = joint.limits;
    coordinates.push_back(c);
  }
  if (coordinates.empty()) xml.fail(xml.root(), "no joint that moves", "at least one");
  if (coordinates.size() > kMostCoordinates)
    xml.fail(xml.root(), text(coordinates.size(), " joints that move"), text("at most ", kMostCoordinates));
  std::vector<Axis> out(joints.size());
  std::vector<char> known(joints.size(), 0);
  Eigen::Index next = 0;
  const auto n = static_cast<Eigen::Index>(coordinates.size());
  for (std::size_t j = 0; j < joints.size(); ++j) {
    out[j] = {VectorXd::Zero(n), joints[j].constant};
    if (joints[j].follows) continue;
    out[j].coefficients[next++] = 1.0;
    known[j] = 1;
  }
  // Each pass resolves the joints that depend on resolved ones only.
  for (bool progress = true; progress;) {
    progress = false;
    for (std::size_t j = 0; j < joints.size(); ++j) {
      bool ready = known[j] == 0;
      for (const FileJoint::Share& s : joints[j].shares) ready = ready && known[s.joint] != 0;
      if (!ready) continue;
      for (const FileJoint::Share& s : joints[j].shares) {
        const Axis& leader = out[s.joint];
        out[j].coefficients += s.coefficient * leader.coefficients;
        out[j].offset += s.coefficient * leader.offset;
      }
      known[j] = 1;
      progress = true;
    }
  }
  for (std::size_t j = 0; j < joints.size(); ++j) {
    if (known[j] == 0)
      xml.fail(joints[j].node, "the joint '" + joints[j].name + "' in a cycle of joints that follow each other",
               "one that follows none in the end");
  }
  return out;
}

void add_effect(ModelDescription& model, const std::string& file, const char* attribute, const Axis& axis,
                double value) {
  if (value == 0.0) return;
  const auto [effect, key] = effect_of_attribute(attribute).value();
  EffectTerm term;
  term.effect = effect;
  term.axis = axis;
  term.values[key] = value;
  term.where = file;
  model.effects.push_back(std::move(term));
}

}  // namespace veridyn
