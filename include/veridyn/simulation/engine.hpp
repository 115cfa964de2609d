#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "veridyn/math/types.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// Result of a step.
enum class StepStatus {
  kOk,
  kNotFinite,    ///< a torque, a position or a velocity has become NaN or infinite
  kNotPositive,  ///< the mass matrix is not positive definite at this configuration
  kTooStiff,     ///< the tolerance requires more substeps than allowed
  kRanAway       ///< a controlled joint is far outside its range
};

/// A phrase that follows "the run stopped at 1.2 s: joint insertion": "has a position that is not
/// finite".
const char* describe(StepStatus status);

/// A forward simulation driven by torques: veridyn's own Plant, or another engine with the same
/// interface. Vectors have n entries: [rad], [m] where the joint is prismatic.
class Engine {
 public:
  virtual ~Engine() = default;

  virtual int joints() const = 0;

  /// Sets the state and clears the memories: friction with memory starts unloaded, time at zero.
  virtual void set_state(const VectorRef& q, const VectorRef& dq) = 0;

  /// Advances by dt [s] under constant joint torques. If the status is not kOk, the state is that
  /// of the last valid instant, and failed_joint() names the joint.
  virtual StepStatus step(const VectorRef& tau, double dt) noexcept = 0;

  /// Acceleration at the present state under these torques. step() starts with it, so that both
  /// together cost no more than step().
  virtual StepStatus accelerate(const VectorRef& tau, VectorXd& ddq) noexcept = 0;

  virtual double time() const = 0;  ///< [s] simulated time since set_state()
  virtual const VectorXd& q() const = 0;
  virtual const VectorXd& dq() const = 0;
  virtual std::optional<JointIndex> failed_joint() const = 0;

  /// Effects of the model that this engine does not support, in words.
  virtual const std::vector<std::string>& left_out() const = 0;
};

/// Makes an engine: "veridyn" is a Plant, "mujoco" is MuJoCo with the same model, in builds that include it.
/// @throws InvalidInput  the engine does not exist or refuses the model.
std::unique_ptr<Engine> make_engine(const std::string& name, const Model& arm);

/// Names for make_engine().
std::vector<std::string> engine_names();

}  // namespace veridyn
