#include "recordings/kept_recordings.hpp"

#include <algorithm>
#include <atomic>
#include <exception>
#include <filesystem>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <system_error>
#include <utility>

namespace veridyn {

struct KeptRecordings::State {
  using Kept = std::shared_future<std::shared_ptr<const Whole>>;

  std::mutex mutex;
  long bytes_left = 0;
  std::map<std::string, Kept> recordings;  // by path and reading options
};

namespace {

std::atomic<long> g_parsed{0};

std::string key_of(const std::string& path, const RecordingOptions& options) {
  std::string out = path + "\n" + std::to_string(options.rate);
  out += " " + std::to_string(options.first_row) + " " + std::to_string(options.row_count);
  for (const std::string& column : options.columns) out += "\n" + column;
  const SignalChoice& signals = options.signals;
  for (const std::string& topic : signals.topics) out += "\ntopic " + topic;
  for (const auto& [name, source] : signals.map) out += "\nmap " + name + "=" + source;
  for (const auto& [name, unit] : signals.units) out += "\nunit " + name + "=" + unit;
  for (const WantedJoint& joint : signals.joints)
    out += "\njoint " + joint.name + (joint.prismatic ? " slides" : "");
  return out;
}

// Size of a text file. A pipe cannot be read twice: it counts as small and is kept in any case.
long text_bytes(const std::string& path) {
  std::error_code error;
  if (std::filesystem::is_fifo(path, error)) return 0;
  const auto size = std::filesystem::file_size(path, error);
  return error ? -1 : static_cast<long>(size);
}

using Whole = KeptRecordings::Whole;

std::shared_ptr<const Whole> parsed(const std::string& path, const RecordingOptions& options) {
  ++g_parsed;
  auto whole = std::make_shared<Whole>();
  whole->rows = read_recording(path, options, whole->facts);
  return whole;
}

// All rows of a file, if it is kept.
std::shared_ptr<const Whole> whole_file(const std::string& path, const RecordingOptions& options,
                                        KeptRecordings* kept) {
  if (kept == nullptr) return nullptr;
  RecordingOptions all = options;
  all.first_row = 0;
  all.row_count = -1;
  return kept->find(path, all);
}

}  // namespace

KeptRecordings::KeptRecordings(long most_bytes) : state_(std::make_unique<State>()) {
  state_->bytes_left = most_bytes;
}

KeptRecordings::~KeptRecordings() = default;

std::shared_ptr<const Whole> KeptRecordings::find(const std::string& path,
                                                  const RecordingOptions& options) {
  std::promise<std::shared_ptr<const Whole>> promise;
  State::Kept result;
  {
    const std::lock_guard<std::mutex> lock(state_->mutex);
    const std::string key = key_of(path, options);
    const auto found = state_->recordings.find(key);
    if (found != state_->recordings.end()) {
      result = found->second;
    } else {
      const long bytes = text_bytes(path);
      if (bytes < 0 || bytes > state_->bytes_left) return nullptr;
      state_->bytes_left -= bytes;
      state_->recordings.emplace(key, promise.get_future().share());
    }
  }
  if (result.valid()) return result.get();
  try {
    std::shared_ptr<const Whole> recording = parsed(path, options);
    promise.set_value(recording);
    return recording;
  } catch (...) {
    promise.set_exception(std::current_exception());
    throw;
  }
}

OpenedRows open_rows(const std::string& path, const RecordingOptions& options,
                     KeptRecordings* kept) {
  const auto whole = whole_file(path, options, kept);
  if (whole != nullptr && options.first_row == 0 &&
      (options.row_count < 0 || options.row_count >= whole->rows.rows())) {
    auto at = std::make_shared<int>(0);
    return {[whole, at](int rows) {
              const int count = std::min(rows, whole->rows.rows() - *at);
              *at += count;
              return rows_of(whole->rows, *at - count, count);
            },
            [whole] { return whole->facts; }};
  }
  ++g_parsed;
  auto reader = std::make_shared<RecordingReader>(path, options);
  return {[reader](int rows) { return reader->next(rows); }, [reader] { return reader->facts(); }};
}

Recording read_rows(const std::string& path, const RecordingOptions& options,
                    KeptRecordings* kept) {
  const auto whole = whole_file(path, options, kept);
  const long rows = whole != nullptr ? whole->rows.rows() : 0;
  if (options.first_row >= rows || options.row_count == 0) return read_recording(path, options);
  const long behind = rows - options.first_row;
  const long count = options.row_count < 0 ? behind : std::min(options.row_count, behind);
  return rows_of(whole->rows, static_cast<int>(options.first_row), static_cast<int>(count));
}

long files_parsed() {
  return g_parsed.load();
}

}  // namespace veridyn
