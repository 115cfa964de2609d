#include "recordings/velocity_trust.hpp"

#include "veridyn/math/require.hpp"

namespace veridyn {

bool makes_velocity_wrong(const QualityFinding& f) {
  const bool judged = f.kind == QualityKind::kVelocityScale || f.kind == QualityKind::kVelocitySign ||
                      f.kind == QualityKind::kVelocityQuantised || f.kind == QualityKind::kVelocityUnrelated || f.kind == QualityKind::kVelocityDelay ||
                      (f.kind == QualityKind::kDegrees && f.signal == "dq");
  return judged && f.severity != Severity::kInfo && f.joint;
}

VelocityTrust trust_in_velocities(const std::vector<RecordingQuality>& recordings) {
  VelocityTrust out;
  for (const RecordingQuality& recording : recordings) {
    for (const QualityFinding& f : recording.findings) {
      if (makes_velocity_wrong(f)) out.wrong.insert(*f.joint);
      if (f.kind == QualityKind::kVelocityNoise && f.joint) out.doubtful.insert(*f.joint);
    }
  }
  for (const JointIndex joint : out.wrong) out.doubtful.erase(joint);
  return out;
}

std::vector<std::string> remarks_on(const std::set<JointIndex>& wrong, const Model& arm) {
  std::vector<std::string> out;
  for (const auto [j] : wrong) {
    out.push_back(text("dq", j + 1, " (", arm.coordinates()[j].name, ") is no derivative of q",
                       j + 1, ", which is used instead"));
  }
  return out;
}

}  // namespace veridyn
