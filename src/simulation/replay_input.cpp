#include <algorithm>
#include <set>

#include "recordings/velocity_trust.hpp"
#include "veridyn/simulation/replay.hpp"

namespace veridyn {
ReplayInput replay_input(const Model& arm, const std::string& recording, PreprocessingOptions how) {
  ReplayInput out;
  out.quality = check_recording(recording, recording_options_for(arm, how));
  const std::set<JointIndex> wrong = trust_in_velocities({out.quality}).wrong;
  how.derive_velocity_of.assign(wrong.begin(), wrong.end());
  for (const JointIndex joint : wrong) {
    const auto why = std::find_if(out.quality.findings.begin(), out.quality.findings.end(),
                                  [joint](const QualityFinding& f) {
                                    return makes_velocity_wrong(f) && f.joint == joint;
                                  });
    out.remarks.push_back(why->sentence + " The replay takes it from the position.");
  }
  std::vector<double> time;
  std::vector<MatrixXd> pieces[4];
  const auto collect = [&](const Segment& s) {
    const Eigen::Index first = s.core_begin;
    const Eigen::Index count = s.core_end - s.core_begin;
    for (Eigen::Index k = first; k < first + count; ++k) {
      time.push_back(s.time[k]);
      out.use.push_back(s.use[k]);
    }
    const MatrixXd* all[] = {&s.q, &s.dq, &s.ddq, &s.tau};
    for (size_t m = 0; m < 4; ++m) pieces[m].emplace_back(all[m]->middleRows(first, count));
  };
  const PreparationFacts facts = for_each_segment(arm, recording, how, collect);
  if (facts.filled.count > 0)
    out.remarks.push_back(filled_text(facts.filled, facts.rows_read) + ".");
  MatrixXd* const whole[] = {&out.motion.q, &out.motion.dq, &out.motion.ddq, &out.tau};
  for (size_t m = 0; m < 4; ++m) {
    whole[m]->resize(static_cast<Eigen::Index>(time.size()), arm.joints());
    Eigen::Index row = 0;
    for (const MatrixXd& piece : pieces[m]) {
      whole[m]->middleRows(row, piece.rows()) = piece;
      row += piece.rows();
    }
  }
  out.motion.time =
      Eigen::Map<const VectorXd>(time.data(), static_cast<Eigen::Index>(time.size()));
  return out;
}

}  // namespace veridyn
