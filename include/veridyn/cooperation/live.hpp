#pragma once

#include <functional>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "veridyn/cooperation/scenario_run.hpp"

namespace veridyn {

/// What one line of a live run may ask for.
struct LiveWait {
  double seconds = 0.0;
};
struct LiveStop {};   ///< end all motion
struct LiveAlive {};  ///< the line is there, nothing else
struct LiveQuit {};   ///< end the run
struct LiveJog {      ///< the object's velocity from now on, until the next line
  Eigen::Vector3d velocity{0.0, 0.0, 0.0};  ///< [m/s] in the master's axes
};
using LiveCommand =
    std::variant<ScenarioCommand, LiveJog, LiveWait, LiveStop, LiveAlive, LiveQuit>;

/// One line, words parted by blanks; what begins with '#' is a remark, and like an empty line alive:
///
///   move X Y Z SECONDS           the object by a way [m] in the master's axes
///   turn A B C SECONDS           the object by Rz(C) Ry(B) Rx(A) [rad]
///   jog VX VY VZ                 the object's velocity [m/s], until another line comes
///   force MEMBER NEWTONS SECONDS  the force wanted in a member
///   tighten METRES SECONDS       every slave away from the centroid
///   arm NAME X Y Z SECONDS       one arm relative to the object [m] in the world
///   release MEMBER               let go; take MEMBER: take hold again
///   stop | alive | wait SECONDS | quit
///
/// @throws InvalidInput  a word or a number that is none of these: "found ..., expected ...".
LiveCommand parse_live_command(const std::string& line, const Scenario& scenario);

/// Where lines come from, without waiting.
class LineSource {
 public:
  virtual ~LineSource() = default;
  /// True where a whole line was there, which `line` then is.
  virtual bool next(std::string& line) = 0;
  virtual bool closed() const = 0;
};

/// "-": standard input; "udp:PORT": every datagram is a line, from this machine alone unless
/// "udp:ADDRESS:PORT" names another address to listen on. Whoever sends first has the line: what
/// others send is not taken.
/// @throws InvalidInput  another form, a port that cannot be had.
std::unique_ptr<LineSource> open_line_source(const std::string& name);

struct LiveOptions {
  std::string engine = "veridyn";
  double pace = 1.0;           ///< simulated seconds per second; 0: as fast as possible
  double silence = 0.5;        ///< [s] without a line after which a jog or a socket's line is lost
  bool watches_silence = false;  ///< a line is lost by silence, as on sockets; else by its end
  double hold = 1.0;           ///< [s] for which all is held after the line was lost
  double longest = 3600.0;     ///< [s] of the run
  double tell = 0.1;           ///< [s] between lines of what is: see LiveReport
};

/// One arm of a live run at one instant, (n) each.
struct LiveArm {
  VectorXd q, dq;  ///< true [rad], [m] and rates
  VectorXd tau;    ///< that acted in the period before [N m], [N]
};

/// What a live run tells, every LiveOptions::tell seconds and after each command.
struct LiveReport {
  std::function<void(const std::string&)> state;  ///< "t=1.200 state=tracks tip=... force=..."
  std::function<void(const std::string&)> refused;  ///< a line that was not understood
  /// Time [s] and arms, in the scenario's order, whenever `state` is told.
  std::function<void(double, const std::vector<LiveArm>&)> arms{};
};

/// How a live run ended.
struct LiveRun {
  double time = 0.0;     ///< [s]
  long commands = 0, refused = 0;
  bool lost = false;     ///< the line ended or fell silent: all was held
  double lost_at = 0.0;  ///< [s]
  double moved_after_loss = 0.0;  ///< [m] largest way of any tip from stop_duration after the loss
  double largest_force = 0.0;     ///< [N]
  double longest_latency = 0.0;   ///< [s] from a line's arrival to the torques that follow from it
  CooperativeState state = CooperativeState::kTracking;
  StepStatus status = StepStatus::kOk;
  std::string report() const;
};

/// Runs the scenario's arms under commands from a line; its phases are left out.
/// @throws InvalidInput  as run_scenario().
LiveRun run_live(const Scenario& scenario, LineSource& lines, const LiveOptions& options,
                 const LiveReport& tell);

}  // namespace veridyn
