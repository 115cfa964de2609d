#include <gtest/gtest.h>

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <string>

namespace {

namespace fs = std::filesystem;

// The layers of the house. What stands in a folder's set is what it may include beside itself:
//   math < model < kinematics < dynamics < effects < regressor,  model < recordings,
//   {regressor | recordings} < estimation < causes,
//   {identification < {diagnosis | comparison} | watch | excitation | simulation | control | calibration}
//     < cooperation < {dvrk | report} < cli.
const std::map<std::string, std::set<std::string>>& below() {
  static const std::map<std::string, std::set<std::string>> kBelow = [] {
    std::map<std::string, std::set<std::string>> all;
    std::set<std::string> sofar;
    for (const char* folder : {"math", "model"}) {
      all[folder] = sofar;
      sofar.insert(folder);
    }
    all["recordings"] = sofar;
    for (const char* folder : {"kinematics", "dynamics", "effects", "regressor"}) {
      all[folder] = sofar;
      sofar.insert(folder);
    }
    sofar.insert("recordings");
    all["estimation"] = sofar;
    sofar.insert("estimation");
    all["causes"] = sofar;
    sofar.insert("causes");
    for (const char* folder :
         {"identification", "excitation", "simulation", "control", "calibration", "watch"})
      all[folder] = sofar;
    for (const char* folder : {"diagnosis", "comparison", "export"}) {
      all[folder] = sofar;
      all[folder].insert("identification");
    }
    sofar.insert({"identification", "diagnosis", "comparison", "export", "excitation", "simulation",
                  "control", "calibration", "watch"});
    all["cooperation"] = sofar;
    sofar.insert("cooperation");
    all["dvrk"] = sofar;
    all["report"] = sofar;
    sofar.insert({"dvrk", "report"});
    all["cli"] = sofar;
    return all;
  }();
  return kBelow;
}

// The folder that a quoted include names: "veridyn/FOLDER/..." (public) or "FOLDER/..." (private);
// a bare file name is a neighbour in `own`.
std::string folder_of(const std::string& include, const std::string& own) {
  const std::string path = include.rfind("veridyn/", 0) == 0 ? include.substr(8) : include;
  const auto slash = path.find('/');
  return slash == std::string::npos ? own : path.substr(0, slash);
}

// Every include in a file that points up or across, one line each.
std::string wrong_includes(const fs::path& file, const std::string& own) {
  std::ifstream stream(file);
  std::ostringstream wrong;
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    if (line.rfind("#include \"", 0) != 0) continue;
    const std::string include = line.substr(10, line.find('"', 10) - 10);
    const std::string folder = folder_of(include, own);
    if (folder == own || below().at(own).count(folder) != 0) continue;
    wrong << file.string() << ":" << number << ": " << own << " includes " << include << "\n";
  }
  return wrong.str();
}

TEST(IncludeOrder, IncludesPointDownTheHouse) {
  const fs::path root = VERIDYN_SOURCE_DIR;
  int files = 0;
  for (const fs::path& top : {root / "include/veridyn", root / "src"}) {
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(top)) {
      const std::string extension = entry.path().extension();
      if (extension != ".hpp" && extension != ".cpp") continue;
      const std::string own = fs::relative(entry.path(), top).begin()->string();
      if (own == "veridyn.hpp" || own == "control.hpp") continue;  // faces include all
      ASSERT_EQ(below().count(own), 1U)
          << entry.path() << ": found a folder that has no place in the house";
      EXPECT_EQ(wrong_includes(entry.path(), own), "");
      ++files;
    }
  }
  EXPECT_GT(files, 50);
}

// The test itself notices an include that points up, and one that points across.
TEST(IncludeOrder, AWrongIncludeIsNoticed) {
  const fs::path file =
      fs::temp_directory_path() / ("veridyn_include_order_" + std::to_string(::getpid()) + ".hpp");
  std::ofstream(file) << "#include \"veridyn/effects/effect.hpp\"\n"
                         "#include \"veridyn/identification/recording.hpp\"\n"
                         "#include \"report/json/json_value.hpp\"\n";
  const std::string wrong = wrong_includes(file, "simulation");
  fs::remove(file);
  EXPECT_NE(wrong.find(":2: simulation includes veridyn/identification"), std::string::npos)
      << wrong;
  EXPECT_NE(wrong.find(":3: simulation includes report"), std::string::npos) << wrong;
  EXPECT_EQ(wrong.find(":1:"), std::string::npos) << wrong;
}

}  // namespace
