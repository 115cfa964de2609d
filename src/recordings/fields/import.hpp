#pragma once

#include <string>

#include "recordings/bags/file_kind.hpp"
#include "recordings/signals/raw_recording.hpp"
#include "veridyn/recordings/recording.hpp"
#include "veridyn/recordings/recording_facts.hpp"

namespace veridyn::recordings {

/// A recording that is read as a whole: not a stream of rows t, q1..qn.
struct Imported {
  Recording recording;
  RecordingFacts facts;
};

/// Assembles the arm's signals from the contents of a file: chooses topic, joints, clock and units.
/// @throws InvalidInput  no positions; a missing joint of the arm; several topics that fit the arm equally
/// well (without an arm the first one is taken, with a remark).
Imported assemble(RawRecording raw, const std::string& path, const SignalChoice& choice);

/// Reads a bag or an array file.
/// @throws InvalidInput  as assemble(), or the file is too damaged.
Imported import_file(const OpenedFile& file, const RecordingOptions& options);

}  // namespace veridyn::recordings
