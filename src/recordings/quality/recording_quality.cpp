#include "veridyn/recordings/recording_quality.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <functional>

#include "recordings/kept_recordings.hpp"
#include "recordings/quality/quality_checks.hpp"
#include "veridyn/math/require.hpp"
#include "model/suggestion.hpp"

namespace veridyn {
namespace {

using Source = std::function<Recording(int)>;

// The last rows of a piece, prepended to the next one.
Recording joined(const Recording& before, const Recording& next) {
  const int context = std::min(before.rows(), quality::kContext);
  Recording both;
  both.source = next.source;
  both.time.resize(context + next.rows());
  both.time << before.time.tail(context), next.time;
  for (const RecordingSignal& signal : kRecordingSignals) {
    const MatrixXd& values = next.*signal.values;
    if (values.cols() == 0) continue;
    (both.*signal.values).resize(context + next.rows(), values.cols());
    both.*signal.values << (before.*signal.values).bottomRows(context), values;
  }
  return both;
}

// Excludes saturation that is an effect of a slowly refreshed torque, which holds its extreme as well.
void exclude_held_values(RecordingQuality& quality) {
  const auto is_held = [&quality](const std::string& signal, int joint) {
    return std::any_of(quality.findings.begin(), quality.findings.end(),
                       [&](const QualityFinding& f) { return f.finding == "stale_signal" && f.signal == signal && f.joint == joint; });
  };
  const auto last = std::remove_if(quality.saturated.begin(), quality.saturated.end(), [&](const SaturatedInterval& one) { return is_held("tau", one.joint + 1); });
  quality.saturated.erase(last, quality.saturated.end());
  const auto end = std::stable_partition(quality.findings.begin(), quality.findings.end(), [&](const QualityFinding& f) {
    return f.finding != "saturation" || !is_held(f.signal, f.joint);
  });
  quality.findings.erase(end, quality.findings.end());
}

// Runs all tallies over all rows. The first rows have been read already.
RecordingQuality checked_quality(Recording head_rows, const std::string& file, const Source& source) {
  require(head_rows.rows() > 0, file, ": found no row, expected numbers below the header.");
  RecordingQuality quality;
  quality.file = file;
  quality.joints = head_rows.joints();
  quality::Findings findings(file);
  quality::AbsurdTally absurd;
  absurd.clean(&head_rows, 0);
  const double first_time = head_rows.time[0];

  const quality::Head head(head_rows);
  quality::TimeTally time(head);
  quality::RowTally rows(head);
  quality::JumpTally jumps(head);
  quality::ClipTally clips(head);
  Recording last;
  const auto add = [&](const quality::Piece& piece) {
    time.add(piece);
    rows.add(piece);
    jumps.add(piece);
    clips.add(piece);
    quality.rows += piece.rows.rows() - piece.fresh;
    quality.duration = piece.rows.time[piece.rows.rows() - 1] - first_time;
    const int context = std::min(piece.rows.rows(), quality::kContext);
    last = rows_of(piece.rows, piece.rows.rows() - context, context);
  };
  add({head_rows, 0});
  for (Recording next = source(quality::kPieceRows); next.rows() > 0; next = source(quality::kPieceRows)) {
    absurd.clean(&next, 0);
    const Recording piece = joined(last, next);
    add({piece, piece.rows() - next.rows()});
  }

  absurd.conclude(&findings);
  rows.conclude(&findings);
  if (quality.rows > 1) quality.rate = 1.0 / head.step;
  if (quality.rows >= quality::numbers.fewest_rows) {
    time.conclude(&findings);
    if (absurd.share() < quality::numbers.hopeless_share) {
      jumps.conclude(&findings);
      clips.conclude(&findings, &quality.saturated);
      quality::check_motion(head, &findings);
      quality::check_velocities(head, &findings);
      quality::check_stale_signals(head, &findings);
      quality::check_saturated_plateaus(head, &findings);
      quality::check_torque_steps(head, &findings);
      quality::check_start_up(head, &findings);
      quality.period = detect_period(head_rows);
      quality::check_period(quality.period, &findings);
    }
  } else {
    findings.add(
        Severity::kWarning, "short_recording", {},
        {quality::kNone, static_cast<double>(quality.rows), "rows"},
        text("Only ", quality.rows, " rows: too short to judge rate, motion and velocities."));
  }
  quality.findings = std::move(findings).sorted();
  exclude_held_values(quality);
  if (quality.find("time_unit") != nullptr) {  // both findings would have the same cause
    const auto same = [](const QualityFinding& f) { return f.finding == "rate_contradiction" || f.finding == "sample_rate"; };
    quality.findings.erase(std::remove_if(quality.findings.begin(), quality.findings.end(), same), quality.findings.end());
  }
  return quality;
}

std::string capitalised(std::string sentence) {
  if (!sentence.empty())
    sentence[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(sentence[0])));
  return sentence;
}

std::string line_of(const TopicFacts& topic) {
  std::string line = text("topic ", topic.name, " (", topic.type, "): ", topic.messages, " messages");
  if (topic.rate > 0.0) line += text(" at ", quality::number(topic.rate), " Hz");
  if (!topic.joints.empty()) line += ", joints " + listed(topic.joints);
  if (topic.used) line += ", used";
  if (!topic.undecoded.empty()) line += "; not decoded: " + topic.undecoded;
  return line;
}

}  // namespace

const char* name_of(Severity severity) {
  static constexpr const char* kNames[] = {"info", "warning", "fault"};
  return kNames[static_cast<int>(severity)];
}

Severity RecordingQuality::severity() const {
  Severity worst = Severity::kInfo;
  for (const QualityFinding& finding : findings) worst = std::max(worst, finding.severity);
  return worst;
}

const QualityFinding* RecordingQuality::find(const std::string& finding, int joint) const {
  for (const QualityFinding& candidate : findings) {
    if (candidate.finding == finding && (joint == 0 || candidate.joint == joint)) return &candidate;
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
  for (const TopicFacts& topic : facts.topics) lines += "  " + line_of(topic) + "\n";
  for (const QualityFinding& finding : findings) {
    lines +=
        text("  ", name_of(finding.severity), "  ", finding.finding, ": ", finding.sentence, "\n");
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
    finding.finding = "remark";
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
