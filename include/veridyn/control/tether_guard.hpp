#pragma once

#include <Eigen/Core>
#include <vector>

namespace veridyn {

struct TetherGuardOptions {
  double period = 1e-3;      ///< [s] of update()
  double margin = 0.005;     ///< [m] of slack that is kept once a member has had twice as much
  double horizon = 0.03;     ///< [s] time constant of the approach to the largest length
  double least_push = 0.5;   ///< [N] that tells a spring or a bar from a string
  double rest = 0.1;         ///< [s] in which motion of the guard dies away when nothing presses
  double acceleration = 40.0;  ///< [m/s^2] and
  double speed = 3.0;          ///< [m/s] of a tip at most: a free fall of 0.46 m
  double smoothing = 40.0;     ///< [Hz] of the velocities and accelerations seen
};

/// Keeps members from being jerked tight by an arm that has lost its torque: the ends that still
/// follow go along with it. A string jerks with k^1/2 m^1/2 v within milliseconds, before any
/// force sensor tells; but for tenths of a second before that encoders show the arm fall.
///
/// With the length L of a member between its tips and the largest one L_max allowed, every end
/// that is healthy gets the acceleration that keeps
///
///   d2L/dt2 <= -2/h dL/dt - (L - L_max)/h^2     (h: horizon)
///
/// so that L approaches L_max at most like exp(-t/h). L_max is the member's length without force,
/// learnt while the task runs, and the stretch under twice the force that is allowed; where the
/// member has become slack, `margin` below the length without force. Members that have pushed are
/// kept from being crushed likewise, with L_min and the signs turned. What presses nothing is not
/// moved.
///
/// Velocities and accelerations are taken from the places of the tips alone (fading-memory
/// polynomial of the second degree, Morrison 1969, section 13.6): observers that are led by the
/// acceleration asked of an arm are wrong by a / bandwidth where an arm does not follow.
///
/// Nothing allocates after the constructor, nothing throws.
class TetherGuard {
 public:
  struct Member {
    int from = 0, to = 1;
    double stiffness = 0.0;  ///< [N/m] as far as known; 0: its length under force counts as free
  };
  /// What is to be added to an end's place.
  struct Motion {
    Eigen::Vector3d position{Eigen::Vector3d::Zero()};      ///< [m]
    Eigen::Vector3d velocity{Eigen::Vector3d::Zero()};      ///< [m/s]
    Eigen::Vector3d acceleration{Eigen::Vector3d::Zero()};  ///< [m/s^2]
  };

  /// @throws InvalidInput  ends that are not there, options that are not above zero.
  TetherGuard(int arms, std::vector<Member> members, const TetherGuardOptions& options);

  void reset() noexcept;
  /// While the task runs: what is the length of a member without force? @param force  [N] read.
  void learn(int member, double length, double force) noexcept;
  /// While all is held: does the member push? @param force  [N] read.
  void feel(int member, double force) noexcept;
  /// A member was let go or taken anew.
  void forget(int member) noexcept;

  /// While all is held, once per period.
  /// @param position  of the tips [m]. @param healthy  0: this arm does not follow.
  /// @param force  [N] that a member may carry.
  void update(const std::vector<Eigen::Vector3d>& position, const std::vector<char>& healthy,
              double force) noexcept;

  const Motion& motion(int arm) const { return motions_[static_cast<std::size_t>(arm)]; }
  /// [m] Length without force; NaN: not known yet.
  double free_length(int member) const { return lengths_[static_cast<std::size_t>(member)]; }

 private:
  struct Seen {  ///< a tip, as its places tell it
    Eigen::Vector3d position{Eigen::Vector3d::Zero()};
    Eigen::Vector3d velocity{Eigen::Vector3d::Zero()};
    Eigen::Vector3d acceleration{Eigen::Vector3d::Zero()};
  };
  void look(const std::vector<Eigen::Vector3d>& position) noexcept;
  void limit(std::size_t member, double length, double force) noexcept;
  void hold_back(std::size_t member, const std::vector<char>& healthy, double force) noexcept;

  TetherGuardOptions options_;
  std::vector<Member> members_;
  std::vector<double> lengths_, limits_;
  std::vector<char> pushes_;
  std::vector<Motion> motions_;
  std::vector<Seen> seen_;
  bool looked_ = false;
};

}  // namespace veridyn
