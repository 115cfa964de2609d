#include "recordings/fields/import.hpp"

#include "recordings/arrays/array_recording.hpp"
#include "recordings/bags/bag_recording.hpp"

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

}  // namespace veridyn::recordings
