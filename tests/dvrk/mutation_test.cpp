#include <gtest/gtest.h>

#include <sys/mman.h>
#include <unistd.h>

#include <cstring>
#include <random>

#include "dvrk/packet_probe.hpp"
#include "dvrk/vectors.hpp"
#include "veridyn/dvrk/protocol.hpp"

// Mutated datagrams, each in front of a page that nobody may read: a byte read beyond the end ends
// the test, with or without a sanitizer.

namespace veridyn::dvrk {
namespace {

class GuardedBuffer {
 public:
  GuardedBuffer() {
    page_ = static_cast<size_t>(::sysconf(_SC_PAGESIZE));
    room_ = 2 * page_;
    void* at =
        ::mmap(nullptr, room_ + page_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (at == MAP_FAILED) throw std::bad_alloc();
    begin_ = static_cast<std::uint8_t*>(at);
    ::mprotect(begin_ + room_, page_, PROT_NONE);
  }
  ~GuardedBuffer() { ::munmap(begin_, room_ + page_); }
  GuardedBuffer(const GuardedBuffer&) = delete;
  GuardedBuffer& operator=(const GuardedBuffer&) = delete;

  // The bytes, ending where the forbidden page begins.
  ByteView hold(const std::uint8_t* bytes, size_t size) {
    std::uint8_t* at = begin_ + room_ - size;
    std::memcpy(at, bytes, size);
    return {at, size};
  }

 private:
  size_t page_ = 0, room_ = 0;
  std::uint8_t* begin_ = nullptr;
};

class Mutator {
 public:
  explicit Mutator(std::uint64_t seed) : random_(seed) {
    for (const Vector& v : vectors()) seeds_.push_back(bytes_of(v.hex));
    bytes_.reserve(4096);
  }

  const std::vector<std::uint8_t>& next() {
    bytes_ = seeds_[pick(seeds_.size())];
    for (size_t k = 1 + pick(4); k > 0; --k) mutate();
    return bytes_;
  }

 private:
  size_t pick(size_t below) { return static_cast<size_t>(random_() % below); }

  void mutate() {
    switch (pick(6)) {
      case 0:
        bytes_[pick(bytes_.size())] ^= static_cast<std::uint8_t>(1U << pick(8));
        break;
      case 1:
        bytes_[pick(bytes_.size())] = static_cast<std::uint8_t>(random_());
        break;
      case 2:
        bytes_.resize(1 + pick(bytes_.size()));
        break;
      case 3:
        bytes_.resize(bytes_.size() + pick(64), static_cast<std::uint8_t>(random_()));
        break;
      case 4: {  // another packet behind it
        const std::vector<std::uint8_t>& other = seeds_[pick(seeds_.size())];
        if (bytes_.size() + other.size() < 4000)
          bytes_.insert(bytes_.end(), other.begin(), other.end());
        break;
      }
      default:  // a length field
        if (bytes_.size() > 15) bytes_[12 + pick(4)] = static_cast<std::uint8_t>(4 * pick(64));
    }
  }

  std::mt19937_64 random_;
  std::vector<std::vector<std::uint8_t>> seeds_;
  std::vector<std::uint8_t> bytes_;
};

TEST(MutatedDatagrams, NothingIsReadOutsideAndNothingContradictsItself) {
  GuardedBuffer buffer;
  Mutator mutator(19);
  for (long k = 0; k < 2000000; ++k) {
    const std::vector<std::uint8_t>& bytes = mutator.next();
    const char* wrong = probe_packet(buffer.hold(bytes.data(), bytes.size()));
    ASSERT_EQ(wrong, nullptr) << wrong << ", mutation " << k << ": "
                              << hex_of({bytes.data(), bytes.size()});
  }
}

TEST(MutatedDatagrams, EveryPrefixOfEveryVectorIsSafe) {
  GuardedBuffer buffer;
  for (const Vector& v : vectors()) {
    const std::vector<std::uint8_t> bytes = bytes_of(v.hex);
    for (size_t size = 0; size <= bytes.size(); ++size)
      EXPECT_EQ(probe_packet(buffer.hold(bytes.data(), size)), nullptr);
  }
}

}  // namespace
}  // namespace veridyn::dvrk
