#include "veridyn/recordings/growing_recording.hpp"

#include <chrono>
#include <thread>
#include <utility>

#include "recordings/csv/row_source.hpp"

namespace veridyn {
namespace {

constexpr std::chrono::milliseconds kPause{20};

}  // namespace

GrowingRecording::GrowingRecording(const std::string& path, const RecordingOptions& options,
                                   std::function<bool()> go_on) {
  const bool pipe = path == "-";  // the end of a pipe is final; a file may still grow
  const auto wait = [pipe, go_on = std::move(go_on)] {
    if (pipe || !go_on()) return false;
    std::this_thread::sleep_for(kPause);
    return true;
  };
  source_ = recordings::csv_rows(CsvLines(ByteStream(pipe ? "/dev/stdin" : path, wait)), options,
                                 recordings::RowClock::kMayBeSetBack);
}

GrowingRecording::~GrowingRecording() = default;

Recording GrowingRecording::next(int rows) { return source_->next(rows); }

}  // namespace veridyn
