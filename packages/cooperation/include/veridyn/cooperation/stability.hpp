#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "veridyn/cooperation/scenario.hpp"

namespace veridyn {

/// A scenario parameter that affects stability, by name: "stiffness" of all members and walls
/// [N/m], "delay" of their sensors [s], "rate" of the loop [Hz], ...; see stability_parameters().
struct StabilityParameter {
  std::string name, unit, meaning;
  bool logarithmic = false;  ///< ranges are spaced by equal ratios
};
const std::vector<StabilityParameter>& stability_parameters();

/// The scenario with that parameter changed; tuned force laws are recomputed.
/// @throws InvalidInput  no such parameter, or a value out of range.
Scenario with_parameter(const Scenario& scenario, const std::string& name, double value);

/// Value of the parameter; where members differ, that of the first. @throws InvalidInput  no such parameter.
double parameter(const Scenario& scenario, const std::string& name);

/// Values from `from` to `to`, linearly or logarithmically spaced as the parameter requires.
struct ParameterRange {
  std::string name;
  double from = 0.0, to = 0.0;
  int count = 0;
  std::vector<double> values() const;
};
/// Parses "stiffness=100:20000:50". @throws InvalidInput  another form, an unknown name.
ParameterRange parse_range(const std::string& text);

/// Changes of the force readings at which the loop reaches its stability limit; infinite if none is found
/// within the search.
struct StabilityMargins {
  double gain = 0.0;       ///< factor on every force reading
  double phase_deg = 0.0;  ///< lag of every force reading
  double delay = 0.0;      ///< [s] additional delay of every force reading
};

/// One equilibrium.
struct StabilityPoint {
  std::string phase;
  double time = 0.0;    ///< [s] since the start
  double radius = 0.0;  ///< largest modulus of the eigenvalues, per cycle
  bool stable = false;
};

/// Effect of an incremental law with a deadband: its describing function, and the limit cycle of
/// the linear loop with the actual law.
struct DeadbandSwing {
  std::string member;
  /// Maximum of the describing function: 2 increment rate / (pi deadband) [m/(N s)]
  double largest_gain = 0.0;
  double critical_gain = 0.0;  ///< gain of an integral law at the stability limit
  bool describing_function_swings = false;
  bool swings = false;     ///< the simulated corrections never end
  double amplitude = 0.0;  ///< [N] half of the force's peak-to-peak value
  double frequency = 0.0;  ///< [Hz] of the limit cycle
};

/// A force sensor with a sample pattern that is too long for the analysis, and the rate with which it is
/// replaced: within 4 % if all sensors have one rate, otherwise such that their common pattern has at most
/// 1000 cycles.
struct ReplacedRate {
  std::string sensor;  ///< member or wall
  double rate = 0.0, analysed = 0.0;  ///< [Hz] actual rate, and rate in the analysis
};

/// Discrete-time closed loop of a scenario, linearised at equilibria of its motion.
///
/// Every control cycle is linearised exactly as `cooperate` runs it: encoders, velocity observer,
/// force sensors with their rate and delay, force laws, impedance and position loops, observer of
/// model errors, motor lag, then arms and object by the exponential of their equations of motion.
/// If sensors are slower than the loop the cycle repeats after `cycles` periods, and the
/// eigenvalues belong to that many cycles.
///
/// Arms are assumed to slide: viscous friction counts, dry friction does not. Dry friction ends small
/// motions, but cannot stabilise an unstable loop for large ones, so that "stable" here means stable with any
/// dry friction. Two limits are given for the object's stiffness: that of the linear loop, and that below
/// which the scenario's own dry friction still brings it to rest. The latter is searched from the former by
/// bisection over nonlinear simulations.
struct StabilityAnalysis {
  std::string name;
  double period = 0.0;  ///< [s] period of the control loop
  int cycles = 1;       ///< number of control cycles of the eigenvalues
  std::vector<ReplacedRate> replaced_rates;
  int states = 0;
  std::vector<std::pair<double, double>> eigenvalues;  ///< real and imaginary parts at the worst point
  bool stable = false;
  double radius = 0.0;  ///< largest modulus per cycle, at the worst point
  StabilityPoint worst;
  std::vector<StabilityPoint> points;
  StabilityMargins margins;                ///< margins at the worst point
  /// [N/m] below which the scenario comes to rest, with dry friction
  double largest_stable_stiffness = 0.0;
  double linear_stable_stiffness = 0.0;    ///< [N/m] the same without dry friction, for sliding arms
  int simulated_runs = 0;                  ///< number of nonlinear simulations
  double smallest_stable_stiffness = 0.0;  ///< [N/m] lower limit, searched from the scenario's own stiffness
  bool stiffness_bounded = false;          ///< false: stable up to the end of the search
  std::vector<DeadbandSwing> deadbands;
  std::vector<std::string> members;
  double seconds = 0.0;
  std::string report() const;
};

/// @throws InvalidInput  an invalid model; a force sensor with less than one sample in 1000 cycles.
StabilityAnalysis analyse_stability(const Scenario& scenario);

/// Spectral radii over two parameters, at the scenario's worst equilibrium.
struct StabilityMap {
  ParameterRange a, b;
  std::vector<double> a_values, b_values;
  std::vector<double> radius;  ///< radius of point (i, j) at index i + a_values.size() * j
  std::vector<char> stable;
  double seconds = 0.0;
};
/// @param threads  0: one per core.
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

/// Gains of the tuned form that tolerate a given phase lag of the readings.
struct GainRecommendation {
  double phase_deg = 0.0;  ///< requested phase margin
  bool found = false;
  double crossover = 0.0;  ///< [rad/s] crossover of the force loop: the largest with that margin
  double impedance_damping = 0.0;  ///< [N s/m] recommended damping of the impedance
  ForceLaw law;            ///< recommended law of the first member
  double radius = 0.0;     ///< spectral radius per cycle with these gains
  StabilityMargins margins;
  int tried = 0;
};

/// Searches force laws of the form of tuned_force_law(), varying the crossover, the member's damping and the
/// impedance's damping, for the fastest law that remains stable while readings lag by phases up to the
/// requested one, in steps of 5 degrees, and while they are amplified by half.
/// @throws InvalidInput  no member has an impedance at either end.
GainRecommendation recommend_gains(const Scenario& scenario, double phase_deg);

/// Stability for model errors within their whole intervals.
struct StabilityBounds {
  int samples = 0;
  double share = 0.0;  ///< relative error of every base parameter: Scenario::model_error
  int unstable = 0;        ///< number of samples with an unstable loop
  double worst_radius = 0.0;
  /// Factor on all intervals up to which every sampled corner is stable; 0: one is unstable even with exact
  /// parameters.
  double factor = 0.0;
  bool factor_bounded = false;
  /// Guarantee of the small-gain theorem: the loop is stable for all errors of the known mass matrices below
  /// this share, |M_known^-1/2 (M - M_known) M_known^-1/2|, of any structure and any variation in time.
  /// Conservative. Zero means no guarantee: the loop is unstable without errors, or samples repeat after more
  /// than 24 cycles.
  double guaranteed_mass_error = 0.0;
};
/// @throws InvalidInput  fewer than one sample.
StabilityBounds bound_stability(const Scenario& scenario, int samples, int threads = 0);

/// True force in every member after a step of 1 N in all wanted forces, in the linear loop.
struct StepResponses {
  std::vector<std::string> members;
  std::vector<double> time;                 ///< [s] since the step
  std::vector<std::vector<double>> force;   ///< [N], one list for each member
};
StepResponses step_responses(const Scenario& scenario);

/// Results of `veridyn stability`.
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

/// Options for turning an identified model alone into a scenario: the impedance of its frame against a wall.
struct StabilityModelOptions {
  std::string frame;         ///< frame in contact; empty: "tool", or else the last frame
  std::vector<double> pose;  ///< joints; empty: the middle of their ranges
  double stiffness = 2450.0, damping = 2.0;  ///< [N/m], [N s/m] of the wall
};
/// @param model  path of an identified model. @throws InvalidInput  as read_model(), or no such frame.
Scenario contact_scenario(const std::string& model, const StabilityModelOptions& options);

/// Reads a scenario file, or an identified model by contact_scenario(). @throws InvalidInput  the file is
/// neither.
Scenario read_scenario_or_model(const std::string& path, const StabilityModelOptions& options);

}  // namespace veridyn
