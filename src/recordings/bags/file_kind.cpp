#include "recordings/bags/file_kind.hpp"

#include <filesystem>
#include <string_view>
#include <system_error>

#include "files/words.hpp"
#include "recordings/bags/bag_sink.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::recordings {
namespace {

using std::string_view_literals::operator""sv;

constexpr std::size_t kProbe = 640;  // bytes that identify the kind

struct Refused {
  std::string_view magic;
  const char* found;
  const char* expected;
};

// Known formats that are not supported, with advice for the user.
constexpr Refused kRefused[] = {
    {"PAR1"sv, "a Parquet file", "it saved as CSV or .npz"},
    {"ARROW1"sv, "an Arrow (Feather) file", "it saved as CSV or .npz"},
    {"\xD0\xCF\x11\xE0"sv, "an Excel workbook", "it saved as CSV"},
    {"\x1F\x8B"sv, "a gzip file", "it unpacked (gunzip)"},
    {"BZh"sv, "a bzip2 file", "it unpacked (bunzip2)"},
    {"\xFD" "7zXZ"sv, "an xz file", "it unpacked (unxz)"},
    {"\x93NUMPY"sv, "a single array of NumPy (.npy)",
     ".npz with t, q, dq and tau (numpy.savez)"},
    {"\x80\x02"sv, "a Python pickle", "CSV or .npz"},
    {"\x80\x03"sv, "a Python pickle", "CSV or .npz"},
    {"\x80\x04"sv, "a Python pickle", "CSV or .npz"},
    {"\x80\x05"sv, "a Python pickle", "CSV or .npz"},
    {"%PDF"sv, "a PDF", "a recording"},
    {"TDSm"sv, "a TDMS file of LabVIEW", "it saved as CSV"},
    {"MDF "sv, "an MDF measurement file", "it saved as CSV"},
    {"ULog"sv, "a ULog of PX4", "it saved as CSV (ulog2csv)"},
    {"\xFF\xFE"sv, "text in UTF-16", "UTF-8"},
    {"\xFE\xFF"sv, "text in UTF-16", "UTF-8"},
    {"<?xml"sv, "XML", "a table (CSV) or a bag"},
    {"header:"sv, "the text of rostopic echo", "its table: rostopic echo -p, or the bag"},
    {"header: \n"sv, "the text of rostopic echo", "its table: rostopic echo -p, or the bag"},
    {"---\nheader:"sv, "the text of ros2 topic echo", "its table: ros2 topic echo --csv, or the bag"},
    {"{"sv, "JSON", "a table (CSV) or MCAP"},
    {"[{"sv, "JSON", "a table (CSV) or MCAP"}};

// Identifies the kind by the first kProbe bytes.
FileKind kind_of(std::string_view probe, const std::string& path) {
  if (bags::is_bag(probe)) return FileKind::kBag;
  if (starts_with(probe, "PK\x03\x04")) return FileKind::kNpz;
  if (starts_with(probe, "MATLAB 5.0 MAT-file") || starts_with(probe, "MATLAB 7.3 MAT-file"))
    return FileKind::kMat;
  const std::string_view hdf5 = "\x89HDF\r\n\x1A\n";
  if (starts_with(probe, hdf5) || (probe.size() > 520 && probe.substr(512, 8) == hdf5))
    return FileKind::kHdf5;
  for (const Refused& refused : kRefused) {
    require(!starts_with(probe, refused.magic), path, ": found ", refused.found, ", expected ",
            refused.expected, ".");
  }
  return FileKind::kText;
}

}  // namespace

OpenedFile::OpenedFile(const std::string& file) : path(file) {
  std::error_code absent;
  if (std::filesystem::is_directory(path, absent)) {
    kind = FileKind::kBag;
    return;
  }
  bytes.emplace(path);
  while (bytes->unread().size() < kProbe && bytes->read_on()) {
  }
  kind = kind_of(bytes->unread(), path);
}

}  // namespace veridyn::recordings
