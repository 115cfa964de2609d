#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <utility>
#include <vector>

#include "veridyn/excitation/excitation.hpp"

namespace veridyn::cli {

// Parsers of the options of `excite`; each throws CLI::ValidationError with the value found and the
// form expected.

/// "EFFECT:PLACE,EFFECT:PLACE".
std::pair<Cause, Cause> parse_rivals(const Model& arm, const std::string& words);

/// "FRAME:X,X,Y,Y,Z,Z", from and to; "-inf" and "inf" leave a side open.
FrameBox parse_frame_box(const std::string& words);

/// "FRAME:R" or "FRAME:R,X,Y,Z".
Sphere parse_sphere(const std::string& words);

/// "X,X,Y,Y,Z,Z", from and to, of --keep-out.
Obstacle parse_obstacle_box(const std::string& words);

/// "X,Y,Z,R".
Sphere parse_obstacle(const std::string& words);

/// "FRAME:LOW,HIGH" or "FRAME:LOW,HIGH,X,Y,Z".
InsertionRange parse_insertion_range(const std::string& words);

/// Every sphere keeps away from every obstacle and from the spheres on other frames.
std::vector<SpherePair> sphere_pairs(const std::vector<Sphere>& spheres,
                                     const std::vector<Sphere>& obstacles, double clearance);

/// Adds the options of the motion: --frequency to --limit-share.
void add_motion_options(CLI::App& command, ExcitationOptions& options);

/// Adds the options of the search: --criterion to --seed.
void add_search_options(CLI::App& command, ExcitationOptions& options);

}  // namespace veridyn::cli
