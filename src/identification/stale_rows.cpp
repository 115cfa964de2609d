#include "veridyn/identification/stale_rows.hpp"

#include <utility>

namespace veridyn {
namespace {

constexpr double kLongest = 0.1;  // [s] between the sound rows on either side

bool repeats(const Recording& r, Eigen::Index k) {
  for (const RecordingSignal& signal : kRecordingSignals) {
    const MatrixXd& m = r.*signal.values;
    for (Eigen::Index i = 0; i < m.cols() && m.rows() > 0; ++i) {
      if (!(m(k, i) == m(k - 1, i))) return false;  // written so that a NaN never repeats
    }
  }
  return true;
}

bool finite_row(const Recording& r, Eigen::Index k) {
  for (const RecordingSignal& signal : kRecordingSignals) {
    const MatrixXd& m = r.*signal.values;
    if (m.rows() > 0 && !m.row(k).allFinite()) return false;
  }
  return true;
}

// The share u of the way from p0 to p1, whose slopes per whole way are v0 and v1.
double hermite(double p0, double v0, double p1, double v1, double u) {
  const double left = 1.0 - u;
  return left * left * ((1.0 + 2.0 * u) * p0 + u * v0) + u * u * ((3.0 - 2.0 * u) * p1 - left * v1);
}

// Fills in the rows between two sound ones.
void fill(Recording& r, Eigen::Index before, Eigen::Index after) {
  const double length = r.time[after] - r.time[before];
  for (Eigen::Index k = before + 1; k < after; ++k) {
    const double u = (r.time[k] - r.time[before]) / length;
    for (const RecordingSignal& signal : kRecordingSignals) {
      MatrixXd& m = r.*signal.values;
      if (m.rows() > 0) m.row(k) = (1.0 - u) * m.row(before) + u * m.row(after);
    }
    for (Eigen::Index i = 0; i < r.dq.cols(); ++i)
      r.q(k, i) = hermite(r.q(before, i), length * r.dq(before, i), r.q(after, i),
                          length * r.dq(after, i), u);
  }
}

}  // namespace

RepairedRecording without_stale_rows(Recording recording) {
  RepairedRecording out{std::move(recording), 0};
  Recording& r = out.recording;
  const Eigen::Index rows = r.rows();
  for (Eigen::Index k = 1; k < rows; ++k) {
    if (!repeats(r, k)) continue;
    Eigen::Index after = k + 1;
    while (after < rows && repeats(r, after)) ++after;
    const Eigen::Index before = k - 1;
    const bool moves = after < rows && finite_row(r, after) && r.q.row(before) != r.q.row(after);
    if (moves && r.time[after] - r.time[before] <= kLongest) {
      fill(r, before, after);
      out.repaired += after - k;
    }
    k = after;
  }
  return out;
}

}  // namespace veridyn
