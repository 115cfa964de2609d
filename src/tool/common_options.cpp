#include "veridyn/tool/common_options.hpp"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <utility>

#include "veridyn/tool/choice.hpp"
#include "veridyn/tool/messages.hpp"
#include "tool/recording_options.hpp"
#include "veridyn/tool/sound_arguments.hpp"
#include "files/output_file.hpp"
#include "recordings/same_recording.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/report/setting_names.hpp"

namespace veridyn::cli {
namespace {

// Parses a nonnegative whole number; -1 for anything else.
long row_number(const std::string& digits) {
  long value = -1;
  const char* end = digits.data() + digits.size();
  const auto [stop, error] = std::from_chars(digits.data(), end, value);
  return error == std::errc() && stop == end && value >= 0 ? value : -1;
}

RowRange row_range(const std::string& option, const std::string& words) {
  const auto colon = words.find(':');
  const std::string first = words.substr(0, colon);
  const std::string end = colon == std::string::npos ? "" : words.substr(colon + 1);
  const long a = first.empty() ? 0 : row_number(first);
  const long b = end.empty() ? -1 : row_number(end);
  if (colon == std::string::npos || a < 0 || (!end.empty() && b <= a)) {
    throw CLI::ValidationError(option, "found '" + words +
                                           "', expected rows A:B with A < B, as 200:1311 (the "
                                           "first row is 0, B itself is left out)");
  }
  return {a, end.empty() ? std::nullopt : std::make_optional(b - a)};
}

std::vector<std::string> signal_names(const std::string& option, const std::string& words) {
  std::vector<std::string> known = {"t"};
  for (const RecordingSignal& signal : kRecordingSignals) known.emplace_back(signal.name);
  std::vector<std::string> names = CLI::detail::split(words, ',');
  for (const std::string& name : names) {
    // A signal of all joints has no number, as "tau"; that of one joint has one, as "tau2".
    const std::string signal = name.substr(0, name.find_last_not_of("0123456789") + 1);
    const bool of_joint = signal != name && signal != "t";
    if (std::find(known.begin(), known.end(), of_joint ? signal : name) != known.end()) continue;
    throw CLI::ValidationError(
        option, "found '" + name + "', expected names out of " + listed(known) + ", as q,dq,tau or q1,dq1,tau1,q2");
  }
  return names;
}

}  // namespace

void add_common_options(CLI::App& command, CommonOptions& options) {
  const char* const group = "Common";
  add_output_option(command, "--json", options.json, "Write the result as JSON")
      ->group(group);
  add_value(command, "--threads N", options.threads, "Threads; 0: one per core",
            CLI::NonNegativeNumber)
      ->group(group);
  command.add_flag("--quiet", options.quiet, "Do not print progress on standard error")
      ->group(group);
  command.set_version_flag("--version", "veridyn " VERIDYN_VERSION)->group(group);
}

void add_report_option(CLI::App& command, CommonOptions& options) {
  add_output_option(command, "--report", options.report,
                    "Write the result as one HTML page with plots")
      ->group("Common");
}

void add_robot_argument(CLI::App& command, std::string& robot) {
  add_value(command, "ROBOT", robot,
            "YAML, URDF, MJCF or SDF file, or the bare name of a robot that comes with the tool")
      ->required();
}

CLI::Option* add_row_range(CLI::App& command, const std::string& option, const std::string& help,
                           std::function<void(RowRange)> take) {
  const auto parse = [option, take = std::move(take)](const std::string& words) {
    take(row_range(option, words));
  };
  return command.add_option_function<std::string>(option, parse, help)
      ->option_text("A:B")
      ->group(kRecordings);
}

void add_headerless_options(CLI::App& command, std::vector<std::string>& columns, double& rate,
                            const std::string& rate_option) {
  const auto parse = [&columns](const std::string& words) {
    columns = signal_names("--columns", words);
  };
  command
      .add_option_function<std::string>("--columns", parse,
                                        "Signals of CSV files in the order of their columns, as "
                                        "q,dq,tau; a header line is skipped")
      ->option_text("NAMES")
      ->group(kRecordings);
  command.add_option(rate_option, rate, "Sample rate of CSV files without a time column [Hz]")
      ->option_text("HZ")
      ->check(CLI::PositiveNumber)
      ->group(kRecordings);
}

void add_preprocessing_options(CLI::App& command, PreprocessingOptions& o) {
  add_headerless_options(command, o.columns, o.header_rate);
  add_signal_options(command, o.signals);
  add_row_range(command, "--rows", "Samples to use; filters still see the others",
                [&o](RowRange rows) {
                  o.first_row = rows.first;
                  o.row_count = rows.count;
                });
  const auto number = [&command](const char* option, double& target, const char* unit,
                                 const char* help) {
    command.add_option(option, target, help)
        ->option_text(unit)
        ->check(CLI::NonNegativeNumber)
        ->capture_default_str()
        ->group(kRecordings);
  };
  number("--filter-cutoff", o.cutoff, "HZ",
         "Cut-off of the zero-phase low-pass filter [Hz]; 0: none");
  add_value(command, "--filter-order N", o.order, "Filter order of each of the two passes",
            CLI::Range(1, 20))
      ->group(kRecordings);
  add_choice(command, "--filtering", o.filtering, {Filtering::kMatched, Filtering::kSignals},
             "Filter torque and regressor columns alike (matched), or the measured signals")
      ->group(kRecordings);
  add_choice(command, "--velocity", o.velocity,
             {VelocitySource::kRecorded, VelocitySource::kDerived},
             "Use recorded velocities, or differentiate positions")
      ->group(kRecordings);
  add_choice(command, "--stale-rows", o.stale_rows, {StaleRows::kFilled, StaleRows::kKept},
             "Duplicated samples of a late publisher: interpolate, or keep")
      ->group(kRecordings);
  number("--resample", o.rate, "HZ", "Uniform sample rate [Hz]; 0: one over the median time step");
  number("--drop-start", o.drop_start, "S", "Seconds to drop at the start of each file");
  number("--drop-end", o.drop_end, "S", "Seconds to drop at the end of each file");
  number("--min-speed", o.min_speed, "V",
         "Exclude samples at which a joint is slower than this [rad/s or m/s]");
  add_value(command, "--decimation N", o.decimation,
            "Keep every N-th filtered sample; 0: as many as the cut-off frequency needs",
            CLI::NonNegativeNumber)
      ->group(kRecordings);
}

void add_friction_option(CLI::App& command, JointFriction& friction) {
  add_choice(command, "--friction", friction,
             {JointFriction::kAuto, JointFriction::kPlain, JointFriction::kFile},
             "Friction of the joints: plain adds viscous and Coulomb friction, an offset and, "
             "where identifiable, rotor inertia; file keeps the robot file's; auto is plain for a "
             "URDF without friction");
}

void require_writable(const std::string& path) {
  if (path.empty()) return;
  struct stat there {};
  const bool exists = ::stat(path.c_str(), &there) == 0;
  require(!exists || !S_ISDIR(there.st_mode), path,
          ": cannot be written: found a folder, expected a file name.");
  // A pipe is not opened, since closing it would end it for its reader.
  if (exists && !S_ISREG(there.st_mode)) {
    require(::access(path.c_str(), W_OK) == 0, path, ": cannot be written: no permission.");
    return;
  }
  const OutputFile probe(path);
}

void warn_of_shared_recordings(const std::vector<std::string>& train,
                               const std::vector<std::string>& test) {
  for (const std::string& path : test) {
    if (std::any_of(train.begin(), train.end(),
                    [&path](const std::string& other) { return same_recording(path, other); }))
      print_message("warning: " + path + " is both learned from and tested on: its error is not held out.");
  }
}

void warn_of_repeated_recordings(const std::vector<std::string>& train) {
  std::vector<std::vector<std::string>> alike;  // files of equal contents, in the given order
  for (const std::string& path : train) {
    const auto group = std::find_if(alike.begin(), alike.end(), [&](const auto& files) {
      return same_recording(path, files.front());
    });
    if (group == alike.end()) alike.push_back({path});
    else group->push_back(path);
  }
  for (const std::vector<std::string>& files : alike) {
    if (files.size() == 1) continue;
    const size_t others = files.size() - 2;
    print_message("warning: " + files[1] +
        (others == 0 ? " holds the same as " + files[0] + " and counts"
                     : fmt::format(" and {} other{} hold the same as {} and count", others, others == 1 ? "" : "s", files[0])) +
        " once more: error bars come out too small; give it once.");
  }
}

}  // namespace veridyn::cli
