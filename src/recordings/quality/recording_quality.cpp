#include "veridyn/recordings/recording_quality.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <functional>
#include <memory>

#include "recordings/kept_recordings.hpp"
#include "recordings/quality/quality_checks.hpp"
#include "veridyn/math/require.hpp"
#include "model/suggestion.hpp"

namespace veridyn {
namespace {

using Source = std::function<Recording(int)>;

// Counts numbers beyond +-1e6 and replaces them by gaps.
class AbsurdNumbers {
 public:
  void remove_absurd_numbers(Recording* rows) {
    for (int k = 0; k < rows->rows(); ++k) {
      const long before = numbers_;
      for (const RecordingSignal& signal : kRecordingSignals) {
        for (double& value : (rows->*signal.values).row(k)) {
          if (!(std::abs(value) > quality::numbers.absurd)) continue;
          value = quality::kNone;
          ++numbers_;
        }
      }
      if (before == 0 && numbers_ > 0) first_time_ = rows->time[k];
      bad_rows_ += numbers_ > before ? 1 : 0;
    }
    rows_ += rows->rows();
  }

  double bad_row_share() const { return quality::share_of(bad_rows_, rows_); }

  void conclude(quality::Findings* findings) const {
    if (numbers_ == 0) return;
    findings->add(Severity::kFault, QualityKind::kAbsurdNumbers, {}, {bad_row_share(), static_cast<double>(numbers_), "numbers"},
                  text(quality::counted(numbers_, "number"), " beyond +-1e6 in ", quality::percent(bad_row_share()), " of the rows, the first at t = ",
                       quality::number(first_time_), " s: the file is broken",
                       bad_row_share() < quality::numbers.hopeless_share ? " there." : "; its motion is not judged."));
  }

 private:
  long rows_ = 0, bad_rows_ = 0, numbers_ = 0;
  double first_time_ = 0.0;
};

template <typename List, typename Condition>
void erase_if(List& list, const Condition& condition) {
  list.erase(std::remove_if(list.begin(), list.end(), condition), list.end());
}

// Excludes findings that are effects of others: saturation of a slowly refreshed torque, which repeats its
// extreme value as well, and rates that follow from times in another unit.
void exclude_effects(RecordingQuality& quality) {
  const auto is_held = [all = quality.findings](const std::string& signal, std::optional<JointIndex> joint) {
    return std::any_of(all.begin(), all.end(),
                       [&](const QualityFinding& f) { return f.kind == QualityKind::kStaleSignal && f.signal == signal && f.joint == joint; });
  };
  erase_if(quality.saturated, [&](const SaturatedInterval& one) { return is_held("tau", one.joint); });
  const bool other_unit = quality.find(QualityKind::kTimeUnit) != nullptr;
  erase_if(quality.findings, [&](const QualityFinding& f) {
    const bool of_rate = f.kind == QualityKind::kRateContradiction || f.kind == QualityKind::kSampleRate;
    return (f.kind == QualityKind::kSaturation && is_held(f.signal, f.joint)) || (other_unit && of_rate);
  });
}

// Runs all tallies over all rows. The first rows have been read already.
RecordingQuality checked_quality(Recording head_rows, const std::string& file, const Source& source) {
  require(head_rows.rows() > 0, file, ": found no row, expected numbers below the header.");
  RecordingQuality quality;
  quality.file = file;
  quality.joints = head_rows.joints();
  quality::Findings findings(&quality);
  AbsurdNumbers absurd;
  absurd.remove_absurd_numbers(&head_rows);
  const double first_time = head_rows.time[0];

  const quality::Head head(head_rows);
  const std::unique_ptr<quality::Tally> rows = row_tally(head), time = time_tally(head), jumps = jump_tally(head), clips = clip_tally(head);
  Recording last;
  const auto add = [&](const quality::Piece& piece) {
    for (quality::Tally* tally : {rows.get(), time.get(), jumps.get(), clips.get()}) tally->add(piece);
    quality.rows += piece.rows.rows() - piece.fresh;
    quality.duration = piece.rows.time[piece.rows.rows() - 1] - first_time;
    const int context = std::min(piece.rows.rows(), quality::kContext);
    last = rows_of(piece.rows, piece.rows.rows() - context, context);
  };
  add({head_rows, 0});
  for (Recording next = source(quality::kPieceRows); next.rows() > 0; next = source(quality::kPieceRows)) {
    absurd.remove_absurd_numbers(&next);
    Recording piece = std::move(last);
    const int fresh = piece.rows();
    append(piece, std::move(next));
    add({piece, fresh});
  }

  absurd.conclude(&findings);
  rows->conclude(&findings);
  if (quality.rows > 1) quality.rate = 1.0 / head.step;
  if (quality.rows < quality::numbers.fewest_rows) {
    findings.add(Severity::kWarning, QualityKind::kShortRecording, {}, {quality::kNone, static_cast<double>(quality.rows), "rows"},
                 text("Only ", quality.rows, " rows: too short to judge rate, motion and velocities."));
  } else {
    time->conclude(&findings);
    if (absurd.bad_row_share() < quality::numbers.hopeless_share) {
      jumps->conclude(&findings);
      clips->conclude(&findings);
      for (const auto check : {quality::check_motion, quality::check_velocities, quality::check_stale_signals, quality::check_saturated_plateaus,
                               quality::check_torque_steps, quality::check_start_up}) {
        check(head, &findings);
      }
      quality.period = detect_period(head_rows);
      if (quality.period.found())
        findings.add(Severity::kInfo, QualityKind::kPeriod, {}, {quality::kNone, quality.period.seconds, "s"},
                     text("The motion repeats every ", quality.period.seconds, " s, ", quality::number(quality.period.repeats),
                          " times: repeats give the noise floor."));
    }
  }
  std::stable_sort(quality.findings.begin(), quality.findings.end(),
                   [](const QualityFinding& a, const QualityFinding& b) { return a.severity > b.severity; });
  exclude_effects(quality);
  return quality;
}

std::string capitalised(std::string sentence) {
  if (!sentence.empty())
    sentence[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(sentence[0])));
  return sentence;
}

std::string topic_line(const TopicFacts& topic) {
  std::string line = text("topic ", topic.name, " (", topic.type, "): ", topic.messages, " messages");
  if (topic.rate > 0.0) line += text(" at ", quality::number(topic.rate), " Hz");
  if (!topic.joints.empty()) line += ", joints " + listed(topic.joints);
  if (topic.used) line += ", used";
  if (!topic.undecoded.empty()) line += "; not decoded: " + topic.undecoded;
  return line;
}

}  // namespace

const char* name_of(QualityKind kind) {
  static constexpr const char* kNames[] = {
      "absurd_numbers", "beyond_effort", "beyond_limits", "beyond_speed", "brakes", "changed_midway", "constant_signal", "counts", "current",
      "degrees", "dh_convention", "encoder_zero", "errors_in_variables", "gaps", "given_unit", "gravity", "hardly_moves",
      "irregular_time", "joint_at_rest", "jumps", "millimetres", "missing_rows", "motor_side", "move_as_one",
      "no_motion", "no_sign", "no_torque", "not_compared", "overflow", "period", "position_sign",
      "rate_contradiction", "remark", "same_column", "sample_rate", "saturation", "share_of_range",
      "short_recording", "stale_rows", "stale_signal", "start_up_transient", "swapped_joints", "time_unit",
      "torque_clock", "torque_delay", "torque_filter", "torque_quantised", "torque_sign", "torque_unit", "turns",
      "two_rates", "unexplained", "values", "velocity_delay", "velocity_noise", "velocity_quantised", "velocity_scale",
      "velocity_sign", "velocity_unrelated", "weak_motion", "zero_signal"};
  return kNames[static_cast<int>(kind)];
}

const char* name_of(Severity severity) {
  static constexpr const char* kNames[] = {"info", "warning", "fault"};
  return kNames[static_cast<int>(severity)];
}

Severity RecordingQuality::severity() const {
  Severity worst = Severity::kInfo;
  for (const QualityFinding& finding : findings) worst = std::max(worst, finding.severity);
  return worst;
}

const QualityFinding* RecordingQuality::find(QualityKind kind, std::optional<JointIndex> joint) const {
  for (const QualityFinding& candidate : findings) {
    if (candidate.kind == kind && (!joint || candidate.joint == joint)) return &candidate;
  }
  return nullptr;
}

std::string RecordingQuality::report() const {
  std::string lines =
      text(file, ": ", rows, " rows, ", joints, " joints, ", quality::number(duration), " s");
  lines += rate > 0.0 ? text(" at ", quality::number(rate), " Hz\n") : "\n";
  if (!facts.matched.empty()) lines += "  " + facts.match() + "\n";
  if (facts.matched.empty() && !facts.joints.empty() && facts.joints.front() != "1")
    lines += "  joints: " + listed(facts.joints) + "\n";
  for (const TopicFacts& topic : facts.topics) lines += "  " + topic_line(topic) + "\n";
  for (const QualityFinding& finding : findings) {
    lines +=
        text("  ", name_of(finding.severity), "  ", name_of(finding.kind), ": ", finding.sentence, "\n");
  }
  return lines;
}

RecordingQuality check_recording(const std::string& path, const RecordingOptions& options) {
  return check_rows(path, open_rows(path, options));
}

RecordingQuality check_rows(const std::string& path, const OpenedRows& rows) {
  RecordingQuality quality = checked_quality(rows.next(quality::kHeadRows), path, rows.next);
  quality.facts = rows.facts();
  // Remarks of the reader come after faults and warnings.
  auto at = std::find_if(quality.findings.begin(), quality.findings.end(),
                         [](const auto& f) { return f.severity == Severity::kInfo; });
  for (const std::string& remark : quality.facts.remarks) {
    QualityFinding finding;
    finding.file = path;
    finding.kind = QualityKind::kRemark;
    finding.share = finding.value = quality::kNone;
    finding.sentence = capitalised(remark);
    at = quality.findings.insert(at, finding) + 1;
  }
  return quality;
}

RecordingQuality check_recording(const Recording& recording) {
  int row = std::min(recording.rows(), quality::kHeadRows);
  return checked_quality(rows_of(recording, 0, row), recording.source, [&](int count) {
    const int first = row;
    row += std::min(count, recording.rows() - row);
    return rows_of(recording, first, row - first);
  });
}

}  // namespace veridyn
