#include "recordings/same_recording.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <system_error>

namespace veridyn {
namespace {

constexpr std::size_t kSampled = 4096;  // number of hashes in a sample
constexpr long kRun = 4;                // rows per hash; coarse signals repeat single rows by chance

// FNV-1a over the values of the rows up to k, rounded to single precision, so that a file with seven digits has
// the same hashes.
std::uint64_t hash_of_rows(const Recording& rows, long k) {
  std::uint64_t hash = 14695981039346656037ULL;
  for (const RecordingSignal& signal : kRecordingSignals) {
    const MatrixXd& values = rows.*signal.values;
    for (Eigen::Index j = 0; j < values.cols(); ++j) {
      for (long i = k - kRun + 1; i <= k; ++i) {
        const auto value = static_cast<float>(values(i, j));
        std::uint32_t bits = 0;
        std::memcpy(&bits, &value, sizeof bits);
        hash = (hash ^ bits) * 1099511628211ULL;
        hash ^= hash >> 29;
      }
    }
  }
  return hash;
}

}  // namespace

void RowSample::add(const Recording& piece, long first, long last) {
  if (piece.rows() == 0) return;
  const long held = before_.rows();
  Recording rows = std::move(before_);
  append(rows, piece);
  for (long k = std::max({first + held + kRun - 1, held, kRun - 1}); k < std::min<long>(last + held, rows.rows()); ++k) {
    if (rows.q.row(k) == rows.q.row(k - 1)) continue;
    const std::uint64_t hash = hash_of_rows(rows, k);
    if (hash < largest_) hashes_.push_back(hash);
    if (hashes_.size() >= 2 * kSampled) keep_smallest();
  }
  const int kept = std::min(rows.rows(), static_cast<int>(kRun) - 1);
  before_ = rows_of(rows, rows.rows() - kept, kept);
}

void RowSample::keep_smallest() {
  std::sort(hashes_.begin(), hashes_.end());
  hashes_.erase(std::unique(hashes_.begin(), hashes_.end()), hashes_.end());
  if (hashes_.size() < kSampled) return;
  hashes_.resize(kSampled);
  largest_ = hashes_.back();
}

std::vector<std::uint64_t> RowSample::hashes() {
  keep_smallest();
  return hashes_;
}

double share_of_rows(const std::vector<std::uint64_t>& of, const std::vector<std::uint64_t>& in) {
  if (of.empty() || in.empty()) return 0.0;
  const auto whole_up_to = [](const std::vector<std::uint64_t>& sample) { return sample.size() < kSampled ? UINT64_MAX : sample.back(); };
  const auto end = std::upper_bound(of.begin(), of.end(), std::min(whole_up_to(of), whole_up_to(in)));
  std::vector<std::uint64_t> common;
  std::set_intersection(of.begin(), end, in.begin(), in.end(), std::back_inserter(common));
  return end == of.begin() ? 0.0 : static_cast<double>(common.size()) / static_cast<double>(end - of.begin());
}

bool same_recording(const std::string& a, const std::string& b) {
  namespace fs = std::filesystem;
  std::error_code error;
  if (a == b || fs::equivalent(a, b, error)) return true;
  if (!fs::is_regular_file(a, error) || !fs::is_regular_file(b, error)) return false;
  if (fs::file_size(a, error) != fs::file_size(b, error) || fs::file_size(a, error) == 0) return false;
  std::ifstream one(a, std::ios::binary);
  std::ifstream other(b, std::ios::binary);
  std::array<char, 1 << 16> a_bytes, b_bytes;
  while (one && other) {
    const auto a_count = one.read(a_bytes.data(), a_bytes.size()).gcount();
    if (other.read(b_bytes.data(), b_bytes.size()).gcount() != a_count) return false;
    if (!std::equal(a_bytes.begin(), a_bytes.begin() + a_count, b_bytes.begin())) return false;
  }
  return one.eof() && other.eof();
}

}  // namespace veridyn
