#pragma once

#include <memory>
#include <string>
#include <vector>

#include "veridyn/math/types.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// How a step ended.
enum class StepStatus {
  kOk,
  kNotFinite,    ///< a torque, a position or a velocity has become NaN or infinite
  kNotPositive,  ///< the mass matrix has no inverse where the arm stands
  kTooStiff,     ///< the error asks for more substeps than allowed
  kRanAway       ///< a controlled joint is far beyond all that it could be asked for
};

/// A phrase that stands after "the run stopped at 1.2 s: joint insertion": "has a position that is
/// not finite".
const char* describe(StepStatus status);

/// Something that moves under torques: veridyn's own Plant, or another engine behind the same
/// words. Vectors have n entries: [rad], [m] where the joint is prismatic, and so on.
class Engine {
 public:
  virtual ~Engine() = default;

  virtual int joints() const = 0;

  /// Puts the arm there and forgets the past: friction with a memory starts fresh, time restarts.
  virtual void set_state(const VectorRef& q, const VectorRef& dq) = 0;

  /// Moves on by dt [s] under constant joint torques. After anything but kOk the state is that of
  /// the last instant that was sound, and failed_joint() names the joint.
  virtual StepStatus step(const VectorRef& tau, double dt) noexcept = 0;

  /// The acceleration where the arm stands, under these torques. step() begins with it, so that
  /// both together cost no more than step().
  virtual StepStatus accelerate(const VectorRef& tau, VectorXd& ddq) noexcept = 0;

  virtual double time() const = 0;  ///< [s] since set_state()
  virtual const VectorXd& q() const = 0;
  virtual const VectorXd& dq() const = 0;
  virtual int failed_joint() const = 0;  ///< from 0; -1: none in particular

  /// Effects of the model that this engine does not have, in words.
  virtual const std::vector<std::string>& left_out() const = 0;
};

/// "veridyn": a Plant; "mujoco": the same model file in MuJoCo, where it was built with it.
/// @throws InvalidInput  no such engine, or what it says against the model.
std::unique_ptr<Engine> make_engine(const std::string& name, const Model& arm);

/// The names that make_engine() knows.
std::vector<std::string> engine_names();

}  // namespace veridyn
