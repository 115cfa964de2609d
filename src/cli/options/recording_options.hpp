#pragma once

#include <CLI/CLI.hpp>
#include <map>
#include <string>
#include <vector>

#include "veridyn/model/model.hpp"
#include "veridyn/recordings/preprocessing.hpp"
#include "veridyn/recordings/recording_quality.hpp"

namespace veridyn::cli {

/// Heading in the help above the options that say how recordings are read.
inline constexpr const char* kRecordings = "Recordings";

/// Adds --topic, --map and --units.
void add_signal_options(CLI::App& command, SignalChoice& signals);

/// Adds --fix and --drive-gains.
void add_robot_options(CLI::App& command, CommonOptions& options);

/// The robot of a command, without the coordinates that --fix holds, with --drive-gains.
/// @throws InvalidInput  the file is bad. @throws CLI::ValidationError  --fix names no joint of it, or
/// there is not one drive gain for each.
Model read_robot(const std::string& robot, const CommonOptions& options);

/// The options by which `excite --given` reads recordings as `how` does: columns, rate, topics, names,
/// units, rows, and joints that --fix holds.
std::vector<std::string> words_for_given(const PreprocessingOptions& how,
                                         const std::map<std::string, double>& fixed);

/// Says which joints were matched, and what reading the files brought up.
void tell_facts(const std::vector<RecordingQuality>& recordings);

/// Looks at the first rows of every recording: says which joints were matched, what reading brought
/// up, and where a recording looks as if it were in degrees or millimetres.
void look_at_recordings(const Model& arm, const std::vector<std::string>& recordings,
                        const PreprocessingOptions& how, int threads);

}  // namespace veridyn::cli
