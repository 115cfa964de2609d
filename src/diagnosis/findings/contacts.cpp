#include "diagnosis/findings/contacts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "diagnosis/numerics.hpp"
#include "math/student_t.hpp"
#include "veridyn/effects/cause.hpp"

namespace veridyn {
namespace {

std::string efforts_words(const Model& arm, const Contact& c) {
  std::string out;
  for (Eigen::Index i = 0; i <= c.last_joint; ++i) {
    const Coordinate& joint = arm.coordinates()[i];
    out += fmt::format("{}{:.2g} {} on joint {} ({})", i == 0 ? "" : ", ", c.effort[i],
                       effort_unit(joint), i + 1, joint.name);
  }
  return out;
}

}  // namespace

std::vector<ExcludedInterval> excluded_intervals(const std::vector<Contact>& contacts) {
  std::vector<ExcludedInterval> out;
  for (const Contact& c : contacts)
    out.push_back({c.source, {}, c.from - numerics::kContactMargin,
                   c.to + numerics::kContactMargin, ExternalContact::kName});
  return out;
}

namespace {

Finding finding_of(const Contact& c, const Identification& seen) {
  const Model& arm = *seen.model;
  Finding f;
  f.cause = ExternalContact{{c.last_joint}};
  f.joint = JointIndex{c.last_joint};
  const Coordinate& joint = arm.coordinates()[c.last_joint];
  f.source = c.source;
  f.unit = effort_unit(joint);
  const double effort = c.effort[c.last_joint];
  const double half = student_t_quantile(numerics::kOutside, numerics::kContactFreedom) * c.deviation;
  f.parameters = {{"effort", f.unit, effort, effort - half, effort + half},
                  {"from", "s", c.from, c.from, c.from},
                  {"to", "s", c.to, c.to, c.to}};
  for (int i = 0; i < c.last_joint; ++i) {
    const Coordinate& inner = arm.coordinates()[i];
    f.parameters.push_back({"effort_" + inner.name, effort_unit(inner), c.effort[i], c.effort[i], c.effort[i]});
  }
  f.p_value = student_t_two_sided(c.peak, numerics::kContactFreedom);
  // A push is no error of the model: these are the held-out errors with and without its intervals.
  f.test_before = seen.test_error.relative;
  f.test_after = seen.test_error.relative;
  f.test_outside = seen.test_without_excluded.relative.size() > 0 ? seen.test_without_excluded.relative : seen.test_error.relative;
  f.phrase = fmt::format(
      "from {:.1f} to {:.1f} s something pushes the arm on link {} or beyond it: {} (mean "
      "torque that the model does not explain). These {:.1f} s are left out of the fit",
      c.from, c.to, words_of(arm, f.cause).frame, efforts_words(arm, c), c.to - c.from);
  return f;
}

}  // namespace

std::vector<Finding> findings_of(const std::vector<Contact>& contacts, const Identification& seen) {
  std::vector<Finding> out;
  std::map<int, std::pair<size_t, int>> of_joint;  // index of the finding, and number of pushes
  for (const Contact& c : contacts) {
    Finding f = finding_of(c, seen);
    const auto [at, is_first] = of_joint.emplace(c.last_joint, std::make_pair(out.size(), 1));
    if (is_first) {
      out.push_back(std::move(f));
      continue;
    }
    auto& [own, count] = at->second;
    ++count;
    out[own].phrase += fmt::format("; {}: from {:.1f} to {:.1f} s", c.source, c.from, c.to);
    out[own].p_value = std::min(out[own].p_value, f.p_value);
    for (FoundParameter& p : f.parameters) {
      p.name += fmt::format("_{}", count);
      out[own].parameters.push_back(std::move(p));
    }
  }
  return out;
}

}  // namespace veridyn
