#include "diagnosis/comparison/estimates.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "diagnosis/comparison/comparison_numbers.hpp"
#include "identification/base_expression.hpp"
#include "math/decompositions.hpp"
#include "veridyn/effects/effect_facts.hpp"
#include "veridyn/identification/base_parameters.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

void require_values(const Model& arm) {
  constexpr const char* kExpected = "', expected a model that identify or diagnose wrote.";
  require(arm.inertial_values().has_value(), "compare: found a body without values in robot '", arm.name(), kExpected);
  for (const EffectTerm& term : arm.effects())
    require(EffectFacts(arm, term).has_values(), "compare: found effect '", term.effect, "' without values in robot '", arm.name(), kExpected);
}

}  // namespace

Estimates::Estimates(const Model& arm, const VectorRef& own) {
  require_values(arm);
  const std::vector<StandardParameter> parameters = standard_parameters(arm);
  const std::optional<IdentifiedBase>& file = arm.description().identified;
  if (file && !file->has_scatter()) note = fmt::format("{} clusters are too few for statistics", file->clusters);
  const bool from_file = file && file->has_scatter() && read(*file, parameters);
  if (!from_file) {
    const BaseParameters base = base_parameters(arm);
    K = base.K;
    leading = base.independent;
    values = K * standard_values(arm);
    scatter.resize(K.rows(), 0);
  }
  identified = static_cast<int>(K.rows());
  make_canonical();
  const std::vector<std::string> names = parameter_names(parameters);
  for (int r = 0; r < identified; ++r)
    expressions.push_back(expression_of(K.row(r).transpose().cwiseProduct(VectorXd(1.0 - own.array())), leading[r], names));
  if (from_file) add_facts(parameters);
}

// Reads the combinations of an identification. False, with a note, if they contradict the values of the file.
bool Estimates::read(const IdentifiedBase& file, const std::vector<StandardParameter>& parameters) {
  std::unordered_map<std::string, Eigen::Index> index;
  for (size_t j = 0; j < parameters.size(); ++j) index.emplace(parameters[j].name, static_cast<Eigen::Index>(j));
  const auto rows = static_cast<Eigen::Index>(file.parameters.size());
  K = MatrixXd::Zero(rows, static_cast<Eigen::Index>(parameters.size()));
  values.resize(rows);
  scatter.resize(rows, file.parameters.front().scatter.size());
  leading.clear();
  for (Eigen::Index r = 0; r < rows; ++r) {
    const IdentifiedParameter& p = file.parameters[r];
    double sum = 0.0, size = std::abs(p.value);
    for (const auto& [name, coefficient] : p.combination) {
      const auto found = index.find(name);
      if (found == index.end()) {
        note = "its statistics name '" + name + "', which the model does not have";
        return false;
      }
      K(r, found->second) = coefficient;
      const double part = coefficient * parameters[found->second].value;
      sum += part;
      size += std::abs(part);
    }
    if (std::abs(sum - p.value) > comparing::numbers.from_values * size) {
      note = "its values were changed after the identification (" + p.name + ")";
      return false;
    }
    leading.push_back(static_cast<int>(index.at(p.name)));
    values[r] = p.free;
    scatter.row(r) = p.scatter.transpose();
  }
  clusters = file.clusters;
  if (scatter.cols() == clusters) motion = file.motion;
  return true;
}

void Estimates::make_canonical() {
  const MatrixXd at_leading = K(Eigen::all, leading);
  if (at_leading.isIdentity(comparing::kSame)) return;
  const Eigen::ColPivHouseholderQR<MatrixXd> by_leading(at_leading);
  K = by_leading.solve(K).eval();
  scatter = by_leading.solve(scatter).eval();
  values = by_leading.solve(values).eval();
}

// Known parameters, of which the identified combinations have none.
void Estimates::add_facts(const std::vector<StandardParameter>& parameters) {
  for (size_t j = 0; j < parameters.size(); ++j) {
    if (!parameters[j].fixed) continue;
    const Eigen::Index row = K.rows();
    leading.push_back(static_cast<int>(j));
    K.conservativeResize(row + 1, Eigen::NoChange);
    K.row(row) = VectorXd::Unit(K.cols(), static_cast<Eigen::Index>(j)).transpose();
    values.conservativeResize(row + 1);
    values[row] = parameters[j].value;
    scatter.conservativeResize(row + 1, Eigen::NoChange);
    scatter.row(row).setZero();
  }
}

Estimate Estimates::of(const VectorRef& w) const {
  const VectorXd c = w(leading);
  return {c.dot(values), scatter.transpose() * c};
}

bool Estimates::determines(const VectorRef& w, const VectorRef& sizes) const {
  const VectorXd c = w(leading);
  return (sizes.cwiseProduct(K.transpose() * c - w)).norm() <= comparing::kInSpan * sizes.cwiseProduct(w).norm();
}

bool same_motion(const Estimates& a, const Estimates& b) {
  if (a.motion.rows() == 0 || a.motion.rows() != b.motion.rows()) return false;
  const auto spread = [](const MatrixXd& m) { return (m.rowwise() - m.colwise().mean()).norm(); };
  return (a.motion - b.motion).norm() < comparing::numbers.same_motion * std::max(spread(a.motion), spread(b.motion));
}

}  // namespace veridyn
