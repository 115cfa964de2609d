#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <set>

#include "hide_and_seek/swept_room.hpp"
#include "identification/identification_numbers.hpp"
#include "identification/synthetic_recording.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/identification/base_parameters.hpp"
#include "veridyn/simulation/plausible_model.hpp"

namespace veridyn::seek {
namespace {

using Numbers = IdentificationNumbers;

constexpr double kNoise = 0.03;  // share of the torques
constexpr double kMass = 2.0;    // [kg]

// Recordings of a SCARA with what is wrong in them, and the right answer in words.
struct Taken {
  const char* name;
  const char* right;  // states of the joints, or a status; "*": each is right
  MotionShape shape;
  void (*spoil)(Recording&) = [](Recording&) {};
  int recordings = 1;
  double noise = kNoise;
  bool in_file = false;
};

MotionShape shaped(double duration, double period = 0.0, double rate = 100.0) {
  MotionShape out;
  out.duration = duration;
  out.rate = rate;
  out.period = period;
  return out;
}

double rms(const VectorXd& values) { return std::sqrt(values.squaredNorm() / static_cast<double>(values.size())); }

// A force that no column has, as a share of the joint's torque.
template <int percent>
void unknown_force(Recording& r) {
  const VectorXd q = r.q.col(0);
  VectorXd force = (25.0 * q.array()).sin();
  force *= 0.01 * percent * rms(r.tau.col(0)) / rms(force);
  r.tau.col(0) += force;
}

// The motion of a joint scaled to a travel; its torques are not those of this motion.
void travel(Recording& r, int joint, double length) {
  const double factor = length / (r.q.col(joint).maxCoeff() - r.q.col(joint).minCoeff());
  r.q.col(joint) *= factor;
  r.dq.col(joint) *= factor;
}

void without_rows(Recording& r, const std::vector<Eigen::Index>& gone) {
  Recording out = r;
  Eigen::Index kept = 0;
  for (Eigen::Index k = 0; k < r.rows(); ++k) {
    if (std::find(gone.begin(), gone.end(), k) != gone.end()) continue;
    out.time[kept] = r.time[k];
    out.q.row(kept) = r.q.row(k);
    out.dq.row(kept) = r.dq.row(k);
    out.tau.row(kept++) = r.tau.row(k);
  }
  r = rows_of(out, 0, static_cast<int>(kept));
}

const std::vector<Taken>& all_taken() {
  static const std::vector<Taken> kAll = {
      {"no repeats", "cannot_tell cannot_tell cannot_tell cannot_tell", shaped(20.0)},
      {"repeats", "at_floor at_floor at_floor at_floor", shaped(20.0, 4.0)},
      {"short", "cannot_tell cannot_tell cannot_tell cannot_tell", shaped(6.0)},
      {"an unknown force", "unexplained at_floor at_floor at_floor", shaped(20.0, 4.0), unknown_force<8>},
      {"a smaller unknown force", "unexplained at_floor at_floor at_floor", shaped(20.0, 4.0), unknown_force<3>},
      {"a negligible force", "at_floor at_floor at_floor at_floor", shaped(20.0, 4.0), unknown_force<1>},
      {"a force below any sensor", "at_floor at_floor at_floor at_floor", shaped(20.0, 4.0), unknown_force<1>, 1, 0.003},
      {"a joint at rest", "rank_deficient", shaped(20.0), [](Recording& r) { travel(r, 1, 1e-3); }},
      {"a slide at rest", "rank_deficient", shaped(20.0), [](Recording& r) { travel(r, 2, 1e-4); }},
      {"a joint that hardly moves", "cannot_tell hardly_moved cannot_tell cannot_tell", shaped(20.0), [](Recording& r) { travel(r, 1, 3e-3); }},
      {"a slide that hardly moves", "cannot_tell cannot_tell hardly_moved cannot_tell", shaped(20.0), [](Recording& r) { travel(r, 2, 3e-4); }},
      {"a joint that moves a little", "cannot_tell hardly_moved cannot_tell cannot_tell", shaped(20.0), [](Recording& r) { travel(r, 1, 0.1); }},
      {"one joint without torque", "no_torque", shaped(20.0), [](Recording& r) { r.tau.col(3).setZero(); }},
      {"no torques", "no model", shaped(10.0), [](Recording& r) { r.tau.setZero(); }},
      {"rounding for torques", "no model", shaped(10.0), [](Recording& r) { r.tau *= 7e-13 / r.tau.cwiseAbs().maxCoeff(); }},
      {"a poor velocity", "derived", shaped(20.0), [](Recording& r) { r.dq.col(1) += noise_like(r.dq, 0.2, 7).col(1); }},
      {"a noisy velocity", "derived", shaped(20.0), [](Recording& r) { r.dq.col(1) += noise_like(r.dq, 0.02, 7).col(1); }},
      {"a little noisy velocity", "*", shaped(20.0), [](Recording& r) { r.dq.col(1) += noise_like(r.dq, 0.003, 7).col(1); }},
      {"a gap", "gaps", shaped(120.0), [](Recording& r) { without_rows(r, {700, 701, 702, 703, 704, 705, 706, 707, 708, 709, 710, 711}); }},
      {"a small gap", "gaps", shaped(120.0), [](Recording& r) { without_rows(r, {700, 701, 702, 703, 704, 705}); }},
      {"repeats with gaps", "at_floor at_floor at_floor at_floor", shaped(20.0, 4.0), [](Recording& r) { without_rows(r, {700, 701, 702, 703, 704, 705, 706, 1000, 1001, 1002}); }},
      {"slow samples", "at_floor at_floor at_floor at_floor", shaped(60.0, 12.0, 25.0)},
      {"few repeats", "at_floor at_floor at_floor at_floor", shaped(13.0, 8.0)},
      {"hardly a repeat", "cannot_tell cannot_tell cannot_tell cannot_tell", shaped(9.0, 8.0)},
      {"long repeats", "at_floor at_floor at_floor at_floor", shaped(200.0, 70.0, 50.0), [](Recording&) {}, 1, kNoise, true},
      {"many recordings", "cannot_tell cannot_tell cannot_tell cannot_tell", shaped(8.0), [](Recording&) {}, 24}};
  return kAll;
}

std::string without_digits(const std::string& words) {
  std::string out;
  for (const char c : words) {
    if (std::string("0123456789.-+%").find(c) == std::string::npos) out += c;
  }
  return out;
}

// States, what is said beside them, and how many clusters the deviations have.
SweepAnswer answer(const Model& arm, const Taken& taken, const Recordings& recordings, const Numbers& numbers) {
  const Identification id = identify(arm, recordings, {}, {}, numbers);
  std::string said;
  if (!id.model) {
    said = id.undetermined.empty() ? "no model: " : fmt::format("rank_deficient in {}: ", id.undetermined.size());
    said += without_digits(id.reason);
    return {said.find(taken.right) == 0, said};
  }
  for (const IdentifiedJoint& j : verdict_of(id, numbers).joints) said += (said.empty() ? "" : " ") + std::string(name_of(j.state));
  bool right = std::string(taken.right) == "*" || said.find(taken.right) != std::string::npos;
  if (id.model->description().identified) said += fmt::format(" of {} clusters", id.model->description().identified->clusters);
  for (const std::string& remark : id.remarks) {
    said += " | " + without_digits(remark);
    right = right || (std::string(taken.right) == "derived" && remark.find("derivative") != std::string::npos);
    right = right || (std::string(taken.right) == "gaps" && remark.find("gaps") != std::string::npos);
  }
  return {right, said};
}

// Poses of an arm, with motions between them: rows at rest, then rows that move.
struct Rests {
  const char* name;
  int poses, rows;
  double creep;            // largest speed at rest [rad/s]; a fifth of it [m/s] where a joint slides
  double spread = 1.0;     // of the poses
  bool reversals = false;  // moments of rest between poses that are no poses
  bool determined = true;
};

Recording recorded(const Model& arm, const Rests& how, unsigned seed) {
  Random random(seed);
  RigidBodyDynamics bodies(arm, *arm.inertial_values());
  std::vector<Eigen::Vector3d> q, dq, tau;
  VectorXd g(3);
  const Eigen::Vector3d scale(0.8, 0.5, 0.05);
  const auto hold = [&](int rows, double wrong) {
    const Eigen::Vector3d at =
        Eigen::Vector3d(0.1, 0.2, 0.12) + how.spread * Eigen::Vector3d(scale.cwiseProduct(random.vector(3, -1.0, 1.0)));
    bodies.gravity_torques(at, g);
    for (int k = 0; k < rows; ++k) {
      q.push_back(at);
      dq.emplace_back(how.creep * Eigen::Vector3d(1.0, 1.0, 0.2).cwiseProduct(random.vector(3, -1.0, 1.0)));
      tau.emplace_back(wrong * g + 0.01 * random.vector(3, -1.0, 1.0));
    }
    for (int k = 0; k < 8; ++k) {
      q.push_back(at);
      dq.emplace_back(0.7 * random.vector(3, -1.0, 1.0).array().sign().matrix());
      tau.emplace_back(g);
    }
  };
  for (int p = 0; p < how.poses; ++p) {
    hold(how.rows, 1.0);
    if (how.reversals) hold(4, 3.0);
  }
  Recording out;
  const auto rows = static_cast<Eigen::Index>(q.size());
  out.source = how.name;
  out.time = VectorXd::LinSpaced(rows, 0.0, 0.01 * static_cast<double>(rows - 1));
  out.q.resize(rows, 3);
  out.dq.resize(rows, 3);
  out.tau.resize(rows, 3);
  for (Eigen::Index k = 0; k < rows; ++k) {
    out.q.row(k) = q[k];
    out.dq.row(k) = dq[k];
    out.tau.row(k) = tau[k];
  }
  return out;
}

SweepAnswer answer(const Model& arm, const Rests& rests, const Recording& recording, const Numbers& numbers) {
  PreprocessingOptions how;
  how.in_memory[rests.name] = std::make_shared<const Recording>(recording);
  const RestPoses poses = read_rest_poses(arm, rests.name, how, {}, numbers);
  const Identification id = identify_at_rest(arm, {poses}, {}, {}, numbers);
  std::string said = fmt::format("{} poses", poses.poses());
  if (!id.model) return {!rests.determined, said + ": " + without_digits(id.reason)};
  said += fmt::format(", {} parameters of {} clusters", id.base.size(), id.model->description().identified->clusters);
  return {rests.determined && poses.poses() == rests.poses, said};
}

// Recordings with and without a known mass, in a file's order.
struct Weighed {
  const char* name;
  std::vector<double> masses;  // of each recording [kg]; the named mass is kMass
  bool named;                  // the loaded recordings are
  double noise = 0.02;
  double seconds = 12.0;
  int identifiable = 6;
};

const std::vector<Weighed>& all_weighed() {
  static const std::vector<Weighed> kAll = {{"a known mass", {0.0, 0.0, kMass}, true},
                                            {"a mass somewhere", {0.0, kMass, 0.0}, false},
                                            {"a mass that is not there", {0.0, 0.0, 0.0}, true, 0.02, 12.0, 0},
                                            {"a mass under noise", {0.0, 0.0, kMass}, true, 0.4},
                                            {"a mass under much noise", {0.0, kMass}, true, 3.0, 6.0, 0},
                                            {"short recordings", {0.0, kMass}, true, 0.02, 2.0},
                                            {"a mass in one of six", {0.0, 0.0, 0.0, kMass, 0.0, 0.0}, false, 0.02, 4.0}};
  return kAll;
}

Model loaded(const Model& arm, double mass) {
  ModelDescription d = arm.description();
  Frame box;
  box.name = "box";
  box.parent = FrameIndex{static_cast<int>(arm.frames().size()) - 1};
  box.body = Body{};
  Eigen::Matrix<double, 6, 1> inertia;
  inertia << 0.13, 0.0, 0.1, 0.0, 0.0, 0.05;
  box.body->phi = inertial_parameters(mass, Eigen::Vector3d(0.02, 0.1, 0.05), mass / 12.0 * inertia);
  d.frames.push_back(box);
  return Model(std::move(d));
}

SweepAnswer answer(const Model& arm, const Weighed& weighed, const PreprocessingOptions& how, const Numbers& numbers) {
  std::vector<std::string> names;
  KnownMass mass{kMass, arm.frames().back().name, {}};
  for (size_t k = 0; k < weighed.masses.size(); ++k) names.push_back(fmt::format("take-{}", k));
  if (weighed.named) mass.recordings = {names.back()};
  const DriveGains found = find_drive_gains(arm, names, {mass}, how, 1, numbers);
  int identifiable = 0;
  std::string said = without_digits(found.problem);
  for (const DriveGain& g : found.joints) {
    identifiable += g.identifiable ? 1 : 0;
    said += fmt::format("; {} {}", g.identifiable ? "gain" : "open", without_digits(g.reason));
  }
  bool loads = found.problem.empty() == (weighed.identifiable > 0);
  for (size_t k = 0; k < names.size() && !found.loads.empty() && weighed.identifiable > 0; ++k) {
    const std::vector<std::string>& carry = found.loads.front().known.recordings;
    loads = loads && (std::find(carry.begin(), carry.end(), names[k]) != carry.end()) == (weighed.masses[k] > 0.0);
  }
  return {loads && (identifiable == weighed.identifiable || weighed.identifiable == 0), said + fmt::format(" of {} clusters", found.clusters)};
}

}  // namespace

SweptRoom identification_room(unsigned seed, const std::string& folder) {
  std::vector<TableCase<Numbers>> cases;
  const Model scara = read_model(VERIDYN_SOURCE_DIR "/data/robots/scara.yaml");
  for (const Taken& taken : all_taken()) {
    Recordings recordings;
    for (int k = 0; k < taken.recordings; ++k) {
      MotionShape shape = taken.shape;
      shape.seed = seed + static_cast<unsigned>(k);
      Recording r = synthetic_recording(scara, shape);
      r.tau += noise_like(r.tau, taken.noise, seed + 100 + static_cast<unsigned>(k));
      taken.spoil(r);
      if (taken.in_file) {
        std::filesystem::create_directories(folder);
        const std::string path = folder + "/identification.csv";
        write_recording(r, path);
        recordings.add(path);
      } else {
        recordings.add(r);
      }
    }
    cases.emplace_back(taken.name, [scara, taken, recordings](const Numbers& n) { return answer(scara, taken, recordings, n); });
  }
  const Model psm = plausible_model(read_model("psm-3dof"), 3).arm;
  for (const Rests& rests : std::vector<Rests>{{"poses", 60, 20, 0.0},
                                               {"creeping poses", 60, 20, 4e-3},
                                               {"short poses", 60, 6, 0.0},
                                               {"poses and reversals", 60, 20, 0.0, 1.0, true},
                                               {"few poses", 6, 20, 0.0},
                                               {"one pose", 20, 20, 0.0, 1e-7}}) {
    cases.emplace_back(rests.name, [psm, rests, r = recorded(psm, rests, seed)](const Numbers& n) { return answer(psm, rests, r, n); });
  }
  const std::size_t first_weighed = cases.size();
  const Model elbow = read_model("elbow-6r");
  for (const Weighed& weighed : all_weighed()) {
    PreprocessingOptions how;
    for (size_t k = 0; k < weighed.masses.size(); ++k) {
      MotionShape shape = shaped(weighed.seconds);
      shape.seed = seed + static_cast<unsigned>(k);
      Recording r = synthetic_recording(weighed.masses[k] > 0.0 ? loaded(elbow, weighed.masses[k]) : elbow, shape);
      r.current = r.tau + noise_like(r.tau, weighed.noise, seed + 50 + static_cast<unsigned>(k));
      for (Eigen::Index j = 0; j < r.current.cols(); ++j) r.current.col(j) /= 12.0 - 2.0 * static_cast<double>(j);
      r.tau.resize(0, 0);
      how.in_memory[fmt::format("take-{}", k)] = std::make_shared<const Recording>(r);
    }
    cases.emplace_back(weighed.name, [elbow, weighed, how](const Numbers& n) { return answer(elbow, weighed, how, n); });
  }
  // Numbers of gains are asked of known masses alone, which take longest, and those of rests of poses.
  SweptRoom out = room_of(identification_numbers(), cases);
  const std::set<std::string> of_gains = {"identifiable", "heavier", "fewest_clusters", "unloaded", "most_divisions", "untied"};
  const std::set<std::string> of_blocks = {"most_blocks", "phases", "first_block", "period_time"};
  for (std::size_t k = 0; k < cases.size(); ++k) {
    const bool weighed = k >= first_weighed;
    out.cases[k].concerns = [weighed, of_gains, of_blocks](const std::string& number) {
      return weighed ? of_gains.count(number) + of_blocks.count(number) > 0 : of_gains.count(number) == 0;
    };
  }
  return out;
}

}  // namespace veridyn::seek
