#include "comparison/model_structure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "veridyn/effects/effect.hpp"
#include "veridyn/regressor/standard_parameters.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

// Relative difference of shape constants up to which effects are comparable.
constexpr double kLike = 0.2;
constexpr double kSame = 1e-9;  // relative to 1 + |a|: what files lose in rounding is less

bool same(double a, double b) {
  return a == b || std::abs(a - b) <= kSame * (1.0 + std::abs(a));
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
         a.variable.coefficients.isApprox(b.variable.coefficients, kSame);
}

// Identifies an effect's terms, without their shape constants.
std::string place_of(const Model& arm, const EffectTerm& term) {
  std::string out = term.effect + "(" + axis_text(arm, term.axis);
  if (term.from) out += " from " + axis_text(arm, *term.from);
  if (!term.frame.empty()) out += " on " + term.frame;
  return out + ")";
}

std::vector<double> shape_of(const Model& arm, const EffectTerm& term) {
  const BoundEffect bound(arm, term);
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
      return shape_of(arm, arm.effects()[static_cast<std::size_t>(a)]) <
             shape_of(arm, arm.effects()[static_cast<std::size_t>(b)]);
    });
  }
  return out;
}

// True if the shapes differ so little that the parameters keep their meaning.
bool comparable(const Model& before, int term_before, const Model& after, int term_after) {
  const std::vector<double> a =
      shape_of(before, before.effects()[static_cast<std::size_t>(term_before)]);
  const std::vector<double> b =
      shape_of(after, after.effects()[static_cast<std::size_t>(term_after)]);
  for (std::size_t s = 0; s < a.size(); ++s) {
    if (std::abs(a[s] - b[s]) > kLike * std::max(std::abs(a[s]), std::abs(b[s]))) return false;
  }
  return true;
}

bool same_geometry(const Model& before, const Model& after) {
  for (std::size_t k = 0; k < before.frames().size(); ++k) {
    if (!same_place(before.frames()[k], after.frames()[k])) return false;
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
      const EffectTerm& ta = before.effects()[static_cast<std::size_t>(in_a->second[k])];
      const EffectTerm& tb = after.effects()[static_cast<std::size_t>(in_b->second[k])];
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
  for (std::size_t k = 0; k < before.frames().size(); ++k) {
    if (same_place(before.frames()[k], after.frames()[k])) continue;
    moved += (moved.empty() ? "" : ", ") + before.frames()[k].name;
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
  for (const int k : before.bodies()) {
    const Frame& a = before.frames()[static_cast<std::size_t>(k)];
    const Frame& b = after.frames()[static_cast<std::size_t>(k)];
    if (a.body->fixed == b.body->fixed) continue;
    out.push_back({"facts", fmt::format("the body {} is a fact in the model {} only.", a.name,
                                        a.body->fixed ? "before" : "after")});
  }
}

void compare_coordinates(const Model& before, const Model& after, Differences& out) {
  for (int i = 0; i < before.joints(); ++i) {
    const Coordinate& a = before.coordinates()[static_cast<std::size_t>(i)];
    const Coordinate& b = after.coordinates()[static_cast<std::size_t>(i)];
    if (same(a.drive_gain, b.drive_gain)) continue;
    out.push_back({"drive_gain",
                   fmt::format("drive gain of {}: {:.5g} before and {:.5g} after; where currents "
                               "were recorded, all its torques scale with it.",
                               a.name, a.drive_gain, b.drive_gain)});
  }
  const Eigen::Vector3d g = before.gravity();
  const Eigen::Vector3d h = after.gravity();
  if (!same(g.x(), h.x()) || !same(g.y(), h.y()) || !same(g.z(), h.z())) {
    out.push_back({"gravity", fmt::format("gravity is [{:.5g}, {:.5g}, {:.5g}] before and [{:.5g}, "
                                          "{:.5g}, {:.5g}] after.",
                                          g.x(), g.y(), g.z(), h.x(), h.y(), h.z())});
  }
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
    const std::string& a = before.coordinates()[static_cast<std::size_t>(i)].name;
    const std::string& b = after.coordinates()[static_cast<std::size_t>(i)].name;
    if (a != b) odd = fmt::format("coordinate {} is '{}' and '{}'", i + 1, a, b);
  }
  if (odd.empty() && before.frames().size() != after.frames().size())
    odd = "the number of frames differs";
  for (std::size_t k = 0; odd.empty() && k < before.frames().size(); ++k) {
    const Frame& a = before.frames()[k];
    const Frame& b = after.frames()[k];
    if (a.name != b.name) {
      odd = fmt::format("frame {} is '{}' and '{}'", k + 1, a.name, b.name);
    } else if (a.parent != b.parent || a.type != b.type) {
      odd = fmt::format("frame '{}' hangs or moves in another way", a.name);
    } else if (a.body.has_value() != b.body.has_value()) {
      odd = fmt::format("frame '{}' has a body in one of them only", a.name);
    }
  }
  require(odd.empty(), "compare: found robot ", robot_text(before), " and robot ",
          robot_text(after), ": ", odd, "; expected two models of one arm.");
}

std::vector<StructureDifference> structure_differences(const Model& before, const Model& after) {
  Differences out;
  compare_frames(before, after, out);
  compare_coordinates(before, after, out);
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
        of_term[static_cast<std::size_t>(terms[k])] =
            fmt::format("{}#{}{}", place, k, foreign ? "'" : "");
      }
    }
    for (const StandardParameter& p : standard_parameters(arm)) {
      const std::string name = p.effect < 0 ? p.name + (first || one_geometry ? "" : "'")
                                            : of_term[static_cast<std::size_t>(p.effect)] +
                                                  p.name.substr(p.name.rfind('.'));
      (first ? out.before : out.after).push_back(name);
    }
  }
  return out;
}

}  // namespace veridyn
