#include "tool/recording_options.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <map>
#include <set>

#include "veridyn/tool/messages.hpp"
#include "veridyn/tool/option_checks.hpp"
#include "identification/velocity_choice.hpp"
#include "recordings/signals/units.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/model/fixed_coordinates.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/files/physical_faults.hpp"

namespace veridyn::cli {
namespace {


// Splits "a=b,c=d" into pairs.
std::vector<std::pair<std::string, std::string>> pairs_in(const std::string& option,
                                                          const std::string& words,
                                                          const char* example) {
  std::vector<std::pair<std::string, std::string>> pairs;
  for (const std::string& one : CLI::detail::split(words, ',')) {
    const std::size_t equals = one.find('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == one.size())
      throw CLI::ValidationError(option, "found '" + one + "', expected NAME=VALUE, as " + example);
    pairs.emplace_back(one.substr(0, equals), one.substr(equals + 1));
  }
  return pairs;
}

// Adds an option that may be repeated, each time with a list.
void add_list(CLI::App& command, const std::string& option, const char* shape, const char* help,
              const std::function<void(const std::string&)>& take) {
  command
      .add_option_function<std::vector<std::string>>(
          option,
          [take](const std::vector<std::string>& all) {
            for (const std::string& one : all) take(one);
          },
          help)
      ->option_text(shape)
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->group(kRecordings);
}

}  // namespace

void add_signal_options(CLI::App& command, SignalChoice& signals) {
  add_list(command, "--topic", "NAME", "Topic of the joint states, if a bag has several",
           [&signals](const std::string& words) {
             for (const std::string& topic : CLI::detail::split(words, ','))
               signals.topics.push_back(topic);
           });
  add_list(command, "--map", "SIGNAL=SOURCE",
           "Where a signal is found, as tau1=/arm/effort/0, tau=/arm/effort, t=stamp, or a joint: "
           "yaw=outer_yaw",
           [&signals](const std::string& words) {
             for (const auto& [key, source] : pairs_in("--map", words, "tau1=/arm/effort/0"))
               signals.map[key] = source;
           });
  add_list(command, "--units", "SIGNAL=UNIT",
           "Units other than SI, as q=deg,t=ms; tau=A: motor currents; q=4096/rev: counts; tau=%: of the limit; q=0.01: a factor",
           [&signals](const std::string& words) {
             for (const auto& [key, unit] : pairs_in("--units", words, "q=deg,t=ms"))
               signals.units[key] = unit;
             try {
               recordings::require_known_units(signals);
             } catch (const InvalidInput& error) {
               throw CLI::ValidationError(error.what());
             }
           });
  command.add_flag("--as-recorded", signals.as_recorded, "Keep rows that are plainly wrong: dropouts, wrapped angles, bursts, a clock that steps back")
      ->group(kRecordings);
}

void add_robot_options(CLI::App& command, CommonOptions& options) {
  add_value(command, "--gravity X,Y,Z", options.gravity,
            "Direction of gravity in the robot file's base [m/s^2], as on another mount; 0,0,0: the torques hold none")
      ->delimiter(',')
      ->expected(3);
  add_value(command, "--drive-gains K,K,...", options.drive_gains,
            "Torque per ampere of each joint [N m/A], for recordings of motor currents")
      ->delimiter(',');
  std::map<std::string, double>& fixed = options.fixed;
  add_list(command, "--fix", "JOINT=VALUE", "Position of a joint that is not recorded or stands still [rad or m]",
           [&fixed](const std::string& words) {
             for (const auto& [joint, value] : pairs_in("--fix", words, "finger=0")) {
               const char* end = value.data() + value.size();
               const auto [rest, error] = std::from_chars(value.data(), end, fixed[joint]);
               if (error != std::errc() || rest != end)
                 throw CLI::ValidationError("--fix", "found '" + value + "', expected a number");
             }
           });
}

void warn_of_impossible_bodies(const std::string& robot, const Model& arm) {
  for (const std::string& fault : physical_faults(arm)) print_message("warning: " + robot + ": impossible: " + fault + ".");
}

Model read_robot(const std::string& robot, const CommonOptions& options, SignalChoice* signals) {
  const Model whole = read_model(robot);
  const Model arm = value_of("--fix", [&] { return with_fixed(whole, options.fixed); });
  for (int i = 0; signals != nullptr && i < whole.joints(); ++i) {
    const Coordinate& c = whole.coordinates()[i];
    const auto fixed = options.fixed.find(c.name);
    if (fixed != options.fixed.end())
      signals->held.push_back({i + 1, {c.name, c.prismatic}, fixed->second});
  }
  ModelDescription d = arm.description();
  if (!options.gravity.empty()) d.gravity = Eigen::Map<const Eigen::Vector3d>(options.gravity.data());
  const Model turned(std::move(d));
  if (options.drive_gains.empty()) return turned;
  return value_of("--drive-gains", [&] { return with_drive_gains(turned, options.drive_gains); });
}

std::vector<std::string> options_for_given(const PreprocessingOptions& how,
                                         const std::map<std::string, double>& fixed) {
  std::vector<std::string> words;
  const auto add = [&words](const char* option, const std::string& value) {
    words.insert(words.end(), {option, value});
  };
  if (!how.columns.empty()) add("--columns", CLI::detail::join(how.columns));
  if (how.header_rate > 0.0) add("--given-rate", fmt::format("{}", how.header_rate));
  for (const std::string& topic : how.signals.topics) add("--topic", topic);
  for (const auto& [signal, source] : how.signals.map) add("--map", signal + "=" + source);
  for (const auto& [signal, unit] : how.signals.units) add("--units", signal + "=" + unit);
  if (how.first_row > 0 || how.row_count) {
    add("--rows", text(how.first_row, ":",
                       how.row_count ? std::to_string(how.first_row + *how.row_count) : ""));
  }
  if (how.signals.as_recorded) words.push_back("--as-recorded");
  for (const auto& [joint, value] : fixed) add("--fix", joint + "=" + fmt::format("{}", value));
  return words;
}

void report_facts(const std::vector<RecordingQuality>& recordings) {
  std::set<std::string> told;
  for (const RecordingQuality& quality : recordings) {
    const std::string match = quality.facts.match();
    if (!match.empty() && told.insert(match).second) print_message(quality.file + ": " + match);
    for (const std::string& remark : quality.facts.remarks) print_message(quality.file + ": " + remark);
  }
}

void check_recordings(const Model& arm, const std::vector<std::string>& recordings,
                        const PreprocessingOptions& how, int threads) {
  const std::vector<RecordingQuality> seen = quick_quality(arm, recordings, how, threads);
  report_facts(seen);
  std::map<QualityKind, std::pair<std::string, int>> kinds;  // text of each kind of warning, and number of further
                                                             // ones
  const auto in_all = [&](QualityKind kind) { return std::all_of(seen.begin(), seen.end(), [&](const RecordingQuality& q) { return q.find(kind) != nullptr; }); };
  for (const RecordingQuality& quality : seen) {
    for (const QualityFinding& f : quality.findings) {
      // A recording with hardly any usable row is reported by its reader.
      const bool dead_joint = f.kind == QualityKind::kZeroSignal && f.joint;  // one joint of several
      const bool no_number = f.joint && f.share == 1.0;
      if (f.kind == QualityKind::kNoTorque || f.kind == QualityKind::kShortRecording || (f.kind == QualityKind::kZeroSignal && !f.joint)) {
        explain_refusal(quality.file, f.sentence);
        continue;
      }
      if (f.kind == QualityKind::kDegrees || dead_joint || (f.kind == QualityKind::kMoveAsOne && in_all(f.kind)) || (f.severity == Severity::kFault && (f.kind != QualityKind::kGaps || no_number)))
        ++kinds.emplace(f.kind, std::pair("warning: " + quality.file + ": " + f.sentence, -1)).first->second.second;
    }
  }
  for (const auto& [kind, said] : kinds) {
    const auto& [sentence, more] = said;
    print_message(sentence + (more > 0 ? text(" (And ", more, " more of this kind: `veridyn check` lists them.)") : ""));
  }
}

}  // namespace veridyn::cli
