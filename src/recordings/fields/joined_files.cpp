#include "recordings/fields/joined_files.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

#include "files/words.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::recordings {
namespace {

constexpr double kNanoseconds = 1e9;
constexpr std::size_t kDigits = 4;  // largest number of digits of a joint's number

// Reads one file with the names of its own joints, in the units of the file.
RawStream stream_of(const std::string& file, const RecordingOptions& options, RecordingFacts* facts) {
  RecordingOptions plain = options;
  plain.first_row = 0;
  plain.row_count.reset();
  plain.signals.joints.clear();
  plain.signals.held.clear();
  const auto only_time = [](std::map<std::string, std::string>* of) {
    for (auto at = of->begin(); at != of->end();) at = at->first == "t" ? std::next(at) : of->erase(at);
  };
  only_time(&plain.signals.map);
  only_time(&plain.signals.units);
  const Recording r = read_recording(file, plain, *facts);
  RawStream out;
  for (const RecordingSignal& signal : kRecordingSignals) {
    for (Eigen::Index j = 0; j < (r.*signal.values).cols(); ++j) {
      RawField field;
      field.joint = facts->joints[j];
      field.signal = static_cast<int>(&signal - kRecordingSignals);
      out.fields.push_back(field);
    }
  }
  const double start = facts->start;
  for (int row = 0; row < r.rows(); ++row) {
    out.recorded.push_back(std::llround(start * kNanoseconds) + std::llround(r.time[row] * kNanoseconds));
    for (const RecordingSignal& signal : kRecordingSignals) {
      const MatrixXd& values = r.*signal.values;
      for (Eigen::Index j = 0; j < values.cols(); ++j) out.values.push_back(values(row, j));
    }
  }
  return out;
}

// Numbers the joints consecutively over all files, if each file counts its own from 1.
void renumber_joints(const std::vector<std::string>& files, std::vector<RawStream>* streams) {
  std::set<std::string> all;
  std::string second, where;  // first name that an earlier file has as well
  bool numbers = true;
  for (std::size_t s = 0; s < streams->size(); ++s) {
    std::set<std::string> own;
    for (const RawField& f : (*streams)[s].fields) own.insert(f.joint);
    for (const std::string& name : own) {
      numbers = numbers && is_number(name) && name.size() <= kDigits;
      if (all.insert(name).second || !where.empty()) continue;
      second = name;
      where = files[s];
    }
  }
  if (where.empty()) return;
  require(numbers, where, ": found joint ", second, ", expected one that no file before it has.");
  int before = 0;
  for (RawStream& stream : *streams) {
    int most = 0;
    for (RawField& f : stream.fields) {
      const int number = std::stoi(f.joint);
      most = std::max(most, number);
      f.joint = std::to_string(before + number);
    }
    before += most;
  }
}

}  // namespace

std::vector<std::string> files_joined_by(const std::string& path) {
  std::error_code ignored;
  if (path.find('+') == std::string::npos || std::filesystem::exists(path, ignored)) return {};
  const std::vector<std::string> out = split(path, '+');
  const bool any = std::any_of(out.begin(), out.end(), [&ignored](const std::string& file) {
    return std::filesystem::exists(file, ignored);
  });
  return any ? out : std::vector<std::string>();
}

Imported import_joined(const std::string& path, const std::vector<std::string>& files, const RecordingOptions& options) {
  RawRecording raw;
  raw.format = "joined files";
  for (const std::string& file : files) {
    RecordingFacts facts;
    raw.streams.push_back(stream_of(file, options, &facts));
    for (const std::string& remark : facts.remarks) raw.remarks.push_back(file + ": " + remark);
  }
  renumber_joints(files, &raw.streams);
  for (RawStream& stream : raw.streams) {
    for (RawField& f : stream.fields) f.path = kRecordingSignals[f.signal].name + f.joint;
  }
  Imported out = assemble(std::move(raw), path, options.signals);
  const auto& q = out.recording.q;
  int first = 0;
  int end = out.recording.rows();
  while (first < end && !q.row(first).allFinite()) ++first;
  while (end > first && !q.row(end - 1).allFinite()) --end;
  require(end - first > 1, path, ": found no time that all ", files.size(),
          " files have in common, expected recordings of one motion with one clock.");
  out.recording = rows_of(out.recording, first, end - first);
  return out;
}

}  // namespace veridyn::recordings
