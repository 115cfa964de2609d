#pragma once

#include <memory>
#include <mutex>

#include "veridyn/dynamics/torque_regressor.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn::python {

/// What batch calls keep of a model from one call to the next. Models never change.
struct BatchOf {
  explicit BatchOf(const Model& arm) : regressor(arm), phi(arm.inertial_values()) {}
  TorqueRegressor regressor;
  std::optional<VectorXd> phi;
};

/// A Model of Python's: the model with its batch, made at its first use.
class SharedModel : public Model {
 public:
  explicit SharedModel(Model arm) : Model(std::move(arm)) {}
  SharedModel(const SharedModel& other) : Model(other) {}

  const BatchOf& batch() const {
    std::call_once(once_, [this] { batch_ = std::make_unique<BatchOf>(*this); });
    return *batch_;
  }

 private:
  mutable std::once_flag once_;
  mutable std::unique_ptr<BatchOf> batch_;
};

}  // namespace veridyn::python
