#include "identification/check/questions.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <numeric>
#include <sstream>
#include <utility>

#include "identification/check/check_thresholds.hpp"
#include "math/median.hpp"
#include "recordings/signals/units.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/recordings/preprocessing.hpp"

namespace veridyn {
namespace {

using Names = std::vector<std::string>;
constexpr const char* kSignals[] = {"q", "dq", "ddq", "tau", "i"};

std::string joined(const std::string& a, const std::string& b) { return a.empty() || b.empty() ? a + b : a + "," + b; }

// Splits "q1=deg,tau=Nm" into pairs of signal and unit.
std::vector<std::pair<std::string, std::string>> assignments(const std::string& list) {
  std::vector<std::pair<std::string, std::string>> out;
  std::istringstream words(list);
  for (std::string word; std::getline(words, word, ',');) out.emplace_back(word.substr(0, word.find('=')), word.substr(word.find('=') + 1));
  return out;
}

// The columns of this signal; for currents those of the torques, to which they have been converted.
MatrixXd* columns_of(const std::string& signal, Recording& r) {
  for (const auto& [name, values] : {std::pair{"q", &r.q}, std::pair{"dq", &r.dq}, std::pair{"ddq", &r.ddq}, std::pair{"tau", &r.tau}, std::pair{"i", &r.tau}}) {
    if (signal == name) return values->size() > 0 ? values : nullptr;
  }
  return nullptr;
}

// Splits "tau3" into the signal and the joint (from 0).
std::pair<std::string, int> column(const std::string& key) {
  const std::size_t digits = key.find_last_not_of("0123456789") + 1;
  return {key.substr(0, digits), digits < key.size() ? std::stoi(key.substr(digits)) - 1 : -1};
}

// The scales that --units applies to a signal.
std::vector<recordings::UnitScale> scales_of(const std::string& signal, const std::string& units, const Model& arm) {
  SignalChoice choice;
  choice.joints = joints_of(arm);
  for (const auto& [key, unit] : assignments(units)) choice.units[key] = unit;
  std::vector<recordings::UnitScale> out;
  for (int i = 0; i < arm.joints(); ++i) {
    out.push_back(recordings::scale_for(choice, signal, i + 1));
    const double gain = arm.coordinates()[i].drive_gain;
    if (signal == "tau" && gain > 0.0 && recordings::is_current_unit(recordings::unit_of(choice, signal, i + 1))) out.back().factor *= gain;
  }
  return out;
}

// True for rows in which all joints are at rest for some time.
std::vector<char> rows_at_rest(const Recording& r) {
  std::vector<char> out(static_cast<std::size_t>(r.rows()), 0);
  for (int first = 0, k = 1; k <= r.rows(); ++k) {
    const bool rests = k < r.rows() && ((r.q.row(k) - r.q.row(first)).array().abs() <= checking::kAtRest * checking::kLongRest).all();
    if (rests) continue;
    if (r.time[k - 1] - r.time[first] >= checking::kLongRest) std::fill(out.begin() + first, out.begin() + k, 1);
    first = k;
  }
  return out;
}

// A hypothesis with a fitted number; neighbours() gives the same hypothesis with nearby numbers.
RecordingQuestion numbered(RecordingQuestion q, double distance, std::function<std::vector<RecordingQuestion>(double)> neighbours) {
  q.price = checking::kFittedNumberCost;
  q.first_distance = distance;
  q.neighbours = std::move(neighbours);
  return q;
}

// The hypothesis that positions of all joints, or of the joint with this name, were measured on the motor side of a gear.
RecordingQuestion before_the_gear(double ratio, bool velocity, std::optional<JointIndex> joint = {}, const std::string& name = "") {
  const double whole = std::round(ratio);
  const std::string words = fmt::format("{:.4g}", std::abs(ratio / whole - 1.0) < checking::kWholeRatio ? whole : ratio);
  const std::string unit = fmt::format("{}={:.5g}", joint ? std::to_string(joint->value + 1) : "", 1.0 / std::stod(words));
  return numbered({QualityKind::kMotorSide, joint, {},
                   (joint ? "The position of " + name + " is that of its motor, in front of a gear of about " : "Positions are those of the motors, in front of gears of about ") + words,
                   "q" + unit + (velocity ? ",dq" + unit : "")},
                  checking::kRatioStep, [=](double distance) {
                    return std::vector<RecordingQuestion>{before_the_gear(ratio * (1.0 + distance), velocity, joint, name), before_the_gear(ratio / (1.0 + distance), velocity, joint, name)};
                  });
}

// The hypothesis that the joint has this angle where the robot file has zero.
RecordingQuestion zero_at(double zero, JointIndex joint, const std::string& name) {
  const std::string words = fmt::format("{:.4g}", zero);
  return numbered({QualityKind::kEncoderZero, joint, {}, text("The position of ", name, " is counted from another zero, which lies at ", words, " rad"), text("q", joint.value + 1, "=rad@", words)},
                  checking::kZeroStep, [=](double distance) {
                    return std::vector<RecordingQuestion>{zero_at(zero + distance, joint, name), zero_at(zero - distance, joint, name)};
                  });
}

// The hypothesis that torques of all joints, or of the joint with this name, were measured
// `late` seconds after the motion, and `later` seconds at the end of a recording of this length.
RecordingQuestion torques_late(double late, double later, double length, std::optional<JointIndex> joint = {}, const std::string& name = "") {
  const auto when = [](double by) { return fmt::format("{:.0f} ms {} the motion", 1e3 * std::abs(by), by < 0.0 ? "before" : "after"); };
  const bool drifts = late != later;
  RecordingQuestion q{drifts ? QualityKind::kTorqueClock : QualityKind::kTorqueDelay, joint, {}, joint ? "The torque of " + name + " was measured " : "The torques were measured "};
  q.what += drifts ? fmt::format("by another clock, {} at the start and {} at the end", when(late), when(later)) : when(late);
  q.is_cause = !drifts;
  q.other = drifts ? "one clock for both" : fmt::format("a torque {:.0f} ms {}", 1e3 * std::abs(late), late < 0.0 ? "later" : "earlier");
  q.rows = [late, joint, drift = (later - late) / length](Recording& r) {
    const VectorXd& t = r.time;
    const MatrixXd tau = r.tau;
    for (Eigen::Index k = 0; k < r.rows(); ++k) {
      const double at = t[k] + late + drift * (t[k] - t[0]);
      const Eigen::Index next = std::upper_bound(t.begin(), t.end(), at) - t.begin();
      const bool inside = next > 0 && next < r.rows();
      const double share = inside ? (at - t[next - 1]) / (t[next] - t[next - 1]) : 0.0;
      for (Eigen::Index i = joint ? joint->value : 0; i <= (joint ? joint->value : tau.cols() - 1); ++i)
        r.tau(k, i) = inside ? (1.0 - share) * tau(next - 1, i) + share * tau(next, i) : std::nan("");
    }
  };
  q = numbered(std::move(q), checking::kDelays[0], [=](double distance) {
    std::vector<RecordingQuestion> out;
    for (const double d : {distance, -distance}) {
      out.push_back(torques_late(late + d, drifts ? later : later + d, length, joint, name));
      if (drifts) out.push_back(torques_late(late, later + d, length, joint, name));
    }
    return out;
  });
  if (drifts) q.price *= 2.0;
  return q;
}

// The hypothesis that torques passed a filter y += (1 - a) (x - y) with this time constant [s].
RecordingQuestion torques_filtered(double constant) {
  RecordingQuestion q{QualityKind::kTorqueFilter, {}, {}, fmt::format("The torques passed a low-pass of about {:.2g} Hz", 0.5 / (M_PI * constant))};
  q.other = "recording them without it";
  q.rows = [constant](Recording& r) {
    const MatrixXd tau = r.tau;
    for (Eigen::Index k = 1; k < tau.rows(); ++k) r.tau.row(k) += (tau.row(k) - tau.row(k - 1)) / std::expm1((r.time[k] - r.time[k - 1]) / constant);
  };
  return numbered(std::move(q), checking::kFactorStep, [=](double distance) {
    return std::vector<RecordingQuestion>{torques_filtered(constant * (1.0 + distance)), torques_filtered(constant / (1.0 + distance))};
  });
}

// The part of a recording, before or after a moment [s], that does not fit the rest.
enum class Part { kBefore, kAfter };
// @param moment  [s] since the recording began.
RecordingQuestion without_rows(Part part, double moment, const VectorXd& time) {
  const long row = std::lower_bound(time.begin(), time.end(), time[0] + moment) - time.begin();
  const bool after = part == Part::kAfter;
  const double length = time[time.size() - 1] - time[0];
  RecordingQuestion q{QualityKind::kChangedMidway, {}, {}, fmt::format("Something {} {:.3g} s does not fit with the rows {}, as a push, a load, an offset, an encoder that slipped or a sensor that failed",
                                                         after ? "after" : "before", moment, after ? "before" : "after")};
  q.other = after ? fmt::format("--rows 0:{}", row) : fmt::format("--rows {}:", row);
  q.rows = [after, moment](Recording& changed) {
    for (Eigen::Index k = 0; k < changed.rows(); ++k) {
      if ((changed.time[k] - changed.time[0] > moment) == after) changed.tau.row(k).setConstant(std::nan(""));
    }
  };
  q = numbered(std::move(q), 0.0, [=](double distance) {
    const double other = after ? moment + distance : moment - distance;
    const double kept = after ? length - other : other;
    return 3.0 * kept < length ? std::vector<RecordingQuestion>() : std::vector<RecordingQuestion>{without_rows(after ? Part::kBefore : Part::kAfter, other, time)};
  });
  q.price += checking::kExcludedRowsCost * static_cast<double>(after ? time.size() - row : row) / static_cast<double>(time.size());
  return q;
}

// Units that the signals of all joints may have instead of SI.
struct Unit {
  QualityKind kind;
  const char* what;
  const char* q;
  const char* dq;
};
constexpr Unit kAngles[] = {{QualityKind::kDegrees, "Positions and velocities are degrees", "deg", "deg/s"},
                            {QualityKind::kDegrees, "Velocities are degrees per second", "", "deg/s"},
                            {QualityKind::kDegrees, "Positions are degrees", "deg", ""},
                            {QualityKind::kTurns, "Positions are turns", "rev", ""},
                            {QualityKind::kTurns, "Positions are turns, and velocities turns a minute", "rev", "rpm"},
                            {QualityKind::kTurns, "Velocities are turns a minute", "", "rpm"}};
constexpr Unit kShares[] = {{QualityKind::kShareOfRange, "Positions are shares of the range, -100 to 100", "%", ""},
                            {QualityKind::kShareOfRange, "Positions and velocities are shares of the range, -100 to 100", "%", "%"}};

class List {
 public:
  List(const Model& arm, const Recording& r, const SignalChoice& given, const std::vector<bool>& moves, const QuickFit& fit)
      : arm_(arm), r_(r), given_(given), torque_(r.current.size() > 0 ? "i" : "tau"), moves_(moves), shares_(fit.shares), joints_(joints_of(arm)), motion_{"q"} {
    for (const Coordinate& c : arm.coordinates()) turning_ = turning_ || !c.prismatic, sliding_ = sliding_ || c.prismatic;
    if (r.dq.size() > 0) motion_.emplace_back("dq");
    if (r.ddq.size() > 0) motion_.emplace_back("ddq");
    all_ = motion_;
    all_.push_back(torque_);
  }

  std::vector<RecordingQuestion> all(const QuickFit& fit) {
    add_given_units();
    add_signs();
    if (sliding_) add_millimetres();
    if (turning_) add_angle_units();
    if (torque_ == "tau") add_torque_units();
    if (torque_ == "tau" && fit.moments != nullptr) add_torque_factors(fit);
    add_brakes();
    add_clocks();
    add_exchanges();
    add_gravity_directions();
    add_dh_convention();
    return std::move(out_);
  }

 private:
  int joints() const { return arm_.joints(); }
  bool slides(int i) const { return joints_[i].prismatic; }
  bool is_badly_explained(int i) const { return moves_[i] && std::sqrt(shares_[i]) > checking::kPoorFit; }
  std::string joint_name(int i) const { return text("joint ", i + 1, " (", arm_.coordinates()[i].name, ")"); }
  bool has_velocity() const { return r_.dq.size() > 0; }

  RecordingQuestion& add(QualityKind kind, std::optional<JointIndex> joint, const std::string& what, const std::string& units) {
    out_.push_back({kind, joint, {}, what, units});
    return out_.back();
  }

  // Units with reversed signs for joint i: "q3=-rad,dq3=-rad/s".
  std::string reversed(const Names& signals, int i) const {
    std::string out;
    for (const std::string& s : signals) {
      const std::string unit = s == "i" ? "A" : s == "tau" ? (slides(i) ? "N" : "Nm") : (slides(i) ? "m" : "rad") + std::string(s == "dq" ? "/s" : s == "ddq" ? "/s2" : "");
      out = joined(out, text(s, i + 1, "=-", unit));
    }
    return out;
  }

  // Tests whether given units are wrong, and the signals in SI.
  void add_given_units() {
    std::string of_motion, signals;
    for (const std::string& signal : all_) {
      const std::string units = without_given(signal);
      if (!units.empty()) add(QualityKind::kGivenUnit, {}, "the unit of " + signal + " is not that of the recording", units);
      if (units.empty() || signal == torque_) continue;
      of_motion = joined(of_motion, units);
      signals += (signals.empty() ? "" : " and ") + signal;
    }
    if (signals.find(' ') != std::string::npos) add(QualityKind::kGivenUnit, {}, "the units of " + signals + " are not those of the recording", of_motion);
  }

  // Units that turn a signal back into the numbers of the file; empty: it was read as it is.
  std::string without_given(const std::string& signal) const {
    std::string out;
    SignalChoice given = given_;
    given.joints = joints_;
    for (int i = 0; i < joints(); ++i) {
      const recordings::UnitScale scale = recordings::scale_for(given, signal, i + 1);
      if (scale.direction_bit) return "";
      if (scale.changes_nothing()) continue;
      out = joined(out, fmt::format("{}{}={:.17g}", signal, i + 1, 1.0 / scale.factor));
      if (scale.zero != 0.0) out += fmt::format("@{:.17g}", -scale.factor * scale.zero);
    }
    return out;
  }

  void add_signs() {
    for (int i = 0; i < joints(); ++i) {
      if (moves_[i]) add(QualityKind::kTorqueSign, JointIndex{i}, "The torque of " + joint_name(i) + " has the wrong sign", reversed({torque_}, i));
      if (!is_badly_explained(i)) continue;
      add(QualityKind::kPositionSign, JointIndex{i}, "The position of " + joint_name(i) + " is counted the other way round", reversed(motion_, i)).price = checking::kPositionSignCost;
      add(QualityKind::kPositionSign, JointIndex{i}, "Position and torque of " + joint_name(i) + " are counted the other way round", reversed(all_, i)).price = checking::kPositionSignCost;
    }
    if (joints() > 1) add(QualityKind::kTorqueSign, {}, "All torques have the wrong sign", torque_ + (torque_ == "i" ? "=-A" : "=-Nm"));
  }

  // Adds the hypothesis that positions and velocities of all joints are in another unit. Velocities are
  // derived again if the file has none in the new unit.
  void add_unit(QualityKind kind, const std::string& what, const std::string& q, const std::string& dq) {
    if (!dq.empty() && !has_velocity()) return;
    const std::string units = joined(q.empty() ? "" : "q=" + q, dq.empty() ? "" : "dq=" + dq);
    const auto scales = scales_of("q", units, arm_);
    for (int i = 0; i < r_.joints() && !q.empty() && kind != QualityKind::kDegrees; ++i) {
      const double travel = std::abs(scales[i].factor) * (r_.q.col(i).maxCoeff<Eigen::PropagateNumbers>() - r_.q.col(i).minCoeff<Eigen::PropagateNumbers>());
      if (moves_[i] && (travel < checking::kLeastTravel || travel > checking::kMostTravel)) return;
    }
    if (!has_velocity() || !parts_velocities(scales, scales_of("dq", units, arm_))) add(kind, {}, what, units);
  }

  // True if velocities, integrated, differ from the travel of the positions by far more in these units than as recorded.
  bool parts_velocities(const std::vector<recordings::UnitScale>& q, const std::vector<recordings::UnitScale>& dq) const {
    std::vector<double> more;
    for (int i = 0; i < r_.joints(); ++i) {
      if (!moves_[i] || slides(i)) continue;
      double way = 0.0, least = 0.0, most = 0.0;
      for (Eigen::Index k = 1; k < r_.rows(); ++k) {
        const double step = r_.dq(k, i) * (r_.time[k] - r_.time[k - 1]);
        way += std::isfinite(step) ? step : 0.0;
        least = std::min(least, way), most = std::max(most, way);
      }
      const double off = std::log((most - least) / (r_.q.col(i).maxCoeff<Eigen::PropagateNumbers>() - r_.q.col(i).minCoeff<Eigen::PropagateNumbers>()));
      const double with = std::abs(off + std::log(std::abs(dq[i].factor / q[i].factor))) - std::abs(off);
      if (std::isfinite(with)) more.push_back(with);
    }
    return !more.empty() && median(more) > std::log(2.0);
  }

  bool exceeds_plausible_range(int i) const { return !slides(i) && moves_[i] && ((r_.q.col(i).array().abs() > checking::kMostTravel).any() || leaves_limits(arm_, {i}, r_)); }

  // Adds millimetres as the unit of positions and velocities, "q=mm,dq=mm/s"; for an arm with revolute
  // joints, of each prismatic joint alone.
  void add_millimetres() {
    std::string units;
    for (int i = 0; i < joints(); ++i) {
      if (turning_ ? !slides(i) : i > 0) continue;
      units = joined(units, fmt::format(has_velocity() ? "q{0}=mm,dq{0}=mm/s" : "q{0}=mm", turning_ ? std::to_string(i + 1) : ""));
    }
    add(QualityKind::kMillimetres, {}, "Positions of sliding joints are millimetres", units);
    if (turning_) add(QualityKind::kMillimetres, {}, "Positions are millimetres and degrees", joined(has_velocity() ? "q=deg,dq=deg/s" : "q=deg", units));
  }

  void add_angle_units() {
    for (const Unit& u : kAngles) add_unit(u.kind, u.what, u.q, u.dq);
    int moving = 0, beyond = 0;
    for (int i = 0; i < joints(); ++i) moving += moves_[i] ? 1 : 0, beyond += exceeds_plausible_range(i) ? 1 : 0;
    for (int i = 0; i < joints(); ++i) {
      for (const double zero : checking::kZeros) {
        if (is_badly_explained(i) && !slides(i)) out_.push_back(zero_at(zero, {i}, joint_name(i)));
      }
      // One joint alone in degrees, as separate drivers may publish it.
      if (beyond == moving || !exceeds_plausible_range(i)) continue;
      if (has_velocity()) add(QualityKind::kDegrees, JointIndex{i}, "Position and velocity of " + joint_name(i) + " are degrees", fmt::format("q{0}=deg,dq{0}=deg/s", i + 1));
      add(QualityKind::kDegrees, JointIndex{i}, "The position of " + joint_name(i) + " is in degrees", text("q", i + 1, "=deg"));
      add_motor_side(r_.q.col(i).cwiseAbs().maxCoeff<Eigen::PropagateNumbers>(), JointIndex{i}, joint_name(i));
    }
    const double largest = r_.q.cwiseAbs().maxCoeff<Eigen::PropagateNumbers>();
    if (largest > checking::kMostTravel && !sliding_) add_motor_side(largest, {}, "");
    const bool limited = std::all_of(joints_.begin(), joints_.end(), [](const WantedJoint& j) { return std::isfinite(j.upper - j.lower); });
    for (const Unit& u : kShares) {
      if (limited && largest > checking::kMostTravel && largest < checking::kMostShare) add_unit(u.kind, u.what, u.q, u.dq);
    }
    if (sliding_ || largest < 2.0 * checking::kMostTravel) return;
    for (const int counts : checking::kCounts) {
      for (const std::string& zero : {std::string(), text("@", counts / 2)}) {
        for (const bool both : {false, true}) {
          const std::string unit = text(counts, "/rev");
          add_unit(QualityKind::kCounts, text("Positions", both ? " and velocities" : "", " are counts of an encoder, ", counts, " a turn", zero.empty() ? "" : text(" and ", counts / 2, " at zero")),
                  unit + zero, both ? unit : "");
        }
      }
    }
  }

  // Adds gear ratios that bring the largest angle of one joint, or of all, into the range of an arm.
  void add_motor_side(double largest, std::optional<JointIndex> joint, const std::string& name) {
    for (double ratio = checking::kLeastRatio; ratio < checking::kMostRatio; ratio *= 1.0 + checking::kRatioStep) {
      if (largest / ratio < checking::kMostTravel && largest / ratio > checking::kLeastTravel) out_.push_back(before_the_gear(ratio, has_velocity(), joint, name));
    }
  }

  void add_torque_units() {
    if (is_load_register()) add(QualityKind::kTorqueUnit, {}, "Torques are load registers with a direction bit", "tau=load");
    const bool limited = std::all_of(joints_.begin(), joints_.end(), [](const WantedJoint& j) { return std::isfinite(j.effort) && j.effort > 0.0; });
    for (const auto& [unit, words] : checking::kTorqueUnits) {
      if (limited || std::string(words) == "in") add(QualityKind::kTorqueUnit, {}, text("Torques are ", words, std::string(words) == "in" ? text(" ", unit) : " of the largest effort"), text("tau=", unit));
    }
    for (int i = 0; i < joints(); ++i) {
      for (const char* unit : {"mNm", "Ncm"}) {
        if (is_badly_explained(i) && !slides(i)) add(QualityKind::kTorqueUnit, JointIndex{i}, "The torque of " + joint_name(i) + " is in " + std::string(unit), text("tau", i + 1, "=", unit));
      }
    }
    if (std::all_of(arm_.coordinates().begin(), arm_.coordinates().end(), [](const Coordinate& c) { return c.drive_gain > 0.0; }))
      add(QualityKind::kCurrent, {}, "Efforts are motor currents", "tau=A");
  }

  // Adds other units of the torques, by the factors that fit best: of one joint, and of all.
  void add_torque_factors(const QuickFit& fit) {
    const auto is_beyond = [](double factor, double bound) { return factor > bound || (factor > 0.0 && factor * bound < 1.0); };
    const auto is_far = [&](double factor) { return is_beyond(factor, checking::kTorqueFactor); };
    const auto unit = [](int i, double factor) { return fmt::format("tau{}={:.4g}", i + 1, factor); };
    std::vector<double> common;
    VectorXd all = fit.together;
    const double largest = all.maxCoeff();
    for (int i = 0; i < joints(); ++i) {
      if (fit.ratios[i] * all[i] > 0.0) common.push_back(1.0 / (fit.ratios[i] * all[i]));
      if (joints() == 1 || !moves_[i] || !is_beyond(fit.alone[i], checking::kOwnFactor)) continue;
      RecordingQuestion& q = add(QualityKind::kTorqueUnit, JointIndex{i}, fmt::format("The torque of {} fits with a factor of {:.4g}, as a wrong gain, a current or in front of a gear", joint_name(i), fit.alone[i]), unit(i, fit.alone[i]));
      q.price = checking::kFittedNumberCost;
      q.is_cause = !is_far(fit.alone[i]);
    }
    all *= common.empty() ? 1.0 / largest : median(common);
    for (int i = 0; i < joints(); ++i) {
      if (std::abs(fit.together[i]) < checking::kTiny * largest) all[i] = fit.alone[i];
    }
    const double least = all.minCoeff(), most = all.maxCoeff();
    if (!(least > 0.0) || (!is_far(most / least) && (common.empty() || least * checking::kBehindGear < 1.0))) return;
    std::string units, gears;
    for (int i = 0; i < joints(); ++i) {
      const bool known = fit.alone[i] != 1.0;
      if (known) units = joined(units, unit(i, all[i]));
      gears += (i > 0 ? ", " : "") + (known ? fmt::format("{:.4g}", all[i]) : "?");
    }
    add(QualityKind::kTorqueUnit, {}, "Torques are in a unit of their own on each joint, as currents or in front of gears of about " + gears, units).price = checking::kFittedNumberCost * joints();
  }

  // Tests whether brakes hold the arm between its motions, so that its torques at rest are meaningless.
  void add_brakes() {
    const std::vector<char> rests = rows_at_rest(r_);
    const long count = std::count(rests.begin(), rests.end(), 1);
    if (count == 0 || 2 * count > static_cast<long>(rests.size())) return;
    RecordingQuestion& q = add(QualityKind::kBrakes, {}, "While the arm rests, its torques are not those that hold it, as with closed brakes", "");
    q.other = fmt::format("--min-speed {}", checking::kAtRest);
    q.rows = [rests](Recording& r) {
      for (std::size_t k = 0; k < rests.size(); ++k) {
        if (rests[k] != 0) r.tau.row(static_cast<Eigen::Index>(k)).setConstant(std::nan(""));
      }
    };
  }

  // Tests torques that lag or lead the motion. Errors below kPoorFit come from friction near rest on correct
  // recordings, and are not tested.
  void add_clocks() {
    bool any = false;
    for (int i = 0; i < joints(); ++i) any = any || is_badly_explained(i);
    if (!any) return;
    const double length = r_.time[r_.rows() - 1] - r_.time[0];
    for (const double late : checking::kDelays) {
      for (const double d : {late, -late}) {
        out_.push_back(torques_late(d, d, length));
        out_.push_back(torques_late(0.0, checking::kDrift * d, length));
        for (int i = 0; i < joints() && joints() > 1; ++i) {
          if (is_badly_explained(i)) out_.push_back(torques_late(d, d, length, JointIndex{i}, joint_name(i)));
        }
      }
    }
    for (const double constant : checking::kFilters) out_.push_back(torques_filtered(constant));
    for (int k = 1; k < checking::kMoments; ++k) {
      const double moment = k * length / checking::kMoments;
      if (3 * k >= checking::kMoments) out_.push_back(without_rows(Part::kAfter, moment, r_.time));
      if (3 * k <= 2 * checking::kMoments) out_.push_back(without_rows(Part::kBefore, moment, r_.time));
    }
  }

  // True if all torques are load registers: whole numbers up to 2047, on both sides of the direction bit 1024.
  bool is_load_register() const {
    long high = 0, low = 0;
    for (const double v : r_.tau.reshaped()) {
      if (!std::isfinite(v)) continue;
      if (v < 0.0 || v >= 2.0 * checking::kDirectionBit || v != std::floor(v)) return false;
      ++(v > checking::kDirectionBit ? high : low);
    }
    return checking::kBothDirections * static_cast<double>(std::min(high, low)) > static_cast<double>(high + low);
  }

  // Adds another order of these signals' columns: `order` has the index of the column that holds each joint.
  RecordingQuestion& arranged(std::optional<JointIndex> joint, const std::string& what, const Names& signals, const std::vector<int>& order) {
    RecordingQuestion& q = add(QualityKind::kSwappedJoints, joint, what, "");
    for (const std::string& signal : signals) {
      for (std::size_t i = 0; i < order.size(); ++i) {
        if (order[i] != static_cast<int>(i)) q.map = joined(q.map, fmt::format("{0}{1}={0}{2}", signal, i + 1, order[i] + 1));
      }
    }
    return q;
  }

  // Adds exchanges: of two joints; of all joints in the alphabetical order of their names, as ROS sorts them;
  // of all joints, shifted by one.
  void add_exchanges() {
    std::vector<int> own(static_cast<std::size_t>(joints()));
    std::iota(own.begin(), own.end(), 0);
    for (int i = 0; i < joints(); ++i) {
      for (int j = i + 1; j < joints(); ++j) {
        if (!moves_[i] || !moves_[j] || !(is_badly_explained(i) || is_badly_explained(j))) continue;
        std::vector<int> order = own;
        std::swap(order[i], order[j]);
        const std::string pair = joint_name(i) + " and " + joint_name(j);
        arranged(JointIndex{i}, "The torques of " + pair + " are swapped", {torque_}, order).second = JointIndex{j};
        arranged(JointIndex{i}, "Positions and velocities of " + pair + " are swapped", motion_, order).second = JointIndex{j};
        arranged(JointIndex{i}, "The whole of " + pair + " is swapped", all_, order).second = JointIndex{j};
      }
    }
    std::vector<int> sorted = own, alphabetical = own, on = own, back = own;
    std::sort(sorted.begin(), sorted.end(), [this](int a, int b) { return joints_[a].name < joints_[b].name; });
    for (int k = 0; k < joints(); ++k) alphabetical[sorted[k]] = k;
    std::rotate(on.begin(), on.begin() + 1, on.end());
    std::rotate(back.begin(), back.end() - 1, back.end());
    int moved = 0;
    for (int i = 0; i < joints(); ++i) moved += alphabetical[i] != i ? 1 : 0;
    if (moved > 2) {  // two moved joints are an exchange
      arranged({}, "All columns are in the alphabetical order of the joints' names", all_, alphabetical);
      arranged({}, "The torques are in the alphabetical order of the joints' names", {torque_}, alphabetical);
    }
    if (joints() < 3) return;
    arranged({}, "The torques stand one column too far to the right", {torque_}, on);
    arranged({}, "The torques stand one column too far to the left", {torque_}, back);
  }

  void add_gravity_directions() {
    const Eigen::Vector3d g = arm_.gravity();
    const double size = g.norm() > 0.0 ? g.norm() : checking::kGravity;
    for (int k = 0; k < 27; ++k) {
      const Eigen::Vector3d direction(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
      const Eigen::Vector3d vector = direction.isZero() ? direction : Eigen::Vector3d(size * direction.normalized());
      if ((vector - g).norm() > checking::kTilt * checking::kTilt) out_.push_back(gravity_along(vector));
    }
    if (g.isZero()) return;
    for (RecordingQuestion& near : gravity_along(g).neighbours(checking::kTilt)) out_.push_back(std::move(near));
  }

  void add_dh_convention() {
    const auto& frames = arm_.frames();
    if (std::none_of(frames.begin(), frames.end(), [](const Frame& f) { return f.dh.has_value(); })) return;
    const auto row = std::find_if(frames.begin(), frames.end(), [](const Frame& f) { return f.dh.has_value(); });
    const bool standard = row->dh->convention == DhConvention::kStandard;
    const std::string other = standard ? "modified" : "standard";
    RecordingQuestion& q = add(QualityKind::kDhConvention, {}, text("The DH rows of the robot file are written in the ", other, " convention"), "");
    q.other = text("convention: ", other, " in the robot file");
    q.robot = [standard](ModelDescription& d) {
      for (Frame& frame : d.frames) {
        if (!frame.dh) continue;
        DhRow other_row = *frame.dh;
        if (frame.type == JointType::kRevolute) frame.variable.offset -= other_row.theta;
        if (frame.type == JointType::kPrismatic) frame.variable.offset -= other_row.d;
        other_row.convention = standard ? DhConvention::kModified : DhConvention::kStandard;
        place(frame, other_row);
        if (frame.body) frame.body->phi.reset();  // the values do not hold in the other convention's frame
      }
    };
  }

  const Model& arm_;
  const Recording& r_;
  const SignalChoice& given_;
  std::string torque_;
  const std::vector<bool>& moves_;
  VectorXd shares_;  // unexplained share of each joint's squared torque
  std::vector<WantedJoint> joints_;
  Names motion_, all_;  // recorded signals of the motion; the same with the torque
  bool turning_ = false, sliding_ = false;
  std::vector<RecordingQuestion> out_;
};

std::string options_text(const std::string& units, const std::string& map) {
  return (units.empty() ? "" : "--units " + units) + (units.empty() || map.empty() ? "" : " ") + (map.empty() ? "" : "--map " + map);
}

// The unit of numbers that were read in the unit `given` and are in the unit `found` after that.
std::string composed(const std::string& signal, const std::string& given, const std::string& found, const WantedJoint& joint) {
  if (given.empty()) return found;
  const recordings::UnitScale a = recordings::unit_scale(signal, given, &joint).value(), b = recordings::unit_scale(signal, found, &joint).value();
  const recordings::UnitScale both{a.factor * b.factor, a.zero + b.zero / a.factor};
  if (std::abs(both.factor - 1.0) < checking::kTiny && both.zero == 0.0) return "";
  if (b.factor == -1.0 && b.zero == 0.0) return given[0] == '-' ? given.substr(1) : "-" + given;
  return recordings::unit_name(signal, both, joint);
}

// The options for a recording as it is in its file, from those with which it was read and the corrections of what was read.
class ReadingOptions {
 public:
  ReadingOptions(const SignalChoice& given, const Model& arm) : given_(given), joints_(joints_of(arm)), map_(given.map) {
    for (const char* signal : kSignals) {
      for (std::size_t i = 0; i < joints_.size(); ++i) {
        const std::string unit = recordings::unit_of(given, signal, static_cast<int>(i) + 1);
        units_[signal].push_back(concerns(unit, i) ? unit : "");
      }
    }
  }

  void apply(const RecordingQuestion& q) {
    changed_ = changed_ || (q.changes_recording() && !q.rows);
    const std::map<std::string, std::string> map = map_;
    const std::map<std::string, Names> units = units_;
    for (const auto& [to, from] : assignments(q.map)) {
      const auto source = map.find(from);
      map_[to] = source != map.end() ? source->second : from;
      if (map_[to] == to) map_.erase(to);
      units_.at(column(to).first)[column(to).second] = units.at(column(from).first)[column(from).second];
    }
    for (const auto& [key, unit] : assignments(q.units)) {
      const auto [signal, joint] = column(key);
      for (std::size_t i = 0; i < joints_.size(); ++i) {
        std::string& name = units_.at(signal)[i];
        if (joint < 0 ? concerns(unit, i) : static_cast<std::size_t>(joint) == i) name = composed(signal, name, unit, joints_[i]);
      }
    }
  }

  // The options that replace the given ones; empty if they remain.
  std::string words() const {
    if (!changed_) return "";
    std::string units, of_joints, map;
    for (const char* signal : kSignals) {
      if (const std::string most = most_frequent(signal); !most.empty()) units = joined(units, text(signal, "=", most));
      for (const auto& [to, source] : map_) {
        if (column(to).first == signal) map = joined(map, to + "=" + source);
      }
    }
    for (std::size_t i = 0; i < joints_.size(); ++i) {
      for (const char* signal : kSignals) {
        const std::string most = most_frequent(signal), &own = units_.at(signal)[i];
        if (own == most || (own.empty() && !concerns(most, i))) continue;
        of_joints = joined(of_joints, text(signal, i + 1, "=", own.empty() ? recordings::unit_name(signal, {}, joints_[i]) : own));
      }
    }
    units = joined(units, of_joints);
    if (const auto clock = given_.units.find("t"); clock != given_.units.end()) units = joined(units, "t=" + clock->second);
    const std::string out = options_text(units, map);
    return out.empty() ? "leaving out " + given_options(given_) : out;
  }

 private:
  bool concerns(const std::string& unit, std::size_t i) const { return !recordings::is_unit_of_other_joint_type(unit, joints_[i]); }

  // The unit of more than half of the joints, or empty.
  std::string most_frequent(const std::string& signal) const {
    const Names& names = units_.at(signal);
    for (const std::string& name : names) {
      if (2 * std::count(names.begin(), names.end(), name) > static_cast<long>(names.size())) return name;
    }
    return "";
  }

  const SignalChoice& given_;
  std::vector<WantedJoint> joints_;
  std::map<std::string, std::string> map_;
  std::map<std::string, Names> units_;  // of each joint; empty: SI
  bool changed_ = false;
};

// True if the hypothesis concerns the unit of positions, of which there is only one.
bool is_position_unit(const RecordingQuestion& q) { return q.units.rfind('q', 0) == 0 && q.kind != QualityKind::kPositionSign; }

}  // namespace

bool RecordingQuestion::is_whole() const { return map.rfind('q', 0) == 0 && map.find_first_of("ti") != std::string::npos; }

bool RecordingQuestion::excludes(const RecordingQuestion& o) const {
  if (is_position_unit(*this) && is_position_unit(o)) return !joint || !o.joint || joint == o.joint;
  if (kind == QualityKind::kTorqueUnit && o.kind == QualityKind::kCurrent) return true;
  if (robot || o.robot) return kind == o.kind;
  // Exchanged torques and exchanged motions of the same two joints are one mistake.
  if (second && joint == o.joint && second == o.second && !is_whole() && !o.is_whole()) return false;
  if (kind != o.kind && (kind == QualityKind::kTorqueSign || o.kind == QualityKind::kTorqueSign || kind == QualityKind::kTorqueUnit || o.kind == QualityKind::kTorqueUnit ||
                               !joint || !o.joint))
    return false;
  const auto concerns = [&o](std::optional<JointIndex> k) { return k && (k == o.joint || k == o.second); };
  return !joint || !o.joint || concerns(joint) || concerns(second);
}

std::vector<RecordingQuestion> questions_of(const Model& arm, const Recording& recording, const SignalChoice& given, const std::vector<bool>& moves, const QuickFit& fit) {
  return List(arm, recording, given, moves, fit).all(fit);
}

bool leaves_limits(const Model& arm, JointIndex joint, const Recording& recording) {
  const Limits& limits = arm.coordinates()[joint.value].limits;
  const double margin = checking::kBeyondLimits * (limits.upper - limits.lower);
  const auto q = recording.q.col(joint.value).array();
  return std::isfinite(margin) && (q < limits.lower - margin || q > limits.upper + margin).any();
}

RecordingQuestion gravity_along(const Eigen::Vector3d& gravity) {
  RecordingQuestion q{QualityKind::kGravity};
  const Eigen::Vector3d g = (gravity.array().abs() < checking::kTiny).select(0.0, gravity);
  const std::string words = fmt::format("{:.4g},{:.4g},{:.4g}", g[0], g[1], g[2]);
  q.what = g.isZero() ? "The torques hold no gravity, as the commands of a controller that compensates it"
                      : text("Gravity points along (", words, ") m/s^2 of the robot file's base, as on another mount");
  q.other = "--gravity " + words;
  q.robot = [g](ModelDescription& d) { d.gravity = g; };
  if (g.isZero()) return q;
  q.first_distance = 2.0 * checking::kTilt;
  q.neighbours = [g](double distance) {
    const Eigen::Vector3d across = g.unitOrthogonal();
    const Eigen::Vector3d third = g.normalized().cross(across);
    std::vector<RecordingQuestion> out;
    for (int k = 0; k < checking::kTiltDirections; ++k) {
      const double turn = M_PI * k / (0.5 * checking::kTiltDirections);
      const Eigen::Vector3d axis = std::cos(turn) * across + std::sin(turn) * third;
      out.push_back(gravity_along(Eigen::AngleAxisd(distance, axis) * g));
    }
    return out;
  };
  return q;
}

std::string options_of(const std::vector<RecordingQuestion>& questions, const SignalChoice& given, const Model& arm) {
  ReadingOptions options(given, arm);
  std::string other;
  for (const RecordingQuestion& q : questions) {
    options.apply(q);
    if (!q.other.empty()) other += (other.empty() ? "" : " ") + q.other;
  }
  const std::string reading = options.words();
  return reading.empty() || other.empty() ? reading + other : reading + " " + other;
}

std::string given_options(const SignalChoice& given) {
  std::string units, map;
  for (const auto& [key, unit] : given.units) units = joined(units, key + "=" + unit);
  for (const auto& [key, source] : given.map) map = joined(map, key + "=" + source);
  return options_text(units, map);
}

bool any_changes_robot(const std::vector<RecordingQuestion>& set) {
  return std::any_of(set.begin(), set.end(), [](const RecordingQuestion& q) { return static_cast<bool>(q.robot); });
}

Model corrected_arm(const std::vector<RecordingQuestion>& set, const Model& arm) {
  ModelDescription d = arm.description();
  for (const RecordingQuestion& q : set) {
    if (q.robot) q.robot(d);
  }
  return Model(std::move(d));
}

void apply_to(const std::vector<RecordingQuestion>& set, const Model& arm, Recording& recording) {
  for (const RecordingQuestion& q : set) {
    Recording before;
    if (!q.map.empty()) before = recording;
    for (const auto& [to, from] : assignments(q.map)) {
      if (MatrixXd* values = columns_of(column(to).first, recording)) values->col(column(to).second) = columns_of(column(from).first, before)->col(column(from).second);
    }
  }
  for (const RecordingQuestion& q : set) {
    if (q.rows) q.rows(recording);
    for (const char* signal : kSignals) {
      MatrixXd* values = columns_of(signal, recording);
      if (q.units.empty() || values == nullptr) continue;
      const std::vector<recordings::UnitScale> scales = scales_of(signal, q.units, arm);
      for (int i = 0; i < arm.joints(); ++i) {
        if (!scales[i].changes_nothing()) values->col(i) = values->col(i).unaryExpr(scales[i]).eval();
      }
    }
  }
}

}  // namespace veridyn
