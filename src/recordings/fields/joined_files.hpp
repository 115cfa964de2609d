#pragma once

#include <string>
#include <vector>

#include "recordings/fields/import.hpp"

namespace veridyn::recordings {

/// Names of the files in a path such as `yaw.csv+pitch.csv`, which holds one motion with a part of the joints
/// in each file; empty if `path` is a single file.
std::vector<std::string> files_joined_by(const std::string& path);

/// Reads them as one recording, at the times of the file with the most joints, over the time that all files
/// have in common. If all files number their joints from 1, joints are numbered in the order of the files.
/// @throws InvalidInput  as read_recording() of each; the same joint in two files; no time in common.
Imported import_joined(const std::string& path, const std::vector<std::string>& files, const RecordingOptions& options);

}  // namespace veridyn::recordings
