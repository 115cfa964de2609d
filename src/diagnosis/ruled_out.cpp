#include "ruled_out.hpp"

#include <algorithm>
#include <set>
#include <vector>

namespace veridyn {
namespace {

constexpr size_t kListed = 60;  // of what the data rule out

std::string place_text(const Model& arm, const Hypothesis& h) {
  if (h.body >= 0) return "on " + arm.frames()[static_cast<size_t>(h.frame)].name;
  if (h.joint < 0) return "of the arm";
  return "on joint " + std::to_string(h.joint + 1);
}

// Why a hypothesis that these data can answer was not accepted.
std::string why_not(const Evidence& e, const DiagnosisOptions& limits) {
  if (e.sign_broken) return "its value would have an impossible sign or size";
  if (e.gain <= 0.0) return "held-out data are predicted no better";
  if (e.gain <= limits.smallest_gain) return "held-out data gain too little from it";
  if (!e.consistent) return "it helps in some of the held-out parts only";
  return "its value is not certain enough among so many questions";
}

}  // namespace

void add_ruled_out(const Inquiry& asked, const NormalBlocks& asked_data, const Selection& selection,
                   const Fit& fit, const std::map<std::string, double>& unconfirmed,
                   const DiagnosisOptions& limits, Diagnosis& d) {
  std::set<std::string> known;
  for (const Hypothesis& h : fit.inquiry.augmented.hypotheses) known.insert(h.family);
  std::vector<Evidence> rest = selection.last_asked;
  const auto rank = [](const Evidence& e) { return e.taken ? 0 : e.absorbed ? 2 : 1; };
  std::stable_sort(rest.begin(), rest.end(), [&rank](const Evidence& a, const Evidence& b) {
    return rank(a) != rank(b) ? rank(a) < rank(b) : a.gain > b.gain;
  });
  for (const Evidence& e : rest) {
    const Hypothesis& h = asked.augmented.hypotheses[static_cast<size_t>(e.hypothesis)];
    if (!known.insert(h.family).second) continue;
    const auto refuted = unconfirmed.find(h.family);
    if (refuted != unconfirmed.end()) {
      d.not_supported.push_back({h.effect, h.joint + 1, refuted->second,
                                 "it helps in training, but not on the held-out recordings"});
    } else if (e.taken) {
      d.not_supported.push_back({h.effect, h.joint + 1, e.p_value,
                                 "other findings explain it once their constants are refined"});
    } else if (e.absorbed) {
      const bool moves = !columns_of(asked_data, h).empty();
      d.cannot_tell.push_back(
          {h.effect, h.joint + 1,
           moves ? "its torque is a combination of parameters that the model has already"
                 : "it never acts in these recordings"});
      if (h.body >= 0)
        d.cannot_tell.back().why += " (" + place_text(asked.augmented.model, h) + ")";
    } else if (d.not_supported.size() < kListed) {
      d.not_supported.push_back({h.effect, h.joint + 1, e.p_value, why_not(e, limits)});
    }
  }
  if (!d.changes) {
    d.cannot_tell.push_back(
        {"payload", 0, "without a model from before, a load is part of the link it sits on"});
  }
}

}  // namespace veridyn
