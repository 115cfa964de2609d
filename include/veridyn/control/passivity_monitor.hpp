#pragma once

namespace veridyn {

/// Monitors the port between arms and object for energy that a control loop generates.
///
/// At an equilibrium with the force h_d, passive arms return no more energy to the object than they received:
/// E(t) = integral of (h - h_d) dl/dt never rises by more than it fell before. A loop that oscillates on its
/// own supplies the energy that the object's damping dissipates, cycle after cycle, and E rises without
/// bound. Valid while h_d and the planned length are constant.
class PassivityMonitor {
 public:
  /// Restarts the integral, as when h_d changes.
  void reset() noexcept { energy_ = highest_rise_ = lowest_ = 0.0; }

  /// @param excess  h - h_d [N]. @param rate  dl/dt beyond what is planned [m/s]. @param dt  [s].
  void update(double excess, double rate, double dt) noexcept {
    energy_ += excess * rate * dt;
    if (energy_ < lowest_) lowest_ = energy_;
    if (energy_ - lowest_ > highest_rise_) highest_rise_ = energy_ - lowest_;
  }

  double energy() const { return energy_; }           ///< E now [J]
  double generated() const { return highest_rise_; }  ///< largest rise of E above an earlier value [J]

 private:
  double energy_ = 0.0, highest_rise_ = 0.0, lowest_ = 0.0;
};

}  // namespace veridyn
