// Position steps that the neighbouring motion cannot explain.
#include <algorithm>
#include <cmath>

#include "recordings/quality/quality_checks.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::quality {

JumpTally::JumpTally(const Head& head)
    : step_(head.step), joints_(static_cast<std::size_t>(head.rows.joints())) {
  const Recording& rows = head.rows;
  const int count = rows.rows();
  for (std::size_t joint = 0; joint < joints_.size(); ++joint) {
    const int j = static_cast<int>(joint);
    std::vector<double> change;  // step from one row to the next
    for (int k = 2; k < count; ++k)
      change.push_back(std::abs(rows.q(k, j) - 2.0 * rows.q(k - 1, j) + rows.q(k - 2, j)));
    const double noise = change.empty() ? 0.0 : quantile(std::move(change), 1.0 - numbers.ends);
    const double range = range_of(rows.q, j);
    joints_[joint].tolerance = std::max({numbers.smallest_jump, numbers.jump_noise * noise, numbers.jump_range * range});
  }
}

// Compares the step into row k with its neighbours but the step into k + 1, because the position jumps back
// after a single wrong value.
bool JumpTally::is_jump(const Recording& rows, int k, int joint) const {
  const auto step = [&](int row) { return std::abs(rows.q(row, joint) - rows.q(row - 1, joint)); };
  double around = std::max({step(k - 2), step(k - 1), step(k + 2), step(k + 3)});
  if (rows.dq.cols() > 0) {
    const double fastest = rows.dq.col(joint).segment(k - 2, 5).cwiseAbs().maxCoeff();
    around = std::max(around, step_ * fastest);
  }
  return step(k) > joints_[joint].tolerance + numbers.jump_around * around;
}

void JumpTally::add(const Piece& piece) {
  const Recording& rows = piece.rows;
  for (int k = 3; k + 3 < rows.rows(); ++k) {
    if (rows.time[k] - rows.time[k - 1] > numbers.hole * step_) continue;
    for (std::size_t joint = 0; joint < joints_.size(); ++joint) {
      const int j = static_cast<int>(joint);
      if (!is_jump(rows, k, j)) continue;
      const double jump = rows.q(k, j) - rows.q(k - 1, j);
      Joint& tally = joints_[joint];
      ++tally.count;
      if (jump * (rows.q(k - 1, j) - rows.q(k - 2, j)) > 0.0) ++tally.onward;
      if (std::abs(jump) <= std::abs(tally.largest)) continue;
      tally.largest = jump;
      tally.largest_at = rows.time[k];
    }
  }
}

void JumpTally::conclude(Findings* findings) const {
  const bool together = std::count_if(joints_.begin(), joints_.end(),
                                      [](const Joint& joint) { return joint.count > 0; }) > 1;
  long count = 0, onward = 0;
  for (const Joint& joint : joints_) {
    count += joint.count;
    onward += joint.onward;
  }
  const bool lost = together && count >= numbers.fewest_lost && static_cast<double>(onward) > numbers.onward * static_cast<double>(count);
  for (std::size_t joint = 0; joint < joints_.size(); ++joint) {
    const Joint& tally = joints_[joint];
    if (tally.count == 0) continue;
    const Place place{"q", static_cast<int>(joint) + 1};
    const double turns = tally.largest / kTurn;
    const bool wrapped = std::round(turns) != 0.0 && std::abs(turns - std::round(turns)) < numbers.turn_error;
    findings->add(Severity::kFault, "jumps", place, {kNone, tally.largest, unit_of("q")},
                  text("The position of ", named(place), " jumps ", counted(tally.count, "time"),
                       ", by ", number(tally.largest), " at t = ", number(tally.largest_at), " s",
                       wrapped    ? ": a full turn, the angle is wrapped."
                       : lost     ? ", as other joints do, and nearly always in the direction of the motion: rows were lost there, and the time goes on as if not?"
                       : together ? ", and other joints jump too: several recordings in one file?"
                                  : ", which its motion cannot explain."));
  }
}

}  // namespace veridyn::quality
