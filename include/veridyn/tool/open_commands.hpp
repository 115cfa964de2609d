#pragma once

#include <CLI/CLI.hpp>
#include <Eigen/Geometry>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "veridyn/control/inverse_kinematics.hpp"
#include "veridyn/model/model.hpp"
#include "veridyn/tool/common_options.hpp"
#include "veridyn/tool/file_to_write.hpp"
#include "veridyn/tool/program.hpp"

namespace veridyn::cli {

// Commands of the library to which a package adds options. The program of the package implements the command
// with all its options, and `veridyn` passes a call with one of these options on to it.

/// More files for `export`.
struct ExportExtension {
  std::string options;  ///< options that write files, for messages: "--a or --b"
  std::function<void(CLI::App&)> add_options;
  std::function<void()> check;                      ///< @throws CLI::ValidationError
  std::function<std::vector<std::string>()> paths;  ///< the files to write; empty paths were not given
  std::function<void(const Model&, std::vector<FileToWrite>&)> add_files;
};

/// Adds `export`; nullopt: with the options of the library alone.
void add_export_command(CLI::App& tool, Outcome& outcome, const std::optional<ExportExtension>& extension);

/// Arms that `kinematics` knows by another name.
struct KinematicsExtension {
  /// Solves for the pose of the frame "tip"; `q` starts at the previous row.
  using InverseSolver = std::function<ReachStatus(const Eigen::Isometry3d& T_world_tip, VectorXd& q)>;
  struct Arm {
    Model model;
    InverseSolver closed_form;
  };
  std::string robots;  ///< text that the help shows after "Robot file or name"
  std::function<std::optional<Arm>(const std::string& name)> read;
};

/// Adds `kinematics`, which reads the arms of the extension too.
void add_kinematics_command(CLI::App& tool, Outcome& outcome, const KinematicsExtension& extension);

/// A purpose of `excite` other than a motion for identification.
struct ExciteExtension {
  struct Request {
    const CLI::App* command = nullptr;
    std::string robot, output;
    unsigned seed = 0;
    std::optional<double> limit_share;
    CommonOptions common;
  };
  std::function<void(CLI::App&)> add_options;
  /// Runs the extension's part of `excite`; nullopt: the request is for a motion, which the library designs.
  std::function<std::optional<ExitStatus>(const Request&)> run;
};

/// Adds `excite`; nullopt: for motions alone.
void add_excite_command(CLI::App& tool, Outcome& outcome, const std::optional<ExciteExtension>& extension);

}  // namespace veridyn::cli
