#include "recordings/fields/import.hpp"

#include <sys/stat.h>

#include <list>
#include <mutex>

#include "recordings/arrays/array_recording.hpp"
#include "recordings/bags/bag_recording.hpp"
#include "recordings/csv/csv_table.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/math/text_stream.hpp"

namespace veridyn::recordings {
namespace {

constexpr std::size_t kKept = 8;                    // recordings kept for further passes
constexpr std::size_t kKeptNumbers = std::size_t{64} << 20;

// Text of everything that determines the result.
std::string key_of(const std::string& path, const RecordingOptions& options) {
  TextStream key;
  struct stat about {};
  ::stat(path.c_str(), &about);
  key << path << '\n' << about.st_size << ' ' << about.st_mtim.tv_sec << ' ' << about.st_mtim.tv_nsec
      << ' ' << about.st_ino << ' ' << options.rate << '\n';
  for (const std::string& column : options.columns) key << column << ' ';
  for (const std::string& topic : options.signals.topics) key << topic << '\n';
  for (const auto& [name, source] : options.signals.map) key << name << '=' << source << '\n';
  for (const auto& [name, unit] : options.signals.units) key << name << '~' << unit << '\n';
  for (const WantedJoint& joint : options.signals.joints) key << joint.name << ' ' << joint.prismatic << ' ' << joint.lower << ' ' << joint.upper << ' ' << joint.effort << '\n';
  for (const HeldJoint& h : options.signals.held) key << "held " << h.number << '\n';
  return key.str();
}

std::size_t numbers_in(const Recording& r) {
  std::size_t count = 0;
  for (const RecordingSignal& signal : kRecordingSignals)
    count += static_cast<std::size_t>((r.*signal.values).size());
  return count;
}

// The most recent recordings, because an identification reads each several times.
class Kept {
 public:
  std::shared_ptr<const Imported> find(const std::string& key) {
    const std::lock_guard<std::mutex> lock(mutex_);
    for (auto at = entries_.begin(); at != entries_.end(); ++at) {
      if (at->key != key) continue;
      entries_.splice(entries_.begin(), entries_, at);
      return at->recording;
    }
    return nullptr;
  }

  void keep(const std::string& key, std::shared_ptr<const Imported> recording) {
    const std::lock_guard<std::mutex> lock(mutex_);
    entries_.push_front({key, std::move(recording)});
    std::size_t numbers = 0;
    std::size_t count = 0;
    for (auto at = entries_.begin(); at != entries_.end();) {
      numbers += numbers_in(at->recording->recording);
      const bool drop = ++count > kKept || numbers > kKeptNumbers;
      at = drop ? entries_.erase(at) : std::next(at);
    }
  }

 private:
  struct Entry {
    std::string key;
    std::shared_ptr<const Imported> recording;
  };
  std::mutex mutex_;
  std::list<Entry> entries_;
};

Kept& kept() {
  static Kept recordings;
  return recordings;
}

RawRecording read_raw(const OpenedFile& file, const RecordingOptions& options) {
  switch (file.kind) {
    case FileKind::kNpz:
      return raw_from_arrays(read_npz(*file.bytes), file.path, "NumPy .npz", options);
    case FileKind::kMat:
      return raw_from_arrays(read_mat(file.path), file.path, "MATLAB MAT-file", options);
    case FileKind::kHdf5:
      return raw_from_arrays(read_hdf5(file.path), file.path, "HDF5", options);
    case FileKind::kBag:
    case FileKind::kText:
      break;
  }
  return bags::read_bag_recording(file, options.signals);
}

template <typename Read>
std::shared_ptr<const Imported> read_and_keep(const std::string& path,
                                              const RecordingOptions& options, Read read) {
  const std::string key = key_of(path, options);  // computed before the file is read
  auto imported = std::make_shared<const Imported>(assemble(read(), path, options.signals));
  kept().keep(key, imported);
  return imported;
}

}  // namespace

std::shared_ptr<const Imported> import_file(const OpenedFile& file,
                                            const RecordingOptions& options) {
  return read_and_keep(file.path, options, [&] { return read_raw(file, options); });
}

std::shared_ptr<const Imported> import_table(CsvLines lines, const RecordingOptions& options) {
  const std::string path = lines.path();
  return read_and_keep(path, options, [&] { return read_csv_table(std::move(lines), options); });
}

std::shared_ptr<const Imported> imported_before(const std::string& path,
                                                const RecordingOptions& options) {
  return kept().find(key_of(path, options));
}

}  // namespace veridyn::recordings
