#include "diagnosis/causes/geometry.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "veridyn/dynamics/regressor_batch.hpp"
#include "identification/base_solution.hpp"
#include "math/parallel.hpp"

namespace veridyn {
namespace {

constexpr double kSampleRate = 10.0;  // [Hz] enough for the motions of a rigid arm
constexpr double kAngleStep = 0.05;   // [rad] first step of a profile
constexpr double kAngleRange = 0.6;
constexpr double kLengthStep = 0.01;  // [m]
constexpr double kLengthRange = 0.15;
constexpr double kRatioStep = 0.05;
constexpr double kRatioRange = 0.6;
constexpr double kWorthRefining = 0.02;  // fall of the criterion at the first step
constexpr double kSharp = 0.4;           // of the gain: by so much the mirrored value is worse
constexpr int kRefinements = 14;
constexpr size_t kKept = 5;
constexpr double kGolden = 0.381966;
constexpr double kTie = 0.8;  // of the best gain

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
    const VectorXd mean = mean_squares(arm, independent(arm), -1);
    weights_ = mean.array().max(1e-300).inverse();
    start_ = mean_squares(arm, independent(arm), -1).array().max(1e-300).log().sum();
  }

  double start() const { return start_; }

  // Sum over joints of ln(mean square residual); fold `without` left out, or -1.
  double criterion(const Model& variant, const std::vector<int>& columns, int without) const {
    return mean_squares(variant, columns, without).array().max(1e-300).log().sum();
  }

  // Columns that are independent for this geometry.
  static std::vector<int> independent(const Model& variant) {
    return base_parameters(variant).independent;
  }

 private:
  void append(const Stretch& s, Fold& fold) const {
    const auto step =
        std::max<Eigen::Index>(1, static_cast<Eigen::Index>(1.0 / (kSampleRate * s.dt)));
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

  void fill_effects(Fold& fold) const {
    Eigen::Index count = 0;
    for (const EffectTerm& term : arm_.effects())
      count += BoundEffect(arm_, term).parameter_count();
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

  VectorXd mean_squares(const Model& variant, const std::vector<int>& columns, int without) const {
    const RegressorBatch batch(variant);
    const auto k = static_cast<Eigen::Index>(columns.size());
    const auto bodies = static_cast<int>(kBodyParameters * variant.bodies().size());
    std::vector<std::vector<MatrixXd>> A(folds_.size());
    MatrixXd G = MatrixXd::Zero(k, k);
    VectorXd g = VectorXd::Zero(k);
    for (size_t f = 0; f < folds_.size(); ++f) {
      if (static_cast<int>(f) == without) continue;
      std::vector<MatrixXd> Y(static_cast<size_t>(variant.joints()));
      batch.evaluate(folds_[f].q, folds_[f].dq, folds_[f].ddq, Y);
      for (int i = 0; i < variant.joints(); ++i) {
        const auto at = static_cast<size_t>(i);
        const std::vector<int>& mine = batch.columns(i);
        MatrixXd Ai = MatrixXd::Zero(folds_[f].q.rows(), k);
        for (Eigen::Index c = 0; c < k; ++c) {
          const int column = columns[static_cast<size_t>(c)];
          if (column >= bodies) {
            Ai.col(c) = folds_[f].effects[at].col(column - bodies);
            continue;
          }
          const auto found = std::lower_bound(mine.begin(), mine.end(), column);
          if (found != mine.end() && *found == column) Ai.col(c) = Y[at].col(found - mine.begin());
        }
        G.noalias() += weights_[i] * Ai.transpose() * Ai;
        g.noalias() += weights_[i] * Ai.transpose() * folds_[f].tau.col(i);
        A[f].push_back(std::move(Ai));
      }
    }
    const VectorXd scale = G.diagonal().cwiseSqrt().cwiseMax(1e-150).cwiseInverse();
    MatrixXd scaled = scale.asDiagonal() * G * scale.asDiagonal();
    scaled.diagonal().array() += 1e-10;
    const VectorXd x = scale.asDiagonal() * scaled.ldlt().solve(scale.asDiagonal() * g);
    VectorXd sum = VectorXd::Zero(variant.joints());
    double rows = 0.0;
    for (size_t f = 0; f < folds_.size(); ++f) {
      if (A[f].empty()) continue;
      rows += static_cast<double>(folds_[f].q.rows());
      for (int i = 0; i < variant.joints(); ++i)
        sum[i] += (folds_[f].tau.col(i) - A[f][static_cast<size_t>(i)] * x).squaredNorm();
    }
    return sum / std::max(1.0, rows);
  }

  const Model& arm_;
  std::vector<Fold> folds_;
  VectorXd weights_;
  double start_ = 0.0;
};

struct SearchRange {
  double step;
  double reach;
};

SearchRange search_range(const GeometryConstant& c) {
  if (c.kind == GeometryConstant::Kind::kCoefficient)
    return {kRatioStep * std::abs(c.value), kRatioRange * std::abs(c.value)};
  return c.angle ? SearchRange{kAngleStep, kAngleRange} : SearchRange{kLengthStep, kLengthRange};
}

// Golden section on [low, high]; f is smooth with one minimum there.
template <typename F>
double minimum(double low, double high, const F& f) {
  double a = low + kGolden * (high - low);
  double b = high - kGolden * (high - low);
  double fa = f(a);
  double fb = f(b);
  for (int i = 0; i < kRefinements; ++i) {
    if (fa < fb) {
      high = b;
      b = a;
      fb = fa;
      a = low + kGolden * (high - low);
      fa = f(a);
    } else {
      low = a;
      a = b;
      fa = fb;
      b = high - kGolden * (high - low);
      fb = f(b);
    }
  }
  return fa < fb ? a : b;
}

// The profile of one constant; gain 0 if there is nothing in it.
GeometryFinding profile(const Model& arm, const GeometryConstant& constant,
                        const Profiler& profiler, int base, int folds) {
  GeometryFinding out;
  out.constant = constant;
  out.base_before = base;
  const SearchRange range = search_range(constant);
  const double v0 = constant.value;
  const auto columns = Profiler::independent(with_constant(arm, constant, v0 + 0.7 * range.step));
  const auto at = [&](double v, int without) {
    return profiler.criterion(with_constant(arm, constant, v), columns, without);
  };
  const double centre = at(v0, -1);
  const double up = at(v0 + range.step, -1);
  const double down = at(v0 - range.step, -1);
  if (std::min(up, down) > centre - kWorthRefining || (up < centre && down < centre)) return out;
  const double sign = up < down ? 1.0 : -1.0;
  double inner = 0.0;
  double middle = range.step;
  double best = std::min(up, down);
  double outer = 2.0 * range.step;
  for (double next = at(v0 + sign * outer, -1); next < best && outer < range.reach;
       next = at(v0 + sign * outer, -1)) {
    inner = middle;
    middle = outer;
    best = next;
    outer *= 1.6;
  }
  if (outer >= range.reach) return out;  // still falling at the end of the range: no optimum inside
  const auto search = [&](int without) {
    return v0 + sign * minimum(inner, outer, [&](double u) { return at(v0 + sign * u, without); });
  };
  out.found = search(-1);
  out.base_after =
      static_cast<int>(Profiler::independent(with_constant(arm, constant, out.found)).size());
  const double found = at(out.found, -1);
  // More base parameters than the arm as it stands are mere flexibility if the other side of the
  // file's value does nearly as well.
  if (static_cast<int>(columns.size()) > base &&
      at(2.0 * v0 - out.found, -1) - found < kSharp * (profiler.start() - found))
    return out;
  out.gain = profiler.start() - found;
  if (folds < 3) return out;
  VectorXd values(folds);
  for (int f = 0; f < folds; ++f) values[f] = search(f);
  out.deviation =
      std::sqrt((values.array() - values.mean()).square().sum() * (folds - 1.0) / folds);
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
    out.push_back({k, Kind::kTheta, -1, frame.dh->theta, true, "theta" + of});
    out.push_back({k, Kind::kAlpha, -1, frame.dh->alpha, true, "alpha" + of});
    out.push_back({k, Kind::kA, -1, frame.dh->a, false, "a" + of});
    out.push_back({k, Kind::kD, -1, frame.dh->d, false, "d" + of});
    for (int i = 0; i < arm.joints(); ++i) {
      const double c = frame.variable.coefficients[i];
      if (c == 0.0 || std::abs(c) == 1.0) continue;
      out.push_back({k, Kind::kCoefficient, i, c, false,
                     "ratio of " + arm.coordinates()[static_cast<size_t>(i)].name + " in frame " +
                         frame.name});
    }
  }
  return out;
}

Model with_constant(const Model& arm, const GeometryConstant& constant, double value) {
  using Kind = GeometryConstant::Kind;
  ModelDescription d = arm.description();
  Frame& frame = d.frames[static_cast<size_t>(constant.frame)];
  DhRow row = *frame.dh;
  if (constant.kind == Kind::kA) row.a = value;
  if (constant.kind == Kind::kAlpha) row.alpha = value;
  if (constant.kind == Kind::kD) row.d = value;
  if (constant.kind == Kind::kTheta) row.theta = value;
  if (constant.kind == Kind::kCoefficient) frame.variable.coefficients[constant.coordinate] = value;
  frame.variable.offset = 0.0;
  place(frame, row);
  return Model(std::move(d));
}

std::vector<GeometryFinding> profile_geometry(const Model& arm,
                                              const std::vector<std::string>& train,
                                              const IdentificationOptions& options) {
  const Profiler profiler(arm, train, options);
  const std::vector<GeometryConstant> constants = geometry_constants(arm);
  const auto base = static_cast<int>(Profiler::independent(arm).size());
  std::vector<GeometryFinding> all(constants.size());
  parallel_for(static_cast<int>(constants.size()), options.threads, [&](int k) {
    all[static_cast<size_t>(k)] = profile(arm, constants[static_cast<size_t>(k)], profiler, base,
                                          static_cast<int>(train.size()));
  });
  all.erase(std::remove_if(all.begin(), all.end(),
                           [](const GeometryFinding& f) { return f.gain < kWorthRefining; }),
            all.end());
  std::sort(all.begin(), all.end(),
            [](const GeometryFinding& a, const GeometryFinding& b) { return a.gain > b.gain; });
  if (all.size() > kKept) all.resize(kKept);
  if (all.empty()) return all;
  // An angle between two branches may be wrong in either. The longest chain ends in the tool, where
  // everyone would see it; the other branch goes first.
  const std::vector<char> main_chain = longest_chain(arm);
  const double tie = kTie * all.front().gain;
  std::stable_sort(all.begin(), all.end(), [&](const GeometryFinding& a, const GeometryFinding& b) {
    const bool tied = a.gain > tie && b.gain > tie;
    if (!tied) return a.gain > b.gain;
    return main_chain[static_cast<size_t>(a.constant.frame)] <
           main_chain[static_cast<size_t>(b.constant.frame)];
  });
  return all;
}

}  // namespace veridyn
