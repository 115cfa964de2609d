#include "diagnosis/search/exchanges.hpp"

#include <Eigen/LU>
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
  return !is_factor(t) || z[0] > kSignReversingGain;
}

}  // namespace

Exchange Exchanges::exchange_with(const Round& round, const Subset& s, const Term& term) const {
  return exchange_with(round, s, products_of(round, term, std::make_shared<Columns>(columns_of(term, current_.rows()))));
}

Exchange Exchanges::exchange_with(const Round& round, const Subset& s, const TermProducts& one) {
  Exchange out;
  out.term = one.term;
  out.columns = one.columns;
  out.ridge = one.cross.ridge;
  out.fit = round.evaluate(s, &one.cross);
  if (is_possible(one.term, *one.columns, out.fit.x.tail(one.columns->count()))) out.value = out.fit.score + one.term.price;
  return out;
}

// Improves the shape constants of a term by golden sections, each between its neighbours in the grid.
void Exchanges::polish_shapes(const Round& round, const Subset& s, Exchange& best) const {
  if (best.term.kind == TermKind::kLoad) return polish_load(round, s, best);
  for (int turn = 0; turn < (best.term.shapes.size() > 1 ? 2 : 1); ++turn) {
    for (size_t d = 0; d < best.term.shapes.size(); ++d) {
      const TermShape shape = best.term.shapes[d];
      if (shape.fixed) continue;
      const double centre = best.term.effect.values.at(shape.name);
      const double reach = turn == 0 ? 1.0 : 0.5;
      const auto at = [&](double u) {
        const double value = shape.logarithmic ? centre * std::pow(shape.step, u) : centre + shape.step * u;
        Exchange out = best;
        out.term.effect.values[shape.name] = std::clamp(value, shape.lower, shape.upper);
        return exchange_with(round, s, out.term);
      };
      double low = -reach, high = reach;
      Exchange a = at(low + kSearchGolden * (high - low)), b = at(high - kSearchGolden * (high - low));
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
      Exchange& better = a.value < b.value ? a : b;
      if (better.value < best.value) best = std::move(better);
    }
  }
}

// Puts a point mass in place of ten free parameters: its inertia follows from mass and centre. The prior of the centre is
// part of the value, so that of links with equal torque the one nearest to the load carries it.
void Exchanges::polish_load(const Round& round, const Subset& s, Exchange& best) const {
  const auto [A, b] = round.normal_equations(s, products_of(round, best.term, best.columns).cross);
  // The columns are those of the coefficients about the term's present centre.
  const MatrixXd coefficients = load_parameters(best.term.centre).inverse();
  const MassCost cost(coefficients.transpose() * A * coefficients, coefficients.transpose() * b, kReach);
  const PlacedMass load = cost.fit();
  Term t = best.term;
  t.centre = load.com;
  t.mass = load.mass;
  best = exchange_with(round, s, t);
  best.value += 0.5 * load.com.squaredNorm() / (kReach * kReach);
  if (load.mass == 0.0 || cost.at_bound(load)) best.value = std::numeric_limits<double>::infinity();
}

TermProducts Exchanges::products_of(const Round& round, const Term& term, std::shared_ptr<const Columns> columns) const {
  Cross cross = round.cross(*columns, current_.ridge_of(term, columns->count(), round.scale()));
  return {term, std::move(columns), std::move(cross)};
}

std::vector<TermProducts> Exchanges::products_of(const Round& round, const std::vector<Term>& some) const {
  std::vector<TermProducts> out(some.size());
  parallel_for(static_cast<int>(some.size()), request_.threads, [&](int k) {
    out[k] = products_of(round, some[k], std::make_shared<Columns>(columns_of(some[k], current_.rows())));
  });
  return out;
}

std::vector<Exchange> Exchanges::best_terms(const Round& round, const Subset& s, const std::vector<TermProducts>& all, double needed,
                                        const TermFilter& is_selected) const {
  struct Screened {
    double value = 0.0;
    const TermProducts* of = nullptr;
  };
  std::map<std::string, Screened> by_place;
  for (const TermProducts& one : all) {
    if (!is_selected(one.term)) continue;
    const double gain = round.training_gain(s, one.cross) - one.term.price - 0.5 * static_cast<double>(one.columns->count());
    if (gain + one.term.price <= kWorthPolish * needed) continue;
    Screened& best = by_place[one.term.place];
    if (best.of == nullptr || gain > best.value) best = {gain, &one};
  }
  std::vector<Screened> order;
  for (auto& [place, one] : by_place) order.push_back(one);
  std::sort(order.begin(), order.end(), [](const Screened& a, const Screened& b) { return a.value > b.value; });
  order.resize(std::min<size_t>(order.size(), kScreened));
  std::vector<Exchange> out(order.size());
  parallel_for(static_cast<int>(order.size()), request_.threads, [&](int k) { out[k] = exchange_with(round, s, *order[k].of); });
  const auto better = [](const Exchange& a, const Exchange& b) { return a.value < b.value; };
  // Terms with a gain in few blocks only are compared after those with a gain in all.
  const Fitted without = round.evaluate(s);
  out.erase(std::remove_if(out.begin(), out.end(), [&](const Exchange& e) {
              const Gain g = round.gain(e.fit, without);
              return without.score - e.value + e.term.price < kWorthPolish * needed || g.sum < kWorthPolish * g.limit;
            }), out.end());
  std::sort(out.begin(), out.end(), better);
  out.resize(std::min<size_t>(out.size(), kFinalists));
  parallel_for(static_cast<int>(out.size()), request_.threads, [&](int k) {
    if (std::isfinite(out[k].value)) polish_shapes(round, s, out[k]);
  });
  std::sort(out.begin(), out.end(), better);
  return out;
}

std::vector<TermProducts> Exchanges::products_of_dictionary(const Round& round, const TermFilter& is_selected) {
  std::vector<size_t> some;
  for (size_t k = 0; k < current_.dictionary().size(); ++k) {
    if (is_selected(current_.dictionary()[k])) some.push_back(k);
  }
  std::vector<TermProducts> out(some.size());
  parallel_for(static_cast<int>(some.size()), request_.threads, [&](int k) {
    out[k] = products_of(round, current_.dictionary()[some[k]], current_.columns_at(some[k]));
  });
  return out;
}

std::vector<TermProducts> Exchanges::products_of_ripples(const Round& round, const MatrixXd& residual) const {
  std::vector<Term> some = search::ripples(current_.rows(), residual, current_.dictionary(), request_.threads);
  some.erase(std::remove_if(some.begin(), some.end(), [&](const Term& t) { return !request_.scope.is_wanted(current_.rows().arm(), t.cause) || request_.scope.silent.count(t.joint->value) != 0; }), some.end());
  return products_of(round, some);
}

std::vector<Exchange> Exchanges::far_gravities(const Round& now, const Fitted& fit) {
  std::vector<Exchange> out;
  const Term* tilt = nullptr;
  for (const Term& t : current_.dictionary()) {
    if (is_tilt(t)) tilt = &t;
  }
  const Eigen::Vector3d own = current_.gravity();
  const double g = own.norm();
  if (tilt == nullptr || g == 0.0) return out;
  std::vector<Eigen::Vector3d> all = {Eigen::Vector3d::Zero()};
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {1.0, -1.0}) all.push_back(sign * g * Eigen::Vector3d::Unit(axis));
  }
  const CurrentSet::State state = current_.snapshot();
  for (const Eigen::Vector3d& gravity : all) {
    if ((gravity - own).norm() < kFarGravity * g) continue;
    ModelDescription d = current_.rows().arm().description();
    d.gravity = gravity;
    if (!current_.move_to(Model(std::move(d)))) continue;
    const Round then = current_.round();
    Exchange e;
    e.term = *tilt;
    // The absence of gravity costs as much as any direction under which gravity has no torque on the joints.
    if (gravity != Eigen::Vector3d::Zero()) e.term.price += std::log(static_cast<double>(all.size()));
    e.fit = then.fit();
    const Gain gain = now.gain(e.fit, fit);
    e.value = fit.score - gain.sum + e.term.price;
    e.columns = std::make_shared<Columns>(columns_of(e.term, current_.rows()));
    e.ridge = VectorXd::Constant(e.columns->count(), kNoMass);
    e.gravity = gravity;
    current_.restore(state);
    if (e.value < fit.score) out.push_back(std::move(e));
  }
  return out;
}

}  // namespace veridyn::search
