#include "veridyn/identification/identification.hpp"

#include <chrono>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "fold_errors.hpp"
#include "identified_base.hpp"
#include "many_recordings.hpp"
#include "shortfall.hpp"
#include "math/numbers.hpp"
#include "recordings/named_recordings.hpp"
#include "validation.hpp"
#include "identification/base_solution.hpp"
#include "identification/instrumental.hpp"
#include "identification/velocity_choice.hpp"
#include "math/dense.hpp"
#include "math/output_file.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/model/model_file.hpp"
#include "veridyn/model/model_origin.hpp"
#include "veridyn/model/physical_faults.hpp"

namespace veridyn {
namespace {

// [kg, kg m^2] lower bound of every pseudo-inertia's eigenvalues: bodies get a finite size, so that
// simulations are well-posed.
constexpr double kSmallestEigenvalue = 1e-8;
constexpr double kGap =
    1e-6;  // relative duality gap; far below the effect of a single sample

// With a prior whose terms outweigh the residual, rounding limits the certified gap: 0.1 % of the
// cost is still far below any parameter's deviation.
constexpr double kGapWithPrior = 1e-3;

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// Base parameters of the arm outside the row space of the data.
std::vector<std::string> undetermined_parameters(const BaseParameters& arm_base,
                                                 const BaseParameters& data_base,
                                                 const VectorXd& scale) {
  // Rows of K span the determined combinations; both in columns with the same scaling.
  const MatrixXd determined = (data_base.K * scale.asDiagonal()).transpose();
  const MatrixXd wanted = (arm_base.K * scale.asDiagonal()).transpose();
  std::vector<std::string> out;
  const MatrixXd Q = orthonormal_basis(determined);
  for (int j = 0; j < arm_base.size(); ++j) {
    const VectorXd row = wanted.col(j);
    const VectorXd rest = row - Q * (Q.transpose() * row);
    if (rest.norm() > 1e-5 * row.norm())
      out.push_back(arm_base.expressions[j]);
  }
  return out;
}

// True, with a status and a reason, if the recordings do not determine the arm's base parameters.
bool rank_deficient(const Model& arm, const BaseParameters& arm_base,
                    const SquareRootInformation& total, Identification& id) {
  const auto parameters = standard_parameters(arm);
  const BaseParameters data_base = base_parameters(total, preferred_columns(parameters));
  id.rank_gap = data_base.rank_gap;
  if (data_base.size() >= arm_base.size() && id.still_joints.empty()) return false;
  const SquareRootInformation structure = identifiable_factor(arm, 3, id.still_joints);
  const BaseParameters& determined =
      id.still_joints.empty() ? data_base
                              : base_parameters(structure, preferred_columns(parameters));
  id.undetermined =
      undetermined_parameters(arm_base, determined, identifiable_factor(arm, 3).column_norms());
  id.status = IdentificationStatus::kRankDeficient;
  std::string open;
  int told = 0;
  for (const std::string& name : id.undetermined) {
    // Sums of many parameters fill lines without helping; id.undetermined has them all.
    if (told == 8 || name.find(' ') != std::string::npos) continue;
    open += (told++ == 0 ? "" : "; ") + name;
  }
  const int rest = static_cast<int>(id.undetermined.size()) - told;
  if (rest > 0) open += text(told > 0 ? " and " : "", rest, told > 0 ? " more" : " sums of parameters");
  id.reason = shortfall(arm_base, data_base, id.still_joints);
  // If the gap concerns nearly all of them, listing their names does not help.
  if (!id.still_joints.empty() || static_cast<int>(id.undetermined.size()) <= arm_base.size() / 2) {
    id.reason += "; undetermined: " + open;
  } else {
    id.reason += text("; the ", arm_base.size() - data_base.size(),
                      " that are missing are spread over nearly all: a longer or richer motion is needed");
  }
  return true;
}

// Values of the manufacturer's file for a body.
std::optional<InertialParameters> maker_of(const Model& arm, const Body& body) {
  if (body.prior) return body.prior;
  return arm.description().values == RobotValues::kPrior ? body.phi : std::nullopt;
}

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

// Signs of effects, and the boxes of the robot file.
Bounds parameter_bounds(const Model& arm, const std::vector<StandardParameter>& parameters,
                        EffectSigns signs) {
  Bounds bounds;
  const auto count = static_cast<Eigen::Index>(parameters.size());
  const auto unit = [count](Eigen::Index j, double sign) {
    return VectorXd(sign * VectorXd::Unit(count, j));
  };
  for (Eigen::Index j = 0; j < count; ++j) {
    const StandardParameter& p = parameters[j];
    if (p.fixed || p.effect < 0) continue;
    const double most = arm.description().box.effect_max;
    const bool signed_by_nature = std::isfinite(p.lower) && signs == EffectSigns::kPhysical;
    if (signed_by_nature) bounds.add(unit(j, -1.0), -p.lower, text(p.name, " >= ", p.lower));
    if (most > 0.0) bounds.add(unit(j, 1.0), most, text(p.name, " <= ", most));
    if (most > 0.0 && !signed_by_nature)
      bounds.add(unit(j, -1.0), most, text(p.name, " >= ", -most));
  }
  for (size_t b = 0; b < arm.bodies().size(); ++b) {
    const Frame& frame = arm.frames()[arm.bodies()[b]];
    if (frame.body->fixed) continue;
    const ParameterBox& own = frame.body->box;
    const ParameterBox& all = arm.description().box;
    const double mass_max = own.mass_max > 0.0 ? own.mass_max : all.mass_max;
    const double reach = own.com_reach > 0.0 ? own.com_reach : all.com_reach;
    const auto first = static_cast<Eigen::Index>(kBodyParameters * b);
    if (mass_max > 0.0)
      bounds.add(unit(first, 1.0), mass_max, text("m_", frame.name, " <= ", mass_max));
    if (reach > 0.0) {
      // No mass is farther away than twice the reach: trace of the second moments <= (2 reach)^2 m.
      // This also bounds parameters that the data do not determine.
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
    if (!arm.frames()[arm.bodies()[b]].body->fixed)
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

// [m] Smallest distance of a prior's mass from its centre: a point mass has no inertia, and bodies
// of a drawing may have inconsistent moments. Far below the accuracy of a link's inertia.
constexpr double kSmallestRadius = 0.005;

// Prior of each body: the given one, or the manufacturer's values; none for a body without mass.
// Nullopt if no body has a prior.
std::optional<std::vector<InertialParameters>> priors_of(const Model& arm,
                                                         const FeasibleProblem& problem,
                                                         const IdentificationOptions& options) {
  std::vector<InertialParameters> out;
  if (options.prior) {
    const auto phi = options.prior->inertial_values();
    require(phi.has_value(), "prior: found bodies without values in '", options.prior->name(),
            "', expected a model with values, as from CAD or identify.");
    require(phi->size() == kBodyParameters * static_cast<int>(arm.bodies().size()),
            "the prior '", options.prior->name(), "' does not give values to the same bodies as '",
            arm.name(), "'.");
    for (const int first : problem.body_columns)
      out.push_back(with_size(phi->segment<kBodyParameters>(first), kSmallestRadius));
    return out;
  }
  bool any = false;
  for (const int first : problem.body_columns) {
    const Body& body =
        *arm.frames()[arm.bodies()[first / kBodyParameters]].body;
    const std::optional<InertialParameters> prior = maker_of(arm, body);
    out.push_back(prior ? with_size(*prior, kSmallestRadius) : InertialParameters::Zero());
    any = any || out.back()[0] > 0.0;
  }
  if (!any) return std::nullopt;
  return out;
}

enum class PriorUse { kPull, kLeaveOut };

void solve_feasible(const Model& arm, const SquareRootInformation& total,
                    const IdentificationOptions& options, PriorUse use, Identification& id) {
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
    id.active_constraints.push_back("pseudo-inertia of " + arm.frames()[arm.bodies()[body]].name +
                                    " is singular");
  }
  for (const ActiveRow& active : result.active_rows)
    id.active_constraints.push_back(bounds.names[active.row]);
  const bool pulled = prior && use == PriorUse::kPull;
  if (result.status == FeasibleStatus::kOptimal) return;
  if (pulled && result.feasible && result.duality_gap <= kGapWithPrior) return;
  if (prior && use == PriorUse::kPull && !options.prior) {
    id.active_constraints.clear();
    solve_feasible(arm, total, options, PriorUse::kLeaveOut, id);
    id.remarks.push_back("The bodies of the maker's file pulled at nothing: with them feasible least "
                         "squares does not converge. What torques do not tell is not near them.");
    return;
  }
  id.status = IdentificationStatus::kNotConverged;
  const std::string report = result.report();
  id.reason = report.substr(0, report.find(','));
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

// The least-norm standard parameters (columns scaled) with these base parameters.
VectorXd shortest_parameters(const BaseParameters& base, const VectorXd& beta,
                             const VectorXd& norms) {
  VectorXd scale = norms;
  for (Eigen::Index j = 0; j < scale.size(); ++j) scale[j] = norms[j] > 0.0 ? 1.0 / norms[j] : 0.0;
  const MatrixXd A = base.K * scale.asDiagonal();
  return scale.asDiagonal() * least_norm(A, beta);
}

bool all_bodies_possible(const Model& arm, const VectorXd& parameters) {
  for (size_t b = 0; b < arm.bodies().size(); ++b) {
    const InertialParameters phi =
        parameters.segment<kBodyParameters>(static_cast<Eigen::Index>(kBodyParameters * b));
    if (smallest_eigenvalue(pseudo_inertia(phi)) <= 0.0) return false;
  }
  return true;
}

void keep_facts(const std::vector<StandardParameter>& parameters, VectorXd& values) {
  for (size_t j = 0; j < parameters.size(); ++j) {
    if (parameters[j].fixed) values[static_cast<Eigen::Index>(j)] = parameters[j].value;
  }
}

void describe_base(const Model& arm, const BaseParameters& base, const VectorXd& beta,
                   const VectorXd& std, Identification& id) {
  const auto parameters = standard_parameters(arm);
  id.parameter_deviations = VectorXd::Constant(parameters.size(), kNaN);
  for (int j = 0; j < base.size(); ++j) {
    const auto own = static_cast<size_t>(base.independent[j]);
    id.base.push_back({base.names[j], base.expressions[j],
                       parameters[own].unit, beta[j], std[j]});
    if (base.classes[own] == Identifiability::kAlone)
      id.parameter_deviations[static_cast<Eigen::Index>(own)] = std[j];
  }
}

void take_solution(const Model& arm, const std::vector<CompressedRecording>& recordings, const BaseParameters& base,
                   const BaseSolution& solution, const VectorXd& beta, Identification& id);

// Computes all parameters from the factors.
void solve(const Model& arm, const std::vector<CompressedRecording>& recordings,
           const IdentificationOptions& options, Identification& id) {
  const auto parameters = standard_parameters(arm);
  const std::vector<std::string> names = parameter_names(parameters);
  const BaseParameters base = identifiable_base_parameters(arm);
  const SquareRootInformation total = weighted_total(recordings, range_weights(recordings), names);
  if (rank_deficient(arm, base, total, id)) return;
  fit_base(arm, recordings, base, options, id);
}

}  // namespace

void fit_base(const Model& arm, const std::vector<CompressedRecording>& recordings,
              const BaseParameters& base, const IdentificationOptions& options, Identification& id) {
  const auto parameters = standard_parameters(arm);
  const std::vector<std::string> names = parameter_names(parameters);
  VectorXd weights = range_weights(recordings);
  SquareRootInformation total = weighted_total(recordings, weights, names);
  const VectorXd norms = total.column_norms();
  if (options.method == Method::kOls) {
    weights = VectorXd::Ones(weights.size());
  } else if (options.weights == JointWeights::kResidual) {
    weights = residual_weights(recordings, weights, base, names);
  }
  const BaseSolution solution = solve_base(recordings, weights, base, names);
  id.status = IdentificationStatus::kDone;
  id.condition_number = solution.condition_number;
  id.condition_number_scaled = solution.condition_number_scaled;
  id.effective_samples = solution.effective_samples;
  id.unconstrained_objective = solution.residual2;
  id.objective = solution.residual2;
  VectorXd beta = solution.beta;
  if (options.method == Method::kFeasible) {
    total = weighted_total(recordings, weights, names);
    solve_feasible(arm, total, options, PriorUse::kPull, id);
    if (id.status == IdentificationStatus::kNotConverged && options.prior) return;
    beta = base.K * id.parameters;
  } else {
    id.parameters = shortest_parameters(base, solution.beta, norms);
  }
  take_solution(arm, recordings, base, solution, beta, id);
}

namespace {

// Model and tables of a solution whose parameters are set.
void take_solution(const Model& arm, const std::vector<CompressedRecording>& recordings, const BaseParameters& base,
                   const BaseSolution& solution, const VectorXd& beta, Identification& id) {
  const auto parameters = standard_parameters(arm);
  keep_facts(parameters, id.parameters);
  id.feasible = all_bodies_possible(arm, id.parameters);
  describe_base(arm, base, beta, solution.std, id);
  ModelDescription description =
      with_values(arm, id.parameters, id.parameter_deviations).description();
  for (size_t k = 0; k < description.frames.size(); ++k) {
    if (description.frames[k].body)
      description.frames[k].body->prior = maker_of(arm, *arm.frames()[k].body);
  }
  description.values = RobotValues::kFacts;
  description.identified = identified_base(base, parameters, solution, beta, recordings);
  id.model = Model(std::move(description));
}

// Replaces the least-squares solution by that of the motion without noise.
void refit_with_instruments(const Model& arm, const std::vector<CompressedRecording>& recordings,
                            const IdentificationOptions& options, Identification& id) {
  if (options.method != Method::kIv && options.method != Method::kDidim) return;
  const std::vector<std::string> names = parameter_names(standard_parameters(arm));
  const BaseParameters base = identifiable_base_parameters(arm);
  VectorXd weights = range_weights(recordings);
  const VectorXd norms = weighted_total(recordings, weights, names).column_norms();
  if (options.weights == JointWeights::kResidual) weights = residual_weights(recordings, weights, base, names);
  IdentificationOptions how = options;
  how.preprocessing = id.preprocessing;
  InstrumentalFit fit = fit_with_instruments(arm, recordings, base, weights, how);
  id.endogeneity = std::move(fit.tests);
  id.objective = fit.objective;
  id.parameters = shortest_parameters(base, fit.solution.beta, norms);
  id.base.clear();
  take_solution(arm, recordings, base, fit.solution, fit.solution.beta, id);
}

using BlockList = std::vector<const std::vector<SquareRootInformation>*>;

VectorXd squared_errors(const BlockList& blocks, const std::map<std::string, double>& values) {
  VectorXd out = VectorXd::Zero(blocks.front()->size());
  for (const auto* block : blocks) {
    for (size_t i = 0; i < block->size(); ++i) {
      const SquareRootInformation& joint = (*block)[i];
      VectorXd x(joint.size());
      for (Eigen::Index c = 0; c < x.size(); ++c)
        x[c] = values.at(joint.columns()[c]);
      out[static_cast<Eigen::Index>(i)] += joint.residual2(x);
    }
  }
  return out;
}

std::map<std::string, double> by_name(const std::vector<std::string>& names, const VectorXd& values) {
  std::map<std::string, double> out;
  for (size_t p = 0; p < names.size(); ++p) out[names[p]] = values[static_cast<Eigen::Index>(p)];
  return out;
}

// Of the rows that were fitted.
VectorXd rms_residuals(const Model& arm, const Identification& id) {
  const auto values = by_name(parameter_names(standard_parameters(arm)), id.parameters);
  VectorXd squares = VectorXd::Zero(arm.joints());
  VectorXd rows = squares;
  for (const CompressedRecording& r : id.factors) {
    for (const auto& block : r.blocks) {
      squares += squared_errors({&block}, values);
      for (size_t i = 0; i < block.size(); ++i) rows[static_cast<Eigen::Index>(i)] += block[i].rows();
    }
  }
  return squares.cwiseQuotient(rows.cwiseMax(1.0)).cwiseSqrt();
}

// Factor that inflates residuals with a longer correlation time to equivalent ones with one
// independent sample in kUsualIndependence.
double as_if_independent(const Model& arm, const Identification& id) {
  constexpr double kUsualIndependence = 0.1;  // [s], equal to TorqueNoise::seconds
  double seconds = 0.0;
  for (const CompressedRecording& r : id.factors) seconds += r.facts.duration;
  if (!(id.effective_samples > 0.0)) return 1.0;
  return std::sqrt(std::max(1.0, seconds * arm.joints() / id.effective_samples / kUsualIndependence));
}

// Relative to a column's norm: directions with less information (asymmetric Coulomb friction beside an
// offset differs at rest alone) stay at the values of all parts, which they would else leave by far.
constexpr double kHardlyDetermined = 1e-3;
constexpr size_t kManyRecordings = 4;  // enough to hold out one as a whole
constexpr size_t kPartsOfOne = 8;
constexpr size_t kPartsOfFew = 2;

// BlockList of the recordings that are held out together.
std::vector<BlockList> parts_of(const std::vector<CompressedRecording>& recordings) {
  const size_t each = recordings.size() >= kManyRecordings ? 1
                      : recordings.size() == 1             ? kPartsOfOne
                                                           : kPartsOfFew;
  std::vector<BlockList> out;
  for (const CompressedRecording& r : recordings) {
    const size_t count = r.blocks.size();
    for (size_t part = 0; part < each; ++part) {
      BlockList blocks;
      for (size_t b = part * count / each; b < (part + 1) * count / each; ++b)
        blocks.push_back(&r.blocks[b]);
      if (!blocks.empty()) out.push_back(std::move(blocks));
    }
  }
  return out;
}

// Sum of squares of every joint's torque, as its series has it, over so many rows.
VectorXd squared_torques(const Identification& id, const VectorXd& rows) {
  VectorXd out = rows;
  for (Eigen::Index j = 0; j < rows.size(); ++j) {
    double sum = 0.0;
    size_t count = 0;
    for (const RecordingError& r : id.train) {
      if (r.series.measured.empty()) continue;
      const std::vector<double>& torque = r.series.measured[j];
      for (const double t : torque) sum += t * t;
      count += torque.size();
    }
    if (count > 0) out[j] *= sum / static_cast<double>(count);
  }
  return out;
}

}  // namespace

FoldErrors fold_errors(const Identification& fitted, const IdentificationOptions& options,
                       FoldValues values) {
  const Model& arm = *fitted.model;
  const std::vector<std::string> names = parameter_names(standard_parameters(arm));
  const std::vector<BlockList> parts = parts_of(fitted.factors);
  const BaseParameters base =
      values == FoldValues::kFitted ? identifiable_base_parameters(arm) : BaseParameters();
  VectorXd weights = range_weights(fitted.factors);
  if (values == FoldValues::kFitted && options.weights == JointWeights::kResidual)
    weights = residual_weights(fitted.factors, weights, base, names);
  FoldErrors out;
  out.error2.resize(static_cast<Eigen::Index>(parts.size()), arm.joints());
  VectorXd rows = VectorXd::Zero(arm.joints());
  std::vector<SquareRootInformation> factors;
  for (const BlockList& part : parts) {
    factors.emplace_back(names);
    for (const auto* block : part) {
      for (size_t i = 0; i < block->size(); ++i) {
        factors.back().merge((*block)[i], weights[static_cast<Eigen::Index>(i)]);
        rows[static_cast<Eigen::Index>(i)] += (*block)[i].rows();
      }
    }
  }
  SquareRootInformation total(names);
  for (const SquareRootInformation& factor : factors) total.merge(factor);
  const MatrixXd anchor = (kHardlyDetermined * total.column_norms()).asDiagonal();
  for (size_t part = 0; part < parts.size(); ++part) {
    Identification without;
    without.parameters = VectorXd::Zero(names.size());
    if (values == FoldValues::kFitted) {
      SquareRootInformation rest(names);
      for (size_t other = 0; other < parts.size(); ++other) {
        if (other != part || parts.size() == 1) rest.merge(factors[other]);
      }
      rest.absorb(anchor, anchor * fitted.parameters);
      without.unconstrained_objective = fitted.unconstrained_objective;
      solve_feasible(arm, rest, options, PriorUse::kPull, without);
    }
    out.error2.row(part) =
        squared_errors(parts[part], by_name(names, without.parameters)).transpose();
  }
  out.torque2 = squared_torques(fitted, rows);
  return out;
}

void keep_training_error(Identification& id) {
  ModelDescription description = id.model->description();
  description.identified->error = id.train_error.relative;
  description.identified->noise = rms_residuals(*id.model, id) * as_if_independent(*id.model, id);
  id.model = Model(std::move(description));
}

AskedArm::AskedArm(const Model& file, JointFriction friction)
    : file_(file), friction_(friction), used_(with_friction(file, friction)) {}

bool AskedArm::leave_rotors_out() {
  Model lean = with_friction_alone(file_, friction_);
  const bool fewer = lean.effects().size() < used_.effects().size();
  used_ = std::move(lean);
  return fewer;
}

std::string AskedArm::remark() const { return friction_remark(file_, used_); }

namespace {

// Removes columns of effects that the arm does not have, as in factors of an arm with more effects.
void forget_other_columns(const Model& arm, std::vector<CompressedRecording>& recordings) {
  const std::vector<std::string> names = parameter_names(standard_parameters(arm));
  const std::set<std::string> known(names.begin(), names.end());
  for (CompressedRecording& r : recordings) {
    for (auto& block : r.blocks) {
      for (SquareRootInformation& joint : block) {
        std::vector<std::string> kept;
        for (const std::string& name : joint.columns())
          if (known.count(name) != 0) kept.push_back(name);
        if (static_cast<Eigen::Index>(kept.size()) < joint.size()) joint = joint.restricted(kept);
      }
    }
  }
}

bool without_torque(const std::vector<CompressedRecording>& recordings) {
  return std::all_of(recordings.begin(), recordings.end(), [](const CompressedRecording& r) {
    return std::all_of(r.joints.begin(), r.joints.end(),
                       [](const auto& joint) { return joint.minimum == 0.0 && joint.maximum == 0.0; });
  });
}

bool fit_arm(const Model& arm, const std::vector<CompressedRecording>& recordings,
             const IdentificationOptions& options, Identification& id) {
  for (const CompressedRecording& r : recordings) {
    id.rows += r.rows;
    if (r.rows == 0.0) {
      id.reason = r.source + ": no usable samples are left after gaps, edges and row limits";
      return false;
    }
  }
  id.still_joints = still_joints(arm, recordings);
  if (id.still_joints.empty() && without_torque(recordings)) {
    id.reason = recordings.front().source + ": the torques of all joints are zero throughout";
    return false;
  }
  id.noise_floor = mean_noise_floor(recordings, arm.joints());
  const auto begin = std::chrono::steady_clock::now();
  solve(arm, recordings, options, id);
  if (id.status == IdentificationStatus::kRankDeficient && !recordings.empty()) {
    const std::string more =
        recordings.size() > 1 ? text(" and ", recordings.size() - 1, " more") : std::string();
    id.reason = recordings.front().source + more + ": " + id.reason;
  }
  id.seconds.solve = seconds_since(begin);
  return id.model.has_value();
}

}  // namespace

bool fit_factors(AskedArm& arm, std::vector<CompressedRecording>& recordings,
                 const IdentificationOptions& options, Identification& id) {
  const Identification question = id;
  forget_other_columns(arm.used(), recordings);
  bool done = fit_arm(arm.used(), recordings, options, id);
  if (!done && id.status == IdentificationStatus::kRankDeficient && arm.leave_rotors_out()) {
    id = question;
    forget_other_columns(arm.used(), recordings);
    done = fit_arm(arm.used(), recordings, options, id);
  }
  if (std::string remark = arm.remark(); !remark.empty())
    id.remarks.insert(id.remarks.begin(), std::move(remark));
  for (const std::string& fault : physical_faults(arm.used()))
    id.remarks.push_back("The robot file has what no arm has: " + fault + ".");
  return done;
}

namespace {

// Identifies the drive gains first, then the arm from the recordings without a load.
Identification identify_with_known_masses(const Model& arm, const std::vector<std::string>& train,
                                          const std::vector<std::string>& test,
                                          const IdentificationOptions& options) {
  if (options.progress) options.progress("finding drive gains", 0.0);
  const DriveGains gains =
      find_drive_gains(with_friction_alone(arm, options.friction), train, options.known_masses, options.preprocessing, options.threads);
  std::string open = gains.problem;
  for (size_t j = 0; j < gains.joints.size() && open.empty(); ++j) {
    const DriveGain& gain = gains.joints[j];
    if (gain.identifiable || arm.coordinates()[j].drive_gain != 0.0) continue;
    open = "the drive gain of " + gain.coordinate + " is not identifiable and robot '" + arm.name() +
           "' has none: " + gain.reason;
  }
  Identification id;
  if (open.empty()) {
    IdentificationOptions plain = options;
    plain.known_masses.clear();
    plain.choose_velocities = false;  // decided for all recordings together, with the gains
    id = identify(with_drive_gains(arm, gains), gains.unloaded, test, plain);
  } else {
    id = described(arm, options);
    id.status = IdentificationStatus::kNoDriveGains;
    id.reason = open;
  }
  id.drive_gains = gains;
  return id;
}

Identification identify_named(const Model& arm, const std::vector<std::string>& train,
                              const std::vector<std::string>& test,
                              const IdentificationOptions& options) {
  require(!train.empty(), "identify: there is no recording to train on.");
  if (!options.known_masses.empty()) return identify_with_known_masses(arm, train, test, options);
  return identify_compressed(arm, {}, train, test, options);
}

}  // namespace

Identification identify_compressed(const Model& file, std::vector<CompressedRecording> trained,
                                   const std::vector<std::string>& train,
                                   const std::vector<std::string>& test,
                                   const IdentificationOptions& options) {
  Identification id = described(file, options);
  const auto say = [&options](const std::string& what, double share) {
    if (options.progress) options.progress(what, share);
  };
  say("compressing", 0.0);
  const auto begin = std::chrono::steady_clock::now();
  AskedArm arm(file, options.friction);
  for (CompressedRecording& r : compress_many(arm.used(), train, id.preprocessing, options.threads))
    trained.push_back(std::move(r));
  for (CompressedRecording& r : trained)
    merge_blocks(r, blocks_of_each(static_cast<int>(trained.size())));
  id.seconds.compress = seconds_since(begin);
  say("solving", 0.4);
  if (!fit_factors(arm, trained, options, id)) return id;
  refit_with_instruments(arm.used(), trained, options, id);
  say("validating", 0.6);
  id.factors = std::move(trained);
  validate(arm.used(), test, options, id);
  keep_training_error(id);
  say("done", 1.0);
  return id;
}

Identification identify(const Model& arm, const Recordings& train, const Recordings& test,
                        const IdentificationOptions& options) {
  NamedRecordings<IdentificationOptions> named(train, test, options);
  keep_recordings(named.how, KeptRecordings::kFewPasses);
  Identification id = identify_named(arm, named.train, named.test, named.how);
  id = with_chosen_velocities(arm, std::move(id), named.train, named.how,
                              [&](const IdentificationOptions& how) {
                                return identify_named(arm, named.train, named.test, how);
                              });
  forget_recordings(id);
  return id;
}

Identification identify(const Model& arm, const Recording& recording,
                        const IdentificationOptions& options) {
  return identify(arm, Recordings(recording), {}, options);
}

void save(const Identification& id, const std::string& path, const std::string& command,
          const std::string& robot) {
  require(id.model.has_value(), path, ": there is no model to save: ", id.reason, ".");
  std::vector<std::string> inputs = {robot};
  for (const std::vector<RecordingError>* role : {&id.train, &id.test}) {
    for (const RecordingError& recording : *role) inputs.push_back(recording.source);
  }
  write_file(path, with_origin(to_yaml(*id.model), origin_now(command, inputs)));
}

}  // namespace veridyn
