#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>
#include <sstream>

#include "cli/tool.hpp"
#include "support/sanitized.hpp"

// The length of a recording costs no memory.

namespace veridyn {
namespace {

constexpr double kAllowedGrowth = 1.25;
// Sanitizers keep freed memory aside, more of it the longer a program runs.
#if VERIDYN_SANITIZED
constexpr bool kMemoryIsReal = false;
#else
constexpr bool kMemoryIsReal = true;
#endif

// Writes the rows of a recording several times over, with time that goes on.
std::string repeated(const TemporaryFolder& folder, const std::string& name,
                     const std::string& content, int times, double seconds) {
  std::ofstream out(folder.path(name));
  std::istringstream header(content);
  std::string line;
  std::getline(header, line);
  out << line << "\n";
  for (int k = 0; k < times; ++k) {
    std::istringstream rows(content);
    std::getline(rows, line);
    while (std::getline(rows, line)) {
      char time[32];
      std::snprintf(time, sizeof time, "%.2f", std::stod(line) + k * seconds);
      out << time << line.substr(line.find(',')) << "\n";
    }
  }
  return folder.path(name);
}

long peak_kib(const Words& arguments) {
  const ToolRun run = run_tool(arguments);
  EXPECT_EQ(run.status, 0) << run.err;
  return run.peak_kib;
}

// Both are longer than the first 200,000 rows, which are looked at as a whole for the period.
TEST(Memory, MemoryDoesNotGrowWithTenTimesTheRows) {
  if (!kMemoryIsReal) GTEST_SKIP() << "memory cannot be measured under the address sanitizer";
  const TemporaryFolder folder;
  const std::string content = planar_recording(250.0);
  const std::string once = repeated(folder, "once.csv", content, 1, 250.0);
  const std::string ten = repeated(folder, "ten.csv", content, 10, 250.0);
  const std::string out = folder.path("out.json");
  const auto identify = [&](const std::string& recording) {
    return Words{"identify", "planar-2r", "--train", recording, "--json", out, "--quiet"};
  };
  const long small = peak_kib(identify(once));
  const double rows = json_of(out)["rows"];
  const long large = peak_kib(identify(ten));
  EXPECT_NEAR(json_of(out)["rows"].get<double>() / rows, 10.0, 0.5);
  EXPECT_LT(static_cast<double>(large), kAllowedGrowth * static_cast<double>(small));
}

}  // namespace
}  // namespace veridyn
