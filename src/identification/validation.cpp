#include "validation.hpp"

#include <algorithm>
#include <chrono>
#include <limits>
#include <unordered_map>
#include <utility>

#include "math/parallel.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr int kSeriesSamples = 30000;  // for plots, of all recordings together

// What sums of squares alone cannot tell is not a number.
PredictionError only_relative(PredictionError error) {
  error.maximum.setConstant(std::numeric_limits<double>::quiet_NaN());
  error.moving_relative.setConstant(std::numeric_limits<double>::quiet_NaN());
  return error;
}

PredictionError total(const std::vector<ErrorSums>& all, int joints) {
  ErrorSums out(joints);
  for (const ErrorSums& one : all) out.add(one);
  return out.error();
}

// Errors on the rows of factors whose samples are elsewhere: sums of squares and nothing else.
ErrorSums factor_errors(const Model& arm, const CompressedRecording& recording,
                        const VectorXd& values, RecordingError& out) {
  std::unordered_map<std::string, Eigen::Index> index;
  for (const StandardParameter& p : standard_parameters(arm))
    index.emplace(p.name, static_cast<Eigen::Index>(index.size()));
  ErrorSums sums(arm.joints());
  for (const auto& block : recording.blocks) {
    for (size_t i = 0; i < block.size(); ++i) {
      VectorXd x(block[i].size());
      for (Eigen::Index c = 0; c < x.size(); ++c)
        x[c] = values[index.at(block[i].columns()[static_cast<size_t>(c)])];
      sums.torque2[static_cast<Eigen::Index>(i)] += block[i].rhs_norm2();
      sums.error2[static_cast<Eigen::Index>(i)] += block[i].residual2(x);
    }
  }
  out.source = recording.source;
  out.error = only_relative(sums.error());
  out.filled = recording.facts.filled;
  out.as_recorded = {};
  out.rows = recording.facts.rows_read;
  out.noise_floor = recording.noise_floor;
  out.period = recording.period.seconds;
  return sums;
}

bool any_filled(const std::vector<RecordingError>& recordings) {
  return std::any_of(recordings.begin(), recordings.end(),
                     [](const RecordingError& r) { return r.filled.count > 0; });
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
  const ErrorSums prepared = predict(how, &out.series);
  out.source = recording.source;
  out.error = prepared.error();
  out.filled = recording.facts.filled;
  out.rows = recording.facts.rows_read;
  out.noise_floor = recording.noise_floor;
  out.period = recording.period.seconds;
  if (out.filled.count == 0) return {prepared, prepared};
  PreprocessingOptions kept = how;
  kept.stale_rows = StaleRows::kKept;
  const ErrorSums as_recorded = predict(kept, nullptr);
  out.as_recorded = as_recorded.error();
  return {prepared, as_recorded};
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
    std::vector<ErrorSums> prepared, as_recorded;
  };
  Part parts[] = {{trained, id.preprocessing, id.train, {}, {}},
                  {held_out, id.test_preprocessing, id.test, {}, {}}};
  for (Part& part : parts) {
    part.out.resize(part.recordings.size());
    part.prepared.assign(part.recordings.size(), ErrorSums(arm.joints()));
    part.as_recorded = part.prepared;
  }
  const auto count = static_cast<int>(trained.size() + test.size());
  parallel_for(count, options.threads, [&](int k) {
    const auto t = static_cast<size_t>(k);
    Part& part = parts[t < trained.size() ? 0 : 1];
    const size_t at = t < trained.size() ? t : t - trained.size();
    const CompressedRecording& recording = part.recordings[at];
    if (recording.detached) {
      part.prepared[at] = factor_errors(arm, recording, id.parameters, part.out[at]);
      part.as_recorded[at] = part.prepared[at];
      return;
    }
    part.out[at].series.wanted = std::clamp(kSeriesSamples / count, 100, part.out[at].series.wanted);
    const auto predict = [&](const PreprocessingOptions& how, PredictionSeries* series) {
      return prediction_error(arm, recording.source, how, id.parameters, recording.joints, series,
                              threads_of_each(count, options.threads));
    };
    MeasuredErrors found = measure_errors(recording, part.how, predict, part.out[at]);
    part.prepared[at] = std::move(found.prepared);
    part.as_recorded[at] = std::move(found.as_recorded);
  });
  id.train_error = total(parts[0].prepared, arm.joints());
  const bool detached = std::any_of(trained.begin(), trained.end(),
                                    [](const CompressedRecording& r) { return r.detached; });
  if (detached) id.train_error = only_relative(std::move(id.train_error));
  if (any_filled(id.train) && !detached) id.train_as_recorded = total(parts[0].as_recorded, arm.joints());
  if (!test.empty()) id.test_error = total(parts[1].prepared, arm.joints());
  if (any_filled(id.test)) id.test_as_recorded = total(parts[1].as_recorded, arm.joints());
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

Identification evaluate(const Model& arm, const std::vector<std::string>& train,
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

}  // namespace veridyn
