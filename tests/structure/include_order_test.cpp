#include <gtest/gtest.h>

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

// The layers of the house. What stands in a folder's set is what it may include beside itself:
//   math < model < kinematics < dynamics < effects < {regressor | files},  {model | files} < recordings,
//   {regressor | recordings} < identification < {diagnosis | excitation},  {regressor | recordings} < control < simulation,
//   all of these < report < tool < cli.
// Packages stand on its public headers.
const std::map<std::string, std::set<std::string>>& below() {
  static const std::map<std::string, std::set<std::string>> kBelow = [] {
    std::map<std::string, std::set<std::string>> all;
    std::set<std::string> sofar;
    for (const char* folder : {"math", "model", "kinematics", "dynamics", "effects"}) {
      all[folder] = sofar;
      sofar.insert(folder);
    }
    all["regressor"] = all["files"] = sofar;
    all["recordings"] = {"math", "model", "files"};
    sofar.insert({"regressor", "files", "recordings"});
    all["identification"] = all["control"] = all["simulation"] = all["diagnosis"] = all["excitation"] = sofar;
    all["control"].insert("c");  // the header of the controller for programs in C
    all["simulation"].insert("control");
    all["diagnosis"].insert("identification");
    all["excitation"].insert("identification");
    sofar.insert({"identification", "diagnosis", "excitation", "control", "simulation"});
    for (const char* folder : {"report", "tool", "cli"}) {
      all[folder] = sofar;
      sofar.insert(folder);
    }
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

TEST(IncludeOrder, EveryIncludePointsToALowerLayer) {
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

// Packages and the packages that each stands on.
const std::map<std::string, std::set<std::string>> kPackages = {
    {"dvrk", {}}, {"calibration", {}}, {"cooperation", {"dvrk"}}};

// Every include of a package's file that is neither a public header of the library or of a package below nor a file of the package.
std::string foreign_includes(const fs::path& file, const std::string& package) {
  const fs::path root = VERIDYN_SOURCE_DIR;
  std::vector<fs::path> places = {root / "include", file.parent_path()};
  for (const char* folder : {"include", "include/veridyn", "src"}) places.push_back(root / "packages" / package / folder);
  for (const std::string& below : kPackages.at(package)) places.push_back(root / "packages" / below / "include");
  std::ifstream stream(file);
  std::ostringstream wrong;
  for (std::string line; std::getline(stream, line);) {
    if (line.rfind("#include \"", 0) != 0) continue;
    const std::string include = line.substr(10, line.find('"', 10) - 10);
    const bool found = std::any_of(places.begin(), places.end(), [&](const fs::path& place) { return fs::exists(place / include); });
    if (!found) wrong << file.string() << ": " << package << " includes " << include << "\n";
  }
  return wrong.str();
}

TEST(IncludeOrder, PackagesIncludePublicHeadersAlone) {
  const fs::path root = fs::path(VERIDYN_SOURCE_DIR) / "packages";
  int files = 0;
  for (const auto& [package, stands_on] : kPackages) {
    for (const char* folder : {"include", "src"}) {
      for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root / package / folder)) {
        const std::string extension = entry.path().extension();
        if (extension != ".hpp" && extension != ".cpp") continue;
        EXPECT_EQ(foreign_includes(entry.path(), package), "");
        ++files;
      }
    }
  }
  EXPECT_GT(files, 150);
}

// A private header of the library, and one of a package that stands above, are noticed.
TEST(IncludeOrder, AForeignIncludeOfAPackageIsDetected) {
  const fs::path file = fs::temp_directory_path() / ("veridyn_package_" + std::to_string(::getpid()) + ".hpp");
  std::ofstream(file) << "#include \"veridyn/files/words.hpp\"\n"
                         "#include \"math/digits.hpp\"\n"
                         "#include \"dvrk/protocol/udp_port.hpp\"\n"
                         "#include \"cooperation/experiment.hpp\"\n";
  const std::string above = foreign_includes(file, "calibration"), wrong = foreign_includes(file, "dvrk");
  fs::remove(file);
  EXPECT_NE(above.find("dvrk/protocol/udp_port.hpp"), std::string::npos) << above;
  EXPECT_NE(wrong.find("math/digits.hpp"), std::string::npos) << wrong;
  EXPECT_NE(wrong.find("cooperation/experiment.hpp"), std::string::npos) << wrong;
  EXPECT_EQ(wrong.find("files/words.hpp"), std::string::npos) << wrong;
}

// Parts of rooms and what each includes of its own room. A room's public headers are a part, and so
// is what lies beside its folders.
using Parts = std::map<std::string, std::set<std::string>>;

void add_includes(const fs::path& file, const std::string& own, Parts& parts) {
  std::ifstream stream(file);
  const std::string room = own.substr(0, own.find('/'));
  for (std::string line; std::getline(stream, line);) {
    if (line.rfind("#include \"", 0) != 0) continue;
    const std::string include = line.substr(10, line.find('"', 10) - 10);
    const bool in_public = include.rfind("veridyn/", 0) == 0;
    const std::string path = in_public ? include.substr(8) : include;
    if (path.rfind('/') == std::string::npos || folder_of(include, own) != room) continue;
    const std::string folder = path.substr(0, path.rfind('/'));
    const std::string part = in_public && folder == room ? room + "/(public)" : folder;
    if (part != own) parts[own].insert(part);
  }
}

// What a part includes, and what that includes.
std::set<std::string> reached_from(const std::string& part, const Parts& parts) {
  std::set<std::string> out;
  std::set<std::string> next = {part};
  while (!next.empty()) {
    const std::string one = *next.begin();
    next.erase(next.begin());
    const auto below = parts.find(one);
    if (below == parts.end()) continue;
    for (const std::string& other : below->second)
      if (out.insert(other).second) next.insert(other);
  }
  return out;
}

std::string parts_in_circles(const Parts& parts) {
  std::string out;
  for (const auto& [part, includes] : parts)
    if (reached_from(part, parts).count(part) != 0) out += part + "\n";
  return out;
}

TEST(IncludeOrder, PartsOfAFolderIncludeEachOtherWithoutCycles) {
  const fs::path root = VERIDYN_SOURCE_DIR;
  Parts parts;
  for (const fs::path& top : {root / "include/veridyn", root / "src"}) {
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(top)) {
      const std::string extension = entry.path().extension();
      const std::string folder = fs::relative(entry.path().parent_path(), top).generic_string();
      if ((extension != ".hpp" && extension != ".cpp") || folder == ".") continue;
      const bool face = top != root / "src" && folder.find('/') == std::string::npos;
      add_includes(entry.path(), face ? folder + "/(public)" : folder, parts);
    }
  }
  EXPECT_GT(parts.size(), 20U);
  EXPECT_EQ(parts_in_circles(parts), "");
}

TEST(IncludeOrder, ACycleOfPartsIsDetected) {
  const Parts parts = {{"a", {"a/low"}}, {"a/low", {"a/(public)"}}, {"a/x", {"a/y"}}, {"a/y", {"a/low", "a/x"}}};
  EXPECT_EQ(parts_in_circles(parts), "a/x\na/y\n");
}

// The test itself notices an include that points up, and one that points across.
TEST(IncludeOrder, AnUpwardIncludeIsDetected) {
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
