#include "recordings/arrays/array_recording.hpp"
#include "veridyn/math/require.hpp"

#ifdef VERIDYN_WITH_HDF5

#include <hdf5.h>

namespace veridyn::recordings {
namespace {

constexpr hsize_t kLargest = hsize_t{1} << 29;  // largest number of values in one array

#if H5_VERSION_GE(1, 12, 0)
using ObjectInfo = H5O_info2_t;
#else
using ObjectInfo = H5O_info_t;
#endif

void read_texts(hid_t data, hid_t type, hsize_t count, ArraySet* set) {
  if (count > 1000) return;
  if (H5Tis_variable_str(type) > 0) {
    std::vector<char*> texts(count, nullptr);
    const hid_t memory = H5Tcopy(H5T_C_S1);
    H5Tset_size(memory, H5T_VARIABLE);
    H5Tset_cset(memory, H5Tget_cset(type));
    if (H5Dread(data, memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, texts.data()) >= 0) {
      for (const char* text : texts) set->joint_names.emplace_back(text == nullptr ? "" : text);
      const hid_t space = H5Dget_space(data);
      H5Dvlen_reclaim(memory, space, H5P_DEFAULT, texts.data());
      H5Sclose(space);
    }
    H5Tclose(memory);
    return;
  }
  const std::size_t width = H5Tget_size(type);
  if (width == 0 || width > 1000) return;
  std::string bytes(width * count, '\0');
  if (H5Dread(data, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes.data()) < 0) return;
  for (hsize_t k = 0; k < count; ++k)
    set->joint_names.emplace_back(std::string(bytes.data() + k * width, width).c_str());
}

void read_dataset(hid_t data, const std::string& name, ArraySet* set) {
  const hid_t space = H5Dget_space(data);
  const hid_t type = H5Dget_type(data);
  hsize_t dims[2] = {1, 1};
  const int rank = H5Sget_simple_extent_ndims(space);
  if (rank == 1 || rank == 2) H5Sget_simple_extent_dims(space, dims, nullptr);
  H5Sclose(space);
  const H5T_class_t kind = H5Tget_class(type);
  const bool numbers = kind == H5T_FLOAT || kind == H5T_INTEGER;
  const std::string last = name.substr(name.rfind('/') + 1);
  if (kind == H5T_STRING && rank == 1 && (last == "joints" || last == "joint_names")) {
    read_texts(data, type, dims[0], set);
  } else if (numbers && (rank == 1 || rank == 2) && dims[0] > 0 && dims[1] > 0 &&
             dims[0] <= kLargest / dims[1]) {
    NamedArray array;
    array.name = name;
    array.rows = dims[0];
    array.columns = dims[1];
    array.values.resize(array.rows * array.columns);
    if (H5Dread(data, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, array.values.data()) >= 0)
      set->arrays.push_back(std::move(array));
  }
  H5Tclose(type);
}

herr_t read_visited_object(hid_t file, const char* name, const ObjectInfo* info, void* set) {
  if (info->type != H5O_TYPE_DATASET) return 0;
  const hid_t data = H5Dopen2(file, name, H5P_DEFAULT);
  if (data < 0) return 0;
  read_dataset(data, name, static_cast<ArraySet*>(set));
  H5Dclose(data);
  return 0;
}

}  // namespace

ArraySet read_hdf5(const std::string& path) {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // suppresses the messages of the library itself
  count_opened_file();
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  require(file >= 0, path, ": cannot be opened as HDF5, expected an intact file.");
  ArraySet set;
#if H5_VERSION_GE(1, 12, 0)
  H5Ovisit3(file, H5_INDEX_NAME, H5_ITER_NATIVE, read_visited_object, &set, H5O_INFO_BASIC);
#else
  H5Ovisit2(file, H5_INDEX_NAME, H5_ITER_NATIVE, read_visited_object, &set, H5O_INFO_BASIC);
#endif
  H5Fclose(file);
  return set;
}

}  // namespace veridyn::recordings

#else

namespace veridyn::recordings {

ArraySet read_hdf5(const std::string& path) {
  throw InvalidInput(path + ": found HDF5, but this build has no HDF5 (libhdf5-dev, then build "
                            "again); expected CSV or .npz.");
}

}  // namespace veridyn::recordings

#endif
