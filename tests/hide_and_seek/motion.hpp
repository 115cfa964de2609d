#pragma once

#include <vector>

#include "hide_and_seek/draw.hpp"
#include "hide_and_seek/lagrange_arm.hpp"

namespace veridyn::seek {

struct State {
  VectorXd q, dq, ddq;
};

/// Fourier series over two or more periods, from rest to rest, plus the deviation that a controller
/// leaves: smooth waves that do not repeat. Known at every time, with exact derivatives.
class Motion {
 public:
  /// @param number  of the recording: every one has other coefficients and another frequency.
  /// @param reach   of a usual motion's amplitude and speed, above 0 and at most 1.
  Motion(const Model& arm, unsigned seed, int number, double reach = 1.0);

  struct Rows {
    VectorXd time;
    MatrixXd q, dq, ddq;  ///< (rows x n)
  };

  /// The arm follows given rows, evenly spaced from time zero on, with the same deviation. Between
  /// the rows: polynomials of fifth order.
  Motion(const Model& arm, Rows wanted, unsigned seed, int number);

  double duration() const { return duration_; }  ///< [s]
  State at(double t) const;

  Rows sampled(double rate) const;

 private:
  struct Wave {
    double omega, sine, cosine;
  };
  struct Joint {
    double centre = 0.0;
    std::vector<Wave> wanted;
    std::vector<Wave> deviation;
  };
  void add_deviation(Joint& joint, bool prismatic, Draw& draw) const;

  std::vector<Joint> joints_;
  Rows given_;  ///< empty: the motion is the Fourier series
  double duration_ = 0.0;
};

}  // namespace veridyn::seek
