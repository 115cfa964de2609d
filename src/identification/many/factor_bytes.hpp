#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "veridyn/math/require.hpp"
#include "veridyn/math/types.hpp"

namespace veridyn {

/// Writes values one after the other, little-endian. A call with fields of any kind writes them in order, as a ByteReader
/// reads them; a struct has a function exchange(bytes, object) that lists its fields once for both.
class ByteWriter {
 public:
  template <typename... Fields>
  void operator()(Fields&... fields) {
    (field(fields), ...);
  }
  void number(std::uint64_t value) {
    for (int k = 0; k < 8; ++k) bytes_.push_back(static_cast<char>(value >> (8 * k) & 0xff));
  }
  void real(double value) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, &value, sizeof(bits));
    number(bits);
  }
  void text(const std::string& value) {
    number(value.size());
    bytes_ += value;
  }
  void vector(const VectorXd& value) {
    number(static_cast<std::uint64_t>(value.size()));
    for (Eigen::Index k = 0; k < value.size(); ++k) real(value[k]);
  }

  const std::string& bytes() const { return bytes_; }

 private:
  void field(long& value) { number(static_cast<std::uint64_t>(value)); }
  void field(double& value) { real(value); }
  void field(std::string& value) { text(value); }
  void field(VectorXd& value) { vector(value); }
  template <typename T>
  void field(std::vector<T>& all) {
    number(all.size());
    for (T& one : all) field(one);
  }
  template <typename T>
  void field(T& object) {
    exchange(*this, object);
  }

  std::string bytes_;
};

/// Reads what a ByteWriter wrote. @throws InvalidInput  the bytes end too early.
class ByteReader {
 public:
  ByteReader(const std::string& bytes, std::size_t at, const std::string& source)
      : bytes_(bytes), at_(at), source_(source) {}

  template <typename... Fields>
  void operator()(Fields&... fields) {
    (field(fields), ...);
  }
  std::uint64_t number() {
    expect(8);
    std::uint64_t value = 0;
    for (int k = 0; k < 8; ++k)
      value |= std::uint64_t{static_cast<unsigned char>(bytes_[at_++])} << (8 * k);
    return value;
  }
  double real() {
    const std::uint64_t bits = number();
    double value = 0.0;
    std::memcpy(&value, &bits, sizeof(value));
    return value;
  }
  /// Reads the number of items of at least `bytes` each, which the remaining length bounds.
  std::size_t count(std::size_t bytes) {
    const std::uint64_t value = number();
    require(value <= (bytes_.size() - at_) / bytes, source_, ": found ", value,
            " entries at byte ", at_, ", expected no more than the rest of the file holds.");
    return static_cast<std::size_t>(value);
  }
  std::string text() {
    const std::size_t size = count(1);
    const std::string value = bytes_.substr(at_, size);
    at_ += size;
    return value;
  }
  VectorXd vector() {
    VectorXd value(count(8));
    for (Eigen::Index k = 0; k < value.size(); ++k) value[k] = real();
    return value;
  }
  bool at_end() const { return at_ == bytes_.size(); }

 private:
  void field(long& value) { value = static_cast<long>(number()); }
  void field(double& value) { value = real(); }
  void field(std::string& value) { value = text(); }
  void field(VectorXd& value) { value = vector(); }
  template <typename T>
  void field(std::vector<T>& all) {
    all.resize(count(8));
    for (T& one : all) field(one);
  }
  template <typename T>
  void field(T& object) {
    exchange(*this, object);
  }

  void expect(std::size_t size) const {
    require(bytes_.size() - at_ >= size, source_, ": ends at byte ", bytes_.size(),
            ", expected more.");
  }

  const std::string& bytes_;
  std::size_t at_;
  const std::string& source_;
};

}  // namespace veridyn
