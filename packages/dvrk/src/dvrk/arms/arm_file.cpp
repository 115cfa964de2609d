#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "veridyn/files/input_file.hpp"
#include "veridyn/files/path_near_program.hpp"
#include "veridyn/math/rotation.hpp"
#include "veridyn/model/suggestion.hpp"
#include "veridyn/files/yaml/yaml_node.hpp"
#include "dvrk/arms/arm_facts.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::dvrk {
namespace {

namespace fs = std::filesystem;

// The flag under `key`; false if the key is missing.
bool read_flag(const YamlNode& node, const std::string& key) {
  const auto given = node.find(key);
  return given && given->flag();
}

// Whole number from `lower` to `upper`; fails at the node for others.
int read_integer(const YamlNode& node, int lower, int upper) {
  const double value = node.number();
  const std::string expected = text("a whole number from ", lower, " to ", upper);
  if (value != std::floor(value) || value < lower || value > upper)
    node.fail(node.found(), expected);
  return static_cast<int>(value);
}

void read_range(const YamlNode& node, double& lower, double& upper) {
  const YamlNode range = node.at("position");
  const std::vector<double> values = range.numbers(2, "two numbers [lower, upper]");
  lower = values[0];
  upper = values[1];
  if (!(lower < upper)) range.fail("a lower limit not below the upper one", "[lower, upper]");
}

// Square matrix from a list of rows.
MatrixXd read_square(const YamlNode& node) {
  const std::vector<YamlNode> rows = node.items("a list of rows");
  const auto n = static_cast<Eigen::Index>(rows.size());
  MatrixXd matrix(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const std::vector<double> row = rows[i].numbers(
        rows.size(), text(n, " numbers, as many as there are rows"));
    matrix.row(i) = Eigen::Map<const Eigen::RowVectorXd>(row.data(), n);
  }
  if (n == 0 || Eigen::FullPivLU<MatrixXd>(matrix).rank() < n)
    node.fail("a singular matrix", "one that can be inverted");
  return matrix;
}

ArmJoint read_joint(const YamlNode& node, DhConvention convention) {
  node.allow_keys({"name", "dh", "position", "velocity", "prismatic"});
  ArmJoint joint;
  joint.name = node.at("name").word("the joint's name");
  joint.prismatic = read_flag(node, "prismatic");
  if (const auto dh = node.find("dh")) {
    const std::vector<double> row = dh->numbers(4, "four numbers [a, alpha, d, theta]");
    joint.dh = DhRow{convention, row[0], row[1], row[2], row[3]};
  }
  read_range(node, joint.lower, joint.upper);
  if (const auto velocity = node.find("velocity")) joint.velocity = velocity->positive_number();
  return joint;
}

ArmActuator read_actuator(const YamlNode& node) {
  node.allow_keys({"name", "board", "axis", "counts", "gear", "torque_constant", "max_current",
                   "position", "kp", "kd", "pot", "prismatic"});
  ArmActuator actuator;
  actuator.name = node.at("name").word("the actuator's name");
  actuator.prismatic = read_flag(node, "prismatic");
  actuator.board = read_integer(node.at("board"), 0, 1);
  actuator.axis = read_integer(node.at("axis"), 0, 3);
  actuator.counts = node.at("counts").positive_number();
  actuator.gear = node.at("gear").positive_number();
  actuator.torque_constant = node.at("torque_constant").positive_number();
  actuator.max_current = node.at("max_current").positive_number();
  read_range(node, actuator.lower, actuator.upper);
  actuator.kp = node.at("kp").positive_number();
  actuator.kd = node.at("kd").positive_number();
  if (const auto pot = node.find("pot")) {
    const std::vector<double> scale = pot->numbers(2, "two numbers [per volt, at 0 V]");
    if (scale[0] == 0.0) pot->fail("the scale 0", "a number other than 0");
    actuator.pot = {scale[0], scale[1]};
  } else {
    actuator.pot = {(actuator.upper - actuator.lower) / 4.5, actuator.lower};
  }
  return actuator;
}

void read_brake(const YamlNode& node, const std::vector<int>& boards,
                std::vector<ArmActuator>& actuators) {
  node.allow_keys({"actuator", "board", "axis", "release", "release_time", "released", "engaged"});
  const int which = read_integer(node.at("actuator"), 0, static_cast<int>(actuators.size()) - 1);
  if (actuators[which].brake) node.at("actuator").fail(text("a second brake of actuator ", which), "one for each");
  BrakeConfig brake;
  brake.board = boards[read_integer(node.at("board"), 0, 1)];
  brake.axis = read_integer(node.at("axis"), 0, 3);
  brake.amps_to_bits = kNominalAmpsToBits;
  brake.bits_to_amps = kNominalBitsToAmps;
  brake.release_current = node.at("release").positive_number();
  brake.release_time = node.at("release_time").positive_number();
  brake.released_current = node.at("released").positive_number();
  brake.engaged_current = node.at("engaged").number();
  if (brake.released_current > brake.release_current || std::abs(brake.engaged_current) > brake.release_current)
    node.fail("a current above the one that releases", "currents up to it");
  brake.max_current = brake.release_current;
  actuators[which].brake = brake;
}

Eigen::Isometry3d read_tip(const YamlNode& node) {
  node.allow_keys({"position", "rotation"});
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  const std::vector<double> p = node.at("position").numbers(3, "three numbers [x, y, z]");
  T.translation() << p[0], p[1], p[2];
  const MatrixXd R = read_square(node.at("rotation"));
  if (!is_rotation(R, 1e-9)) node.at("rotation").fail("a matrix that is no rotation", "three rows of one");
  T.linear() = R;
  return T;
}

std::string content_of(const std::string& path) {
  return content_of_file(path, "the facts of an arm");
}

class ArmFile {
 public:
  explicit ArmFile(const std::string& path)
      : source_{path, {}, {}}, root_(YamlNode::parse(content_of(path), source_)) {
    root_.allow_keys({"dvrk_arm", "name", "unsure", "convention", "arms", "joints", "tip",
                      "actuators", "brakes", "coupling", "pots_to_actuators", "instruments"});
    if (root_.at("dvrk_arm").number() != 1.0) root_.at("dvrk_arm").fail("another version", "1");
  }

  std::vector<std::string> names() const {
    std::vector<std::string> all;
    for (const YamlNode& arm : root_.at("arms").items("a list of arms"))
      all.push_back(arm.at("name").word("the arm's name"));
    return all;
  }

  ArmFacts arm(const std::string& name) const {
    ArmFacts facts;
    facts.name = name;
    facts.kind = root_.at("name").word("the kind of arm");
    if (const auto unsure = root_.find("unsure"))
      for (const YamlNode& line : unsure->items("a list of remarks"))
        facts.unsure.push_back(line.word("a remark"));
    read_joints(facts);
    read_place(facts);
    if (const auto brakes = root_.find("brakes"))
      for (const YamlNode& brake : brakes->items("a list of brakes"))
        read_brake(brake, facts.boards, facts.actuators);
    read_couplings(facts);
    if (const auto tip = root_.find("tip")) facts.T_last_tip = read_tip(*tip);
    check_io_config(nominal_config(facts), source_.file);
    return facts;
  }

 private:
  void read_joints(ArmFacts& facts) const {
    const YamlNode convention = root_.at("convention");
    const std::string word = convention.word("standard or modified");
    if (word != "standard" && word != "modified")
      convention.fail("'" + word + "'", "standard or modified");
    const auto dh = word == "standard" ? DhConvention::kStandard : DhConvention::kModified;
    for (const YamlNode& joint : root_.at("joints").items("a list of joints"))
      facts.joints.push_back(read_joint(joint, dh));
    for (const YamlNode& actuator : root_.at("actuators").items("a list of actuators"))
      facts.actuators.push_back(read_actuator(actuator));
    if (facts.joints.size() != facts.actuators.size())
      root_.at("actuators")
          .fail(text(facts.actuators.size(), " actuators"),
                text(facts.joints.size(), ", as many as joints"));
  }

  void read_place(ArmFacts& facts) const {
    for (const YamlNode& arm : root_.at("arms").items("a list of arms")) {
      arm.allow_keys({"name", "boards", "directions"});
      if (arm.at("name").word("the arm's name") != facts.name) continue;
      for (const YamlNode& board : arm.at("boards").items("two board ids"))
        facts.boards.push_back(read_integer(board, 0, 15));
      if (facts.boards.size() != 2)
        arm.at("boards").fail(arm.at("boards").found(), "two board ids");
      const YamlNode list = arm.at("directions");
      const std::vector<double> directions =
          list.numbers(facts.actuators.size(), "1 or -1 for every actuator");
      for (std::size_t k = 0; k < directions.size(); ++k) {
        if (std::abs(directions[k]) != 1.0) list.fail(text(directions[k]), "1 or -1");
        facts.actuators[k].direction = directions[k];
      }
      return;
    }
    root_.at("arms").fail("no arm '" + facts.name + "'" + did_you_mean(facts.name, names()),
                          "one of: " + listed(names()));
  }

  void read_couplings(ArmFacts& facts) const {
    const auto n = static_cast<Eigen::Index>(facts.joints.size());
    facts.actuator_to_joint = MatrixXd::Identity(n, n);
    if (const auto coupling = root_.find("coupling")) facts.actuator_to_joint = sized(*coupling, n);
    if (const auto pots = root_.find("pots_to_actuators"))
      facts.pots_to_actuators = sized(*pots, n);
    const auto instruments = root_.find("instruments");
    if (!instruments) return;
    for (const YamlNode& node : instruments->items("a list of instruments")) {
      node.allow_keys({"name", "first", "coupling"});
      ArmInstrument instrument;
      instrument.name = node.at("name").word("the instrument's name");
      instrument.first = read_integer(node.at("first"), 0, static_cast<int>(n) - 1);
      instrument.coupling = sized(node.at("coupling"), n - instrument.first);
      facts.instruments.push_back(instrument);
    }
  }

  static MatrixXd sized(const YamlNode& node, Eigen::Index n) {
    MatrixXd matrix = read_square(node);
    if (matrix.rows() != n) node.fail(text("a matrix of ", matrix.rows(), " rows"), text(n));
    return matrix;
  }

  YamlSource source_;
  YamlNode root_;
};

// YAML files of the first folder that has any: $VERIDYN_DVRK, the sources, the installation, near the program.
std::vector<fs::path> arm_files() {
  std::vector<fs::path> files;
  std::vector<fs::path> folders;
  if (const char* own = std::getenv("VERIDYN_DVRK")) folders.emplace_back(own);
#ifdef VERIDYN_DVRK_SOURCE_DIR
  folders.emplace_back(VERIDYN_DVRK_SOURCE_DIR);
#endif
#ifdef VERIDYN_DVRK_INSTALL_DIR
  folders.emplace_back(VERIDYN_DVRK_INSTALL_DIR);
#endif
  folders.emplace_back(path_near_program("share/veridyn/dvrk"));
  std::error_code ignored;
  for (const fs::path& folder : folders) {
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored))
      if (entry.path().extension() == ".yaml") files.push_back(entry.path());
    if (!files.empty()) break;  // the first folder that has arms
  }
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

ArmFacts read_arm(const std::string& name) {
  const auto colon = name.rfind(".yaml:");
  if (colon != std::string::npos)
    return ArmFile(name.substr(0, colon + 5)).arm(name.substr(colon + 6));
  for (const fs::path& path : arm_files()) {
    const ArmFile file(path.string());
    for (const std::string& known : file.names())
      if (known == name) return file.arm(name);
  }
  const std::vector<std::string> known = arm_names();
  throw InvalidInput(text("found no dVRK arm '", name, "'", did_you_mean(name, known),
                          ", expected one of: ", listed(known), "."));
}

std::vector<std::string> arm_names() {
  std::vector<std::string> names;
  for (const fs::path& path : arm_files())
    for (const std::string& name : ArmFile(path.string()).names()) names.push_back(name);
  return names;
}

}  // namespace veridyn::dvrk
