#include "diagnosis/findings/contacts.hpp"

#include <fmt/format.h>

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

void add_contacts(const std::vector<Contact>& contacts, const Identification& seen, Diagnosis& d) {
  const Model& arm = *seen.model;
  for (const Contact& c : contacts) {
    Finding f;
    f.rank = static_cast<int>(d.findings.size()) + 1;
    f.cause = ExternalContact{{c.last_joint}};
    f.joint = JointIndex{c.last_joint};
    const Coordinate& joint = arm.coordinates()[c.last_joint];
    f.source = c.source;
    f.unit = effort_unit(joint);
    const double effort = c.effort[c.last_joint];
    const double half =
        student_t_quantile(numerics::kOutside, numerics::kContactFreedom) * c.deviation;
    f.parameters = {{"effort", f.unit, effort, effort - half, effort + half},
                    {"from", "s", c.from, c.from, c.from},
                    {"to", "s", c.to, c.to, c.to}};
    for (int i = 0; i < c.last_joint; ++i) {
      const Coordinate& inner = arm.coordinates()[i];
      f.parameters.push_back({"effort_" + inner.name, effort_unit(inner), c.effort[i], c.effort[i], c.effort[i]});
    }
    f.p_value = student_t_two_sided(c.peak, numerics::kContactFreedom);
    // A push is no error of the model: gives the held-out error with and without these intervals.
    f.test_before = seen.test_error.relative;
    f.test_after = seen.test_error.relative;
    f.test_outside = seen.test_without_excluded.relative.size() > 0
                         ? seen.test_without_excluded.relative
                         : seen.test_error.relative;
    f.phrase = fmt::format(
        "from {:.1f} to {:.1f} s something pushes the arm on link {} or beyond it: {} (mean "
        "torque that the model does not explain). These {:.1f} s are left out of the fit",
        c.from, c.to, words_of(arm, f.cause).frame, efforts_words(arm, c), c.to - c.from);
    d.findings.push_back(std::move(f));
  }
}

}  // namespace veridyn
