#pragma once

#include <string>
#include <vector>

#include "veridyn/diagnosis/watch.hpp"

namespace veridyn {

/// Results of watching one source, for reports.
struct WatchedSource {
  std::string source;
  double from = 0.0, to = 0.0;  ///< [s] watched interval
  double blind = 0.0;           ///< [s] part of it in which nothing could be watched
  double learned = 0.0;         ///< [s] part of it in which the noise was estimated and no alarm was possible
  std::vector<WatchEvent> events;
  std::vector<WatchState> states;  ///< one for each step

  /// Number of changes. The stages of one change count once; what was present from the beginning
  /// does not count.
  int alarms() const;
};

/// Writes one event as one line without line end: {"event": "named", "id": 1, "time": ..., ...}.
std::string json_line(const WatchEvent& event, const std::string& source);

/// Result of the command "watch": {"veridyn", "command", "robot", "sources": [{"source", "seconds", "learned",
/// "blind", "alarms", "alarms_per_hour", "events": [...]}], "running"}.
std::string to_json(const std::vector<WatchedSource>& sources, const Model& arm, bool running);

/// A page with these results and the residuals over time; it reloads every two seconds while `running`.
/// @param command  command line of the run.
std::string to_page(const std::vector<WatchedSource>& sources, const Model& arm,
                    const std::string& command, bool running);

}  // namespace veridyn
