#pragma once

#include <vector>

#include "veridyn/math/types.hpp"

namespace veridyn {

struct FilterSection;  // defined in src/math/filter_sweep.hpp

/// A Butterworth low-pass run forward and backward, so that it has no phase lag.
///
/// Second-order sections by the bilinear transform with pre-warping; any order. One pass damps by 3
/// dB at the cut-off, the two together by 6 dB (as MATLAB's filtfilt, which the thesis uses). At
/// the ends the signal is continued by its odd reflection and the sections start in the steady
/// state of the first value, so that a straight line passes unchanged. Source: Gustafsson, IEEE
/// Trans. Signal Processing 44(4), 1996 (start-up of forward-backward filters).
class ZeroPhaseFilter {
 public:
  /// @param cutoff  cut-off frequency [Hz], between 0 and rate / 2.
  /// @param order   order of one pass, 1 to 20.
  /// @param rate    sample rate [Hz].
  /// @throws InvalidInput  a parameter is outside of its range.
  ZeroPhaseFilter(double cutoff, int order, double rate);

  /// Filters every column in place. Columns are filtered eight at a time.
  void apply(MatrixXd& columns) const;

  ~ZeroPhaseFilter();
  ZeroPhaseFilter(const ZeroPhaseFilter&);
  ZeroPhaseFilter& operator=(const ZeroPhaseFilter&);

  /// Number of samples after which a disturbance has decayed to `remainder` of its size.
  int settling_samples(double remainder) const;

 private:
  std::vector<FilterSection> sections_;
  double slowest_pole_ = 0.0;  ///< largest magnitude of a pole
};

/// Time derivative of every column by central differences of fourth order, of lower order at the ends. The rows
/// are dt [s] apart.
MatrixXd differentiate(const MatrixRef& columns, double dt);

}  // namespace veridyn
