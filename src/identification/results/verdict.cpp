#include "veridyn/identification/verdict.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <ostream>

#include "effects/plain_friction.hpp"
#include "identification/identification_numbers.hpp"
#include "math/numbers.hpp"
#include "veridyn/regressor/standard_parameters.hpp"

namespace veridyn {
namespace {

double share_of_range(const Identification& id, const Coordinate& joint, size_t i) {
  double lowest = kInfinity, highest = -kInfinity;
  for (const CompressedRecording& r : id.factors) {
    if (i >= r.joints.size()) continue;
    lowest = std::min(lowest, r.joints[i].lowest);
    highest = std::max(highest, r.joints[i].highest);
  }
  const double range = joint.limits.upper - joint.limits.lower;
  return std::isfinite(range) && lowest <= highest ? (highest - lowest) / range : kNaN;
}

double share_of_speed(const Identification& id, const Coordinate& joint, size_t i) {
  double largest = 0.0;
  for (const CompressedRecording& r : id.factors) {
    if (i < r.joints.size()) largest = std::max(largest, r.joints[i].largest_speed);
  }
  return std::isfinite(joint.limits.velocity) ? largest / joint.limits.velocity : kNaN;
}

// Relative error of the joint's torque in a fit of its offset alone to the training recordings; infinite without one.
double error_of_constant(const Identification& id, size_t i) {
  const std::vector<StandardParameter> parameters = standard_parameters(*id.model);
  const std::vector<std::string> names = parameter_names(parameters);
  std::vector<std::string> offset;
  for (size_t j = 0; j < parameters.size(); ++j) {
    const EffectTerm* term = parameters[j].effect ? &id.model->effects()[static_cast<size_t>(*parameters[j].effect)] : nullptr;
    if (term != nullptr && term->effect == kPlainOffset && main_coordinate(term->axis) == JointIndex{static_cast<int>(i)}) offset = {names[j]};
  }
  double left2 = 0.0, torque2 = 0.0;
  for (const CompressedRecording& r : id.factors) {
    SquareRootInformation of_offset(offset);
    for (const auto& block : r.blocks) of_offset.merge(block[i].restricted(offset));
    left2 += of_offset.rho2();
    torque2 += of_offset.rhs_norm2();
  }
  return offset.empty() || !(torque2 > 0.0) ? kInfinity : std::sqrt(left2 / torque2);
}

bool rests_in_test(const Identification& id, const std::string& joint) {
  return std::find(id.still_in_test.begin(), id.still_in_test.end(), joint) != id.still_in_test.end();
}

IdentifiedState state_of(const Identification& id, const IdentifiedJoint& j) {
  if (j.range < identifying::numbers.hardly_moves && j.speed < identifying::numbers.hardly_moves) return IdentifiedState::kHardlyMoved;
  if (!std::isfinite(j.error)) return IdentifiedState::kNoTorque;
  if (!std::isfinite(j.floor) || rests_in_test(id, j.joint)) return IdentifiedState::kCannotTell;
  if (j.error > identifying::numbers.below_any_sensor && j.error > identifying::numbers.far_above_floor * j.floor) return IdentifiedState::kUnexplained;
  const bool follows = 2.0 * j.error * j.error < j.constant * j.constant;  // from the motion, more than half of it
  return follows ? IdentifiedState::kAtFloor : IdentifiedState::kCannotTell;
}

std::string two_digits(double value) { return value < 99.5 ? fmt::format("{:.2g}", value) : fmt::format("{:.0f}", value); }

std::string in_percent(double share) { return two_digits(100.0 * share) + " %"; }

std::vector<IdentifiedJoint> joints_in(const IdentificationVerdict& v, IdentifiedState state) {
  std::vector<IdentifiedJoint> out;
  std::copy_if(v.joints.begin(), v.joints.end(), std::back_inserter(out), [state](const IdentifiedJoint& j) { return j.state == state; });
  return out;
}

// "a, b and c VERB 2.1, 3 and 4 WHAT; " for several joints; {} stands for the figures.
std::string listed(const std::vector<IdentifiedJoint>& in, const char* one, const char* several, const std::string& what,
                   const std::function<std::string(const IdentifiedJoint&)>& figure) {
  if (in.empty()) return "";
  std::string names, figures;
  for (size_t k = 0; k < in.size(); ++k) {
    const std::string between = k == 0 ? "" : k + 1 == in.size() ? " and " : ", ";
    names += between + in[k].joint;
    figures += between + figure(in[k]);
  }
  return names + " " + (in.size() == 1 ? one : several) + " " +
         fmt::format(fmt::runtime(what), figures) + "; ";
}

// @param whose  describes the rows of the errors.
std::string sentence_of(const Identification& id, const IdentificationVerdict& v, const std::string& whose) {
  const auto error = [](const IdentifiedJoint& j) { return in_percent(j.error); };
  std::string out = listed(joints_in(v, IdentifiedState::kHardlyMoved), "moved", "moved",
                           "over {} of the range: record again with a motion of `veridyn excite`",
                           [](const IdentifiedJoint& j) { return in_percent(j.range); });
  out += listed(joints_in(v, IdentifiedState::kUnexplained), "leaves", "leave", "{} times the noise " + whose + ": `veridyn diagnose` asks why",
                [](const IdentifiedJoint& j) {
                  return j.error > identifying::kLargestRatio * j.floor ? fmt::format("over {:.0f}", identifying::kLargestRatio)
                                                                        : two_digits(j.error / j.floor);
                });
  out += listed(joints_in(v, IdentifiedState::kNoTorque), "has", "have", "no torque " + whose + ": it was not recorded, or nothing drove the joint",
                [](const IdentifiedJoint&) { return ""; });
  std::vector<IdentifiedJoint> quiet = joints_in(v, IdentifiedState::kAtFloor), loud;
  const auto first_loud = std::stable_partition(quiet.begin(), quiet.end(), [](const IdentifiedJoint& j) { return j.floor <= identifying::kLoud; });
  loud.assign(first_loud, quiet.end());
  quiet.erase(first_loud, quiet.end());
  const auto first_small =
      std::stable_partition(quiet.begin(), quiet.end(), [](const IdentifiedJoint& j) { return j.error <= identifying::numbers.far_above_floor * j.floor; });
  const std::vector<IdentifiedJoint> small(first_small, quiet.end());
  quiet.erase(first_small, quiet.end());
  out += listed(quiet, "is", "are", "at the noise (error {} " + whose + ")", error);
  out += listed(small, "leaves", "leave", "{} " + whose + ", more than the noise, less than most torque sensors resolve", error);
  out += listed(loud, "leaves", "leave",
                "{} " + whose + ", about what its repetitions differ by: `veridyn check` names noise, spikes and wrong times, `veridyn diagnose` asks what drifts", error);
  std::vector<IdentifiedJoint> resting = joints_in(v, IdentifiedState::kCannotTell);
  const auto first_moving = std::stable_partition(resting.begin(), resting.end(), [&id](const IdentifiedJoint& j) { return rests_in_test(id, j.joint); });
  const auto first_unknown = std::stable_partition(first_moving, resting.end(), [](const IdentifiedJoint& j) { return std::isfinite(j.floor); });
  const std::vector<IdentifiedJoint> constant(first_moving, first_unknown), unknown(first_unknown, resting.end());
  resting.erase(first_moving, resting.end());
  out += listed(constant, "leaves", "leave", "{} " + whose + ", and a constant torque hardly more: little of it follows from the motion", error);
  out += listed(resting, "hardly moves", "hardly move", "in the test recordings and leave {} there, dry friction included: a test on a motion judges friction and inertia", error);
  out += listed(unknown, "leaves", "leave",
                "{} " + whose + ", and as no motion is repeated, the noise is not known", error);
  out.erase(out.size() - std::min<size_t>(out.size(), 2));
  return out;
}

}  // namespace

const char* name_of(IdentifiedState state) {
  static constexpr const char* kNames[] = {"at_floor", "unexplained", "hardly_moved", "no_torque", "cannot_tell"};
  return kNames[static_cast<int>(state)];
}

std::string Identification::verdict() const { return model ? verdict_of(*this).sentence : reason; }

std::ostream& operator<<(std::ostream& out, const Identification& id) { return out << id.report(); }

const char* noise_floor_label(const Identification& id) {
  const VectorXd& error = (id.test_error.relative.size() > 0 ? id.test_error : id.train_error).relative;
  const bool floor = id.noise_floor.size() != error.size() || (id.noise_floor.array() <= error.array()).all();
  return floor ? "noise floor" : "repetitions differ by";
}

IdentificationVerdict verdict_of(const Identification& id) {
  IdentificationVerdict out;
  if (!id.model) return out;
  const bool tested = id.test_error.relative.size() > 0;
  out.held_out = tested && std::all_of(id.test.begin(), id.test.end(), [](const RecordingError& r) { return r.learned_from.empty(); });
  // Late rows are no error of the model.
  const VectorXd& repaired = (tested ? id.test_repaired : id.train_repaired).relative;
  const VectorXd& as_recorded = (tested ? id.test_error : id.train_error).relative;
  const VectorXd& error = repaired.size() > 0 ? repaired : as_recorded;
  bool is_another = false;  // differs in the printed digits
  const std::vector<Coordinate>& joints = id.model->coordinates();
  for (size_t i = 0; i < joints.size() && static_cast<Eigen::Index>(i) < error.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    IdentifiedJoint j;
    j.joint = joints[i].name;
    j.error = error[k];
    j.floor = k < id.noise_floor.size() ? std::min(id.noise_floor[k], j.error) : kNaN;
    j.constant = error_of_constant(id, i);
    j.range = share_of_range(id, joints[i], i);
    j.speed = share_of_speed(id, joints[i], i);
    j.state = state_of(id, j);
    is_another = is_another || in_percent(j.error) != in_percent(as_recorded[k]);
    out.joints.push_back(j);
  }
  out.sentence = sentence_of(id, out, std::string(out.held_out ? "held out" : tested ? "on rows that were learned from" : "on the training recordings") + (is_another ? ", late rows repaired" : ""));
  return out;
}

}  // namespace veridyn
