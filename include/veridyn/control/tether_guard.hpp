#pragma once

#include <Eigen/Core>
#include <vector>

namespace veridyn {

struct TetherGuardOptions {
  double period = 1e-3;      ///< [s] interval between calls of update()
  /// [m] slack that is preserved in a member whose slack has reached twice as much
  double margin = 0.005;
  double horizon = 0.03;     ///< [s] time constant of the approach to the largest length
  /// [N] compression that identifies a spring or a bar, as opposed to a string
  double least_push = 0.5;
  double rest = 0.1;  ///< [s] decay time of the guard's motion when no member is near its limits
  double acceleration = 40.0;  ///< [m/s^2] largest acceleration of a tip
  double speed = 3.0;          ///< [m/s] largest speed of a tip: a free fall of 0.46 m
  double smoothing = 40.0;     ///< [Hz] bandwidth of the estimated velocities and accelerations
};

/// Prevents an arm that has lost its torque from jerking members: the ends that still follow move along with
/// it. The peak force of a string is k^1/2 m^1/2 v within milliseconds, before any force sensor reacts;
/// encoders, however, measure the falling arm tenths of a second earlier.
///
/// With the length L of a member between its tips and the largest allowed length L_max, every
/// healthy end gets the acceleration that keeps
///
///   d2L/dt2 <= -2/h dL/dt - (L - L_max)/h^2     (h: horizon)
///
/// so that L approaches L_max at most like exp(-t/h). L_max is the member's unloaded length, estimated while the
/// task runs, plus the stretch under twice the allowed force; for a member that has become slack, `margin` below
/// the unloaded length. Members that have carried compression are kept from being crushed in the same way, with
/// L_min and the signs reversed. Ends of other members are not moved.
///
/// Velocities and accelerations are estimated from the tips' positions alone (fading-memory
/// polynomial of the second degree, Morrison 1969, section 13.6): observers that are driven by the
/// commanded acceleration are wrong by a / bandwidth where an arm does not follow.
///
/// Nothing allocates after the constructor, nothing throws.
class TetherGuard {
 public:
  struct Member {
    int from = 0, to = 1;
    double stiffness = 0.0;  ///< [N/m]; 0: unknown, the length under load is taken as the unloaded length
  };
  /// Correction of an end's reference.
  struct Motion {
    Eigen::Vector3d position{Eigen::Vector3d::Zero()};      ///< [m]
    Eigen::Vector3d velocity{Eigen::Vector3d::Zero()};      ///< [m/s]
    Eigen::Vector3d acceleration{Eigen::Vector3d::Zero()};  ///< [m/s^2]
  };

  /// @throws InvalidInput  ends that do not exist, options that are not above zero.
  TetherGuard(int arms, std::vector<Member> members, const TetherGuardOptions& options);

  void reset() noexcept;  ///< clears all lengths, estimates and motions
  /// While the task runs: updates the unloaded length of a member. @param length  [m] between its tips. @param force  [N] reading.
  void update_length(int member, double length, double force) noexcept;
  /// While targets are held: detects compression of a member. @param force  [N] reading.
  void detect_compression(int member, double force) noexcept;
  /// Clears the estimate of a member that was released or attached again.
  void reset_member(int member) noexcept;

  /// Updates the motions of all ends; call it once per period while targets are held.
  /// @param position  [m] of each arm's tip; skipped if not finite.
  /// @param healthy  one entry for each arm; 0: it does not follow its target.
  /// @param force  [N] allowed in a member.
  void update(const std::vector<Eigen::Vector3d>& position, const std::vector<char>& healthy,
              double force) noexcept;

  const Motion& motion(int arm) const { return motions_[arm]; }
  /// [m] unloaded length; NaN: not yet known
  double free_length(int member) const { return lengths_[member]; }

 private:
  struct Seen {  ///< motion of a tip, estimated from its positions
    Eigen::Vector3d position{Eigen::Vector3d::Zero()};
    Eigen::Vector3d velocity{Eigen::Vector3d::Zero()};
    Eigen::Vector3d acceleration{Eigen::Vector3d::Zero()};
    bool looked = false;  // a finite position has been received
  };
  void update_positions(const std::vector<Eigen::Vector3d>& position) noexcept;  ///< advances seen_ by one period
  void limit(std::size_t member, double length, double force) noexcept;  ///< sets L_max of the member
  void limit_end_accelerations(std::size_t member, const std::vector<char>& healthy, double force) noexcept;  ///< corrects its healthy ends' motions_ to keep L_max and L_min

  TetherGuardOptions options_;
  std::vector<Member> members_;
  std::vector<double> lengths_, limits_;
  std::vector<char> pushes_;
  std::vector<Motion> motions_;
  std::vector<Seen> seen_;
};

}  // namespace veridyn
