#include "validation.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "math/parallel.hpp"
#include "recordings/named_recordings.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

bool any(const std::vector<RecordingError>& recordings, PredictionError RecordingError::* figure) {
  return std::any_of(recordings.begin(), recordings.end(), [figure](const RecordingError& r) {
    return (r.*figure).relative.size() > 0;
  });
}

PredictionError total(const std::vector<MeasuredErrors>& all, ErrorSums MeasuredErrors::* sums,
                      int joints) {
  ErrorSums out(joints);
  for (const MeasuredErrors& one : all) out.add(one.*sums);
  return out.error();
}

}  // namespace

Identification described(const Model& arm, const IdentificationOptions& options) {
  Identification id;
  id.robot = arm.name();
  id.method = options.method;
  id.weights = options.weights;
  id.condition = options.condition;
  id.signs = options.signs;
  if (options.prior) id.prior = options.prior->name();
  id.preprocessing = options.preprocessing;
  id.test_preprocessing = options.test_preprocessing.value_or(options.preprocessing);
  return id;
}

VectorXd mean_noise_floor(const std::vector<CompressedRecording>& recordings, int joints) {
  VectorXd sum = VectorXd::Zero(joints);
  int count = 0;
  for (const CompressedRecording& r : recordings) {
    if (r.noise_floor.size() == 0) continue;
    sum += r.noise_floor.cwiseAbs2();
    ++count;
  }
  return count > 0 ? VectorXd((sum / count).cwiseSqrt()) : VectorXd();
}

MeasuredErrors measure_errors(const CompressedRecording& recording, const PreprocessingOptions& how,
                              const Predict& predict, RecordingError& out) {
  MeasuredErrors found{ErrorSums(0), ErrorSums(0), ErrorSums(0)};
  found.repaired = predict(how, &out.series, &found.without_excluded);
  out.source = recording.source;
  out.filled = recording.facts.filled;
  out.rows = recording.facts.rows_read;
  out.noise_floor = recording.noise_floor;
  out.period = recording.period.seconds;
  found.as_recorded = found.repaired;
  if (out.filled.count > 0) {
    PreprocessingOptions kept = how;
    kept.stale_rows = StaleRows::kKept;
    found.as_recorded = predict(kept, nullptr, nullptr);
    out.repaired = found.repaired.error();
  }
  const bool excludes =
      std::any_of(how.left_out.begin(), how.left_out.end(),
                  [&](const LeftOut& part) { return part.source == recording.source; });
  if (excludes) out.without_excluded = found.without_excluded.error();
  out.error = found.as_recorded.error();
  return found;
}

void validate(const Model& arm, const std::vector<std::string>& test,
              const IdentificationOptions& options, Identification& id) {
  const auto begin = std::chrono::steady_clock::now();
  const std::vector<CompressedRecording>& trained = id.factors;
  const std::vector<CompressedRecording> held_out =
      compress_all(arm, test, id.test_preprocessing, options.threads);
  for (const CompressedRecording& r : held_out)
    require(
        r.rows > 0.0, r.source,
        ": found no usable samples after gaps, edges and row limits, expected some to test on.");
  // Of the training recordings and of the held-out ones.
  struct Part {
    const std::vector<CompressedRecording>& recordings;
    const PreprocessingOptions& how;
    std::vector<RecordingError>& out;
    std::vector<MeasuredErrors> measured;
  };
  Part parts[] = {{trained, id.preprocessing, id.train, {}},
                  {held_out, id.test_preprocessing, id.test, {}}};
  const ErrorSums none(arm.joints());
  for (Part& part : parts) {
    part.out.resize(part.recordings.size());
    part.measured.assign(part.recordings.size(), {none, none, none});
  }
  parallel_for(static_cast<int>(trained.size() + test.size()), options.threads, [&](int k) {
    const auto t = static_cast<size_t>(k);
    Part& part = parts[t < trained.size() ? 0 : 1];
    const size_t at = t < trained.size() ? t : t - trained.size();
    const CompressedRecording& recording = part.recordings[at];
    const auto predict = [&](const PreprocessingOptions& how, PredictionSeries* series,
                             ErrorSums* without_excluded) {
      return prediction_error(arm, recording.source, how, id.parameters, recording.joints, series,
                              without_excluded);
    };
    part.measured[at] = measure_errors(recording, part.how, predict, part.out[at]);
  });
  const auto figure = [&](const Part& part, PredictionError RecordingError::* of_one,
                          ErrorSums MeasuredErrors::* sums) {
    return any(part.out, of_one) ? total(part.measured, sums, arm.joints()) : PredictionError();
  };
  for (const Part& part : parts) {
    const bool trains = &part == &parts[0];
    (trains ? id.train_error : id.test_error) =
        figure(part, &RecordingError::error, &MeasuredErrors::as_recorded);
    (trains ? id.train_repaired : id.test_repaired) =
        figure(part, &RecordingError::repaired, &MeasuredErrors::repaired);
    (trains ? id.train_without_excluded : id.test_without_excluded) =
        figure(part, &RecordingError::without_excluded, &MeasuredErrors::without_excluded);
  }
  id.seconds.validate =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

bool has_all_values(const Model& arm) {
  if (!arm.inertial_values()) return false;
  for (const EffectTerm& term : arm.effects()) {
    if (!BoundEffect(arm, term).has_values()) return false;
  }
  return true;
}

Model frozen(const Model& arm) {
  ModelDescription d = arm.description();
  for (Frame& frame : d.frames) {
    if (frame.body) frame.body->fixed = true;
  }
  for (EffectTerm& term : d.effects) term.fixed = true;
  return Model(std::move(d));
}

namespace {

Identification evaluate_named(const Model& arm, const std::vector<std::string>& train,
                              const std::vector<std::string>& test,
                              const IdentificationOptions& options) {
  require(!train.empty(), "evaluate: there is no recording.");
  require(has_all_values(arm), "evaluate: robot '", arm.name(), "' has parameters without values.");
  Identification id = described(arm, options);
  const Model facts = frozen(arm);
  const std::vector<StandardParameter> parameters = standard_parameters(facts);
  id.parameters.resize(static_cast<Eigen::Index>(parameters.size()));
  for (size_t p = 0; p < parameters.size(); ++p)
    id.parameters[static_cast<Eigen::Index>(p)] = parameters[p].value;
  id.factors = compress_all(facts, train, id.preprocessing, options.threads);
  for (const CompressedRecording& r : id.factors) {
    id.rows += r.rows;
    if (r.rows > 0.0) continue;
    id.reason = r.source + ": no usable samples are left after gaps, edges and row limits";
    return id;
  }
  id.noise_floor = mean_noise_floor(id.factors, arm.joints());
  validate(facts, test, options, id);
  id.status = IdentificationStatus::kDone;
  id.model = arm;
  return id;
}

}  // namespace

Identification evaluate(const Model& arm, const Recordings& train, const Recordings& test,
                        const IdentificationOptions& options) {
  const NamedRecordings<IdentificationOptions> named(train, test, options);
  Identification id = evaluate_named(arm, named.train, named.test, named.how);
  forget_recordings(id);
  return id;
}

}  // namespace veridyn
