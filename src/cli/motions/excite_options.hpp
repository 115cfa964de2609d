#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <utility>
#include <vector>

#include "veridyn/excitation/excitation.hpp"

namespace veridyn::cli {

// Parsers of the options of `excite`. Each throws CLI::ValidationError with the value found and the form
// expected.

/// Parses "EFFECT:PLACE,EFFECT:PLACE".
std::pair<Cause, Cause> parse_rivals(const Model& arm, const std::string& words);

/// Parses "FRAME:X,X,Y,Y,Z,Z" [m], from and to; "-inf" and "inf" leave a side open.
FrameBox parse_frame_box(const std::string& words);

/// Parses "FRAME:R" or "FRAME:R,X,Y,Z" [m].
Sphere parse_sphere(const std::string& words);

/// Parses "X,X,Y,Y,Z,Z" [m], from and to, the value of --keep-out.
Obstacle parse_obstacle_box(const std::string& words);

/// Parses "X,Y,Z,R" [m].
Sphere parse_obstacle(const std::string& words);

/// Parses "FRAME:LOW,HIGH" or "FRAME:LOW,HIGH,X,Y,Z" [m].
InsertionRange parse_insertion_range(const std::string& words);

/// All pairs of a sphere with an obstacle, or with a sphere on another frame.
std::vector<SpherePair> sphere_pairs(const std::vector<Sphere>& spheres,
                                     const std::vector<Sphere>& obstacles, double clearance);

/// Adds the options of the motion: --frequency to --limit-share.
void add_motion_options(CLI::App& command, ExcitationOptions& options);

/// Adds the options of the search: --criterion to --seed.
void add_search_options(CLI::App& command, ExcitationOptions& options);

}  // namespace veridyn::cli
