#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "math/output_file.hpp"
#include "dvrk/cooperation/board_teleoperation.hpp"

namespace veridyn::dvrk {

std::string TeleoperationRun::report() const {
  std::string out = fmt::format("{}: {} cycles, {} late.\n", name, cycles, late);
  out += fmt::format("{:<22} {:>16} {:>14} {:>13} {:>12} {:>12}\n", "phase", "follows rms [mm]",
                     "largest [mm]", "moved [mm]", "touches [N]", "hand [N]");
  for (std::size_t p = 0; p < phases.size(); ++p)
    out += fmt::format("{:<22} {:>16.3f} {:>14.3f} {:>13.2f} {:>12.3f} {:>12.3f}\n", phases[p],
                       1e3 * tracking_rms[p], 1e3 * tracking_largest[p], 1e3 * follower_moved[p],
                       force_follower[p], force_hand[p]);
  out += fmt::format("The follower moves {:.1f} ms after the leader; it touched with at most {:.3g} N.\n",
                     1e3 * latency, largest_force);
  if (end != BoardEnd::kDone)
    out += fmt::format("At {:.4g} s {}: the follower held, the leader was free, then power went.\n",
                       fault_at, why);
  out += fmt::format("Boards at the end: {}.\n", describe(power));
  return out;
}

std::string to_json(const TeleoperationRun& run) {
  nlohmann::ordered_json out = {{"veridyn", "0.1.0"},
                                {"command", "cooperate"},
                                {"kind", "teleoperation"},
                                {"scenario", run.name},
                                {"status", run.met() ? "done" : "stopped"},
                                {"reason", run.why},
                                {"latency", run.latency},
                                {"largest_force", run.largest_force},
                                {"cycles", run.cycles},
                                {"late", run.late},
                                {"power", describe(run.power)}};
  out["phases"] = nlohmann::ordered_json::array();
  for (std::size_t p = 0; p < run.phases.size(); ++p)
    out["phases"].push_back({{"phase", run.phases[p]},
                             {"tracking_rms", run.tracking_rms[p]},
                             {"tracking_largest", run.tracking_largest[p]},
                             {"follower_moved", run.follower_moved[p]},
                             {"force", run.force_follower[p]},
                             {"hand_force", run.force_hand[p]}});
  return out.dump(1) + "\n";
}

void write_rows(const TeleoperationRun& run, const std::string& path) {
  OutputFile file(path);
  file.stream() << "t,leader_x,leader_y,leader_z,target_x,target_y,target_z,follower_x,follower_y,"
                   "follower_z,force,hand_x,hand_y,hand_z,clutch\n";
  for (Eigen::Index k = 0; k < run.rows.rows(); ++k) {
    std::string row = fmt::format("{:.9g}", run.rows(k, 0));
    for (Eigen::Index i = 1; i < run.rows.cols(); ++i)
      row += fmt::format(",{:.9g}", run.rows(k, i));
    file.stream() << row << '\n';
  }
  file.commit();
}

}  // namespace veridyn::dvrk
