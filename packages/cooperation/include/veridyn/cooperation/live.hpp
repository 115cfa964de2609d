#pragma once

#include <functional>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "veridyn/cooperation/scenario_run.hpp"

namespace veridyn {

/// Commands that one line of a live run can contain.
struct LiveWait {
  double seconds = 0.0;
};
/// Ends all motion. It is executed on arrival, also during a LiveWait; earlier lines that have not been
/// executed by then are dropped. In a script, which arrives as a whole, it is executed in order.
struct LiveStop {};
struct LiveAlive {};  ///< a sign of life without another effect
struct LiveQuit {};   ///< end the run
struct LiveJog {      ///< velocity of the object from now on, until the next line
  Eigen::Vector3d velocity{0.0, 0.0, 0.0};  ///< [m/s] velocity in the axes of the master
};
using LiveCommand =
    std::variant<ScenarioCommand, LiveJog, LiveWait, LiveStop, LiveAlive, LiveQuit>;

/// Parses one line of words separated by blanks. A line that starts with '#', or an empty one, is a sign of
/// life:
///
///   move X Y Z SECONDS           move the object [m] in the leader's axes
///   turn A B C SECONDS           rotate the object by Rz(C) Ry(B) Rx(A) [rad]
///   jog VX VY VZ                 velocity of the object [m/s], until the next line
///   force MEMBER NEWTONS SECONDS  wanted force of a member
///   tighten METRES SECONDS       move every follower away from the centroid
///   arm NAME X Y Z SECONDS       move one arm relative to the object [m] in the world
///   release MEMBER               release a member; take MEMBER: attach it again
///   stop | alive | wait SECONDS | quit
///
/// @throws InvalidInput  an unknown word or a malformed number: "found ..., expected ...".
LiveCommand parse_live_command(const std::string& line, const Scenario& scenario);

/// A source of command lines that never blocks.
class LineSource {
 public:
  virtual ~LineSource() = default;
  /// True if a whole line has arrived; `line` is set to it.
  virtual bool next(std::string& line) = 0;
  virtual bool closed() const = 0;  ///< no further line will come
  /// True for a file, which does not grow: all lines, stops included, are executed in order.
  virtual bool is_script() const { return false; }
};

/// Opens "-", standard input, or "udp:PORT", where every datagram is a line and only this machine may send,
/// unless "udp:ADDRESS:PORT" gives another address to listen on. Lines are accepted from the first sender
/// only.
/// @throws InvalidInput  another form, or a port that cannot be opened.
std::unique_ptr<LineSource> open_line_source(const std::string& name);

struct LiveOptions {
  std::string engine = "veridyn";
  double pace = 1.0;           ///< simulated seconds per second; 0: as fast as possible
  /// [s] without a line after which a jog or a socket's connection counts as lost
  double silence = 0.5;
  /// True: a connection is lost by silence, as on sockets; false: by its end.
  bool watches_silence = false;
  double hold = 1.0;           ///< [s] duration of holding after the connection is lost
  double longest = 3600.0;     ///< [s] longest duration of the run
  double tell = 0.1;           ///< [s] time between reports, see LiveReport
};

/// One arm of a live run at one instant, (n) each.
struct LiveArm {
  VectorXd q, dq;  ///< true [rad], [m] and rates
  VectorXd tau;    ///< [N m], [N] during the previous period
};

/// Callbacks of a live run; `state` and `arms` are called every LiveOptions::tell seconds and at the end.
struct LiveReport {
  std::function<void(const std::string&)> state;  ///< 't=1.200 state="tracks" ARM=x,y,z MEMBER=force', [m] in the world, [N]
  std::function<void(const std::string&)> refused;  ///< receives the reason of each refusal
  /// Time [s] and arms, in the scenario's order, together with `state`.
  std::function<void(double, const std::vector<LiveArm>&)> arms{};
};

/// Result of a live run.
struct LiveRun {
  double time = 0.0;     ///< [s] simulated duration
  long commands = 0, refused = 0;
  bool lost = false;     ///< the connection ended or was silent, and targets were held
  double lost_at = 0.0;  ///< [s] time of the loss of the connection
  /// [m] largest motion of any tip that is later than stop_duration after the loss
  double moved_after_loss = 0.0;
  double largest_force = 0.0;     ///< [N] largest force of any member
  /// [s] from the arrival of a line to the torques that result from it
  double longest_latency = 0.0;
  CooperativeState state = CooperativeState::kTracking;
  StepStatus status = StepStatus::kOk;
  std::string report() const;
};

/// Runs the scenario's arms under commands from a line source; the phases of the scenario are
/// ignored.
/// @throws InvalidInput  as run_scenario().
LiveRun run_live(const Scenario& scenario, LineSource& lines, const LiveOptions& options,
                 const LiveReport& tell);

}  // namespace veridyn
