#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "fuzz/targets.hpp"
#include "recordings/samples.hpp"

// Inputs that once broke a reader, the seeds of the fuzzer, and a few thousand changes of these, with
// a fixed generator. `make fuzz` goes on from here under clang's libFuzzer.

namespace veridyn {
namespace {

namespace fs = std::filesystem;

class EveryReader : public testing::TestWithParam<FuzzTarget> {};

// Numbers and marks that readers have to take or to refuse, wherever they are.
const std::string kWords[] = {"1e305", "-1e999", "inf", "nan", "5e-324", "1,5", "\r\n", "\xEF\xBB\xBF", "", "~",
                              "{", "]", "&a *a", "2147483648", "-1", "0x1p-1074", "9e18", "\t", "\"", "<",
                              std::string(300, '('), std::string(300, '[')};

std::string changed(std::string bytes, std::mt19937& random) {
  for (unsigned k = 0; k <= random() % 3; ++k) {
    const std::size_t at = bytes.empty() ? 0 : random() % bytes.size();
    switch (bytes.empty() ? 3 : random() % 5) {
      case 0:
        bytes[at] = static_cast<char>(bytes[at] ^ (1 << (random() % 8)));
        break;
      case 1:
        bytes.resize(at);
        break;
      case 2:
        bytes.erase(at, 1 + random() % 8);
        break;
      case 3:
        bytes.insert(at, kWords[random() % std::size(kWords)]);
        break;
      default:  // a number or a word gives way
        bytes.replace(at, std::min<std::size_t>(random() % 6, bytes.size() - at),
                      kWords[random() % std::size(kWords)]);
    }
  }
  return bytes;
}

TEST_P(EveryReader, ReadsOrRefusesFilesThatCrashedItBefore) {
  const fs::path folder = VERIDYN_SOURCE_DIR "/tests/fuzz/corpus/" + GetParam().name;
  if (!fs::exists(folder)) return;  // nothing has so far
  for (const fs::directory_entry& entry : fs::directory_iterator(folder))
    EXPECT_EQ(GetParam().probe(bytes_of_file(entry.path().string())), "") << entry.path();
}

TEST_P(EveryReader, ReadsOrRefusesRandomlyMutatedFiles) {
  const std::vector<std::string> seeds = GetParam().seeds();
  ASSERT_FALSE(seeds.empty());
  for (const std::string& seed : seeds) EXPECT_EQ(GetParam().probe(seed), "");
  std::mt19937 random(35);
  for (int round = 0; round < 300; ++round) {
    const std::string bytes = changed(seeds[random() % seeds.size()], random);
    ASSERT_EQ(GetParam().probe(bytes), "") << "round " << round << ":\n" << bytes.substr(0, 4000);
  }
}

INSTANTIATE_TEST_SUITE_P(Fuzz, EveryReader, testing::ValuesIn(fuzz_targets()),
                         [](const auto& reader) { return reader.param.name; });

}  // namespace
}  // namespace veridyn
