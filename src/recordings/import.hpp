#pragma once

#include <memory>
#include <string>

#include "recordings/csv/csv_lines.hpp"
#include "recordings/bags/file_kind.hpp"
#include "recordings/signals/raw_recording.hpp"
#include "veridyn/recordings/recording.hpp"
#include "veridyn/recordings/recording_facts.hpp"

namespace veridyn::recordings {

/// A recording that is not a stream of rows t, q1..qn: read whole.
struct Imported {
  Recording recording;
  RecordingFacts facts;
};

/// The arm's signals out of everything that a file holds: which topic, which joints, on which clock,
/// in which units.
/// @throws InvalidInput  no positions; a joint that is wanted and not there; several topics that fit
/// equally well (only if joints are wanted; otherwise the first is taken and that is remarked).
Imported assemble(const RawRecording& raw, const std::string& path, const SignalChoice& choice);

/// A bag or an array file.
/// @throws InvalidInput  as assemble() does, or the file is damaged beyond use.
std::shared_ptr<const Imported> import_file(const OpenedFile& file, const RecordingOptions& options);

/// A CSV table with other names than t, q1..qn. @throws InvalidInput  as import_file().
std::shared_ptr<const Imported> import_table(CsvLines lines, const RecordingOptions& options);

/// What one of the above gave of the same file before, or nothing.
std::shared_ptr<const Imported> imported_before(const std::string& path,
                                                const RecordingOptions& options);

}  // namespace veridyn::recordings
