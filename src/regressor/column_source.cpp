#include "regressor/column_source.hpp"

#include <utility>

namespace veridyn {
namespace {

class BodyColumns final : public ColumnSource {
 public:
  explicit BodyColumns(const Model& arm)
      : count_(kBodyParameters * static_cast<int>(arm.bodies().size())), batch_(arm) {}

  int count() const override { return count_; }
  std::vector<int> columns(int joint) const override { return batch_.columns({joint}); }
  void evaluate(const MotionSamples& m, std::vector<MatrixXd>& Y) const override {
    batch_.evaluate(m.q, m.dq, m.ddq, Y);
  }
  void add_gradient(const MotionSamples& m, const std::vector<MatrixXd>& weights,
                    MatrixXd& slopes) const override {
    MatrixXd own;
    batch_.gradient(m.q, m.dq, m.ddq, weights, own);
    slopes += own;
  }

 private:
  int count_;
  TorqueRegressor batch_;
};

class TorqueColumn final : public ColumnSource {
 public:
  TorqueColumn(const Model& arm, VectorXd phi, TorquePart part, VectorXd joints)
      : batch_(arm), phi_(std::move(phi)), part_(part), joints_(std::move(joints)) {}

  int count() const override { return 1; }
  std::vector<int> columns(int joint) const override {
    return joints_[joint] != 0.0 ? std::vector<int>{0} : std::vector<int>{};
  }
  void evaluate(const MotionSamples& m, std::vector<MatrixXd>& Y) const override {
    const MatrixXd still = MatrixXd::Zero(m.rows(), m.joints());
    const bool whole = part_ == TorquePart::kWhole;
    MatrixXd tau;
    batch_.torques(m.q, whole ? m.dq : still, whole ? m.ddq : still, phi_, tau);
    Y.resize(m.joints());
    for (Eigen::Index i = 0; i < m.joints(); ++i) {
      Y[i].resize(m.rows(), joints_[i] != 0.0 ? 1 : 0);
      if (joints_[i] != 0.0) Y[i].col(0) = joints_[i] * tau.col(i);
    }
  }
  void add_gradient(const MotionSamples& m, const std::vector<MatrixXd>& weights,
                    MatrixXd& slopes) const override {
    const MatrixXd still = MatrixXd::Zero(m.rows(), m.joints());
    const bool whole = part_ == TorquePart::kWhole;
    MatrixXd by_state;
    batch_.torque_derivatives(m.q, whole ? m.dq : still, whole ? m.ddq : still, phi_, by_state);
    const Eigen::Index n = m.joints();
    for (Eigen::Index d = 0; d < (whole ? 3 * n : n); ++d) {
      for (Eigen::Index i = 0; i < n; ++i) {
        if (joints_[i] == 0.0) continue;
        slopes.col(d).array() += joints_[i] * weights[i].col(0).array() *
                                 by_state.col(d * n + i).array();
      }
    }
  }

 private:
  TorqueRegressor batch_;
  VectorXd phi_;
  TorquePart part_;
  VectorXd joints_;
};

}  // namespace

std::unique_ptr<ColumnSource> body_columns(const Model& arm) {
  return std::make_unique<BodyColumns>(arm);
}

std::unique_ptr<ColumnSource> torque_column(const Model& arm, const VectorXd& phi, TorquePart part,
                                            const VectorXd& joints) {
  return std::make_unique<TorqueColumn>(arm, phi, part, joints);
}

}  // namespace veridyn
