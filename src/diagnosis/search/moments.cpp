#include "diagnosis/search/moments.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "diagnosis/search/numbers.hpp"

namespace veridyn::search {
namespace {

// The rows of one recording.
class OneRecording {
 public:
  OneRecording(const Rows& rows, const MatrixXd& residual, const VectorXd& scale, size_t recording, const std::string& source)
      : rows_(rows), residual_(residual), scale_(scale), source_(source) {
    for (Eigen::Index k = 0; k < rows.rows(); ++k) {
      if (rows.recording()[k] == recording) own_.push_back(k);
    }
  }

  // @param period  [s] of the motion; 0: it does not repeat.
  std::vector<Contact> contacts(double period) {
    if (own_.size() < kFewestRows) return {};
    const double step = (time_of(row_count() - 1) - time_of(0)) / static_cast<double>(row_count() - 1);
    compute_running_means(std::max<std::ptrdiff_t>(1, std::lround(0.5 * kMomentSeconds / step)));
    std::vector<Contact> out;
    double pushed = 0.0;
    for (std::ptrdiff_t k = 0; k < row_count();) {
      if (!is_large(k)) {
        ++k;
        continue;
      }
      auto end = k;
      while (end < row_count() && is_large(end)) ++end;
      const auto [first, last] = cut_to_half_height(k, end);
      if (first < last) {
        Contact c = contact(first, last);
        pushed += c.to - c.from;
        if (c.peak > 0.0 && c.to - c.from >= kShortest && !repeats_with_period(c, period)) out.push_back(std::move(c));
      }
      k = end;
    }
    if (pushed >= kMostOfTime * step * static_cast<double>(row_count())) out.clear();
    return out;
  }

 private:
  std::ptrdiff_t row_count() const { return static_cast<std::ptrdiff_t>(own_.size()); }
  double time_of(std::ptrdiff_t k) const { return rows_.time()[own_[k]]; }
  bool is_large(std::ptrdiff_t k) const { return (mean_.row(k).cwiseAbs().array() >= kMomentSize).any(); }

  // Fills mean_ with running means over 2 * half + 1 rows, divided by the scale of the residual.
  void compute_running_means(std::ptrdiff_t half) {
    const int n = rows_.joints();
    mean_ = MatrixXd::Zero(row_count(), n);
    for (int j = 0; j < n; ++j) {
      if (scale_.size() <= j || scale_[j] <= 0.0) continue;
      for (std::ptrdiff_t k = half; k + half < row_count(); ++k) {
        double sum = 0.0;
        for (auto at = k - half; at <= k + half; ++at) sum += residual_(own_[at], j);
        mean_(k, j) = sum / static_cast<double>(2 * half + 1) / scale_[j];
      }
    }
    usual_ = VectorXd(n);
    for (int j = 0; j < n; ++j) {
      VectorXd all = mean_.col(j).cwiseAbs();
      const auto at = all.data() + static_cast<std::ptrdiff_t>(kUsualShare * static_cast<double>(row_count() - 1));
      std::nth_element(all.data(), at, all.data() + all.size());
      usual_[j] = std::max(1.0, *at);
    }
  }

  // True if the residual is alike one period before or after: a function of the motion, not a push.
  bool repeats_with_period(const Contact& c, double period) const {
    for (const double shift : {-period, period}) {
      double sum = 0.0, rows = 0.0;
      for (std::ptrdiff_t k = 0; k < row_count() && shift != 0.0; ++k) {
        if (time_of(k) < c.from + shift || time_of(k) > c.to + shift) continue;
        sum += residual_(own_[k], c.last_joint);
        rows += 1.0;
      }
      if (rows > 0.0 && sum / rows / c.effort[c.last_joint] >= 0.5) return true;
    }
    return false;
  }

  // Running means and filters extend a push on either side: it begins and ends at half of its height.
  std::pair<std::ptrdiff_t, std::ptrdiff_t> cut_to_half_height(std::ptrdiff_t first, std::ptrdiff_t end) const {
    VectorXd height = VectorXd::Zero(rows_.joints());
    for (auto at = first; at < end; ++at) {
      for (int j = 0; j < rows_.joints(); ++j) height[j] = std::max(height[j], std::abs(residual_(own_[at], j)));
    }
    const auto is_pushed = [&](std::ptrdiff_t row) {
      for (int j = 0; j < rows_.joints(); ++j) {
        if (height[j] >= kPeak * scale_[j] && std::abs(residual_(own_[row], j)) >= 0.5 * height[j]) return true;
      }
      return false;
    };
    while (first < end && !is_pushed(first)) ++first;
    while (end > first && !is_pushed(end - 1)) --end;
    return {first, end};
  }

  // The contact between two rows; its peak stays zero if no joint's residual is large enough.
  Contact contact(std::ptrdiff_t first, std::ptrdiff_t end) const {
    const int n = rows_.joints();
    Contact c;
    c.source = source_;
    c.from = time_of(first);
    c.to = time_of(end - 1);
    c.effort = VectorXd::Zero(n);
    for (int j = 0; j < n; ++j) {
      for (auto at = first; at < end; ++at) c.effort[j] += residual_(own_[at], j) / static_cast<double>(end - first);
      const double peak = mean_.block(first, j, end - first, 1).cwiseAbs().maxCoeff();
      if (peak < kPeak * usual_[j] || std::abs(c.effort[j]) < kTorqueShare * rows_.measured.col(j).cwiseAbs().maxCoeff()) continue;
      c.last_joint = j;
      c.deviation = scale_[j];
      c.peak = std::max(c.peak, peak);
    }
    return c;
  }

  const Rows& rows_;
  const MatrixXd& residual_;
  const VectorXd& scale_;
  const std::string& source_;
  std::vector<Eigen::Index> own_;
  MatrixXd mean_;   // (rows x n)
  VectorXd usual_;  // (n) size of the running means in this recording, at least one scale
};

}  // namespace

void add_moments_in(const Rows& rows, const MatrixXd& residual, const VectorXd& scale, const std::vector<std::string>& sources,
                    const std::vector<double>& periods, std::vector<Contact>& out) {
  for (size_t r = 0; r < sources.size(); ++r) {
    std::vector<Contact> own = OneRecording(rows, residual, scale, r, sources[r]).contacts(periods[r]);
    out.insert(out.end(), std::make_move_iterator(own.begin()), std::make_move_iterator(own.end()));
  }
}

}  // namespace veridyn::search
