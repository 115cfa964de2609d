#include <algorithm>
#include <filesystem>
#include <cmath>
#include <memory>
#include <utility>

#include "recordings/csv/csv_table.hpp"
#include "recordings/fields/import.hpp"
#include "recordings/fields/joined_files.hpp"
#include "recordings/csv/row_source.hpp"
#include "recordings/mending/mended_rows.hpp"
#include "recordings/signals/units.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/recordings/recording.hpp"

namespace veridyn {
namespace {

// Rows of a recording in memory.
class ImportedRows : public recordings::RowSource {
 public:
  ImportedRows(recordings::Imported imported, const RecordingOptions& options) : imported_(std::move(imported)) {
    const long rows = imported_.recording.rows();
    at_ = std::min(options.first_row, rows);
    end_ = std::min<long>(rows, at_ + options.row_count.value_or(rows));
  }

  Recording next(int rows) override {
    const auto count = static_cast<int>(std::min<long>(rows, end_ - at_));
    at_ += count;
    return rows_of(imported_.recording, static_cast<int>(at_) - count, count);
  }

  int joints() const override { return imported_.recording.joints(); }
  RecordingFacts facts() const override { return imported_.facts; }

 private:
  recordings::Imported imported_;
  long at_ = 0;
  long end_ = 0;
};

// Removes joints that the arm holds still.
class WithoutHeldJoints : public recordings::RowSource {
 public:
  WithoutHeldJoints(std::unique_ptr<recordings::RowSource> whole, const SignalChoice& choice)
      : whole_(std::move(whole)), held_(choice.held), range_(held_.size()) {
    for (int j = 0; j < whole_->joints(); ++j) {
      const auto is = [j](const HeldJoint& h) { return h.number == j + 1; };
      if (std::none_of(held_.begin(), held_.end(), is)) kept_.push_back(j);
    }
  }

  Recording next(int rows) override {
    Recording out = whole_->next(rows);
    for (size_t k = 0; k < held_.size(); ++k) {
      for (const double q : out.q.col(held_[k].number - 1)) {
        if (std::isnan(q)) continue;
        range_[k].first = std::min(range_[k].first, q - held_[k].position);
        range_[k].second = std::max(range_[k].second, q - held_[k].position);
      }
    }
    for (const RecordingSignal& signal : kRecordingSignals) {
      MatrixXd& values = out.*signal.values;
      if (values.cols() > 0) values = MatrixXd(values(Eigen::all, kept_));
    }
    return out;
  }

  int joints() const override { return static_cast<int>(kept_.size()); }

  RecordingFacts facts() const override {
    RecordingFacts out = whole_->facts();
    const std::vector<std::string> all = std::exchange(out.joints, {});
    for (const int j : kept_) out.joints.push_back(all[j]);
    for (size_t k = 0; k < held_.size(); ++k) {
      const auto [low, high] = range_[k];
      if (std::max(-low, high) <= kHeldStill) continue;
      out.remarks.push_back(text(held_[k].joint.name, " is held at ", held_[k].position, " and was ",
                                 held_[k].position + low, " to ", held_[k].position + high,
                                 " there: what follows leaves its motion out."));
    }
    return out;
  }

 private:
  static constexpr double kHeldStill = 0.01;  // [rad] or [m] largest distance of a held joint from its declared position

  std::unique_ptr<recordings::RowSource> whole_;
  std::vector<HeldJoint> held_;
  std::vector<std::pair<double, double>> range_;  // range of each held joint around its declared position
  std::vector<int> kept_;
};

std::unique_ptr<recordings::RowSource> open_row_source(const std::string& path,
                                               const RecordingOptions& options) {
  const std::vector<std::string> files = recordings::files_joined_by(path);
  if (!files.empty())
    return std::make_unique<ImportedRows>(recordings::import_joined(path, files, options), options);
  recordings::OpenedFile file(path);
  if (file.kind != recordings::FileKind::kText)
    return std::make_unique<ImportedRows>(recordings::import_file(file, options), options);
  CsvLines lines(std::move(*file.bytes));
  std::optional<recordings::CsvHeader> header = recordings::table_header(lines, options);
  if (!header) return recordings::csv_rows(std::move(lines), options);
  recordings::RawRecording table = recordings::read_csv_table(std::move(lines), std::move(*header), options);
  return std::make_unique<ImportedRows>(recordings::assemble(std::move(table), path, options.signals), options);
}

// True for a source that can be opened only once: a pipe, a socket, a terminal.
bool is_read_once(const std::string& path) {
  std::error_code ignored;
  const std::filesystem::file_type type = std::filesystem::status(path, ignored).type();
  return type == std::filesystem::file_type::fifo || type == std::filesystem::file_type::socket ||
         type == std::filesystem::file_type::character;
}

// Rows of an arm with held joints, which may be recorded or not. This is found by opening the file twice, so
// that a pipe is assumed to contain no held joint.
std::unique_ptr<recordings::RowSource> rows_of_arm(const std::string& path, const RecordingOptions& options) {
  const SignalChoice& choice = options.signals;
  if (choice.held.empty() || is_read_once(path)) return open_row_source(path, options);
  RecordingOptions all = options;
  for (const HeldJoint& h : choice.held)
    all.signals.joints.insert(all.signals.joints.begin() + h.number - 1, h.joint);
  try {
    std::unique_ptr<recordings::RowSource> whole = open_row_source(path, all);
    if (whole->joints() == static_cast<int>(all.signals.joints.size()))
      return std::make_unique<WithoutHeldJoints>(std::move(whole), choice);
  } catch (const InvalidInput&) {
    // Held joints have no column in the result.
  }
  return open_row_source(path, options);
}

}  // namespace

RecordingReader::RecordingReader(const std::string& path, const RecordingOptions& options) {
  require(options.first_row >= 0, "--rows: found first row ", options.first_row,
          ", expected 0 or more.");
  require(std::isfinite(options.rate) && options.rate >= 0.0, "--rate: found ", options.rate,
          ", expected a rate in Hz.");
  recordings::require_known_units(options.signals);
  source_ = recordings::mended(rows_of_arm(path, options), options.signals);
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
