#pragma once

#include <string>

#include "veridyn/model/model.hpp"

namespace veridyn::cli {

/// Writes XML of a simulation; unless quiet, prints how many parts of the model its comments list as
/// left out.
void write_simulation_xml(const std::string& target, const char* format, const std::string& xml, bool quiet);

/// Writes the simulation's file `from` (MJCF or SDF) with the model's values, and prints which.
void write_updated_simulation(const Model& model, const std::string& from, const std::string& target,
                              bool quiet);

/// True for the endings of MJCF and SDF files.
bool is_simulation_file(const std::string& path);

/// Refuses `target` with such an ending for a robot that comes from another format.
void expect_simulation_of(const std::string& option, const std::string& target, const std::string& robot);

/// The model as write_updated_simulation() writes it, and the values that torques do not determine
/// are made plausible, see portable_model().
void save_as_simulation(const Model& model, const std::string& robot, const std::string& target, bool quiet);

}  // namespace veridyn::cli
