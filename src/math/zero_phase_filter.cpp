#include "math/zero_phase_filter.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "aligned_doubles.hpp"
#include "filter_sweep.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

// Builds a section from the coefficients of y = b0 x + b1 x' + b2 x'' - a1 y' - a2 y''.
FilterSection section(double b0, double b1, double b2, double a1, double a2) {
  // s2 in the steady state for a constant input of one; every section has unit gain at zero frequency.
  const double start2 = b2 - a2;
  return {b0, b1 - a1 * b0, b2 - a2 * b0, a1, a2, b1 - a1 + start2, start2};
}

}  // namespace

ZeroPhaseFilter::~ZeroPhaseFilter() = default;
ZeroPhaseFilter::ZeroPhaseFilter(const ZeroPhaseFilter&) = default;
ZeroPhaseFilter& ZeroPhaseFilter::operator=(const ZeroPhaseFilter&) = default;

ZeroPhaseFilter::ZeroPhaseFilter(double cutoff, int order, double rate) {
  require(order >= 1 && order <= 20, "filter order is ", order, "; expected 1 to 20.");
  require(cutoff > 0.0 && cutoff < 0.5 * rate, "filter cut-off is ", cutoff,
          " Hz; expected above 0 and below ", 0.5 * rate, " Hz, half the sampling rate.");
  const double warped =
      std::tan(M_PI * cutoff / rate);  // cut-off of the analogue prototype, times half the time step
  for (int k = 0; k < order / 2; ++k) {
    const double damping = 2.0 * std::sin(M_PI * (2 * k + 1) / (2.0 * order));
    const double scale = 1.0 + damping * warped + warped * warped;
    const double b0 = warped * warped / scale;
    const double a2 = (1.0 - damping * warped + warped * warped) / scale;
    slowest_pole_ = std::max(slowest_pole_, std::sqrt(std::abs(a2)));
    sections_.push_back(
        section(b0, 2.0 * b0, b0, 2.0 * (warped * warped - 1.0) / scale, a2));
  }
  if (order % 2 == 1) {
    const double b0 = warped / (1.0 + warped);
    const double a1 = (warped - 1.0) / (1.0 + warped);
    slowest_pole_ = std::max(slowest_pole_, std::abs(a1));
    sections_.push_back(section(b0, b0, 0.0, a1, 0.0));
  }
}

int ZeroPhaseFilter::settling_samples(double remainder) const {
  return static_cast<int>(std::ceil(std::log(remainder) / std::log(slowest_pole_)));
}

void ZeroPhaseFilter::apply(MatrixXd& columns) const {
  const Eigen::Index rows = columns.rows();
  if (rows < 2) return;
  const Eigen::Index pad = std::min<Eigen::Index>(rows - 1, settling_samples(1e-4));
  thread_local AlignedDoubles memory;
  FilterSweep sweep{sections_.data(), static_cast<int>(sections_.size()),
                    nullptr,          0,
                    rows,             pad,
                    nullptr};
  sweep.work = memory.get(static_cast<size_t>((rows + 2 * pad) * kFilterLanes));
  std::array<double*, kFilterLanes> lanes{};
  sweep.columns = lanes.data();
  for (Eigen::Index c = 0; c < columns.cols(); c += kFilterLanes) {
    sweep.lanes = static_cast<int>(std::min<Eigen::Index>(kFilterLanes, columns.cols() - c));
    for (int l = 0; l < sweep.lanes; ++l) lanes[l] = columns.data() + (c + l) * rows;
    filter_kernels().run(sweep);
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
