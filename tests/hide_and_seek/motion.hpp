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
  Motion(const Model& arm, unsigned seed, int number);

  /// The arm is asked to follow a given series, see Series, and deviates from it as above.
  ///
  ///   q_i = centre_i + sum_k  sine(i, k) sin(2 pi f k t) + cosine(i, k) cos(2 pi f k t),  k = 1 ..
  struct Series {
    double frequency = 0.0;  ///< f [Hz]
    int periods = 2;
    VectorXd centre;        ///< (n)
    MatrixXd sine, cosine;  ///< (n x harmonics)
  };
  Motion(const Model& arm, const Series& series, unsigned seed, int number);

  double duration() const { return duration_; }  ///< [s]
  State at(double t) const;

  struct Rows {
    VectorXd time;
    MatrixXd q, dq, ddq;  ///< (rows x n)
  };
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
  double duration_ = 0.0;
};

}  // namespace veridyn::seek
