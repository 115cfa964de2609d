#include "veridyn/model/joint_sensors.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "math/digits.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr double kSmallestPivot = 1e-6;

std::vector<RecordedChannel> channels_of(const Model& arm) {
  std::vector<RecordedChannel> out;
  for (const Coordinate& c : arm.coordinates()) out.push_back(c.recorded);
  return out;
}

// Computes signal(t - delay) by linear interpolation; before the first row the signal equals its first value.
VectorXd delayed(const VectorRef& signal, const VectorRef& time, double delay) {
  VectorXd out(signal.size());
  Eigen::Index k = 0;
  for (Eigen::Index row = 0; row < signal.size(); ++row) {
    const double t = time[row] - delay;
    while (k + 1 < row && time[k + 1] <= t) ++k;
    const double u = k + 1 < signal.size() ? (t - time[k]) / (time[k + 1] - time[k]) : 0.0;
    out[row] = t <= time[0] ? signal[0] : (1.0 - u) * signal[k] + u * signal[k + 1];
  }
  return out;
}

}  // namespace

JointSensors::JointSensors(const Model& arm) : JointSensors(channels_of(arm)) {
  for (Eigen::Index j = 0; j < drive_gain_.size(); ++j)
    drive_gain_[j] = arm.coordinates()[j].drive_gain;
}

JointSensors::JointSensors(std::vector<RecordedChannel> channels) : channels_(std::move(channels)) {
  const auto n = static_cast<Eigen::Index>(channels_.size());
  offset_ = delay_ = VectorXd::Zero(n);
  gain_ = drive_gain_ = VectorXd::Ones(n);
  for (Eigen::Index j = 0; j < n; ++j) {
    const RecordedChannel& c = channels_[j];
    require(c.torque_gain > 0.0 && std::isfinite(c.torque_gain) &&
                std::isfinite(c.position_offset) && std::isfinite(c.torque_delay),
            "JointSensors: joint ", j + 1, " has a torque gain of ", c.torque_gain,
            ", a position offset of ", c.position_offset, " and a torque delay of ", c.torque_delay,
            " s, expected finite numbers, the gain above zero.");
    offset_[j] = c.position_offset;
    gain_[j] = c.torque_gain;
    delay_[j] = c.torque_delay;
    const bool alone = c.torque_crosstalk.empty();
    ideal_ = ideal_ && offset_[j] == 0.0 && gain_[j] == 1.0 && delay_[j] == 0.0 && alone;
    if (!alone && crosstalk_.size() == 0) crosstalk_ = MatrixXd::Identity(n, n);
    for (const auto& [from, share] : c.torque_crosstalk) {
      require(from.value >= 0 && from.value < n && from.value != j && std::isfinite(share), "JointSensors: joint ", j + 1,
              " has a torque crosstalk of ", share, " from joint ", from.value + 1,
              ", expected a finite number and another of the ", n, " joints.");
      crosstalk_(j, from.value) = share;
    }
  }
  // LU without pivoting, which is stable if the shares in each row sum to less than one.
  for (Eigen::Index k = 0; k < crosstalk_.rows(); ++k) {
    require(std::abs(crosstalk_(k, k)) > kSmallestPivot,
            "JointSensors: found a torque crosstalk that leaves nothing of the torque of joint ", k + 1,
            ", expected torques that can be told apart.");
    for (Eigen::Index i = k + 1; i < crosstalk_.rows(); ++i) {
      crosstalk_(i, k) /= crosstalk_(k, k);
      for (Eigen::Index c = k + 1; c < crosstalk_.cols(); ++c)
        crosstalk_(i, c) -= crosstalk_(i, k) * crosstalk_(k, c);
    }
  }
}

void JointSensors::remove_crosstalk(InPlace tau) const noexcept {
  const Eigen::Index n = crosstalk_.rows();
  for (Eigen::Index i = 1; i < n; ++i) {
    for (Eigen::Index k = 0; k < i; ++k) tau[i] -= crosstalk_(i, k) * tau[k];
  }
  for (Eigen::Index i = n; i-- > 0;) {
    for (Eigen::Index k = i + 1; k < n; ++k) tau[i] -= crosstalk_(i, k) * tau[k];
    tau[i] /= crosstalk_(i, i);
  }
}

void JointSensors::add_crosstalk(InPlace tau) const noexcept {
  const Eigen::Index n = crosstalk_.rows();
  for (Eigen::Index i = 0; i < n; ++i) {
    tau[i] *= crosstalk_(i, i);
    for (Eigen::Index k = i + 1; k < n; ++k) tau[i] += crosstalk_(i, k) * tau[k];
  }
  for (Eigen::Index i = n; i-- > 1;) {
    for (Eigen::Index k = 0; k < i; ++k) tau[i] += crosstalk_(i, k) * tau[k];
  }
}

VectorXd JointSensors::largest_true_torques(const VectorRef& largest) const {
  const VectorXd alone = largest.cwiseQuotient(gain_);
  VectorXd ratio = VectorXd::Ones(joints());
  for (int i = 0; i < joints(); ++i) {
    double command = alone[i];
    for (const auto& [from, share] : channels_[i].torque_crosstalk) command += std::abs(share) * alone[from.value];
    const double allowed = command > 0.0 ? alone[i] / command : 1.0;
    ratio[i] = std::min(ratio[i], allowed);
    for (const auto& [from, share] : channels_[i].torque_crosstalk) {
      if (share != 0.0) ratio[from.value] = std::min(ratio[from.value], allowed);
    }
  }
  return alone.cwiseProduct(ratio);
}

void JointSensors::require_drive_gains(const Model& arm, const std::string& where) const {
  for (int j = 0; j < joints(); ++j) {
    require(drive_gain_[j] != 0.0, where, ": found motor currents only, and robot '", arm.name(),
            "' has no drive_gain for coordinate '", arm.coordinates()[j].name,
            "'; drive gains (--drive-gains K,K,..., drive_gains= in Python) give the torque per ampere "
            "of each joint, known masses find it (--known-mass), and a robot file (info --yaml writes "
            "one) keeps it.");
  }
}

void JointSensors::add_errors(const VectorRef& time, MatrixXd& q, MatrixXd& tau) const {
  q.rowwise() += offset_.transpose();
  for (Eigen::Index j = 0; j < tau.cols(); ++j) {
    if (delay_[j] > 0.0) tau.col(j) = delayed(tau.col(j), time, delay_[j]);
  }
  if (crosstalk_.size() > 0) {
    for (Eigen::Index row = 0; row < tau.rows(); ++row) {
      VectorXd all = tau.row(row);
      add_crosstalk(all);
      tau.row(row) = all;
    }
  }
  for (Eigen::Index j = 0; j < tau.cols(); ++j) tau.col(j) *= gain_[j];
}

std::vector<std::string> JointSensors::descriptions(const Model& arm) const {
  std::vector<std::string> out;
  for (int j = 0; j < joints(); ++j) {
    const Coordinate& c = arm.coordinates()[j];
    const RecordedChannel& e = channels_[j];
    const std::string encoder = "the encoder of joint '" + c.name + "' shows ";
    const std::string torque = "the recorded torque of joint '" + c.name + "' is ";
    if (e.position_offset != 0.0)
      out.push_back(encoder + digits(std::abs(e.position_offset), 6) + " " + position_unit(c) +
                    (e.position_offset > 0.0 ? " more" : " less") + " than there is");
    if (e.torque_gain != 1.0)
      out.push_back(torque + digits(e.torque_gain, 6) + " times the true one");
    if (e.torque_delay != 0.0)
      out.push_back(torque + digits(1e3 * std::abs(e.torque_delay), 4) + " ms " +
                    (e.torque_delay > 0.0 ? "late" : "early"));
    for (const auto& [from, share] : e.torque_crosstalk)
      out.push_back(torque + "mixed with " + digits(share, 6) + " times that of joint '" +
                    arm.coordinates()[from.value].name + "'");
  }
  return out;
}

}  // namespace veridyn
