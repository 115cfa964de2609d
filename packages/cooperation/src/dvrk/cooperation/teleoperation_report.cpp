#include <fmt/format.h>

#include "veridyn/files/output_file.hpp"
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
  out += latency ? fmt::format("The follower moves {:.1f} ms after the leader", 1e3 * *latency)
                 : "How late the follower moves cannot be told: no phase led it freely for longer than "
                   "0.06 s";
  out += fmt::format("; it touched with at most {:.3g} N.\n", largest_force);
  if (end != BoardEnd::kDone)
    out += fmt::format("At {:.4g} s {}: the follower was to be held, the leader free, then power went.\n",
                       fault_at, why);
  out += faults_text(after_fault, later);
  out += fmt::format("Boards at the end: {}.\n", power_text(power, not_off));
  return out;
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
