// files/: readers and writers of robot files (YAML, URDF, MJCF, SDF, JSON, C), with helpers for files and text.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "veridyn/model/model.hpp"

namespace veridyn {

struct ModelFileOptions {
  /// Values that replace constants of the file (`constants:`), to test hypotheses about them.
  std::map<std::string, double> constants;
};

/// Reads a robot, or a model (a robot with identified values), in the format of docs/robot-files.md.
///
/// @param robot  a path that ends in .yaml, .yml, .urdf, .xml, .mjcf or .sdf, or the bare name of a file in
///               data/robots/. Bare names are looked for in the folder $VERIDYN_ROBOTS, then in
///               those that the build knows.
/// @throws InvalidInput  "file:line:column: found ..., expected ...".
Model read_model(const std::string& robot, const ModelFileOptions& options = {});

/// The file that read_model() reads for this name. @throws InvalidInput  no robot has it.
std::string robot_path(const std::string& robot);

/// Reads YAML from memory; `file` is its name in messages.
Model read_yaml(const std::string& content, const std::string& file,
                const ModelFileOptions& options = {});

/// Statistics in a model's file, beside the values and their standard deviations (`std:` in bodies
/// and effects, `drive_gain_std:` in coordinates):
///
///   identified:
///     recordings: [one.csv]         # used for training
///     clusters: 8                   # of the jackknife; degrees of freedom are one fewer
///     error: [0.04, 0.12]           # relative, per joint, on these recordings
///     noise: [0.2, 0.5]             # [N m], [N]: IdentifiedBase::noise
///     motion: [[..], ..]            # IdentifiedBase::motion, a row for every cluster
///     base:
///       - {name: hx_upper, unit: kg m, value: 2.25, free: 2.26, std: 0.01,
///          of: {hx_upper: 1, m_upper: 0.5}, factor: [..]}   # IdentifiedParameter
///
/// `value` is the combination of the model's parameters; if they were changed since, the statistics
/// are not used. `std` follows from `factor` and serves human readers.
///
/// The robot file of a model, laid out like a hand-written one. read_yaml(to_yaml(m)) is m; expressions of the file
/// are written back where they still have the parameter's value, so that constants keep their meaning.
std::string to_yaml(const Model& arm);

/// Writes to_yaml() to a file. @throws InvalidInput  the file cannot be written.
void save_model(const Model& arm, const std::string& path);

/// Bare names that read_model() knows, sorted.
std::vector<std::string> robot_names();

}  // namespace veridyn
