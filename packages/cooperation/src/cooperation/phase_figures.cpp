#include "phase_figures.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "veridyn/control/passivity_monitor.hpp"

namespace veridyn {
namespace {

// [s] Time since the begin of the phase at which all its commands have ended.
double commands_end(const ScenarioPhase& phase) {
  double end = 0.0;
  for (const ScenarioCommand& c : phase.commands) end = std::max(end, c.over);
  return end;
}

// [J] Energy that the force error of the rows [first, end) generates; NaN if the rate is unknown.
double generated(const MemberTrace& m, Eigen::Index first, Eigen::Index end, double dt) {
  if (!m.rate.segment(first, end - first).allFinite())
    return std::numeric_limits<double>::quiet_NaN();
  PassivityMonitor monitor;
  for (Eigen::Index k = first; k < end; ++k)
    monitor.update(m.force[k] - m.wanted[k], m.rate[k], dt);
  return monitor.generated();
}

// Figures of the rows [first, end); those after `settled` are without commands.
MemberFigures member_figures(const MemberTrace& m, Eigen::Index first, Eigen::Index end,
                         Eigen::Index settled, double dt) {
  MemberFigures f;
  const Eigen::Index rows = end - first;
  const Eigen::Index last = std::max<Eigen::Index>(1, rows / 5);
  const VectorXd error = m.force.segment(first, rows) - m.wanted.segment(first, rows);
  f.wanted = m.wanted[end - 1];
  f.tracked = m.tracked.segment(first, rows).minCoeff() > 0.5;
  f.largest_error = error.cwiseAbs().maxCoeff();
  f.rms_error = std::sqrt(error.squaredNorm() / static_cast<double>(rows));
  f.steady_error = error.tail(last).cwiseAbs().maxCoeff();
  f.mean_error = error.tail(last).mean();
  const VectorXd force = m.force.segment(end - last, last);
  f.oscillation = force.maxCoeff() - force.minCoeff();
  for (Eigen::Index k = end - last + 1; k < end; ++k)
    f.corrections += m.x_f[k] != m.x_f[k - 1] ? 1 : 0;
  const double change = f.wanted - m.wanted[first];
  if (change != 0.0) {
    const double beyond =
        (std::copysign(1.0, change) * (m.force.segment(first, rows).array() - f.wanted)).maxCoeff();
    f.overshoot = std::max(0.0, beyond);
  }
  f.generated = generated(m, settled, end, dt);
  return f;
}

// Largest figure of the members tracked throughout; NaN if there are none: no bound is satisfied then.
double worst_of_tracked(const std::vector<MemberFigures>& members, double MemberFigures::*figure) {
  double worst = std::numeric_limits<double>::quiet_NaN();
  for (const MemberFigures& m : members) {
    if (m.tracked) worst = std::fmax(worst, m.*figure);
  }
  return worst;
}

}  // namespace

PhaseFigures phase_figures(const Scenario& scenario, const ScenarioPhase& phase,
                           const ScenarioRun& run, Eigen::Index first, Eigen::Index end) {
  PhaseFigures out;
  out.phase = phase.name;
  out.from = run.time[first] - 1.0 / scenario.control.rate;
  out.to = run.time[end - 1];
  out.duration = phase.duration;
  out.cut_short = end - first < std::lround(phase.duration * scenario.control.rate);
  out.asked_force_error = phase.asked_force_error;
  out.asked_steady_error = phase.asked_steady_error;
  const auto settled = std::min(
      end,
      first + static_cast<Eigen::Index>(std::lround(commands_end(phase) * scenario.control.rate)));
  for (size_t k = 0; k < run.member.size(); ++k) {
    out.members.push_back(
        member_figures(run.member[k], first, end, settled, 1.0 / scenario.control.rate));
    out.members.back().member = run.members[k];
  }
  const ArmTrace& master = run.arm[scenario.master];
  const MatrixXd off = (master.tip - master.motion).middleRows(first, end - first);
  out.position_error = off.rowwise().norm().maxCoeff();
  out.final_position_error = off.bottomRows<1>().norm();
  out.asked_position_error = phase.asked_position_error;
  for (const BodyTrace& body : run.body) {
    const MatrixXd away = (body.position - body.wanted).middleRows(first, end - first);
    out.body_error = std::max(out.body_error, away.rowwise().norm().maxCoeff());
  }
  return out;
}

double PhaseFigures::largest_force_error() const {
  return worst_of_tracked(members, &MemberFigures::largest_error);
}

double PhaseFigures::largest_steady_error() const {
  return worst_of_tracked(members, &MemberFigures::steady_error);
}

bool PhaseFigures::met() const {
  if (cut_short) return false;
  return (asked_force_error <= 0.0 || largest_force_error() <= asked_force_error) &&
         (asked_steady_error <= 0.0 || largest_steady_error() <= asked_steady_error) &&
         (asked_position_error <= 0.0 ||
          std::max(position_error, body_error) <= asked_position_error);
}

}  // namespace veridyn
