#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace veridyn {

using Words = std::vector<std::string>;

/// What one run of the tool left behind.
struct ToolRun {
  int status = -1;  ///< exit status; -1 if a signal ended it
  std::string out;
  std::string err;
  long peak_kib = 0;  ///< largest resident memory

  long error_lines() const;
};

/// Runs build/bin/veridyn as a user would, without a terminal.
/// @param working_folder  where it runs; empty: here
/// @param longest  [s] after which a signal ends it; 0: never
ToolRun run_tool(const Words& arguments, const std::string& working_folder = "", unsigned longest = 0);

/// a with b behind it.
Words operator+(Words a, const Words& b);

/// A folder of its own, gone with the object.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  /// Writes a file. @returns its path.
  std::string write(const std::string& name, const std::string& content) const;

  /// Names of all files, sorted.
  Words files() const;

 private:
  std::filesystem::path folder_;
};

std::string content_of(const std::string& path);

nlohmann::json json_of(const std::string& path);

/// A swinging planar-2r without noise, CSV with a header, 100 Hz.
/// @param shoulder, elbow  amplitude of each joint [rad]; 0: it rests.
std::string planar_recording(double seconds, double shoulder = 1.0, double elbow = 1.0);

}  // namespace veridyn
