#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "veridyn/math/require.hpp"
#include "veridyn/math/types.hpp"

namespace veridyn {

/// Writes or reads fields in sequence, little-endian. A struct has one function exchange(bytes, object),
/// which lists its fields for both directions.
/// @throws InvalidInput  the bytes end too early.
class ByteExchange {
 public:
  /// Constructs a writer.
  ByteExchange() = default;
  /// Constructs a reader that begins at `at`. @param source  name of the bytes in messages.
  ByteExchange(std::string_view bytes, std::size_t at, std::string source)
      : reads_(true), given_(bytes), at_(at), source_(std::move(source)) {}

  template <typename... Fields>
  void operator()(Fields&... fields) {
    (field(fields), ...);
  }

  /// Exchanges a number of items of at least `bytes` each, which the remaining length bounds.
  std::size_t count(std::size_t items, std::size_t bytes) {
    std::uint64_t value = items;
    field(value);
    require(!reads_ || value <= (given_.size() - at_) / bytes, source_, ": found ", value, " entries at byte ", at_,
            ", expected no more than the rest of the file holds.");
    return static_cast<std::size_t>(value);
  }

  bool reads() const { return reads_; }
  bool at_end() const { return at_ == given_.size(); }
  const std::string& bytes() const { return written_; }

 private:
  void field(std::uint64_t& value) {
    if (reads_) {
      require(given_.size() - at_ >= sizeof value, source_, ": ends at byte ", given_.size(), ", expected more.");
      value = 0;
    }
    for (std::size_t k = 0; k < sizeof value; ++k) {
      if (reads_)
        value |= std::uint64_t{static_cast<unsigned char>(given_[at_++])} << (8 * k);
      else
        written_.push_back(static_cast<char>(value >> (8 * k) & 0xff));
    }
  }
  void field(long& value) { whole(value); }
  void field(int& value) { whole(value); }
  template <typename Whole>
  void whole(Whole& value) {
    auto bits = static_cast<std::uint64_t>(value);
    field(bits);
    value = static_cast<Whole>(bits);
  }
  void field(double& value) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, &value, sizeof bits);
    field(bits);
    std::memcpy(&value, &bits, sizeof bits);
  }
  void field(std::string& value) {
    const std::size_t size = count(value.size(), 1);
    if (!reads_) {
      written_ += value;
      return;
    }
    value = given_.substr(at_, size);
    at_ += size;
  }
  void field(VectorXd& value) {
    value.resize(static_cast<Eigen::Index>(count(static_cast<std::size_t>(value.size()), 8)));
    for (double& entry : value) field(entry);
  }
  template <typename T>
  void field(std::vector<T>& all) {
    all.resize(count(all.size(), 8));
    for (T& one : all) field(one);
  }
  template <typename T>
  void field(T& object) {
    exchange(*this, object);
  }

  bool reads_ = false;
  std::string written_;
  std::string_view given_;
  std::size_t at_ = 0;
  std::string source_;
};

/// An object as bytes.
template <typename T>
std::string bytes_of(const T& object) {
  ByteExchange out;
  out(const_cast<T&>(object));  // writing only reads the object
  return out.bytes();
}

}  // namespace veridyn
