#include "veridyn/cooperation/scenario_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "empty_run.hpp"
#include "experiment.hpp"
#include "phase_figures.hpp"
#include "veridyn/files/output_file.hpp"

namespace veridyn {
namespace {

Eigen::Index row_count(const Scenario& scenario, double seconds) {
  return static_cast<Eigen::Index>(std::lround(seconds * scenario.control.rate));
}

}  // namespace

ScenarioRun empty_run(const Scenario& scenario, const std::string& engine, Eigen::Index rows) {
  ScenarioRun run;
  run.name = scenario.name;
  run.engine = engine;
  run.time = VectorXd::Zero(rows);
  for (const ScenarioArm& arm : scenario.arms) {
    run.arms.push_back(arm.name);
    const MatrixXd joints = MatrixXd::Zero(rows, arm.start.size());
    const MatrixXd points = MatrixXd::Zero(rows, 3);
    run.arm.push_back({joints, joints, joints, points, points, points});
  }
  for (const ScenarioMember& member : scenario.members) {
    run.members.push_back(member.name);
    run.member.push_back({run.time, run.time, run.time, run.time, run.time, run.time, {}});
  }
  for (const ScenarioWall& wall : scenario.walls) {
    run.members.push_back(wall.name);
    run.member.push_back({run.time, run.time, run.time, run.time, run.time, run.time,
                          MatrixXd::Zero(wall.sensor_axes == 3 ? rows : 0, 3)});
  }
  for (const ScenarioBody& body : scenario.bodies) {
    run.bodies.push_back(body.name);
    run.body.push_back({MatrixXd::Zero(rows, 3), MatrixXd::Zero(rows, 3)});
  }
  return run;
}

void keep_first_rows(ScenarioRun& run, Eigen::Index rows) {
  run.time.conservativeResize(rows);
  for (ArmTrace& t : run.arm) {
    for (MatrixXd* m : {&t.q, &t.dq, &t.tau, &t.tip, &t.motion, &t.target})
      m->conservativeResize(rows, m->cols());
  }
  for (MemberTrace& t : run.member) {
    for (VectorXd* v : {&t.wanted, &t.force, &t.measured, &t.x_f, &t.rate, &t.tracked})
      v->conservativeResize(rows);
    if (t.axes.rows() > 0) t.axes.conservativeResize(rows, 3);
  }
  for (BodyTrace& t : run.body) {
    t.position.conservativeResize(rows, 3);
    t.wanted.conservativeResize(rows, 3);
  }
}

ScenarioRun run_scenario(const Scenario& scenario, const std::string& engine,
                         const std::function<void(double)>& progress) {
  const auto begun = std::chrono::steady_clock::now();
  Experiment experiment(scenario, engine);
  Eigen::Index rows = 0;
  for (const ScenarioPhase& phase : scenario.phases) rows += row_count(scenario, phase.duration);
  ScenarioRun run = empty_run(scenario, engine, rows);
  run.left_out = experiment.left_out();
  run.asked_largest_force = scenario.asked_largest_force;
  Eigen::Index k = 0;
  for (const ScenarioPhase& phase : scenario.phases) {
    experiment.begin_phase(phase);
    const Eigen::Index first = k;
    const Eigen::Index end = k + row_count(scenario, phase.duration);
    for (; k < end; ++k) {
      if (!experiment.step()) {
        run.status = experiment.status();
        run.stopped_at = experiment.world().time();
        break;
      }
      experiment.record(run, k);
      const CooperativeState state = experiment.controller().state();
      if (state != CooperativeState::kTracking && run.state == CooperativeState::kTracking) {
        run.state = state;
        run.held_at = run.time[k];
      }
      if (progress && k % 500 == 0) progress(static_cast<double>(k) / static_cast<double>(rows));
    }
    if (k > first) run.phases.push_back(phase_figures(scenario, phase, run, first, k));
    if (!run.complete()) break;
  }
  keep_first_rows(run, k);
  for (const MemberTrace& member : run.member) {
    if (member.force.size() > 0)
      run.largest_force = std::max(run.largest_force, member.force.cwiseAbs().maxCoeff());
  }
  run.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  return run;
}

bool ScenarioRun::met() const {
  if (!complete()) return false;
  if (asked_largest_force > 0.0 && !(largest_force <= asked_largest_force)) return false;
  return std::all_of(phases.begin(), phases.end(), [](const PhaseFigures& p) { return p.met(); });
}

std::string ScenarioRun::report() const {
  const double end = time.size() > 0 ? time[time.size() - 1] : 0.0;
  std::string out = fmt::format("{}: {} arm{}, {:.4g} s ", name, arms.size(),
                                arms.size() == 1 ? "" : "s", end);
  out += engine == "boards" ? "on boards.\n"
                            : fmt::format("simulated in {:.2g} s by {}.\n", seconds, engine);
  out +=
      fmt::format("{:<22} {:<12} {:>8} {:>9} {:>9} {:>9} {:>9} {:>9} {:>10}\n"
                  "{:<35} {:>8} {:>9} {:>9} {:>9} {:>9} {:>9} {:>10}\n",
                  "phase", "member", "wanted", "largest", "steady", "mean", "overshoot", "swing",
                  "made", "", "N", "N", "N", "N", "N", "N", "mJ");
  for (const PhaseFigures& p : phases) {
    for (const MemberFigures& m : p.members) {
      out += fmt::format(
          "{:<22} {:<12} {:>8.3g} {:>9.3f} {:>9.3f} {:>9.3f} {:>9.3f} {:>9.3f} {:>10}\n",
          p.phase, m.member, m.wanted, m.largest_error, m.steady_error, m.mean_error, m.overshoot,
          m.oscillation,
          std::isnan(m.generated) ? "-" : fmt::format("{:.3g}", 1e3 * m.generated));
    }
  }
  if (!phases.empty())
    out +=
        "largest, steady, mean: error of the force, at any time and in the phase's last fifth; swing: "
        "from its least to its largest there; made: energy that the loop gave the object at rest.\n";
  for (const PhaseFigures& p : phases) {
    if (p.cut_short) {
      out += fmt::format("{}: cut short, {:.4g} s of {:.4g} s: NOT met\n", p.phase, p.to - p.from,
                         p.duration);
      continue;
    }
    const bool asked = p.asked_force_error > 0.0 || p.asked_steady_error > 0.0;
    if (asked && std::isnan(p.largest_force_error())) {
      out += fmt::format("{}: no force was tracked throughout: NOT met\n", p.phase);
      continue;
    }
    if (p.asked_force_error > 0.0)
      out += fmt::format("{}: force within {:.3g} N, asked {:.3g} N: {}\n", p.phase,
                         p.largest_force_error(), p.asked_force_error,
                         p.largest_force_error() <= p.asked_force_error ? "met" : "NOT met");
    if (p.asked_steady_error > 0.0)
      out += fmt::format("{}: at rest within {:.3g} N, asked {:.3g} N: {}\n", p.phase,
                         p.largest_steady_error(), p.asked_steady_error,
                         p.largest_steady_error() <= p.asked_steady_error ? "met" : "NOT met");
    if (p.body_error > 0.0)
      out += fmt::format("{}: held bodies at most {:.3g} mm off their way\n", p.phase,
                         1e3 * p.body_error);
    if (p.asked_position_error > 0.0)
      out += fmt::format("{}: places within {:.3g} mm, asked {:.3g} mm: {}\n", p.phase,
                         1e3 * std::max(p.position_error, p.body_error),
                         1e3 * p.asked_position_error,
                         std::max(p.position_error, p.body_error) <= p.asked_position_error
                             ? "met"
                             : "NOT met");
    out += fmt::format("{}: leader at most {:.3g} mm off its way, {:.3g} mm at the end\n", p.phase,
                       1e3 * p.position_error, 1e3 * p.final_position_error);
  }
  out += fmt::format("Largest force: {:.3g} N", largest_force);
  if (asked_largest_force > 0.0)
    out += fmt::format(", asked {:.3g} N: {}", asked_largest_force,
                       largest_force <= asked_largest_force ? "met" : "NOT met");
  out += ".\n";
  if (state != CooperativeState::kTracking)
    out += fmt::format("At {:.4g} s the controller {}.\n", held_at, describe(state));
  if (!complete())
    out += fmt::format("Stopped at {:.4g} s: an arm {}.\n", stopped_at, describe(status));
  return out;
}

std::string scenario_row_names(const ScenarioRun& run) {
  std::string head = "t";
  for (const char* signal : {"q", "dq", "tau"}) {
    int number = 0;
    for (const ArmTrace& arm : run.arm) {
      for (Eigen::Index i = 0; i < arm.q.cols(); ++i)
        head += fmt::format(",{}{}", signal, ++number);
    }
  }
  for (const std::string& arm : run.arms) {
    for (const char* what : {"tip", "motion", "target"})
      head += fmt::format(",{0}_{1}_x,{0}_{1}_y,{0}_{1}_z", what, arm);
  }
  for (const std::string& m : run.members)
    head += fmt::format(",wanted_{0},force_{0},measured_{0},x_f_{0}", m);
  for (std::size_t m = 0; m < run.member.size(); ++m) {
    if (run.member[m].axes.rows() > 0)
      head += fmt::format(",measured_{0}_x,measured_{0}_y,measured_{0}_z", run.members[m]);
  }
  return head;
}

std::string scenario_row(const ScenarioRun& run, Eigen::Index k) {
  std::string row = fmt::format("{:.9g}", run.time[k]);
  const auto add = [&](const auto& values) {
    for (Eigen::Index i = 0; i < values.size(); ++i) row += fmt::format(",{:.10g}", values[i]);
  };
  for (const ArmTrace& arm : run.arm) add(arm.q.row(k));
  for (const ArmTrace& arm : run.arm) add(arm.dq.row(k));
  for (const ArmTrace& arm : run.arm) add(arm.tau.row(k));
  for (const ArmTrace& arm : run.arm) {
    add(arm.tip.row(k));
    add(arm.motion.row(k));
    add(arm.target.row(k));
  }
  for (const MemberTrace& m : run.member)
    row += fmt::format(",{:.8g},{:.8g},{:.8g},{:.8g}", m.wanted[k], m.force[k], m.measured[k],
                       m.x_f[k]);
  for (const MemberTrace& m : run.member) {
    if (m.axes.rows() > 0) add(m.axes.row(k));
  }
  return row;
}

void write_scenario_rows(const ScenarioRun& run, const std::string& path) {
  OutputFile file(path);
  file.stream() << scenario_row_names(run) << '\n';
  for (Eigen::Index k = 0; k < run.time.size(); ++k) file.stream() << scenario_row(run, k) << '\n';
  file.commit();
}

}  // namespace veridyn
