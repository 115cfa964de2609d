#include <fmt/format.h>

#include <cmath>
#include <set>

#include "identification/estimation/additive_regression.hpp"
#include "hide_and_seek/draw.hpp"
#include "hide_and_seek/swept_room.hpp"

namespace veridyn::seek {
namespace {

constexpr int kSignals = 5, kFolds = 6, kRows = 900;
constexpr double kNear = 0.1;  // largest error of the curves on new rows, rms; the noise has 0.58

// A response beside noise, and the signals that it is a function of.
struct Curve {
  const char* name;
  std::set<int> signals;
  double (*response)(const double* x);
  double apart = 1.0;  // of signals 0 and 1; below 1 they go together
};

const std::vector<Curve>& curves() {
  static const std::vector<Curve> kAll = {
      {"nothing", {}, [](const double*) { return 0.0; }},
      {"nothing beside signals that go together", {}, [](const double*) { return 0.0; }, 0.01},
      {"a straight line", {1}, [](const double* x) { return x[1]; }},
      {"a wave", {4}, [](const double* x) { return std::sin(4.0 * x[4]); }},
      {"a fast wave", {4}, [](const double* x) { return std::sin(9.0 * x[4]); }},
      {"an end stop", {2}, [](const double* x) { return 8.0 * std::pow(std::max(0.0, x[2] - 0.4), 2); }},
      {"an end stop and a wave", {2, 4},
       [](const double* x) { return 8.0 * std::pow(std::max(0.0, x[2] - 0.4), 2) + std::sin(4.0 * x[4]); }},
      {"three curves", {0, 2, 3}, [](const double* x) { return x[0] * x[0] + std::sin(3.0 * x[2]) + std::abs(x[3]); }},
      {"a wave of signals that go together", {0}, [](const double* x) { return std::sin(4.0 * x[0]); }, 0.01},
      {"the difference of signals that go together", {},
       [](const double* x) { return 100.0 * (x[1] - x[0]); }, 0.01},
      {"a small wave", {3}, [](const double* x) { return 0.4 * std::sin(4.0 * x[3]); }}};
  return kAll;
}

struct Rows {
  FoldedRows folded;
  VectorXd truth;
};

Rows rows_of(const Curve& curve, unsigned seed) {
  Draw draw(seed, curve.name);
  Rows out;
  out.folded.signals.resize(kRows, kSignals);
  out.folded.response.resize(kRows);
  out.truth.resize(kRows);
  for (int r = 0; r < kRows; ++r) {
    double x[kSignals];
    for (double& one : x) one = draw.in(-1.0, 1.0);
    if (curve.apart < 1.0) x[1] = x[0] + curve.apart * x[1];
    for (int s = 0; s < kSignals; ++s) out.folded.signals(r, s) = x[s];
    out.truth[r] = curve.response(x);
    out.folded.response[r] = out.truth[r] + draw.in(-1.0, 1.0);
  }
  for (int f = 0; f <= kFolds; ++f) out.folded.fold_begin.push_back(f * kRows / kFolds);
  return out;
}

TableCase<EstimationNumbers> case_of(const Curve& curve, unsigned seed) {
  std::vector<SmoothTerm> terms;
  for (int s = 0; s < kSignals; ++s) terms.push_back({{s}, {SmoothBasis(BasisKind::kSmooth, -1.0, 1.0, 10, 0.02)}, 1.0});
  const Rows train = rows_of(curve, seed), test = rows_of(curve, seed + 1);
  return {curve.name, [curve, terms, train, test](const EstimationNumbers& numbers) {
            std::vector<MatrixXd> columns;
            for (const SmoothTerm& term : terms) columns.push_back(term.columns(train.folded.signals));
            const AdditiveModel model = additive_regression(train.folded, terms, columns, {4, 0.05, 0.9, 0.05}, numbers);
            std::set<int> found;
            std::string said;
            for (const ChosenTerm& one : model.chosen) {
              found.insert(one.term);
              said += fmt::format("signal {} {:g} ", one.term, one.smoothing / numbers.least_smoothing);
            }
            VectorXd error = -test.truth;
            if (!model.chosen.empty()) error += predicted(model, terms, test.folded.signals);
            const bool near = error.norm() <= kNear * std::sqrt(static_cast<double>(kRows));
            return SweepAnswer{found == curve.signals && (near || curve.signals.empty()), said + (near ? "near" : "off")};
          }};
}

}  // namespace

SweptRoom estimation_room(unsigned seed) {
  std::vector<TableCase<EstimationNumbers>> cases;
  for (const Curve& curve : curves()) cases.push_back(case_of(curve, seed));
  return room_of(estimation_numbers(), cases);
}

}  // namespace veridyn::seek
