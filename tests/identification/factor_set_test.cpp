#include "veridyn/identification/factor_set.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstdio>
#include <deque>
#include <filesystem>
#include <fstream>
#include <map>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "identification/many_recordings.hpp"
#include "identification/synthetic_recording.hpp"
#include "recordings/kept_recordings.hpp"
#include "support/near.hpp"
#include "support/refusal.hpp"
#include "veridyn/identification/many_machines.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/model_file.hpp"

namespace veridyn {
namespace {

Model robot(const std::string& name) {
  return read_model(VERIDYN_SOURCE_DIR "/data/robots/" + name + ".yaml");
}

// Files of noisy recordings in a folder of their own, removed at the end.
class Files {
 public:
  explicit Files(const std::string& name) : folder_(testing::TempDir() + "veridyn-" + name) {
    std::filesystem::create_directories(folder_);
  }
  ~Files() { std::filesystem::remove_all(folder_); }
  Files(const Files&) = delete;
  Files& operator=(const Files&) = delete;

  std::string path(const std::string& name) const { return folder_ + "/" + name; }

  std::vector<std::string> recordings(const Model& arm, int count, double seconds = 10.0) const {
    std::vector<std::string> out;
    for (int k = 0; k < count; ++k) {
      MotionShape shape;
      shape.duration = seconds;
      shape.seed = static_cast<unsigned>(10 + k);
      Recording r = synthetic_recording(arm, shape);
      r.tau += noise_like(r.tau, 0.05, static_cast<unsigned>(k));
      out.push_back(path("recording-" + std::to_string(k) + ".csv"));
      write_recording(r, out.back());
    }
    return out;
  }

 private:
  std::string folder_;
};

testing::AssertionResult same_answer(const Identification& a, const Identification& b,
                                     double tolerance) {
  if (!a.model || !b.model) return testing::AssertionFailure() << a.reason << " / " << b.reason;
  auto parameters = near(a.parameters, b.parameters,
                               tolerance * (1.0 + b.parameters.cwiseAbs().maxCoeff()));
  if (!parameters) return parameters << " in the parameters";
  if (a.base.size() != b.base.size()) return testing::AssertionFailure() << "base differs";
  for (size_t j = 0; j < a.base.size(); ++j) {
    if (std::abs(a.base[j].std - b.base[j].std) > tolerance * (1.0 + b.base[j].std))
      return testing::AssertionFailure() << "deviation of " << a.base[j].name;
  }
  return near(a.train_error.relative, b.train_error.relative, tolerance);
}

// Recordings that do not fit the memory are parsed once, and their answer is that of recordings in
// memory to the last bit.
TEST(ManyRecordings, BeyondMemoryAreParsedOnceWithTheSameResult) {
  const Model arm = robot("scara");
  const Files files("parsed-once");
  const std::vector<std::string> paths = files.recordings(arm, 3);
  const auto answer = [&](long most_bytes) {
    IdentificationOptions how;
    how.preprocessing.kept = std::make_shared<KeptRecordings>(most_bytes);
    return identify(arm, {paths[0], paths[1]}, {paths[2]}, how);
  };
  const Identification in_memory = answer(KeptRecordings::kFewPasses);
  const long before = files_parsed();
  const Identification on_disk = answer(0);
  EXPECT_EQ(files_parsed() - before, 3);
  ASSERT_TRUE(in_memory.model);
  EXPECT_EQ(in_memory.parameters, on_disk.parameters);
  EXPECT_EQ(in_memory.train_error.relative, on_disk.train_error.relative);
  EXPECT_EQ(in_memory.test_error.relative, on_disk.test_error.relative);
}

TEST(Factors, AreKeptByAFileRoundTrip) {
  const Model arm = robot("scara");
  const Files files("same-after-a-file");
  const FactorSet factors = compress(arm, files.recordings(arm, 2));
  save_factors(factors, files.path("f"));
  const FactorSet read = read_factors(files.path("f"));
  EXPECT_EQ(to_bytes(read), to_bytes(factors));  // every number to the last bit
  ASSERT_EQ(read.recordings.size(), 2);
  const SquareRootInformation& a = factors.recordings[1].blocks[0][2];
  const SquareRootInformation& b = read.recordings[1].blocks[0][2];
  EXPECT_EQ(a.R(), b.R());
  EXPECT_EQ(a.z(), b.z());
  EXPECT_EQ(a.rho2(), b.rho2());
  EXPECT_EQ(a.columns(), b.columns());
  EXPECT_TRUE(read.recordings[1].detached);
}

// Whoever merges factors learns what the recordings together say; the errors are those of the rows
// that went in, a few thousandths off those of all samples.
TEST(Factors, GiveTheSameIdentificationAsTheRecordings) {
  const Model arm = robot("scara");
  const Files files("tell-the-same");
  const std::vector<std::string> train = files.recordings(arm, 3);
  const Identification whole = identify(arm, train);
  const auto by_way_of_bytes = [&](const std::vector<std::string>& paths) {
    return factors_from_bytes(to_bytes(compress(arm, paths)));
  };
  const FactorSet merged =
      merge(by_way_of_bytes({train[0]}), by_way_of_bytes({train[1], train[2]}));
  const Identification id = identify(arm, merged);
  ASSERT_TRUE(id.model);
  EXPECT_TRUE(near(id.parameters, whole.parameters, 1e-12 * whole.parameters.norm()));
  for (size_t j = 0; j < id.base.size(); ++j) {
    EXPECT_NEAR(id.base[j].value, whole.base[j].value, 1e-12 * (1.0 + whole.parameters.norm()));
    EXPECT_NEAR(id.base[j].std, whole.base[j].std, 1e-9 * (1.0 + whole.base[j].std));
  }
  EXPECT_TRUE(near(id.train_error.relative, whole.train_error.relative, 0.02));
  EXPECT_TRUE(std::isnan(id.train_error.maximum[0]));  // needs samples
  const Identification mixed = identify(arm, by_way_of_bytes({train[0]}), {train[1], train[2]});
  EXPECT_TRUE(near(mixed.parameters, whole.parameters, 1e-12 * whole.parameters.norm()));
}

// A maker's file without friction: factors are made with plain friction, of which `file` uses nothing.
TEST(Factors, OfAFileWithoutFrictionGiveTheSameIdentification) {
  const Model arm = robot("planar-2r");
  const Files files("no-friction");
  const std::vector<std::string> train = files.recordings(arm, 2);
  ModelDescription d = arm.description();
  d.effects.clear();
  d.values = RobotValues::kPrior;
  const Model bare(d);
  const FactorSet factors = compress(bare, train);
  for (const JointFriction friction : {JointFriction::kAuto, JointFriction::kPlain, JointFriction::kFile}) {
    IdentificationOptions how;
    how.friction = friction;
    const Identification whole = identify(bare, train, {}, how);
    const Identification id = identify(bare, factors, {}, {}, how);
    ASSERT_TRUE(id.model && whole.model);
    // As far as the feasible solver goes, which comes from another rounding.
    EXPECT_TRUE(near(id.parameters, whole.parameters, 1e-7 * whole.parameters.norm())) << name_of(friction);
  }
}

TEST(Factors, OfAnotherArmOrFilterAreRefused) {
  const Model arm = robot("scara");
  const Files files("other-arm");
  const std::vector<std::string> train = files.recordings(arm, 1);
  const FactorSet factors = compress(arm, train);
  ModelDescription longer = arm.description();
  longer.frames.back().A.p.x += 1e-3;
  const Model other(longer);
  EXPECT_THROW(identify(other, factors), InvalidInput);
  EXPECT_THROW(merge(factors, compress(other, train)), InvalidInput);
  PreprocessingOptions sharper;
  sharper.cutoff = 3.0;
  EXPECT_THROW(merge(factors, compress(arm, train, sharper)), InvalidInput);
}

TEST(Factors, ThatAreDamagedAreRefusedInOneLine) {
  const Model arm = robot("scara");
  const Files files("damaged");
  const std::string whole = to_bytes(compress(arm, files.recordings(arm, 1, 6.0)));
  std::string flipped = whole;
  flipped[whole.size() / 2] = static_cast<char>(flipped[whole.size() / 2] ^ 1);
  for (const std::string& bytes : {std::string("t,q1\n0,1\n"), whole.substr(0, whole.size() / 2),
                                   flipped, std::string(), whole.substr(0, 20)}) {
    try {
      factors_from_bytes(bytes, "lab.factors");
      ADD_FAILURE() << "took " << bytes.size() << " bytes";
    } catch (const InvalidInput& error) {
      const std::string words = error.what();
      EXPECT_EQ(words.compare(0, 12, "lab.factors:"), 0) << words;
      EXPECT_NE(words.find("expected"), std::string::npos) << words;
      EXPECT_EQ(words.find('\n'), std::string::npos) << words;
    }
  }
}

// The version is the number behind the first line, which no checksum covers.
TEST(Factors, OfALaterVersionAreRefused) {
  const Model arm = robot("scara");
  const Files files("later");
  std::string later = to_bytes(compress(arm, files.recordings(arm, 1, 6.0)));
  const std::size_t version = later.find('\n') + 1;
  ASSERT_EQ(later[version], 1);
  later[version] = 2;
  try {
    factors_from_bytes(later, "lab.factors");
    ADD_FAILURE() << "took factors of version 2";
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("found factors of version 2, expected 1"), std::string::npos) << error.what();
  }
}

// Many recordings keep few blocks each, and still every row.
TEST(ManyRecordings, MergingBlocksKeepsEveryRow) {
  const Model arm = robot("scara");
  const Files files("blocks");
  CompressedRecording r = compress(arm, files.recordings(arm, 1, 30.0)[0], {});
  double before = 0.0;
  for (const auto& block : r.blocks) before += block[0].rhs_norm2();
  merge_blocks(r, 3);
  EXPECT_LE(r.blocks.size(), 3);
  double after = 0.0;
  double rows = 0.0;
  for (const auto& block : r.blocks) {
    after += block[0].rhs_norm2();
    for (const SquareRootInformation& f : block) rows += f.rows();
  }
  EXPECT_NEAR(after, before, 1e-12 * before);
  EXPECT_EQ(rows, r.rows);
  EXPECT_EQ(blocks_of_each(1000), 1);
  EXPECT_GE(blocks_of_each(10), 16);  // as many as a recording has
}

// ---- ranks, as threads --------------------------------------------------------------------------

constexpr std::chrono::seconds kLongestWait{60};

class Mail {
 public:
  void put(int from, int to, const std::string& bytes) {
    const std::lock_guard<std::mutex> lock(guard_);
    boxes_[{from, to}].push_back(bytes);
    arrived_.notify_all();
  }
  std::string read_part(int from, int to) {
    std::unique_lock<std::mutex> lock(guard_);
    std::deque<std::string>& box = boxes_[{from, to}];
    if (!arrived_.wait_for(lock, kLongestWait, [&] { return !box.empty(); }))
      throw std::runtime_error(text("rank ", to, " waits for rank ", from));
    std::string bytes = box.front();
    box.pop_front();
    return bytes;
  }

 private:
  std::mutex guard_;
  std::condition_variable arrived_;
  std::map<std::pair<int, int>, std::deque<std::string>> boxes_;
};

class ThreadRank final : public Communicator {
 public:
  ThreadRank(int rank, int size, Mail& mail) : rank_(rank), size_(size), mail_(mail) {}
  int rank() const override { return rank_; }
  int size() const override { return size_; }
  void send(int to, const std::string& bytes) override { mail_.put(rank_, to, bytes); }
  std::string receive(int from) override { return mail_.read_part(from, rank_); }

 private:
  int rank_, size_;
  Mail& mail_;
};

// The answer of rank 0, and what each rank threw.
Identification by_ranks(const Model& arm, const std::vector<std::string>& train,
                        const std::vector<std::string>& test, int size, std::vector<std::string>* refused = nullptr,
                        IdentificationOptions options = {}, const KeepFactors& keep = {}, int keeper = 0) {
  Mail mail;
  std::vector<std::thread> ranks;
  Identification answer;
  std::mutex guard;
  options.threads = 1;
  for (int r = 0; r < size; ++r) {
    ranks.emplace_back([&, r] {
      ThreadRank rank(r, size, mail);
      try {
        Identification id = identify(arm, train, test, options, rank, r == keeper ? keep : KeepFactors());
        if (r == 0) answer = std::move(id);
      } catch (const InvalidInput& error) {
        const std::lock_guard<std::mutex> lock(guard);
        if (refused != nullptr) refused->emplace_back(error.what());
      } catch (const std::exception& error) {
        ADD_FAILURE() << error.what();
      }
    });
  }
  for (std::thread& t : ranks) t.join();
  return answer;
}

TEST(DistributedIdentification, GivesTheSameResultAsOneProcess) {
  const Model arm = robot("scara");
  const Files files("ranks");
  std::vector<std::string> train = files.recordings(arm, 6, 8.0);
  const std::vector<std::string> test = {train.back()};
  train.pop_back();
  const Identification one = identify(arm, train, test);
  for (const int size : {1, 2, 3, 7}) {
    const Identification many = by_ranks(arm, train, test, size);
    EXPECT_TRUE(same_answer(many, one, 1e-12)) << size << " ranks";
    EXPECT_TRUE(near(many.test_error.relative, one.test_error.relative, 1e-12));
    EXPECT_TRUE(near(many.train_error.maximum, one.train_error.maximum, 1e-12));
    ASSERT_EQ(many.train.size(), train.size());
    for (size_t k = 0; k < train.size(); ++k) EXPECT_EQ(many.train[k].source, train[k]);
    EXPECT_TRUE(many.unusable_recordings.empty());
  }
}

// A velocity whose scale is wrong is left out by one process; ranks and factors do the same.
TEST(DistributedIdentification, ChoosesTheVelocitiesThatOneProcessChooses) {
  const Model arm = robot("scara");
  const Files files("ranks-velocities");
  std::vector<std::string> train;
  for (const std::string& path : files.recordings(arm, 4, 8.0)) {
    Recording r = read_recording(path);
    r.dq.col(1) *= 1.3;
    train.push_back(path + ".scaled.csv");
    write_recording(r, train.back());
  }
  const std::vector<std::string> test = {train.back()};
  train.pop_back();
  const Identification one = identify(arm, train, test);
  ASSERT_EQ(one.preprocessing.derive_velocity_of, (std::vector<JointIndex>{{1}}));
  for (const int size : {1, 2, 4}) {
    const Identification many = by_ranks(arm, train, test, size);
    EXPECT_TRUE(same_answer(many, one, 1e-12)) << size << " ranks";
    EXPECT_TRUE(near(many.test_error.relative, one.test_error.relative, 1e-12));
    EXPECT_EQ(many.remarks, one.remarks);
  }
  const FactorSet factors = compress(arm, train, one.preprocessing);
  const Identification of_factors =
      identify(arm, factors_from_bytes(to_bytes(factors)), {}, test);
  EXPECT_TRUE(near(of_factors.parameters, one.parameters, 1e-12 * (1.0 + one.parameters.norm())));
  EXPECT_TRUE(near(of_factors.test_error.relative, one.test_error.relative, 1e-12));
  EXPECT_THROW(merge(factors, compress(arm, test)), InvalidInput);
}

TEST(DistributedIdentification, SkipsUnreadableRecordings) {
  const Model arm = robot("scara");
  const Files files("ranks-left-out");
  const std::vector<std::string> good = files.recordings(arm, 3, 8.0);
  const std::string lost = files.path("lost.csv");
  const std::string broken = files.path("broken.csv");
  std::ofstream(broken) << "t,q1,q2\n0,zero,1\n";
  const Identification many =
      by_ranks(arm, {good[0], lost, good[1], broken, good[2]}, {good[0]}, 2);
  ASSERT_EQ(many.unusable_recordings.size(), 2);
  EXPECT_EQ(many.unusable_recordings[0].source, lost);
  EXPECT_EQ(many.unusable_recordings[1].source, broken);
  EXPECT_NE(many.unusable_recordings[1].why.find("broken.csv"), std::string::npos);
  EXPECT_TRUE(same_answer(many, identify(arm, good, {good[0]}), 1e-12));
  std::vector<std::string> refused;
  by_ranks(arm, {lost, broken}, {}, 3, &refused);
  EXPECT_EQ(refused.size(), 3U);
}

// A fault that only one rank detects ends all ranks: a prior of another arm, before anything is read; a weight that no
// solver accepts, once all recordings are compressed; a recording that is missing when its errors are measured; and factors
// that another rank cannot store.
TEST(DistributedIdentification, FailsOnAllRanksWithTheSameMessage) {
  const Model arm = robot("scara");
  const Files files("ranks-refuse");
  const std::vector<std::string> train = files.recordings(arm, 3, 8.0);
  IdentificationOptions foreign, weight;
  foreign.prior = robot("planar-2r");
  weight.prior = arm;
  weight.prior_weight = -1.0;
  int kept = 0;
  const KeepFactors count = [&](const FactorSet&, bool) { ++kept; };
  std::vector<std::string> refused;
  by_ranks(arm, train, {}, 3, &refused, foreign, count);
  ASSERT_EQ(refused.size(), 3U);
  EXPECT_NE(refused[0].find("does not give values to the same bodies"), std::string::npos) << refused[0];
  EXPECT_EQ(kept, 0);
  foreign.method = Method::kWls;  // which asks no prior
  EXPECT_TRUE(by_ranks(arm, train, {}, 3, nullptr, foreign).model.has_value());
  std::vector<std::string> of_weight;
  by_ranks(arm, train, {}, 3, &of_weight, weight);
  ASSERT_EQ(of_weight.size(), 3U);
  EXPECT_NE(of_weight[0].find("weight"), std::string::npos) << of_weight[0];
  const KeepFactors lose = [&](const FactorSet&, bool whole) {
    if (whole) return;
    std::remove(train[0].c_str());
  };
  std::vector<std::string> gone;
  by_ranks(arm, train, {}, 3, &gone, {}, lose);
  ASSERT_EQ(gone.size(), 3U);
  EXPECT_NE(gone[0].find(train[0]), std::string::npos) << gone[0];
  const KeepFactors full = [&](const FactorSet&, bool whole) { require(whole, "the disk is full"); };
  std::vector<std::string> of_disk;
  by_ranks(arm, {train[1], train[2]}, {}, 3, &of_disk, {}, full, 2);
  ASSERT_EQ(of_disk.size(), 3U);
  EXPECT_EQ(of_disk[0], "the disk is full");
  for (const auto* all : {&refused, &of_weight, &gone, &of_disk}) {
    for (const std::string& one : *all) EXPECT_EQ(one, all->front());
  }
}

// Factors are kept while the work goes on, and once as a whole, with the velocities that were chosen in the end.
TEST(DistributedIdentification, WritesTheSameFactorsAsOneProcess) {
  const Model arm = robot("scara");
  const Files files("kept");
  std::vector<std::string> train = files.recordings(arm, 3, 8.0);
  for (const bool wrong : {false, true}) {
    for (const std::string& path : train) {
      if (!wrong) break;
      Recording r = read_recording(path);
      r.dq.col(1) *= 1.3;
      write_recording(r, path);
    }
    Mail mail;
    ThreadRank alone(0, 1, mail);
    std::vector<size_t> parts;
    std::vector<FactorSet> whole;
    const Identification id = identify(arm, train, {}, {}, alone, [&](const FactorSet& factors, bool all) {
      if (all) whole.push_back(factors);
      else parts.push_back(factors.recordings.size());
    });
    ASSERT_TRUE(id.model.has_value()) << id.reason;
    EXPECT_GE(parts.size(), 2U);
    EXPECT_EQ(parts.back(), 3U);
    ASSERT_EQ(whole.size(), 1U);
    EXPECT_EQ(whole[0].recordings.size(), 3U);
    EXPECT_EQ(joints_with_derived_velocities(whole[0]), (wrong ? std::vector<JointIndex>{{1}} : std::vector<JointIndex>{}));
    EXPECT_TRUE(near(identify(arm, whole[0]).parameters, id.parameters, 1e-9 * id.parameters.norm()));
  }
}

// Ranks tell what recordings leave open as one machine does.
TEST(DistributedIdentification, ReportsTheSameRankDeficiencyAsOneProcess) {
  const Model arm = robot("scara");
  const Files files("still");
  std::vector<std::string> train = files.recordings(arm, 2, 8.0);
  for (const std::string& path : train) {
    Recording r = read_recording(path);
    r.q.col(3).setConstant(0.1);
    r.dq.col(3).setZero();
    write_recording(r, path);
  }
  const Identification one = identify(arm, train), many = by_ranks(arm, train, {}, 2);
  EXPECT_EQ(one.status, IdentificationStatus::kRankDeficient);
  EXPECT_EQ(many.status, one.status);
  EXPECT_EQ(many.reason, one.reason);
  EXPECT_EQ(many.undetermined, one.undetermined);
}

// Ranks exchange factors, but drive gains and instruments need samples.
TEST(DistributedIdentification, RejectsOptionsThatNeedSamples) {
  const Model arm = robot("scara");
  Mail mail;
  ThreadRank alone(0, 1, mail);
  IdentificationOptions instruments, masses;
  instruments.method = Method::kDidim;
  masses.known_masses = {{1.0, "tool", {}}};
  EXPECT_TRUE(refuses_with("instruments", [&] { identify(arm, {"a.csv"}, {}, instruments, alone); }));
  EXPECT_TRUE(refuses_with("known masses", [&] { identify(arm, {"a.csv"}, {}, masses, alone); }));
  EXPECT_TRUE(refuses_with("no recording to train on", [&] { identify(arm, std::vector<std::string>(), {}, {}, alone); }));
}

}  // namespace
}  // namespace veridyn
