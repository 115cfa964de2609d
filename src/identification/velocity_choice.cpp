#include "identification/velocity_choice.hpp"

#include <algorithm>
#include <utility>

#include "identification/identification_numbers.hpp"
#include "math/parallel.hpp"
#include "recordings/kept_recordings.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

VectorXd log_of_square(const VectorXd& relative) {
  return 2.0 * relative.array().max(1e-300).min(1e300).log();
}

RecordingQuality quality_of(const Model& arm, const std::string& name,
                            const PreprocessingOptions& how) {
  const RecordingOptions reading = inspected_rows(arm, how);
  const auto judge = [&] { return check_rows(name, open_rows(name, reading, how.kept.get())); };
  try {
    const Recording* there = find_in_memory(how.in_memory, name);
    if (there != nullptr) return check_recording(*there);
    return how.kept ? how.kept->quality(name, reading, judge) : judge();
  } catch (const InvalidInput&) {
    return {};
  }
}

}  // namespace

RecordingOptions inspected_rows(const Model& arm, const PreprocessingOptions& how) {
  RecordingOptions reading = recording_options_for(arm, how);
  reading.first_row = std::max(0L, how.first_row);
  reading.row_count = std::min(how.row_count.value_or(identifying::kLookedAt), identifying::kLookedAt);
  return reading;
}

VectorXd log_training_errors(const Identification& id) {
  const PredictionError& error = id.train_without_excluded.relative.size() > 0
                                     ? id.train_without_excluded
                                 : id.train_repaired.relative.size() > 0 ? id.train_repaired
                                                                         : id.train_error;
  return log_of_square(error.relative);
}

VectorXd decrease_of_errors(const Identification& before, const Identification& after) {
  return (log_training_errors(before) - log_training_errors(after))
      .cwiseMin(log_of_square(before.train_error.relative) - log_of_square(after.train_error.relative));
}

VelocityChoice choose_velocities(const Identification& before, std::set<JointIndex> candidates,
                                 double least,
                                 const std::function<Identification(const std::set<JointIndex>&)>& refit) {
  for (int round = 0; round < 2 && !candidates.empty(); ++round) {
    Identification derived = refit(candidates);
    if (!derived.model) break;
    const VectorXd gain = decrease_of_errors(before, derived);
    std::set<JointIndex> better;
    for (const JointIndex j : candidates) {
      if (gain[j.value] > least) better.insert(j);
    }
    if (better == candidates) return {std::move(better), std::move(derived)};
    candidates = std::move(better);
  }
  return {};
}

std::vector<RecordingQuality> quick_quality(const Model& arm,
                                        const std::vector<std::string>& recordings,
                                        const PreprocessingOptions& how, int threads) {
  std::vector<RecordingQuality> seen(recordings.size());
  parallel_for(static_cast<int>(recordings.size()), threads, [&](int k) {
    const auto at = static_cast<size_t>(k);
    seen[at] = quality_of(arm, recordings[at], how);
  });
  return seen;
}

void derive_velocities(const std::set<JointIndex>& joints, IdentificationOptions& how) {
  how.preprocessing.derive_velocity_of.assign(joints.begin(), joints.end());
  if (how.test_preprocessing)
    how.test_preprocessing->derive_velocity_of = how.preprocessing.derive_velocity_of;
}

VelocityTrust trust_in_velocities(const Model& arm, const std::vector<std::string>& recordings,
                                  const IdentificationOptions& how) {
  const PreprocessingOptions& from = how.preprocessing;
  if (!how.choose_velocities || from.velocity != VelocitySource::kRecorded ||
      from.filtering != Filtering::kMatched || !from.derive_velocity_of.empty())
    return {};
  return trust_in_velocities(quick_quality(arm, recordings, from, how.threads));
}

Identification with_chosen_velocities(
    const Model& arm, Identification id, const std::vector<std::string>& train,
    IdentificationOptions how,
    const std::function<Identification(const IdentificationOptions&)>& again) {
  const VelocityTrust trust = trust_in_velocities(arm, train, how);
  if (!id.model) {
    if (trust.wrong.empty()) return id;
    derive_velocities(trust.wrong, how);
    Identification derived = again(how);
    if (!derived.model) return id;
    for (std::string& remark : remarks_on(trust.wrong, arm)) derived.remarks.push_back(std::move(remark));
    return derived;
  }
  std::set<JointIndex> doubted = trust.doubtful;
  doubted.insert(trust.wrong.begin(), trust.wrong.end());
  for (const RecordingError& r : id.train)
    how.preprocessing.known_periods.emplace(r.source, r.period);
  VelocityChoice choice =
      choose_velocities(id, doubted, identifying::numbers.velocity_gain, [&](const std::set<JointIndex>& joints) {
        derive_velocities(joints, how);
        return again(how);
      });
  if (!choice.fit) return id;
  for (const auto [j] : choice.better) {
    const std::string& name = arm.coordinates()[j].name;
    choice.fit->remarks.push_back(text("dq", j + 1, " (", name,
                                       ") predicts the torque worse than the derivative of q",
                                       j + 1, ", which is used instead"));
  }
  return std::move(*choice.fit);
}

std::set<JointIndex> exclude_wrong_velocities(const Model& arm, const std::vector<std::string>& train,
                                         const std::vector<std::string>& test,
                                         IdentificationOptions& how) {
  std::vector<std::string> all = train;
  all.insert(all.end(), test.begin(), test.end());
  const std::set<JointIndex> wrong = trust_in_velocities(arm, all, how).wrong;
  if (!wrong.empty()) derive_velocities(wrong, how);
  return wrong;
}

}  // namespace veridyn
