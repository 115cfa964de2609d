#include "recordings/kept_recordings.hpp"

#include "recordings/rows_on_disk.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <exception>
#include <filesystem>
#include <future>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <system_error>
#include <utility>

namespace veridyn {

namespace internal {

// Values that are computed once for each key, by the first caller, as long as there is memory for them.
template <typename Key, typename Made>
class MadeOnce {
 public:
  explicit MadeOnce(long most_bytes) : bytes_left_(most_bytes) {}

  // @param bytes  memory that the value needs; negative: it cannot be kept.
  template <typename Bytes, typename Make>
  std::shared_ptr<const Made> find(const Key& key, const Bytes& bytes, const Make& make) {
    std::promise<std::shared_ptr<const Made>> promise;
    std::shared_future<std::shared_ptr<const Made>> there;
    long wanted = 0;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      const auto found = all_.find(key);
      if (found != all_.end()) {
        there = found->second;
      } else {
        wanted = bytes();
        if (wanted < 0 || wanted > bytes_left_) return nullptr;
        bytes_left_ -= wanted;
        all_.emplace(key, promise.get_future().share());
      }
    }
    if (there.valid()) return there.get();
    try {
      std::shared_ptr<const Made> made = make();
      promise.set_value(made);
      return made;
    } catch (...) {
      promise.set_exception(std::current_exception());
      const std::lock_guard<std::mutex> lock(mutex_);
      all_.erase(key);
      bytes_left_ += wanted;
      throw;
    }
  }

  // The value if it has been computed already, else null.
  std::shared_ptr<const Made> find_made(const Key& key) {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto found = all_.find(key);
    const bool ready = found != all_.end() && found->second.wait_for(std::chrono::seconds(0)) ==
                                                  std::future_status::ready;
    return ready ? found->second.get() : nullptr;
  }

 private:
  std::mutex mutex_;
  long bytes_left_;
  std::map<Key, std::shared_future<std::shared_ptr<const Made>>> all_;
};

}  // namespace internal

struct KeptRecordings::State {
  explicit State(long most_bytes)
      : recordings(most_bytes), prepared(most_bytes), qualities(most_bytes) {}
  internal::MadeOnce<std::string, Whole> recordings;  // recordings by path and reading options
  internal::MadeOnce<PreparationKey, PreparedRecording> prepared;
  internal::MadeOnce<std::string, RecordingQuality> qualities;
  RowsOnDisk on_disk;
};

namespace {

std::atomic<long> g_parsed{0};

std::string key_of(const std::string& path, const RecordingOptions& options) {
  std::string out = path + "\n" + std::to_string(options.rate);
  out += " " + std::to_string(options.first_row) + " " + std::to_string(options.row_count.value_or(-1));
  for (const std::string& column : options.columns) out += "\n" + column;
  const SignalChoice& signals = options.signals;
  for (const std::string& topic : signals.topics) out += "\ntopic " + topic;
  for (const auto& [name, source] : signals.map) out += "\nmap " + name + "=" + source;
  for (const auto& [name, unit] : signals.units) out += "\nunit " + name + "=" + unit;
  for (const WantedJoint& joint : signals.joints)
    out += "\njoint " + joint.name + (joint.prismatic ? " slides" : "") + " " + std::to_string(joint.lower) + " " + std::to_string(joint.upper) + " " + std::to_string(joint.effort);
  if (signals.as_recorded) out += "\nas recorded";
  for (const HeldJoint& h : signals.held) out += "\nheld " + std::to_string(h.number);
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

// All rows of a file, if they are in memory.
std::shared_ptr<const Whole> whole_file(const std::string& path, const RecordingOptions& options,
                                        KeptRecordings* kept) {
  if (kept == nullptr) return nullptr;
  RecordingOptions all = options;
  all.first_row = 0;
  all.row_count.reset();
  return kept->find(path, all);
}

}  // namespace

KeptRecordings::KeptRecordings(long most_bytes) : state_(std::make_unique<State>(most_bytes)) {}

KeptRecordings::~KeptRecordings() = default;

std::shared_ptr<const Whole> KeptRecordings::find(const std::string& path,
                                                  const RecordingOptions& options) {
  return state_->recordings.find(
      key_of(path, options), [&] { return text_bytes(path); }, [&] { return parsed(path, options); });
}

RecordingQuality KeptRecordings::quality(const std::string& path, const RecordingOptions& options,
                                         const std::function<RecordingQuality()>& judge) {
  const auto kept = state_->qualities.find(
      key_of(path, options), [] { return long{sizeof(RecordingQuality)}; },
      [&] { return std::make_shared<const RecordingQuality>(judge()); });
  return kept ? *kept : judge();
}

std::shared_ptr<const RecordingQuality> KeptRecordings::known_quality(
    const std::string& path, const RecordingOptions& options) {
  return state_->qualities.find_made(key_of(path, options));
}

std::shared_ptr<const PreparedRecording> KeptRecordings::prepared(
    const PreparationKey& key, long bytes, const std::function<PreparedRecording()>& make) {
  return state_->prepared.find(
      key, [&] { return bytes; },
      [&] { return std::make_shared<const PreparedRecording>(make()); });
}

PreparationKey preparation_key(const Model& arm, const std::string& recording,
                               const PreprocessingOptions& o) {
  std::vector<double> numbers = {o.cutoff, o.signal_cutoff_ratio, o.rate, o.drop_start, o.drop_end};
  for (const Coordinate& c : arm.coordinates()) {
    const RecordedChannel& shown = c.recorded;
    numbers.insert(numbers.end(), {shown.position_offset, shown.torque_gain, shown.torque_delay, c.drive_gain});
    for (const auto& [from, share] : shown.torque_crosstalk) numbers.insert(numbers.end(), {1.0 * from.value, share});
    numbers.push_back(-1.0);  // separates the numbers of two joints
  }
  std::vector<int> choices;
  for (const JointIndex joint : o.derive_velocity_of) choices.push_back(joint.value);
  std::sort(choices.begin(), choices.end());
  choices.insert(choices.end(), {o.order, static_cast<int>(o.filtering), static_cast<int>(o.velocity),
                                 static_cast<int>(o.stale_rows)});
  RecordingOptions reading = recording_options_for(arm, o);
  reading.first_row = o.first_row;
  reading.row_count = o.row_count;
  return {key_of(recording, reading), std::move(numbers), std::move(choices)};
}

// A pass over the text, which stores the rows for later passes if it reaches the end.
OpenedRows KeptRecordings::stored_rows(const std::string& path, const RecordingOptions& options) {
  RecordingOptions all = options;
  all.row_count.reset();
  RowsOnDisk& disk = state_->on_disk;
  std::string key = key_of(path, all);
  if (const auto stored = disk.find(key)) {
    const bool whole = !options.row_count || *options.row_count >= stored->rows();
    if (whole) return {disk.rows_of(stored), [stored] { return stored->facts; }};
  }
  ++g_parsed;
  struct Pass {
    RecordingReader reader;
    RowsOnDisk::Stored stored = {};
    bool storing = true;
  };
  auto pass = std::make_shared<Pass>(Pass{RecordingReader(path, options)});
  const long most = options.row_count.value_or(std::numeric_limits<long>::max());
  return {[pass, most, &disk, key = std::move(key)](int rows) {
            Recording piece = pass->reader.next(rows);
            if (piece.rows() > 0) pass->storing = pass->storing && disk.append(piece, pass->stored);
            const bool ended = piece.rows() < rows;
            if (ended && pass->storing && !pass->stored.pieces.empty() && pass->stored.rows() < most) {
              pass->stored.facts = pass->reader.facts();
              disk.finish(key, std::move(pass->stored));
            }
            pass->storing = pass->storing && !ended;
            return piece;
          },
          [pass] { return pass->reader.facts(); }};
}

OpenedRows open_rows(const std::string& path, const RecordingOptions& options,
                     KeptRecordings* kept) {
  const auto whole = whole_file(path, options, kept);
  if (whole != nullptr && options.first_row == 0 &&
      (!options.row_count || *options.row_count >= whole->rows.rows())) {
    auto at = std::make_shared<int>(0);
    return {[whole, at](int rows) {
              const int count = std::min(rows, whole->rows.rows() - *at);
              *at += count;
              return rows_of(whole->rows, *at - count, count);
            },
            [whole] { return whole->facts; }};
  }
  if (kept != nullptr && options.first_row == 0) return kept->stored_rows(path, options);
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
  const long count = std::min(options.row_count.value_or(behind), behind);
  return rows_of(whole->rows, static_cast<int>(options.first_row), static_cast<int>(count));
}

long files_parsed() {
  return g_parsed.load();
}

}  // namespace veridyn
