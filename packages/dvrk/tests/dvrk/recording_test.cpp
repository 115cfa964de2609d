#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "dvrk/rig.hpp"
#include "dvrk/run/cycle_clock.hpp"
#include "dvrk/run/rows/row_file.hpp"
#include "dvrk/run/rows/row_keeper.hpp"
#include "veridyn/recordings/recording.hpp"

// Rows on their way to the disk, the boards' time, and the clock of the loop.

namespace veridyn::dvrk {
namespace {

std::string temporary(const std::string& name) {
  return (std::filesystem::temp_directory_path() / (name + std::to_string(::getpid()))).string();
}

std::string content(const std::string& path) {
  std::ifstream file(path);
  std::ostringstream out;
  out << file.rdbuf();
  return out.str();
}

void keep(RowKeeper& keeper, int from, int to) {
  BoardArmState state(2);
  for (int k = from; k < to; ++k) {
    state.q << 0.1 * k, -0.2 * k;
    keeper.keep(0.001 * k, state);
  }
}

template <typename Holds>
bool arrives_in_time(Holds&& holds) {
  for (int k = 0; k < 1000 && !holds(); ++k)
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  return holds();
}

// A program killed now leaves whole rows and a first line that marks the file as incomplete.
TEST(RowFile, RowsAreOnTheDiskWhileTheyAreRecorded) {
  const std::string path = temporary("veridyn-rows-");
  RowKeeper keeper(2, 10.0, 100.0);
  {
    RowFile file(path, keeper, 2);
    EXPECT_FALSE(std::filesystem::exists(path));  // nothing before the first row
    keep(keeper, 0, 500);
    ASSERT_TRUE(arrives_in_time([&] { return content(path).find("\n0.499,") != std::string::npos; }));
    const std::string there = content(path);
    EXPECT_EQ(there.rfind("# incomplete: the program ended while it recorded", 0), 0U);
    EXPECT_EQ(there.back(), '\n');
    const Recording rows = read_recording(path);
    EXPECT_EQ(rows.rows(), 500);
    EXPECT_NEAR(rows.q(499, 1), -0.2 * 499, 1e-8);
    keep(keeper, 500, 600);
    file.finish("");
    EXPECT_EQ(file.rows(), 600);
    EXPECT_EQ(file.error(), "");
  }
  EXPECT_EQ(content(path).rfind("t,q1,q2,dq1,dq2,tau1,tau2\n", 0), 0U);
  EXPECT_EQ(read_recording(path).rows(), 600);
  std::filesystem::remove(path);
}

// A limit on the size of files stands for a disk that is full.
TEST(RowFile, AFullDiskKeepsWholeRowsAndReportsTheirNumber) {
  const std::string path = temporary("veridyn-full-");
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit small{4000, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  RowKeeper keeper(2, 10.0, 100.0);
  Eigen::Index kept = 0;
  {
    RowFile file(path, keeper, 2);
    keep(keeper, 0, 500);
    EXPECT_TRUE(arrives_in_time([&] { return file.failed(); }));
    file.finish("stopped");
    kept = file.rows();
    EXPECT_NE(file.error(), "");
  }
  ::setrlimit(RLIMIT_FSIZE, &before);
  const std::string there = content(path);
  EXPECT_EQ(there.rfind("# incomplete: ", 0), 0U);
  EXPECT_NE(there.find(" after " + std::to_string(kept) + " rows"), std::string::npos)
      << there.substr(0, 200);
  EXPECT_GT(kept, 50);
  EXPECT_EQ(read_recording(path).rows(), kept);
  std::filesystem::remove(path);
}

// Full before the first row: no file, and the one that was there stays as it was.
TEST(RowFile, AFullDiskWithoutARowLeavesNoFile) {
  const auto folder = std::filesystem::temp_directory_path() / ("veridyn-no-row-" + std::to_string(::getpid()));
  std::filesystem::create_directory(folder);
  const std::string path = (folder / "rows.csv").string();
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  for (const bool there : {false, true}) {
    for (const rlim_t bytes : {0, 100, 230}) {  // nothing, a part of the first line, no whole row
      if (there) std::ofstream(path) << "an older recording\n";
      const rlimit small{bytes, before.rlim_max};
      ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
      RowKeeper keeper(2, 10.0, 100.0);
      {
        RowFile file(path, keeper, 2);
        keep(keeper, 0, 500);
        EXPECT_TRUE(arrives_in_time([&] { return file.failed(); }));
        file.finish("stopped");
        EXPECT_EQ(file.rows(), 0);
        EXPECT_NE(file.error(), "");
      }
      ::setrlimit(RLIMIT_FSIZE, &before);
      EXPECT_EQ(std::filesystem::exists(path), there) << bytes;
      if (there) {
        EXPECT_EQ(content(path), "an older recording\n");
      }
      int files = 0;
      for ([[maybe_unused]] const auto& one : std::filesystem::directory_iterator(folder)) ++files;
      EXPECT_EQ(files, there ? 1 : 0) << bytes;
    }
  }
  std::filesystem::remove_all(folder);
}

// A link to a file stays one.
TEST(RowFile, ASymbolicLinkIsKeptAndItsTargetWritten) {
  const auto folder = std::filesystem::temp_directory_path() / ("veridyn-linked-" + std::to_string(::getpid()));
  std::filesystem::create_directory(folder);
  const std::string path = (folder / "link.csv").string(), target = (folder / "target.csv").string();
  std::ofstream(target) << "an older recording\n";
  std::filesystem::create_symlink(target, path);
  RowKeeper keeper(2, 10.0, 100.0);
  {
    RowFile file(path, keeper, 2);
    keep(keeper, 0, 50);
    file.finish("");
  }
  EXPECT_TRUE(std::filesystem::is_symlink(path));
  EXPECT_EQ(read_recording(target).rows(), 50);
  std::filesystem::remove_all(folder);
}

// The boards' counter gives times that no late wake-up disturbs; somebody else who reads the
// boards restarts it, and the time that he took is added.
TEST(LatchTime, IsCorrectIfAnotherReaderRestartsTheCounter) {
  constexpr double kCycle = 1.0 / 1500.0;
  for (const bool another : {false, true}) {
    LatchTime latch;
    double worst = 0.0, last = 0.0;
    for (int k = 0; k < 15000; ++k) {
      const double at = k * kCycle;
      const double woken = (k % 7 == 0 ? 3e-4 : 0.0) + (k % 500 == 0 ? 2e-3 : 0.0);
      // Ten times a second another reader takes a half of the time since the read before.
      const double lost = another && k % 150 == 75 ? 0.5 * kCycle : 0.0;
      last = latch.next(at + woken, kCycle - lost);
      if (k > 100) worst = std::max(worst, std::abs(last - (at - 0.0)));
    }
    EXPECT_LT(worst, 1.5e-3) << another;
    EXPECT_NEAR(last, 14999 * kCycle, 1.5e-3) << another;  // not ten seconds less 33 ms
    EXPECT_EQ(latch.foreign_reads() > 50, another);
  }
}

// A link whose wake-ups and replies a test makes late.
class SlowLink final : public DatagramLink {
 public:
  bool send(ByteView, Destination) noexcept override { return true; }
  Arrival receive(ByteSpan, double) noexcept override { return {}; }
  double now() noexcept override { return now_; }
  void wait(double seconds) noexcept override { now_ += seconds + oversleep; }
  std::uint32_t address_word() const noexcept override { return 0; }
  void pass(double seconds) { now_ += seconds; }
  double oversleep = 0.0;

 private:
  double now_ = 0.0;
};

struct Late {
  double oversleep, replies, lay;
  LateReason reason;
};

TEST(CycleClock, ALateCycleIsAttributedToTheSystemOrToReplies) {
  for (const Late& late :
       {Late{0.030, 0.0, 0.0, LateReason::kSystem}, Late{0.0, 0.030, 0.0, LateReason::kReplies},
        Late{0.0, 0.030, 0.029, LateReason::kSystem}}) {
    SlowLink link;
    CycleClock clock(link, 1000.0);
    for (int k = 0; k < 400; ++k) {
      const bool now = k == 200;
      link.oversleep = now ? late.oversleep : 0.0;
      clock.begin();
      link.pass(1e-4 + (now ? late.replies : 0.0));
      clock.read(now ? late.lay : 0.0);
      clock.end();
    }
    const LoopTiming& timing = clock.timing();
    EXPECT_EQ(timing.late, 1);
    EXPECT_NEAR(timing.longest_gap.seconds, 0.031, 2e-4);
    EXPECT_EQ(reason_of(timing.longest_gap), late.reason) << describe_reason(timing.longest_gap);
    EXPECT_EQ(timing.late_own, 0);
    EXPECT_EQ(timing.late_replies, late.reason == LateReason::kReplies ? 1 : 0);
    EXPECT_FALSE(clock.persistently_late());
  }
}

TEST(CycleClock, APersistentlyLateLoopIsDetected) {
  SlowLink link;
  CycleClock clock(link, 1500.0);
  int cycles = 0;
  while (!clock.persistently_late() && cycles < 10000) {
    clock.begin();
    link.pass(0.0106);  // 94 Hz
    clock.read(0.0);
    clock.end();
    ++cycles;
  }
  EXPECT_LT(cycles, 60);
  EXPECT_LT(clock.timing().measured_rate(), 0.1 * 1500.0);
}

}  // namespace
}  // namespace veridyn::dvrk
