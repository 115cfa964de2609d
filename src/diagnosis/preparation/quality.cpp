#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <utility>

#include "diagnosis/preparation/diagnosis_state.hpp"
#include "identification/velocity_choice.hpp"
#include "math/parallel.hpp"
#include "recordings/kept_recordings.hpp"
#include "recordings/velocity_trust.hpp"

// Excludes faulty data from the recordings, and fits the arm to the rest.

namespace veridyn {
namespace {

// A velocity that is inconsistent with its position is replaced by the position's derivative.
void exclude_wrong_velocities(DiagnosisState& x) {
  for (RecordingQuality& recording : x.d.data_quality) {
    for (QualityFinding& f : recording.findings) {
      if (makes_velocity_wrong(f)) f.sentence += "; the velocity of this joint is taken from its position";
    }
  }
  derive_velocities(trust_in_velocities(x.d.data_quality).wrong, x.options.identification);
}

void remark_derived_velocity(JointIndex joint, DiagnosisState& x) {
  for (const RecordingQuality& recording : x.d.data_quality) {
    for (const QualityFinding& f : recording.findings) {
      if (f.kind != QualityKind::kVelocityNoise || f.joint != joint) continue;
      x.remarks.push_back(f.sentence +
                          " It is taken from the position: torques are predicted better.");
      x.d.remarks = x.remarks;
      return;
    }
  }
}

std::vector<RecordingQuality> quality_of_training(const DiagnosisState& x) {
  std::vector<RecordingQuality> out;
  for (const RecordingQuality& recording : x.d.data_quality) {
    if (std::find(x.train.begin(), x.train.end(), recording.file) != x.train.end())
      out.push_back(recording);
  }
  return out;
}

// Where a noisy velocity changes its sign at random at low speed, dry friction computed from it resembles
// other effects. A velocity that is noisier than the derivative of its position is replaced by that
// derivative where this predicts the joint's torque better, by the margin that a cause needs.
void choose_quieter_velocities(DiagnosisState& x) {
  const PreprocessingOptions& how = x.options.identification.preprocessing;
  if (how.velocity == VelocitySource::kDerived) return;
  const std::set<JointIndex> known(how.derive_velocity_of.begin(), how.derive_velocity_of.end());
  std::set<JointIndex> noisy = trust_in_velocities(quality_of_training(x)).doubtful;
  for (const JointIndex j : known) noisy.erase(j);
  const Thresholds& limits = x.options.thresholds;
  const double least = x.d.changes ? limits.smallest_change : limits.smallest_gain;
  VelocityChoice choice = choose_velocities(x.d.baseline, noisy, least,
                                            [&](std::set<JointIndex> joints) {
                                              joints.insert(known.begin(), known.end());
                                              derive_velocities(joints, x.options.identification);
                                              return x.fit(x.arm);
                                            });
  if (!choice.fit) {
    derive_velocities(known, x.options.identification);
    return;
  }
  x.d.baseline = std::move(*choice.fit);
  for (const JointIndex j : choice.better) remark_derived_velocity(j, x);
}

// Stores the periods of the recordings, which later steps need many times.
void store_periods(DiagnosisState& x) {
  IdentificationOptions& how = x.options.identification;
  std::map<std::string, double>& known = how.preprocessing.known_periods;
  for (const auto* list : {&x.d.baseline.train, &x.d.baseline.test}) {
    for (const RecordingError& r : *list) known.emplace(r.source, r.period);
  }
  if (how.test_preprocessing) how.test_preprocessing->known_periods = known;
}

}  // namespace

void leave_out(const std::vector<ExcludedInterval>& parts, DiagnosisState& x) {
  IdentificationOptions& how = x.options.identification;
  how.preprocessing.excluded_intervals.insert(how.preprocessing.excluded_intervals.end(), parts.begin(), parts.end());
  if (how.test_preprocessing) {
    auto& there = how.test_preprocessing->excluded_intervals;
    there.insert(there.end(), parts.begin(), parts.end());
  }
  x.d.excluded_intervals.insert(x.d.excluded_intervals.end(), parts.begin(), parts.end());
}

namespace {

// Joins parts that overlap.
void merge_overlaps(std::vector<ExcludedInterval>& parts) {
  std::sort(parts.begin(), parts.end(), [](const auto& a, const auto& b) { return a.from < b.from; });
  std::vector<ExcludedInterval> out;
  for (ExcludedInterval& part : parts) {
    if (out.empty() || part.from > out.back().to) out.push_back(std::move(part));
    else out.back().to = std::max(out.back().to, part.to);
  }
  parts = std::move(out);
}

// A torque at the limit of its channel only bounds the true one (a censored observation), and would bias the
// parameters. Such rows are excluded, and so are the rows to which the low-pass spreads them, half a wave at
// its cut-off on either side.
void exclude_saturated(DiagnosisState& x) {
  const double cutoff = x.options.identification.preprocessing.cutoff;
  const double margin = cutoff > 0.0 ? 0.5 / cutoff : 0.0;
  for (const RecordingQuality& quality : x.d.data_quality) {
    std::map<JointIndex, std::vector<ExcludedInterval>> of_joint;
    for (const SaturatedInterval& one : quality.saturated)
      of_joint[one.joint].push_back({quality.file, one.joint, one.from - margin, one.to + margin, "torque at its limit"});
    for (auto& [index, parts] : of_joint) {
      const int joint = index.value;
      if (joint >= x.arm.joints()) continue;
      merge_overlaps(parts);
      double seconds = 0.0;
      for (const ExcludedInterval& part : parts) seconds += part.to - part.from;
      const Coordinate& own = x.arm.coordinates()[joint];
      const bool too_many = seconds > 0.5 * quality.duration;
      x.remarks.push_back(fmt::format(
          "{}: the torque of joint {} ({}) stands at its limit: {:.2g} s {}.", quality.file, joint + 1, own.name, seconds,
          too_many ? "of it, too much to be left out" : "of it are left out, and not counted in what its error is made of"));
      if (too_many) continue;
      leave_out(parts, x);
      x.saturated.insert(joint);
    }
  }
}

}  // namespace

void check_quality(DiagnosisState& x) {
  std::vector<std::string> all = x.train;
  for (const std::string& path : x.test) {
    if (std::find(all.begin(), all.end(), path) == all.end()) all.push_back(path);
  }
  x.options.identification.choose_velocities = false;  // choose_quieter_velocities() does it once
  const PreprocessingOptions& how = x.options.identification.preprocessing;
  x.d.data_quality.resize(all.size());
  parallel_for(static_cast<int>(all.size()), x.options.identification.threads, [&](int k) {
    const std::string& name = all[k];
    const Recording* there = find_in_memory(how.in_memory, name);
    RecordingQuality& quality = x.d.data_quality[k];
    quality = there != nullptr ? check_recording(*there)
                               : check_rows(name, open_rows(name, recording_options_for(x.arm, how), how.kept.get()));
    quality.file = name;
  });
  exclude_wrong_velocities(x);
  exclude_saturated(x);
}

namespace {

// False if there is no fit yet, or if check_quality() has changed the rows since.
bool fits_current_rows(const Identification& fit, const DiagnosisState& x) {
  const PreprocessingOptions& how = x.options.identification.preprocessing;
  return fit.model && fit.preprocessing.derive_velocity_of == how.derive_velocity_of &&
         fit.preprocessing.excluded_intervals.size() == how.excluded_intervals.size();
}

}  // namespace

bool fit_baseline(DiagnosisState& x) {
  const Model file = x.arm;
  const JointFriction friction = x.options.identification.friction;
  if (!fits_current_rows(x.d.baseline, x)) x.d.baseline = x.fit(x.arm);
  if (!x.d.baseline.model) return false;
  // From here on the arm is the identified one, with added effects.
  const size_t given = file.effects().size();
  if (x.d.baseline.model->effects().size() > given) {
    x.arm = with_friction(file, friction);
    if (x.arm.effects().size() > x.d.baseline.model->effects().size())
      x.arm = with_friction_alone(file, friction);
    x.d.friction_remark = friction_remark(file, x.arm);
    x.d.baseline.remarks.clear();  // reported once
  }
  x.options.identification.friction = JointFriction::kFile;
  choose_quieter_velocities(x);
  store_periods(x);
  x.start = x.d.baseline;
  return true;
}

}  // namespace veridyn
