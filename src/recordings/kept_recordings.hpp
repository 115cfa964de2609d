#pragma once

#include <functional>
#include <memory>
#include <string>

#include "recordings/prepared_recording.hpp"
#include "veridyn/recordings/recording.hpp"
#include "veridyn/recordings/recording_quality.hpp"

namespace veridyn {

/// An open recording: a function for its next rows (none at the end), and the facts found while reading; the
/// remarks on rows are complete at the end.
struct OpenedRows {
  std::function<Recording(int)> next;
  std::function<RecordingFacts()> facts;
};

/// Files that are parsed once and kept in memory, up to `most_bytes` of text in total, and their prepared forms, up
/// to as many bytes; rows of other files are in RowsOnDisk. Pipes are always kept. Code that reads the same
/// recordings many times creates one and passes it on in PreprocessingOptions::kept. Threads may share it.
class KeptRecordings {
 public:
  static constexpr long kManyQuestions = 400L << 20;  ///< [bytes] largest text that is kept for a diagnosis
  static constexpr long kFewPasses = 10L << 20;       ///< [bytes] largest text for a few passes over each file

  explicit KeptRecordings(long most_bytes = kManyQuestions);
  ~KeptRecordings();
  KeptRecordings(const KeptRecordings&) = delete;
  KeptRecordings& operator=(const KeptRecordings&) = delete;

  /// The parsed recording, read by the first caller; null if it does not fit.
  struct Whole {
    Recording rows;
    RecordingFacts facts;
  };
  std::shared_ptr<const Whole> find(const std::string& path, const RecordingOptions& options);

  /// Quality of a recording's first rows, evaluated by the first caller.
  RecordingQuality quality(const std::string& path, const RecordingOptions& options,
                           const std::function<RecordingQuality()>& judge);

  /// The quality of a recording's first rows if it has been evaluated already, else null.
  std::shared_ptr<const RecordingQuality> known_quality(const std::string& path,
                                                        const RecordingOptions& options);

  /// A recording in memory, prepared by the first caller; null if it does not fit.
  /// @param bytes  memory that it needs. @throws  the exceptions of make(); the next caller tries again.
  std::shared_ptr<const PreparedRecording> prepared(const PreparationKey& key, long bytes,
                                                    const std::function<PreparedRecording()>& make);

  /// A pass over a recording that is not in memory, from its text or from RowsOnDisk.
  /// The object must outlive it.
  OpenedRows stored_rows(const std::string& path, const RecordingOptions& options);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The rows of a file, from memory if the file is kept and options.row_count includes all rows.
/// @throws InvalidInput  as RecordingReader.
OpenedRows open_rows(const std::string& path, const RecordingOptions& options,
                     KeptRecordings* kept = nullptr);

/// Like read_recording(), from memory if the file is kept.
Recording read_rows(const std::string& path, const RecordingOptions& options,
                    KeptRecordings* kept);

/// Like check_recording(), for open rows.
RecordingQuality check_rows(const std::string& path, const OpenedRows& rows);

/// Number of files that open_rows() has opened and parsed since the program began.
long files_parsed();

}  // namespace veridyn
