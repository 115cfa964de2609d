#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include <chrono>
#include <cmath>
#include <iostream>
#include <map>
#include <memory>
#include <optional>
#include <thread>

#include "veridyn/tool/column_file.hpp"
#include "cli/cooperation/commands.hpp"
#include "veridyn/tool/common_options.hpp"
#include "veridyn/files/output_file.hpp"
#include "veridyn/tool/messages.hpp"
#include "veridyn/tool/option_checks.hpp"
#include "veridyn/tool/sound_arguments.hpp"
#include "veridyn/control/load_cell.hpp"
#include "veridyn/math/require.hpp"
#include "report/json/load_cell_json.hpp"

namespace veridyn::cli {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kPollPeriod = 0.001;  // [s] between two polls of the source

struct LoadcellRequest {
  std::string readings, source, output, calibration;
  std::vector<double> weights;
  double gravity = 9.81;
  double seconds = 2.0;
  double cutoff = 0.0, silence = 15.0, stuck = 15.0;
  double range = 0.0, jump = 0.0;  // 0: default
  CommonOptions common;
};

// [s] on a steady clock.
double steady_seconds() {
  return std::chrono::duration<double>(Clock::now().time_since_epoch()).count();
}

struct Readings {
  std::vector<double> force, raw;
};

// Forces [N], from masses if the file has them, and readings [counts].
Readings read_readings_file(const LoadcellRequest& request) {
  const ColumnFile file =
      read_columns(request.readings, "readings as CSV: mass,raw [kg, counts] or force,raw [N, counts]");
  const bool mass = file.find("mass") >= 0;
  const int under = mass ? file.at("mass") : file.at("force");
  const int raw = file.at("raw");
  Readings out;
  for (Eigen::Index k = 0; k < file.values.rows(); ++k) {
    out.force.push_back(file.values(k, under) * (mass ? request.gravity : 1.0));
    out.raw.push_back(file.values(k, raw));
  }
  return out;
}

// Prompts for each of the weights and reads the source meanwhile. Throws InvalidInput without a reading.
Readings read_weights_from_source(const LoadcellRequest& request) {
  const std::unique_ptr<ForceSource> source = open_force_source(request.source);
  Readings out;
  for (const double mass : request.weights) {
    print_message(fmt::format("hang {:.6g} kg on the cell and press return", mass));
    std::string line;
    require(static_cast<bool>(std::getline(std::cin, line)),
            "standard input: ended before all weights were read.");
    while (source->poll() > 0) {  // readings between the prompts are discarded
    }
    const double end = steady_seconds() + request.seconds;
    int taken = 0;
    while (steady_seconds() < end) {
      while (source->poll() > 0) {
        out.force.push_back(mass * request.gravity);
        out.raw.push_back(source->raw());
        ++taken;
      }
      std::this_thread::sleep_for(std::chrono::duration<double>(kPollPeriod));
    }
    require(taken > 0, request.source, ": found no readings under ", mass,
            " kg, expected at least one in ", request.seconds, " s.");
  }
  return out;
}

// Two weights determine a line without a residual, whose interval needs more readings.
std::string calibration_report(const LoadCellCalibration& found, std::size_t readings) {
  if (!std::isfinite(found.offset_interval) || !std::isfinite(found.scale_interval)) {
    return fmt::format("{} weights, {} readings: offset {:.1f} counts, scale {:.6g} N per count; no "
                       "interval from {} readings.\n",
                       found.weights, readings, found.offset, found.scale, readings);
  }
  std::string out = fmt::format(
      "{} weights, {} readings: offset {:.1f} +- {:.2g} counts, scale {:.6g} +- {:.2g} N per count "
      "(95 %).\n",
      found.weights, readings, found.offset, found.offset_interval, found.scale,
      found.scale_interval);
  out += std::isfinite(found.noise) ? fmt::format("Noise of a reading {:.2g} N; ", found.noise)
                                    : std::string("No noise from one reading per weight; ");
  if (found.weights > 2)
    return out + fmt::format("weights lie within {:.2g} N of the line.\n", found.nonlinearity);
  return out + "two weights do not tell how straight the line is.\n";
}

ExitStatus calibrate(const LoadcellRequest& request) {
  require_writable(request.common.json, request.output);
  const bool live = !request.source.empty();
  if (live == !request.readings.empty())
    throw CLI::ValidationError("calibrate", "expected a file of readings, or --source and --weights.");
  expect_value(!live || request.weights.size() >= 2, "--weights", "found ", request.weights.size(),
               ", expected two or more with --source.");
  const Readings readings = live ? read_weights_from_source(request) : read_readings_file(request);
  const LoadCellCalibration found = [&] {
    try {
      return calibrate_load_cell(readings.force, readings.raw);
    } catch (const InvalidInput& error) {
      throw InvalidInput((live ? request.source : request.readings) + ": " + error.what());
    }
  }();
  if (!request.output.empty()) write_file(request.output, load_cell_text(found));
  if (!request.common.json.empty()) write_file(request.common.json, to_json(found));
  std::cout << calibration_report(found, readings.raw.size());
  return kDone;
}

constexpr double kUsualRange = 200.0;  // [N] default range of a cell for calibration
constexpr double kJumpShare = 0.1;     // largest step of a reading, as a share of the range

ForceChannelOptions channel_options(const LoadcellRequest& request) {
  ForceChannelOptions options;
  const bool calibrated = !request.calibration.empty();
  if (calibrated) options.calibration = read_load_cell(request.calibration);
  options.cutoff = request.cutoff;
  options.range = request.range > 0.0 ? request.range
                  : calibrated        ? kUsualRange
                                      : std::numeric_limits<double>::max();
  const bool bounded = request.range > 0.0 || calibrated;
  if (request.jump > 0.0 || bounded)
    options.largest_jump = request.jump > 0.0 ? request.jump : kJumpShare * options.range;
  options.largest_silence = 1e-3 * request.silence;
  options.stuck_after = 1e-3 * request.stuck;
  return options;
}

// Counts readings and faults: all states of the channel, not only the last one.
struct ReadingTally {
  std::string rows = "t,raw,force\n";
  double worst = 0.0, lowest = 0.0, highest = 0.0, sum = 0.0;
  long readings = 0;
  std::optional<long> last;
  std::map<ForceState, double> seconds;  // [s] duration of each state

  void add_reading(double t, double passed, const ForceReading& reading, const ForceChannel& channel) {
    if (reading.number > last) {
      lowest = readings == 0 ? reading.force : std::min(lowest, reading.force);
      highest = readings == 0 ? reading.force : std::max(highest, reading.force);
      sum += reading.force;
      ++readings;
      last = reading.number;
      rows += fmt::format("{:.6f},{:.9g},{:.9g}\n", t, channel.last_accepted(), reading.force);
    }
    if (last) worst = std::max(worst, reading.age);
    if (last || channel.state() != ForceState::kWaiting) seconds[channel.state()] += passed;
  }
  double mean() const { return readings > 0 ? sum / static_cast<double>(readings) : 0.0; }
};

void write_tally(const LoadcellRequest& request, const ReadingTally& tally, const ForceChannel& channel,
                 const std::string& state) {
  const auto known = [&](double value) {
    return tally.readings > 0 ? nlohmann::ordered_json(value) : nlohmann::ordered_json();
  };
  nlohmann::ordered_json states = nlohmann::ordered_json::object();
  for (const auto& [one, seconds] : tally.seconds) states[describe(one)] = seconds;
  const nlohmann::ordered_json page = {
      {"source", request.source},
      {"calibrated", !request.calibration.empty()},
      {"seconds", request.seconds},
      {"readings", tally.readings},
      {"rate", static_cast<double>(tally.readings) / request.seconds},
      {"refused", channel.source().rejected_readings()},
      {"beyond_range", channel.beyond_range()},
      {"jumps", channel.jumps()},
      {"lowest", known(tally.lowest)},
      {"highest", known(tally.highest)},
      {"mean", known(tally.mean())},
      {"oldest", known(tally.worst)},
      {"state", state},
      {"states", states}};
  write_file(request.common.json, page.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
}

ExitStatus read(const LoadcellRequest& request) {
  require_writable(request.common.json, request.output);
  const ForceChannelOptions options = channel_options(request);
  ForceChannel channel(open_force_source(request.source), options);
  ReadingTally tally;
  const double begun = steady_seconds();
  for (double t = begun, before = begun; t - begun < request.seconds; before = t, t = steady_seconds()) {
    const ForceReading reading = channel.update(t);
    tally.add_reading(t - begun, t - before, reading, channel);
    std::this_thread::sleep_for(std::chrono::duration<double>(kPollPeriod));
  }
  if (!request.output.empty()) write_file(request.output, tally.rows);
  std::cout << fmt::format("{} readings in {:.3g} s ({:.4g} Hz), {} refused, {} beyond the range, {} "
                           "jumps; from {:.4g} to {:.4g}, mean {:.5g}; oldest {:.3g} ms.\n",
                           tally.readings, request.seconds,
                           static_cast<double>(tally.readings) / request.seconds,
                           channel.source().rejected_readings(), channel.beyond_range(), channel.jumps(),
                           tally.lowest, tally.highest, tally.mean(), 1e3 * tally.worst);
  std::string words = tally.readings == 0 ? describe(channel.state()) : "";
  for (const auto& [state, seconds] : tally.seconds) {
    if (state == ForceState::kGood || tally.readings == 0) continue;
    words += fmt::format("{}{} ({:.3g} s)", words.empty() ? "" : "; ", describe(state), seconds);
  }
  if (!request.common.json.empty())
    write_tally(request, tally, channel, words.empty() ? describe(ForceState::kGood) : words);
  if (words.empty()) return kDone;
  print_message(fmt::format("{}: the sensor {}", request.source, words));
  return kDataCannotAnswer;
}

void add_calibrate(CLI::App& parent, Outcome& outcome) {
  const auto request = std::make_shared<LoadcellRequest>();
  CLI::App& command = *parent.add_subcommand("calibrate", "Offset and scale from known weights");
  add_value(command, "READINGS", request->readings, "CSV: mass,raw or force,raw; rows per weight");
  add_value(command, "--source serial:DEVICE[:BAUD][:text|binary]|udp:[ADDRESS:]PORT[:text|binary]",
            request->source, "Read the sensor itself, one weight after the other");
  add_value(command, "--weights M1,M2,...", request->weights, "Masses to hang on the sensor [kg]")
      ->delimiter(',');
  add_value(command, "--seconds S", request->seconds,
            "Duration of the reading for each weight [s] (2)", CLI::Range(0.01, 3600.0));
  add_value(command, "--gravity G", request->gravity, "[m/s^2] (9.81)", CLI::Range(0.1, 100.0));
  add_output_option(command, "-o,--output", request->output, "Write the calibration as YAML");
  add_common_options(command, request->common);
  command.callback([request, &outcome] { outcome.status = calibrate(*request); });
}

void add_read(CLI::App& parent, Outcome& outcome) {
  const auto request = std::make_shared<LoadcellRequest>();
  CLI::App& command =
      *parent.add_subcommand("read", "Show readings, and whether the sensor is alive");
  add_value(command, "SOURCE", request->source,
            "serial:DEVICE[:BAUD][:text|binary] or udp:[ADDRESS:]PORT[:text|binary]")
      ->required();
  add_value(command, "--calibration FILE", request->calibration,
            "Calibration file; without it readings are in counts");
  add_value(command, "--seconds S", request->seconds, "Duration [s] (2)", CLI::Range(0.01, 1e6));
  add_value(command, "--cutoff HZ", request->cutoff, "Cut-off of the low-pass filter [Hz]; 0: none",
            CLI::NonNegativeNumber);
  add_value(command, "--range N", request->range,
            "Of the cell [N]: readings beyond it are not given (200; without a calibration none)",
            CLI::PositiveNumber);
  add_value(command, "--jump N", request->jump,
            "Between two readings [N]: one that is farther off waits for a second that agrees with "
            "it (a tenth of the range)",
            CLI::PositiveNumber);
  add_value(command, "--silence MS", request->silence, "After which it is dead [ms] (15)",
            CLI::PositiveNumber);
  add_value(command, "--stuck MS", request->stuck,
            "Of equal readings, after which it is stuck [ms] (15); 0: never",
            CLI::NonNegativeNumber);
  add_output_option(command, "-o,--output", request->output, "Write t, raw, force as CSV");
  add_common_options(command, request->common);
  command.callback([request, &outcome] { outcome.status = read(*request); });
}

}  // namespace

void add_loadcell_command(CLI::App& tool, Outcome& outcome) {
  CLI::App& command = *tool.add_subcommand("loadcell", "Calibrate and read force sensors");
  command.require_subcommand(1);
  add_calibrate(command, outcome);
  add_read(command, outcome);
}

}  // namespace veridyn::cli
