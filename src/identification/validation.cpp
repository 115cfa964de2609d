#include "validation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>
#include <unordered_map>
#include <utility>

#include "identification/identification_numbers.hpp"
#include "identification/recording_passes.hpp"
#include "many_recordings.hpp"
#include "math/parallel.hpp"
#include "model/noise_unit.hpp"
#include "veridyn/math/numbers.hpp"
#include "identification/velocity_choice.hpp"
#include "recordings/named_recordings.hpp"
#include "recordings/same_recording.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/effects/effect_facts.hpp"

namespace veridyn {
namespace {

// Sets the quantities that do not follow from sums of squares to NaN.
PredictionError only_relative(PredictionError error) {
  error.maximum.setConstant(std::numeric_limits<double>::quiet_NaN());
  error.moving_relative.setConstant(std::numeric_limits<double>::quiet_NaN());
  return error;
}

// Errors from factors alone, where samples are not available: sums of squares only.
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
        x[c] = values[index.at(block[i].columns()[c])];
      sums.torque2[static_cast<Eigen::Index>(i)] += block[i].rhs_norm2();
      sums.error2[static_cast<Eigen::Index>(i)] += block[i].residual2(x);
    }
  }
  out.source = recording.source;
  out.error = only_relative(sums.error());
  out.filled = recording.facts.filled;
  out.rows = recording.facts.rows_read;
  out.noise_floor = recording.noise_floor;
  out.period = recording.period.seconds;
  return sums;
}

// Rms residuals of the fitted rows.
VectorXd rms_residuals(const Model& arm, const Identification& id) {
  VectorXd squares = VectorXd::Zero(arm.joints());
  VectorXd rows = squares;
  for (const CompressedRecording& r : id.factors) {
    RecordingError unused;
    squares += factor_errors(arm, r, id.parameters, unused).error2;
    for (const auto& block : r.blocks) {
      for (size_t i = 0; i < block.size(); ++i) rows[static_cast<Eigen::Index>(i)] += block[i].rows();
    }
  }
  return squares.cwiseQuotient(rows.cwiseMax(1.0)).cwiseSqrt();
}

// Factor for residuals with a longer correlation time: it converts them to equivalent residuals with one
// independent sample in kNoiseSeconds. Noise that is held for T seconds (a zero-order hold), with a column
// that oscillates at f hertz, gives sqrt(T / kNoiseSeconds) |sinc(pi f T)|.
double correlation_inflation(const Model& arm, const Identification& id) {
  double seconds = 0.0;
  for (const CompressedRecording& r : id.factors) seconds += r.facts.duration;
  if (!(id.effective_samples > 0.0)) return 1.0;
  return std::sqrt(std::max(1.0, seconds * arm.joints() / id.effective_samples / kNoiseSeconds));
}

// True if some recording has this kind of error.
bool any_has(const std::vector<RecordingError>& recordings, PredictionError RecordingError::* figure) {
  return std::any_of(recordings.begin(), recordings.end(), [figure](const RecordingError& r) {
    return (r.*figure).relative.size() > 0;
  });
}

PredictionError total_error(const std::vector<MeasuredErrors>& all, ErrorSums MeasuredErrors::* sums,
                      int joints) {
  ErrorSums out(joints);
  for (const MeasuredErrors& one : all) out.add(one.*sums);
  return out.error();
}

}  // namespace

Identification empty_identification(const Model& arm, const IdentificationOptions& options) {
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
  VectorXd least = VectorXd::Constant(joints, kInfinity), sum = VectorXd::Zero(joints), count = sum;
  bool repeats = false;
  for (const CompressedRecording& r : recordings) {
    if (r.noise_floor.size() == 0) continue;
    least = least.cwiseMin(r.noise_floor);
    repeats = true;
  }
  if (!repeats) return {};
  for (const CompressedRecording& r : recordings) {
    for (int i = 0; i < joints && r.noise_floor.size() > 0; ++i) {
      if (r.noise_floor[i] > identifying::kOnce * least[i]) continue;
      sum[i] += r.noise_floor[i] * r.noise_floor[i];
      count[i] += 1.0;
    }
  }
  return sum.cwiseQuotient(count).cwiseSqrt();
}

std::string no_sample_left(const CompressedRecording& recording, const PreprocessingOptions& how) {
  const double cut = how.drop_start + how.drop_end;
  std::string out = recording.source + ": no usable samples are left after gaps, edges and row limits";
  if (recording.facts.duration <= cut)
    out += text("; it lasts ", recording.facts.duration, " s, of which --drop-start ", how.drop_start, " and --drop-end ", how.drop_end, " cut ", cut,
                " s: ten seconds and more are needed");
  return out;
}

bool without_torque(const CompressedRecording& recording) {
  return std::all_of(recording.joints.begin(), recording.joints.end(), [](const TorqueFacts& joint) {
    return std::max(-joint.minimum, joint.maximum) < identifying::numbers.no_torque;
  });
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
      std::any_of(how.excluded_intervals.begin(), how.excluded_intervals.end(),
                  [&](const ExcludedInterval& part) { return part.source == recording.source; });
  if (excludes) out.without_excluded = found.without_excluded.error();
  out.error = found.as_recorded.error();
  return found;
}

MeasuredRecording measure(const Model& arm, const CompressedRecording& recording,
                          const PreprocessingOptions& how, const VectorXd& values,
                          int series_samples, int threads) {
  const ErrorSums none(arm.joints());
  MeasuredRecording out{{}, {none, none, none}, false};
  if (recording.detached) {
    out.sums.repaired = factor_errors(arm, recording, values, out.error);
    out.sums.as_recorded = out.sums.without_excluded = out.sums.repaired;
    out.detached = true;
    return out;
  }
  out.error.series.wanted = series_samples;
  const auto predict = [&](const PreprocessingOptions& with, PredictionSeries* series,
                           ErrorSums* without_excluded) {
    return prediction_error(arm, recording.source, with, values, recording.joints, series,
                            without_excluded, threads);
  };
  out.sums = measure_errors(recording, how, predict, out.error);
  return out;
}

int series_samples_of_each(int recordings) {
  const int usual = PredictionSeries().wanted;
  return std::clamp(identifying::kSeriesSamples / std::max(1, recordings), identifying::kFewestSamples, usual);
}

std::vector<CompressedRecording> compress_test(const Model& arm,
                                               const std::vector<std::string>& test,
                                               const PreprocessingOptions& how, int threads) {
  const std::vector<CompressedRecording> out =
      compress_each(test, threads, [&](const std::string& path, int own) { return compress_facts(arm, path, how, own); });
  for (const CompressedRecording& r : out) {
    require(
        r.rows > 0.0, r.source,
        ": found no usable samples after gaps, edges and row limits, expected some to test on.");
    require(!without_torque(r), r.source, ": the torques of all joints are zero throughout, expected some to test on.");
  }
  return out;
}

void set_errors(const Model& arm, std::vector<MeasuredRecording> train,
                 std::vector<MeasuredRecording> test, Identification& id) {
  struct Part {
    std::vector<MeasuredRecording>& measured;
    std::vector<RecordingError>& out;
    PredictionError& error;
    PredictionError& repaired;
    PredictionError& without_excluded;
  };
  for (const Part& part :
       {Part{train, id.train, id.train_error, id.train_repaired, id.train_without_excluded},
        Part{test, id.test, id.test_error, id.test_repaired, id.test_without_excluded}}) {
    std::vector<MeasuredErrors> sums;
    bool detached = false;
    part.out.clear();
    for (MeasuredRecording& r : part.measured) {
      sums.push_back(std::move(r.sums));
      detached = detached || r.detached;
      part.out.push_back(std::move(r.error));
    }
    const auto figure = [&](PredictionError RecordingError::* of_one,
                            ErrorSums MeasuredErrors::* of_sums) {
      return any_has(part.out, of_one) ? total_error(sums, of_sums, arm.joints()) : PredictionError();
    };
    part.error = figure(&RecordingError::error, &MeasuredErrors::as_recorded);
    if (detached) {
      part.error = only_relative(std::move(part.error));
      continue;
    }
    part.repaired = figure(&RecordingError::repaired, &MeasuredErrors::repaired);
    part.without_excluded =
        figure(&RecordingError::without_excluded, &MeasuredErrors::without_excluded);
  }
}

namespace {

// Remarks on the share of each recording that gaps exclude.
void remark_on_gaps(const std::vector<CompressedRecording>& recordings,
                    std::vector<std::string>& remarks) {
  for (const CompressedRecording& r : recordings) {
    const double share = static_cast<double>(r.facts.unused) / static_cast<double>(std::max(1L, r.facts.samples));
    if (share < identifying::numbers.few_in_gaps) continue;
    remarks.push_back(fmt::format("{}: {:.2g} % of the samples lie in gaps or beside them and are not used",
                                  r.source, 100.0 * share));
  }
}

// Marks test recordings that share rows with training recordings, and joints that rest in all test recordings.
void judge_tests(const std::vector<Coordinate>& joints, const std::vector<CompressedRecording>& held_out, Identification& id) {
  for (size_t t = 0; t < held_out.size(); ++t) {
    for (const CompressedRecording& r : id.factors) {
      const double share = share_of_rows(held_out[t].facts.row_hashes, r.facts.row_hashes);
      if (share < identifying::numbers.learned_rows) continue;
      id.test[t].learned_from = r.source;
      // A copy written with fewer digits has some rows that are rounded differently.
      const std::string part = share > 1.0 - identifying::numbers.learned_rows ? "its rows" : fmt::format("{:.0f} % of its rows", 100.0 * share);
      const std::string what = r.source == held_out[t].source ? "it is learned from, too" : part + " are rows of " + r.source + ", which is learned from";
      id.warnings.push_back(held_out[t].source + ": " + what + ": its error is not held out; test on another recording");
      break;
    }
  }
  if (held_out.empty() || id.factors.empty()) return;
  const auto rests = [&](const std::vector<CompressedRecording>& tests, size_t joint) {
    const auto of_each = [joint](const std::vector<CompressedRecording>& all, auto figure) {
      std::vector<double> out;
      for (const CompressedRecording& r : all) out.push_back(figure(r.joints[joint]));
      std::sort(out.begin(), out.end());
      return out;
    };
    // One training recording in another unit must not make the tests seem at rest.
    const auto usual = [](const std::vector<double>& sorted) { return sorted[(sorted.size() - 1) / 2]; };
    const auto little = [&](auto figure) { return of_each(tests, figure).back() < identifying::numbers.hardly_moves * usual(of_each(id.factors, figure)); };
    return little([](const TorqueFacts& j) { return j.travel(); }) && little([](const TorqueFacts& j) { return j.largest_speed; });
  };
  for (size_t i = 0; i < joints.size(); ++i) {
    if (rests(held_out, i)) id.still_in_test.push_back(joints[i].name);
  }
  for (const CompressedRecording& r : held_out) {
    bool all = true;
    for (size_t i = 0; i < joints.size(); ++i) all = all && rests({r}, i);
    if (all)
      id.warnings.push_back(r.source + ": the arm hardly moves, and dry friction holds any torque within its band: gravity can be judged up to that, friction and inertia cannot; test on a motion");
  }
}

}  // namespace

MeasuredRecordings RecordingPasses::measure(const Model& arm, const std::vector<std::string>& test, int threads,
                                            const Identification& id) const {
  const std::vector<CompressedRecording>& trained = id.factors;
  MeasuredRecordings out{compress_test(arm, test, id.test_preprocessing, threads), {}, {}};
  const auto count = static_cast<int>(trained.size() + out.held_out.size());
  std::vector<std::optional<MeasuredRecording>> measured(trained.size() + out.held_out.size());
  parallel_for(count, threads, [&](int k) {
    const auto at = static_cast<size_t>(k);
    const bool of_training = at < trained.size();
    measured[at] = veridyn::measure(arm, of_training ? trained[at] : out.held_out[at - trained.size()],
                                    of_training ? id.preprocessing : id.test_preprocessing, id.parameters,
                                    series_samples_of_each(count), threads_of_each(count, threads));
  });
  for (size_t k = 0; k < measured.size(); ++k)
    (k < trained.size() ? out.train : out.test).push_back(std::move(*measured[k]));
  return out;
}

void validate(const Model& arm, const std::vector<std::string>& test, const IdentificationOptions& options,
              const RecordingPasses& passes, Identification& id) {
  const auto begin = std::chrono::steady_clock::now();
  MeasuredRecordings measured = passes.measure(arm, test, options.threads, id);
  set_errors(arm, std::move(measured.train), std::move(measured.test), id);
  judge_tests(arm.coordinates(), measured.held_out, id);
  for (const auto* recordings : {&id.factors, &measured.held_out}) remark_on_gaps(*recordings, id.remarks);
  id.seconds.validate =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

void validate(const Model& arm, const std::vector<std::string>& test, const IdentificationOptions& options,
              Identification& id) {
  validate(arm, test, options, RecordingPasses(), id);
}

void store_training_error(Identification& id) {
  ModelDescription description = id.model->description();
  description.identified->error = id.train_error.relative;
  description.identified->noise = rms_residuals(*id.model, id) * correlation_inflation(*id.model, id);
  id.model = Model(std::move(description));
}

bool has_all_values(const Model& arm) {
  if (!arm.inertial_values()) return false;
  for (const EffectTerm& term : arm.effects()) {
    if (!EffectFacts(arm, term).has_values()) return false;
  }
  return true;
}

Model with_fixed_parameters(const Model& arm) {
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
  Identification id = empty_identification(arm, options);
  const Model facts = with_fixed_parameters(arm);
  const std::vector<StandardParameter> parameters = standard_parameters(facts);
  id.parameters.resize(static_cast<Eigen::Index>(parameters.size()));
  for (size_t p = 0; p < parameters.size(); ++p)
    id.parameters[static_cast<Eigen::Index>(p)] = parameters[p].value;
  id.factors = compress_all(facts, train, id.preprocessing, options.threads);
  for (const CompressedRecording& r : id.factors) {
    id.rows += r.rows;
    if (r.rows > 0.0) continue;
    id.reason = no_sample_left(r, id.preprocessing);
    return id;
  }
  if (std::all_of(id.factors.begin(), id.factors.end(), [](const CompressedRecording& r) { return without_torque(r); })) {
    id.reason = id.factors.front().source + ": the torques of all joints are zero throughout: not recorded? Record the efforts, or name their columns by --map tau=SOURCE";
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
  NamedRecordings<IdentificationOptions> named(train, test, options);
  keep_recordings(named.how, KeptRecordings::kFewPasses);
  const std::set<JointIndex> wrong = exclude_wrong_velocities(arm, named.train, named.test, named.how);
  Identification id = evaluate_named(arm, named.train, named.test, named.how);
  for (std::string& remark : remarks_on(wrong, arm)) id.remarks.push_back(std::move(remark));
  drop_recordings(id);
  return id;
}

}  // namespace veridyn
