#include "identification/feasible/feasible_fit.hpp"

#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "veridyn/identification/feasible_least_squares.hpp"
#include "veridyn/identification/pseudo_inertia.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/physical_faults.hpp"
#include "veridyn/regressor/standard_parameters.hpp"

namespace veridyn {

std::optional<InertialParameters> manufacturer_values(const Model& arm, const Body& body) {
  if (body.prior) return body.prior;
  return arm.description().values == RobotValues::kPrior ? body.phi : std::nullopt;
}

namespace {

// [kg, kg m^2] lower bound of the eigenvalues of every pseudo-inertia: bodies get a finite size, which
// simulations need.
constexpr double kSmallestEigenvalue = 1e-8;
constexpr double kGap =
    1e-6;  // relative duality gap; far below the effect of a single sample

// With a prior whose terms outweigh the residual, rounding limits the certified gap: 0.1 % of the
// cost is still far below any parameter's deviation.
constexpr double kGapWithPrior = 1e-3;
// A given prior determines what torques leave undetermined. It contradicts the torques if the squared
// residual increases by more than this many times the prior's weight, a tenth by default. The priors of rods
// for psm-3dof and mtm increase it by 0.4 and 2.3 %.
constexpr double kContradicts = 100.0;
// Share of the squared torques (a relative error of 1e-3), below which a prior never contradicts them.
constexpr double kHardlyAnError = 1e-6;

struct Bounds {
  std::vector<VectorXd> rows;
  std::vector<double> limits;
  std::vector<std::string> names;

  void add(VectorXd row, double limit, std::string name) {
    rows.push_back(std::move(row));
    limits.push_back(limit);
    names.push_back(std::move(name));
  }
};

// Signs of effects, and the bounds given in the robot file.
Bounds parameter_bounds(const Model& arm, const std::vector<StandardParameter>& parameters,
                        EffectSigns signs) {
  Bounds bounds;
  const auto count = static_cast<Eigen::Index>(parameters.size());
  const auto unit = [count](Eigen::Index j, double sign) {
    return VectorXd(sign * VectorXd::Unit(count, j));
  };
  for (Eigen::Index j = 0; j < count; ++j) {
    const StandardParameter& p = parameters[j];
    if (p.fixed || !p.effect) continue;
    const double most = arm.description().box.effect_max;
    const bool signed_by_nature = std::isfinite(p.lower) && signs == EffectSigns::kPhysical;
    if (signed_by_nature) bounds.add(unit(j, -1.0), -p.lower, text(p.name, " >= ", p.lower));
    if (most > 0.0) bounds.add(unit(j, 1.0), most, text(p.name, " <= ", most));
    if (most > 0.0 && !signed_by_nature)
      bounds.add(unit(j, -1.0), most, text(p.name, " >= ", -most));
  }
  for (size_t b = 0; b < arm.bodies().size(); ++b) {
    const Frame& frame = arm.frames()[arm.bodies()[b].value];
    if (frame.body->fixed) continue;
    const ParameterBox& own = frame.body->box;
    const ParameterBox& all = arm.description().box;
    const double mass_max = own.mass_max > 0.0 ? own.mass_max : all.mass_max;
    const double reach = own.com_reach > 0.0 ? own.com_reach : all.com_reach;
    const auto first = static_cast<Eigen::Index>(kBodyParameters * b);
    if (mass_max > 0.0)
      bounds.add(unit(first, 1.0), mass_max, text("m_", frame.name, " <= ", mass_max));
    if (reach > 0.0) {
      // No mass lies farther away than twice the reach: trace of the second moments <= (2 reach)^2 m. This
      // also bounds parameters that the data do not determine.
      VectorXd row = -4.0 * reach * reach * unit(first, 1.0);
      for (const int c : {4, 6, 9}) row[first + c] = 0.5;
      bounds.add(row, 0.0, text("mass of ", frame.name, " lies within ", 2.0 * reach, " m"));
    }
    for (Eigen::Index c = 1; c <= 3 && reach > 0.0; ++c) {
      for (const double sign : {1.0, -1.0}) {
        bounds.add(unit(first + c, sign) - reach * unit(first, 1.0), 0.0,
                   text("|com of ", frame.name, "| <= ", reach));
      }
    }
  }
  return bounds;
}

FeasibleProblem feasible_problem(const Model& arm, const SquareRootInformation& total,
                                 const Bounds& bounds) {
  FeasibleProblem problem;
  problem.R = total.R();
  problem.z = total.z();
  problem.rho2 = total.rho2();
  for (size_t b = 0; b < arm.bodies().size(); ++b) {
    if (!arm.frames()[arm.bodies()[b].value].body->fixed)
      problem.body_columns.push_back(static_cast<int>(kBodyParameters * b));
  }
  problem.G.resize(static_cast<Eigen::Index>(bounds.rows.size()), total.size());
  problem.h.resize(problem.G.rows());
  for (Eigen::Index r = 0; r < problem.G.rows(); ++r) {
    problem.G.row(r) = bounds.rows[r].transpose();
    problem.h[r] = bounds.limits[r];
  }
  return problem;
}

// [m] smallest radius of gyration of a prior: a point mass has no inertia, and bodies of a CAD model may have
// inconsistent moments. It is far below the accuracy of a link's inertia.
constexpr double kSmallestRadius = 0.005;

// Prior of each body: the given one, or the manufacturer's values; none for a body without mass.
// Nullopt if no body has a prior.
std::optional<std::vector<InertialParameters>> priors_of(const Model& arm,
                                                         const FeasibleProblem& problem,
                                                         const IdentificationOptions& options) {
  std::vector<InertialParameters> out;
  if (options.prior) {
    require_prior_fits(arm, options);
    const auto phi = options.prior->inertial_values();
    for (const int first : problem.body_columns)
      out.push_back(with_minimum_radius(phi->segment<kBodyParameters>(first), kSmallestRadius));
    return out;
  }
  bool any = false;
  for (const int first : problem.body_columns) {
    const Body& body =
        *arm.frames()[arm.bodies()[first / kBodyParameters].value].body;
    const std::optional<InertialParameters> prior = manufacturer_values(arm, body);
    // A physically impossible body is not used as a prior.
    const bool usable = prior && body_fault("", *prior).empty();
    out.push_back(usable ? with_minimum_radius(*prior, kSmallestRadius) : InertialParameters::Zero());
    any = any || out.back()[0] > 0.0;
  }
  if (!any) return std::nullopt;
  return out;
}

enum class PriorUse { kPull, kLeaveOut };

// The smallest squared residual of physically possible bodies without a prior.
double least_feasible(const FeasibleProblem& problem, FeasibleOptions solver) {
  solver.entropic_prior = {};
  const FeasibleResult result = solve_feasible_least_squares(problem, solver);
  return result.feasible ? result.objective : std::numeric_limits<double>::infinity();
}

void solve_with(PriorUse use, const Model& arm, const SquareRootInformation& total,
                const IdentificationOptions& options, Identification& id) {
  const auto parameters = standard_parameters(arm);
  const Bounds bounds = parameter_bounds(arm, parameters, options.signs);
  const FeasibleProblem problem = feasible_problem(arm, total, bounds);
  FeasibleOptions solver;
  solver.condition = options.condition;
  solver.gap_tolerance = kGap;
  solver.eigenvalue_margin = kSmallestEigenvalue;
  std::optional<std::vector<InertialParameters>> prior = priors_of(arm, problem, options);
  if (prior && use == PriorUse::kPull) {
    solver.entropic_prior.phi = std::move(*prior);
    const double bodies = std::max<double>(1.0, static_cast<double>(problem.body_columns.size()));
    solver.entropic_prior.weight = options.prior_weight * id.unconstrained_objective / bodies;
  }
  const FeasibleResult result = solve_feasible_least_squares(problem, solver);
  id.parameters = result.x;
  id.objective = result.objective;
  id.duality_gap = result.duality_gap;
  id.certified = result.certificate == Certificate::kRigorous;
  for (const ActiveBody& active : result.active_bodies) {
    const int body = problem.body_columns[active.body] / kBodyParameters;
    id.active_constraints.push_back("pseudo-inertia of " + arm.frames()[arm.bodies()[body].value].name +
                                    " is singular");
  }
  for (const ActiveRow& active : result.active_rows)
    id.active_constraints.push_back(bounds.names[active.row]);
  const bool pulled = prior && use == PriorUse::kPull;
  const double most = 1.0 + kContradicts * options.prior_weight;
  const bool doubtful = pulled && options.prior && result.feasible && result.objective > most * id.unconstrained_objective &&
                        result.objective > kHardlyAnError * total.rhs_norm2();
  const double least = doubtful ? least_feasible(problem, solver) : std::numeric_limits<double>::infinity();
  const bool contradicts = result.objective > most * least;
  const bool enough = result.status == FeasibleStatus::kOptimal || (pulled && result.feasible && result.duality_gap <= kGapWithPrior);
  // A result with a larger residual than zero torques is useless.
  const bool worse_than_none = result.objective > total.rhs_norm2();
  if (enough && !contradicts && !worse_than_none) return;
  if (pulled && !options.prior) {
    id.active_constraints.clear();
    solve_with(PriorUse::kLeaveOut, arm, total, options, id);
    id.remarks.push_back("The bodies of the maker's file pulled at nothing: with them feasible least "
                         "squares does not converge. What torques do not tell is not near them.");
    return;
  }
  id.status = IdentificationStatus::kNotConverged;
  if (worse_than_none) {
    id.reason = text("the best physically possible arm leaves ", 100.0 * std::sqrt(result.objective / total.rhs_norm2()),
                     " % of the torques: they are too small for the lightest one, expected N m and N");
    return;
  }
  const std::string report = result.report();
  id.reason = contradicts ? text("feasible least squares: the prior raises the squared residual from ",
                                 least, " to ", result.objective)
                          : report.substr(0, report.find(','));
  if (!options.prior && result.status == FeasibleStatus::kNotConverged) {
    id.reason += text(", ", result.duality_gap, " of the objective from the least one; ");
    id.reason += id.certified ? "a motion that moves every joint more, or --prior MODEL, tells what these torques leave open"
                              : "box: {mass_max: KG, com_reach: M, effect_max: N} in the robot file bounds what "
                                "these torques leave open, and --prior MODEL fills it";
  }
  if (options.prior)
    id.reason += "; the prior '" + options.prior->name() + "' does not let it: leave it out, or give "
                 "its bodies the mass and size of this arm's";
}

}  // namespace

void require_prior_fits(const Model& arm, const IdentificationOptions& options) {
  if (!options.prior) return;
  const auto phi = options.prior->inertial_values();
  require(phi.has_value(), "prior: found bodies without values in '", options.prior->name(),
          "', expected a model with values, as from CAD or identify.");
  require(phi->size() == kBodyParameters * static_cast<int>(arm.bodies().size()),
          "the prior '", options.prior->name(), "' does not give values to the same bodies as '",
          arm.name(), "'.");
}

void solve_feasible(const Model& arm, const SquareRootInformation& total,
                    const IdentificationOptions& options, Identification& id) {
  solve_with(PriorUse::kPull, arm, total, options, id);
}

}  // namespace veridyn
