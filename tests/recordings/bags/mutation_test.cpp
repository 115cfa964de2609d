#include <gtest/gtest.h>

#include <random>

#include "recordings/bags/bag_probe.hpp"
#include "recordings/samples.hpp"

namespace veridyn::bags {
namespace {

// Bits, bytes, lengths and cuts at random in real containers: nothing but InvalidInput comes out,
// and nothing is allocated for what is not there. The fuzzer (VERIDYN_FUZZ) goes further.
TEST(ADamagedContainer, IsReadOrRefused) {
  std::mt19937 random(20);
  long values = 0;
  for (const char* file : {"vectors/mini_ros1.bag", "vectors/mini_chunk_zstd.mcap", "ros1_cpp_lz4.bag",
                           "ros1_crash_lz4.bag", "mcap_json.mcap", "mcap_cdr_zstd.mcap",
                           "rb2_zstd_file/rb2_zstd_file_0.db3.zstd"}) {
    const std::string whole = bytes_of_file(sample(file));
    ASSERT_FALSE(whole.empty());
    EXPECT_GT(probe_container(whole), 0);
    for (int round = 0; round < 60; ++round) {
      std::string bytes = whole;
      for (unsigned k = 0; k <= random() % 4; ++k) {
        const std::size_t at = random() % bytes.size();
        switch (random() % 4) {
          case 0:
            bytes[at] = static_cast<char>(bytes[at] ^ (1 << (random() % 8)));
            break;
          case 1:
            bytes[at] = static_cast<char>(random());
            break;
          case 2:  // a length that cannot be
            for (std::size_t j = at; j < bytes.size() && j < at + 4; ++j) bytes[j] = '\xFF';
            break;
          default:
            bytes.resize(std::max<std::size_t>(1, at));
        }
      }
      values += probe_container(bytes);
    }
  }
  EXPECT_GT(values, 0);
}

}  // namespace
}  // namespace veridyn::bags
