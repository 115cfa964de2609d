#include "diagnosis/causes/geometry.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "diagnosis/evidence/clustered_fit.hpp"
#include "diagnosis/numerics.hpp"

#include "effects/kinematic_error.hpp"
#include "veridyn/dynamics/regressor_batch.hpp"
#include "identification/base_solution.hpp"
#include "math/parallel.hpp"
#include "math/student_t.hpp"

namespace veridyn {
namespace {

// First step and reach of a profile, for angles, lengths and ratios.
struct SearchRange {
  double step;
  double reach;
};
constexpr SearchRange kAngles = {numerics::kAngleStep, numerics::kAngleReach};     // [rad]
constexpr SearchRange kLengths = {numerics::kLengthStep, numerics::kLengthReach};  // [m]
constexpr SearchRange kRatios = {numerics::kAngleStep, numerics::kAngleReach};     // of the ratio

constexpr int kRefinements = 14;
constexpr size_t kKept = 5;
constexpr Eigen::Index kParts = 8;       // of a recording, for the scatter of a constant
constexpr Eigen::Index kMostParts = 64;  // of all: they are in memory together

Eigen::Index parts_of_each(Eigen::Index recordings) {
  return std::clamp<Eigen::Index>(kMostParts / std::max<Eigen::Index>(1, recordings), 1, kParts);
}

// Sparse samples of one recording, with what does not depend on geometry computed once.
struct Fold {
  MatrixXd q, dq, ddq;
  MatrixXd tau;
  std::vector<MatrixXd>
      effects;  // per joint: columns of the model's effects, zero where another joint's
};

class Profiler {
 public:
  Profiler(const Model& arm, const std::vector<std::string>& train,
           const IdentificationOptions& options)
      : arm_(arm) {
    PreprocessingOptions how = options.preprocessing;
    how.filtering = Filtering::kSignals;
    for (const std::string& path : train) {
      Fold fold;
      for_each_stretch(arm, path, how, [&](const Stretch& s) { append(s, fold); });
      fill_effects(fold);
      folds_.push_back(std::move(fold));
    }
    weights_ = VectorXd::Ones(arm.joints());
    const std::vector<int> columns = independent(arm);
    weights_ = mean_squares(arm, columns).array().max(numerics::kTiny).inverse();
    start_ = criterion(arm, columns);
  }

  double start() const { return start_; }

  // Sum over joints of ln(mean square residual).
  double criterion(const Model& variant, const std::vector<int>& columns) const {
    return log_of(mean_squares(variant, columns));
  }

  // The criterion of three variants without one part each, (parts x 3).
  MatrixXd without_parts(const std::array<Model, 3>& variants,
                         const std::vector<int>& columns) const {
    MatrixXd out;
    for (size_t v = 0; v < variants.size(); ++v) {
      const Parts parts = sums_of_parts(variants[v], columns, parts_of_each(recordings()));
      const Sums all = total(parts.sums);
      out.conservativeResize(static_cast<Eigen::Index>(parts.sums.size()), 3);
      for (size_t k = 0; k < parts.sums.size(); ++k) {
        Sums rest = all;
        add(-1.0, parts.sums[k], rest);
        out(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(v)) = log_of(
            mean_squares(parts.own, rest, static_cast<Eigen::Index>(columns.size())));
      }
    }
    return out;
  }

  int recordings() const { return static_cast<int>(folds_.size()); }

  // Columns that are independent for this geometry.
  static std::vector<int> independent(const Model& variant) {
    return base_parameters(variant).independent;
  }

 private:
  static double log_of(const VectorXd& mean_squares) {
    return mean_squares.array().max(numerics::kTiny).log().sum();
  }

  void append(const Stretch& s, Fold& fold) const {
    const auto step =
        std::max<Eigen::Index>(1, static_cast<Eigen::Index>(1.0 / (numerics::kGeometryRate * s.dt)));
    std::vector<Eigen::Index> kept;
    for (Eigen::Index k = s.core_begin; k < s.core_end; ++k) {
      if (s.use[static_cast<size_t>(k)] != 0 && k % step == 0) kept.push_back(k);
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
  }

  void fill_effects(Fold& fold) {
    acts_on_.clear();
    for (const EffectTerm& term : arm_.effects())
      acts_on_.insert(acts_on_.end(), static_cast<size_t>(BoundEffect(arm_, term).parameter_count()),
                      term.axis.coefficients);
    const auto count = static_cast<Eigen::Index>(acts_on_.size());
    fold.effects.assign(static_cast<size_t>(arm_.joints()), MatrixXd::Zero(fold.q.rows(), count));
    Eigen::Index at = 0;
    for (const EffectTerm& term : arm_.effects()) {
      BoundEffect effect(arm_, term);
      EffectColumns row{};
      for (Eigen::Index k = 0; k < fold.q.rows(); ++k) {
        effect.columns(effect.sample(0.0, fold.q.data() + k, fold.dq.data() + k,
                                     fold.ddq.data() + k, fold.q.rows()),
                       row);
        for (int c = 0; c < effect.parameter_count(); ++c) {
          for (int i = 0; i < arm_.joints(); ++i)
            fold.effects[static_cast<size_t>(i)](k, at + c) = row[c] * term.axis.coefficients[i];
        }
      }
      at += effect.parameter_count();
    }
  }

  // Which columns act on a joint: their places among all, and where they come from.
  struct Own {
    std::vector<Eigen::Index> places;
    std::vector<Eigen::Index> from;  // of the batch's columns of this joint; of the effects below 0
  };

  std::vector<Own> own_columns(const RegressorBatch& batch, const std::vector<int>& columns,
                               int bodies, int joints) const {
    std::vector<Own> out(static_cast<size_t>(joints));
    for (int i = 0; i < joints; ++i) {
      Own& own = out[static_cast<size_t>(i)];
      const std::vector<int>& mine = batch.columns(i);
      for (size_t c = 0; c < columns.size(); ++c) {
        const bool effect = columns[c] >= bodies;
        const auto found = std::lower_bound(mine.begin(), mine.end(), columns[c]);
        if (effect ? acts_on_[static_cast<size_t>(columns[c] - bodies)][i] == 0.0
                   : found == mine.end() || *found != columns[c])
          continue;
        own.places.push_back(static_cast<Eigen::Index>(c));
        own.from.push_back(effect ? -1 - (columns[c] - bodies) : found - mine.begin());
      }
    }
    return out;
  }

  // Normal equations of one part of one recording: of every joint, over its own columns (below the
  // diagonal).
  struct Sums {
    std::vector<MatrixXd> G;
    std::vector<VectorXd> g;
    VectorXd b2;
    double rows = 0.0;
  };

  struct Parts {
    std::vector<Own> own;
    std::vector<Sums> sums;
  };

  static void add(double sign, const Sums& from, Sums& to) {
    for (size_t i = 0; i < to.G.size(); ++i) {
      to.G[i] += sign * from.G[i];
      to.g[i] += sign * from.g[i];
    }
    to.b2 += sign * from.b2;
    to.rows += sign * from.rows;
  }

  // Of every recording in so many parts of equal duration.
  Parts sums_of_parts(const Model& variant, const std::vector<int>& columns,
                      Eigen::Index parts) const {
    const RegressorBatch batch(variant);
    const auto bodies = static_cast<int>(kBodyParameters * variant.bodies().size());
    const int n = variant.joints();
    Parts out{own_columns(batch, columns, bodies, n), {}};
    for (const Fold& fold : folds_) {
      std::vector<MatrixXd> Y(static_cast<size_t>(n));
      batch.evaluate(fold.q, fold.dq, fold.ddq, Y);
      const size_t first = out.sums.size();
      const Eigen::Index rows = fold.q.rows();
      out.sums.resize(first + static_cast<size_t>(parts));
      for (int i = 0; i < n; ++i) {
        const auto at = static_cast<size_t>(i);
        const Own& own = out.own[at];
        MatrixXd A(rows, static_cast<Eigen::Index>(own.from.size()));
        for (Eigen::Index c = 0; c < A.cols(); ++c) {
          const Eigen::Index from = own.from[static_cast<size_t>(c)];
          if (from < 0) A.col(c) = fold.effects[at].col(-1 - from);
          else A.col(c) = Y[at].col(from);
        }
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
  VectorXd mean_squares(const std::vector<Own>& own, const Sums& sums,
                        Eigen::Index columns) const {
    MatrixXd G = MatrixXd::Zero(columns, columns);
    VectorXd g = VectorXd::Zero(columns);
    for (size_t i = 0; i < sums.G.size(); ++i) {
      const std::vector<Eigen::Index>& places = own[i].places;  // ascending: below stays below
      const double w = weights_[static_cast<Eigen::Index>(i)];
      for (size_t c = 0; c < places.size(); ++c) {
        const auto column = sums.G[i].col(static_cast<Eigen::Index>(c));
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
      VectorXd mine(static_cast<Eigen::Index>(own[at].places.size()));
      for (Eigen::Index c = 0; c < mine.size(); ++c) mine[c] = x[own[at].places[static_cast<size_t>(c)]];
      const VectorXd Gx = sums.G[at].selfadjointView<Eigen::Lower>() * mine;
      out[i] = std::max(out[i] + mine.dot(Gx) - 2.0 * mine.dot(sums.g[at]), 0.0);
    }
    return out / std::max(1.0, sums.rows);
  }

  VectorXd mean_squares(const Model& variant, const std::vector<int>& columns) const {
    const Parts parts = sums_of_parts(variant, columns, 1);
    return mean_squares(parts.own, total(parts.sums), static_cast<Eigen::Index>(columns.size()));
  }

  static Sums total(const std::vector<Sums>& parts) {
    Sums out = parts.front();
    for (size_t k = 1; k < parts.size(); ++k) add(1.0, parts[k], out);
    return out;
  }

  const Model& arm_;
  std::vector<Fold> folds_;
  std::vector<VectorXd> acts_on_;  // of every effect column: the coefficients of its axis
  VectorXd weights_;
  double start_ = 0.0;
};

SearchRange search_range(const GeometryConstant& c) {
  if (c.kind == GeometryConstant::Kind::kCoefficient)
    return {kRatios.step * std::abs(c.value), kRatios.reach * std::abs(c.value)};
  return c.angle ? kAngles : kLengths;
}

// Golden section on [low, high]; f is smooth with one minimum there.
template <typename F>
double minimum(double low, double high, const F& f) {
  double a = low + numerics::kGolden * (high - low);
  double b = high - numerics::kGolden * (high - low);
  double fa = f(a);
  double fb = f(b);
  for (int i = 0; i < kRefinements; ++i) {
    if (fa < fb) {
      high = b;
      b = a;
      fb = fa;
      a = low + numerics::kGolden * (high - low);
      fa = f(a);
    } else {
      low = a;
      a = b;
      fa = fb;
      b = high - numerics::kGolden * (high - low);
      fb = f(b);
    }
  }
  return fa < fb ? a : b;
}

// Scatter of an optimum: the least point of a parabola through three values of the constant, with
// one part of the recordings left out each; the larger of that and of whole recordings.
void measure_scatter(const Model& arm, const Profiler& profiler, const std::vector<int>& columns,
                     double step, GeometryFinding& out) {
  const std::array<Model, 3> variants = {with_constant(arm, out.constant, out.found - step),
                                         with_constant(arm, out.constant, out.found),
                                         with_constant(arm, out.constant, out.found + step)};
  const MatrixXd y = profiler.without_parts(variants, columns);
  MatrixXd least(1, y.rows());
  for (Eigen::Index k = 0; k < y.rows(); ++k) {
    const double bend = y(k, 0) - 2.0 * y(k, 1) + y(k, 2);
    const double shift = bend > 0.0 ? 0.5 * (y(k, 0) - y(k, 2)) / bend : 0.0;
    least(0, k) = out.found + step * std::clamp(shift, -1.0, 1.0);
  }
  out.deviation = jackknife_deviations(least)[0];
  out.degrees_of_freedom = static_cast<double>(y.rows() - 1);
  const int recordings = profiler.recordings();
  if (recordings < 3) return;
  // Parts of one recording share what is systematic to it. Leaving a whole one out moves the
  // optimum by the sum of its parts' shares, to first order.
  const Eigen::Index parts = y.rows() / recordings;
  MatrixXd whole(1, recordings);
  for (int r = 0; r < recordings; ++r) {
    whole(0, r) = out.found;
    for (Eigen::Index k = 0; k < parts; ++k)
      whole(0, r) += least(0, r * parts + k) - out.found;
  }
  const double of_recordings = jackknife_deviations(whole)[0];
  const double wider = student_t_quantile(numerics::kOutside, recordings - 1.0) /
                       student_t_quantile(numerics::kOutside, out.degrees_of_freedom);
  out.deviation = std::max(out.deviation, wider * of_recordings);
}

// The profile of one constant; gain 0 if there is nothing in it.
GeometryFinding profile(const Model& arm, const GeometryConstant& constant,
                        const Profiler& profiler, int base, const Thresholds& limits) {
  GeometryFinding out;
  out.constant = constant;
  out.base_before = base;
  const SearchRange range = search_range(constant);
  const double v0 = constant.value;
  const auto columns =
      Profiler::independent(with_constant(arm, constant, v0 + numerics::kOffCentre * range.step));
  const auto at = [&](double v) {
    return profiler.criterion(with_constant(arm, constant, v), columns);
  };
  // Columns that are independent beside the file's value may vanish at it, and others in their place
  // not: there the arm as it stands is the measure.
  const double centre = std::min(at(v0), profiler.start());
  const double up = at(v0 + range.step);
  const double down = at(v0 - range.step);
  if (std::min(up, down) > centre - 0.5 * limits.smallest_gain || (up < centre && down < centre))
    return out;
  const double sign = up < down ? 1.0 : -1.0;
  double inner = 0.0;
  double middle = range.step;
  double best = std::min(up, down);
  double outer = 2.0 * range.step;
  for (double next = at(v0 + sign * outer); next < best && outer < range.reach;
       next = at(v0 + sign * outer)) {
    inner = middle;
    middle = outer;
    best = next;
    outer *= numerics::kBracketGrowth;
  }
  if (outer >= range.reach) return out;  // still falling at the end of the range: no optimum inside
  out.found =
      v0 + sign * minimum(inner, outer, [&](double u) { return at(v0 + sign * u); });
  out.base_after =
      static_cast<int>(Profiler::independent(with_constant(arm, constant, out.found)).size());
  const double found = at(out.found);
  // More base parameters than the arm as it stands are mere flexibility if the other side of the
  // file's value does nearly as well.
  if (static_cast<int>(columns.size()) > base &&
      at(2.0 * v0 - out.found) - found < limits.constant_sharpness * (profiler.start() - found))
    return out;
  out.gain = profiler.start() - found;
  measure_scatter(arm, profiler, columns, 0.5 * range.step, out);
  return out;
}

// Frames between the world and the frame with the most joints above it.
std::vector<char> longest_chain(const Model& arm) {
  std::vector<int> depth(arm.frames().size(), 0);
  size_t last = 0;
  for (size_t k = 0; k < depth.size(); ++k) {
    const Frame& frame = arm.frames()[k];
    depth[k] = (frame.parent < 0 ? 0 : depth[static_cast<size_t>(frame.parent)]) +
               static_cast<int>(frame.type != JointType::kFixed);
    if (depth[k] > depth[last]) last = k;
  }
  std::vector<char> out(depth.size(), 0);
  for (int k = static_cast<int>(last); k >= 0; k = arm.frames()[static_cast<size_t>(k)].parent)
    out[static_cast<size_t>(k)] = 1;
  return out;
}

}  // namespace

std::vector<GeometryConstant> geometry_constants(const Model& arm) {
  using Kind = GeometryConstant::Kind;
  std::vector<GeometryConstant> out;
  std::vector<char> carries(arm.frames().size(), 0);
  for (int k = static_cast<int>(arm.frames().size()) - 1; k >= 0; --k) {
    const Frame& frame = arm.frames()[static_cast<size_t>(k)];
    if (frame.body) carries[static_cast<size_t>(k)] = 1;
    if (carries[static_cast<size_t>(k)] != 0 && frame.parent >= 0)
      carries[static_cast<size_t>(frame.parent)] = 1;
  }
  for (int k = 0; k < static_cast<int>(arm.frames().size()); ++k) {
    const Frame& frame = arm.frames()[static_cast<size_t>(k)];
    if (!frame.dh || carries[static_cast<size_t>(k)] == 0) continue;
    const std::string of = " of frame " + frame.name;
    out.push_back({k, Kind::kTheta, frame.dh->theta, true, "theta", "theta" + of});
    out.push_back({k, Kind::kAlpha, frame.dh->alpha, true, "alpha", "alpha" + of});
    out.push_back({k, Kind::kA, frame.dh->a, false, "a", "a" + of});
    out.push_back({k, Kind::kD, frame.dh->d, false, "d", "d" + of});
    for (int i = 0; i < arm.joints(); ++i) {
      const double c = frame.variable.coefficients[i];
      if (c == 0.0 || std::abs(c) == 1.0) continue;
      const std::string ratio = "ratio of " + arm.coordinates()[static_cast<size_t>(i)].name;
      out.push_back({k, Kind::kCoefficient, c, false, ratio, ratio + " in frame " + frame.name});
    }
  }
  return out;
}

Model with_constant(const Model& arm, const GeometryConstant& constant, double value) {
  ModelDescription d = arm.description();
  set_value({constant.name, FrameIndex{constant.frame}}, value, d);
  return Model(std::move(d));
}

std::vector<GeometryFinding> profile_geometry(const Model& arm,
                                              const std::vector<std::string>& train,
                                              const IdentificationOptions& options,
                                              const Thresholds& limits) {
  const Profiler profiler(arm, train, options);
  const std::vector<GeometryConstant> constants = geometry_constants(arm);
  const auto base = static_cast<int>(Profiler::independent(arm).size());
  std::vector<GeometryFinding> all(constants.size());
  parallel_for(static_cast<int>(constants.size()), options.threads, [&](int k) {
    all[static_cast<size_t>(k)] =
        profile(arm, constants[static_cast<size_t>(k)], profiler, base, limits);
  });
  all.erase(std::remove_if(all.begin(), all.end(),
                           [&limits](const GeometryFinding& f) { return f.gain < 0.5 * limits.smallest_gain; }),
            all.end());
  std::sort(all.begin(), all.end(),
            [](const GeometryFinding& a, const GeometryFinding& b) { return a.gain > b.gain; });
  if (all.size() > kKept) all.resize(kKept);
  if (all.empty()) return all;
  // An angle between two branches may be wrong in either. The longest chain ends in the tool, where
  // everyone would see it; the other branch goes first.
  const std::vector<char> main_chain = longest_chain(arm);
  const double tie = limits.rival_share * all.front().gain;
  std::stable_sort(all.begin(), all.end(), [&](const GeometryFinding& a, const GeometryFinding& b) {
    const bool tied = a.gain > tie && b.gain > tie;
    if (!tied) return a.gain > b.gain;
    return main_chain[static_cast<size_t>(a.constant.frame)] <
           main_chain[static_cast<size_t>(b.constant.frame)];
  });
  return all;
}

}  // namespace veridyn
