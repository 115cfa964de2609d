#include "identification/fold_errors.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "identification/base_solution.hpp"
#include "identification/feasible/feasible_fit.hpp"
#include "identification/many_recordings.hpp"
#include "model/noise_unit.hpp"
#include "veridyn/identification/base_parameters.hpp"

namespace veridyn {
namespace {

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

// Rms residuals of the fitted rows.
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

// Factor for residuals with a longer correlation time: it converts them to equivalent residuals with one
// independent sample in kNoiseSeconds. Noise that is held for T seconds (a zero-order hold), with a column
// that oscillates at f hertz, gives sqrt(T / kNoiseSeconds) |sinc(pi f T)|.
double correlation_inflation(const Model& arm, const Identification& id) {
  double seconds = 0.0;
  for (const CompressedRecording& r : id.factors) seconds += r.facts.duration;
  if (!(id.effective_samples > 0.0)) return 1.0;
  return std::sqrt(std::max(1.0, seconds * arm.joints() / id.effective_samples / kNoiseSeconds));
}

// For each part that is held out together, the blocks of its recordings.
std::vector<BlockList> parts_of(const std::vector<CompressedRecording>& recordings, const HoldOut& hold_out) {
  const size_t each = hold_out.parts_of_each(recordings.size());
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

// Sum of squares of every joint's torque over this number of rows, estimated from its series.
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

FoldErrors fold_errors(const Identification& fitted, const IdentificationOptions& options, const HoldOut& hold_out) {
  const Model& arm = *fitted.model;
  const std::vector<std::string> names = parameter_names(standard_parameters(arm));
  const std::vector<BlockList> parts = parts_of(fitted.factors, hold_out);
  VectorXd weights = range_weights(fitted.factors);
  if (options.weights == JointWeights::kResidual)
    weights = residual_weights(joint_totals(fitted.factors), weights, identifiable_base_parameters(arm), names);
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
  // Directions that the parts hardly determine (asymmetric Coulomb friction and an offset differ at rest
  // alone) keep the values of all parts together; otherwise the folds would differ much.
  const MatrixXd anchor = (std::sqrt(hold_out.new_share) * total.column_norms()).asDiagonal();
  for (size_t part = 0; part < parts.size(); ++part) {
    Identification without;
    without.parameters = VectorXd::Zero(names.size());
    SquareRootInformation rest(names);
    for (size_t other = 0; other < parts.size(); ++other) {
      if (other != part || parts.size() == 1) rest.merge(factors[other]);
    }
    rest.absorb(anchor, anchor * fitted.parameters);
    without.unconstrained_objective = fitted.unconstrained_objective;
    solve_feasible(arm, rest, options, without);
    out.error2.row(part) =
        squared_errors(parts[part], by_name(names, without.parameters)).transpose();
  }
  out.torque2 = squared_torques(fitted, rows);
  return out;
}

void store_training_error(Identification& id) {
  ModelDescription description = id.model->description();
  description.identified->error = id.train_error.relative;
  description.identified->noise = rms_residuals(*id.model, id) * correlation_inflation(*id.model, id);
  id.model = Model(std::move(description));
}

}  // namespace veridyn
