#include "recordings/rows_on_disk.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <utility>

#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

// Calls visit(data) for the time and for every column of every signal, in a fixed order, until it
// returns false.
template <typename Rows, typename Visit>
bool for_columns(Rows& rows, const Visit& visit) {
  if (!visit(rows.time.data())) return false;
  for (const RecordingSignal& signal : kRecordingSignals) {
    auto& values = rows.*signal.values;
    for (Eigen::Index j = 0; j < values.cols(); ++j)
      if (!visit(values.col(j).data())) return false;
  }
  return true;
}

// Reads or writes all bytes at an offset of the file with pread or pwrite.
template <typename Call, typename Bytes>
bool whole(const Call& call, int file, Bytes* bytes, long count, long offset) {
  while (count > 0) {
    const ssize_t done = call(file, bytes, static_cast<size_t>(count), offset);
    if (done <= 0) return false;
    bytes += done;
    count -= done;
    offset += done;
  }
  return true;
}

constexpr long kDouble = sizeof(double);

}  // namespace

long RowsOnDisk::Stored::rows() const {
  long sum = 0;
  for (const Piece& piece : pieces) sum += piece.rows;
  return sum;
}

RowsOnDisk::~RowsOnDisk() {
  if (file_ >= 0) ::close(file_);
}

// Opens a file in a folder that is usually on a disk, whereas /tmp may be in memory.
bool RowsOnDisk::open() {
  if (tried_) return file_ >= 0;
  tried_ = true;
  const char* const chosen = std::getenv("TMPDIR");
  std::string path = chosen != nullptr && *chosen != '\0' ? chosen : "/var/tmp";
  std::error_code error;
  const auto space = std::filesystem::space(path, error);
  if (error) return false;
  most_ = std::min(kMostBytes, static_cast<long>(kMostOfFreeSpace * static_cast<double>(space.available))) / kDouble;
  path += "/veridyn-XXXXXX";  // mkostemp replaces the six letters
  file_ = ::mkostemp(path.data(), O_CLOEXEC);
  if (file_ >= 0) ::unlink(path.c_str());
  return file_ >= 0;
}

std::shared_ptr<const RowsOnDisk::Stored> RowsOnDisk::find(const std::string& key) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto found = all_.find(key);
  return found != all_.end() ? found->second : nullptr;
}

bool RowsOnDisk::append(const Recording& piece, Stored& to) {
  long columns = 1;
  for (const RecordingSignal& signal : kRecordingSignals) columns += (piece.*signal.values).cols();
  const long rows = piece.rows();
  long offset = 0;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!open() || used_ + columns * rows > most_) return false;
    offset = used_;
    used_ += columns * rows;
  }
  if (to.pieces.empty()) to.without_rows = veridyn::rows_of(piece, 0, 0);
  to.pieces.push_back({offset, piece.rows()});
  return for_columns(piece, [&](const double* column) {
    const bool done = whole(::pwrite, file_, reinterpret_cast<const char*>(column), rows * kDouble, offset * kDouble);
    offset += rows;
    return done;
  });
}

void RowsOnDisk::finish(const std::string& key, Stored stored) {
  const std::lock_guard<std::mutex> lock(mutex_);
  all_.emplace(key, std::make_shared<const Stored>(std::move(stored)));
}

std::function<Recording(int)> RowsOnDisk::rows_of(std::shared_ptr<const Stored> stored) const {
  size_t piece = 0;
  int row = 0;  // next row of that piece
  return [this, stored = std::move(stored), piece, row](int rows) mutable {
    int count = 0;
    int first = row;
    for (size_t p = piece; p < stored->pieces.size() && count < rows; ++p, first = 0)
      count += std::min(rows - count, stored->pieces[p].rows - first);
    Recording out = stored->without_rows;
    out.time.resize(count);
    for (const RecordingSignal& signal : kRecordingSignals) {
      MatrixXd& values = out.*signal.values;
      if (values.cols() > 0) values.resize(count, values.cols());
    }
    for (int at = 0; at < count;) {
      const Stored::Piece& from = stored->pieces[piece];
      const int part = std::min(count - at, from.rows - row);
      long offset = from.offset + row;
      const bool done = for_columns(out, [&](double* column) {
        const long column_offset = offset;
        offset += from.rows;
        return whole(::pread, file_, reinterpret_cast<char*>(column + at), part * kDouble, column_offset * kDouble);
      });
      require(done, out.source, ": its rows cannot be read back from the temporary file.");
      at += part;
      row += part;
      if (row == from.rows) {
        ++piece;
        row = 0;
      }
    }
    return out;
  };
}

}  // namespace veridyn
