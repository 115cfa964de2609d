#include <gtest/gtest.h>

#include <pthread.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <filesystem>
#include <new>
#include <system_error>
#include <thread>

#include "identification/synthetic_recording.hpp"
#include "recordings/samples.hpp"
#include "support/sanitized.hpp"
#include "veridyn/identification/factor_set.hpp"
#include "veridyn/identification/identification.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/model_file.hpp"

// Memory that ends at any allocation of a recording's way from its file to factors in a file and to an
// identified model: in the caller's thread and in the one that reads ahead. A program of its own, for it
// defines malloc.

namespace {

std::atomic<long> allocations{0};
std::atomic<long> first_failing{-1};  // number of an allocation; negative: none
std::atomic<long> last_failing{-1};

bool fails() {
  const long number = allocations++;
  const bool now = number >= first_failing && number <= last_failing;
  if (now) errno = ENOMEM;
  return now;
}

}  // namespace

#if !VERIDYN_SANITIZED
extern "C" {
void* __libc_malloc(std::size_t size);                           // NOLINT: glibc's own name
void* __libc_memalign(std::size_t alignment, std::size_t size);  // NOLINT

void* malloc(std::size_t size) noexcept { return fails() ? nullptr : __libc_malloc(size); }
void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
  return fails() ? nullptr : __libc_memalign(alignment, size);
}
}
#endif

namespace veridyn {
namespace {

namespace fs = std::filesystem;

constexpr long kForGood = 1L << 60;

class OutOfMemory : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) / ("out_of_memory_" + std::to_string(::getpid()));
    fs::create_directories(folder_);
    MotionShape shape;
    shape.duration = 4.0;
    shape.rate = 100.0;
    write_recording(synthetic_recording(arm_, shape), recording());
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string recording() const { return (folder_ / "recording.csv").string(); }
  std::string output() const { return (folder_ / "factors").string(); }

  void work() const {
    const std::vector<std::string> recordings = {recording()};
    const FactorSet factors = compress(arm_, recordings, PreprocessingOptions(), 2);
    save_factors(factors, output());
    (void)identify(arm_, factors);
  }

  // Runs the work with allocations `first` to `last`, counted from its begin, failing.
  // @returns true if it went through.
  bool survives(long first, long last) const {
    fs::remove(output());
    last_failing = allocations + last;
    first_failing = allocations + first;
    bool done = false;
    try {
      work();
      done = true;
    } catch (const std::bad_alloc&) {
    } catch (const std::system_error&) {  // a thread that could not be started
    }
    first_failing = last_failing = -1;
    return done;
  }

  Model arm_ = read_model("planar-2r");
  fs::path folder_;
};

TEST_F(OutOfMemory, AnAllocationFailureLeavesNoPartialFile) {
  work();
  const std::string whole = bytes_of_file(output());
  const long before = allocations;
  work();
  const long all = allocations - before;
  if (all == 0) GTEST_SKIP() << "a sanitizer brings its own malloc";
  ASSERT_GT(all, 1000);
  long refused = 0;
  constexpr int kPlaces = 200;
  for (int k = 0; k < kPlaces; ++k) {
    const long at = all * k / kPlaces;
    for (const long length : {0L, kForGood}) {
      if (!survives(at, length == 0 ? at : kForGood)) ++refused;
      for (const fs::directory_entry& entry : fs::directory_iterator(folder_))
        EXPECT_TRUE(entry.path() == recording() || entry.path() == output()) << entry.path();
      if (fs::exists(output())) {
        EXPECT_EQ(bytes_of_file(output()), whole) << "allocation " << at;
      }
    }
  }
  EXPECT_GT(refused, kPlaces);
  // Nothing of that is left in the process.
  EXPECT_TRUE(survives(-2, -2));
  EXPECT_EQ(bytes_of_file(output()), whole);
}

// A thread whose stack finds no room cannot be started: what it would have read ahead is read in turn.
TEST_F(OutOfMemory, IfNoThreadCanStartTheResultIsTheSame) {
  work();
  const std::string whole = bytes_of_file(output());
  fs::remove(output());
  pthread_attr_t usual, vast;
  ASSERT_EQ(::pthread_getattr_default_np(&usual), 0);
  ASSERT_EQ(::pthread_attr_init(&vast), 0);
  ASSERT_EQ(::pthread_attr_setstacksize(&vast, std::size_t{1} << 47), 0);  // all that a process can address
  ASSERT_EQ(::pthread_setattr_default_np(&vast), 0);
  EXPECT_THROW(std::thread([] {}).join(), std::system_error);
  EXPECT_NO_THROW(work());
  ASSERT_EQ(::pthread_setattr_default_np(&usual), 0);
  ASSERT_TRUE(fs::exists(output()));
  EXPECT_EQ(bytes_of_file(output()), whole);
}

TEST_F(OutOfMemory, AFailedAllocationThrowsInsteadOfTruncatingText) {
  const std::string part(500, 'x');
  const auto whole = [&part] { return text(part, ' ', 1.5, ' ', part, ' ', 12345678); };
  const std::string expected = whole();
  const long before = allocations;
  (void)whole();
  const long all = allocations - before;
  if (all == 0) GTEST_SKIP() << "a sanitizer brings its own malloc";
  ASSERT_GT(all, 2);
  for (long at = 0; at < all; ++at) {
    first_failing = last_failing = allocations + at;
    EXPECT_THROW(whole(), std::bad_alloc) << "allocation " << at;
    first_failing = last_failing = -1;
    EXPECT_EQ(whole(), expected);
  }
}

}  // namespace
}  // namespace veridyn
