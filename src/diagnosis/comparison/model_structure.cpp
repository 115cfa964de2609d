#include "diagnosis/comparison/model_structure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <unordered_map>
#include <utility>

#include "diagnosis/comparison/comparison_numbers.hpp"
#include "math/eigen_pose.hpp"
#include "veridyn/effects/effect_facts.hpp"
#include "veridyn/identification/pseudo_inertia.hpp"
#include "veridyn/regressor/standard_parameters.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

// One statement of a model file.
struct Property {
  StructureKind kind;
  std::string subject;
  std::string text;     // empty: the statement is that the model has the subject
  std::vector<double> numbers = {};  // if any, they are compared instead of the text
};

bool same(double a, double b) {
  return a == b || std::abs(a - b) <= comparing::kSame * (1.0 + std::abs(a));
}

bool same(const Property& a, const Property& b) {
  if (a.numbers.empty()) return a.text == b.text;
  return std::equal(a.numbers.begin(), a.numbers.end(), b.numbers.begin(), b.numbers.end(), [](double x, double y) { return same(x, y); });
}

bool has_frame_of_same_name(const Model& arm, const Frame& frame) {
  return arm.find_frame(frame.name).has_value();
}

std::string parent_of(const Model& arm, const Frame& frame) {
  return frame.parent ? arm.frames()[frame.parent->value].name : "the world";
}

std::vector<double> placement_numbers(const Frame& frame) {
  std::vector<double> out(frame.variable.coefficients.begin(), frame.variable.coefficients.end());
  out.push_back(frame.variable.offset);
  for (const Posed& pose : {frame.A, frame.B}) {
    const Eigen::Matrix4d T = eigen(pose).matrix();
    out.insert(out.end(), T.data(), T.data() + T.size());
  }
  return out;
}

std::vector<double> shape_constants_of(const Model& arm, const EffectTerm& term) {
  const EffectFacts bound(arm, term);
  const auto count = static_cast<long>(bound.effect().shapes().size());
  return {bound.shape().begin(), bound.shape().begin() + count};
}

// A name for every effect of the arm, such as "coulomb_friction(elbow)". Several of one kind on one axis are numbered in
// the order of their shape constants.
std::vector<std::string> names_of_terms(const Model& arm) {
  std::map<std::string, std::vector<std::pair<std::vector<double>, std::size_t>>> at_place;
  for (std::size_t e = 0; e < arm.effects().size(); ++e) {
    const EffectTerm& term = arm.effects()[e];
    std::string place = term.effect + "(" + axis_text(arm, term.axis);
    if (term.from) place += " from " + axis_text(arm, *term.from);
    if (!term.frame.empty()) place += " on " + term.frame;
    at_place[place + ")"].emplace_back(shape_constants_of(arm, term), e);
  }
  std::vector<std::string> out(arm.effects().size());
  for (auto& [place, terms] : at_place) {
    std::sort(terms.begin(), terms.end());
    for (std::size_t k = 0; k < terms.size(); ++k) out[terms[k].second] = place + (k > 0 ? fmt::format(", number {}", k + 1) : "");
  }
  return out;
}

// Adds statements about the frames of `arm`: kind and placement of those that `other` has too, existence of moving ones
// and of bodies on fixed ones that it does not have.
void add_frames(const Model& arm, const Model& other, std::vector<Property>& out) {
  constexpr const char* kTypes[] = {"fixed", "turning", "sliding"};
  for (const Frame& frame : arm.frames()) {
    if (has_frame_of_same_name(other, frame)) {
      out.push_back({StructureKind::kRobot, "frame '" + frame.name + "'",
                     fmt::format("{} on {} with{} body", kTypes[static_cast<int>(frame.type)], parent_of(arm, frame), frame.body ? " a" : "out a")});
      out.push_back({StructureKind::kGeometry, frame.name, "", placement_numbers(frame)});
    } else if (frame.type != JointType::kFixed) {
      out.push_back({StructureKind::kRobot, "the moving frame '" + frame.name + "'", ""});
    } else if (frame.body) {
      const std::string mass = frame.body->phi ? fmt::format(" ({:.4g} kg)", (*frame.body->phi)[0]) : "";
      out.push_back({StructureKind::kBody, fmt::format("the body {}{} on {}", frame.name, mass, parent_of(arm, frame)), ""});
    }
    if (frame.body && frame.body->fixed) out.push_back({StructureKind::kFacts, "the body " + frame.name + " as a fact", ""});
  }
}

std::vector<Property> properties_of(const Model& arm, const Model& other) {
  std::vector<Property> out;
  const auto number = [&out](StructureKind kind, const std::string& subject, double value, int digits) {
    out.push_back({kind, subject, fmt::format("{:.{}g}", value, digits), {value}});
  };
  number(StructureKind::kRobot, "the number of coordinates", arm.joints(), 3);
  for (int i = 0; i < arm.joints(); ++i) out.push_back({StructureKind::kRobot, fmt::format("coordinate {}", i + 1), "'" + arm.coordinates()[i].name + "'"});
  add_frames(arm, other, out);
  for (const auto& [name, value] : arm.description().constants) number(StructureKind::kConstant, "constant " + name, value, 6);
  for (const Coordinate& c : arm.coordinates()) number(StructureKind::kDriveGain, "drive gain of " + c.name, c.drive_gain, 5);
  const Eigen::Vector3d& g = arm.gravity();
  out.push_back({StructureKind::kGravity, "gravity", fmt::format("[{:.5g}, {:.5g}, {:.5g}]", g.x(), g.y(), g.z()), {g.x(), g.y(), g.z()}});
  const std::vector<std::string> names = names_of_terms(arm);
  for (std::size_t e = 0; e < names.size(); ++e) {
    const EffectTerm& term = arm.effects()[e];
    out.push_back({StructureKind::kEffect, names[e], ""});
    const std::vector<double> shape = shape_constants_of(arm, term);
    for (std::size_t s = 0; s < shape.size(); ++s) number(StructureKind::kShape, names[e] + ": " + find_effect(term.effect).shapes()[s].name, shape[s], 4);
  }
  return out;
}

const Property* find_property(const std::vector<Property>& all, const Property& wanted) {
  const auto at = std::find_if(all.begin(), all.end(), [&](const Property& p) { return p.kind == wanted.kind && p.subject == wanted.subject; });
  return at == all.end() ? nullptr : &*at;
}

// True if the frames that both models have, by name, are placed alike.
bool same_geometry(const Model& a, const Model& b) {
  return std::all_of(a.frames().begin(), a.frames().end(), [&](const Frame& frame) {
    const std::optional<FrameIndex> there = b.find_frame(frame.name);
    return !there || same({StructureKind::kGeometry, "", "", placement_numbers(frame)}, {StructureKind::kGeometry, "", "", placement_numbers(b.frames()[there->value])});
  });
}

// True if corresponding shape constants differ by less than half, so that the parameters have the same meaning.
bool have_similar_constants(const std::vector<double>& a, const std::vector<double>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](double x, double y) { return std::abs(x - y) <= 0.5 * std::max(std::abs(x), std::abs(y)); });
}

// Names of standard parameters that are equal where the parameters of two models may correspond.
std::vector<std::string> meanings(const Model& arm, const std::vector<StandardParameter>& parameters) {
  const std::vector<std::string> terms = names_of_terms(arm);
  std::vector<std::string> out;
  for (const StandardParameter& p : parameters) out.push_back(p.effect ? terms[*p.effect] + p.name.substr(p.name.rfind('.')) : p.name);
  return out;
}

const Frame& frame_of_body(const Model& arm, int body) {
  return arm.frames()[arm.bodies()[body].value];
}

// Adds to M the rows of a body that `from` does not have, from those of the body that carries it.
void add_carried_body(const Model& from, const Model& to, int body, MatrixXd& M) {
  Eigen::Matrix4d T = Eigen::Matrix4d::Identity();  // pose of the body in the frame that carries it
  const Frame* frame = &frame_of_body(to, body);
  while (!frame->body || !has_frame_of_same_name(from, *frame)) {
    if (frame->type != JointType::kFixed || !frame->parent) return;  // it acts on no joint
    T = eigen(frame->A * frame->B).matrix() * T;
    frame = &to.frames()[frame->parent->value];
  }
  const auto carrier = std::find(to.bodies().begin(), to.bodies().end(), FrameIndex{static_cast<int>(frame - to.frames().data())}) - to.bodies().begin();
  Eigen::Matrix<double, kBodyParameters, kBodyParameters> X;
  for (int c = 0; c < kBodyParameters; ++c)
    X.col(c) = inertial_parameters(Eigen::Matrix4d(T * pseudo_inertia(InertialParameters::Unit(c)) * T.transpose()));
  M.middleRows<kBodyParameters>(kBodyParameters * body) = X.transpose() * M.middleRows<kBodyParameters>(kBodyParameters * carrier);
}

}  // namespace

const char* name_of(StructureKind kind) {
  static constexpr const char* kNames[] = {"robot", "effect", "body", "shape", "geometry", "constant", "gravity", "drive_gain", "facts"};
  return kNames[static_cast<int>(kind)];
}

const char* name_of(ComparedQuantity quantity) {
  static constexpr const char* kNames[] = {"friction", "offset", "weight", "weight_slope", "inertia", "parameter"};
  return kNames[static_cast<int>(quantity)];
}

std::vector<StructureDifference> structure_differences(const Model& before, const Model& after) {
  const std::vector<Property> a = properties_of(before, after), b = properties_of(after, before);
  std::vector<StructureDifference> out;
  std::string moved, constants;
  for (const Property& p : a) {
    const Property* const there = find_property(b, p);
    if (there == nullptr && p.text.empty()) out.push_back({p.kind, "only the model before has " + p.subject + "."});
    if (there == nullptr || same(p, *there)) continue;
    const std::string values = fmt::format("{} is {} before and {} after", p.subject, p.text, there->text);
    if (p.kind == StructureKind::kGeometry)
      moved += (moved.empty() ? "" : ", ") + p.subject;
    else if (p.kind == StructureKind::kConstant)
      constants += "; " + values;
    else
      out.push_back({p.kind, values + (p.kind == StructureKind::kDriveGain ? "; where currents were recorded, all its torques scale with it." : ".")});
  }
  for (const Property& p : b) {
    if (p.text.empty() && find_property(a, p) == nullptr) out.push_back({p.kind, "only the model after has " + p.subject + "."});
  }
  for (const StructureDifference& d : out) {
    require(d.kind != StructureKind::kRobot, "compare: found robot '", before.name(), "' and robot '", after.name(), "': ", d.sentence.substr(0, d.sentence.size() - 1),
            "; expected two models of one arm.");
  }
  if (!moved.empty()) {
    out.insert(out.begin(), {StructureKind::kGeometry, "frames stand or move differently: " + moved + constants +
                                             "; masses, moments and inertias do not mean the same, only effects and predictions are compared."});
  }
  return out;
}

Correspondence::Correspondence(const Model& from, const Model& to) {
  const std::vector<StandardParameter> mine = standard_parameters(from), theirs = standard_parameters(to);
  const std::vector<std::string> names = meanings(from, mine), other_names = meanings(to, theirs);
  std::unordered_map<std::string, std::size_t> index;
  for (std::size_t j = 0; j < theirs.size(); ++j) index.emplace(other_names[j], j);
  const bool one_geometry = same_geometry(from, to);
  M = MatrixXd::Zero(static_cast<Eigen::Index>(theirs.size()), static_cast<Eigen::Index>(mine.size()));
  own = foreign = VectorXd::Zero(M.cols());
  for (std::size_t j = 0; j < mine.size(); ++j) {
    const auto at = static_cast<Eigen::Index>(j);
    const auto found = index.find(names[j]);
    if (mine[j].body && !has_frame_of_same_name(to, frame_of_body(from, *mine[j].body)))
      own[at] = 1.0;
    else if (found == index.end() || (mine[j].body && !one_geometry) ||
             (mine[j].effect && !have_similar_constants(shape_constants_of(from, from.effects()[*mine[j].effect]), shape_constants_of(to, to.effects()[*theirs[found->second].effect]))))
      foreign[at] = 1.0;
    else
      M(static_cast<Eigen::Index>(found->second), at) = 1.0;
  }
  for (int k = 0; k < static_cast<int>(to.bodies().size()); ++k) {
    if (!has_frame_of_same_name(from, frame_of_body(to, k))) add_carried_body(from, to, k, M);
  }
}

}  // namespace veridyn
