#pragma once

#include "math/random_numbers.hpp"
#include "veridyn/excitation/excitation.hpp"
#include "veridyn/kinematics/motion_limits.hpp"

namespace veridyn {

/// The space that is searched: any vector of numbers is a motion within the limits.
///
/// Each joint has 2 * harmonics numbers that give its shape (their size does not matter), one for
/// the share of the allowed size and one for the place within the range; the last two pass through
/// a sigmoid.
class Candidates {
 public:
  Candidates(const Model& arm, const ExcitationOptions& options);

  int size() const { return joints_ * (2 * harmonics_ + 2); }

  FourierTrajectory trajectory(const VectorXd& x) const;

  /// Where a search may begin: any shape, large motions, in the middle of the range.
  VectorXd random(RandomNumbers& numbers) const;

 private:
  MotionLimits limits_;
  int joints_;
  int harmonics_;
  double frequency_;
  double share_;
};

}  // namespace veridyn
