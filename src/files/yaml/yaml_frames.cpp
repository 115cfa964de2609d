#include "files/yaml/yaml_frames.hpp"

#include <cmath>

#include "veridyn/math/require.hpp"
#include "model/joint_placement.hpp"
#include "model/suggestion.hpp"
#include "files/yaml/yaml_axis.hpp"
#include "files/yaml/yaml_body.hpp"

namespace veridyn {
namespace {

Vec3d read_vector(const YamlNode& node) {
  const std::vector<double> v = node.numbers(3, "three numbers");
  return {v[0], v[1], v[2]};
}

Vec3d read_direction(const YamlNode& node) {
  const Vec3d v = read_vector(node);
  const double length = std::sqrt(dot(v, v));
  if (!(length > 0.0)) node.fail("an axis of length zero", "a direction");
  return {v.x / length, v.y / length, v.z / length};
}

class FrameReader {
 public:
  FrameReader(const std::vector<std::string>& coordinates,
              const std::optional<DhConvention>& convention)
      : coordinates_(coordinates), convention_(convention) {}

  std::vector<Frame> read(const std::vector<YamlNode>& nodes) {
    for (const YamlNode& node : nodes) {
      node.allow_keys({"name", "parent", "convention", "dh", "origin", "axis", "tip", "offset",
                       "revolute", "prismatic", "body"});
      const YamlNode name = node.at("name");
      const std::string word = name.word("the frame's name");
      if (word == "world")
        name.fail("a frame called 'world'", "another name; the world is there already");
      if (index_of(names_, word) >= 0) name.fail("a second frame '" + word + "'", "unique names");
      names_.push_back(word);
      parents_.push_back(node.at("parent").word("the parent's name, or world"));
    }
    std::vector<Frame> frames;
    for (std::size_t k = 0; k < nodes.size(); ++k) {
      frames.push_back(read_frame(nodes[k].with_path("frames/" + names_[k]), static_cast<int>(k)));
    }
    return frames;
  }

 private:
  Frame read_frame(const YamlNode& node, int k) const {
    Frame frame;
    frame.name = names_[k];
    frame.parent = parent_index(node.at("parent"), k);
    frame.variable.coefficients = VectorXd::Zero(coordinates_.size());
    read_joint(node, frame);
    if (const auto dh = node.find("dh")) {
      place_by_row(node, *dh, frame);
    } else {
      place_by_origin(node, frame);
    }
    if (const auto body = node.find("body")) frame.body = read_body(*body);
    return frame;
  }

  std::optional<FrameIndex> parent_index(const YamlNode& node, int k) const {
    const std::string& parent = parents_[k];
    if (parent == "world") return std::nullopt;
    const int p = index_of(names_, parent);
    if (p >= 0 && p < k) return FrameIndex{p};
    if (p < 0) {
      std::vector<std::string> known = names_;
      known.insert(known.begin(), "world");
      node.fail("the unknown parent '" + parent + "'" + did_you_mean(parent, known),
                "world or a frame above");
    }
    const std::string cycle = cycle_through(k);
    if (!cycle.empty()) node.fail("a cycle of parents (" + cycle + ")", "a tree");
    node.fail("the parent '" + parent + "', which stands after its child '" +
                  names_[k] + "'",
              "parents before children");
  }

  // The text "a -> b -> a" if the parents of frame k form a cycle.
  std::string cycle_through(int k) const {
    std::string path = names_[k];
    int at = k;
    for (std::size_t step = 0; step < names_.size(); ++step) {
      const std::string& parent = parents_[at];
      at = index_of(names_, parent);
      if (at < 0) return "";
      path += " -> " + parent;
      if (at == k) return path;
    }
    return "";
  }

  void read_joint(const YamlNode& node, Frame& frame) const {
    const auto turns = node.find("revolute");
    const auto slides = node.find("prismatic");
    if (turns && slides)
      slides->fail("both revolute and prismatic", "one of them, or none for a fixed frame");
    if (!turns && !slides) return;
    frame.type = turns ? JointType::kRevolute : JointType::kPrismatic;
    frame.variable = read_axis(turns ? *turns : *slides, coordinates_);
  }

  void place_by_row(const YamlNode& node, const YamlNode& row, Frame& frame) const {
    for (const char* other : {"origin", "axis", "tip", "offset"}) {
      if (const auto clash = node.find(other))
        clash->fail(text("both dh and ", other), "one way to place a frame");
    }
    const std::vector<double> v = row.numbers(4, "four numbers [a, alpha, d, theta]");
    const auto convention = node.find("convention");
    if (!convention && !convention_) {
      node.fail("a dh row without convention",
                "convention: standard | modified, here or for the whole file");
    }
    place(frame,
          DhRow{convention ? read_convention(*convention) : *convention_, v[0], v[1], v[2], v[3]});
  }

  static void place_by_origin(const YamlNode& node, Frame& frame) {
    if (const auto convention = node.find("convention"))
      convention->fail("a convention without dh", "a dh row");
    const auto origin = node.find("origin");
    if (!origin) node.fail("neither dh nor origin", "one of them to place the frame");
    origin->allow_keys({"xyz", "rpy"});
    JointPlacement placement;
    if (const auto xyz = origin->find("xyz")) placement.origin.p = read_vector(*xyz);
    if (const auto rpy = origin->find("rpy"))
      placement.origin.R = rotation_from_rpy(read_vector(*rpy));
    if (const auto axis = node.find("axis")) placement.axis = read_direction(*axis);
    if (const auto tip = node.find("tip")) placement.tip = read_vector(*tip);
    if (const auto offset = node.find("offset")) {
      if (frame.type == JointType::kFixed)
        offset->fail("an offset of a fixed frame", "revolute or prismatic");
      frame.variable.offset = offset->number();
    }
    place(frame, placement);
  }

  const std::vector<std::string>& coordinates_;
  const std::optional<DhConvention>& convention_;
  std::vector<std::string> names_;
  std::vector<std::string> parents_;
};

}  // namespace

DhConvention read_convention(const YamlNode& node) {
  const std::string name = node.word("standard or modified");
  if (name != "standard" && name != "modified") {
    node.fail(node.found() + did_you_mean(name, {"standard", "modified"}), "standard or modified");
  }
  return name == "standard" ? DhConvention::kStandard : DhConvention::kModified;
}

std::vector<Frame> read_frames(const YamlNode& list, const std::vector<std::string>& coordinates,
                               const std::optional<DhConvention>& convention) {
  return FrameReader(coordinates, convention).read(list.items("a list of frames"));
}

}  // namespace veridyn
