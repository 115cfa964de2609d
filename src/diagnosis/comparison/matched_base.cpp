#include "diagnosis/comparison/matched_base.hpp"

#include <fmt/format.h>

#include <cmath>
#include <unordered_map>

#include "diagnosis/comparison/model_structure.hpp"
#include "veridyn/effects/effect_facts.hpp"
#include "veridyn/identification/base_parameters.hpp"
#include "math/decompositions.hpp"
#include "veridyn/math/require.hpp"
#include "diagnosis/comparison/comparison_numbers.hpp"

namespace veridyn {
namespace {

// Solves A x = b with the least norm of x, for many b.
using LeastNorm = Eigen::CompleteOrthogonalDecomposition<MatrixXd>;

VectorXd values_of(const Model& arm, const std::vector<StandardParameter>& parameters) {
  require(arm.inertial_values().has_value(), "compare: found a body without values in robot '",
          arm.name(), "', expected a model that identify or diagnose wrote.");
  for (const EffectTerm& term : arm.effects()) {
    require(EffectFacts(arm, term).has_values(), "compare: found effect '", term.effect,
            "' without values in robot '", arm.name(),
            "', expected a model that identify or diagnose wrote.");
  }
  VectorXd out(parameters.size());
  for (std::size_t j = 0; j < parameters.size(); ++j)
    out[static_cast<Eigen::Index>(j)] = parameters[j].value;
  return out;
}

std::string expression_of(const VectorXd& row, Eigen::Index leading,
                          const std::vector<StandardParameter>& parameters) {
  std::string out = parameters[leading].name;
  for (Eigen::Index j = 0; j < row.size(); ++j) {
    if (j == leading || row[j] == 0.0) continue;
    const std::string size = fmt::format("{:.6g}", std::abs(row[j]));
    out += row[j] < 0.0 ? " - " : " + ";
    out += (size == "1" ? "" : size + " ") + parameters[j].name;
  }
  return out;
}

// Reads the identified base from the model file. False, with a note, if it contradicts the file's values.
bool read_identified_base(const IdentifiedBase& file, const std::vector<StandardParameter>& parameters,
                     const VectorXd& values, BaseNumbers& out) {
  std::unordered_map<std::string, Eigen::Index> index;
  for (std::size_t j = 0; j < parameters.size(); ++j)
    index.emplace(parameters[j].name, static_cast<Eigen::Index>(j));
  const auto rows = static_cast<Eigen::Index>(file.parameters.size());
  out.K = MatrixXd::Zero(rows, values.size());
  out.free.resize(rows);
  out.scatter.resize(rows, file.parameters.front().scatter.size());
  for (Eigen::Index r = 0; r < rows; ++r) {
    const IdentifiedParameter& p = file.parameters[r];
    double sum = 0.0;
    double size = std::abs(p.value);
    for (const auto& [name, coefficient] : p.combination) {
      const auto found = index.find(name);
      if (found == index.end()) {
        out.note = "its statistics name '" + name + "', which the model does not have";
        return false;
      }
      out.K(r, found->second) = coefficient;
      sum += coefficient * values[found->second];
      size += std::abs(coefficient * values[found->second]);
    }
    if (std::abs(sum - p.value) > comparing::numbers.from_values * size) {
      out.note = "its values were changed after the identification (" + p.name + ")";
      return false;
    }
    out.leading.push_back(static_cast<int>(index.at(p.name)));
    out.free[r] = p.free;
    out.scatter.row(r) = p.scatter.transpose();
  }
  out.clusters = file.clusters;
  if (out.scatter.cols() == out.clusters) out.motion = file.motion;
  return true;
}

// Brings the combinations K into the form that identify() writes: a one at a row's leading parameter and
// zeros at the other leading ones, so that x with K x = beta equals beta at the leading parameters.
void make_canonical(BaseNumbers& numbers) {
  const auto count = numbers.K.rows();
  MatrixXd leading(count, count);
  for (Eigen::Index r = 0; r < count; ++r)
    leading.col(r) = numbers.K.col(numbers.leading[r]);
  if (leading.isIdentity(comparing::kSame)) return;
  const LeastNorm by_leading(leading);
  const auto solve = [&by_leading](MatrixXd& columns) {
    for (Eigen::Index c = 0; c < columns.cols(); ++c)
      columns.col(c) = by_leading.solve(VectorXd(columns.col(c)));
  };
  solve(numbers.K);
  solve(numbers.scatter);
  numbers.free = by_leading.solve(VectorXd(numbers.free));
}

void read_values(const Model& arm, const VectorXd& values, BaseNumbers& out) {
  const BaseParameters base = base_parameters(arm);
  out.K = base.K;
  out.leading = base.independent;
  out.free = base.K * values;
  out.scatter.resize(base.size(), 0);
}

}  // namespace

BaseNumbers base_numbers(const Model& arm) {
  const std::vector<StandardParameter> parameters = standard_parameters(arm);
  const VectorXd values = values_of(arm, parameters);
  const std::optional<IdentifiedBase>& file = arm.description().identified;
  BaseNumbers out;
  if (!file || !file->has_scatter() || !read_identified_base(*file, parameters, values, out)) {
    if (file && !file->has_scatter())
      out.note = fmt::format("{} clusters are too few for statistics", file->clusters);
    out.leading.clear();
    read_values(arm, values, out);
  }
  make_canonical(out);
  for (Eigen::Index r = 0; r < out.K.rows(); ++r) {
    const int leading = out.leading[r];
    const StandardParameter& p = parameters[leading];
    out.names.push_back(p.name);
    out.units.push_back(p.unit);
    out.expressions.push_back(expression_of(out.K.row(r).transpose(), leading, parameters));
  }
  return out;
}

bool same_motion(const BaseNumbers& a, const BaseNumbers& b) {
  if (a.motion.rows() == 0 || a.motion.rows() != b.motion.rows()) return false;
  const auto spread = [](const MatrixXd& m) { return (m.rowwise() - m.colwise().mean()).norm(); };
  return (a.motion - b.motion).norm() < comparing::numbers.same_motion * std::max(spread(a.motion), spread(b.motion));
}

MatchedBase matched_base(const Model& before, const BaseNumbers& a, const Model& after,
                         const BaseNumbers& b, const VectorRef& scale_before,
                         const VectorRef& scale_after) {
  const MatchingNames names = matching_names(before, after);
  std::unordered_map<std::string, Eigen::Index> column;
  std::vector<double> scale;
  const auto columns_of = [&](const std::vector<std::string>& of, const VectorRef& sizes) {
    std::vector<Eigen::Index> out;
    for (std::size_t j = 0; j < of.size(); ++j) {
      const auto [at, fresh] = column.emplace(of[j], static_cast<Eigen::Index>(column.size()));
      if (fresh) scale.push_back(sizes[static_cast<Eigen::Index>(j)]);
      out.push_back(at->second);
    }
    return out;
  };
  const std::vector<Eigen::Index> at_a = columns_of(names.before, scale_before);
  const std::vector<Eigen::Index> at_b = columns_of(names.after, scale_after);
  // Columns of the combinations over the parameters of both models, with one scaling.
  const auto scaled = [&](const MatrixXd& K, const std::vector<Eigen::Index>& at) {
    MatrixXd out = MatrixXd::Zero(scale.size(), K.rows());
    for (std::size_t j = 0; j < at.size(); ++j)
      out.row(at[j]) =
          scale[at[j]] * K.col(j).transpose();
    return out;
  };
  const MatrixXd in_a = scaled(a.K, at_a);
  const MatrixXd in_b = scaled(b.K, at_b);
  const LeastNorm by_a(in_a), by_b(in_b);
  MatchedBase out;
  for (Eigen::Index r = 0; r < in_a.cols(); ++r) {
    const VectorXd w = by_b.solve(VectorXd(in_a.col(r)));
    if ((in_b * w - in_a.col(r)).norm() > comparing::kInSpan * in_a.col(r).norm()) {
      out.only_before.push_back(a.expressions[r]);
      continue;
    }
    out.parameters.push_back({static_cast<int>(r), a.free[r], w.dot(b.free),
                              a.scatter.row(r).transpose(), b.scatter.transpose() * w});
  }
  for (Eigen::Index r = 0; r < in_b.cols(); ++r) {
    const VectorXd w = by_a.solve(VectorXd(in_b.col(r)));
    if ((in_a * w - in_b.col(r)).norm() > comparing::kInSpan * in_b.col(r).norm())
      out.only_after.push_back(b.expressions[r]);
  }
  return out;
}

}  // namespace veridyn
