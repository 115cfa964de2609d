#include "recordings/fields/import.hpp"

#include <utility>

#include "recordings/arrays/array_recording.hpp"
#include "recordings/bags/bag_recording.hpp"
#include "recordings/csv/csv_table.hpp"

namespace veridyn::recordings {
namespace {

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

}  // namespace

Imported import_file(const OpenedFile& file, const RecordingOptions& options) {
  return assemble(read_raw(file, options), file.path, options.signals);
}

Imported import_table(CsvLines lines, const RecordingOptions& options) {
  const std::string path = lines.path();
  return assemble(read_csv_table(std::move(lines), options), path, options.signals);
}

}  // namespace veridyn::recordings
