#include <gtest/gtest.h>

#include <cstdint>
#include <iterator>
#include <random>
#include <vector>

#include "recordings/bags/bag_probe.hpp"
#include "recordings/recording_probe.hpp"
#include "recordings/samples.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

using bags::probe_container;

void damage(std::mt19937* random, std::string* bytes) {
  for (unsigned k = 0; k <= (*random)() % 4; ++k) {
    const std::size_t at = (*random)() % bytes->size();
    switch ((*random)() % 4) {
      case 0:
        (*bytes)[at] = static_cast<char>((*bytes)[at] ^ (1 << ((*random)() % 8)));
        break;
      case 1:
        (*bytes)[at] = static_cast<char>((*random)());
        break;
      case 2:  // a length that cannot be
        for (std::size_t j = at; j < bytes->size() && j < at + 4; ++j) (*bytes)[j] = '\xFF';
        break;
      default:
        bytes->resize(std::max<std::size_t>(1, at));
    }
  }
}

// Words that tables hold, in wrong places.
void damage_text(std::mt19937* random, std::string* text) {
  static const char* const kWords[] = {",",   ";",     "\t",  " ",    "\n",     "\"",     "nan", "1e999",
                                       "-",   "1,5",   "#",   "q1",   "x",      "0 0,5;", "",    "1e-999",
                                       "9,9", "inf",   "+",   "\r\n", "time",   "[deg]",  "/0",  "1700000000"};
  for (unsigned k = 0; k <= (*random)() % 4; ++k) {
    const std::size_t at = (*random)() % text->size();
    const std::size_t drop = (*random)() % 3;
    text->replace(at, std::min(drop, text->size() - at), kWords[(*random)() % std::size(kWords)]);
    if (text->empty()) *text = "0";
  }
}

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
      damage(&random, &bytes);
      values += probe_container(bytes);
    }
  }
  EXPECT_GT(values, 0);
}

// The same for archives and tables, from the first byte to the signals of an arm.
TEST(ADamagedTable, IsReadOrRefused) {
  std::mt19937 random(21);
  long values = 0;
  std::vector<std::string> tables = {
      "t;q1;q2;tau1;tau2\n0,00;0,10;0,20;1,0;2,0\n0,01;0,11;0,21;1,1;2,1\n0,02;0,12;0,22;1,2;2,2\n",
      "# t q1 q2\n0.00 0.10 0.20\n0.01 0.11 0.21\n0.02 0.12 0.22\n",
      "time_ms\tElbow pos [deg]\tElbow torque [mNm]\n0\t10\t1\n5\t11\t2\n10\t12\t3\n",
      "sec,nsec,q1,q2\n1700000000,0,0.1,0.2\n1700000000,5000000,0.1,0.3\n"};
  for (const char* file : {"csv_plotjuggler3_handmade.csv", "csv_plotjuggler_toolbox_handmade.csv",
                           "csv_rostopic_p.csv", "csv_ur_rtde_python.csv"})
    tables.push_back(bytes_of_file(sample(file)));
  for (const std::string& whole : tables) {
    EXPECT_GT(probe_recording(whole), 0) << whole.substr(0, 60);
    for (int round = 0; round < 400; ++round) {
      std::string bytes = whole;
      if (round % 4 == 0) damage(&random, &bytes);
      damage_text(&random, &bytes);
      values += probe_recording(bytes);
    }
  }
  for (const char* file : {"numpy.npz", "numpy_compressed.npz"}) {
    const std::string whole = bytes_of_file(sample(file));
    EXPECT_GT(probe_recording(whole), 0);
    for (int round = 0; round < 400; ++round) {
      std::string bytes = whole;
      damage(&random, &bytes);
      values += probe_recording(bytes);
    }
  }
  EXPECT_GT(values, 0);
}

// A comma behind a number's end is none of the number's.
TEST(ADamagedTable, IsRefusedWithLineAndColumn) {
  try {
    read_probe("t;q1;q2\n0,0;0,1;0,2\n0,1;1 x,5;0,2\n0,2;0,1;0,2\n");
    FAIL();
  } catch (const InvalidInput& refused) {
    EXPECT_NE(std::string(refused.what()).find(":3:2: found '1 x,5'"), std::string::npos)
        << refused.what();
  }
}

// An archive of one deflated array, with the size that its directory states.
std::string archive_of_size(std::uint64_t size) {
  std::string out = "PK\x03\x04";
  const auto put = [&out](std::uint64_t value, int bytes) {
    for (int k = 0; k < bytes; ++k) out += static_cast<char>(k < 8 ? value >> (8 * k) & 0xFF : 0);
  };
  const std::string name = "q.npy";
  put(0x02014b50, 4);
  put(0, 6);
  put(8, 2);  // deflate
  put(0, 8);
  put(100, 4);  // packed
  put(0xFFFFFFFF, 4);
  put(name.size(), 2);
  put(12, 2);
  put(0, 10);
  put(0, 4);  // offset
  out += name;
  put(1, 2);  // the field of large sizes
  put(8, 2);
  put(size, 8);
  put(0x06054b50, 4);
  put(0, 6);
  put(1, 2);
  put(0, 4);
  put(4, 4);  // offset of the directory
  put(0, 2);
  return out;
}

// No memory is asked for what a directory alone states, of any size.
TEST(AnArchive, LargerThanMemoryIsRefused) {
  for (const std::uint64_t size : {std::uint64_t{1} << 50, ~std::uint64_t{0}}) {
    try {
      read_probe(archive_of_size(size));
      FAIL() << size;
    } catch (const InvalidInput& refused) {
      EXPECT_NE(std::string(refused.what()).find("expected at most"), std::string::npos) << refused.what();
    }
  }
}

}  // namespace
}  // namespace veridyn
