#include <fmt/format.h>

#include <set>

#include "hide_and_seek/swept_room.hpp"
#include "identification/fleet/fleet_numbers.hpp"
#include "identification/synthetic_recording.hpp"
#include "veridyn/identification/factor_set.hpp"
#include "veridyn/files/model_file.hpp"

namespace veridyn::seek {
namespace {

constexpr double kFrictionVaries = 0.05, kGainVaries = 0.005;  // from arm to arm
constexpr double kNoise = 0.01;                                // share of the torques

constexpr const char* kWorn = "coulomb_friction(elbow).level";

// A fleet, and what one of its arms has otherwise, as factors.
struct OddFleet {
  const char* name;
  int arms;
  bool odd;
  double tool = 1.0, friction = 1.0, gain = 1.0;
  bool alike = false;  // the friction of all arms is the same
  bool still = false;  // one joint of one arm never moves
};

const std::vector<OddFleet>& fleets_asked() {
  static const std::vector<OddFleet> kAll = {
      {"nothing", 12, false},
      {"nothing in three arms", 3, false},
      {"nothing in five arms", 5, false},
      {"equal arms", 8, false, 1.0, 1.0, 1.0, true},
      {"a tool", 12, true, 3.0},
      {"a light tool", 12, true, 1.15},
      {"a tool among five arms", 5, true, 3.0},
      {"worn", 12, true, 1.0, 1.5},
      {"worn among five arms", 5, true, 1.0, 2.0},
      {"a little worn", 12, true, 1.0, 1.25},
      {"worn beside equal arms", 8, true, 1.0, 1.1, 1.0, true},
      {"gain", 12, true, 1.0, 1.0, 1.1},
      {"gain among four arms", 4, true, 1.0, 1.0, 1.2},
      {"a joint at rest", 8, false, 1.0, 1.0, 1.0, false, true}};
  return kAll;
}

struct Data {
  std::vector<std::string> names;
  std::vector<FactorSet> factors;
};

Data data_of(const OddFleet& asked, const Model& arm, unsigned seed) {
  const std::vector<StandardParameter> parameters = standard_parameters(arm);
  const VectorXd values = true_parameters(arm);
  const VectorXd none = VectorXd::Constant(values.size(), std::numeric_limits<double>::quiet_NaN());
  Random random(seed);
  Data out;
  for (int a = 0; a < asked.arms; ++a) {
    const bool odd = a == asked.arms / 2;
    VectorXd own = values;
    for (std::size_t p = 0; p < parameters.size(); ++p) {
      double& value = own[static_cast<Eigen::Index>(p)];
      const double varies = 1.0 + kFrictionVaries * random.in(-1.0, 1.0);
      if (parameters[p].effect && !asked.alike) value *= varies;
      if (odd && parameters[p].name == kWorn) value *= asked.friction;
      if (odd && parameters[p].body == 3) value *= asked.tool;
    }
    double gain = 1.0 + kGainVaries * random.in(-1.0, 1.0);
    if (odd) gain *= asked.gain;
    MotionShape shape;
    shape.duration = 10.0;
    shape.rate = 100.0;
    shape.seed = 100 + static_cast<unsigned>(a);
    Recording r = synthetic_recording(with_values(arm, own, none), shape);
    if (asked.still && odd) {
      r.q.col(2).setConstant(r.q(0, 2));
      r.dq.col(2).setZero();
    }
    r.tau.col(1) *= gain;
    r.tau += noise_like(r.tau, kNoise, 1000 * seed + static_cast<unsigned>(a));
    FactorSet set = compress(arm, std::vector<std::string>());
    set.recordings.push_back(compress(arm, r, {}));
    out.factors.push_back(std::move(set));
    out.names.push_back(fmt::format("arm-{}", a));
  }
  return out;
}

// Right where the odd arm is told, by whatever it shows in, and no other.
SweepAnswer answer(const Fleet& fleet, const OddFleet& asked) {
  const std::string odd = fmt::format("arm-{}", asked.arms / 2);
  std::set<std::string> arms, said;
  for (const FleetOutlier& o : fleet.outliers) {
    arms.insert(o.arm);
    said.insert("outlier " + o.arm + " " + o.what);
  }
  for (const FleetLeftOut& o : fleet.other_bodies) {
    arms.insert(o.arm);
    said.insert("other bodies " + o.arm);
  }
  for (const UndeterminedArm& u : fleet.undetermined) said.insert("undetermined " + u.arm);
  if (!fleet.reason.empty()) said.insert("no model");
  for (const FleetSpread& s : fleet.spreads) said.insert(fmt::format("{} of {}", s.name, s.arms));
  std::string out;
  for (const std::string& one : said) out += (out.empty() ? "" : " | ") + one;
  return {arms == (asked.odd ? std::set<std::string>{odd} : std::set<std::string>()), out};
}

}  // namespace

SweptRoom fleet_room(unsigned seed) {
  const Model arm = read_model(VERIDYN_SOURCE_DIR "/data/robots/scara.yaml");
  std::vector<TableCase<FleetNumbers>> cases;
  for (const OddFleet& asked : fleets_asked()) {
    cases.emplace_back(asked.name, [arm, asked, data = data_of(asked, arm, seed)](const FleetNumbers& numbers) {
      return answer(identify_fleet(arm, data.names, data.factors, {}, numbers), asked);
    });
  }
  return room_of(fleet_numbers(), cases);
}

}  // namespace veridyn::seek
