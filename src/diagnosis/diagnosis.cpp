#include "veridyn/diagnosis/diagnosis.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <set>
#include <utility>

#include "geometry.hpp"
#include "selection.hpp"
#include "veridyn/effects/effect.hpp"
#include "veridyn/math/parallel.hpp"
#include "veridyn/math/student_t.hpp"

namespace veridyn {
namespace {

constexpr int kListed = 40;  // of what the data rule out
constexpr double kWeaker =
    0.3;  // a cause that gains this share of a wrong constant's gain is named as its weaker rival

std::vector<CompressedRecording> compress_all(const Model& arm,
                                              const std::vector<std::string>& paths,
                                              const PreprocessingOptions& preprocessing,
                                              int threads) {
  std::vector<CompressedRecording> out(paths.size());
  parallel_for(static_cast<int>(paths.size()), threads, [&](int k) {
    out[static_cast<size_t>(k)] = compress(arm, paths[static_cast<size_t>(k)], preprocessing);
  });
  return out;
}

// All that one run of questions needs.
struct Inquiry {
  AugmentedModel augmented;
  std::vector<CompressedRecording> train, test;
  ColumnSet base;
  std::vector<std::string> columns;
};

Inquiry prepare(const Identification& baseline, const std::vector<std::string>& train,
                const std::vector<std::string>& test, const DiagnosisOptions& options) {
  Inquiry q{augmented_model(*baseline.model, baseline.factors, options.effects), {}, {}, {}, {}};
  const IdentificationOptions& how = options.identification;
  q.train = compress_all(q.augmented.model, train, how.preprocessing, how.threads);
  q.test = compress_all(q.augmented.model, test, how.test_preprocessing.value_or(how.preprocessing),
                        how.threads);
  const std::vector<std::string> names = parameter_names(standard_parameters(q.augmented.model));
  const Model& arm = *baseline.model;
  const BaseParameters base = base_parameters(arm);
  for (const int j : base.independent) {
    q.base.push_back(static_cast<int>(q.columns.size()));
    q.columns.push_back(names[static_cast<size_t>(j)]);
  }
  for (const Hypothesis& h : q.augmented.hypotheses)
    q.columns.insert(q.columns.end(), h.columns.begin(), h.columns.end());
  return q;
}

VectorXd relative_error(const NormalBlocks& test, const ColumnSet& set, const VectorXd& x) {
  const VectorXd r2 = test.residual2(set, x, test.total());
  return (r2.array() / test.total().b2.array().max(1e-300)).sqrt();
}

// Held-out error of the models that grow by one finding at a time.
std::vector<VectorXd> errors_along_the_way(const Inquiry& q, const NormalBlocks& data,
                                           const Selection& selection) {
  const NormalBlocks test(q.test, q.columns, data.scale());
  std::vector<VectorXd> out;
  ColumnSet set = q.base;
  for (size_t k = 0; k <= selection.accepted.size(); ++k) {
    VectorXd w = data.total().rows.array() / data.total().b2.array().max(1e-300);
    for (int round = 0; round < 2; ++round) {
      const VectorXd x = data.solve(set, w, data.total(), nullptr);
      w = data.total().rows.array() / data.residual2(set, x, data.total())
                                          .array()
                                          .max(1e-12 * data.total().b2.array().max(1e-290));
    }
    out.push_back(relative_error(test, set, data.solve(set, w, data.total(), nullptr)));
    if (k == selection.accepted.size()) break;
    const Hypothesis& h =
        q.augmented.hypotheses[static_cast<size_t>(selection.accepted[k].evidence.hypothesis)];
    const ColumnSet own = columns_of(data, h);
    set.insert(set.end(), own.begin(), own.end());
  }
  return out;
}

std::vector<FoundParameter> parameters_of(const Inquiry& q, const NormalBlocks& data,
                                          const Selection& selection, const Hypothesis& h) {
  const EffectTerm& term = q.augmented.model.effects()[static_cast<size_t>(h.term)];
  const BoundEffect bound(q.augmented.model, term);
  const double t = student_t_quantile(0.05, selection.degrees_of_freedom);
  std::vector<FoundParameter> out;
  for (int p = 0; p < bound.parameter_count(); ++p) {
    FoundParameter found{bound.parameters()[static_cast<size_t>(p)].name, bound.unit(p), 0.0, 0.0,
                         0.0};
    for (size_t k = 0; k < selection.columns.size(); ++k) {
      if (data.names()[static_cast<size_t>(selection.columns[k])] !=
          h.columns[static_cast<size_t>(p)])
        continue;
      const auto at = static_cast<Eigen::Index>(k);
      found.value = selection.values[at];
      found.low = found.value - t * selection.standard_deviations[at];
      found.high = found.value + t * selection.standard_deviations[at];
    }
    out.push_back(found);
  }
  return out;
}

std::string sentence(const Inquiry& q, const Hypothesis& h, const Finding& finding) {
  const BoundEffect bound(q.augmented.model,
                          q.augmented.model.effects()[static_cast<size_t>(h.term)]);
  std::vector<double> values;
  for (const FoundParameter& p : finding.parameters) values.push_back(p.value);
  return "Joint " + std::to_string(finding.joint) + " (" + finding.coordinate +
         "): " + bound.phrase(values) + ".";
}

// Sum over joints of the squared error above the noise floor: what a better model could remove.
double removable(const VectorXd& error, const VectorXd& floor) {
  const VectorXd below =
      floor.size() == error.size() ? VectorXd(floor.cwiseAbs2()) : VectorXd::Zero(error.size());
  return (error.cwiseAbs2() - below).cwiseMax(0.0).sum();
}

// Share of the removable error that goes away between two held-out errors.
double explained(const VectorXd& before, const VectorXd& after, const Identification& baseline) {
  if (before.size() == 0 || after.size() == 0) return 0.0;
  const double all = removable(baseline.test_error.relative, baseline.noise_floor);
  if (all <= 0.0) return 0.0;
  return std::min(
      1.0,
      (removable(before, baseline.noise_floor) - removable(after, baseline.noise_floor)) / all);
}

void add_findings(const Inquiry& q, const NormalBlocks& data, const Selection& selection,
                  Diagnosis& d) {
  const std::vector<VectorXd> errors = errors_along_the_way(q, data, selection);
  for (size_t k = 0; k < selection.accepted.size(); ++k) {
    const Accepted& a = selection.accepted[k];
    const Hypothesis& h = q.augmented.hypotheses[static_cast<size_t>(a.evidence.hypothesis)];
    Finding f;
    f.rank = static_cast<int>(d.findings.size()) + 1;
    f.effect = h.effect;
    f.joint = h.joint + 1;
    f.coordinate = q.augmented.model.coordinates()[static_cast<size_t>(h.joint)].name;
    f.parameters = parameters_of(q, data, selection, h);
    if (!f.parameters.empty()) f.unit = f.parameters.front().unit;
    f.p_value = a.evidence.p_value;
    f.gain = a.evidence.gain;
    f.test_before = errors[k];
    f.test_after = errors[k + 1];
    f.explains = explained(errors[k], errors[k + 1], d.baseline);
    for (const Evidence& e : a.rivals) {
      const Hypothesis& other = q.augmented.hypotheses[static_cast<size_t>(e.hypothesis)];
      f.rivals.push_back({other.effect, other.joint + 1,
                          q.augmented.model.coordinates()[static_cast<size_t>(other.joint)].name,
                          "gains within 20 % as much on held-out data"});
    }
    f.sentence = sentence(q, h, f);
    d.findings.push_back(std::move(f));
  }
}

// One line for every family that was asked and not accepted.
void add_the_rest(const Inquiry& q, const Selection& selection, Diagnosis& d) {
  std::set<std::string> known;
  for (const Accepted& a : selection.accepted)
    known.insert(q.augmented.hypotheses[static_cast<size_t>(a.evidence.hypothesis)].family);
  std::vector<Evidence> rest = selection.last_asked;
  std::sort(rest.begin(), rest.end(),
            [](const Evidence& a, const Evidence& b) { return a.gain > b.gain; });
  for (const Evidence& e : rest) {
    const Hypothesis& h = q.augmented.hypotheses[static_cast<size_t>(e.hypothesis)];
    if (!known.insert(h.family).second) continue;
    if (e.absorbed) {
      d.cannot_tell.push_back(
          {h.effect, h.joint + 1,
           "its torque is a combination of parameters that the model has already"});
    } else if (static_cast<int>(d.not_supported.size()) < kListed) {
      d.not_supported.push_back({h.effect, h.joint + 1, e.p_value});
    }
  }
}

Model extended_arm(const Identification& baseline, const Inquiry& q, const Selection& selection) {
  ModelDescription description = baseline.model->description();
  for (const Accepted& a : selection.accepted) {
    const Hypothesis& h = q.augmented.hypotheses[static_cast<size_t>(a.evidence.hypothesis)];
    description.effects.push_back(q.augmented.model.effects()[static_cast<size_t>(h.term)]);
  }
  return Model(description);
}

bool asks_for(const DiagnosisOptions& options, const std::string& effect) {
  return options.effects.empty() ||
         std::find(options.effects.begin(), options.effects.end(), effect) != options.effects.end();
}

// How well the best effect would do in place of a wrong constant, and which ones come near.
std::vector<std::pair<Hypothesis, double>> effects_instead(const Inquiry& q,
                                                           const NormalBlocks& data,
                                                           const DiagnosisOptions& options) {
  DiagnosisOptions none = options;
  none.max_effects = 0;
  const Selection asked = select_effects(data, q.base, q.augmented.hypotheses, none);
  std::vector<Evidence> all = asked.last_asked;
  std::sort(all.begin(), all.end(),
            [](const Evidence& a, const Evidence& b) { return a.gain > b.gain; });
  std::vector<std::pair<Hypothesis, double>> out;
  std::set<std::string> named;
  for (const Evidence& e : all) {
    const Hypothesis& h = q.augmented.hypotheses[static_cast<size_t>(e.hypothesis)];
    if (e.absorbed || e.sign_broken || !named.insert(h.family).second) continue;
    out.emplace_back(h, e.gain);
  }
  return out;
}

// The held-out gain of correcting a constant, measured as every other gain is.
double correction_gain(const Model& corrected, const Inquiry& q, const NormalBlocks& data,
                       const std::vector<std::string>& train, const IdentificationOptions& how) {
  const std::vector<CompressedRecording> factors =
      compress_all(corrected, train, how.preprocessing, how.threads);
  const std::vector<std::string> names = parameter_names(standard_parameters(corrected));
  std::vector<std::string> columns;
  ColumnSet base;
  for (const int j : base_parameters(corrected).independent) {
    base.push_back(static_cast<int>(columns.size()));
    columns.push_back(names[static_cast<size_t>(j)]);
  }
  return fold_gain(data, q.base, NormalBlocks(factors, columns), base);
}

// A wrong constant goes before any effect that explains no more: asked the other way round it comes
// back as several effects.
std::optional<Finding> wrong_constant(const Model& arm,
                                      const std::vector<GeometryFinding>& geometry,
                                      const Inquiry& q, const NormalBlocks& data,
                                      const std::vector<std::string>& train,
                                      const DiagnosisOptions& options) {
  if (geometry.empty()) return std::nullopt;
  GeometryFinding best = geometry.front();
  const double profiled = best.gain;
  best.gain = correction_gain(with_constant(arm, best.constant, best.found), q, data, train,
                              options.identification);
  if (best.gain < 2.0 * options.smallest_gain) return std::nullopt;
  const auto instead = effects_instead(q, data, options);
  if (!instead.empty() && best.gain < options.rival_share * instead.front().second)
    return std::nullopt;
  Finding f;
  f.rank = 1;
  f.effect = "coupling_error";
  const Frame& frame = arm.frames()[static_cast<size_t>(best.constant.frame)];
  f.frame = frame.name;
  int joint = 0;
  for (int i = 0; i < arm.joints(); ++i) {
    if (arm.moves(best.constant.frame, i)) joint = i;
  }
  f.joint = joint + 1;
  f.coordinate = arm.coordinates()[static_cast<size_t>(joint)].name;
  f.unit = best.constant.kind == GeometryConstant::Kind::kCoefficient ? "1"
           : best.constant.angle                                      ? "rad"
                                                                      : "m";
  const double t = student_t_quantile(0.05, 7.0);
  f.parameters.push_back({"value", f.unit, best.found, best.found - t * best.deviation,
                          best.found + t * best.deviation});
  f.parameters.push_back({"correction", f.unit, best.found - best.constant.value,
                          best.found - best.constant.value - t * best.deviation,
                          best.found - best.constant.value + t * best.deviation});
  f.gain = best.gain;
  f.p_value = best.deviation > 0.0
                  ? student_t_two_sided((best.found - best.constant.value) / best.deviation, 7.0)
                  : 0.05;
  for (size_t k = 1; k < geometry.size(); ++k) {
    if (geometry[k].gain < options.rival_share * profiled) continue;
    f.rivals.push_back(
        {"coupling_error", f.joint, f.coordinate,
         "another constant, " + geometry[k].constant.name + ", would explain as much"});
  }
  for (const auto& [h, gain] : instead) {
    if (gain < kWeaker * best.gain || f.rivals.size() > 5) break;
    f.rivals.push_back({h.effect, h.joint + 1, arm.coordinates()[static_cast<size_t>(h.joint)].name,
                        "hides it: alone it gains " +
                            std::to_string(static_cast<int>(100.0 * gain / best.gain)) +
                            " % as much"});
  }
  const std::string number = f.unit == "rad" ? std::to_string(180.0 / M_PI * best.found) + " deg"
                                             : std::to_string(best.found) + " " + f.unit;
  const std::string stands = f.unit == "rad"
                                 ? std::to_string(180.0 / M_PI * best.constant.value) + " deg"
                                 : std::to_string(best.constant.value) + " " + f.unit;
  f.sentence = "The robot file has a wrong constant: " + best.constant.name + " is " + stands +
               " there; the recordings ask for " + number + ".";
  return f;
}

}  // namespace

Diagnosis diagnose(const Model& arm, const std::vector<std::string>& train,
                   const std::vector<std::string>& test, const DiagnosisOptions& options) {
  const auto begin = std::chrono::steady_clock::now();
  Diagnosis d;
  d.provisional = train.size() == 1;
  std::vector<std::string> all = train;
  all.insert(all.end(), test.begin(), test.end());
  const PreprocessingOptions& how = options.identification.preprocessing;
  d.data_quality.resize(all.size());
  parallel_for(static_cast<int>(all.size()), options.identification.threads, [&](int k) {
    RecordingOptions reading;
    reading.columns = how.columns;
    reading.rate = how.header_rate;
    d.data_quality[static_cast<size_t>(k)] = check_recording(all[static_cast<size_t>(k)], reading);
  });
  d.baseline = identify(arm, train, test, options.identification);
  if (!d.baseline.model) return d;
  Identification start = d.baseline;
  Inquiry q = prepare(start, train, test, options);
  std::optional<NormalBlocks> data(std::in_place, q.train, q.columns);
  if (asks_for(options, "coupling_error")) {
    const std::vector<GeometryFinding> geometry =
        profile_geometry(arm, train, options.identification);
    if (std::optional<Finding> wrong = wrong_constant(arm, geometry, q, *data, train, options)) {
      start = identify(with_constant(arm, geometry.front().constant, geometry.front().found), train,
                       test, options.identification);
      wrong->test_before = d.baseline.test_error.relative;
      wrong->test_after = start.test_error.relative;
      wrong->explains = explained(wrong->test_before, wrong->test_after, d.baseline);
      d.findings.push_back(*wrong);
      q = prepare(start, train, test, options);
      data.emplace(q.train, q.columns);
    }
  }
  const Selection selection = select_effects(*data, q.base, q.augmented.hypotheses, options);
  std::set<std::string> families;
  for (const Hypothesis& h : q.augmented.hypotheses) families.insert(h.family);
  d.hypotheses = static_cast<int>(families.size());
  if (!test.empty()) add_findings(q, *data, selection, d);
  add_the_rest(q, selection, d);
  d.extended = selection.accepted.empty() ? start
                                          : identify(extended_arm(start, q, selection), train, test,
                                                     options.identification);
  d.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return d;
}

}  // namespace veridyn
