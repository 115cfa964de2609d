#include "veridyn/identification/compressed_recording.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "identification/identification_numbers.hpp"
#include "many_recordings.hpp"
#include "period_fold.hpp"
#include "read_ahead.hpp"
#include "velocity_choice.hpp"
#include "math/parallel.hpp"
#include "recordings/kept_recordings.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

using Visit = VisitSegment;
using Pass = StretchPass;

// Blocks for the jackknife and for held-out folds. If the motion repeats, they are phases of its period, with
// all repeats merged, because repeats share systematic errors and are not independent. Otherwise they are
// segments of equal duration; their number is between half of most_blocks and most_blocks. It is divided by
// two or four for an arm with so many joints that the factors would exceed kMostBytes.
class Blocks {
 public:
  Blocks(const RegressorColumns& columns, int joints, double period)
      : phases_(identifying::numbers.phases), most_(identifying::numbers.most_blocks), period_(period), duration_(identifying::numbers.first_block) {
    const std::vector<std::string> names = parameter_names(columns.parameters());
    for (int i = 0; i < joints; ++i) {
      std::vector<std::string> mine;
      for (const int p : columns.parameters_of({i})) {
        if (!columns.parameters()[p].fixed)
          mine.push_back(names[p]);
      }
      none_.emplace_back(std::move(mine));
    }
    double bytes = 0.0;
    for (const SquareRootInformation& mine : none_) bytes += 0.5 * sizeof(double) * mine.size() * mine.size();
    while (most_ > identifying::kFewestBlocks && bytes * static_cast<double>(most_) > identifying::kMostBytes) most_ /= 2;
    while (phases_ > identifying::kFewestBlocks && bytes * phases_ > identifying::kMostBytes) phases_ /= 2.0;
  }

  // Absorbs rows of some joints, beginning with joint `first`. Factors of different joints are independent,
  // so that threads may process them in parallel.
  void add_rows(const std::vector<JointRows>& rows, int first, int threads) {
    size_t last = 0;
    for (const JointRows& joint : rows) {
      for (Eigen::Index k = 0; k < joint.time.size(); ++k) {
        while (block_of(joint.time[k]) >= most_) merge_pairs();
      }
    }
    for (const JointRows& joint : rows) {
      for (Eigen::Index k = 0; k < joint.time.size(); ++k)
        last = std::max(last, block_of(joint.time[k]) + 1);
    }
    while (blocks_.size() < last) blocks_.push_back(none_);
    parallel_for(static_cast<int>(rows.size()), threads, [&](int i) {
      add_rows(static_cast<size_t>(first + i), rows[i]);
    });
  }

  std::vector<std::vector<SquareRootInformation>> extract() {
    const auto empty = [](const std::vector<SquareRootInformation>& b) {
      return std::all_of(b.begin(), b.end(),
                         [](const SquareRootInformation& f) { return f.rows() == 0.0; });
    };
    blocks_.erase(std::remove_if(blocks_.begin(), blocks_.end(), empty), blocks_.end());
    return std::move(blocks_);
  }

 private:
  // Block of a time [s]: the phase of a periodic motion, else an interval of duration_.
  size_t block_of(double time) const {
    if (period_ <= 0.0) return static_cast<size_t>(time / duration_);
    const double turns = time / period_;
    return static_cast<size_t>(phases_ * (turns - std::floor(turns)));
  }

  void add_rows(size_t joint, const JointRows& rows) {
    Eigen::Index at = 0;
    while (at < rows.time.size()) {
      const size_t block = block_of(rows.time[at]);
      Eigen::Index end = at;
      while (end < rows.time.size() && block_of(rows.time[end]) == block) ++end;
      blocks_[block][joint].absorb(rows.A.middleRows(at, end - at), rows.b.segment(at, end - at));
      at = end;
    }
  }

  void merge_pairs() {
    veridyn::merge_pairs(blocks_);
    duration_ *= 2.0;
  }

  double phases_;
  size_t most_;
  double period_;
  double duration_;
  std::vector<SquareRootInformation> none_;  // factors of a block without rows
  std::vector<std::vector<SquareRootInformation>> blocks_;
};

// Removes the excluded intervals of all other recordings.
PreprocessingOptions of_this_source(PreprocessingOptions options, const std::string& source) {
  std::vector<ExcludedInterval>& parts = options.excluded_intervals;
  parts.erase(std::remove_if(parts.begin(), parts.end(),
                             [&](const ExcludedInterval& part) { return part.source != source; }),
              parts.end());
  const auto weights = options.weights.find(source);
  if (weights == options.weights.end()) options.weights.clear();
  else options.weights = {*weights};
  return options;
}

// Absorbs the rows of every joint, groups of joints in parallel, with at most kGroupsAtOnce groups in memory.
void absorb_all(const RegressorColumns& columns, const Segment& s, int threads, Blocks& blocks) {
  const std::vector<RegressorColumns::Joints> groups = columns.groups(s.q.rows());
  for (size_t at = 0; at < groups.size(); at += identifying::kGroupsAtOnce) {
    const size_t count = std::min(identifying::kGroupsAtOnce, groups.size() - at);
    std::vector<std::vector<JointRows>> of_group(count);
    parallel_for(static_cast<int>(count), threads, [&](int g) {
      of_group[g] = columns.rows(s, groups[at + static_cast<size_t>(g)]);
    });
    std::vector<JointRows> rows;
    for (std::vector<JointRows>& group : of_group)
      std::move(group.begin(), group.end(), std::back_inserter(rows));
    blocks.add_rows(rows, groups[at].first, threads);
  }
}

// Scope of a pass over a recording.
enum class Wanted { kFactors, kFacts };

// Number of samples of one segment that a fit would use, over all joints.
double samples_of(const RegressorColumns& columns, const PreprocessingOptions& options,
                  const Segment& s) {
  const int step = decimation(options, s.dt);
  double out = 0.0;
  for (Eigen::Index k = s.core_begin; k < s.core_end; ++k) {
    if (s.use[k] == 0) continue;
    if (std::lround((s.time[k] - s.start) / s.dt) % step != 0) continue;
    for (int i = 0; i < s.dq.cols(); ++i)
      out += static_cast<double>(!columns.is_excluded({i}, s.time[k] - s.start) &&
                                 std::abs(s.dq(k, i)) >= options.min_speed);
  }
  return out;
}

void add_facts(const Segment& s, const MatrixXd& tau, bool& first, PeriodFold& fold,
               std::vector<TorqueFacts>& joints) {
  for (Eigen::Index k = s.core_begin; k < s.core_end; ++k) {
    if (s.use[k] == 0) continue;
    fold.add(s.time[k] - s.start, tau, k);
    for (size_t j = 0; j < joints.size(); ++j) {
      TorqueFacts& joint = joints[j];
      const auto i = static_cast<Eigen::Index>(j);
      joint.minimum = first ? tau(k, i) : std::min(joint.minimum, tau(k, i));
      joint.maximum = first ? tau(k, i) : std::max(joint.maximum, tau(k, i));
      joint.largest_speed = std::max(joint.largest_speed, std::abs(s.dq(k, i)));
      joint.lowest = first ? s.q(k, i) : std::min(joint.lowest, s.q(k, i));
      joint.highest = first ? s.q(k, i) : std::max(joint.highest, s.q(k, i));
    }
    first = false;
  }
}

CompressedRecording run_compress(const Model& arm, const std::string& source,
                                 const PreprocessingOptions& options, const MotionPeriod& period,
                                 const Pass& pass, int threads,
                                 Wanted wanted = Wanted::kFactors) {
  CompressedRecording out;
  out.source = source;
  out.period = period;
  const int n = arm.joints();
  const PreprocessingOptions mine = of_this_source(options, source);
  const RegressorColumns columns(arm, mine);
  Blocks blocks(columns, n, period.seconds);
  PeriodFold fold(n, period.seconds);
  out.joints.resize(n);
  bool first = true;
  const Visit visit = [&](const Segment& s) {
    if (wanted == Wanted::kFactors) {
      absorb_all(columns, s, threads, blocks);
    } else {
      out.rows += samples_of(columns, mine, s);
    }
    add_facts(s, columns.filtered_torque(s), first, fold, out.joints);
  };
  out.facts = threads > 1 ? read_ahead(pass, visit) : pass(visit);
  out.blocks = blocks.extract();
  for (const auto& block : out.blocks) {
    for (const SquareRootInformation& factor : block) {
      require(factor.column_norms().allFinite() && std::isfinite(factor.rhs_norm2()), source, ": torques of robot '", arm.name(),
              "' are no finite numbers along this motion, expected numbers of the robot file in m, kg and rad.");
      out.rows += factor.rows();
    }
  }
  out.noise_floor = fold.relative_floor();
  return out;
}

// Time and positions of the first minutes, decimated: sufficient for the period, with memory independent of
// the file's length and rate.
class ThinnedPositions {
 public:
  void add(const Recording& piece, Eigen::Index row) {
    if (index_++ % stride_ != 0) return;
    time_.push_back(piece.time[row]);
    q_.push_back(piece.q.row(row));
    if (static_cast<long>(time_.size()) < identifying::kPeriodRows) return;
    stride_ *= 2;
    for (size_t k = 0; 2 * k < time_.size(); ++k) {
      time_[k] = time_[2 * k];
      q_[k] = q_[2 * k];
    }
    time_.resize((time_.size() + 1) / 2);
    q_.resize(time_.size());
  }

  double duration() const { return time_.empty() ? 0.0 : time_.back() - time_.front(); }

  Recording recording() const {
    Recording out;
    if (time_.empty()) return out;
    const auto rows = static_cast<Eigen::Index>(time_.size());
    out.time = Eigen::Map<const VectorXd>(time_.data(), rows);
    out.q.resize(rows, q_.front().size());
    for (Eigen::Index k = 0; k < rows; ++k) out.q.row(k) = q_[k];
    return out;
  }

 private:
  long index_ = 0;
  long stride_ = 1;
  std::vector<double> time_;
  std::vector<Eigen::RowVectorXd> q_;
};

// The positions of the first `period_time` seconds, thinned out.
Recording first_positions(const Model& arm, const std::string& path,
                          const PreprocessingOptions& options) {
  const OpenedRows rows = open_rows(path, recording_options_for(arm, options), options.kept.get());
  ThinnedPositions positions;
  while (positions.duration() < identifying::numbers.period_time) {
    const Recording piece = rows.next(identifying::kPieceRows);
    if (piece.rows() == 0) break;
    for (Eigen::Index k = 0; k < piece.rows(); ++k) positions.add(piece, k);
  }
  return positions.recording();
}

MotionPeriod period_of(const Model& arm, const std::string& path,
                       const PreprocessingOptions& options) {
  const auto known = options.known_periods.find(path);
  if (known != options.known_periods.end()) {
    MotionPeriod period;
    period.seconds = known->second;
    return period;
  }
  const Recording* there = find_in_memory(options.in_memory, path);
  if (there == nullptr && options.kept && options.first_row == 0 && !options.row_count) {
    // The quality check of a short recording has determined the period from the same positions.
    const auto seen = options.kept->known_quality(path, inspected_rows(arm, options));
    if (seen && seen->rows < identifying::kPeriodRows && seen->duration < identifying::numbers.period_time &&
        seen->find(QualityKind::kShortRecording) == nullptr && seen->find(QualityKind::kAbsurdNumbers) == nullptr)
      return seen->period;
  }
  return detect_period(there != nullptr ? *there : first_positions(arm, path, options));
}

// Collects between `wanted` and twice as many samples of a recording of any length: when it is full, every
// second sample is dropped.
class SeriesCollector {
 public:
  SeriesCollector(PredictionSeries* series, int joints) : series_(series) {
    if (series == nullptr) return;
    *series = {series->wanted, {}, {}, {}, {}, {}, {}};
    for (auto* table : tables()) table->resize(static_cast<size_t>(joints));
  }

  void add(const Segment& s, const RegressorColumns::Prediction& p, Eigen::Index row) {
    if (series_ == nullptr || index_++ % stride_ != 0) return;
    const MatrixXd* sources[] = {&s.q, &s.dq, &s.ddq, &p.measured, &p.modelled};
    series_->time.push_back(s.time[row] - s.start);
    for (size_t t = 0; t < tables().size(); ++t) {
      std::vector<std::vector<double>>& table = *tables()[t];
      for (size_t i = 0; i < table.size(); ++i)
        table[i].push_back((*sources[t])(row, static_cast<Eigen::Index>(i)));
    }
    if (series_->time.size() < 2 * static_cast<size_t>(series_->wanted)) return;
    stride_ *= 2;
    drop_every_second(series_->time);
    for (auto* table : tables()) {
      for (std::vector<double>& column : *table) drop_every_second(column);
    }
  }

  // Releases unused memory of the columns.
  void finish() {
    if (series_ == nullptr) return;
    series_->time.shrink_to_fit();
    for (auto* table : tables()) {
      for (std::vector<double>& column : *table) column.shrink_to_fit();
    }
  }

 private:
  using Table = std::vector<std::vector<double>>;

  std::array<Table*, 5> tables() const {
    return {&series_->q, &series_->dq, &series_->ddq, &series_->measured, &series_->modelled};
  }

  static void drop_every_second(std::vector<double>& column) {
    for (size_t k = 0; 2 * k < column.size(); ++k) column[k] = column[2 * k];
    column.resize((column.size() + 1) / 2);
  }

  PredictionSeries* series_;
  long index_ = 0;
  long stride_ = 1;
};

ErrorSums run_prediction(const Model& arm, const std::string& source,
                         const PreprocessingOptions& options, const VectorRef& values,
                         const std::vector<TorqueFacts>& joints, PredictionSeries* series,
                         ErrorSums* without_excluded, const Pass& pass, int threads) {
  const int n = arm.joints();
  const RegressorColumns columns(arm, of_this_source(options, source));
  ErrorSums sums(n);
  ErrorSums kept(n);
  SeriesCollector collector(series, n);
  const Visit visit = [&](const Segment& s) {
    const RegressorColumns::Prediction p = columns.predict(s, values);
    for (Eigen::Index k = s.core_begin; k < s.core_end; ++k) {
      if (s.use[k] == 0) continue;
      for (int i = 0; i < n; ++i) {
        const double slow = std::max(kRestSpeed, identifying::kMovingShare * joints[i].largest_speed);
        const MovingSample moves =
            std::abs(s.dq(k, i)) > slow ? MovingSample::kYes : MovingSample::kNo;
        sums.add(i, p.measured(k, i), p.modelled(k, i), moves);
        if (without_excluded != nullptr && !columns.is_excluded({i}, s.time[k] - s.start))
          kept.add(i, p.measured(k, i), p.modelled(k, i), moves);
      }
      collector.add(s, p, k);
    }
  };
  threads > 1 ? read_ahead(pass, visit) : pass(visit);
  collector.finish();
  if (without_excluded != nullptr) *without_excluded = kept;
  return sums;
}

}  // namespace

CompressedRecording compress(const Model& arm, const std::string& path,
                             const PreprocessingOptions& options, int threads) {
  return run_compress(
      arm, path, options, period_of(arm, path, options),
      [&](const Visit& visit) { return for_each_segment(arm, path, options, visit); },
      number_of_threads(threads));
}

CompressedRecording compress_facts(const Model& arm, const std::string& path,
                                   const PreprocessingOptions& options, int threads) {
  return run_compress(
      arm, path, options, period_of(arm, path, options),
      [&](const Visit& visit) { return for_each_segment(arm, path, options, visit); },
      number_of_threads(threads), Wanted::kFacts);
}

CompressedRecording compress(const Model& arm, const Recording& recording,
                             const PreprocessingOptions& options) {
  return run_compress(
      arm, recording.source, options, detect_period(recording),
      [&](const Visit& visit) { return for_each_segment(arm, recording, options, visit); }, 1);
}

std::vector<CompressedRecording> compress_all(const Model& arm,
                                              const std::vector<std::string>& paths,
                                              const PreprocessingOptions& options, int threads) {
  return compress_each(paths, threads, [&](const std::string& path, int own) { return compress(arm, path, options, own); });
}

ErrorSums::ErrorSums(int joints)
    : torque2(VectorXd::Zero(joints)),
      error2(torque2),
      torque_max(torque2),
      error_max(torque2),
      moving_torque2(torque2),
      moving_error2(torque2) {}

void ErrorSums::add(const ErrorSums& other) {
  torque2 += other.torque2;
  error2 += other.error2;
  torque_max = torque_max.cwiseMax(other.torque_max);
  error_max = error_max.cwiseMax(other.error_max);
  moving_torque2 += other.moving_torque2;
  moving_error2 += other.moving_error2;
}

void ErrorSums::add(int i, double measured, double modelled, MovingSample moves) {
  const double e = measured - modelled;
  torque2[i] += measured * measured;
  error2[i] += e * e;
  torque_max[i] = std::max(torque_max[i], std::abs(measured));
  error_max[i] = std::max(error_max[i], std::abs(e));
  if (moves == MovingSample::kNo) return;
  moving_torque2[i] += measured * measured;
  moving_error2[i] += e * e;
}

PredictionError ErrorSums::error() const {
  // A joint without torque has no relative error; where no joint moves there is no error of moving samples.
  const auto ratio = [](const VectorXd& a, const VectorXd& b) {
    return VectorXd(a.binaryExpr(b, [](double of, double to) { return of == 0.0 ? 0.0 : of / to; }));
  };
  return {ratio(error2, torque2).cwiseSqrt(), ratio(error_max, torque_max),
          moving_torque2.isZero(0.0) ? VectorXd() : VectorXd(ratio(moving_error2, moving_torque2).cwiseSqrt())};
}

ErrorSums prediction_error(const Model& arm, const std::string& path,
                           const PreprocessingOptions& options, const VectorRef& values,
                           const std::vector<TorqueFacts>& joints, PredictionSeries* series,
                           ErrorSums* without_excluded, int threads) {
  return run_prediction(
      arm, path, options, values, joints, series, without_excluded,
      [&](const Visit& visit) { return for_each_segment(arm, path, options, visit); },
      number_of_threads(threads));
}

ErrorSums prediction_error(const Model& arm, const Recording& recording,
                           const PreprocessingOptions& options, const VectorRef& values,
                           const std::vector<TorqueFacts>& joints, PredictionSeries* series,
                           ErrorSums* without_excluded) {
  return run_prediction(
      arm, recording.source, options, values, joints, series, without_excluded,
      [&](const Visit& visit) { return for_each_segment(arm, recording, options, visit); }, 1);
}

}  // namespace veridyn
