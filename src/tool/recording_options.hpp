#pragma once

#include <CLI/CLI.hpp>
#include <map>
#include <string>
#include <vector>

#include "veridyn/model/model.hpp"
#include "veridyn/recordings/preprocessing.hpp"
#include "veridyn/recordings/recording_quality.hpp"

namespace veridyn::cli {

struct CommonOptions;

/// Heading in the help for options that concern the reading of recordings.
inline constexpr const char* kRecordings = "Recordings";

/// Adds --topic, --map and --units.
void add_signal_options(CLI::App& command, SignalChoice& signals);

/// Adds --fix and --drive-gains.
void add_robot_options(CLI::App& command, CommonOptions& options);

/// Warns of physically impossible bodies in the robot file, for commands whose results do not report them.
void warn_of_impossible_bodies(const std::string& robot, const Model& arm);

/// Reads the robot of a command, with --fix and --drive-gains applied.
/// @param signals  receives the joints that --fix holds, which recordings may contain nevertheless.
/// @throws InvalidInput  the file is bad. @throws CLI::ValidationError  --fix names no joint of it,
/// or the number of drive gains differs from that of the joints.
Model read_robot(const std::string& robot, const CommonOptions& options, SignalChoice* signals = nullptr);

/// The options for `excite --given` that correspond to `how`: columns, rate, topics, names, units,
/// rows, and joints held by --fix.
std::vector<std::string> options_for_given(const PreprocessingOptions& how,
                                         const std::map<std::string, double>& fixed);

/// Reports matched joints and remarks of the readers.
void report_facts(const std::vector<RecordingQuality>& recordings);

/// Checks the first rows of every recording: reports matched joints, remarks of the reader, and recordings that
/// are probably in degrees or millimetres.
void check_recordings(const Model& arm, const std::vector<std::string>& recordings,
                        const PreprocessingOptions& how, int threads);

}  // namespace veridyn::cli
