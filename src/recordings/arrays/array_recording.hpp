#pragma once

#include <string>
#include <vector>

#include "recordings/files/byte_stream.hpp"
#include "recordings/signals/raw_recording.hpp"
#include "veridyn/recordings/recording.hpp"

namespace veridyn::recordings {

/// A named array of numbers, row by row. The name may begin with groups: `log/q`.
struct NamedArray {
  std::string name;
  std::size_t rows = 0;
  std::size_t columns = 1;
  std::vector<double> values;
};

/// Contents of an array file.
struct ArraySet {
  std::vector<NamedArray> arrays;
  std::vector<std::string> joint_names;  ///< names from a text array `joints` or `joint_names`
};

/// Assembles a recording from arrays named like the columns of a table (t, q, dq, tau, ...). Rows are
/// samples, or columns if their number is that of the times. Without a time, options.rate is used.
/// @throws InvalidInput  there is neither a time nor a rate.
RawRecording raw_from_arrays(ArraySet set, const std::string& path, const std::string& format,
                             const RecordingOptions& options);

/// Reads NumPy's .npz, stored or deflated. @throws InvalidInput  damaged, or of other types.
ArraySet read_npz(const ByteStream& opened);
/// Reads MATLAB's .mat, version 4 to 7.3. @throws InvalidInput  damaged, or built without matio.
ArraySet read_mat(const std::string& path);
/// Reads HDF5. @throws InvalidInput  damaged, or built without HDF5.
ArraySet read_hdf5(const std::string& path);

}  // namespace veridyn::recordings
