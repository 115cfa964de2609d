#include <algorithm>
#include <cmath>

#include "recordings/csv/csv_table.hpp"
#include "recordings/import.hpp"
#include "recordings/csv/row_source.hpp"
#include "recordings/signals/units.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/recordings/recording.hpp"

namespace veridyn {
namespace {

// Rows of a recording in memory.
class ImportedRows : public recordings::RowSource {
 public:
  ImportedRows(std::shared_ptr<const recordings::Imported> imported, const RecordingOptions& options)
      : imported_(std::move(imported)) {
    const long rows = imported_->recording.rows();
    at_ = std::min(options.first_row, rows);
    end_ = options.row_count < 0 ? rows : std::min(rows, at_ + options.row_count);
  }

  Recording next(int rows) override {
    const auto count = static_cast<int>(std::min<long>(rows, end_ - at_));
    at_ += count;
    return rows_of(imported_->recording, static_cast<int>(at_) - count, count);
  }

  int joints() const override { return imported_->recording.joints(); }
  RecordingFacts facts() const override { return imported_->facts; }

 private:
  std::shared_ptr<const recordings::Imported> imported_;
  long at_ = 0;
  long end_ = 0;
};

std::unique_ptr<recordings::RowSource> rows_in(const std::string& path,
                                               const RecordingOptions& options) {
  std::shared_ptr<const recordings::Imported> whole = recordings::imported_before(path, options);
  if (whole == nullptr) {
    recordings::OpenedFile file(path);
    if (file.kind == recordings::FileKind::kText) {
      CsvLines lines(std::move(*file.bytes));
      if (!recordings::is_csv_table(lines, options))
        return recordings::csv_rows(std::move(lines), options);
      whole = recordings::import_table(std::move(lines), options);
    } else {
      whole = recordings::import_file(file, options);
    }
  }
  return std::make_unique<ImportedRows>(std::move(whole), options);
}

}  // namespace

RecordingReader::RecordingReader(const std::string& path, const RecordingOptions& options) {
  require(options.first_row >= 0, "--rows: found first row ", options.first_row,
          ", expected 0 or more.");
  require(std::isfinite(options.rate) && options.rate >= 0.0, "--rate: found ", options.rate,
          ", expected a rate in Hz.");
  recordings::require_known_units(options.signals);
  source_ = rows_in(path, options);
  recordings::require_joints_of(options.signals, source_->joints(), path);
}

RecordingReader::~RecordingReader() = default;
RecordingReader::RecordingReader(RecordingReader&&) noexcept = default;
RecordingReader& RecordingReader::operator=(RecordingReader&&) noexcept = default;

Recording RecordingReader::next(int rows) {
  return source_->next(rows);
}

int RecordingReader::joints() const {
  return source_->joints();
}

RecordingFacts RecordingReader::facts() const {
  return source_->facts();
}

}  // namespace veridyn
