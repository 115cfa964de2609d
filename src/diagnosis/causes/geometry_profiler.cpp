#include "diagnosis/causes/geometry_profiler.hpp"

#include <algorithm>

#include "diagnosis/evidence/clustered_fit.hpp"
#include "diagnosis/evidence/numerics.hpp"
#include "identification/base_solution.hpp"
#include "regressor/effect_along.hpp"
#include "veridyn/dynamics/torque_regressor.hpp"

namespace veridyn {
namespace {

Eigen::Index parts_of_each(Eigen::Index recordings) {
  return std::clamp<Eigen::Index>(numerics::kMostConstantParts / std::max<Eigen::Index>(1, recordings), 1, numerics::kConstantParts);
}

double log_of(const VectorXd& mean_squares) {
  return mean_squares.array().max(numerics::kTiny).log().sum();
}

}  // namespace

// Columns that act on a joint: their indices among all columns, and their source.
struct GeometryProfiler::Own {
  std::vector<Eigen::Index> places;
  std::vector<Eigen::Index> from;  // of the batch's columns of this joint; of the effects below 0
};

// Normal equations of one part of one recording: of every joint, over its own columns (below the
// diagonal).
struct GeometryProfiler::Sums {
  std::vector<MatrixXd> G;
  std::vector<VectorXd> g;
  VectorXd b2;
  double rows = 0.0;
};

struct GeometryProfiler::Parts {
  std::vector<Own> own;
  std::vector<Sums> sums;
};

GeometryProfiler::GeometryProfiler(const Model& arm, const std::vector<std::string>& train,
                                   const IdentificationOptions& options)
    : arm_(arm) {
  for (const EffectTerm& term : arm.effects())
    acts_on_.insert(acts_on_.end(), static_cast<size_t>(EffectFacts(arm, term).parameter_count()),
                    term.axis.coefficients);
  PreprocessingOptions how = options.preprocessing;
  how.filtering = Filtering::kSignals;
  for (const std::string& path : train) {
    Fold fold;
    for_each_segment(arm, path, how, [&](const Segment& s) { append(s, fold); });
    folds_.push_back(std::move(fold));
  }
  weights_ = VectorXd::Ones(arm.joints());
  const std::vector<int> columns = independent(arm);
  weights_ = mean_squares(arm, columns).array().max(numerics::kTiny).inverse();
  start_ = criterion(arm, columns);
}

double GeometryProfiler::criterion(const Model& variant, const std::vector<int>& columns) const {
  return log_of(mean_squares(variant, columns));
}

std::vector<int> GeometryProfiler::independent(const Model& variant) {
  return base_parameters(variant).independent;
}

MatrixXd GeometryProfiler::without_parts(const std::array<Model, 3>& variants,
                                         const std::vector<int>& columns) const {
  MatrixXd out;
  for (size_t v = 0; v < variants.size(); ++v) {
    const Parts parts = sums_of_parts(variants[v], columns, parts_of_each(recordings()));
    const Sums all = total(parts.sums);
    out.conservativeResize(parts.sums.size(), 3);
    for (size_t k = 0; k < parts.sums.size(); ++k) {
      Sums rest = all;
      add(-1.0, parts.sums[k], rest);
      out(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(v)) =
          log_of(mean_squares(parts.own, rest, static_cast<Eigen::Index>(columns.size())));
    }
  }
  return out;
}

void GeometryProfiler::append(const Segment& s, Fold& fold) const {
  const auto step =
      std::max<Eigen::Index>(1, static_cast<Eigen::Index>(1.0 / (numerics::kGeometryRate * s.dt)));
  std::vector<Eigen::Index> kept;
  for (Eigen::Index k = s.core_begin; k < s.core_end; ++k) {
    if (s.use[k] != 0 && k % step == 0) kept.push_back(k);
  }
  const auto grow = [&kept](MatrixXd& to, const MatrixXd& from) {
    const Eigen::Index at = to.rows();
    to.conservativeResize(at + static_cast<Eigen::Index>(kept.size()), from.cols());
    for (size_t k = 0; k < kept.size(); ++k)
      to.row(at + static_cast<Eigen::Index>(k)) = from.row(kept[k]);
  };
  grow(fold.q, s.q);
  grow(fold.dq, s.dq);
  grow(fold.ddq, s.ddq);
  grow(fold.tau, s.tau);
  grow(fold.effects, effects_along(s));
}

// Evaluated on every sample, because a memory depends on all of them.
MatrixXd GeometryProfiler::effects_along(const Segment& s) const {
  const MotionView motion(s.time, s.q, s.dq, s.ddq);
  MatrixXd load;
  MatrixXd out(motion.rows(), static_cast<Eigen::Index>(acts_on_.size()));
  Eigen::Index at = 0;
  for (const EffectTerm& term : arm_.effects()) {
    const EffectFacts effect(arm_, term);
    if (effect.traits().uses_load && load.size() == 0)
      load = rigid_load(arm_, TorqueRegressor(arm_), motion);
    out.middleCols(at, effect.parameter_count()) = columns_along(effect.bound(), motion, load, s.start);
    at += effect.parameter_count();
  }
  return out;
}

std::vector<GeometryProfiler::Own> GeometryProfiler::own_columns(const TorqueRegressor& batch,
                                                                 const std::vector<int>& columns,
                                                                 int bodies, int joints) const {
  std::vector<Own> out(joints);
  for (int i = 0; i < joints; ++i) {
    Own& own = out[i];
    const std::vector<int>& mine = batch.columns(i);
    for (size_t c = 0; c < columns.size(); ++c) {
      const bool effect = columns[c] >= bodies;
      const auto found = std::lower_bound(mine.begin(), mine.end(), columns[c]);
      if (effect ? acts_on_[columns[c] - bodies][i] == 0.0
                 : found == mine.end() || *found != columns[c])
        continue;
      own.places.push_back(static_cast<Eigen::Index>(c));
      own.from.push_back(effect ? -1 - (columns[c] - bodies) : found - mine.begin());
    }
  }
  return out;
}

void GeometryProfiler::add(double sign, const Sums& from, Sums& to) {
  for (size_t i = 0; i < to.G.size(); ++i) {
    to.G[i] += sign * from.G[i];
    to.g[i] += sign * from.g[i];
  }
  to.b2 += sign * from.b2;
  to.rows += sign * from.rows;
}

GeometryProfiler::Sums GeometryProfiler::total(const std::vector<Sums>& parts) {
  Sums out = parts.front();
  for (size_t k = 1; k < parts.size(); ++k) add(1.0, parts[k], out);
  return out;
}

// Divides every recording into parts of equal duration.
GeometryProfiler::Parts GeometryProfiler::sums_of_parts(const Model& variant,
                                                        const std::vector<int>& columns,
                                                        Eigen::Index parts) const {
  const TorqueRegressor batch(variant);
  const auto bodies = static_cast<int>(kBodyParameters * variant.bodies().size());
  const int n = variant.joints();
  Parts out{own_columns(batch, columns, bodies, n), {}};
  for (const Fold& fold : folds_) {
    std::vector<MatrixXd> Y(n);
    batch.evaluate(fold.q, fold.dq, fold.ddq, Y);
    const size_t first = out.sums.size();
    const Eigen::Index rows = fold.q.rows();
    out.sums.resize(first + static_cast<size_t>(parts));
    for (int i = 0; i < n; ++i) {
      const auto at = static_cast<size_t>(i);
      const Own& own = out.own[at];
      MatrixXd A(rows, static_cast<Eigen::Index>(own.from.size()));
      for (Eigen::Index c = 0; c < A.cols(); ++c) {
        const Eigen::Index from = own.from[c];
        if (from < 0)
          A.col(c) = acts_on_[-1 - from][i] * fold.effects.col(-1 - from);
        else
          A.col(c) = Y[at].col(from);
      }
      if (fold.tau.col(i).isZero(0.0)) A.setZero();  // zeros that nobody measured say nothing
      for (Eigen::Index k = 0; k < parts; ++k) {
        const Eigen::Index begin = k * rows / parts;
        const Eigen::Index count = (k + 1) * rows / parts - begin;
        Sums& s = out.sums[first + static_cast<size_t>(k)];
        if (i == 0) {
          s.rows = static_cast<double>(count);
          s.b2 = fold.tau.middleRows(begin, count).colwise().squaredNorm().transpose();
        }
        const auto mine = A.middleRows(begin, count);
        s.G.push_back(MatrixXd::Zero(A.cols(), A.cols()));
        if (A.cols() > 0) s.G.back().selfadjointView<Eigen::Lower>().rankUpdate(mine.transpose());
        s.g.push_back(mine.transpose() * fold.tau.col(i).segment(begin, count));
      }
    }
  }
  return out;
}

// Mean squared residual of every joint of the least-squares fit of these rows.
VectorXd GeometryProfiler::mean_squares(const std::vector<Own>& own, const Sums& sums,
                                        Eigen::Index columns) const {
  MatrixXd G = MatrixXd::Zero(columns, columns);
  VectorXd g = VectorXd::Zero(columns);
  for (size_t i = 0; i < sums.G.size(); ++i) {
    const std::vector<Eigen::Index>& places = own[i].places;  // ascending: below stays below
    const double w = weights_[static_cast<Eigen::Index>(i)];
    for (size_t c = 0; c < places.size(); ++c) {
      const auto column = sums.G[i].col(c);
      g[places[c]] += w * sums.g[i][static_cast<Eigen::Index>(c)];
      for (size_t r = c; r < places.size(); ++r)
        G(places[r], places[c]) += w * column[static_cast<Eigen::Index>(r)];
    }
  }
  G.triangularView<Eigen::StrictlyUpper>() = G.transpose();
  const VectorXd x = solve_scaled(G, g);
  VectorXd out = sums.b2;
  for (Eigen::Index i = 0; i < out.size(); ++i) {
    const auto at = static_cast<size_t>(i);
    VectorXd mine(own[at].places.size());
    for (Eigen::Index c = 0; c < mine.size(); ++c)
      mine[c] = x[own[at].places[c]];
    const VectorXd Gx = sums.G[at].selfadjointView<Eigen::Lower>() * mine;
    out[i] = std::max(out[i] + mine.dot(Gx) - 2.0 * mine.dot(sums.g[at]), 0.0);
  }
  return out / std::max(1.0, sums.rows);
}

VectorXd GeometryProfiler::mean_squares(const Model& variant,
                                        const std::vector<int>& columns) const {
  const Parts parts = sums_of_parts(variant, columns, 1);
  return mean_squares(parts.own, total(parts.sums), static_cast<Eigen::Index>(columns.size()));
}

}  // namespace veridyn
