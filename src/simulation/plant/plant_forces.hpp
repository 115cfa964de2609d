#pragma once

#include <optional>
#include <string>
#include <vector>

#include "veridyn/effects/effect.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// True for first-order effects along a given motion (an elastic transmission), which would be
/// unstable as a force in a forward simulation.
bool describes_measured_motion(const EffectTerm& term);

/// The interval of forces that dry friction can have at rest.
struct Interval {
  double lower, upper;
};

/// The effects of a model, sorted by their treatment in a forward simulation.
///
///   affine   inertia ddq + damping dq + stiffness q + constant: folded into four arrays
///   dry      an interval at rest; one entry for each direction in which friction acts
///   smooth   all others: any function of time, position and velocity, with memory or without
///
/// Nothing allocates after the constructor.
class PlantForces {
 public:
  /// @throws InvalidInput  an effect has no values.
  explicit PlantForces(const Model& arm);

  const MatrixXd& inertia() const { return inertia_; }  ///< (n x n) of affine effects
  const MatrixXd& damping() const { return damping_; }  ///< (n x n) of affine effects
  const std::vector<std::string>& left_out() const { return left_out_; }

  /// Starts the memories at these positions and velocities, with time zero.
  void reset(const double* q, const double* dq);

  /// Advances the memories to this state.
  void commit(double time, const double* q, const double* dq);

  /// Adds affine (without inertia) and smooth forces to `sum` (n). Loads are those of set_loads().
  void add_smooth(double time, const double* q, const double* dq, double* sum) const;

  /// Number of terms whose force depends on the load of the rigid bodies.
  int loads() const { return static_cast<int>(loads_.size()); }
  /// Sets the loads from the rigid torques (n). @returns the largest change of a load.
  double set_loads(const double* rigid_torques);

  /// Number of directions of dry friction; entry k acts along axis(k).
  int dry() const { return static_cast<int>(dry_.size()); }
  const double* axis(int k) const { return dry_[k].direction.data(); }  ///< direction of dry axis k, (n)
  /// [rad/s], [m/s] along axis(k) of dry friction.
  double velocity(int k, const double* dq) const {
    return along(dry_[k].line, dq);
  }

  /// The sliding force of axis k in `direction` (+1, -1) at this speed.
  double sliding(int k, double time, const double* q, double velocity, int direction) const;
  Interval at_rest(int k, double time, const double* q) const;  ///< [N m], [N] friction of dry axis k at rest

  /// Power [W] that friction without memory dissipates at joint i alone at this speed, the smaller
  /// one of both directions; negative if it drives.
  double friction_power(const VectorXd& q, int i, double speed) const;

  /// Number of directions with memory of the path.
  int memories() const { return static_cast<int>(memories_.size()); }
  /// [rad/s], [m/s] along direction k of the memories.
  double memory_velocity(int k, const double* dq) const {
    return along(memories_[k], dq);
  }

 private:
  struct Entry {
    int coordinate;
    double coefficient;
  };
  using Line = std::vector<Entry>;  // nonzero entries of an axis

  struct Term {
    const AxisEffect* effect;
    EffectTraits traits;
    int parameters;
    ShapeValues shape;
    EffectColumns values;
    Line axis, from;
    double offset = 0.0, from_offset = 0.0;
    std::optional<int> load = {};  // index among the loads; nullopt: none
    EffectState state{};
  };
  struct Affine {
    double constant, s, ds, dds;
  };
  struct Dry {
    VectorXd direction;
    Line line;
    std::vector<Term> terms;
    double constant = 0.0;  // Coulomb friction, which does not depend on position or speed
  };
  struct Load {
    VectorXd axis;  // load = axis . rigid torques
    double value = 0.0;
  };

  static Line line_of(const Axis& axis);  ///< nonzero coefficients
  static double along(const Line& line, const double* x) {
    double sum = 0.0;
    for (const Entry& e : line) sum += e.coefficient * x[e.coordinate];
    return sum;
  }
  static double force(const Term& term, const AxisSample& x, EffectState& state);  ///< of a term at x; advances its memory
  static Affine affine(const Term& term);  ///< coefficients of an affine force
  static bool is_zero(const Term& term);  ///< all parameters are zero
  AxisSample sample(const Term& term, double time, const double* q, const double* dq) const;  ///< without dds; load as of set_loads()
  Term bound(const Model& arm, const EffectTerm& of);  ///< throws InvalidInput if the effect has no values
  void add_affine(const EffectTerm& of, const Affine& force);  ///< to inertia_, damping_ and the constant part
  void add_dry(const EffectTerm& of, const Term& term);  ///< to the dry axis with the same direction

  int n_;
  MatrixXd inertia_, damping_, stiffness_;
  VectorXd constant_;
  bool has_damping_ = false, has_stiffness_ = false;
  std::vector<Term> smooth_;
  std::vector<Dry> dry_;
  std::vector<Load> loads_;
  std::vector<Line> memories_;
  std::vector<std::string> left_out_;
};

}  // namespace veridyn
