#include "veridyn/excitation/fourier_trajectory.hpp"

#include <cmath>
#include <utility>

#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr int kSamplesPerWave = 256;

VectorXd harmonic_numbers(Eigen::Index harmonics) {
  return VectorXd::LinSpaced(harmonics, 1.0, static_cast<double>(harmonics));
}

// Sets rounding errors of the sums at rest to zero, since friction would follow their sign.
void zero_rounding(MatrixXd& signal) {
  const double rounding = 1e-12 * signal.cwiseAbs().maxCoeff();
  signal = (signal.array().abs() > rounding).select(signal, 0.0);
}

}  // namespace

FourierBasis::FourierBasis(VectorXd instants, double frequency, int harmonics)
    : time(std::move(instants)), omega(2.0 * M_PI * frequency * harmonic_numbers(harmonics)) {
  const MatrixXd phase = time * omega.transpose();
  sine = phase.array().sin();
  cosine = phase.array().cos();
}

VectorXd period_instants(double frequency, int count) {
  return VectorXd::LinSpaced(count, 0.0, count - 1.0) / (frequency * count);
}

FourierTrajectory::FourierTrajectory(double frequency, MatrixXd a, MatrixXd b, VectorXd q0)
    : frequency_(frequency), a_(std::move(a)), b_(std::move(b)), q0_(std::move(q0)) {
  require(frequency_ > 0.0 && std::isfinite(frequency_), "FourierTrajectory: found a frequency of ",
          frequency_, " Hz, expected a positive one.");
  require(a_.cols() >= 1, "FourierTrajectory: found no harmonics, expected at least one.");
  require(a_.rows() == b_.rows() && a_.cols() == b_.cols() && q0_.size() == a_.rows(),
          "FourierTrajectory: a is ", a_.rows(), " x ", a_.cols(), ", b is ", b_.rows(), " x ",
          b_.cols(), " and q0 has ", q0_.size(),
          " entries; a and b must be (joints x harmonics) and q0 (joints).");
}

MotionSamples FourierTrajectory::samples(const VectorRef& time) const {
  return samples(FourierBasis(time, frequency_, harmonics()));
}

MotionSamples FourierTrajectory::samples(const FourierBasis& basis) const {
  const auto by_omega = [&](const MatrixXd& c) -> MatrixXd {
    return (c * basis.omega.cwiseInverse().asDiagonal()).transpose();
  };
  const auto times_omega = [&](const MatrixXd& c) -> MatrixXd {
    return (c * basis.omega.asDiagonal()).transpose();
  };
  MotionSamples out;
  out.time = basis.time;
  out.q = basis.sine * by_omega(a_) - basis.cosine * by_omega(b_);
  out.q.rowwise() += q0_.transpose();
  out.dq = basis.cosine * a_.transpose() + basis.sine * b_.transpose();
  out.ddq = basis.cosine * times_omega(b_) - basis.sine * times_omega(a_);
  return out;
}

MotionSamples FourierTrajectory::motion(int periods, double rate) const {
  require(periods >= 1, "FourierTrajectory: found ", periods, " periods, expected at least one.");
  require(rate > 0.0 && std::isfinite(rate), "FourierTrajectory: found a rate of ", rate,
          " Hz, expected a positive one.");
  const double end = periods * period();
  const auto last = static_cast<Eigen::Index>(std::ceil(end * rate - 1e-9));
  const VectorXd time = VectorXd::LinSpaced(last + 1, 0.0, static_cast<double>(last)) / rate;
  MotionSamples out = samples(time.cwiseMin(end));
  out.time = time;
  zero_rounding(out.dq);
  zero_rounding(out.ddq);
  return out;
}

MotionBounds FourierTrajectory::bounds() const {
  const int count = kSamplesPerWave * harmonics();
  const FourierBasis basis(period_instants(frequency_, count), frequency_, harmonics());
  const MotionSamples s = samples(basis);
  const double h = period() / count;
  const MatrixXd size = (a_.array().square() + b_.array().square()).sqrt();
  const VectorXd omega2 = basis.omega.cwiseAbs2();
  const VectorXd q_slack = h * h / 8.0 * (size * basis.omega);
  const VectorXd dq_slack = h * h / 8.0 * (size * omega2);
  const VectorXd ddq_slack = h * h / 8.0 * (size * omega2.cwiseProduct(basis.omega));
  return {s.q.colwise().minCoeff().transpose() - q_slack,
          s.q.colwise().maxCoeff().transpose() + q_slack,
          s.dq.cwiseAbs().colwise().maxCoeff().transpose() + dq_slack,
          s.ddq.cwiseAbs().colwise().maxCoeff().transpose() + ddq_slack};
}

void rest_at_start(MatrixXd& a, MatrixXd& b) {
  const VectorXd mean = a.rowwise().mean();
  a.colwise() -= mean;
  const VectorXd numbers = harmonic_numbers(b.cols());
  const VectorXd share = b * numbers / numbers.squaredNorm();
  b -= share * numbers.transpose();
}

}  // namespace veridyn
