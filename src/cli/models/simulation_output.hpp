#pragma once

#include <string>

#include "veridyn/tool/file_to_write.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn::cli {

/// A file with the XML of a simulation; a message states how many parts of the model its comments list as left out.
FileToWrite simulation_xml(const std::string& target, const char* format, std::string xml);

/// The simulator's file `from` (MJCF or SDF) with the model's values, and a message with the changed ones.
FileToWrite updated_simulation(const Model& model, const std::string& from, const std::string& target);

/// True for the endings of MJCF and SDF files.
bool is_simulation_file(const std::string& path);

/// @throws CLI::ValidationError  `target` has such an ending, but the robot comes from another format.
void expect_simulation_of(const std::string& option, const std::string& target, const std::string& robot);

/// Writes the model as updated_simulation(); values that torques do not determine are made plausible,
/// see portable_model().
void save_as_simulation(const Model& model, const std::string& robot, const std::string& target, bool quiet);

}  // namespace veridyn::cli
