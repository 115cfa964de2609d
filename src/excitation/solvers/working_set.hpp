#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "excitation/solvers/nonlinear_program.hpp"

namespace veridyn {

/// The rows of a program that can become active, for general solvers.
class WorkingSet final : public NonlinearProgram {
 public:
  /// @param near  distance from a bound, below which a row belongs to the initial set.
  WorkingSet(NonlinearProgram& whole, const VectorXd& start, double near)
      : whole_(whole), chosen_(static_cast<size_t>(whole.lower().size()), false) {
    add(whole_.constraints(start), near);
  }

  /// Adds rows whose values c are closer to a bound than `near`, or exceed it by -near.
  /// @returns the number of new rows.
  int add(const VectorXd& c, double near) {
    int added = 0;
    for (Eigen::Index r = 0; r < c.size(); ++r) {
      const bool close = c[r] > whole_.upper()[r] - near || c[r] < whole_.lower()[r] + near;
      if (!close || chosen_[r]) continue;
      chosen_[r] = true;
      ++added;
    }
    if (added > 0 || rows_.empty()) rebuild_rows();
    return added;
  }

  int variables() const override { return whole_.variables(); }
  double objective(const VectorXd& x) override { return whole_.objective(x); }
  VectorXd gradient(const VectorXd& x) override { return whole_.gradient(x); }
  const VectorXd& lower() const override { return lower_; }
  const VectorXd& upper() const override { return upper_; }
  VectorXd constraints(const VectorXd& x) override { return selected_entries(whole_.constraints(x), rows_); }
  const std::vector<std::pair<int, int>>& pattern() const override { return pattern_; }
  VectorXd jacobian(const VectorXd& x) override { return selected_entries(whole_.jacobian(x), entries_); }

 private:
  static VectorXd selected_entries(const VectorXd& all, const std::vector<Eigen::Index>& places) {
    VectorXd out(places.size());
    for (size_t k = 0; k < places.size(); ++k) out[static_cast<Eigen::Index>(k)] = all[places[k]];
    return out;
  }

  void rebuild_rows() {
    rows_.clear();
    entries_.clear();
    pattern_.clear();
    std::vector<int> place(chosen_.size(), -1);
    for (size_t r = 0; r < chosen_.size(); ++r) {
      if (!chosen_[r]) continue;
      place[r] = static_cast<int>(rows_.size());
      rows_.push_back(static_cast<Eigen::Index>(r));
    }
    lower_ = selected_entries(whole_.lower(), rows_);
    upper_ = selected_entries(whole_.upper(), rows_);
    const auto& all = whole_.pattern();
    for (size_t e = 0; e < all.size(); ++e) {
      const int row = place[all[e].first];
      if (row < 0) continue;
      pattern_.emplace_back(row, all[e].second);
      entries_.push_back(static_cast<Eigen::Index>(e));
    }
  }

  NonlinearProgram& whole_;
  std::vector<bool> chosen_;
  std::vector<Eigen::Index> rows_, entries_;
  VectorXd lower_, upper_;
  std::vector<std::pair<int, int>> pattern_;
};

/// Solves with the rows that are close to a bound at the start; violated rows are added, and the search
/// continues from that solution.
inline SolverResult with_working_set(const NonlinearSolver& solver, NonlinearProgram& whole,
                                     const VectorXd& start, const SolverOptions& options) {
  constexpr double kNear = 0.15;  // distance from a bound, as a share of a limit's scale
  constexpr double kBeside = 0.02;
  constexpr double kHeld = 1e-6;
  constexpr int kRounds = 8;
  WorkingSet part(whole, start, kNear);
  SolverResult all{start};
  SolverOptions rest = options;
  for (int round = 0; round < kRounds; ++round) {
    const SolverResult one = solver(part, all.x, rest);
    all.x = one.x;
    all.converged = one.converged;
    all.iterations += one.iterations;
    if (options.stop && options.stop()) break;
    (void)whole.objective(all.x);  // stores the best motion within all limits
    const VectorXd c = whole.constraints(all.x);
    if (part.add(c, -kHeld) == 0) break;
    part.add(c, kBeside);
    rest.iterations = std::max(options.iterations - all.iterations, options.iterations / 4);
  }
  return all;
}

}  // namespace veridyn
