#include "validation.hpp"

#include <chrono>
#include <utility>

#include "veridyn/math/parallel.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {

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
  id.train.resize(trained.size());
  id.test.resize(test.size());
  std::vector<ErrorSums> sums(trained.size() + test.size(), ErrorSums(arm.joints()));
  parallel_for(static_cast<int>(sums.size()), options.threads, [&](int k) {
    const auto t = static_cast<size_t>(k);
    const bool is_train = t < trained.size();
    const CompressedRecording& recording = is_train ? trained[t] : held_out[t - trained.size()];
    RecordingError& out = is_train ? id.train[t] : id.test[t - trained.size()];
    const PreprocessingOptions& how = is_train ? id.preprocessing : id.test_preprocessing;
    sums[t] =
        prediction_error(arm, recording.source, how, id.parameters, recording.joints, &out.series);
    out.source = recording.source;
    out.noise_floor = recording.noise_floor;
    out.period = recording.period.seconds;
    out.error = sums[t].error();
  });
  ErrorSums train_sums(arm.joints());
  ErrorSums test_sums(arm.joints());
  for (size_t t = 0; t < sums.size(); ++t)
    (t < trained.size() ? train_sums : test_sums).add(sums[t]);
  id.train_error = train_sums.error();
  if (!test.empty()) id.test_error = test_sums.error();
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
