// Tallies of numbers, time and rows.
#include <algorithm>
#include <cmath>
#include <utility>

#include "recordings/quality/quality_checks.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::quality {
// ---- absurd numbers

void AbsurdTally::clean(Recording* rows, int fresh) {
  for (int k = fresh; k < rows->rows(); ++k) {
    bool bad = false;
    for (const RecordingSignal& signal : kRecordingSignals) {
      MatrixXd& values = rows->*signal.values;
      for (int j = 0; j < values.cols(); ++j) {
        if (!(std::abs(values(k, j)) > numbers.absurd)) continue;
        values(k, j) = kNone;
        bad = true;
        ++bad_values_;
      }
    }
    if (bad && bad_rows_ == 0) first_time_ = rows->time[k];
    bad_rows_ += bad ? 1 : 0;
    ++rows_;
  }
}

void AbsurdTally::conclude(Findings* findings) const {
  if (bad_rows_ == 0) return;
  findings->add(
      Severity::kFault, "absurd_numbers", {},
      {share(), static_cast<double>(bad_values_), "numbers"},
      text(counted(bad_values_, "number"), " beyond +-1e6 in ", percent(share()),
           " of the rows, the first at t = ", number(first_time_), " s: the file is broken",
           share() < numbers.hopeless_share ? " there." : "; its motion is not judged."));
}

// ---- time

void TimeTally::add(const Piece& piece) {
  const VectorXd& time = piece.rows.time;
  if (rows_ == 0) first_ = time[0];
  for (int k = std::max(piece.fresh, 1); k < time.size(); ++k) {
    const double dt = time[k] - time[k - 1];
    if (dt <= numbers.hole * step_) {
      hole_before_ = kNone;
      continue;
    }
    ++holes_;
    if (std::isnan(first_hole_at_)) first_hole_at_ = time[k - 1];
    const double length = std::round(dt / step_);
    if (std::exchange(hole_before_, length) == length) {
      ++alike_;
      length_ = length;
    }
    lost_rows_ += length - 1.0;
    lost_time_ += dt - step_;
    if (dt > longest_hole_) {
      longest_hole_ = dt;
      longest_hole_at_ = time[k - 1];
    }
  }
  rows_ += time.size() - piece.fresh;
  last_ = time[time.size() - 1];
}

void TimeTally::conclude(Findings* findings) const {
  findings->add(
      Severity::kInfo, "sample_rate", {}, {kNone, 1.0 / step_, "Hz"},
      text("One row every ", number(1e3 * step_), " ms (median), ", number(1.0 / step_), " Hz."));
  if (static_cast<double>(alike_) > kAlike * static_cast<double>(holes_)) {
    findings->add(Severity::kWarning, "two_rates", {}, {share_of(holes_, rows_), 1.0 / (length_ * step_), "Hz"},
                  text(counted(holes_, "row"), ", the first at t = ", number(first_hole_at_), " s, come every ", number(1e3 * length_ * step_),
                       " ms and follow each other: two rates in one recording. Column t counts, not a fixed rate."));
    return;
  }
  const double mean_rate = static_cast<double>(rows_ - 1) / (last_ - first_ - lost_time_);
  const bool misleading = std::abs(mean_rate * step_ - 1.0) > numbers.misleading;
  if (longest_ - shortest_ > numbers.irregular * step_) {
    findings->add(misleading ? Severity::kWarning : Severity::kInfo, "irregular_time", {},
                  {kNone, mean_rate, "Hz"},
                  text("Time steps vary from ", number(1e3 * shortest_), " to ",
                       number(1e3 * longest_), " ms; the mean rate is ", number(mean_rate),
                       " Hz, so count on column t and not on a fixed rate."));
  }
  if (holes_ > 0) {
    const double share = lost_rows_ / (static_cast<double>(rows_) + lost_rows_);
    findings->add(
        share > numbers.many_missing || longest_hole_ > numbers.long_hole * step_ ? Severity::kWarning : Severity::kInfo,
        "missing_rows", {}, {share, longest_hole_, "s"},
        text("About ", number(lost_rows_), " rows are missing (", percent(share), ") in ",
             counted(holes_, "place"), "; the longest hole is ", number(1e3 * longest_hole_),
             " ms after t = ", number(longest_hole_at_), " s."));
  }
}

// ---- stale rows, gaps, constants

RowTally::RowTally(const Head& head)
    : beyond_(static_cast<std::size_t>(head.rows.joints()), 0) {
  for (const RecordingSignal& signal : kRecordingSignals) {
    for (int j = 1; j <= (head.rows.*signal.values).cols(); ++j) channels_.push_back({{signal.name, j}});
  }
}

void RowTally::add(const Piece& piece) {
  for (int k = piece.fresh; k < piece.rows.rows(); ++k) {
    stale_run_ = is_stale(piece.rows, k) ? stale_run_ + 1 : 0;
    stale_ += stale_run_ > 0 ? 1 : 0;
    longest_stale_ = std::max(longest_stale_, stale_run_);
    for (int j = 0; j < piece.rows.joints(); ++j) {
      beyond_[j] += std::abs(piece.rows.q(k, j)) > 2.0 * kTurn ? 1 : 0;
    }
  }
  std::size_t c = 0;
  for (const RecordingSignal& signal : kRecordingSignals) {
    const MatrixXd& values = piece.rows.*signal.values;
    for (int j = 0; j < values.cols(); ++j, ++c) {
      Channel& channel = channels_[c];
      for (int k = piece.fresh; k < values.rows(); ++k) {
        const double value = values(k, j);
        channel.gap_run = std::isnan(value) ? channel.gap_run + 1 : 0;
        channel.gaps += channel.gap_run > 0 ? 1 : 0;
        channel.longest_gap = std::max(channel.longest_gap, channel.gap_run);
        if (std::isnan(value)) continue;
        if (std::isnan(channel.first)) channel.first = value;
        channel.constant = channel.constant && value == channel.first;
        channel.largest = std::max(channel.largest, std::abs(value));
      }
    }
  }
  rows_ += piece.rows.rows() - piece.fresh;
}

void RowTally::conclude(Findings* findings) const {
  const double stale = share_of(stale_, rows_);
  if (stale >= numbers.few_stale) {
    const Severity severity = stale > numbers.frozen      ? Severity::kFault
                              : stale > numbers.many_stale ? Severity::kWarning
                                                   : Severity::kInfo;
    findings->add(
        severity, "stale_rows", {}, {stale, static_cast<double>(longest_stale_), "rows"},
        text(
            percent(stale),
            " of the rows repeat the row before although the arm moves (publisher late?); at most ",
            longest_stale_, " in a row."));
  }
  const auto has_load = [this](const Channel& c) { return (c.place.signal == "tau" || c.place.signal == "i") && c.gaps < rows_; };
  if (std::none_of(channels_.begin(), channels_.end(), has_load))
    findings->add(Severity::kFault, "no_torque", {"tau", 0}, {1.0, kNone, ""},
                  text("No torque and no current of any joint holds a number (tau1 to tau", beyond_.size(), ", i1 to i", beyond_.size(),
                       "): record the efforts, or name their columns by --map tau=SOURCE."));
  conclude_gaps(findings);
  conclude_constant(findings);
  for (std::size_t j = 0; j < beyond_.size(); ++j) {
    const double share = share_of(beyond_[j], rows_);
    if (share < numbers.beyond_turns) continue;
    const Place place{"q", static_cast<int>(j) + 1};
    findings->add(Severity::kWarning, "degrees", place, {share, kNone, ""},
                  text("The position of ", named(place), " is beyond +-4 pi in ", percent(share),
                       " of the rows: degrees or millimetres instead of rad or m?"));
  }
}

void RowTally::add_gaps(const Channel& channel, const Place& place, const std::string& who,
                        Findings* findings) const {
  const double share = share_of(channel.gaps, rows_);
  const Severity severity = share > numbers.many_gaps  ? Severity::kFault
                            : share > numbers.few_gaps ? Severity::kWarning
                                            : Severity::kInfo;
  const std::string lacks = channel.gaps == rows_ ? text(who, " holds no number in any row")
                                                  : text(who, " lacks ", counted(channel.gaps, "value"), " (", percent(share),
                                                         " of the rows); at most ", channel.longest_gap, " in a row");
  findings->add(severity, "gaps", place, {share, static_cast<double>(channel.longest_gap), "rows"},
                lacks + (channel.gaps == rows_ && place.joint > 0 ? text(": ", channel.place.signal, place.joint, "=NAME in --map names another column, "
                                                                         "and --fix JOINT=POSITION leaves a joint out that stood still.") : "."));
}

// Reports one finding for the file if many channels have gaps, else one per channel.
void RowTally::conclude_gaps(Findings* findings) const {
  const Channel& first = channels_.front();
  const bool alike = std::all_of(channels_.begin(), channels_.end(), [&](const Channel& channel) {
    return channel.gaps == first.gaps && channel.longest_gap == first.longest_gap;
  });
  if (alike && first.gaps > 0) return add_gaps(first, {}, "Every signal", findings);
  const Channel& worst =
      *std::max_element(channels_.begin(), channels_.end(),
                        [](const Channel& a, const Channel& b) { return a.gaps < b.gaps; });
  const long affected = std::count_if(channels_.begin(), channels_.end(),
                                      [](const Channel& channel) { return channel.gaps > 0; });
  if (affected > numbers.many_signals) {
    return add_gaps(worst, {},
                    text(affected, " of ", channels_.size(), " signals have gaps; the worst, ",
                         named(worst.place), ","),
                    findings);
  }
  for (const Channel& channel : channels_) {
    if (channel.gaps > 0)
      add_gaps(channel, channel.place, text("The signal of ", named(channel.place)), findings);
  }
}

// Reports constant signals. Constant positions and velocities are part of joint_at_rest, unless all of them
// are zero.
void RowTally::conclude_constant(Findings* findings) const {
  for (const RecordingSignal& signal : kRecordingSignals) {
    long all = 0;
    long zero = 0;
    double largest = 0.0;
    const bool measured = std::string(signal.name) == "tau" || std::string(signal.name) == "i";
    for (const Channel& channel : channels_) {
      if (channel.place.signal != signal.name) continue;
      ++all;
      zero += (channel.constant && channel.first == 0.0) || (measured && channel.largest < kNoLoad && channel.gaps < rows_) ? 1 : 0;
      largest = std::max(largest, channel.largest);
    }
    if (all == 0) continue;
    if (zero == all) {
      findings->add(
          measured ? Severity::kFault : Severity::kWarning, "zero_signal", {signal.name, 0}, {1.0, kNone, ""},
          text("Signal ", signal.name, largest > 0.0 ? text(" is at most ", number(largest)) : std::string(" is zero"), " on every joint (", signal.name, "1 to ", signal.name, all,
               ") in every row: not recorded", measured ? ", so that no force is known; record the efforts, or name their columns by --map." : "?"));
      continue;
    }
    for (const Channel& channel : channels_) {
      if (channel.place.signal != signal.name || !channel.constant || !measured ||
          std::isnan(channel.first))
        continue;
      const bool is_zero = channel.first == 0.0;
      findings->add(Severity::kWarning, is_zero ? "zero_signal" : "constant_signal", channel.place,
                    {1.0, channel.first, unit_of(signal.name)},
                    text("The signal of ", named(channel.place), " is ", number(channel.first),
                         " in every row: not measured?"));
    }
  }
}

}  // namespace veridyn::quality
