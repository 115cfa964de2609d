#include "diagnosis/search/options.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <utility>

#include "diagnosis/load_fit.hpp"
#include "diagnosis/search/numbers.hpp"
#include "math/parallel.hpp"

namespace veridyn::search {
namespace {

// True unless the torque mostly has an impossible sign, or the sign of a factor would turn around.
bool is_possible(const Term& t, const Columns& columns, const VectorXd& z) {
  VectorXd size = VectorXd::Zero(z.size());
  for (const MatrixXd& of : columns.of) size += of.colwise().squaredNorm().transpose();
  Eigen::Index largest = 0;
  size.cwiseProduct(z.cwiseAbs2()).maxCoeff(&largest);
  const auto is_impossible = [&](const Level& level) { return level.column == largest && level.own + z[largest] < 0.0; };
  if (std::any_of(t.nonnegative.begin(), t.nonnegative.end(), is_impossible)) return false;
  return !is_factor(t) || z[0] > kGainOfNothing;
}

}  // namespace

Option Options::option(const Round& round, const Subset& s, const Term& term) const {
  return option(round, s, beside(round, term, std::make_shared<Columns>(columns_of(term, at_.rows()))));
}

Option Options::option(const Round& round, const Subset& s, const Beside& one) {
  Option out;
  out.term = one.term;
  out.columns = one.columns;
  out.ridge = one.cross.ridge;
  out.fit = round.evaluate(s, &one.cross);
  if (is_possible(one.term, *one.columns, out.fit.x.tail(one.columns->count()))) out.value = out.fit.score + one.term.price;
  return out;
}

// Improves the shape near the present one: golden sections for each constant, between its neighbours in the
// grid.
void Options::polish(const Round& round, const Subset& s, Option& best) const {
  if (best.term.kind == TermKind::kLoad) return polish_load(round, s, best);
  for (int turn = 0; turn < (best.term.shapes.size() > 1 ? 2 : 1); ++turn) {
    for (size_t d = 0; d < best.term.shapes.size(); ++d) {
      const TermShape shape = best.term.shapes[d];
      if (shape.fixed) continue;
      const double centre = best.term.effect.values.at(shape.name);
      const double reach = turn == 0 ? 1.0 : 0.5;
      const auto at = [&](double u) {
        const double value = shape.logarithmic ? centre * std::pow(shape.step, u) : centre + shape.step * u;
        Option out = best;
        out.term.effect.values[shape.name] = std::clamp(value, shape.lower, shape.upper);
        return option(round, s, out.term);
      };
      double low = -reach, high = reach;
      Option a = at(low + kSearchGolden * (high - low)), b = at(high - kSearchGolden * (high - low));
      for (int k = 0; k < kSections; ++k) {
        if (a.value < b.value) {
          high -= kSearchGolden * (high - low);
          b = std::move(a);
          a = at(low + kSearchGolden * (high - low));
        } else {
          low += kSearchGolden * (high - low);
          a = std::move(b);
          b = at(high - kSearchGolden * (high - low));
        }
      }
      Option& better = a.value < b.value ? a : b;
      if (better.value < best.value) best = std::move(better);
    }
  }
}

// Puts a point mass in place of ten free parameters: its inertia follows from mass and centre. The prior of the centre is
// part of the value, so that of links with equal torque the one nearest to the load carries it.
void Options::polish_load(const Round& round, const Subset& s, Option& best) const {
  const auto [A, b] = round.normal_equations(s, beside(round, best.term, best.columns).cross);
  const MassCost cost(A, b, kReach);
  const PlacedMass load = cost.fit();
  Term t = best.term;
  t.centre = load.com;
  t.mass = load.mass;
  best = option(round, s, t);
  best.value += 0.5 * load.com.squaredNorm() / (kReach * kReach);
  if (load.mass == 0.0 || cost.at_bound(load)) best.value = std::numeric_limits<double>::infinity();
}

Beside Options::beside(const Round& round, const Term& term, std::shared_ptr<const Columns> columns) const {
  Cross cross = round.cross(*columns, at_.ridge_of(term, columns->count(), round.scale()));
  return {term, std::move(columns), std::move(cross)};
}

std::vector<Beside> Options::beside(const Round& round, const std::vector<Term>& some) const {
  std::vector<Beside> out(some.size());
  parallel_for(static_cast<int>(some.size()), request_.threads, [&](int k) {
    out[k] = beside(round, some[k], std::make_shared<Columns>(columns_of(some[k], at_.rows())));
  });
  return out;
}

// The best terms in place of the last one of the set, one of each cause, with polished shapes.
std::vector<Option> Options::best_terms(const Round& round, const Subset& s, const std::vector<Beside>& all, double needed,
                                        const Asked& is_asked) const {
  struct Screened {
    double value = 0.0;
    const Beside* of = nullptr;
  };
  std::map<std::string, Screened> by_place;
  for (const Beside& one : all) {
    if (!is_asked(one.term)) continue;
    const double gain = round.training_gain(s, one.cross) - one.term.price - 0.5 * static_cast<double>(one.columns->count());
    if (gain + one.term.price <= kWorthPolish * needed) continue;
    Screened& best = by_place[one.term.place];
    if (best.of == nullptr || gain > best.value) best = {gain, &one};
  }
  std::vector<Screened> order;
  for (auto& [place, one] : by_place) order.push_back(one);
  std::sort(order.begin(), order.end(), [](const Screened& a, const Screened& b) { return a.value > b.value; });
  order.resize(std::min<size_t>(order.size(), kScreened));
  std::vector<Option> out(order.size());
  parallel_for(static_cast<int>(order.size()), request_.threads, [&](int k) { out[k] = option(round, s, *order[k].of); });
  const auto better = [](const Option& a, const Option& b) { return a.value < b.value; };
  // Terms with a gain in few blocks only are compared after those with a gain in all.
  const Fitted without = round.evaluate(s);
  out.erase(std::remove_if(out.begin(), out.end(), [&](const Option& o) {
              const Gain g = round.gain(o.fit, without);
              return without.score - o.value + o.term.price < kWorthPolish * needed || g.sum < kWorthPolish * g.limit;
            }), out.end());
  std::sort(out.begin(), out.end(), better);
  out.resize(std::min<size_t>(out.size(), kFinalists));
  parallel_for(static_cast<int>(out.size()), request_.threads, [&](int k) {
    if (std::isfinite(out[k].value)) polish(round, s, out[k]);
  });
  std::sort(out.begin(), out.end(), better);
  return out;
}

std::vector<Beside> Options::dictionary(const Round& round, const Asked& is_asked) {
  std::vector<size_t> some;
  for (size_t k = 0; k < at_.dictionary().size(); ++k) {
    if (is_asked(at_.dictionary()[k])) some.push_back(k);
  }
  std::vector<Beside> out(some.size());
  parallel_for(static_cast<int>(some.size()), request_.threads, [&](int k) {
    out[k] = beside(round, at_.dictionary()[some[k]], at_.columns_at(some[k]));
  });
  return out;
}

std::vector<Beside> Options::ripples(const Round& round, const MatrixXd& residual) const {
  std::vector<Term> some = search::ripples(at_.rows(), residual, at_.dictionary(), request_.threads);
  some.erase(std::remove_if(some.begin(), some.end(), [&](const Term& t) { return !request_.scope.is_wanted(at_.rows().arm(), t.cause) || request_.scope.silent.count(t.joint->value) != 0; }), some.end());
  return beside(round, some);
}

// Directions of gravity far from that of the file, and its absence: derivatives at the file's direction do
// not lead there.
std::vector<Option> Options::far_gravities(const Round& now, const Fitted& fit) {
  std::vector<Option> out;
  const Term* tilt = nullptr;
  for (const Term& t : at_.dictionary()) {
    if (is_tilt(t)) tilt = &t;
  }
  const Eigen::Vector3d own = at_.gravity();
  const double g = own.norm();
  if (tilt == nullptr || g == 0.0) return out;
  std::vector<Eigen::Vector3d> all = {Eigen::Vector3d::Zero()};
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {1.0, -1.0}) all.push_back(sign * g * Eigen::Vector3d::Unit(axis));
  }
  const Present::State state = at_.kept();
  for (const Eigen::Vector3d& gravity : all) {
    if ((gravity - own).norm() < kFarGravity * g) continue;
    ModelDescription d = at_.rows().arm().description();
    d.gravity = gravity;
    if (!at_.move_to(Model(std::move(d)))) continue;
    const Round then = at_.round();
    Option o;
    o.term = *tilt;
    // The absence of gravity costs as much as any direction of which the joints feel nothing.
    if (gravity != Eigen::Vector3d::Zero()) o.term.price += std::log(static_cast<double>(all.size()));
    o.fit = then.fit();
    const Gain gain = now.gain(o.fit, fit);
    o.value = fit.score - gain.sum + o.term.price;
    o.columns = std::make_shared<Columns>(columns_of(o.term, at_.rows()));
    o.ridge = VectorXd::Constant(o.columns->count(), kNoMass);
    o.gravity = gravity;
    at_.restore(state);
    if (o.value < fit.score) out.push_back(std::move(o));
  }
  return out;
}

}  // namespace veridyn::search
