#include "diagnosis/comparison/model_structure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "diagnosis/comparison/comparison_numbers.hpp"
#include "math/eigen_pose.hpp"
#include "veridyn/effects/effect_facts.hpp"
#include "veridyn/identification/pseudo_inertia.hpp"
#include "veridyn/regressor/standard_parameters.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

bool same(double a, double b) {
  return a == b || std::abs(a - b) <= comparing::kSame * (1.0 + std::abs(a));
}

bool same(const Vec3d& a, const Vec3d& b) {
  return same(a.x, b.x) && same(a.y, b.y) && same(a.z, b.z);
}

bool same(const Posed& a, const Posed& b) {
  return same(a.R.row0, b.R.row0) && same(a.R.row1, b.R.row1) && same(a.R.row2, b.R.row2) &&
         same(a.p, b.p);
}

bool same_place(const Frame& a, const Frame& b) {
  return same(a.A, b.A) && same(a.B, b.B) && same(a.variable.offset, b.variable.offset) &&
         a.variable.coefficients.isApprox(b.variable.coefficients, comparing::kSame);
}

// Text that identifies the terms of one effect at one place, independent of their shape constants.
std::string place_of(const Model& arm, const EffectTerm& term) {
  std::string out = term.effect + "(" + axis_text(arm, term.axis);
  if (term.from) out += " from " + axis_text(arm, *term.from);
  if (!term.frame.empty()) out += " on " + term.frame;
  return out + ")";
}

std::vector<double> shape_of(const Model& arm, const EffectTerm& term) {
  const EffectFacts bound(arm, term);
  const std::size_t count = bound.effect().shapes().size();
  return {bound.shape().begin(), bound.shape().begin() + static_cast<long>(count)};
}

// The terms of each place in the order of their constants.
std::map<std::string, std::vector<int>> terms_by_place(const Model& arm) {
  std::map<std::string, std::vector<int>> out;
  for (std::size_t e = 0; e < arm.effects().size(); ++e)
    out[place_of(arm, arm.effects()[e])].push_back(static_cast<int>(e));
  for (auto& [place, terms] : out) {
    std::stable_sort(terms.begin(), terms.end(), [&arm](int a, int b) {
      return shape_of(arm, arm.effects()[a]) <
             shape_of(arm, arm.effects()[b]);
    });
  }
  return out;
}

// True if corresponding shape constants differ by less than half, so that the parameters have the same
// meaning.
bool comparable(const Model& before, int term_before, const Model& after, int term_after) {
  const std::vector<double> a =
      shape_of(before, before.effects()[term_before]);
  const std::vector<double> b =
      shape_of(after, after.effects()[term_after]);
  for (std::size_t s = 0; s < a.size(); ++s) {
    if (std::abs(a[s] - b[s]) > 0.5 * std::max(std::abs(a[s]), std::abs(b[s]))) return false;
  }
  return true;
}

// Pairs of frames that both models have. Any other frame is fixed to one of them, which require_one_arm()
// ensures, such as that of a diagnosed load; a body that one model does not have counts there with parameters
// of zero.
std::vector<std::pair<const Frame*, const Frame*>> common_frames(const Model& before, const Model& after) {
  std::vector<std::pair<const Frame*, const Frame*>> out;
  for (const Frame& frame : before.frames()) {
    const int there = after.find_frame(frame.name);
    if (there >= 0) out.emplace_back(&frame, &after.frames()[there]);
  }
  return out;
}

bool same_geometry(const Model& before, const Model& after) {
  for (const auto& [a, b] : common_frames(before, after)) {
    if (!same_place(*a, *b)) return false;
  }
  return true;
}

using Differences = std::vector<StructureDifference>;

void compare_effects(const Model& before, const Model& after, Differences& out) {
  const auto a = terms_by_place(before);
  const auto b = terms_by_place(after);
  std::set<std::string> places;
  for (const auto& [place, terms] : a) places.insert(place);
  for (const auto& [place, terms] : b) places.insert(place);
  for (const std::string& place : places) {
    const auto in_a = a.find(place);
    const auto in_b = b.find(place);
    const std::size_t count_a = in_a == a.end() ? 0 : in_a->second.size();
    const std::size_t count_b = in_b == b.end() ? 0 : in_b->second.size();
    if (count_a != count_b) {
      const std::string times = std::max(count_a, count_b) > 1
                                    ? fmt::format(" ({} against {} times)", count_a, count_b)
                                    : "";
      out.push_back({"effect", fmt::format("only the model {} has {}{}.",
                                           count_a > count_b ? "before" : "after", place, times)});
    }
    for (std::size_t k = 0; k < std::min(count_a, count_b); ++k) {
      const EffectTerm& ta = before.effects()[in_a->second[k]];
      const EffectTerm& tb = after.effects()[in_b->second[k]];
      const std::vector<double> sa = shape_of(before, ta);
      const std::vector<double> sb = shape_of(after, tb);
      const std::vector<EffectShape> shapes = find_effect(ta.effect).shapes();
      for (std::size_t s = 0; s < shapes.size(); ++s) {
        if (same(sa[s], sb[s])) continue;
        out.push_back({"shape", fmt::format("{}: {} is {:.4g} before and {:.4g} after.", place,
                                            shapes[s].name, sa[s], sb[s])});
      }
    }
  }
}

void compare_frames(const Model& before, const Model& after, Differences& out) {
  std::string moved;
  for (const auto& [a, b] : common_frames(before, after)) {
    if (!same_place(*a, *b)) moved += (moved.empty() ? "" : ", ") + a->name;
  }
  if (moved.empty()) return;
  std::string constants;
  for (const auto& [name, value] : before.description().constants) {
    const auto other = after.description().constants.find(name);
    if (other == after.description().constants.end() || same(value, other->second)) continue;
    constants +=
        fmt::format("; constant {} is {:.6g} before and {:.6g} after", name, value, other->second);
  }
  out.push_back({"geometry", "frames stand or move differently: " + moved + constants +
                                 "; masses, moments and inertias do not mean the same, only "
                                 "effects and predictions are compared."});
}

void compare_facts(const Model& before, const Model& after, Differences& out) {
  for (const auto& [a, b] : common_frames(before, after)) {
    if (!a->body || a->body->fixed == b->body->fixed) continue;
    out.push_back({"facts", fmt::format("the body {} is a fact in the model {} only.", a->name,
                                        a->body->fixed ? "before" : "after")});
  }
}

// Compares the bodies that only one of the models has.
void compare_bodies(const Model& before, const Model& after, Differences& out) {
  for (const bool first : {true, false}) {
    const Model& arm = first ? before : after;
    const Model& other = first ? after : before;
    for (const int k : arm.bodies()) {
      const Frame& frame = arm.frames()[k];
      if (other.find_frame(frame.name) >= 0) continue;
      const std::string mass = frame.body->phi ? fmt::format(" ({:.4g} kg)", (*frame.body->phi)[0]) : "";
      out.push_back({"body", fmt::format("only the model {} has the body {}{} on {}.", first ? "before" : "after", frame.name, mass,
                                         frame.parent ? arm.frames()[frame.parent->value].name : "the world")});
    }
  }
}

void compare_coordinates(const Model& before, const Model& after, Differences& out) {
  for (int i = 0; i < before.joints(); ++i) {
    const Coordinate& a = before.coordinates()[i];
    const Coordinate& b = after.coordinates()[i];
    if (same(a.drive_gain, b.drive_gain)) continue;
    out.push_back({"drive_gain",
                   fmt::format("drive gain of {}: {:.5g} before and {:.5g} after; where currents "
                               "were recorded, all its torques scale with it.",
                               a.name, a.drive_gain, b.drive_gain)});
  }
  const Eigen::Vector3d& g = before.gravity();
  const Eigen::Vector3d& h = after.gravity();
  if (!same(g.x(), h.x()) || !same(g.y(), h.y()) || !same(g.z(), h.z())) {
    out.push_back({"gravity", fmt::format("gravity is [{:.5g}, {:.5g}, {:.5g}] before and [{:.5g}, "
                                          "{:.5g}, {:.5g}] after.",
                                          g.x(), g.y(), g.z(), h.x(), h.y(), h.z())});
  }
}

std::string parent_of(const Model& arm, const Frame& frame) {
  return frame.parent ? arm.frames()[frame.parent->value].name : std::string();
}

std::string robot_text(const Model& arm) {
  return fmt::format("'{}' ({} coordinates, {} frames, {} bodies)", arm.name(), arm.joints(),
                     arm.frames().size(), arm.bodies().size());
}

}  // namespace

void require_one_arm(const Model& before, const Model& after) {
  std::string odd;
  if (before.joints() != after.joints()) odd = "the number of coordinates differs";
  for (int i = 0; odd.empty() && i < before.joints(); ++i) {
    const std::string& a = before.coordinates()[i].name;
    const std::string& b = after.coordinates()[i].name;
    if (a != b) odd = fmt::format("coordinate {} is '{}' and '{}'", i + 1, a, b);
  }
  for (const bool first : {true, false}) {
    const Model& arm = first ? before : after;
    const Model& other = first ? after : before;
    for (const Frame& frame : arm.frames()) {
      if (odd.empty() && frame.type != JointType::kFixed && other.find_frame(frame.name) < 0)
        odd = fmt::format("frame '{}' moves in the model {} only", frame.name, first ? "before" : "after");
    }
  }
  for (const auto& [a, b] : common_frames(before, after)) {
    if (!odd.empty()) break;
    if (parent_of(before, *a) != parent_of(after, *b) || a->type != b->type) {
      odd = fmt::format("frame '{}' hangs or moves in another way", a->name);
    } else if (a->body.has_value() != b->body.has_value()) {
      odd = fmt::format("frame '{}' has a body in one of them only", a->name);
    }
  }
  require(odd.empty(), "compare: found robot ", robot_text(before), " and robot ",
          robot_text(after), ": ", odd, "; expected two models of one arm.");
}

namespace {

// Parameters of the frame's body, written in the frame relative to which its pose is A B.
InertialParameters moved(const InertialParameters& phi, const Frame& frame) {
  const Eigen::Matrix4d H = eigen(frame.A * frame.B).matrix();
  return inertial_parameters(Eigen::Matrix4d(H * pseudo_inertia(phi) * H.transpose()));
}

// As many columns as K has rows; each is the one farthest from the span of those before it.
std::vector<Eigen::Index> independent_columns(MatrixXd K) {
  std::vector<Eigen::Index> out;
  while (static_cast<Eigen::Index>(out.size()) < K.rows()) {
    Eigen::Index best = 0;
    const double norm = K.colwise().norm().maxCoeff(&best);
    if (!(norm > 0.0)) break;
    const VectorXd u = K.col(best) / norm;
    K -= u * (u.transpose() * K);
    K.col(best).setZero();
    out.push_back(best);
  }
  return out;
}

// Removes from the combinations the parameters that the arm no longer has. The body that carries the removed
// one takes up their values, so that each combination of the remaining parameters keeps its value.
void drop_parameters(const std::set<std::string>& gone, const std::vector<StandardParameter>& kept, IdentifiedBase& base) {
  bool leads = false;
  for (IdentifiedParameter& p : base.parameters) {
    for (const std::string& name : gone) p.combination.erase(name);
    leads = leads || gone.count(p.name) != 0;
  }
  if (!leads) return;
  // Chooses new leading parameters: as many independent columns as there are combinations.
  MatrixXd K = MatrixXd::Zero(base.parameters.size(), static_cast<Eigen::Index>(kept.size()));
  for (Eigen::Index r = 0; r < K.rows(); ++r) {
    const auto& combination = base.parameters[r].combination;
    for (Eigen::Index j = 0; j < K.cols(); ++j) {
      const auto found = combination.find(kept[j].name);
      if (found != combination.end()) K(r, j) = found->second;
    }
  }
  const std::vector<Eigen::Index> leading = independent_columns(K);
  for (std::size_t r = 0; r < base.parameters.size() && r < leading.size(); ++r) {
    base.parameters[r].name = kept[leading[r]].name;
    base.parameters[r].unit = kept[leading[r]].unit;
  }
}

}  // namespace

Model without_frames_of_its_own(const Model& arm, const Model& other) {
  ModelDescription d = arm.description();
  std::set<std::string> gone;
  for (const StandardParameter& p : standard_parameters(arm)) {
    if (!p.body) continue;
    const Frame& frame = arm.frames()[arm.bodies()[*p.body]];
    if (other.find_frame(frame.name) < 0) gone.insert(p.name);
  }
  // Frames that are fixed to a removed frame come after it and are removed as well.
  for (std::size_t k = d.frames.size(); k-- > 0;) {
    const Frame frame = d.frames[k];
    if (other.find_frame(frame.name) >= 0) continue;
    if (frame.body) {
      require(frame.body->phi.has_value(), "compare: found a body without values, ", frame.name, " of '", arm.name(),
              "', expected a model that identify or diagnose wrote.");
      // A frame without a body that is fixed to the removed one, such as a flange, passes the body on to its
      // own parent.
      InertialParameters phi = moved(*frame.body->phi, frame);
      std::optional<FrameIndex> carrier = frame.parent;
      while (carrier && !d.frames[carrier->value].body && d.frames[carrier->value].type == JointType::kFixed) {
        phi = moved(phi, d.frames[carrier->value]);
        carrier = d.frames[carrier->value].parent;
      }
      require(carrier && d.frames[carrier->value].body && d.frames[carrier->value].body->phi,
              "compare: found the body ", frame.name, " of '", arm.name(),
              "' on a link without a body, expected two models of one arm.");
      *d.frames[carrier->value].body->phi += phi;
    }
    d.frames.erase(d.frames.begin() + static_cast<long>(k));
    for (Frame& below : d.frames) {
      if (below.parent && below.parent->value > static_cast<int>(k)) --below.parent->value;
    }
  }
  if (d.frames.size() == arm.frames().size()) return arm;
  std::optional<IdentifiedBase> identified = std::exchange(d.identified, std::nullopt);
  if (identified) {
    drop_parameters(gone, standard_parameters(Model(d)), *identified);
    d.identified = std::move(identified);
  }
  return Model(std::move(d));
}

std::vector<StructureDifference> structure_differences(const Model& before, const Model& after) {
  Differences out;
  compare_frames(before, after, out);
  compare_coordinates(before, after, out);
  compare_bodies(before, after, out);
  compare_facts(before, after, out);
  compare_effects(before, after, out);
  return out;
}

MatchingNames matching_names(const Model& before, const Model& after) {
  const bool one_geometry = same_geometry(before, after);
  const auto a = terms_by_place(before);
  const auto b = terms_by_place(after);
  MatchingNames out;
  for (const bool first : {true, false}) {
    const Model& arm = first ? before : after;
    std::vector<std::string> of_term(arm.effects().size());
    for (const auto& [place, terms] : first ? a : b) {
      const auto other = a.find(place);
      for (std::size_t k = 0; k < terms.size(); ++k) {
        const bool foreign = !first && other != a.end() && k < other->second.size() &&
                             !comparable(before, other->second[k], after, terms[k]);
        of_term[terms[k]] =
            fmt::format("{}#{}{}", place, k, foreign ? "'" : "");
      }
    }
    for (const StandardParameter& p : standard_parameters(arm)) {
      const std::string name = !p.effect ? p.name + (first || one_geometry ? "" : "'")
                                            : of_term[*p.effect] +
                                                  p.name.substr(p.name.rfind('.'));
      (first ? out.before : out.after).push_back(name);
    }
  }
  return out;
}

}  // namespace veridyn
