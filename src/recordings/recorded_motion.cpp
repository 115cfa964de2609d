#include "recordings/recorded_motion.hpp"

#include "veridyn/recordings/recording.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr Eigen::Index kFewest = 20;  // smallest number of rows in a segment

}  // namespace

std::vector<MotionSamples> recorded_motion(const Model& arm, const std::string& path,
                                           const PreprocessingOptions& how) {
  RecordingOptions reading = recording_options_for(arm, how);
  reading.first_row = how.first_row;
  reading.row_count = how.row_count;
  Recording rows = read_recording(path, reading);
  require_joints_of(arm, rows.joints(), path);
  const bool whole = rows.q.allFinite() && rows.dq.allFinite() && rows.ddq.allFinite();
  if (whole && rows.dq.size() == rows.q.size() && rows.ddq.size() == rows.q.size())
    return {{rows.time, rows.q, rows.dq, rows.ddq}};
  // Torques do not affect the motion and may be missing.
  rows.tau = MatrixXd::Zero(rows.q.rows(), rows.q.cols());
  PreprocessingOptions options;
  options.filtering = Filtering::kSignals;
  std::vector<MotionSamples> out;
  for_each_segment(arm, rows, options, [&](const Segment& s) {
    const Eigen::Index count = s.core_end - s.core_begin;
    if (count < kFewest) return;
    out.push_back({s.time.segment(s.core_begin, count), s.q.middleRows(s.core_begin, count),
                   s.dq.middleRows(s.core_begin, count), s.ddq.middleRows(s.core_begin, count)});
  });
  require(!out.empty(), path, ": found no segment of ", kFewest, " samples without a gap.");
  return out;
}

void require_joints_of(const Model& arm, int found, const std::string& recording) {
  const int n = arm.joints();
  if (found == n) return;
  std::string names;
  for (const Coordinate& c : arm.coordinates()) names += (names.empty() ? "" : ", ") + c.name;
  throw InvalidInput(text(recording, ": found ", found, " joints, expected the ", n, " of robot '", arm.name(), "': ", names,
                          found < n ? " (--fix NAME=VALUE holds a joint that is not recorded; files with a part of the joints each are one recording: a.csv+b.csv)."
                                    : text(" (the others are a gripper? --map ", arm.coordinates().front().name, "=1 takes the first ", n,
                                           " of them, --map NAME=NUMBER others).")));
}

}  // namespace veridyn
