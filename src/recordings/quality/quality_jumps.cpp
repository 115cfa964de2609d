// Finds position steps that the neighbouring motion cannot explain.
#include <algorithm>
#include <cmath>

#include "recordings/quality/quality_checks.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::quality {
namespace {

class JumpTally : public Tally {
 public:
  explicit JumpTally(const Head& head) : step_(head.step), joints_(static_cast<std::size_t>(head.rows.joints())) {
    for (std::size_t joint = 0; joint < joints_.size(); ++joint) {
      const auto q = head.rows.q.col(static_cast<int>(joint));
      std::vector<double> change;  // second differences of the position
      for (int k = 2; k < q.size(); ++k) change.push_back(std::abs(q[k] - 2.0 * q[k - 1] + q[k - 2]));
      const double noise = change.empty() ? 0.0 : quantile(std::move(change), 1.0 - numbers.ends);
      joints_[joint].tolerance = std::max({numbers.smallest_jump, numbers.jump_noise * noise, numbers.jump_range * range_of(q)});
    }
  }

  void add(const Piece& piece) override {
    const Recording& rows = piece.rows;
    for (int k = 3; k + 3 < rows.rows(); ++k) {
      if (rows.time[k] - rows.time[k - 1] > numbers.hole * step_) continue;
      for (std::size_t joint = 0; joint < joints_.size(); ++joint) {
        const int j = static_cast<int>(joint);
        if (is_jump(rows, k, j)) joints_[joint].add(rows.q(k, j) - rows.q(k - 1, j), rows.q(k - 1, j) - rows.q(k - 2, j), rows.time[k]);
      }
    }
  }

  void conclude(Findings* findings) const override {
    long count = 0, onward = 0, jumping = 0;
    for (const Joint& joint : joints_) {
      count += joint.count;
      onward += joint.onward;
      jumping += joint.count > 0 ? 1 : 0;
    }
    const bool together = jumping > 1;
    const bool lost = together && count >= numbers.fewest_lost && static_cast<double>(onward) > numbers.onward * static_cast<double>(count);
    for (std::size_t joint = 0; joint < joints_.size(); ++joint) {
      const Joint& tally = joints_[joint];
      if (tally.count == 0) continue;
      const Channel position{&kRecordingSignals[0], static_cast<int>(joint)};
      const double turns = tally.largest / kTurn;
      const bool wrapped = std::round(turns) != 0.0 && std::abs(turns - std::round(turns)) < numbers.turn_error;
      findings->add(Severity::kFault, QualityKind::kJumps, position.place(), {kNone, tally.largest, position.unit()},
                    text("The position of ", position.name(), " jumps ", counted(tally.count, "time"),
                         ", by ", number(tally.largest), " at t = ", number(tally.largest_at), " s",
                         wrapped    ? ": a full turn, the angle is wrapped."
                         : lost     ? ", as other joints do, and nearly always in the direction of the motion: rows were lost there, and the time goes on as if not?"
                         : together ? ", and other joints jump too: several recordings in one file?"
                                    : ", which its motion cannot explain."));
    }
  }

 private:
  struct Joint {
    double tolerance = 0.0;
    long count = 0, onward = 0;  // number of jumps; number of those in the direction of the step before
    double largest = 0.0, largest_at = 0.0;

    void add(double jump, double step_before, double time) {
      ++count;
      if (jump * step_before > 0.0) ++onward;
      if (std::abs(jump) <= std::abs(largest)) return;
      largest = jump;
      largest_at = time;
    }
  };

  // Compares the step into row k with its neighbours but the step into k + 1, because the position jumps back
  // after a single wrong value.
  bool is_jump(const Recording& rows, int k, int joint) const {
    const auto step = [&](int row) { return std::abs(rows.q(row, joint) - rows.q(row - 1, joint)); };
    double around = std::max({step(k - 2), step(k - 1), step(k + 2), step(k + 3)});
    if (rows.dq.cols() > 0) around = std::max(around, step_ * rows.dq.col(joint).segment(k - 2, 5).cwiseAbs().maxCoeff());
    return step(k) > joints_[static_cast<std::size_t>(joint)].tolerance + numbers.jump_around * around;
  }

  double step_;
  std::vector<Joint> joints_;
};

}  // namespace

std::unique_ptr<Tally> jump_tally(const Head& head) { return std::make_unique<JumpTally>(head); }

}  // namespace veridyn::quality
