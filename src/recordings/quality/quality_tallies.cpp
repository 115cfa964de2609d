// Checks of every row: time steps, and values of rows.
#include <algorithm>
#include <cmath>
#include <utility>

#include "recordings/quality/quality_checks.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::quality {
namespace {

class TimeTally : public Tally {
 public:
  explicit TimeTally(const Head& head) : step_(head.step), shortest_(head.shortest), longest_(head.longest) {}

  void add(const Piece& piece) override {
    const VectorXd& time = piece.rows.time;
    if (rows_ == 0) first_ = time[0];
    for (int k = std::max(piece.fresh, 1); k < time.size(); ++k) {
      const double dt = time[k] - time[k - 1];
      if (dt > numbers.hole * step_) {
        add_hole(time[k - 1], dt);
      } else {
        hole_before_ = kNone;
      }
    }
    rows_ += time.size() - piece.fresh;
    last_ = time[time.size() - 1];
  }

  void conclude(Findings* findings) const override {
    findings->add(Severity::kInfo, QualityKind::kSampleRate, {}, {kNone, 1.0 / step_, "Hz"},
                  text("One row every ", number(1e3 * step_), " ms (median), ", number(1.0 / step_), " Hz."));
    if (static_cast<double>(alike_) > kAlike * static_cast<double>(holes_)) {
      findings->add(Severity::kWarning, QualityKind::kTwoRates, {}, {share_of(holes_, rows_), 1.0 / (length_ * step_), "Hz"},
                    text(counted(holes_, "row"), ", the first at t = ", number(first_hole_at_), " s, come every ", number(1e3 * length_ * step_),
                         " ms and follow each other: two rates in one recording. Column t counts, not a fixed rate."));
      return;
    }
    const double mean_rate = static_cast<double>(rows_ - 1) / (last_ - first_ - lost_time_);
    const bool misleading = std::abs(mean_rate * step_ - 1.0) > numbers.misleading;
    if (longest_ - shortest_ > numbers.irregular * step_) {
      findings->add(misleading ? Severity::kWarning : Severity::kInfo, QualityKind::kIrregularTime, {}, {kNone, mean_rate, "Hz"},
                    text("Time steps vary from ", number(1e3 * shortest_), " to ", number(1e3 * longest_), " ms; the mean rate is ",
                         number(mean_rate), " Hz, so count on column t and not on a fixed rate."));
    }
    if (holes_ == 0) return;
    const double share = lost_rows_ / (static_cast<double>(rows_) + lost_rows_);
    const bool many = share > numbers.many_missing || longest_hole_ > numbers.long_hole * step_;
    findings->add(many ? Severity::kWarning : Severity::kInfo, QualityKind::kMissingRows, {}, {share, longest_hole_, "s"},
                  text("About ", number(lost_rows_), " rows are missing (", percent(share), ") in ", counted(holes_, "place"),
                       "; the longest hole is ", number(1e3 * longest_hole_), " ms after t = ", number(longest_hole_at_), " s."));
  }

 private:
  void add_hole(double at, double dt) {
    ++holes_;
    if (std::isnan(first_hole_at_)) first_hole_at_ = at;
    const double length = std::round(dt / step_);
    if (std::exchange(hole_before_, length) == length) {
      ++alike_;
      length_ = length;
    }
    lost_rows_ += length - 1.0;
    lost_time_ += dt - step_;
    if (dt <= longest_hole_) return;
    longest_hole_ = dt;
    longest_hole_at_ = at;
  }

  double step_, shortest_, longest_;
  long rows_ = 0;
  double first_ = 0.0, last_ = 0.0;
  long holes_ = 0;
  double lost_rows_ = 0.0, lost_time_ = 0.0;
  double longest_hole_ = 0.0, longest_hole_at_ = 0.0;
  long alike_ = 0;              // number of holes directly after another one of the same length
  double hole_before_ = kNone;  // [rows] length of the hole before, or none
  double first_hole_at_ = kNone, length_ = 0.0;  // time of the first hole [s]; length of the equal ones [rows]
};

// The severity of a share of the rows.
Severity severity_of(double share, double many, double most) {
  return share > most ? Severity::kFault : share > many ? Severity::kWarning : Severity::kInfo;
}

class RowTally : public Tally {
 public:
  explicit RowTally(const Head& head) {
    for (const Channel& channel : channels_of(head.rows)) counts_.push_back({channel});
  }

  void add(const Piece& piece) override {
    for (int k = piece.fresh; k < piece.rows.rows(); ++k) {
      stale_run_ = is_stale(piece.rows, k) ? stale_run_ + 1 : 0;
      stale_ += stale_run_ > 0 ? 1 : 0;
      longest_stale_ = std::max(longest_stale_, stale_run_);
    }
    for (Count& count : counts_) {
      const auto values = count.channel.of(piece.rows);
      for (int k = piece.fresh; k < values.size(); ++k) count.add(values[k]);
    }
    rows_ += piece.rows.rows() - piece.fresh;
  }

  void conclude(Findings* findings) const override {
    const double stale = share_of(stale_, rows_);
    if (stale >= numbers.few_stale) {
      findings->add(severity_of(stale, numbers.many_stale, numbers.frozen), QualityKind::kStaleRows, {},
                    {stale, static_cast<double>(longest_stale_), "rows"},
                    text(percent(stale), " of the rows repeat the row before although the arm moves (publisher late?); at most ",
                         longest_stale_, " in a row."));
    }
    conclude_loads(findings);
    conclude_gaps(findings);
    for (const RecordingSignal& signal : kRecordingSignals) conclude_constant(signal, findings);
    for (const Count& count : counts_) {
      const double share = share_of(count.beyond, rows_);
      if (!count.channel.is(&Recording::q) || share < numbers.beyond_turns) continue;
      findings->add(Severity::kWarning, QualityKind::kDegrees, count.channel.place(), {share, kNone, ""},
                    text("The position of ", count.channel.name(), " is beyond +-4 pi in ", percent(share),
                         " of the rows: degrees or millimetres instead of rad or m?"));
    }
  }

 private:
  struct Count {
    Channel channel;
    double first = kNone;
    bool constant = true;
    double largest = 0.0;
    long gaps = 0, gap_run = 0, longest_gap = 0;
    long beyond = 0;  // rows with more than two turns

    void add(double value) {
      if (std::isnan(value)) {
        ++gaps;
        longest_gap = std::max(longest_gap, ++gap_run);
        return;
      }
      gap_run = 0;
      if (std::isnan(first)) first = value;
      constant = constant && value == first;
      largest = std::max(largest, std::abs(value));
      beyond += std::abs(value) > 2.0 * kTurn ? 1 : 0;
    }
  };

  void conclude_loads(Findings* findings) const {
    const auto has_load = [this](const Count& c) { return is_load(*c.channel.signal) && c.gaps < rows_; };
    if (std::any_of(counts_.begin(), counts_.end(), has_load)) return;
    const auto joints = std::count_if(counts_.begin(), counts_.end(), [](const Count& c) { return c.channel.is(&Recording::q); });
    findings->add(Severity::kFault, QualityKind::kNoTorque, {"tau"}, {1.0, kNone, ""},
                  text("No torque and no current of any joint holds a number (tau1 to tau", joints, ", i1 to i", joints,
                       "): record the efforts, or name their columns by --map tau=SOURCE."));
  }

  void add_gaps(const Count& count, const Place& place, const std::string& who, Findings* findings) const {
    const double share = share_of(count.gaps, rows_);
    std::string sentence = who;
    if (count.gaps < rows_) {
      sentence += text(" lacks ", counted(count.gaps, "value"), " (", percent(share), " of the rows); at most ", count.longest_gap, " in a row.");
    } else {
      sentence += " holds no number in any row";
      sentence += !place.joint ? std::string(".") : text(": ", place.signal, place.joint->value + 1, "=NAME in --map names another column, and "
                                                             "--fix JOINT=POSITION leaves a joint out that stood still.");
    }
    findings->add(severity_of(share, numbers.few_gaps, numbers.many_gaps), QualityKind::kGaps, place,
                  {share, static_cast<double>(count.longest_gap), "rows"}, sentence);
  }

  // Reports one finding for the file if many channels have gaps, else one per channel.
  void conclude_gaps(Findings* findings) const {
    const Count& first = counts_.front();
    const bool alike = std::all_of(counts_.begin(), counts_.end(), [&](const Count& count) {
      return count.gaps == first.gaps && count.longest_gap == first.longest_gap;
    });
    if (alike && first.gaps > 0) return add_gaps(first, {}, "Every signal", findings);
    const long affected = std::count_if(counts_.begin(), counts_.end(), [](const Count& count) { return count.gaps > 0; });
    if (affected > numbers.many_signals) {
      const Count& worst = *std::max_element(counts_.begin(), counts_.end(), [](const Count& a, const Count& b) { return a.gaps < b.gaps; });
      return add_gaps(worst, {}, text(affected, " of ", counts_.size(), " signals have gaps; the worst, ", worst.channel.name(), ","), findings);
    }
    for (const Count& count : counts_) {
      if (count.gaps > 0) add_gaps(count, count.channel.place(), "The signal of " + count.channel.name(), findings);
    }
  }

  // Reports a constant signal. Constant positions and velocities are part of joint_at_rest, unless all of them
  // are zero.
  void conclude_constant(const RecordingSignal& signal, Findings* findings) const {
    std::vector<Count> all;
    std::copy_if(counts_.begin(), counts_.end(), std::back_inserter(all), [&](const Count& c) { return c.channel.signal == &signal; });
    if (all.empty()) return;
    const bool load = is_load(signal);
    double largest = 0.0;
    for (const Count& count : all) largest = std::max(largest, count.largest);
    const auto is_zero = [&](const Count& c) { return (c.constant && c.first == 0.0) || (load && c.largest < kNoLoad && c.gaps < rows_); };
    if (std::all_of(all.begin(), all.end(), is_zero)) {
      findings->add(load ? Severity::kFault : Severity::kWarning, QualityKind::kZeroSignal, {signal.name}, {1.0, kNone, ""},
                    text("Signal ", signal.name, largest > 0.0 ? text(" is at most ", number(largest)) : std::string(" is zero"),
                         " on every joint (", signal.name, "1 to ", signal.name, all.size(), ") in every row: not recorded",
                         load ? ", so that no force is known; record the efforts, or name their columns by --map." : "?"));
      return;
    }
    for (const Count& count : all) {
      if (!load || !count.constant || std::isnan(count.first)) continue;
      findings->add(Severity::kWarning, count.first == 0.0 ? QualityKind::kZeroSignal : QualityKind::kConstantSignal, count.channel.place(),
                    {1.0, count.first, count.channel.unit()},
                    text("The signal of ", count.channel.name(), " is ", number(count.first), " in every row: not measured?"));
    }
  }

  std::vector<Count> counts_;
  long rows_ = 0;
  long stale_ = 0, stale_run_ = 0, longest_stale_ = 0;
};

}  // namespace

std::unique_ptr<Tally> time_tally(const Head& head) { return std::make_unique<TimeTally>(head); }

std::unique_ptr<Tally> row_tally(const Head& head) { return std::make_unique<RowTally>(head); }

}  // namespace veridyn::quality
