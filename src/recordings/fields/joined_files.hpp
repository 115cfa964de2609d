#pragma once

#include <string>
#include <vector>

#include "recordings/fields/import.hpp"

namespace veridyn::recordings {

/// Files of one motion that hold a part of the joints each, written `yaw.csv+pitch.csv`; empty where
/// `path` is one file.
std::vector<std::string> files_joined_by(const std::string& path);

/// Reads them as one recording, at the times of the file with the most joints, as long as all last. Joints
/// that all files number from 1 are counted in the order of the files.
/// @throws InvalidInput  as read_recording() of each; the same joint in two files; no time in common.
Imported import_joined(const std::string& path, const std::vector<std::string>& files, const RecordingOptions& options);

}  // namespace veridyn::recordings
