#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "veridyn/cooperation/scenario.hpp"

namespace veridyn {

/// A number of a scenario that stability depends on, by name: "stiffness" of all members and walls
/// [N/m], "delay" of their sensors [s], "rate" of the loop [Hz], ...; see stability_parameters().
struct StabilityParameter {
  std::string name, unit, meaning;
  bool logarithmic = false;  ///< ranges are spaced by equal ratios
};
const std::vector<StabilityParameter>& stability_parameters();

/// The scenario with that parameter changed; tuned force laws are tuned anew.
/// @throws InvalidInput  no such parameter, or a value that it cannot have.
Scenario with_parameter(const Scenario& scenario, const std::string& name, double value);

/// Its value, of the first member where members differ. @throws InvalidInput  as above.
double parameter(const Scenario& scenario, const std::string& name);

/// Values from `from` to `to`, equally spaced or by equal ratios as the parameter wants.
struct ParameterRange {
  std::string name;
  double from = 0.0, to = 0.0;
  int count = 0;
  std::vector<double> values() const;
};
/// "stiffness=100:20000:50". @throws InvalidInput  another form, an unknown name.
ParameterRange parse_range(const std::string& text);

/// By how much the force readings may change until the loop swings; infinite where nothing is
/// found within the search.
struct StabilityMargins {
  double gain = 0.0;       ///< factor on every force reading
  double phase_deg = 0.0;  ///< lag of every force reading
  double delay = 0.0;      ///< [s] more of every force reading
};

/// One point of rest.
struct StabilityPoint {
  std::string phase;
  double time = 0.0;    ///< [s] since the start
  double radius = 0.0;  ///< largest modulus of the eigenvalues, per cycle
  bool stable = false;
};

/// What a law of increments with a deadband does: its describing function, and the periodic motion
/// that the linear loop with the law as it is runs into.
struct DeadbandSwing {
  std::string member;
  double largest_gain = 0.0;   ///< Largest gain of the describing function, 2 increment rate / (pi deadband)
                               ///< [m/(N s)]
  double critical_gain = 0.0;  ///< Critical gain of an integral law at which the loop begins to swing
  bool describing_function_swings = false;
  bool swings = false;     ///< as iterated: corrections never end
  double amplitude = 0.0;  ///< [N] half of the swing of the force
  double frequency = 0.0;  ///< [Hz]
};

/// The scenario's closed loop about points of rest of its motion, in discrete time.
///
/// Every control cycle is linearised exactly as `cooperate` runs it: encoders, velocity observer,
/// force sensors with their rate and delay, force laws, impedance and position loops, observer of
/// model errors, motor lag, then arms and object by the exponential of their equations of motion.
/// Where sensors are slower than the loop the cycle repeats after `cycles` periods, and eigenvalues
/// are those of that many cycles.
///
/// Arms are taken as sliding: friction that grows with speed counts, dry friction does not. It
/// stills what is small and cannot make an unstable loop stable for large motions, so that "stable"
/// here is stable with any dry friction. For the object's stiffness both are told: up to where the
/// linear loop is stable, and up to where the scenario's own dry friction still stills it, which
/// bisection over runs of the nonlinear simulation finds from there.
struct StabilityAnalysis {
  std::string name;
  double period = 0.0;  ///< [s] of the control loop
  int cycles = 1;       ///< control cycles that the eigenvalues are of
  int states = 0;
  std::vector<std::pair<double, double>> eigenvalues;  ///< at the worst point (real, imaginary)
  bool stable = false;
  double radius = 0.0;  ///< largest modulus per cycle, at the worst point
  StabilityPoint worst;
  std::vector<StabilityPoint> points;
  StabilityMargins margins;                ///< smallest of all points
  double largest_stable_stiffness = 0.0;   ///< [N/m] up to which the scenario comes to rest,
                                           ///< dry friction and all
  double linear_stable_stiffness = 0.0;    ///< [N/m] likewise with arms that slide
  int simulated_runs = 0;                  ///< Simulated runs of the nonlinear simulation
  double smallest_stable_stiffness = 0.0;  ///< [N/m] down to which, from there
  bool stiffness_bounded = false;          ///< false: stable up to the end of the search
  std::vector<DeadbandSwing> deadbands;
  std::vector<std::string> members;
  double seconds = 0.0;
  std::string report() const;
};

/// @throws InvalidInput  as Experiment's models.
StabilityAnalysis analyse_stability(const Scenario& scenario);

/// Radii over two parameters, at the scenario's worst point of rest.
struct StabilityMap {
  ParameterRange a, b;
  std::vector<double> a_values, b_values;
  std::vector<double> radius;  ///< Radius of point (i, j) at i + a_values.size() * j
  std::vector<char> stable;
  double seconds = 0.0;
};
StabilityMap map_stability(const Scenario& scenario, const ParameterRange& a,
                           const ParameterRange& b, int threads = 0);

/// Eigenvalues over one parameter.
struct RootLocus {
  ParameterRange range;
  std::vector<double> values;
  std::vector<std::vector<std::pair<double, double>>> eigenvalues;  ///< largest moduli first
  std::vector<char> stable;
};
RootLocus root_locus(const Scenario& scenario, const ParameterRange& range);

/// Gains of tuned form with which the readings may lag by a wanted phase.
struct GainRecommendation {
  double phase_deg = 0.0;  ///< asked for
  bool found = false;
  double crossover = 0.0;  ///< [rad/s] of the force loop: the largest that keeps the margin
  double impedance_damping = 0.0;  ///< [N s/m]
  ForceLaw law;            ///< Law of the first member
  double radius = 0.0;     ///< per cycle, with these gains
  StabilityMargins margins;
  int tried = 0;
};

/// Searches force laws of tuned_force_law()'s form, over its crossover, the member's damping and
/// the impedance's damping, for the quickest that stays stable while readings lag by any phase up
/// to the one asked for and grow by half.
/// @throws InvalidInput  no member with an impedance at either end.
GainRecommendation recommend_gains(const Scenario& scenario, double phase_deg);

/// Stability while what the controllers know of the arms is wrong by its whole interval.
struct StabilityBounds {
  int samples = 0;
  double share = 0.0;      ///< Share of every base parameter, or NaN: intervals of the identified MODEL
  int unstable = 0;        ///< samples whose loop is not stable
  double worst_radius = 0.0;
  double first_seed = 0.0;
  /// Factor on all intervals up to which every sampled corner stays stable.
  double factor = 0.0;
  bool factor_bounded = false;
  /// Guaranteed by the small-gain theorem: errors of the known mass matrices up to this share of
  /// them, |M_known^-1/2 (M - M_known) M_known^-1/2| below it, whatever their structure and
  /// however they change, keep the loop stable. Conservative.
  double guaranteed_mass_error = 0.0;
};
StabilityBounds bound_stability(const Scenario& scenario, int samples, int threads = 0);

/// The true force in every member after all wanted forces rose by 1 N at once, in the linear loop.
struct StepResponses {
  std::vector<std::string> members;
  std::vector<double> time;                 ///< [s]
  std::vector<std::vector<double>> force;   ///< [N], one list for each member
};
StepResponses step_responses(const Scenario& scenario);

/// All that `veridyn stability` finds.
struct StabilityStudy {
  Scenario scenario;
  StabilityAnalysis analysis;
  std::optional<StabilityMap> map;
  std::optional<RootLocus> locus;
  std::optional<GainRecommendation> recommendation;
  std::optional<StabilityBounds> bounds;
  std::optional<StepResponses> steps;
  std::string report() const;
};

/// How a MODEL alone becomes a scenario: the impedance of its frame against a wall.
struct StabilityModelOptions {
  std::string frame;         ///< that touches; empty: "tool", or else the last frame
  std::vector<double> pose;  ///< joints; empty: the middle of their ranges
  double stiffness = 2450.0, damping = 2.0;  ///< Stiffness of the wall [N/m, N s/m]
};
Scenario contact_scenario(const std::string& model, const StabilityModelOptions& options);

/// A scenario file, or a MODEL by contact_scenario(). @throws InvalidInput  neither.
Scenario read_scenario_or_model(const std::string& path, const StabilityModelOptions& options);

}  // namespace veridyn
