#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "linear_arm.hpp"

namespace veridyn {

/// A member or a wall, linearised about an equilibrium.
struct LinearElement {
  std::optional<int> from = {}, to = {};  ///< arms; nothing: the world
  Eigen::Vector3d u{Eigen::Vector3d::UnitX()};  ///< its line in the world, from `from` to `to`
  double length = 0.0;     ///< [m]; infinite for a wall, whose line does not turn
  double force = 0.0;      ///< [N] tension at the equilibrium
  bool attached = true;    ///< false: released, without force
};

/// All arms and objects about one equilibrium.
struct LinearPoint {
  std::vector<LinearArm> arms;
  std::vector<LinearElement> elements;  ///< members, then walls
};

/// Settings for nonlinear parts of the loop.
struct LoopSettings {
  double reading_gain = 1.0;      ///< factor on every force reading
  int extra_delay = 0;            ///< [cycles] delay of every force reading beyond the scenario's
  double integral = 1.0;          ///< share of a force law's integral gain that acts
  double increment_gain = 0.0;    ///< [m/(N s)] integral gain that replaces a law of increments; 0: none
  /// [N] offset of every wanted force from the equilibrium, for step responses.
  double wanted = 0.0;
};

/// Successive cycles with the same map.
struct CycleRow {
  long first = 0;
  int kind = 0;   ///< kind of the cycles, see ClosedLoop::kinds()
  int count = 1;
};

/// The linearised closed loop of a scenario about a point of rest: one control cycle after the other, in the
/// same order as in Experiment::step(). Between cycles the arms and the object move by the matrix exponential
/// of their equations.
///
/// Sensors that are slower than the loop make it periodic with hyperperiod() cycles, the length of the
/// pattern of sample_pattern().
class ClosedLoop {
 public:
  ClosedLoop(const LinearPoint& point, const Scenario& scenario, const LoopSettings& settings);

  int states() const { return states_; }
  int hyperperiod() const { return hyperperiod_; }
  double period() const { return period_; }

  /// First cycle of the pattern, late enough for every delayed sample to have a nonnegative number.
  long first_cycle() const { return 1000L * hyperperiod_; }
  /// (hyperperiod) the kind of each cycle, beginning with first_cycle(): cycles of one kind have the same
  /// map. Kinds are numbered from 0, in the order of their first occurrence.
  const std::vector<int>& kinds() const { return kinds_; }
  /// The hyperperiod in rows of equal cycles; short rows are given cycle by cycle.
  std::vector<CycleRow> rows() const;

  /// Advances every column of X (states x any) by cycle k; the wanted forces are those of the settings.
  void advance(long k, MatrixXd& X) const;

  /// State transition of a whole hyperperiod, (states x states); wanted forces constant.
  MatrixXd map() const;

  /// (2 joints x joints) Effect of a constant joint torque on positions and velocities in one cycle.
  const MatrixXd& torque_input() const { return input_; }
  int joints() const { return joints_; }

  int correction_row(int element) const { return *element_[element].x_f; }  ///< row of x_f in the state; only of a member
  /// (states): row that gives the true force of an element.
  VectorXd tension_row(int element) const;
  /// (states): row that gives the reading of an element's force law in cycle k, before the cycle; without
  /// filter.
  VectorXd reading_row(int element, long k) const;
  /// True if a new sample arrives in cycle k.
  bool has_new_sample(int element, long k) const;

 private:
  struct Arm {
    int q = 0;         // first row of positions in the state; velocities follow joints_ rows later
    int n = 0;
    int observer = 0;  // first row of the observers' states qh, vh, y, d
    std::optional<int> motor = {};  // first row of the lagging torque
    std::optional<int> queue = {};  // first row of delayed torques
    bool gives_way = false;
    Eigen::Matrix3d mass_inverse{Eigen::Matrix3d::Zero()};
    Eigen::Matrix3d damping{Eigen::Matrix3d::Zero()}, stiffness{Eigen::Matrix3d::Zero()};
  };
  struct Element {
    int line = 0, held = 0;
    std::optional<int> filtered = {}, x_f = {};
    int delay = 0;            // [cycles] delay of the sensor
    double ratio = 1.0;       // samples per cycle
    double share_from = 0.0, share_to = 0.0;
    double value = 0.0;       // [m] x_f at the equilibrium
    ForceLaw law;
    double stiffness = 0.0, damping = 0.0;
    double smoothing = 1.0;
  };

  void assign_states(const LinearPoint& point, const Scenario& scenario);  ///< sets the rows of all parts in the state
  void prepare_arm(int k, const Scenario& scenario);  ///< gains of its position loop or impedance
  void prepare_element(int k, const Scenario& scenario);  ///< its spring, law and shares of the arms
  // Linearises the arms with their attached elements and sets transition_ and input_ by an exact discretisation.
  void prepare_plant();
  MatrixXd line_map(int k) const;  // (3 x joints): end minus start, true
  bool takes_sample(const Element& e, long k) const;
  long cycles_since_sample(const Element& e, long k) const;
  void classify_cycles();
  void update_reading(long k, const Element& e, const MatrixXd& tension, MatrixXd& X, bool& fresh) const;
  MatrixXd law(long k, const Element& e, const MatrixXd& reading, const MatrixXd& rate,
               bool fresh, MatrixXd& X) const;

  LinearPoint point_;
  LoopSettings settings_;
  std::vector<Arm> arm_;
  std::vector<Element> element_;
  MatrixXd transition_, input_;  // maps of positions and velocities of all joints over one cycle
  double period_ = 1e-3;
  double p_ = 0.0;                    // pole of the velocity observer
  double observer_ = 0.0;             // [1/s] bandwidth of the observer of model errors
  double motor_ = 1.0;                // share of a torque's change that acts in a cycle
  int torque_delay_ = 0;
  int joints_ = 0, states_ = 0, hyperperiod_ = 1;
  std::vector<int> kinds_;
};

/// A^n by squaring.
MatrixXd power(MatrixXd A, int n);

/// Largest modulus of the eigenvalues of a square matrix; infinite where it is not finite.
double spectral_radius(const MatrixXd& A);
/// Real and imaginary parts; empty if A is not finite.
std::vector<std::pair<double, double>> eigenvalues(const MatrixXd& A);

/// exp(A t) with its integral's effect on a constant input B: both of one exponential.
void discretise(const MatrixXd& A, const MatrixXd& B, double t, MatrixXd& transition,
                MatrixXd& input);

}  // namespace veridyn
