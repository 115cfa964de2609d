#include "identification/check/questions.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>

#include "identification/check/check_thresholds.hpp"
#include "recordings/signals/units.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/recordings/preprocessing.hpp"

namespace veridyn {
namespace {

void swap_columns(MatrixXd& values, int i, int j) {
  if (values.cols() > 0) values.col(i).swap(values.col(j));
}

// "a1=a2,a2=a1"
std::string exchanged(const std::string& signal, int i, int j) {
  return fmt::format("{0}{1}={0}{2},{0}{2}={0}{1}", signal, i + 1, j + 1);
}

std::string joined(const std::string& a, const std::string& b) { return a.empty() || b.empty() ? a + b : a + "," + b; }

// One signal in another unit, for all joints or for one (from 0).
void to_si(MatrixXd& values, const std::string& signal, const std::string& unit, const std::vector<WantedJoint>& joints, int only = -1) {
  SignalChoice choice;
  choice.units = {{signal, unit}};
  choice.joints = joints;
  for (int i = 0; i < values.cols(); ++i) {
    if (only < 0 || i == only) values.col(i) = values.col(i).unaryExpr(recordings::scale_for(choice, signal, i + 1)).eval();
  }
}

// Positions of all joints, or of one (from 0) of this name, were measured in front of a gear of this ratio.
RecordingQuestion before_the_gear(double ratio, bool velocity, int joint = -1, const std::string& name = "") {
  RecordingQuestion q;
  q.finding = "motor_side";
  q.joint = joint + 1;
  const double whole = std::round(ratio);
  const std::string words = fmt::format("{:.4g}", std::abs(ratio / whole - 1.0) < checking::kWholeRatio ? whole : ratio);
  q.what = joint < 0 ? text("Positions are those of the motors, in front of gears of about ", words)
                     : text("The position of ", name, " is that of its motor, in front of a gear of about ", words);
  const std::string unit = fmt::format("{:.5g}", 1.0 / std::stod(words));
  const std::string number = joint < 0 ? "" : std::to_string(joint + 1);
  q.units = "q" + number + "=" + unit + (velocity ? ",dq" + number + "=" + unit : "");
  const double factor = std::stod(unit);
  q.recording = [factor, velocity, joint](Recording& r) {
    for (MatrixXd* values : {&r.q, &r.dq}) {
      if (values->size() == 0 || (values == &r.dq && !velocity)) continue;
      if (joint < 0) *values *= factor;
      else values->col(joint) *= factor;
    }
  };
  q.price = checking::kOfNumber;
  q.first_distance = checking::kRatioStep;
  q.neighbours = [=](double distance) {
    return std::vector<RecordingQuestion>{before_the_gear(ratio * (1.0 + distance), velocity, joint, name), before_the_gear(ratio / (1.0 + distance), velocity, joint, name)};
  };
  return q;
}

// The position of a joint (from 0) is this angle where the robot file has zero.
RecordingQuestion zero_at(double zero, int joint, const std::string& name) {
  RecordingQuestion q;
  q.finding = "encoder_zero";
  q.joint = joint + 1;
  const std::string words = fmt::format("{:.4g}", zero);
  q.what = text("The position of ", name, " is counted from another zero, which lies at ", words, " rad");
  q.units = text("q", joint + 1, "=rad@", words);
  const double rounded = std::stod(words);
  q.recording = [joint, rounded](Recording& r) { r.q.col(joint).array() -= rounded; };
  q.price = checking::kOfNumber;
  q.first_distance = checking::kZeroStep;
  q.neighbours = [=](double distance) { return std::vector<RecordingQuestion>{zero_at(zero + distance, joint, name), zero_at(zero - distance, joint, name)}; };
  return q;
}

class List {
 public:
  List(const Model& arm, const Recording& r, const std::string& torque, const std::vector<bool>& moves, const std::vector<bool>& badly)
      : arm_(arm), r_(r), torque_(torque), moves_(moves), badly_(badly), joints_(joints_of(arm)) {
    for (const Coordinate& c : arm.coordinates()) turning_ = turning_ || !c.prismatic, sliding_ = sliding_ || c.prismatic;
  }

  std::vector<RecordingQuestion> all() {
    signs();
    angles();
    torques();
    exchanges();
    orders();
    gravity();
    convention();
    return std::move(out_);
  }

 private:
  int joints() const { return arm_.joints(); }
  std::string name(int i) const { return text("joint ", i + 1, " (", arm_.coordinates()[i].name, ")"); }
  bool has_velocity() const { return r_.dq.size() > 0; }

  RecordingQuestion& add(const std::string& finding, int joint, std::string what, std::function<void(Recording&)> change) {
    out_.push_back({});
    RecordingQuestion& q = out_.back();
    q.finding = finding;
    q.joint = joint;
    q.what = std::move(what);
    q.recording = std::move(change);
    return q;
  }

  void signs() {
    const bool amperes = torque_ == "i";
    for (int i = 0; i < joints(); ++i) {
      if (!moves_[i]) continue;
      const bool slides = arm_.coordinates()[i].prismatic;
      add("torque_sign", i + 1, "The torque of " + name(i) + " has the wrong sign", [i](Recording& r) { r.tau.col(i) *= -1.0; }).units =
          fmt::format("{}{}=-{}", torque_, i + 1, amperes ? "A" : slides ? "N" : "Nm");
      const std::string length = slides ? "m" : "rad";
      if (!badly_[i]) continue;
      RecordingQuestion& q = add("position_sign", i + 1, "The position of " + name(i) + " is counted the other way round", [i](Recording& r) {
        for (MatrixXd* values : {&r.q, &r.dq, &r.ddq}) {
          if (values->cols() > 0) values->col(i) *= -1.0;
        }
      });
      q.units = fmt::format("q{0}=-{1}", i + 1, length);
      q.price = checking::kOfPosition;
      if (has_velocity()) q.units += fmt::format(",dq{0}=-{1}/s", i + 1, length);
      RecordingQuestion& whole = add("position_sign", i + 1, "Position and torque of " + name(i) + " are counted the other way round", [i](Recording& r) {
        for (MatrixXd* values : {&r.q, &r.dq, &r.ddq, &r.tau}) {
          if (values->cols() > 0) values->col(i) *= -1.0;
        }
      });
      whole.price = checking::kOfPosition;
      whole.units = fmt::format(has_velocity() ? "q{0}=-{1},dq{0}=-{1}/s,{2}{0}=-{3}" : "q{0}=-{1},{2}{0}=-{3}", i + 1, length, torque_, amperes ? "A" : slides ? "N" : "Nm");
    }
    if (joints() > 1)
      add("torque_sign", 0, "All torques have the wrong sign", [](Recording& r) { r.tau *= -1.0; }).units = fmt::format("{}=-{}", torque_, amperes ? "A" : "Nm");
  }

  // Units of positions and velocities, and what is derived anew where a file has no velocity in them.
  void positions_in(const std::string& finding, const std::string& what, const std::string& q, const std::string& dq) {
    const auto joints = joints_;
    const auto change = [q, dq, joints](Recording& r) {
      to_si(r.q, "q", q, joints);
      if (r.dq.size() > 0 && !dq.empty()) to_si(r.dq, "dq", dq, joints);
    };
    Recording after = r_;
    change(after);
    for (int i = 0; i < after.joints(); ++i) {
      const double travel = after.q.col(i).maxCoeff<Eigen::PropagateNumbers>() - after.q.col(i).minCoeff<Eigen::PropagateNumbers>();
      if (moves_[i] && finding != "degrees" && (travel < checking::kLeastTravel || travel > checking::kMostTravel)) return;
    }
    add(finding, 0, what, change).units = joined("q=" + q, dq.empty() || !has_velocity() ? "" : "dq=" + dq);
  }

  bool is_beyond(int i) const {
    const Coordinate& c = arm_.coordinates()[i];
    const double margin = checking::kBeyondLimits * (c.limits.upper - c.limits.lower);
    const auto q = r_.q.col(i).array();
    const bool far = (q.abs() > checking::kMostTravel).any();
    return !c.prismatic && moves_[i] && (far || (std::isfinite(margin) && (q < c.limits.lower - margin || q > c.limits.upper + margin).any()));
  }

  // One joint of several in degrees, as its own driver publishes it.
  void degrees_of(int i) {
    const auto change = [i](MatrixXd& values) { values.col(i) *= M_PI / 180.0; };
    if (has_velocity()) {
      add("degrees", i + 1, "Position and velocity of " + name(i) + " are degrees", [change](Recording& r) {
        change(r.q);
        change(r.dq);
      }).units = fmt::format("q{0}=deg,dq{0}=deg/s", i + 1);
    }
    add("degrees", i + 1, "The position of " + name(i) + " is in degrees", [change](Recording& r) { change(r.q); }).units = fmt::format("q{}=deg", i + 1);
    const double largest = r_.q.col(i).cwiseAbs().maxCoeff<Eigen::PropagateNumbers>();
    for (double ratio = checking::kLeastRatio; ratio < checking::kMostRatio; ratio *= 1.0 + checking::kRatioStep) {
      if (largest / ratio < checking::kMostTravel && largest / ratio > checking::kLeastTravel) out_.push_back(before_the_gear(ratio, has_velocity(), i, name(i)));
    }
  }

  // "q=mm,dq=mm/s"; of an arm that also turns, of each sliding joint.
  std::string millimetres() const {
    std::string out;
    for (int i = 0; i < joints(); ++i) {
      if (turning_ && !arm_.coordinates()[i].prismatic) continue;
      const std::string number = turning_ ? std::to_string(i + 1) : "";
      out = joined(out, fmt::format(has_velocity() ? "q{0}=mm,dq{0}=mm/s" : "q{0}=mm", number));
      if (!turning_) break;
    }
    return out;
  }

  void angles() {
    if (sliding_) {
      const auto joints = joints_;
      const auto change = [joints](Recording& r) {
        to_si(r.q, "q", "mm", joints);
        if (r.dq.size() > 0) to_si(r.dq, "dq", "mm/s", joints);
      };
      add("millimetres", 0, "Positions of sliding joints are millimetres", change).units = millimetres();
      if (turning_) {
        add("millimetres", 0, "Positions are millimetres and degrees", [change, joints](Recording& r) {
          change(r);
          to_si(r.q, "q", "deg", joints);
          if (r.dq.size() > 0) to_si(r.dq, "dq", "deg/s", joints);
        }).units = joined(has_velocity() ? "q=deg,dq=deg/s" : "q=deg", millimetres());
      }
    }
    if (!turning_) return;
    if (has_velocity()) {
      positions_in("degrees", "Positions and velocities are degrees", "deg", "deg/s");
      const auto joints = joints_;
      add("degrees", 0, "Velocities are degrees per second", [joints](Recording& r) { to_si(r.dq, "dq", "deg/s", joints); }).units = "dq=deg/s";
    }
    positions_in("degrees", "Positions are degrees", "deg", "");
    positions_in("turns", "Positions are turns", "rev", "");
    if (has_velocity()) {
      positions_in("turns", "Positions are turns, and velocities turns a minute", "rev", "rpm");
      const auto joints = joints_;
      add("turns", 0, "Velocities are turns a minute", [joints](Recording& r) { to_si(r.dq, "dq", "rpm", joints); }).units = "dq=rpm";
    }
    for (int i = 0; i < joints(); ++i) {
      for (const double zero : checking::kZeros) {
        if (moves_[i] && badly_[i] && !arm_.coordinates()[i].prismatic) out_.push_back(zero_at(zero, i, name(i)));
      }
    }
    int moving = 0, beyond = 0;
    for (int i = 0; i < joints(); ++i) moving += moves_[i] ? 1 : 0, beyond += is_beyond(i) ? 1 : 0;
    for (int i = 0; i < joints(); ++i) {
      if (beyond < moving && is_beyond(i)) degrees_of(i);
    }
    const double largest = r_.q.cwiseAbs().maxCoeff<Eigen::PropagateNumbers>();
    for (double ratio = checking::kLeastRatio; largest > checking::kMostTravel && !sliding_ && ratio < checking::kMostRatio; ratio *= 1.0 + checking::kRatioStep) {
      if (largest / ratio < checking::kMostTravel && largest / ratio > checking::kLeastTravel) out_.push_back(before_the_gear(ratio, has_velocity()));
    }
    const bool limited = std::all_of(joints_.begin(), joints_.end(), [](const WantedJoint& j) { return std::isfinite(j.upper - j.lower); });
    if (limited && largest > checking::kMostTravel && largest < checking::kMostShare) {
      positions_in("share_of_range", "Positions are shares of the range, -100 to 100", "%", "");
      if (has_velocity()) positions_in("share_of_range", "Positions and velocities are shares of the range, -100 to 100", "%", "%");
    }
    if (sliding_ || largest < 2.0 * checking::kMostTravel) return;
    for (const int counts : checking::kCounts) {
      for (const int zero : {0, counts / 2}) {
        for (const bool both : {false, true}) {
          if (both && !has_velocity()) continue;
          const std::string unit = fmt::format("{}/rev", counts);
          positions_in("counts", fmt::format("Positions{} are counts of an encoder, {} a turn{}", both ? " and velocities" : "", counts, zero > 0 ? fmt::format(" and {} at zero", zero) : ""),
                       zero > 0 ? fmt::format("{}@{}", unit, zero) : unit, both ? unit : "");
        }
      }
    }
  }

  void torques() {
    if (torque_ != "tau") return;
    const auto joints = joints_;
    const auto in = [&](const std::string& unit, const std::string& what) {
      add("torque_unit", 0, what, [unit, joints](Recording& r) { to_si(r.tau, "tau", unit, joints); }).units = "tau=" + unit;
    };
    if (is_load_register()) in("load", "Torques are load registers with a direction bit");
    const bool limited = std::all_of(joints_.begin(), joints_.end(), [](const WantedJoint& j) { return std::isfinite(j.effort) && j.effort > 0.0; });
    for (const std::string unit : checking::kTorqueUnits) {
      const bool share = unit == "%" || unit == "permille" || unit == "share";
      if (share && !limited) continue;
      in(unit, unit == "%" ? "Torques are percent of the largest effort" : unit == "permille" ? "Torques are thousandths of the largest effort"
               : unit == "share" ? "Torques are shares of the largest effort" : "Torques are in " + unit);
    }
    for (int i = 0; i < arm_.joints(); ++i) {
      for (const std::string unit : {"mNm", "Ncm"}) {
        if (moves_[i] && badly_[i] && !arm_.coordinates()[i].prismatic)
          add("torque_unit", i + 1, "The torque of " + name(i) + " is in " + unit, [unit, joints, i](Recording& r) { to_si(r.tau, "tau", unit, joints, i); }).units =
              fmt::format("tau{}={}", i + 1, unit);
      }
    }
    VectorXd gains(arm_.joints());
    for (int i = 0; i < arm_.joints(); ++i) gains[i] = arm_.coordinates()[i].drive_gain;
    if (gains.minCoeff() <= 0.0) return;
    RecordingQuestion& q = add("current", 0, "Efforts are motor currents", [gains](Recording& r) { r.tau = (r.tau * gains.asDiagonal()).eval(); });
    q.units = "tau=A";
  }

  // Whole numbers up to 2047, on both sides of 1024.
  bool is_load_register() const {
    long high = 0, low = 0;
    for (const double v : r_.tau.reshaped()) {
      if (!std::isfinite(v)) continue;
      if (v < 0.0 || v >= 2.0 * checking::kDirectionBit || v != std::floor(v)) return false;
      ++(v > checking::kDirectionBit ? high : low);
    }
    return checking::kBothDirections * static_cast<double>(std::min(high, low)) > static_cast<double>(high + low);
  }

  void exchanges() {
    for (int i = 0; i < joints(); ++i) {
      for (int j = i + 1; j < joints(); ++j) {
        if (!moves_[i] || !moves_[j] || !(badly_[i] || badly_[j])) continue;
        const std::string pair = name(i) + " and " + name(j);
        const std::string torques = exchanged(torque_, i, j);
        const std::string motion = exchanged("q", i, j) + (has_velocity() ? "," + exchanged("dq", i, j) : "");
        const auto swap_torques = [i, j](Recording& r) { swap_columns(r.tau, i, j); };
        const auto swap_motion = [i, j](Recording& r) {
          for (MatrixXd* values : {&r.q, &r.dq, &r.ddq}) swap_columns(*values, i, j);
        };
        const auto pair_of = [&](const std::string& what, const std::string& map, std::function<void(Recording&)> change) {
          RecordingQuestion& q = add("swapped_joints", i + 1, what, std::move(change));
          q.second = j + 1;
          q.map = map;
          q.whole = map.find(torques) != std::string::npos && map != torques;
        };
        pair_of("The torques of " + pair + " are swapped", torques, swap_torques);
        pair_of("Positions and velocities of " + pair + " are swapped", motion, swap_motion);
        pair_of("The whole of " + pair + " is swapped", motion + "," + torques, [=](Recording& r) {
          swap_torques(r);
          swap_motion(r);
        });
      }
    }
  }

  // Columns in the alphabetical order of the joints' names, as ROS sorts them, or moved on by one.
  void orders() {
    std::vector<int> own(static_cast<std::size_t>(joints()));
    for (int i = 0; i < joints(); ++i) own[i] = i;
    std::vector<int> sorted = own, on = own, back = own;  // places of the joints' columns
    std::sort(sorted.begin(), sorted.end(), [this](int a, int b) { return arm_.coordinates()[a].name < arm_.coordinates()[b].name; });
    std::vector<int> alphabetical = own;
    for (int k = 0; k < joints(); ++k) alphabetical[sorted[k]] = k;
    std::rotate(on.begin(), on.begin() + 1, on.end());
    std::rotate(back.begin(), back.end() - 1, back.end());
    const auto add_order = [&](const std::vector<int>& order, const std::string& what, const std::vector<std::string>& signals) {
      int moved = 0;
      std::string map;
      for (const std::string& signal : signals) {
        for (int i = 0; i < joints(); ++i) {
          if (order[i] == i) continue;
          ++moved;
          map = joined(map, fmt::format("{0}{1}={0}{2}", signal, i + 1, order[i] + 1));
        }
      }
      if (moved < 3 * static_cast<int>(signals.size())) return;  // two are an exchange
      const bool torques = signals.back() == torque_, motion = signals.front() == "q";
      add("swapped_joints", 0, what, [order, torques, motion](Recording& r) {
        const Recording before = r;
        for (std::size_t i = 0; i < order.size(); ++i) {
          for (MatrixXd Recording::*values : {&Recording::q, &Recording::dq, &Recording::ddq}) {
            if (motion && (r.*values).cols() > 0) (r.*values).col(i) = (before.*values).col(order[i]);
          }
          if (torques) r.tau.col(i) = before.tau.col(order[i]);
        }
      }).map = map;
    };
    const std::vector<std::string> motion = has_velocity() ? std::vector<std::string>{"q", "dq"} : std::vector<std::string>{"q"};
    std::vector<std::string> all = motion;
    all.push_back(torque_);
    add_order(alphabetical, "All columns are in the alphabetical order of the joints' names", all);
    add_order(alphabetical, "The torques are in the alphabetical order of the joints' names", {torque_});
    add_order(on, "The torques stand one column too far to the right", {torque_});
    add_order(back, "The torques stand one column too far to the left", {torque_});
  }

  void gravity() {
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

  void convention() {
    const auto& frames = arm_.frames();
    if (std::none_of(frames.begin(), frames.end(), [](const Frame& f) { return f.dh.has_value(); })) return;
    const auto row = std::find_if(frames.begin(), frames.end(), [](const Frame& f) { return f.dh.has_value(); });
    const bool standard = row->dh->convention == DhConvention::kStandard;
    const std::string other = standard ? "modified" : "standard";
    RecordingQuestion& q = add("dh_convention", 0, text("The DH rows of the robot file are written in the ", other, " convention"), nullptr);
    q.other = text("convention: ", other, " in the robot file");
    q.robot = [standard](ModelDescription& d) {
      for (Frame& frame : d.frames) {
        if (!frame.dh) continue;
        DhRow other_row = *frame.dh;
        if (frame.type == JointType::kRevolute) frame.variable.offset -= other_row.theta;
        if (frame.type == JointType::kPrismatic) frame.variable.offset -= other_row.d;
        other_row.convention = standard ? DhConvention::kModified : DhConvention::kStandard;
        place(frame, other_row);
        if (frame.body) frame.body->phi.reset();  // in the other frame
      }
    };
  }

  const Model& arm_;
  const Recording& r_;
  std::string torque_;
  const std::vector<bool>& moves_;
  const std::vector<bool>& badly_;
  std::vector<WantedJoint> joints_;
  bool turning_ = false, sliding_ = false;
  std::vector<RecordingQuestion> out_;
};

// Positions have one unit.
bool is_position_unit(const RecordingQuestion& q) {
  return q.recording && (q.finding == "degrees" || q.finding == "counts" || q.finding == "share_of_range" || q.finding == "motor_side" ||
                         q.finding == "turns" || q.finding == "encoder_zero");
}

}  // namespace

bool RecordingQuestion::excludes(const RecordingQuestion& o) const {
  if (is_position_unit(*this) && is_position_unit(o)) return joint == 0 || o.joint == 0 || joint == o.joint;
  if (finding == "torque_unit" && o.finding == "current") return true;
  if (robot || o.robot) return finding == o.finding;
  // That torques of two joints are exchanged and that their motions are is one mistake, seen from either side.
  if (second != 0 && joint == o.joint && second == o.second && !whole && !o.whole) return false;
  if (finding != o.finding && (finding == "torque_sign" || o.finding == "torque_sign" || finding == "torque_unit" || o.finding == "torque_unit" ||
                               joint * o.joint == 0))
    return false;
  const auto concerns = [&o](int k) { return k != 0 && (k == o.joint || k == o.second); };
  return joint == 0 || o.joint == 0 || concerns(joint) || concerns(second);
}

std::vector<RecordingQuestion> questions_of(const Model& arm, const Recording& recording, const std::string& torque, const std::vector<bool>& moves,
                                   const std::vector<bool>& badly) {
  return List(arm, recording, torque, moves, badly).all();
}

RecordingQuestion gravity_along(const Eigen::Vector3d& gravity) {
  RecordingQuestion q;
  q.finding = "gravity";
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

std::string options_of(const std::vector<RecordingQuestion>& questions) {
  std::vector<std::pair<std::string, std::string>> units;  // of each signal
  std::string map, other;
  for (const RecordingQuestion& q : questions) {
    std::istringstream words(q.units);
    for (std::string word; std::getline(words, word, ',');) units.emplace_back(word.substr(0, word.find('=')), word.substr(word.find('=') + 1));
    map = joined(map, q.map);
    if (!q.other.empty()) other += (other.empty() ? "" : " ") + q.other;
  }
  std::string out;
  for (const auto& [signal, unit] : units) {
    // The sign of one joint keeps the unit that all have.
    const std::string whole = signal.substr(0, signal.find_last_not_of("0123456789") + 1);
    const auto all = std::find_if(units.begin(), units.end(), [&](const auto& one) { return one.first == whole; });
    const bool sign_alone = whole != signal && unit[0] == '-' && all != units.end();
    out = joined(out, signal + "=" + (!sign_alone ? unit : all->second[0] == '-' ? all->second.substr(1) : "-" + all->second));
  }
  if (!out.empty()) out = "--units " + out;
  if (!map.empty()) out += (out.empty() ? "" : " ") + ("--map " + map);
  return out.empty() || other.empty() ? out + other : out + " " + other;
}

bool concern_robot(const std::vector<RecordingQuestion>& set) {
  return std::any_of(set.begin(), set.end(), [](const RecordingQuestion& q) { return static_cast<bool>(q.robot); });
}

Model applied(const std::vector<RecordingQuestion>& set, const Model& arm) {
  ModelDescription d = arm.description();
  for (const RecordingQuestion& q : set) {
    if (q.robot) q.robot(d);
  }
  return Model(std::move(d));
}

void apply_to(const std::vector<RecordingQuestion>& set, Recording& recording) {
  for (const bool exchanges : {true, false}) {
    for (const RecordingQuestion& q : set) {
      if (q.recording && q.map.empty() != exchanges) q.recording(recording);
    }
  }
}

}  // namespace veridyn
