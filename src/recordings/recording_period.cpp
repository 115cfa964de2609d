#include "veridyn/recordings/recording_period.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace veridyn {
namespace {

constexpr double kRestingRange = 5e-3;   // [rad, m] joints with a smaller range are ignored
constexpr double kDeep = 0.02;           // largest d of a repeat
// d must exceed this at a smaller lag, so that the motion has left its start.
constexpr double kRisen = 0.25;
constexpr double kKeptShare = 0.8;       // share of the times that count in d; the others are the worst
constexpr double kLongestShare = 0.7;    // largest period as a share of the duration; the rest is the overlap
constexpr double kCoarsestStep = 0.025;  // [s] largest step of the coarse grid
constexpr int kCoarseRows = 5000;
constexpr int kSampledTimes = 256;   // instants of an estimate of d
constexpr double kSuspected = 4.0;  // lags with estimates up to this times kDeep are computed exactly
constexpr double kSurelyRisen = 0.5;  // lags with estimates below this times kRisen have not risen
constexpr double kCap = 8.0;          // bound at which samples of an estimate are cut, for speed only

// Positions of the moving joints on an even grid, each with unit variance.
struct Grid {
  double step = 0.0;
  MatrixXd q;  // (rows x moving joints)
};

// Rows from `first` on with complete positions, without rests at either end.
struct Motion {
  std::vector<double> time;
  MatrixXd q;  // (rows x moving joints)
};

Motion moving_part(const Recording& recording) {
  std::vector<int> rows;
  for (int k = 0; k < recording.rows(); ++k) {
    if (recording.q.row(k).allFinite()) rows.push_back(k);
  }
  Motion motion;
  if (rows.size() < 16) return motion;
  std::vector<int> joints;
  VectorXd tolerance = VectorXd::Zero(recording.joints());
  for (int j = 0; j < recording.joints(); ++j) {
    double low = INFINITY;
    double high = -INFINITY;
    for (const int k : rows) {
      low = std::min(low, recording.q(k, j));
      high = std::max(high, recording.q(k, j));
    }
    if (high - low > kRestingRange) joints.push_back(j);
    tolerance[j] = 0.02 * (high - low);
  }
  const auto moved = [&](int k, int from) {
    return std::any_of(joints.begin(), joints.end(), [&](int j) {
      return std::abs(recording.q(k, j) - recording.q(from, j)) > tolerance[j];
    });
  };
  const auto first =
      std::find_if(rows.begin(), rows.end(), [&](int k) { return moved(k, rows.front()); });
  auto last = rows.end();
  while (last > first && !moved(*(last - 1), rows.back())) --last;
  rows.assign(first, last);
  motion.q.resize(static_cast<int>(rows.size()), static_cast<int>(joints.size()));
  for (std::size_t r = 0; r < rows.size(); ++r) {
    motion.time.push_back(recording.time[rows[r]]);
    for (std::size_t j = 0; j < joints.size(); ++j) {
      motion.q(static_cast<int>(r), static_cast<int>(j)) = recording.q(rows[r], joints[j]);
    }
  }
  return motion;
}

// Linear interpolation, then zero mean and unit variance.
Grid resampled(const Motion& motion, double duration, int rows) {
  Grid grid{duration / (rows - 1), MatrixXd(rows, motion.q.cols())};
  std::size_t k = 0;
  for (int r = 0; r < rows; ++r) {
    const double t = motion.time.front() + r * grid.step;
    while (k + 2 < motion.time.size() && motion.time[k + 1] < t) ++k;
    const double share =
        std::clamp((t - motion.time[k]) / (motion.time[k + 1] - motion.time[k]), 0.0, 1.0);
    const int row = static_cast<int>(k);
    grid.q.row(r) = (1.0 - share) * motion.q.row(row) + share * motion.q.row(row + 1);
  }
  for (int j = 0; j < grid.q.cols(); ++j) {
    grid.q.col(j).array() -= grid.q.col(j).mean();
    const double deviation = std::sqrt(grid.q.col(j).squaredNorm() / rows);
    if (deviation > 0.0) grid.q.col(j) /= deviation;
  }
  return grid;
}

// d(lag) for a lag in steps of the grid, not necessarily an integer. If d exceeds `most`, the result may be any
// larger number.
double difference(const Grid& grid, double lag, std::vector<double>* scratch, double most = INFINITY) {
  const int whole = static_cast<int>(lag);
  const double part = lag - whole;
  const int rows = static_cast<int>(grid.q.rows()) - whole - 1;
  VectorXd sum = VectorXd::Zero(rows);
  for (int j = 0; j < grid.q.cols(); ++j) {
    const auto q = grid.q.col(j);
    sum.array() +=
        ((1.0 - part) * q.segment(whole, rows) + part * q.segment(whole + 1, rows) - q.head(rows))
            .array()
            .square();
  }
  const auto kept = static_cast<int>(kKeptShare * rows);
  const double scale = 2.0 * static_cast<double>(grid.q.cols());
  // The sum of the kept, smallest values is at least the sum of all values, each cut at `cap`, minus `cap`
  // for each value that is not kept.
  const double cap = kCap * most * scale;
  if (most < INFINITY && sum.cwiseMin(cap).sum() > cap * (rows - kept) + most * scale * kept) return INFINITY;
  scratch->assign(sum.data(), sum.data() + rows);
  std::nth_element(scratch->begin(), scratch->begin() + kept, scratch->end());
  return std::accumulate(scratch->begin(), scratch->begin() + kept, 0.0) / (scale * kept);
}

// Computes d at integer lags on demand: exact up to `most`, which later calls must not exceed.
class Differences {
 public:
  explicit Differences(const Grid& grid)
      : grid_(grid),
        rows_(grid.q),
        longest_(static_cast<int>(kLongestShare * static_cast<double>(grid.q.rows()))),
        values_(static_cast<std::size_t>(longest_) + 1, -1.0) {}

  int longest_lag() const { return longest_; }

  double operator()(int lag, double most = kDeep) {
    double& value = values_[lag];
    if (value < 0.0) value = difference(grid_, lag, &scratch_, most);
    return value;
  }

  // True if an estimate of d from kSampledTimes only exceeds `most`. The estimate is a lower bound: positions
  // are smooth, and samples at one phase of the motion can make d only smaller.
  bool exceeds(double most, int lag) {
    const Eigen::Index columns = rows_.cols();
    const Eigen::Index times = rows_.rows() - lag;
    const Eigen::Index count = std::min<Eigen::Index>(times, kSampledTimes);
    const auto kept = static_cast<Eigen::Index>(kKeptShare * static_cast<double>(count));
    const double most_sum = most * 2.0 * static_cast<double>(columns * kept);
    // The same bound as in difference(), over pairs of samples: it excludes most lags after a few samples,
    // without sorting.
    const double cap = kCap * most * 2.0 * static_cast<double>(columns);
    const double certain = most_sum + cap * static_cast<double>(count - kept);
    double cut_sum = 0.0;
    scratch_.resize(count);
    for (Eigen::Index s = 0; s < count; ++s) {
      const double* now = rows_.data() + s * times / count * columns;
      const double* then = now + lag * columns;
      double sum = 0.0;
      for (Eigen::Index j = 0; j < columns; ++j) sum += (then[j] - now[j]) * (then[j] - now[j]);
      scratch_[s] = sum;
      cut_sum += std::min(sum, cap);
      if (cut_sum > certain) return true;
    }
    std::nth_element(scratch_.begin(), scratch_.begin() + kept, scratch_.end());
    return std::accumulate(scratch_.begin(), scratch_.begin() + kept, 0.0) > most_sum;
  }

 private:
  const Grid& grid_;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> rows_;
  int longest_;
  std::vector<double> values_;  // negative: not computed yet
  std::vector<double> scratch_;
};

// The smallest lag, in steps of a coarse grid, at which the motion repeats as well as at any other; 0: none.
int coarse_period(const Grid& grid) {
  Differences d(grid);
  int lag = 0;
  while (lag <= d.longest_lag() && (!d.exceeds(kSurelyRisen * kRisen, lag) || d(lag, kRisen) <= kRisen)) ++lag;
  std::vector<int> minima;
  double best = kDeep;
  for (++lag; lag < d.longest_lag(); ++lag) {
    if (d.exceeds(kSuspected * kDeep, lag) || d(lag) > kDeep) continue;
    if (d(lag) > d(lag - 1) || d(lag) > d(lag + 1)) continue;
    minima.push_back(lag);
    best = std::min(best, d(lag));
  }
  for (const int at : minima) {
    if (d(at) <= std::max(4.0 * best, 0.1 * kDeep)) return at;
  }
  return 0;
}

// Minimum of d near `lag`, by successive parabolas through three points.
double refined(const Grid& grid, double lag, double reach) {
  std::vector<double> scratch;
  for (int pass = 0; pass < 6; ++pass) {
    const double left = difference(grid, lag - reach, &scratch);
    const double middle = difference(grid, lag, &scratch);
    const double right = difference(grid, lag + reach, &scratch);
    const double curvature = left - 2.0 * middle + right;
    if (!(curvature > 0.0)) return lag;
    const double change = std::clamp(0.5 * reach * (left - right) / curvature, -reach, reach);
    lag += change;
    if (reach <= 1.0 && std::abs(change) < 1e-4) break;
    reach = std::max(1.0, 0.5 * reach);
  }
  return lag;
}

}  // namespace

MotionPeriod detect_period(const Recording& recording) {
  MotionPeriod period;
  const Motion motion = moving_part(recording);
  if (motion.time.size() < 16 || motion.q.cols() == 0) return period;
  const double duration = motion.time.back() - motion.time.front();
  const double searched = std::min(duration, kCoarsestStep * kCoarseRows);
  const Grid fine = resampled(motion, duration, static_cast<int>(motion.time.size()));
  const int coarse_rows = std::min(kCoarseRows, static_cast<int>(motion.time.size()));
  const Grid coarse = resampled(motion, searched, coarse_rows);
  const int lag = coarse_period(coarse);
  if (lag == 0) return period;

  const double ratio = coarse.step / fine.step;
  double steps = refined(fine, lag * ratio, std::max(2.0, 2.0 * ratio));
  const double limit = kLongestShare * static_cast<double>(fine.q.rows());
  for (int repeat = 2; repeat * steps < limit; repeat *= 2)
    steps = refined(fine, repeat * steps, 2.0) / repeat;
  std::vector<double> scratch;
  period.seconds = steps * fine.step;
  period.confidence = 1.0 - difference(fine, steps, &scratch);
  period.repeats = duration / period.seconds;
  return period;
}

}  // namespace veridyn
