#pragma once

#include <functional>
#include <string>

#include "veridyn/recordings/recording.hpp"

namespace veridyn {

/// A recording that is open: its rows, at most so many at a time (none at the end), and what reading
/// brought up; remarks on rows are complete at the end.
struct OpenedRows {
  std::function<Recording(int)> next;
  std::function<RecordingFacts()> facts;
};

/// While one of these lives, files that are read by path are parsed once and kept in memory, up to
/// `most_bytes` of text in all; files beyond that are streamed every time. For work that asks many
/// questions of the same recordings. Threads share it; the innermost one counts.
class KeptRecordings {
 public:
  explicit KeptRecordings(long most_bytes = 400L << 20);
  ~KeptRecordings();
  KeptRecordings(const KeptRecordings&) = delete;
  KeptRecordings& operator=(const KeptRecordings&) = delete;

  struct State;

 private:
  State* before_;
};

/// The rows of a file, from memory where it is kept. @throws InvalidInput  as RecordingReader.
OpenedRows open_rows(const std::string& path, const RecordingOptions& options);

/// How many files open_rows() has opened and parsed since the program began.
long files_parsed();

}  // namespace veridyn
