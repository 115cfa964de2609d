#pragma once

#include <string>
#include <vector>

#include "calibration/closed_forms.hpp"
#include "veridyn/effects/cause.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn::internal {

/// One number in the placement of a frame.
struct LinkEntry {
  FrameConstant constant;
  double value = 0.0;   ///< value in the file
  std::string formula;  ///< expression in the file; empty: a plain number
};

/// One unknown of a calibration; its value is added to that of the file.
struct LinkParameter {
  enum class Kind { kConstant, kEntry, kZero, kBase, kTool };
  Kind kind = Kind::kEntry;
  int index = 0;  ///< entry, coordinate, or component of a pose (rotation 0..2, translation 3..5)
  std::string name, frame, unit;
  double file = 0.0;
  bool is_angle() const { return unit == "rad"; }
  std::string full_name() const { return frame.empty() ? name : name + " of " + frame; }
};

/// The numbers of a robot file between its base and one frame.
class LinkParameters {
 public:
  /// @param base_free, tool_free  the pose is unknown. @param oriented  false: only the tool's position is.
  LinkParameters(const Model& arm, FrameIndex frame, bool base_free, bool tool_free, bool oriented);

  const Model& arm() const { return arm_; }
  const std::vector<int>& path() const { return path_; }  ///< frames, base first
  const std::vector<LinkEntry>& entries() const { return entries_; }
  const std::vector<LinkParameter>& all() const { return all_; }
  int size() const { return static_cast<int>(all_.size()); }

  /// Values of the entries, and their derivatives by each named constant (entries x all parameters;
  /// zero elsewhere), at the parameters x.
  void evaluate(const VectorRef& x, VectorXd& values, MatrixXd* by_constant) const;

  /// The arm with the parameters x, without the statistics of its identification.
  Model arm_with(const VectorRef& x) const;

 private:
  void collect_entries();
  void collect_parameters(bool base_free, bool tool_free, bool oriented);
  std::map<std::string, double> constants(const VectorRef& x) const;
  double entry_value(const LinkEntry& entry, const std::map<std::string, double>& c) const;

  const Model& arm_;
  std::vector<int> path_;
  std::vector<LinkEntry> entries_;
  std::vector<LinkParameter> all_;
};

}  // namespace veridyn::internal
