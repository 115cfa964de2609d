#include "veridyn/identification/identification.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "identification/differing_recordings.hpp"
#include "identification/identification_numbers.hpp"
#include "identified_base.hpp"
#include "identification/recording_passes.hpp"
#include "shortfall.hpp"
#include "math/numbers.hpp"
#include "recordings/named_recordings.hpp"
#include "identification/base_solution.hpp"
#include "identification/feasible/feasible_fit.hpp"
#include "identification/instrumental.hpp"
#include "identification/silent_joints.hpp"
#include "identification/velocity_choice.hpp"
#include "math/dense.hpp"
#include "files/output_file.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/files/model_origin.hpp"
#include "veridyn/files/physical_faults.hpp"

namespace veridyn {
namespace {

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// Base parameters of the arm that are not in the row space of the data.
std::vector<std::string> undetermined_parameters(const BaseParameters& arm_base,
                                                 const BaseParameters& data_base,
                                                 const VectorXd& scale) {
  // Rows of K span the determined combinations; both K are for columns of the same scaling.
  const MatrixXd determined = (data_base.K * scale.asDiagonal()).transpose();
  const MatrixXd wanted = (arm_base.K * scale.asDiagonal()).transpose();
  std::vector<std::string> out;
  const MatrixXd Q = orthonormal_basis(determined);
  for (int j = 0; j < arm_base.size(); ++j) {
    const VectorXd row = wanted.col(j);
    const VectorXd rest = row - Q * (Q.transpose() * row);
    if (rest.norm() > identifying::kOutsideSpan * row.norm())
      out.push_back(arm_base.expressions[j]);
  }
  return out;
}

// True, with a status and a reason set, if the recordings do not determine the arm's base parameters.
bool rank_deficient(const Model& arm, const BaseParameters& arm_base,
                    const SquareRootInformation& total, Identification& id) {
  const auto parameters = standard_parameters(arm);
  const BaseParameters data_base = base_parameters(total, preferred_columns(parameters));
  id.rank_gap = data_base.rank_gap;
  const bool enough = data_base.size() >= arm_base.size();
  if (enough && id.still_joints.empty()) return false;
  const SquareRootInformation structure = identifiable_factor(arm, 3, id.still_joints);
  const BaseParameters& determined =
      id.still_joints.empty() ? data_base
                              : base_parameters(structure, preferred_columns(parameters));
  id.undetermined =
      undetermined_parameters(arm_base, determined, identifiable_factor(arm, 3).column_norms());
  if (enough && id.undetermined.empty()) return false;  // the parameters of the joint at rest are fixed
  id.status = IdentificationStatus::kRankDeficient;
  std::string open;
  int told = 0;
  for (const std::string& name : id.undetermined) {
    // Sums of many parameters are skipped in this sentence: they make it long without information, and
    // id.undetermined contains them all.
    if (told == 8 || name.find(' ') != std::string::npos) continue;
    open += (told++ == 0 ? "" : "; ") + name;
  }
  const int rest = static_cast<int>(id.undetermined.size()) - told;
  if (rest > 0) open += text(told > 0 ? " and " : "", rest, told > 0 ? " more" : rest > 1 ? " sums of parameters" : " sum of parameters");
  id.reason = shortfall(arm_base, data_base, id.still_joints);
  // If nearly all parameters are undetermined, a list of them does not help.
  if (!id.still_joints.empty() && static_cast<int>(id.still_joints.size()) == arm.joints()) {
    id.reason += "; gravity, offsets and forces of position of an arm at rest are identified with --at-rest";
  } else if (!open.empty() && (!id.still_joints.empty() || static_cast<int>(id.undetermined.size()) <= arm_base.size() / 2)) {
    id.reason += "; undetermined: " + open;
  } else if (!open.empty()) {
    id.reason += text("; the ", arm_base.size() - data_base.size(),
                      " that are missing are spread over nearly all: a longer or richer motion is needed");
  }
  return true;
}

// Standard parameters with these base parameters and least norm (columns scaled).
VectorXd shortest_parameters(const BaseParameters& base, const VectorXd& beta,
                             const VectorXd& norms) {
  VectorXd scale = norms;
  for (Eigen::Index j = 0; j < scale.size(); ++j) scale[j] = norms[j] > 0.0 ? 1.0 / norms[j] : 0.0;
  const MatrixXd A = base.K * scale.asDiagonal();
  return scale.asDiagonal() * least_norm(A, beta);
}

bool are_all_bodies_possible(const Model& arm, const VectorXd& parameters) {
  for (size_t b = 0; b < arm.bodies().size(); ++b) {
    const InertialParameters phi =
        parameters.segment<kBodyParameters>(static_cast<Eigen::Index>(kBodyParameters * b));
    if (smallest_eigenvalue(pseudo_inertia(phi)) <= 0.0) return false;
  }
  return true;
}

void restore_fixed_parameters(const std::vector<StandardParameter>& parameters, VectorXd& values) {
  for (size_t j = 0; j < parameters.size(); ++j) {
    if (parameters[j].fixed) values[static_cast<Eigen::Index>(j)] = parameters[j].value;
  }
}

// Sets id.base, and in id.parameter_deviations the deviations of parameters that are identifiable alone (else NaN).
void set_base_values(const Model& arm, const BaseParameters& base, const VectorXd& beta,
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

void set_solution(const Model& arm, const std::vector<CompressedRecording>& recordings, const BaseParameters& base,
                   const BaseSolution& solution, const VectorXd& beta, Identification& id);

// Computes all parameters from the factors.
void solve(const Model& arm, const std::vector<CompressedRecording>& recordings,
           const IdentificationOptions& options, Identification& id) {
  const auto parameters = standard_parameters(arm);
  const std::vector<std::string> names = parameter_names(parameters);
  const BaseParameters base = identifiable_base_parameters(arm);
  if (base.size() == 0) {
    id.reason = "robot '" + arm.name() + "' has no parameter to identify: its file declares all as facts";
    return;
  }
  std::vector<SquareRootInformation> joints = joint_totals(recordings);
  const SquareRootInformation total = weighted_total(joints, range_weights(recordings), names);
  if (rank_deficient(arm, base, total, id)) return;
  fit_base(arm, recordings, std::move(joints), base, options, id);
}

}  // namespace

void fit_base(const Model& arm, const std::vector<CompressedRecording>& recordings,
              std::vector<SquareRootInformation> joints, const BaseParameters& base,
              const IdentificationOptions& options, Identification& id) {
  const auto parameters = standard_parameters(arm);
  const std::vector<std::string> names = parameter_names(parameters);
  VectorXd weights = range_weights(recordings);
  SquareRootInformation total = weighted_total(joints, weights, names);
  const VectorXd norms = total.column_norms();
  if (options.method == Method::kOls) {
    weights = VectorXd::Ones(weights.size());
  } else if (options.weights == JointWeights::kResidual) {
    weights = residual_weights(joints, weights, base, names);
  }
  if (options.method == Method::kFeasible) total = weighted_total(joints, weights, names);
  joints.clear();  // large arms need this memory
  joints.shrink_to_fit();
  const BaseSolution solution = solve_base(recordings, weights, base, names);
  id.status = IdentificationStatus::kDone;
  id.condition_number = solution.condition_number;
  id.condition_number_scaled = solution.condition_number_scaled;
  id.effective_samples = solution.effective_samples;
  id.unconstrained_objective = solution.residual2;
  id.objective = solution.residual2;
  VectorXd beta = solution.beta;
  if (options.method == Method::kFeasible) {
    solve_feasible(arm, total, options, id);
    if (id.status == IdentificationStatus::kNotConverged && (options.prior || id.objective > total.rhs_norm2())) return;
    beta = base.K * id.parameters;
  } else {
    id.parameters = shortest_parameters(base, solution.beta, norms);
  }
  set_solution(arm, recordings, base, solution, beta, id);
}

namespace {

// Sets the model and the tables of a solution whose parameters are known.
void set_solution(const Model& arm, const std::vector<CompressedRecording>& recordings, const BaseParameters& base,
                   const BaseSolution& solution, const VectorXd& beta, Identification& id) {
  const auto parameters = standard_parameters(arm);
  restore_fixed_parameters(parameters, id.parameters);
  id.feasible = are_all_bodies_possible(arm, id.parameters);
  set_base_values(arm, base, beta, solution.std, id);
  ModelDescription description =
      with_values(arm, id.parameters, id.parameter_deviations).description();
  for (size_t k = 0; k < description.frames.size(); ++k) {
    if (description.frames[k].body)
      description.frames[k].body->prior = manufacturer_values(arm, *arm.frames()[k].body);
  }
  description.values = RobotValues::kFacts;
  description.identified = identified_base(base, parameters, solution, beta, recordings);
  id.model = Model(std::move(description));
}

// Replaces the least-squares solution by the estimate from the noise-free motion.
void refit_with_instruments(const Model& arm, const std::vector<CompressedRecording>& recordings,
                            const IdentificationOptions& options, Identification& id) {
  if (options.method != Method::kIv && options.method != Method::kDidim) return;
  const std::vector<std::string> names = parameter_names(standard_parameters(arm));
  const BaseParameters base = identifiable_base_parameters(arm);
  VectorXd weights = range_weights(recordings);
  const std::vector<SquareRootInformation> joints = joint_totals(recordings);
  const VectorXd norms = weighted_total(joints, weights, names).column_norms();
  if (options.weights == JointWeights::kResidual) weights = residual_weights(joints, weights, base, names);
  IdentificationOptions how = options;
  how.preprocessing = id.preprocessing;
  InstrumentalFit fit = fit_with_instruments(arm, recordings, base, weights, how);
  id.endogeneity = std::move(fit.tests);
  id.objective = fit.objective;
  id.parameters = shortest_parameters(base, fit.solution.beta, norms);
  id.base.clear();
  set_solution(arm, recordings, base, fit.solution, fit.solution.beta, id);
}

}  // namespace

AskedArm::AskedArm(const Model& file, JointFriction friction)
    : file_(file), friction_(friction), used_(with_friction(file, friction)) {}

bool AskedArm::drop_rotors() {
  Model lean = with_friction_alone(file_, friction_);
  const bool fewer = lean.effects().size() < used_.effects().size();
  used_ = std::move(lean);
  return fewer;
}

std::string AskedArm::remark() const { return friction_remark(file_, used_); }

namespace {

// Removes the columns of effects that the arm does not have: factors may come from an arm with more effects.
void drop_other_columns(const Model& arm, std::vector<CompressedRecording>& recordings) {
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

// False, with id.reason, if a recording has no usable samples or the arm cannot be fitted.
bool fit_arm(const Model& arm, const std::vector<CompressedRecording>& recordings,
             const IdentificationOptions& options, Identification& id) {
  for (const CompressedRecording& r : recordings) {
    id.rows += r.rows;
    if (r.rows == 0.0) {
      id.reason = no_sample_left(r, options.preprocessing);
      return false;
    }
  }
  id.still_joints = still_joints(arm, recordings);
  if (id.still_joints.empty() && std::all_of(recordings.begin(), recordings.end(),
                                            [](const CompressedRecording& r) { return without_torque(r); })) {
    id.reason = recordings.front().source + ": the torques of all joints are zero throughout: not recorded? Record the efforts, or name their columns by --map tau=SOURCE";
    return false;
  }
  id.noise_floor = mean_noise_floor(recordings, arm.joints());
  const auto begin = std::chrono::steady_clock::now();
  solve(arm, recordings, options, id);
  if (id.status == IdentificationStatus::kRankDeficient) {
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
  drop_other_columns(arm.effective_arm(), recordings);
  bool done = fit_arm(arm.effective_arm(), recordings, options, id);
  if (!done && id.status == IdentificationStatus::kRankDeficient && arm.drop_rotors()) {
    id = question;
    drop_other_columns(arm.effective_arm(), recordings);
    done = fit_arm(arm.effective_arm(), recordings, options, id);
  }
  if (std::string remark = arm.remark(); !remark.empty())
    id.remarks.insert(id.remarks.begin(), std::move(remark));
  for (const std::string& fault : physical_faults(arm.effective_arm()))
    id.remarks.push_back("The robot file has what no arm has, and its values are no prior: " + fault + ".");
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
    plain.choose_velocities = false;  // chosen for all recordings together, when the gains are known
    id = identify(with_drive_gains(arm, gains), gains.unloaded, test, plain);
  } else {
    id = empty_identification(arm, options);
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
  if (are_poses(options.preprocessing, train)) return identify_at_rest(arm, train, test, options);
  if (!options.known_masses.empty()) return identify_with_known_masses(arm, train, test, options);
  return identify_compressed(arm, {}, train, test, options);
}

}  // namespace

namespace {

// True if the torques are smaller than those of the lightest possible body, so that the model's error exceeds
// the torque itself.
bool torques_are_negligible(Identification& id) {
  double largest = 0.0;
  for (const CompressedRecording& r : id.factors) {
    for (const TorqueFacts& joint : r.joints) largest = std::max({largest, joint.maximum, -joint.minimum});
  }
  if (largest > identifying::kHardlyTorque || !(id.train_error.relative.array() > 1.0).any()) return false;
  id.model.reset();
  id.status = IdentificationStatus::kNotConverged;
  id.reason = text("the largest torque is ", largest, ", and the lightest possible arm leaves up to ", 100.0 * id.train_error.relative.maxCoeff(),
                   " % of a joint's: expected torques in N m and N (--units tau=...)");
  return true;
}

}  // namespace

Identification identify_compressed(const Model& file, std::vector<CompressedRecording> trained,
                                   const std::vector<std::string>& train,
                                   const std::vector<std::string>& test,
                                   const IdentificationOptions& options, const RecordingPasses& passes) {
  Identification id = empty_identification(file, options);
  const auto say = [&options](const std::string& what, double share) {
    if (options.progress) options.progress(what, share);
  };
  say("compressing", 0.0);
  const auto begin = std::chrono::steady_clock::now();
  AskedArm arm(file, options.friction);
  for (CompressedRecording& r : passes.compress(arm.effective_arm(), train, id.preprocessing, options.threads))
    trained.push_back(std::move(r));
  for (CompressedRecording& r : trained)
    merge_blocks(r, blocks_of_each(static_cast<int>(trained.size())));
  id.seconds.compress = seconds_since(begin);
  say("solving", identifying::kSolving);
  // A torque that is zero throughout was not recorded; without any torque nothing can be identified.
  std::set<int> silent = silent_joints(trained);
  if (static_cast<int>(silent.size()) == file.joints()) silent.clear();
  std::string names;
  for (const int j : silent) names += (names.empty() ? "" : ", ") + file.coordinates()[static_cast<size_t>(j)].name;
  if (!silent.empty()) {
    id.remarks.push_back("The torque of " + names + " is zero throughout: it was not recorded, or nothing drove the joint. Its rows are "
                         "left out, and what it alone shows, as its friction, is not identified.");
    if (std::string friction = arm.remark(); !friction.empty()) id.remarks.push_back(std::move(friction));
    arm = AskedArm(without_effects_of(silent, arm.effective_arm()), JointFriction::kFile);
    exclude_joints(silent, trained);
  }
  if (!fit_factors(arm, trained, options, id)) {
    if (!silent.empty()) id.reason += "; the torque of " + names + " is zero throughout, and the other joints alone do not determine the arm";
    return id;
  }
  refit_with_instruments(arm.effective_arm(), trained, options, id);
  say("validating", identifying::kValidating);
  id.factors = std::move(trained);
  validate(arm.effective_arm(), test, options, passes, id);
  if (std::string differ = differing_recordings(arm.effective_arm(), id); !differ.empty()) id.warnings.push_back(std::move(differ));
  if (torques_are_negligible(id)) return id;
  store_training_error(id);
  say("done", 1.0);
  return id;
}

Identification identify_compressed(const Model& arm, std::vector<CompressedRecording> trained,
                                   const std::vector<std::string>& train, const std::vector<std::string>& test,
                                   const IdentificationOptions& options) {
  return identify_compressed(arm, std::move(trained), train, test, options, RecordingPasses());
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
  drop_recordings(id);
  id.preprocessing.in_memory = options.preprocessing.in_memory;  // shared with the caller
  train.register_in(id.preprocessing.in_memory);
  return id;
}

Identification identify(const Model& arm, const Recording& recording,
                        const IdentificationOptions& options) {
  return identify(arm, Recordings(recording), {}, options);
}

void save(const Model& arm, const std::string& path) { save_model(arm, path); }

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
