#include "veridyn/export/portable_model.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "math/words.hpp"
#include "math/eigen_pose.hpp"
#include "veridyn/regressor/base_parameters.hpp"
#include "veridyn/identification/feasible_least_squares.hpp"
#include "veridyn/identification/pseudo_inertia.hpp"
#include "math/dense.hpp"
#include "veridyn/math/require.hpp"
#include "model/suggestion.hpp"

namespace veridyn {
namespace {

constexpr double kRodRadius = 0.025;     // [m]
constexpr double kRodDensity = 1000.0;   // [kg/m^3]
constexpr double kShortestRod = 0.05;    // [m]
constexpr double kSmallestRadius = 0.005;  // [m] of a manufacturer's body, about its centre
constexpr double kTorquesOverPrior = 1e4;  // weight of the torques' rows relative to the prior
constexpr int kTurns = 2;                  // of the method of multipliers; the second leaves 1e-8 of the rows at most

const char* const kSymbols[] = {"m", "hx", "hy", "hz", "Lxx", "Lxy", "Lyy", "Lxz", "Lyz", "Lzz"};

// A rod that connects the frame's joint, its origin and the joints attached to it.
InertialVector rod(const Model& arm, int frame) {
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

// The prior's body of that name if it is physically consistent, else the manufacturer's, else the
// rod.
InertialVector prior_of(const Model& arm, int frame, const std::optional<Model>& prior) {
  if (prior) {
    const int there = prior->find_frame(arm.frames()[frame].name);
    if (there >= 0) {
      const std::optional<Body>& body = prior->frames()[there].body;
      if (body && body->phi && smallest_scaled_eigenvalue(pseudo_inertia(*body->phi)) > 1e-6)
        return *body->phi;
    }
  }
  const Body& own = *arm.frames()[frame].body;
  if (own.prior && (*own.prior)[0] > 0.0) return with_size(*own.prior, kSmallestRadius);
  return rod(arm, frame);
}

bool all_possible(const VectorXd& phi) {
  for (Eigen::Index first = 0; first < phi.size(); first += kBodyParameters) {
    if (!(smallest_eigenvalue(pseudo_inertia(phi.segment<kBodyParameters>(first))) > 0.0))
      return false;
  }
  return true;
}

Model with_phi(const Model& arm, const VectorXd& phi) {
  ModelDescription d = arm.description();
  for (size_t b = 0; b < arm.bodies().size(); ++b) {
    d.frames[arm.bodies()[b]].body->phi =
        phi.segment<kBodyParameters>(static_cast<Eigen::Index>(kBodyParameters * b));
  }
  return Model(std::move(d));
}

// Columns of the bodies that are not facts.
std::vector<Eigen::Index> free_columns(const Model& arm) {
  std::vector<Eigen::Index> out;
  for (size_t b = 0; b < arm.bodies().size(); ++b) {
    if (arm.frames()[arm.bodies()[b]].body->fixed) continue;
    for (size_t c = 0; c < kBodyParameters; ++c)
      out.push_back(static_cast<Eigen::Index>(kBodyParameters * b + c));
  }
  return out;
}

// Rows of K over the columns of bodies, each row of unit length in the prior's units.
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

// Magnitudes of a body's ten parameters.
VectorXd sizes_of(const std::vector<InertialVector>& priors) {
  VectorXd out(kBodyParameters * priors.size());
  for (size_t b = 0; b < priors.size(); ++b) {
    const double m = priors[b][0];
    const double J = 0.5 * (priors[b][4] + priors[b][6] + priors[b][9]);
    auto own = out.segment<kBodyParameters>(static_cast<Eigen::Index>(kBodyParameters * b));
    own[0] = m;
    own.segment<3>(1).setConstant(std::sqrt(m * J));
    own.tail<6>().setConstant(J);
  }
  return out;
}

std::vector<PortableBody> described(const Model& arm, const BaseParameters& base,
                                    const VectorXd& before) {
  std::vector<PortableBody> out;
  for (size_t b = 0; b < arm.bodies().size(); ++b) {
    const Frame& frame = arm.frames()[arm.bodies()[b]];
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

}  // namespace

PortableModel portable_model(const Model& arm, const std::optional<Model>& prior) {
  const auto phi = arm.inertial_values();
  require(phi.has_value(), "export: arm '", arm.name(),
          "' has bodies without values, expected a MODEL that identify or diagnose wrote.");
  PortableModel out{arm, {}, false, {}, {}};
  if (!arm.description().identified) return out;
  const BaseParameters base = base_parameters(arm);
  out.bodies = described(arm, base, *phi);
  const std::vector<Eigen::Index> free = free_columns(arm);
  if (free.empty()) return out;
  FeasibleProblem problem;
  FeasibleOptions options;
  std::vector<InertialVector> priors;
  for (size_t b = 0; b < arm.bodies().size(); ++b) {
    if (arm.frames()[arm.bodies()[b]].body->fixed) continue;
    problem.body_columns.push_back(static_cast<int>(kBodyParameters * priors.size()));
    priors.push_back(prior_of(arm, arm.bodies()[b], prior));
  }
  const VectorXd scale = sizes_of(priors);
  const TorqueRows rows = torque_rows(base, *phi, free, scale);
  problem.R = kTorquesOverPrior * rows.A;
  options.entropic_prior.weight = 1.0;
  options.entropic_prior.phi = priors;
  options.gap_tolerance = 1e-7;
  // The method of multipliers: what the prior pulls the torques' rows away by is added to their right side.
  FeasibleResult found;
  VectorXd wanted = rows.b;
  for (int turn = 0; turn < kTurns; ++turn) {
    problem.z = kTorquesOverPrior * wanted;
    found = solve_feasible_least_squares(problem, options);
    wanted += rows.b - rows.A * found.x;
  }
  // Corrects rounding by the shortest step, in the prior's units, that restores the torques.
  const MatrixXd A = rows.A * scale.asDiagonal();
  VectorXd x = found.x;
  for (int step = 0; step < 2; ++step)
    x += scale.asDiagonal() * least_norm(A, VectorXd(rows.b - rows.A * x));
  if (!found.feasible || !all_possible(x)) {
    out.remark = "no values near " + std::string(prior ? "the prior" : "plain rods") + " give these torques with possible bodies: values stay as "
                 "identified";
    return out;
  }
  VectorXd chosen = *phi;
  for (size_t j = 0; j < free.size(); ++j) chosen[free[j]] = x[static_cast<Eigen::Index>(j)];
  out.arm = with_phi(arm, chosen);
  out.changed = true;
  const auto drawn = std::count_if(arm.bodies().begin(), arm.bodies().end(), [&](int k) {
    const auto& own = arm.frames()[k].body->prior;
    return own && (*own)[0] > 0.0;
  });
  const std::string rod_words = "a rod of 5 cm diameter and the density of water along every ";
  out.prior = prior      ? "the bodies of " + prior->name()
              : !drawn   ? rod_words + "link"
              : drawn == static_cast<long>(arm.bodies().size())
                  ? "the bodies of the robot file that the model was identified from"
                  : "the bodies of the robot file that the model was identified from, and " + rod_words + "other link";
  out.bodies = described(out.arm, base, *phi);
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

// [m] radius of gyration of a body that is known as a point, such as a diagnosed load: simulators
// refuse bodies without inertia. A kilogram gets 1e-6 kg m^2, below what torques of any arm tell.
constexpr double kPointRadius = 1e-3;

Model with_sizes_of_points(const Model& arm) {
  ModelDescription d = arm.description();
  for (Frame& frame : d.frames) {
    if (!frame.body || !((*frame.body->phi)[0] > 0.0)) continue;
    InertialParameters& phi = *frame.body->phi;
    const Eigen::Matrix4d J = pseudo_inertia(phi);
    const double spread = (J.topLeftCorner<3, 3>() - J.topRightCorner<3, 1>() * J.topRightCorner<3, 1>().transpose() / phi[0]).norm();
    if (spread < phi[0] * kPointRadius * kPointRadius) phi = with_size(phi, kPointRadius);
  }
  return Model(std::move(d));
}

}  // namespace

ExportedModel exported_model(const Model& arm, const std::optional<Model>& prior,
                             const std::string& meshes_from) {
  ExportedModel out{arm, {}, {}, {}};
  if (arm.inertial_values()) {
    const PortableModel portable = portable_model(arm, prior);
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
