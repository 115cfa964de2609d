#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "veridyn/cooperation/scenario_run.hpp"

namespace veridyn {

/// One run of a sweep: the scenario with this stiffness of every member, this delay of every sensor
/// and this rate of the loops.
struct SweepPoint {
  double stiffness = 0.0;      ///< [N/m]
  double delay = 0.0;          ///< [s]
  double rate = 0.0;           ///< [Hz]
  double steady_error = 0.0;   ///< [N] largest steady error of any phase
  double force_error = 0.0;    ///< [N] largest error in the phases with a bound
  double oscillation = 0.0;    ///< [N] largest oscillation at the end of any phase
  double largest_force = 0.0;  ///< [N] largest force of any member at any time
  double generated = 0.0;      ///< [J] largest energy generated in any phase after its commands
  bool stable = false;
  std::string ended;  ///< reason if the run ended early; empty: complete
};

/// Result of a sweep. A point is stable if the run was complete and both the steady error and half
/// the oscillation stayed within the scenario's `stable_error` in every phase.
struct ScenarioSweepResult {
  std::string name, engine;
  double stable_error = 0.0;  ///< [N] bound of a stable point, see ScenarioSweep
  std::vector<double> stiffness, delay, rate;
  std::vector<SweepPoint> points;  ///< stiffness runs fastest, then delay, then rate
  double seconds = 0.0;

  /// The point at these indices, from 0, of the lists above.
  const SweepPoint& at(std::size_t stiffness, std::size_t delay, std::size_t rate) const;
  /// [s] The largest delay of the grid up to which all delays are stable, at these indices from 0; -1: none.
  double stable_delay(std::size_t stiffness, std::size_t rate) const;
  /// [J] largest generated energy at any stable point; 0: none is stable.
  double largest_generated_where_stable() const;
  std::string report() const;
};

struct SweepOptions {
  std::string engine = "veridyn";
  int threads = 0;                         ///< 0: one per core
  std::function<void(double)> progress{};  ///< share done
  /// Points that an earlier sweep has finished, by their index in `points`: they are not run again.
  std::function<std::optional<SweepPoint>(int)> kept{};
  /// Called for each point after its run, from any thread.
  std::function<void(int, const SweepPoint&)> keep{};
};

/// Runs the scenario at every point of its sweep.
/// @throws InvalidInput  as run_scenario(); a scenario without a sweep.
ScenarioSweepResult sweep_scenario(const Scenario& scenario, const SweepOptions& options = {});

}  // namespace veridyn
