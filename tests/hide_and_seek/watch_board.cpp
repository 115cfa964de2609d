#include <fmt/format.h>

#include <set>

#include "hide_and_seek/swept_room.hpp"
#include "support/simulated.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/simulation/plausible_model.hpp"
#include "veridyn/diagnosis/watch.hpp"
#include "diagnosis/watch/onsets.hpp"
#include "diagnosis/watch/watch_numbers.hpp"

namespace veridyn::seek {
namespace {

constexpr double kOnset = 9.0, kEnd = 20.0;  // [s]
constexpr int kPiece = 37;                   // rows that arrive together

// What changes at the onset, or is there all the time, and the causes of the events that tell it.
struct WatchCase {
  const char* name;
  std::vector<std::string> before, after;  // hidden effects, in text form
  std::set<std::string> causes;
  void (*spoil)(Recording&) = [](Recording&) {};
};

void pause(Recording& r) { r.time.tail(static_cast<Eigen::Index>((kEnd - kOnset) * WatchedArm::kRate)).array() += 4.0; }

void without_velocities(Recording& r) { r.dq.resize(0, 0); }

void in_degrees(Recording& r) { r.dq.col(1) *= 180.0 / M_PI; }

void damaged(Recording& r) {
  r.tau.row(700).setConstant(1e9);
  for (Eigen::Index k = 1001; k < 1015; ++k) {
    for (const RecordingSignal& signal : kRecordingSignals) {
      if ((r.*signal.values).size() > 0) (r.*signal.values).row(k) = (r.*signal.values).row(1000);
    }
  }
}

const std::vector<WatchCase>& watch_cases() {
  static const std::vector<WatchCase> kAll = {
      {"nothing", {}, {}, {}},
      {"nothing but damaged rows", {}, {}, {}, damaged},
      {"nothing without velocities", {}, {}, {}, without_velocities},
      {"load", {}, {"payload:tool:mass=0.3"}, {"payload:tool"}},
      {"light load", {}, {"payload:tool:mass=0.06"}, {"payload:tool"}},
      {"load and a velocity in degrees", {}, {"payload:tool:mass=0.3"}, {"payload:tool"}, in_degrees},
      {"load after a pause", {}, {"payload:tool:mass=0.3"}, {"payload:tool"}, pause},
      {"load all the time", {"payload:tool:mass=0.3"}, {"payload:tool:mass=0.3"}, {"payload:tool"}},
      {"friction", {}, {"coulomb_friction:pitch:level=0.3"}, {"coulomb_friction:pitch"}},
      {"little friction", {}, {"coulomb_friction:yaw:level=0.06"}, {"coulomb_friction:yaw"}},
      {"damping", {}, {"viscous_friction:yaw:coefficient=0.4"}, {"viscous_friction:yaw"}},
      {"offset", {}, {"torque_offset:yaw:offset=0.2"}, {"torque_offset:yaw"}},
      {"offset all the time", {"torque_offset:pitch:offset=0.3"}, {"torque_offset:pitch:offset=0.3"}, {"torque_offset:pitch"}},
      {"gain", {}, {"torque_gain:pitch:gain=1.3"}, {"torque_gain:pitch"}},
      {"slip", {}, {"encoder_offset:pitch:offset=0.02"}, {"encoder_offset:pitch"}},
      {"small slip", {}, {"encoder_offset:yaw:offset=0.003"}, {"encoder_offset:yaw"}},
      {"push", {}, {"external_contact:pitch:from=9,to=9.8,effort=1"}, {"external_contact:pitch"}},
      {"short push", {}, {"external_contact:yaw:from=9,to=9.3,effort=1"}, {"external_contact:yaw"}}};
  return kAll;
}

SweepAnswer watched(const Model& arm, const Recording& rows, const std::set<std::string>& causes,
                    const WatchNumbers& numbers) {
  Watch watch(arm, {}, numbers);
  for (int k = 0; k < rows.rows(); k += kPiece) watch.add(rows_of(rows, k, std::min(kPiece, rows.rows() - k)));
  watch.finish();
  std::set<std::string> named;
  std::string said;
  for (const WatchEvent& e : watch.events()) {
    if (e.stage == WatchStage::kSuspected || e.stage == WatchStage::kBlind) continue;
    if (e.stage == WatchStage::kWithdrawn) {
      named.erase(e.text);
    } else {
      named.insert(e.text);
    }
    said += fmt::format("{}{} {}", said.empty() ? "" : "; ", name_of(e.stage), e.text);
  }
  return {named == causes, said.empty() ? "nothing" : said};
}

}  // namespace

SweptRoom watch_room(unsigned seed) {
  const WatchedArm bench;
  const MotionSamples motion = watched_waves(kEnd);
  std::vector<TableCase<WatchNumbers>> cases;
  for (const WatchCase& one : watch_cases()) {
    Recording rows = joined(bench.recorded(motion, one.before, seed), bench.recorded(motion, one.after, seed), kOnset, kEnd);
    one.spoil(rows);
    cases.emplace_back(one.name, [arm = bench.arm, rows, causes = one.causes](const WatchNumbers& numbers) {
      return watched(arm, rows, causes, numbers);
    });
  }
  return room_of(watch_numbers(), cases);
}

}  // namespace veridyn::seek
