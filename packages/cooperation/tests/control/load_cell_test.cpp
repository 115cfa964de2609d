#include "veridyn/control/load_cell.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>
#include <string>
#include <vector>

#include "control/load_cell_frame.hpp"
#include "veridyn/math/require.hpp"

// Load cells: decoding of serial lines, and calibration.

namespace veridyn {
namespace {

int readings_of(LoadCellDecoder& decoder, const std::string& bytes, std::vector<double>& out) {
  int count = 0;
  for (const char c : bytes) {
    if (!decoder.add_byte(static_cast<std::uint8_t>(c))) continue;
    out.push_back(decoder.raw());
    ++count;
  }
  return count;
}

// The check value of this CRC over the digits 1 to 9, as its catalogue has it.
TEST(LoadCell, TheCrcMatchesItsPublishedCheckValue) {
  EXPECT_EQ(crc16(reinterpret_cast<const std::uint8_t*>("123456789"), 9), 0x29B1);
}

TEST(LoadCell, TextLinesOfCommonConvertersAreRead) {
  LoadCellDecoder decoder(LoadCellFormat::kText);
  std::vector<double> got;
  readings_of(decoder, "cut 5\nHX711 reading: 8388607\r\n-12.5\n0.1,512\nHX711\n\x01\x02 7\n1e3\n", got);
  EXPECT_EQ(got, (std::vector<double>{8388607.0, -12.5, 512.0, 1000.0}));
  EXPECT_EQ(decoder.rejected_readings(), 2);  // a name without a number, bytes that are no text
}

// Tabs, names with an equals sign and blanks at the end belong to usual lines; what is too long, whole or
// in one field, or blank, is none.
TEST(LoadCell, BlankLinesAreSkippedAndLongLinesRejected) {
  LoadCellDecoder decoder(LoadCellFormat::kText);
  std::vector<double> got;
  readings_of(decoder, "cut\n1\t2\nF=3\nt=1 F=4 \t\n0.1, 5\n   \n0" + std::string(48, '0') + "6\n", got);
  EXPECT_EQ(got, (std::vector<double>{2.0, 3.0, 4.0, 5.0}));
  EXPECT_EQ(decoder.rejected_readings(), 2);
  readings_of(decoder, "7 " + std::string(100, ' ') + "8\n9\n", got);
  EXPECT_EQ(got.back(), 9.0);
  EXPECT_EQ(got.size(), 5U);
  EXPECT_EQ(decoder.rejected_readings(), 3);
}

// Two weights with one reading each leave no degree of freedom for an interval.
TEST(LoadCell, WithoutRepetitionThereIsNoInterval) {
  const LoadCellCalibration found = calibrate_load_cell({0.0, 2.0}, {100.0, 300.0});
  EXPECT_NEAR(found.scale, 0.01, 1e-12);
  EXPECT_TRUE(std::isnan(found.scale_interval) && std::isnan(found.offset_interval));
  for (const double bad : {static_cast<double>(NAN), static_cast<double>(INFINITY)}) {
    EXPECT_THROW(calibrate_load_cell({0.0, bad}, {1.0, 2.0}), InvalidInput);
    EXPECT_THROW(calibrate_load_cell({0.0, 1.0}, {1.0, bad}), InvalidInput);
  }
}

// The number before "nan" is the time, and "ERR 12" is no force of 12 N.
TEST(LoadCell, ALineWithANonFiniteLastFieldIsRejected) {
  const std::vector<std::string> none = {
      "1.234,nan", "1.234,inf",   "1.234,-inf", "nan",     "1.234,",  "1.234;NaN", "5.2 N", "5.2N",
      "ERR 12",    "overload 12", "1.234,ERR",  "1e999",   "0x1F",    "1.2.3",     "--4",   "1,two,3",
      "12 12nan",  "reading:",    "1.234,1e",   "= nan",   "ERR,5",   "x 1: y 2",
      "F\x01: 12", "F\xB5=12"};
  for (const std::string& line : none) {
    LoadCellDecoder decoder(LoadCellFormat::kText);
    std::vector<double> got;
    readings_of(decoder, "cut\n" + line + "\n", got);
    EXPECT_TRUE(got.empty()) << line << " gave " << got.front();
    EXPECT_EQ(decoder.rejected_readings(), 1) << line;
  }
  const std::vector<std::pair<std::string, double>> readings = {
      {"8388607", 8388607.0}, {"0.1,512", 512.0},  {"0.1; -512.5", -512.5}, {"1 2 3", 3.0},
      {"force = 4.5", 4.5},   {"F:-1e-3 ", -1e-3}, {"t: 0.5, F: 2", 2.0},   {"HX711 reading: 7", 7.0}};
  for (const auto& [line, value] : readings) {
    LoadCellDecoder decoder(LoadCellFormat::kText);
    std::vector<double> got;
    readings_of(decoder, "cut\n" + line + "\n", got);
    EXPECT_EQ(got, std::vector<double>{value}) << line;
  }
}

// Every undamaged frame is read, whatever is between the frames.
TEST(LoadCell, UndamagedBinaryFramesAreReadBetweenGarbageAndTruncatedFrames) {
  std::mt19937 random(7);
  LoadCellDecoder decoder(LoadCellFormat::kBinary);
  std::string line;
  std::vector<double> sent, got;
  for (int k = 0; k < 2000; ++k) {
    std::string bytes = frame(static_cast<std::uint16_t>(k), 1000 * k - 700000);
    if (k % 7 == 3) bytes[5] = static_cast<char>(bytes[5] ^ 0x10);  // a bit is wrong
    if (k % 7 == 5) bytes.resize(4);                                // the rest was lost
    if (k % 7 != 3 && k % 7 != 5) sent.push_back(1000.0 * k - 700000.0);
    if (k % 11 == 0) {
      for (int g = 0; g < 5; ++g) line += static_cast<char>(random() & 0x7F);
    }
    line += bytes;
  }
  readings_of(decoder, line, got);
  EXPECT_EQ(got, sent);
  EXPECT_GT(decoder.rejected_readings(), 200);
}

// raw = 100 + 50 f by hand: offset 100, scale 1/50; the interval holds the truth.
TEST(LoadCell, CalibrationFindsOffsetAndScaleWithinTheirIntervals) {
  const LoadCellCalibration exact =
      calibrate_load_cell({0.0, 0.0, 10.0, 10.0}, {100.0, 100.0, 600.0, 600.0});
  EXPECT_NEAR(exact.offset, 100.0, 1e-9);
  EXPECT_NEAR(exact.scale, 0.02, 1e-12);
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0.0, 20.0);
  int covered = 0;
  for (int run = 0; run < 200; ++run) {
    std::vector<double> force, raw;
    for (const double f : {0.0, 4.9, 9.8, 19.6}) {
      for (int k = 0; k < 10; ++k) {
        force.push_back(f);
        raw.push_back(100.0 + 50.0 * f + noise(random));
      }
    }
    const LoadCellCalibration found = calibrate_load_cell(force, raw);
    covered += std::abs(found.scale - 0.02) <= found.scale_interval ? 1 : 0;
  }
  EXPECT_GT(covered, 178);  // 95 % of 200 less three standard deviations of the count
  EXPECT_LT(covered, 200);
  EXPECT_THROW(calibrate_load_cell({1.0, 1.0}, {5.0, 6.0}), InvalidInput);
  EXPECT_THROW(calibrate_load_cell({0.0, 1.0}, {5.0, 5.0}), InvalidInput);
}

// With two different forces the line passes through the mean reading of each, so that the offset is the mean of 99 and
// 101. The four residuals are 1, so a reading has the variance 4 / (4 - 2) = 2 and the mean of two of them half of it;
// Student's t for two degrees of freedom is 4.3027.
TEST(LoadCell, TheOffsetHasTheUncertaintyOfTheReadingsWithoutForce) {
  const LoadCellCalibration found = calibrate_load_cell({0.0, 0.0, 10.0, 10.0}, {99.0, 101.0, 599.0, 601.0});
  EXPECT_NEAR(found.offset_interval, 4.3026527 * std::sqrt(2.0 / 2.0), 1e-6);
}

}  // namespace
}  // namespace veridyn
