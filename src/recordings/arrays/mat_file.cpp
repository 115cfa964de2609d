#include "recordings/arrays/array_recording.hpp"
#include "veridyn/math/require.hpp"

#ifdef VERIDYN_WITH_MATIO

#include <matio.h>

#include <memory>

namespace veridyn::recordings {
namespace {

constexpr int kDeepest = 4;  // largest depth of nested structs

template <typename T>
void read_numbers(const matvar_t& var, std::vector<double>* out) {
  const T* data = static_cast<const T*>(var.data);
  const std::size_t rows = var.dims[0];
  const std::size_t columns = var.dims[1];
  for (std::size_t r = 0; r < rows; ++r) {  // MATLAB stores columns contiguously
    for (std::size_t c = 0; c < columns; ++c)
      (*out)[r * columns + c] = static_cast<double>(data[c * rows + r]);
  }
}

// Copies the numbers of a real matrix row by row; false for another type.
bool numbers_of(const matvar_t& var, std::vector<double>* out) {
  switch (var.data_type) {
    case MAT_T_DOUBLE:
      return read_numbers<double>(var, out), true;
    case MAT_T_SINGLE:
      return read_numbers<float>(var, out), true;
    case MAT_T_INT8:
      return read_numbers<signed char>(var, out), true;
    case MAT_T_UINT8:
      return read_numbers<unsigned char>(var, out), true;
    case MAT_T_INT16:
      return read_numbers<short>(var, out), true;
    case MAT_T_UINT16:
      return read_numbers<unsigned short>(var, out), true;
    case MAT_T_INT32:
      return read_numbers<int>(var, out), true;
    case MAT_T_UINT32:
      return read_numbers<unsigned>(var, out), true;
    case MAT_T_INT64:
      return read_numbers<long long>(var, out), true;
    case MAT_T_UINT64:
      return read_numbers<unsigned long long>(var, out), true;
    default:
      return false;
  }
}

void read_variable(matvar_t& var, const std::string& name, int depth, ArraySet* set) {
  if (var.rank != 2 || var.data == nullptr || var.isComplex != 0 || depth > kDeepest) return;
  const std::size_t count = var.dims[0] * var.dims[1];
  if (var.class_type == MAT_C_STRUCT && count == 1) {
    char* const* fields = Mat_VarGetStructFieldnames(&var);
    const unsigned field_count = Mat_VarGetNumberOfFields(&var);
    for (unsigned k = 0; k < field_count; ++k) {
      matvar_t* inner = Mat_VarGetStructFieldByIndex(&var, k, 0);
      if (inner != nullptr) read_variable(*inner, name + "/" + fields[k], depth + 1, set);
    }
  } else if (var.class_type == MAT_C_CELL && (name == "joints" || name == "joint_names")) {
    for (std::size_t k = 0; k < count; ++k) {
      const matvar_t* cell = static_cast<matvar_t* const*>(var.data)[k];
      if (cell == nullptr || cell->class_type != MAT_C_CHAR || cell->data == nullptr) return;
      const bool wide = cell->data_size == 2;
      std::string text;
      for (std::size_t c = 0; c < cell->nbytes / (wide ? 2 : 1); ++c)
        text += static_cast<const char*>(cell->data)[wide ? 2 * c : c];
      set->joint_names.push_back(text);
    }
  } else if (count > 0) {
    NamedArray array;
    array.name = name;
    array.rows = var.dims[0];
    array.columns = var.dims[1];
    array.values.resize(count);
    if (static_cast<std::size_t>(var.data_size) * count <= var.nbytes && numbers_of(var, &array.values))
      set->arrays.push_back(std::move(array));
  }
}

}  // namespace

ArraySet read_mat(const std::string& path) {
  count_opened_file();
  const std::unique_ptr<mat_t, int (*)(mat_t*)> file(Mat_Open(path.c_str(), MAT_ACC_RDONLY),
                                                     Mat_Close);
  require(file != nullptr, path, ": cannot be opened as a MAT-file of MATLAB, expected an intact one.");
  ArraySet set;
  while (true) {
    const std::unique_ptr<matvar_t, void (*)(matvar_t*)> var(Mat_VarReadNext(file.get()),
                                                             Mat_VarFree);
    if (var == nullptr) break;
    if (var->name != nullptr) read_variable(*var, var->name, 0, &set);
  }
  return set;
}

}  // namespace veridyn::recordings

#else

namespace veridyn::recordings {

ArraySet read_mat(const std::string& path) {
  throw InvalidInput(path + ": found a MAT-file of MATLAB, but this build has no matio (libmatio-dev, "
                            "then build again); expected CSV or .npz.");
}

}  // namespace veridyn::recordings

#endif
