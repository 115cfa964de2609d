#include <algorithm>
#include <ostream>

#include "diagnosis/of_identification.hpp"
#include "veridyn/effects/effect.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

// The identified arm with free parameters; the manufacturer's values are those of the robot file.
Model with_free_parameters(const Model& identified) {
  ModelDescription d = identified.description();
  d.identified.reset();
  for (Frame& frame : d.frames) {
    if (!frame.body || frame.body->fixed) continue;
    if (frame.body->prior) d.values = RobotValues::kPrior;
    frame.body->phi = frame.body->prior;
    frame.body->std_phi.reset();
  }
  for (EffectTerm& term : d.effects) {
    if (term.fixed) continue;
    for (const EffectParameter& p : find_effect(term.effect).parameters()) term.values.erase(p.name);
    term.deviations.clear();
  }
  return Model(std::move(d));
}

}  // namespace

Diagnosis diagnose(const Identification& fit, const Recordings& test, const DiagnosisOptions& options) {
  if (!fit.model) {  // its status and reason say why
    Diagnosis out;
    out.baseline = fit;
    return out;
  }
  std::vector<std::string> train;
  for (const RecordingError& recording : fit.train) train.push_back(recording.source);
  require(!train.empty(), "diagnose: found an identification without recordings, expected one of identify() with some.");
  DiagnosisOptions how = options;
  how.identification.method = fit.method;
  how.identification.condition = fit.condition;
  how.identification.signs = fit.signs;
  how.identification.preprocessing = fit.preprocessing;
  how.identification.preprocessing.interrupted = options.identification.preprocessing.interrupted;
  how.identification.test_preprocessing = fit.test_preprocessing;
  how.identification.friction = JointFriction::kFile;  // the fit has added it already
  return diagnose(with_free_parameters(*fit.model), train, test, how, &fit);
}

std::ostream& operator<<(std::ostream& out, const Finding& finding) { return out << finding.text; }

std::ostream& operator<<(std::ostream& out, const Diagnosis& diagnosis) { return out << diagnosis.report(); }

void save(const Diagnosis& diagnosis, const std::string& path, const std::string& command,
          const std::string& robot) {
  save(diagnosis.extended.model ? diagnosis.extended : diagnosis.baseline, path, command, robot);
}

}  // namespace veridyn
