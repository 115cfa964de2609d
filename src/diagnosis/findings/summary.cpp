#include "diagnosis/findings/summary.hpp"

#include <algorithm>
#include <numeric>

#include "diagnosis/findings/held_out.hpp"
#include "veridyn/effects/cause.hpp"
#include "veridyn/effects/channel_effect.hpp"

namespace veridyn {
namespace {

// True for a wrong torque gain on a joint that also has an unnamed dependence on the same torque: the
// recorded torque is no constant multiple of the true one, as behind a limit or a dead zone.
bool is_no_factor(const Diagnosis& d, const Finding& gain) {
  if (!std::holds_alternative<ChannelError>(gain.cause) || !gain.joint) return false;
  const auto* sensor = dynamic_cast<const SensorError*>(&find_effect(effect_of(gain.cause)));
  if (sensor == nullptr || !sensor->scales_torque()) return false;
  const std::string torque = "tau" + std::to_string(gain.joint->value + 1);
  return std::any_of(d.findings.begin(), d.findings.end(), [&](const Finding& f) {
    return f.shape && f.joint == gain.joint &&
           std::find(f.shape->signals.begin(), f.shape->signals.end(), torque) != f.shape->signals.end();
  });
}

// The fewest findings that together explain most of the total. Always included are the first one that
// training confirms and held-out recordings do not contradict, and findings that do not concern the model's
// torque. Against an identified model they also include each change that explains more than 1 - share of its
// joint's error, and a load that held-out recordings contradict, because not all of them need to carry it.
std::vector<char> main_findings(const Diagnosis& d, double share) {
  std::vector<char> out(d.findings.size(), 0);
  std::vector<size_t> order(d.findings.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(), [&d](size_t a, size_t b) {
    return d.findings[a].explains > d.findings[b].explains;
  });
  double all = 0.0;
  for (const Finding& f : d.findings) all += std::max(f.explains, 0.0);
  double so_far = 0.0;
  for (const size_t k : order) {
    if (so_far >= share * all) break;
    so_far += std::max(d.findings[k].explains, 0.0);
    out[k] = 1;
  }
  const auto is_contact = [](const Finding& f) { return f.test_outside.size() > 0; };
  const auto is_change = [&](const Finding& f) {
    if (!d.changes || f.shape || f.status == FindingStatus::kNotConfirmed) return false;
    if (f.held_out() == Agreement::kContradicts) return std::holds_alternative<AddedLoad>(f.cause);
    if (!f.joint || f.test_before.size() == 0) return false;
    const auto own = [j = f.joint->value](const VectorXd& v) { return v.size() > j ? VectorXd(v.segment<1>(j)) : VectorXd(); };
    return explained_share(own(f.test_before), own(f.test_after), own(d.baseline.test_error.relative), own(d.baseline.noise_floor)) > 1.0 - share;
  };
  for (size_t k = 0; k < out.size(); ++k) out[k] = out[k] != 0 || is_contact(d.findings[k]) || is_change(d.findings[k]) ? 1 : 0;
  auto first = std::find_if(d.findings.begin(), d.findings.end(), [&](const Finding& f) {
    return !is_contact(f) && f.status != FindingStatus::kNotConfirmed && f.held_out() != Agreement::kContradicts;
  });
  if (first == d.findings.end()) first = std::find_if_not(d.findings.begin(), d.findings.end(), is_contact);
  if (first != d.findings.end()) out[first - d.findings.begin()] = 1;
  return out;
}

}  // namespace

void summarize(Diagnosis& d, const DiagnosisOptions& options) {
  const Thresholds& thresholds = options.thresholds;
  for (Finding& f : d.findings) {
    if (is_no_factor(d, f))
      f.phrase += " in the mean, in no constant proportion: what is left depends on the same torque, as behind a limit or a dead zone";
  }
  const std::vector<char> main = main_findings(d, thresholds.main_share);
  for (size_t k = 0; k < d.findings.size(); ++k) d.findings[k].main = main[k] != 0;
  std::stable_partition(d.findings.begin(), d.findings.end(),
                        [](const Finding& f) { return f.main; });
  d.small_apart = true;
  DiagnosisSummary& s = d.summary;
  for (size_t k = 0; k < d.findings.size(); ++k) {
    Finding& f = d.findings[k];
    f.rank = static_cast<int>(k) + 1;
    s.main += static_cast<int>(f.main);
    if (f.main) s.explained_by_main += f.explains;
  }
  const VectorXd& before = d.baseline.test_error.relative;
  const VectorXd& after = d.extended.test_error.relative;
  if (before.size() == 0 || after.size() != before.size()) return;
  // A curve without a name is part of no model: its residual is in its own finding, and what it predicts of
  // the difference between repeats is no noise.
  VectorXd left = after, floor = d.baseline.noise_floor;
  for (const Finding& f : d.findings) {
    if (!f.shape || !f.joint || f.test_after.size() != left.size()) continue;
    const int j = f.joint->value;
    left[j] = std::min(left[j], f.test_after[j]);
    if (floor.size() > j) floor[j] = std::min(floor[j], left[j]);
  }
  s.explained_by_all = explained_share(before, left, before, floor);
  for (Eigen::Index j = 0; j < before.size(); ++j) {
    if (after[j] > (1.0 + thresholds.held_out_worse) * before[j])
      s.worse_joints.push_back({static_cast<int>(j)});
  }
}

}  // namespace veridyn
