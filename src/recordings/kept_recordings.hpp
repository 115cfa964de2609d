#pragma once

#include <functional>
#include <memory>
#include <string>

#include "recordings/prepared_recording.hpp"
#include "veridyn/recordings/recording.hpp"
#include "veridyn/recordings/recording_quality.hpp"

namespace veridyn {

/// A recording that is open: its rows, at most so many at a time (none at the end), and what reading
/// brought up; remarks on rows are complete at the end.
struct OpenedRows {
  std::function<Recording(int)> next;
  std::function<RecordingFacts()> facts;
};

/// Files that are parsed once and kept in memory, up to `most_bytes` of text in all, and what they
/// are once they are prepared, up to as many bytes; files beyond that are streamed every time. Pipes
/// are kept in any case. For work that asks many questions of the same recordings: it makes one and
/// hands it on in PreprocessingOptions::kept. Threads may share it.
class KeptRecordings {
 public:
  static constexpr long kManyQuestions = 400L << 20;  ///< bound of a diagnosis
  static constexpr long kFewPasses = 10L << 20;       ///< bound where files are read a few times

  explicit KeptRecordings(long most_bytes = kManyQuestions);
  ~KeptRecordings();
  KeptRecordings(const KeptRecordings&) = delete;
  KeptRecordings& operator=(const KeptRecordings&) = delete;

  /// The recording, parsed by whoever asks first; nothing if it is not to be kept.
  struct Whole {
    Recording rows;
    RecordingFacts facts;
  };
  std::shared_ptr<const Whole> find(const std::string& path, const RecordingOptions& options);

  /// A recording that is in memory, prepared by whoever asks first; nothing if it is not to be kept.
  /// @param bytes  that it will take.
  /// @throws  what make() throws; whoever asks then makes it again.
  std::shared_ptr<const PreparedRecording> prepared(const PreparationKey& key, long bytes,
                                                    const std::function<PreparedRecording()>& make);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The rows of a file, from memory where it is kept and options.row_count takes in all of them.
/// @throws InvalidInput  as RecordingReader.
OpenedRows open_rows(const std::string& path, const RecordingOptions& options,
                     KeptRecordings* kept = nullptr);

/// As read_recording(), from memory where the file is kept.
Recording read_rows(const std::string& path, const RecordingOptions& options,
                    KeptRecordings* kept);

/// As check_recording(), of rows that are open.
RecordingQuality check_rows(const std::string& path, const OpenedRows& rows);

/// How many files open_rows() has opened and parsed since the program began.
long files_parsed();

}  // namespace veridyn
