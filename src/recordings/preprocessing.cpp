#include "veridyn/recordings/preprocessing.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <optional>

#include "recordings/kept_recordings.hpp"
#include "recordings/named_recordings.hpp"
#include "recordings/same_recording.hpp"
#include "recordings/signals/units.hpp"
#include "recordings/uniform_stream.hpp"
#include "veridyn/math/require.hpp"
#include "math/zero_phase_filter.hpp"

namespace veridyn {
namespace {

constexpr Eigen::Index kCore = 4096;  // smallest number of samples in one segment
// Ratio of the rows in a segment's core to those around it: if it is large, few samples are filtered twice.
constexpr Eigen::Index kCorePerHalo = 3;
constexpr double kHaloRemainder = 1e-9;  // remainder of the filter's transient at the core
constexpr Eigen::Index kDerivatives =
    4;  // number of samples on either side that two successive central differences use
constexpr double kPreparedBytes = 1.5 * sizeof(double);  // bytes for each number of a segment, with the rows around its core

std::atomic<long> g_prepared{0};

// cut-off >= kSlowestCutoff * sampling rate, and as far below half of it: else the filter's transient is longer
// than any recording.
constexpr double kSlowestCutoff = 1e-5;
/// sampling rate < kSlowClock [Hz]: times are more likely milliseconds than seconds.
constexpr double kSlowClock = 1.5;
constexpr double kNyquistShare = 0.45;  // share of the rate; a light filter with a higher cut-off is omitted

struct Filters {
  std::optional<ZeroPhaseFilter> main;
  std::optional<ZeroPhaseFilter> light;
  Eigen::Index halo = kDerivatives;

  Filters(const PreprocessingOptions& o, double dt, const std::string& source) {
    const double rate = 1.0 / dt;
    if (o.cutoff <= 0.0) return;
    const bool below = o.cutoff <= (0.5 - kSlowestCutoff) * rate;
    require(below || o.cutoff != PreprocessingOptions().cutoff, source, ": found a sampling rate of ", rate,
            " Hz, expected more than ", 2.0 * o.cutoff, " Hz, twice the filter's cut-off", rate < kSlowClock ? text("; t in ", recordings::unit_of_clock(dt), "? --units t=", recordings::unit_of_clock(dt), ".") : std::string("; --filter-cutoff changes it."));
    require(below, "--filter-cutoff: found ", o.cutoff,
            " Hz, expected above 0 and below ", 0.5 * rate, " Hz, half the sampling rate.");
    require(o.cutoff >= kSlowestCutoff * rate, "--filter-cutoff: found ", o.cutoff, " Hz, expected at least ",
            kSlowestCutoff * rate, " Hz at a sampling rate of ", rate, " Hz, or 0 for no filter.");
    main.emplace(o.cutoff, o.order, rate);
    halo += main->settling_samples(kHaloRemainder);
    const double light_cutoff = o.signal_cutoff_ratio * o.cutoff;
    if (o.filtering == Filtering::kMatched && light_cutoff < kNyquistShare * rate) {
      light.emplace(light_cutoff, o.order, rate);
      halo += light->settling_samples(kHaloRemainder);
    }
  }
};

// Marks samples near invalid ones, which depend on interpolation, as invalid too.
std::vector<char> widened(const std::vector<char>& sound, Eigen::Index margin) {
  std::vector<char> use(sound.size(), 1);
  const auto n = static_cast<Eigen::Index>(sound.size());
  for (Eigen::Index i = 0; i < n; ++i) {
    if (sound[i] != 0) continue;
    for (Eigen::Index j = std::max<Eigen::Index>(0, i - margin); j <= std::min(n - 1, i + margin);
         ++j)
      use[j] = 0;
  }
  return use;
}

// Removes the delays of recorded torques.
void undo_delays(const JointSensors& sensors, double dt, MatrixXd& tau) {
  for (int j = 0; j < sensors.joints(); ++j) {
    if (sensors.torque_delay({j}) == 0.0) continue;
    const VectorXd recorded = tau.col(j);
    for (Eigen::Index k = 0; k < tau.rows(); ++k)
      tau(k, j) = sensors.torque_at({j}, k, tau.rows(), dt, [&](Eigen::Index i) { return recorded[i]; });
  }
}

Segment make_segment(const Model& arm, const UniformStream& stream, Eigen::Index rows,
                     const PreprocessingOptions& o, const Filters& f) {
  const int n = arm.joints();
  Segment s;
  s.dt = stream.dt();
  s.start = stream.start();
  s.time.resize(rows);
  for (Eigen::Index i = 0; i < rows; ++i)
    s.time[i] = stream.start() + static_cast<double>(stream.first_index() + i) * s.dt;
  const auto samples = stream.samples().topRows(rows);
  s.q = samples.leftCols(n);
  if (stream.has_velocity()) s.dq = samples.middleCols(n, n);
  s.tau = samples.rightCols(n);
  undo_delays(stream.sensors(), s.dt, s.tau);
  const bool signals = o.filtering == Filtering::kSignals;
  const ZeroPhaseFilter* filter =
      signals ? (f.main ? &*f.main : nullptr) : (f.light ? &*f.light : nullptr);
  if (filter != nullptr) filter->apply(s.q);
  if (!stream.has_velocity()) {
    s.dq = differentiate(s.q, s.dt);
  } else if (filter != nullptr) {
    filter->apply(s.dq);
  }
  for (const auto [j] : o.derive_velocity_of) {
    if (stream.has_velocity() && j < n) s.dq.col(j) = differentiate(s.q.col(j), s.dt);
  }
  s.ddq = differentiate(s.dq, s.dt);
  if (signals && f.main) f.main->apply(s.tau);
  const double margin = o.cutoff > 0.0 ? 0.5 / o.cutoff : 0.0;
  s.use = widened({stream.sound().begin(), stream.sound().begin() + rows},
                  static_cast<Eigen::Index>(margin / s.dt));
  return s;
}

PreparationFacts run(const Model& arm, const std::string& name, UniformStream::Source source,
                     const PreprocessingOptions& o,
                     const std::function<void(const Segment&)>& visit) {
  ++g_prepared;
  RowSample sample;
  long at = 0;
  source = [&, read = std::move(source)](int wanted) {
    Recording piece = read(wanted);
    sample.add(piece, o.first_row - at, o.row_count ? o.first_row + *o.row_count - at : piece.rows());
    at += piece.rows();
    return piece;
  };
  SoundRows sound(source);
  if (o.stale_rows == StaleRows::kFilled)
    source = [&sound](int wanted) { return sound.next(wanted); };
  UniformStream stream(arm, name, std::move(source), o);
  const double dt = stream.dt();
  const Filters filters(o, dt, name);
  PreparationFacts facts;
  facts.dt = dt;
  // Number of samples to read ahead: the filters have to settle, and the samples to cut at the end must be
  // known.
  const Eigen::Index ahead =
      std::max(filters.halo, static_cast<Eigen::Index>(std::ceil(o.drop_end / dt)));
  const Eigen::Index core = std::max(kCore, kCorePerHalo * filters.halo);
  Eigen::Index behind = 0;  // samples before the core in which the filters have settled
  Eigen::Index discard = 0;
  while (true) {
    if (o.interrupted && o.interrupted()) throw Interrupted();
    const Eigen::Index held = stream.hold(behind + core + ahead + 1, discard);
    const bool last = stream.ended() && held <= behind + core + filters.halo;
    const Eigen::Index rows = last ? held : behind + core + filters.halo;
    Segment s = make_segment(arm, stream, rows, o, filters);
    s.core_begin = behind;
    s.core_end = last ? rows : behind + core;
    const double t_end =
        stream.ended() ? s.time[0] + static_cast<double>(held - 1) * dt - o.drop_end : 1e300;
    const double t_begin = stream.start() + o.drop_start;
    for (Eigen::Index i = s.core_begin; i < s.core_end; ++i) {
      const double t = s.time[i];
      const double tolerance = 1e-6 * dt;
      facts.unused += static_cast<long>(s.use[i] == 0);
      if (t < t_begin - tolerance || t > t_end + tolerance ||
          t < stream.first_wanted_time() - tolerance || t > stream.last_wanted_time() + tolerance) {
        s.use[i] = 0;
      }
    }
    facts.samples += static_cast<long>(s.core_end - s.core_begin);
    facts.duration = s.time[s.core_end - 1] - stream.start();
    if (s.core_end > s.core_begin) visit(s);
    if (last) break;
    const Eigen::Index keep_from = std::max<Eigen::Index>(0, s.core_end - filters.halo);
    discard = keep_from;
    behind = s.core_end - keep_from;
  }
  facts.rows_read = stream.rows_read();
  facts.filled = sound.filled();
  facts.row_hashes = sample.hashes();
  return facts;
}

// Every pose at rest is a segment of its own, because neighbouring rows are not neighbours in time.
PreparationFacts for_each_pose(const Model& arm, const Recording& poses, const std::function<void(const Segment&)>& visit) {
  const int n = arm.joints();
  require(poses.joints() == n && poses.dq.cols() == n && (poses.tau.cols() == n || poses.current.cols() == n) && poses.rows() > 0, poses.source,
          ": found ", poses.rows(), " poses of ", poses.joints(), " joints, expected poses of the ", n, " of robot '", arm.name(), "' with their torques.");
  require(poses.q.allFinite() && poses.dq.allFinite() && poses.tau.allFinite() && poses.current.allFinite(), poses.source,
          ": found a pose with a number that is not finite, expected poses at rest.");
  const JointSensors sensors(arm);
  Segment s;
  s.dt = 1.0;
  s.use = {1};
  s.at_rest = true;
  s.core_end = 1;
  s.ddq = MatrixXd::Zero(1, arm.joints());
  for (int k = 0; k < poses.rows(); ++k) {
    VectorXd q = poses.q.row(k).transpose(), tau = (poses.tau.size() > 0 ? poses.tau : poses.current).row(k).transpose();
    sensors.correct_positions(q);
    poses.tau.size() > 0 ? sensors.correct_torques(tau) : sensors.correct_currents(tau);
    s.time = VectorXd::Constant(1, poses.time[k]);
    s.q = q.transpose();
    s.dq = kApproachSpeed * poses.dq.row(k);
    s.tau = tau.transpose();
    visit(s);
  }
  PreparationFacts facts;
  facts.dt = s.dt;
  facts.samples = facts.rows_read = poses.rows();
  return facts;
}

// Visits the stretches of a recording in memory, under the name that options and messages use.
PreparationFacts for_each_stretch_of(const Model& arm, const std::string& name,
                                     const Recording& recording,
                                     const PreprocessingOptions& options,
                                     const std::function<void(const Segment&)>& visit) {
  if (recording.poses) return for_each_pose(arm, recording, visit);
  int at = 0;
  const auto source = [&](int rows) {
    const int count = std::min(rows, recording.rows() - at);
    at += count;
    Recording part = rows_of(recording, at - count, count);
    part.source = name;
    return part;
  };
  return run(arm, name, source, options, visit);
}

}  // namespace

double SampleWeights::at(JointIndex joint, double seconds) const {
  constexpr double kSameInstant = 1e-6;  // [s]
  const auto next = std::lower_bound(time.begin(), time.end(), seconds - kSameInstant);
  return next == time.end() ? 1.0 : of_joint(next - time.begin(), joint.value);
}

std::vector<WantedJoint> joints_of(const Model& arm) {
  std::vector<WantedJoint> joints;
  for (const Coordinate& c : arm.coordinates()) joints.push_back({c.name, c.prismatic, c.limits.lower, c.limits.upper, c.limits.effort});
  return joints;
}

Recordings read_recordings(const Model& arm, const std::vector<std::string>& paths,
                           const PreprocessingOptions& options) {
  const RecordingOptions how = recording_options_for(arm, options);
  Recordings out;
  for (const std::string& path : paths) out.add(read_recording(path, how));
  return out;
}

RecordingOptions recording_options_for(const Model& arm, const PreprocessingOptions& options) {
  RecordingOptions reading;
  reading.columns = options.columns;
  reading.rate = options.header_rate;
  reading.signals = options.signals;
  reading.signals.joints = joints_of(arm);
  return reading;
}

namespace {

// Memory of all segments of a recording with these rows [bytes]; negative: they are not kept.
long prepared_bytes(const Model& arm, const Recording* rows, const PreprocessingOptions& options) {
  if (rows == nullptr || rows->rows() < 2) return -1;
  const double seconds = rows->time[rows->rows() - 1] - rows->time[0];
  const double samples = options.rate > 0.0 ? options.rate * seconds : rows->rows();
  return static_cast<long>(kPreparedBytes * samples * (4.0 * arm.joints() + 2.0));
}

PreparationFacts visit_segments_of_named(const Model& arm, const std::string& name,
                           const PreprocessingOptions& options,
                           const std::function<void(const Segment&)>& visit) {
  if (const Recording* there = find_in_memory(options.in_memory, name))
    return for_each_stretch_of(arm, name, *there, options, visit);
  const OpenedRows rows = open_rows(name, recording_options_for(arm, options), options.kept.get());
  return run(arm, name, rows.next, options, visit);
}

}  // namespace

PreparationFacts for_each_segment(const Model& arm, const std::string& path,
                                  const PreprocessingOptions& options,
                                  const std::function<void(const Segment&)>& visit) {
  if (!options.kept) return visit_segments_of_named(arm, path, options, visit);
  const Recording* rows = find_in_memory(options.in_memory, path);
  std::shared_ptr<const KeptRecordings::Whole> file;
  if (rows == nullptr && (file = options.kept->find(path, recording_options_for(arm, options)))) rows = &file->rows;
  const auto prepared = options.kept->prepared(
      preparation_key(arm, path, options), prepared_bytes(arm, rows, options), [&] {
        PreparedRecording out;
        out.facts = visit_segments_of_named(arm, path, options, [&out](const Segment& s) { out.segments.push_back(s); });
        return out;
      });
  if (!prepared) return visit_segments_of_named(arm, path, options, visit);
  for (const Segment& s : prepared->segments) {
    if (options.interrupted && options.interrupted()) throw Interrupted();
    visit(s);
  }
  return prepared->facts;
}

PreparationFacts for_each_segment(const Model& arm, const Recording& recording,
                                  const PreprocessingOptions& options,
                                  const std::function<void(const Segment&)>& visit) {
  return for_each_stretch_of(arm, recording.source, recording, options, visit);
}

long recordings_prepared() {
  return g_prepared.load();
}

int decimation(const PreprocessingOptions& options, double dt) {
  if (options.decimation > 0) return options.decimation;
  if (options.cutoff <= 0.0) return 1;
  return std::max(1, static_cast<int>(1.0 / (dt * 4.0 * options.cutoff)));
}

}  // namespace veridyn
