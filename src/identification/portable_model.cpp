#include "veridyn/identification/portable_model.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "effects/plain_friction.hpp"
#include "files/words.hpp"
#include "math/eigen_pose.hpp"
#include "veridyn/identification/base_parameters.hpp"
#include "veridyn/regressor/standard_parameters.hpp"
#include "veridyn/identification/feasible_least_squares.hpp"
#include "veridyn/identification/pseudo_inertia.hpp"
#include "veridyn/files/physical_faults.hpp"
#include "math/dense.hpp"
#include "veridyn/math/require.hpp"
#include "model/suggestion.hpp"

namespace veridyn {
namespace {

constexpr double kRodRadius = 0.025;     // [m]
constexpr double kRodDensity = 1000.0;   // [kg/m^3]
constexpr double kShortestRod = 0.05;    // [m]
constexpr double kSmallestRadius = 0.005;  // [m] radius of gyration of a manufacturer's body, at least
constexpr double kTorquesOverPrior = 1e4;  // weight of the torques' rows relative to the prior
// Weight of a CAD model's mass: an error of a tenth costs as much as bodies whose shapes differ by e^50 in
// total, so that only torques change it.
constexpr double kMassTrust = 1e4;
constexpr int kTurns = 2;                  // iterations of the method of multipliers; the second one leaves a violation of at most 1e-8

constexpr double kIdleRotor = 1e-6;  // share of the largest body's inertia below which a rotor has none
constexpr const char* kRotorValue = "inertia";  // parameter of the effect

const char* const kSymbols[] = {"m", "hx", "hy", "hz", "Lxx", "Lxy", "Lyy", "Lxz", "Lyz", "Lzz"};

// A rod that connects the frame's joint, its origin and the joints attached to it.
InertialVector rod_body(const Model& arm, int frame) {
  std::vector<Eigen::Vector3d> points = {Eigen::Vector3d::Zero(),
                                         eigen(inverse(arm.frames()[frame].B).p)};
  for (const Frame& child : arm.frames()) {
    if (child.parent == FrameIndex{frame}) points.push_back(eigen(child.A.p));
  }
  Eigen::Vector3d first = points[0], last = points[0];
  for (const Eigen::Vector3d& a : points) {
    for (const Eigen::Vector3d& b : points) {
      if ((b - a).norm() <= (last - first).norm()) continue;
      first = a;
      last = b;
    }
  }
  const double length = std::max(kShortestRod, (last - first).norm());
  const Eigen::Vector3d along = (last - first).norm() > 0.0 ? Eigen::Vector3d((last - first).normalized())
                                                            : Eigen::Vector3d::UnitZ();
  const double mass = kRodDensity * M_PI * kRodRadius * kRodRadius * length;
  const Eigen::Vector3d com = 0.5 * (first + last);
  Eigen::Matrix4d J;
  J.topLeftCorner<3, 3>() =
      mass * (length * length / 12.0 * along * along.transpose() +
              kRodRadius * kRodRadius / 4.0 * Eigen::Matrix3d::Identity() + com * com.transpose());
  J.topRightCorner<3, 1>() = mass * com;
  J.bottomLeftCorner<1, 3>() = mass * com.transpose();
  J(3, 3) = mass;
  return inertial_parameters(J);
}

// Prior of a body: the body of that name in `prior` if it is physically consistent, else the manufacturer's, else a
// uniform rod.
struct BodyPrior {
  InertialVector phi;
  bool drawn = true;  // false: the body is the rod
};

BodyPrior prior_of(const Model& arm, FrameIndex frame, const std::optional<Model>& prior) {
  const auto usable = [&](const std::optional<InertialParameters>& phi) {
    return phi && (*phi)[0] > 0.0 && body_fault("", *phi).empty();
  };
  if (prior) {
    const std::optional<FrameIndex> there = prior->find_frame(arm.frames()[frame.value].name);
    const std::optional<Body> body = there ? prior->frames()[there->value].body : std::nullopt;
    if (body && usable(body->phi)) return {with_minimum_radius(*body->phi, kSmallestRadius)};
  }
  const Body& own = *arm.frames()[frame.value].body;
  if (usable(own.prior)) return {with_minimum_radius(*own.prior, kSmallestRadius)};
  return {rod_body(arm, frame.value), false};
}

bool are_all_possible(const VectorXd& phi) {
  for (Eigen::Index first = 0; first < phi.size(); first += kBodyParameters) {
    if (!(smallest_eigenvalue(pseudo_inertia(phi.segment<kBodyParameters>(first))) > 0.0))
      return false;
  }
  return true;
}

// The arm with these values in its free columns.
Model with_chosen(const Model& arm, const std::vector<Eigen::Index>& free, const VectorXd& x) {
  ModelDescription d = arm.description();
  const std::vector<StandardParameter> parameters = standard_parameters(arm);
  for (size_t j = 0; j < free.size(); ++j) {
    const StandardParameter& p = parameters[free[j]];
    const double value = x[static_cast<Eigen::Index>(j)];
    if (p.body) (*d.frames[arm.bodies()[*p.body].value].body->phi)[p.component] = value;
    else if (value != p.value) d.effects[*p.effect].values[kRotorValue] = value;
  }
  return Model(std::move(d));
}

// Columns of the bodies without known values, then, with kArmatures, those of the rotor inertias of single
// joints.
std::vector<Eigen::Index> free_columns(const Model& arm, RotorPlace rotors) {
  std::vector<Eigen::Index> out;
  const std::vector<StandardParameter> parameters = standard_parameters(arm);
  for (size_t p = 0; p < parameters.size(); ++p) {
    bool free = parameters[p].body && !arm.frames()[arm.bodies()[*parameters[p].body].value].body->fixed;
    if (parameters[p].effect && rotors == RotorPlace::kArmatures) {
      const EffectTerm& term = arm.effects()[*parameters[p].effect];
      free = term.effect == kRotorInertia && term.axis.coefficients.cwiseAbs().sum() == 1.0 &&
             term.axis.coefficients.maxCoeff() == 1.0 && parameters[p].value >= 0.0 && !parameters[p].fixed;
    }
    if (free) out.push_back(static_cast<Eigen::Index>(p));
  }
  return out;
}

// Rows of K over the columns of bodies, each normalised in the prior's units.
struct TorqueRows {
  MatrixXd A;
  VectorXd b;
};

TorqueRows torque_rows(const BaseParameters& base, const VectorXd& phi,
                       const std::vector<Eigen::Index>& free, const VectorXd& scale) {
  const auto columns = static_cast<Eigen::Index>(free.size());
  TorqueRows out{MatrixXd(base.K.rows(), columns), {}};
  VectorXd values(columns);
  for (Eigen::Index j = 0; j < columns; ++j) {
    out.A.col(j) = base.K.col(free[j]);
    values[j] = phi[free[j]];
  }
  for (Eigen::Index r = 0; r < out.A.rows(); ++r) {
    const double norm = (out.A.row(r).transpose().cwiseProduct(scale)).norm();
    if (norm > 0.0) out.A.row(r) /= norm;
  }
  out.b = out.A * values;
  return out;
}

// Magnitudes of a body's ten parameters, followed by those of the rotor inertias.
VectorXd sizes_of(const std::vector<InertialVector>& priors, Eigen::Index rotors) {
  VectorXd out(static_cast<Eigen::Index>(kBodyParameters * priors.size()) + rotors);
  out.tail(rotors).setZero();
  for (size_t b = 0; b < priors.size(); ++b) {
    const double m = priors[b][0];
    const double J = 0.5 * (priors[b][4] + priors[b][6] + priors[b][9]);
    auto own = out.segment<kBodyParameters>(static_cast<Eigen::Index>(kBodyParameters * b));
    own[0] = m;
    own.segment<3>(1).setConstant(std::sqrt(m * J));
    own.tail<6>().setConstant(J);
    out.tail(rotors) = out.tail(rotors).cwiseMax(J);
  }
  return out;
}

std::vector<PortableBody> portable_bodies(const Model& arm, const BaseParameters& base,
                                    const VectorXd& before) {
  std::vector<PortableBody> out;
  for (size_t b = 0; b < arm.bodies().size(); ++b) {
    const Frame& frame = arm.frames()[arm.bodies()[b].value];
    PortableBody body{frame.name, before[static_cast<Eigen::Index>(kBodyParameters * b)],
                      (*frame.body->phi)[0], {}};
    for (int c = 0; c < kBodyParameters; ++c) {
      const bool alone = base.classes[kBodyParameters * b + static_cast<size_t>(c)] ==
                         Identifiability::kAlone;
      if (!alone && !frame.body->fixed) body.undetermined.emplace_back(kSymbols[c]);
    }
    out.push_back(std::move(body));
  }
  return out;
}

// The arm with a rotor inertia of zero on every joint that has none.
Model with_all_rotors(const Model& arm) {
  ModelDescription d = with_effect_of_all_joints(arm, kRotorInertia).description();
  for (size_t e = arm.effects().size(); e < d.effects.size(); ++e) d.effects[e].values = {{kRotorValue, 0.0}};
  return Model(std::move(d));
}

// The arm without the added rotor inertias that remained zero.
Model without_idle_rotors(const Model& arm, size_t effects) {
  ModelDescription d = arm.description();
  const auto idle = [](const EffectTerm& term) { return term.values.at(kRotorValue) == 0.0; };
  d.effects.erase(std::remove_if(d.effects.begin() + static_cast<std::ptrdiff_t>(effects), d.effects.end(), idle), d.effects.end());
  return Model(std::move(d));
}

}  // namespace

PortableModel portable_model(const Model& given, const std::optional<Model>& prior, RotorPlace rotors) {
  const auto phi = given.inertial_values();
  require(phi.has_value(), "export: arm '", given.name(),
          "' has bodies without values, expected a MODEL that identify or diagnose wrote.");
  PortableModel out{given, {}, false, {}, {}};
  if (!given.description().identified) return out;
  const Model arm = rotors == RotorPlace::kArmatures ? with_all_rotors(given) : given;
  const BaseParameters base = base_parameters(arm);
  out.bodies = portable_bodies(given, base, *phi);
  const std::vector<Eigen::Index> free = free_columns(arm, rotors);
  FeasibleProblem problem;
  FeasibleOptions options;
  std::vector<InertialVector> priors;
  std::vector<bool> drawn;
  for (size_t b = 0; b < arm.bodies().size(); ++b) {
    if (arm.frames()[arm.bodies()[b].value].body->fixed) continue;
    problem.body_columns.push_back(static_cast<int>(kBodyParameters * priors.size()));
    const BodyPrior own = prior_of(arm, arm.bodies()[b], prior);
    priors.push_back(own.phi);
    drawn.push_back(own.drawn);
  }
  if (priors.empty()) return out;
  const auto columns = static_cast<Eigen::Index>(free.size());
  const auto of_bodies = static_cast<Eigen::Index>(kBodyParameters * priors.size());
  const VectorXd scale = sizes_of(priors, columns - of_bodies);
  const TorqueRows rows = torque_rows(base, standard_values(arm), free, scale);
  problem.R = kTorquesOverPrior * rows.A;
  problem.G = -MatrixXd::Identity(columns, columns).bottomRows(columns - of_bodies);
  problem.h = VectorXd::Zero(columns - of_bodies);
  options.quadratic_prior.weight = VectorXd::Zero(columns);
  options.quadratic_prior.x = VectorXd::Zero(columns);
  for (size_t b = 0; b < priors.size(); ++b) {
    if (!drawn[b]) continue;
    const double mass = priors[b][0];
    options.quadratic_prior.weight[problem.body_columns[b]] = kMassTrust / (mass * mass);
    options.quadratic_prior.x[problem.body_columns[b]] = mass;
  }
  options.entropic_prior.weight = 1.0;
  options.entropic_prior.phi = priors;
  options.gap_tolerance = 1e-7;
  // Method of multipliers: the violation of the torques' rows is added to their right side.
  FeasibleResult found;
  VectorXd wanted = rows.b;
  for (int turn = 0; turn < kTurns; ++turn) {
    problem.z = kTorquesOverPrior * wanted;
    found = solve_feasible_least_squares(problem, options);
    wanted += rows.b - rows.A * found.x;
  }
  // Corrects rounding by the shortest step, in the prior's units, that restores the torques. A rotor inertia
  // near zero is set to zero.
  VectorXd x = found.x;
  VectorXd step_scale = scale;
  for (Eigen::Index j = of_bodies; j < columns; ++j) {
    if (x[j] > kIdleRotor * scale[j]) continue;
    x[j] = 0.0;
    step_scale[j] = 0.0;
  }
  const MatrixXd A = rows.A * step_scale.asDiagonal();
  for (int step = 0; step < 2; ++step)
    x += step_scale.asDiagonal() * least_norm(A, VectorXd(rows.b - rows.A * x));
  if (!found.feasible || !are_all_possible(x.head(of_bodies)) || (x.array().tail(columns - of_bodies) < 0.0).any()) {
    out.remark = "no values near " + std::string(prior ? "the prior" : "plain rods") + " give these torques with possible bodies: values stay as "
                 "identified";
    return out;
  }
  out.arm = without_idle_rotors(with_chosen(arm, free, x), given.effects().size());
  out.changed = true;
  const auto count = std::count(drawn.begin(), drawn.end(), true);
  const std::string rod_words = "a rod of 5 cm diameter and the density of water along every ";
  out.prior = prior      ? "the bodies of " + prior->name()
              : count == 0 ? rod_words + "link"
              : count == static_cast<long>(drawn.size())
                  ? "the bodies of the robot file that the model was identified from"
                  : "the bodies of the robot file that the model was identified from, and " + rod_words + "other link";
  out.bodies = portable_bodies(out.arm, base, *phi);
  return out;
}

namespace {

std::map<std::string, std::string> remarks_on(const PortableModel& model) {
  std::map<std::string, std::string> out;
  if (model.changed) {
    out[""] = "torques determine combinations of inertial parameters; those of single links are "
              "chosen near " +
              model.prior + ", without changing any torque";
  }
  for (const PortableBody& body : model.bodies) {
    if (body.undetermined.empty()) continue;
    out[body.frame] = "not determined by torques alone: " + listed(body.undetermined);
  }
  return out;
}

// [m] radius of gyration of a body without size, such as a diagnosed load, since simulators refuse bodies
// without inertia. A kilogram gets 1e-6 kg m^2, below the resolution of any arm's torques.
constexpr double kPointRadius = 1e-3;

Model with_sizes_of_points(const Model& arm) {
  ModelDescription d = arm.description();
  for (Frame& frame : d.frames) {
    if (!frame.body || !((*frame.body->phi)[0] > 0.0)) continue;
    InertialParameters& phi = *frame.body->phi;
    const Eigen::Matrix4d J = pseudo_inertia(phi);
    const double spread = (J.topLeftCorner<3, 3>() - J.topRightCorner<3, 1>() * J.topRightCorner<3, 1>().transpose() / phi[0]).norm();
    if (spread < phi[0] * kPointRadius * kPointRadius) phi = with_minimum_radius(phi, kPointRadius);
  }
  return Model(std::move(d));
}

}  // namespace

ExportedModel exported_model(const Model& arm, const std::optional<Model>& prior,
                             const std::string& meshes_from, RotorPlace rotors) {
  ExportedModel out{arm, {}, {}, {}};
  if (arm.inertial_values()) {
    const PortableModel portable = portable_model(arm, prior, rotors);
    out.arm = with_sizes_of_points(portable.arm);
    out.extras.remarks = remarks_on(portable);
    if (!portable.remark.empty()) out.warnings.push_back(portable.remark);
    if (portable.changed) {
      out.notes.push_back("values that torques do not determine are chosen near " +
                          portable.prior + "; no torque changes, and the file marks them");
    }
  }
  if (!arm.inertial_values())
    out.warnings.push_back("found bodies without values: a URDF of them has no masses; expected a MODEL "
                           "that identify or diagnose wrote");
  const std::string& source = arm.description().source;
  const std::string from = !meshes_from.empty() ? meshes_from : ends_with(source, ".urdf") ? source : "";
  if (from.empty()) return out;
  if (meshes_from.empty() && !std::filesystem::exists(from)) {
    out.warnings.push_back("the meshes of " + from +
                           " are left out: found no such file (--meshes-from names it)");
    return out;
  }
  out.extras.appearance = urdf_appearance(from);
  return out;
}

}  // namespace veridyn
