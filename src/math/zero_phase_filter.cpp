#include "veridyn/math/zero_phase_filter.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>

#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr int kLanes = 8;
using Lanes = std::array<double, kLanes>;

}  // namespace

ZeroPhaseFilter::ZeroPhaseFilter(double cutoff, int order, double rate) {
  require(order >= 1 && order <= 20, "filter order is ", order, "; expected 1 to 20.");
  require(cutoff > 0.0 && cutoff < 0.5 * rate, "filter cut-off is ", cutoff,
          " Hz; expected above 0 and below ", 0.5 * rate, " Hz, half the sampling rate.");
  const double warped =
      std::tan(M_PI * cutoff / rate);  // cut-off of the analogue prototype, times T/2
  for (int k = 0; k < order / 2; ++k) {
    const double damping = 2.0 * std::sin(M_PI * (2 * k + 1) / (2.0 * order));
    const double scale = 1.0 + damping * warped + warped * warped;
    Section s{};
    s.b0 = warped * warped / scale;
    s.b1 = 2.0 * s.b0;
    s.b2 = s.b0;
    s.a1 = 2.0 * (warped * warped - 1.0) / scale;
    s.a2 = (1.0 - damping * warped + warped * warped) / scale;
    slowest_pole_ = std::max(slowest_pole_, std::sqrt(std::abs(s.a2)));
    sections_.push_back(s);
  }
  if (order % 2 == 1) {
    Section s{};
    s.b0 = warped / (1.0 + warped);
    s.b1 = s.b0;
    s.a1 = (warped - 1.0) / (1.0 + warped);
    slowest_pole_ = std::max(slowest_pole_, std::abs(s.a1));
    sections_.push_back(s);
  }
  for (Section& s : sections_) {
    // Transposed direct form II at rest under a constant input of one; every section has gain one
    // there.
    s.start2 = s.b2 - s.a2;
    s.start1 = s.b1 - s.a1 + s.start2;
  }
}

int ZeroPhaseFilter::settling_samples(double remainder) const {
  return static_cast<int>(std::ceil(std::log(remainder) / std::log(slowest_pole_)));
}

void ZeroPhaseFilter::apply(MatrixXd& columns) const {
  const Eigen::Index rows = columns.rows();
  if (rows < 2) return;
  const Eigen::Index pad = std::min<Eigen::Index>(rows - 1, settling_samples(1e-4));
  std::vector<Lanes> work(static_cast<size_t>(rows + 2 * pad));
  const auto sweep = [&](auto first, auto last) {
    for (const Section& s : sections_) {
      Lanes d1;
      Lanes d2;
      for (int l = 0; l < kLanes; ++l) {
        d1[l] = s.start1 * (*first)[l];
        d2[l] = s.start2 * (*first)[l];
      }
      for (auto at = first; at != last; ++at) {
        for (int l = 0; l < kLanes; ++l) {
          const double x = (*at)[l];
          const double y = s.b0 * x + d1[l];
          d1[l] = s.b1 * x - s.a1 * y + d2[l];
          d2[l] = s.b2 * x - s.a2 * y;
          (*at)[l] = y;
        }
      }
    }
  };
  for (Eigen::Index c0 = 0; c0 < columns.cols(); c0 += kLanes) {
    const int lanes = static_cast<int>(std::min<Eigen::Index>(kLanes, columns.cols() - c0));
    for (int l = 0; l < kLanes; ++l) {
      const auto column = columns.col(c0 + std::min(l, lanes - 1));
      for (Eigen::Index i = 0; i < rows; ++i) work[static_cast<size_t>(pad + i)][l] = column[i];
      for (Eigen::Index i = 1; i <= pad; ++i) {
        work[static_cast<size_t>(pad - i)][l] = 2.0 * column[0] - column[i];
        work[static_cast<size_t>(pad + rows - 1 + i)][l] =
            2.0 * column[rows - 1] - column[rows - 1 - i];
      }
    }
    sweep(work.begin(), work.end());
    sweep(work.rbegin(), work.rend());
    for (int l = 0; l < lanes; ++l) {
      for (Eigen::Index i = 0; i < rows; ++i)
        columns(i, c0 + l) = work[static_cast<size_t>(pad + i)][l];
    }
  }
}

MatrixXd differentiate(const MatrixRef& columns, double dt) {
  const Eigen::Index n = columns.rows();
  MatrixXd out = MatrixXd::Zero(n, columns.cols());
  if (n < 2) return out;
  for (Eigen::Index i = 0; i < n; ++i) {
    if (i >= 2 && i + 2 < n) {
      out.row(i) = (8.0 * (columns.row(i + 1) - columns.row(i - 1)) -
                    (columns.row(i + 2) - columns.row(i - 2))) /
                   (12.0 * dt);
    } else {
      const Eigen::Index a = std::max<Eigen::Index>(i - 1, 0);
      const Eigen::Index b = std::min<Eigen::Index>(i + 1, n - 1);
      out.row(i) = (columns.row(b) - columns.row(a)) / (static_cast<double>(b - a) * dt);
    }
  }
  return out;
}

}  // namespace veridyn
