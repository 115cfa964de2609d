#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <tuple>
#include <utility>

#include "cli/tool.hpp"

// The same input gives the same bytes, and any number of threads the same answer: sums may be taken in
// another order, by 1e-10 of a number at most, and no cause may depend on it.

namespace veridyn {
namespace {

using nlohmann::json;

json without_times(json result) {
  if (result.is_object()) {
    result.erase("seconds");
    result.erase("threads");
  }
  for (json& part : result)
    if (part.is_structured()) part = without_times(std::move(part));
  return result;
}

class Repeated : public testing::Test {
 protected:
  void SetUp() override {
    const std::string motion = folder_.write("motion.csv", planar_recording(12.0));
    const std::string other = folder_.write("other.csv", planar_recording(10.0, 0.7, 1.2));
    for (const auto& [from, to, seed] : {std::tuple{motion, train_, "1"}, std::tuple{other, test_, "2"}}) {
      const ToolRun run = run_tool({"simulate", "planar-2r", "--trajectory", from, "-o", to, "--seed", seed, "--effect",
                                    "coulomb_friction:elbow:level=1", "--effect", "torque_offset:shoulder:offset=2", "--quiet"});
      ASSERT_EQ(run.status, 0) << run.err;
    }
  }

  // The result without the times that it took.
  json result_of(Words command, const std::string& threads) const {
    const std::string out = folder_.path("out.json");
    command = command + Words{"--train", train_, "--test", test_, "--threads", threads, "--json", out, "--quiet"};
    const ToolRun run = run_tool(command);
    EXPECT_EQ(run.status, 0) << run.err;
    return without_times(json_of(out));
  }

  TemporaryFolder folder_;
  const std::string train_ = folder_.path("train.csv"), test_ = folder_.path("test.csv");
};

void expect_alike(const json& a, const json& b, const std::string& where) {
  ASSERT_EQ(a.type(), b.type()) << where;
  if (a.is_number_float()) {
    const double x = a.get<double>(), y = b.get<double>();
    EXPECT_NEAR(x, y, 1e-10 * std::max(1.0, std::abs(x))) << where;
    return;
  }
  if (!a.is_structured()) {
    EXPECT_EQ(a, b) << where;
    return;
  }
  ASSERT_EQ(a.size(), b.size()) << where;
  for (const auto& [key, value] : a.items())
    expect_alike(value, a.is_object() ? b.at(key) : b.at(std::stoul(key)), where + "/" + key);
}

TEST_F(Repeated, RunsGiveTheSameResultToTheLastByte) {
  for (const char* command : {"identify", "diagnose"})
    EXPECT_EQ(result_of({command, "planar-2r"}, "2").dump(), result_of({command, "planar-2r"}, "2").dump()) << command;
}

TEST_F(Repeated, TheNumberOfThreadsChangesNoResult) {
  for (const char* command : {"identify", "diagnose"}) {
    const json one = result_of({command, "planar-2r"}, "1");
    if (std::string(command) == "diagnose") {
      std::set<std::string> causes;
      for (const json& f : one.at("findings")) causes.insert(f.at("cause").get<std::string>());
      // The fit without the change could raise the file's own friction level instead: the change is a finding nevertheless.
      EXPECT_EQ(causes, (std::set<std::string>{"coulomb_friction:elbow", "torque_offset:shoulder"})) << one.at("findings").dump(1);
    }
    for (const char* threads : {"2", "4"})
      expect_alike(one, result_of({command, "planar-2r"}, threads), std::string(command) + " --threads " + threads + ":");
  }
}

}  // namespace
}  // namespace veridyn
