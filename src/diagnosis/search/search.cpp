#include "diagnosis/search/search.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <mutex>
#include <numeric>

#include "diagnosis/numerics.hpp"
#include "diagnosis/search/numbers.hpp"
#include "math/parallel.hpp"
#include "math/student_t.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/effects/channel_effect.hpp"
#include "veridyn/identification/base_parameters.hpp"

namespace veridyn::search {
namespace {

bool is_tilt(const Term& t) {
  return t.kind == TermKind::kChannel && dynamic_cast<const ArmEffect*>(&find_effect(t.effect.effect)) != nullptr &&
         !dynamic_cast<const ArmEffect&>(find_effect(t.effect.effect)).far_values().empty();
}

bool scales(const Term& t) {
  if (t.kind != TermKind::kChannel) return false;
  const auto* sensor = dynamic_cast<const SensorError*>(&find_effect(t.effect.effect));
  return sensor != nullptr && sensor->scales_torque();
}

// A term in place of others, with what it reaches.
struct Option {
  Term term;
  std::shared_ptr<Columns> columns;
  VectorXd ridge;
  Fitted fit;
  double value = std::numeric_limits<double>::infinity();  // score with its price
  std::optional<Eigen::Vector3d> gravity;
};

class Search {
 public:
  Search(const Model& arm, const SearchRequest& request) : arm_(arm), request_(request) {
    rows_ = std::make_shared<Rows>(arm, request.recordings, request.preprocessing);
    folds_ = folds_of(*rows_, request.periods, request.preprocessing.cutoff);
    folds_.errors = is_repeated() ? kRepeated : errors_of(folds_.blocks);
    values_ = VectorXd(rows_->names().size());
    const std::vector<StandardParameter> all = standard_parameters(arm);
    for (Eigen::Index p = 0; p < values_.size(); ++p) values_[p] = all[p].value;
    directions_ = base_parameters(arm).size();
    base_ = base_of(*rows_);
    dictionary_ = dictionary(*rows_, request.scope);
    for (Term& t : dictionary_) {
      const bool is_asked = t.kind != TermKind::kCurve || request.scope.wanted.empty();
      if (is_asked && t.place.find(" other") == std::string::npos) places_.insert(t.place);
    }
  }

  SearchResult run() {
    if (folds_.count > 0 && rows_->rows() > 0) {
      begin_with_friction();
      // A curve can do what any name on its joint does: names come first, then curves beside them, or in the place of all
      // names of a joint.
      int round = 0;
      const int most = kRounds + request_.most;
      const auto has_room = [&] { return static_cast<int>(chosen_.size()) < request_.most && round < most; };
      do {
        for (; has_room(); ++round) {
          if (request_.progress) request_.progress(round, most);
          if (!add(false)) break;
          exchange();
        }
      } while (clean() && has_room());
      const size_t with_curves = static_cast<size_t>(request_.most + rows_->joints());
      while (request_.scope.wanted.empty() && chosen_.size() < with_curves && add(true)) {
        if (chosen_.back().term.kind == TermKind::kCurve) stand_for_names();
      }
      clean();
    }
    // Values of the last set.
    for (size_t k = 0; k < chosen_.size(); ++k) {
      if (chosen_[k].term.is_linearised()) linearise(k);
    }
    const VectorXd unasked = predicted_by_curves();
    SearchResult out = finish();
    out.unasked = unasked;
    return out;
  }

 private:
  // What changed since a MODEL may differ from one recording to the next: the held-out ones are not asked there.
  bool is_repeated() const { return !request_.test.empty() && !request_.scope.changes; }

  static double errors_of(int blocks) {
    return blocks < kManyBlocks ? student_t_quantile(2.0 * (1.0 - kPassed), std::max(1.0, blocks - 1.0)) : kErrors;
  }

  Base base_of(const Rows& rows) const { return request_.scope.changes ? prior_base(rows, arm_) : fitted_base(rows, directions_); }

  Round round() {
    std::vector<SetTerm> set;
    for (const Chosen& c : chosen_) set.push_back({&c.columns, c.ridge, c.term.nonnegative});
    return Round(*rows_, folds_, base_, set, weights_);
  }

  static std::vector<int> all_but(size_t count, const std::set<size_t>& without) {
    std::vector<int> out;
    for (size_t k = 0; k < count; ++k) {
      if (without.count(k) == 0) out.push_back(static_cast<int>(k));
    }
    return out;
  }

  double price_of(const std::vector<int>& some) const {
    double sum = 0.0;
    for (const int k : some) sum += chosen_[k].term.price;
    return sum;
  }

  VectorXd ridge_of(const Term& t, Eigen::Index count, const VectorXd& scale) const {
    VectorXd out = VectorXd::Zero(count);
    if (t.kind == TermKind::kCurve) out.setConstant(1.0 / std::pow(kCurveSize * scale[t.joint->value], 2));
    if (t.kind == TermKind::kLoad) {
      out.setConstant(1.0 / std::pow(kInertia, 2));
      out.segment<3>(1).setConstant(1.0 / std::pow(kMassOfArm * kReach, 2));
      out[0] = 1.0 / std::pow(kMassOfArm, 2);
    }
    return out;
  }

  // A torque that is mostly of an impossible sign, or a factor that turns one round, is no answer.
  static bool is_possible(const Term& t, const Columns& columns, const VectorXd& z) {
    VectorXd size = VectorXd::Zero(z.size());
    for (const MatrixXd& of : columns.of) size += of.colwise().squaredNorm().transpose();
    Eigen::Index largest = 0;
    size.cwiseProduct(z.cwiseAbs2()).maxCoeff(&largest);
    if (z[largest] < 0.0 && std::count(t.nonnegative.begin(), t.nonnegative.end(), largest) > 0) return false;
    return !scales(t) || z[0] > kGainOfNothing;
  }

  const Columns& columns_at(size_t k) {
    if (cache_.size() != dictionary_.size()) cache_.resize(dictionary_.size());
    if (!cache_[k]) cache_[k] = std::make_shared<Columns>(columns_of(dictionary_[k], *rows_));
    return *cache_[k];
  }

  Option option(const Round& round, const Subset& s, const Term& term, std::shared_ptr<Columns> columns) const {
    Option out;
    out.term = term;
    out.columns = columns ? std::move(columns) : std::make_shared<Columns>(columns_of(term, *rows_));
    out.ridge = ridge_of(term, out.columns->count(), round.scale());
    const Cross cross = round.cross(*out.columns, out.ridge);
    out.fit = round.evaluate(s, &cross);
    if (is_possible(term, *out.columns, out.fit.x.tail(out.columns->count()))) out.value = out.fit.score + term.price;
    return out;
  }

  // The best shape near the present one: golden sections of each number between its neighbours in the grid.
  void polish(const Round& round, const Subset& s, Option& best) const {
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
          return option(round, s, out.term, nullptr);
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

  // The inertia of a load is that of a point at its centre, which its moments give.
  void polish_load(const Round& round, const Subset& s, Option& best) const {
    for (int k = 0; k < kTurns; ++k) {
      const VectorXd z = best.fit.x.tail(kBodyParameters).head<4>();
      if (std::abs(z[0]) < kNoMass) return;
      Term t = best.term;
      t.centre = z.tail<3>() / z[0];
      if (t.centre.norm() > 2.0 * kReach || (t.centre - best.term.centre).norm() < kSameCentre) return;
      Option next = option(round, s, t, nullptr);
      if (next.value >= best.value) return;
      best = std::move(next);
    }
  }

  // Terms beside those of the dictionary, with their columns.
  struct Further {
    Term term;
    std::shared_ptr<Columns> columns;
    Cross cross;
  };
  Further further(const Round& round, const Term& t) const {
    const auto columns = std::make_shared<Columns>(columns_of(t, *rows_));
    return {t, columns, round.cross(*columns, ridge_of(t, columns->count(), round.scale()))};
  }
  std::vector<Further> further(const Round& round, const std::vector<Term>& some) const {
    std::vector<Further> out;
    for (const Term& t : some) out.push_back(further(round, t));
    return out;
  }

  // The best terms in a place of the set, each cause once, with their shapes polished.
  std::vector<Option> best_terms(const Round& round, const Subset& s, const std::map<size_t, Cross>& crosses,
                                 const std::vector<Further>& more, double needed, const std::function<bool(const Term&)>& is_asked) {
    struct Screened {
      double value;
      const Term* term;
      std::shared_ptr<Columns> columns;
    };
    std::map<std::string, Screened> by_place;
    const auto screen = [&](const Term& t, const Cross& c, const std::shared_ptr<Columns>& columns) {
      if (!is_asked(t)) return;
      const double gain = round.training_gain(s, c) - t.price - 0.5 * static_cast<double>(c.columns->count());
      if (gain + t.price <= kWorthPolish * needed) return;
      const auto at = by_place.find(t.place);
      if (at == by_place.end()) by_place.emplace(t.place, Screened{gain, &t, columns});
      else if (gain > at->second.value) at->second = {gain, &t, columns};
    };
    for (const auto& [k, cross] : crosses) screen(dictionary_[k], cross, cache_[k]);
    for (const Further& f : more) screen(f.term, f.cross, f.columns);
    std::vector<Screened> order;
    for (auto& [place, one] : by_place) order.push_back(one);
    std::sort(order.begin(), order.end(), [](const Screened& a, const Screened& b) { return a.value > b.value; });
    order.resize(std::min<size_t>(order.size(), kScreened));
    std::vector<Option> out(order.size());
    parallel_for(static_cast<int>(order.size()), request_.threads, [&](int k) { out[k] = option(round, s, *order[k].term, order[k].columns); });
    const auto better = [](const Option& a, const Option& b) { return a.value < b.value; };
    // What gains much in a few blocks only does not take the places of what gains everywhere.
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

  std::map<size_t, Cross> crosses(const Round& round) {
    if (cache_.size() != dictionary_.size()) cache_.resize(dictionary_.size());
    std::vector<Cross> all(dictionary_.size());
    parallel_for(static_cast<int>(dictionary_.size()), request_.threads, [&](int k) {
      const Columns& columns = columns_at(k);
      all[k] = round.cross(columns, ridge_of(dictionary_[k], columns.count(), round.scale()));
    });
    std::map<size_t, Cross> out;
    for (size_t k = 0; k < all.size(); ++k) out.emplace(k, std::move(all[k]));
    return out;
  }

  bool is_chosen(const Term& t, const std::set<size_t>& without = {}) const {
    for (size_t k = 0; k < chosen_.size(); ++k) {
      if (without.count(k) != 0 || !same_place(chosen_[k].term, t)) continue;
      // Several memories or waves may act on one axis.
      if (t.kind == TermKind::kEffect && !t.shapes.empty() && find_effect(t.effect.effect).traits().memory) continue;
      return true;
    }
    return false;
  }

  // What can do what any name does comes after all names: curves, and what imitates many others unless the user asks for it.
  bool comes_late(const Term& t) const { return t.kind == TermKind::kCurve || (t.imitates && request_.scope.wanted.empty()); }
  // What was refuted stays away.
  bool is_name(const Term& t) const { return !comes_late(t) && aside_.count(t.place) == 0; }

  static bool makes_worse(const Gain& g) {
    for (Eigen::Index i = 0; i < g.of_joint.size(); ++i) {
      if (g.rise[i] > kSmallest && g.of_joint[i] < -kErrors * g.error_of_joint[i]) return true;
    }
    return false;
  }

  bool passes(const Gain& g, const Term& t) const {
    // Against a MODEL its own numbers may move a little. Of what moves as they do, what they would have to pay counts as
    // well as the error.
    const bool moves_as_model = t.kind == TermKind::kChange || t.kind == TermKind::kLoad;
    const bool matters = g.share >= kSmallest || (moves_as_model && g.prior > t.price + 0.5 * kErrors * kErrors);
    return g.sum > t.price && g.sum > g.limit && matters && !(t.joint && g.of_joint[t.joint->value] <= 0.0);
  }

  Chosen chosen_of(const Option& o) const {
    Chosen c;
    c.term = o.term;
    c.columns = *o.columns;
    c.ridge = o.ridge;
    if (c.term.is_linearised()) c.offset.assign(static_cast<size_t>(c.columns.count()), 0.0);
    return c;
  }

  // Adds the term that lowers the score most; false if none passes.
  bool add(bool curves) {
    const Round now = round();
    const Subset s = now.subset(all_but(chosen_.size(), {}));
    const Fitted fit = now.evaluate(s);
    const std::map<size_t, Cross> all = crosses(now);
    const bool has_room = std::count_if(chosen_.begin(), chosen_.end(), [](const Chosen& c) { return c.term.kind != TermKind::kCurve; }) < request_.most;
    std::vector<Option> options = best_terms(now, s, all, curves ? std::vector<Further>() : further(now, ripple_terms(fit.residual)), 1.0, [&](const Term& t) {
      return !is_chosen(t) && aside_.count(t.place) == 0 && comes_late(t) == curves && (has_room || t.kind == TermKind::kCurve);
    });
    if (!curves) add_far_gravities(now, fit, options);
    for (Option& o : options) {
      if (!(o.value < fit.score)) break;
      if (!passes(now.gain(o.fit, fit), o.term)) continue;
      const std::vector<Chosen> before = chosen_;
      const State state = kept();
      chosen_.push_back(chosen_of(o));
      if (o.gravity) chosen_.back().gravity = o.gravity;
      if (chosen_.back().term.is_linearised()) {
        if (!linearise(chosen_.size() - 1)) {
          chosen_ = before;
          restore(state);
          aside_.insert(o.term.place);
          continue;
        }
      }
      return true;
    }
    return false;
  }

  // Friction that a file does not have is asked about on all joints together: one at a time, the first one's would be
  // fitted to what the others leave, and be mistaken for a power law.
  void begin_with_friction() {
    for (const Term& t : dictionary_) {
      if (t.kind != TermKind::kEffect || !t.joint || request_.without_friction.count(t.joint->value) == 0) continue;
      if (!find_effect(t.effect.effect).traits().elementary || is_chosen(t)) continue;
      if (std::abs(t.effect.axis.coefficients[t.joint->value]) < kAlongJoint * t.effect.axis.coefficients.norm()) continue;
      if (!t.effect.values.empty()) continue;
      Option o;
      o.term = t;
      o.columns = std::make_shared<Columns>(columns_of(t, *rows_));
      o.ridge = VectorXd::Zero(o.columns->count());
      chosen_.push_back(chosen_of(o));
    }
    drop_superfluous();
  }

  struct State {
    std::shared_ptr<const Rows> rows;
    Base base;
    VectorXd values;
    MatrixXd weights;
    std::vector<std::shared_ptr<Columns>> cache;
    std::shared_ptr<const Rows> test, test_of;
    std::map<std::string, std::shared_ptr<const Columns>> test_columns;
  };
  State kept() const { return {rows_, base_, values_, weights_, cache_, test_, test_of_, test_columns_}; }
  void restore(const State& s) {
    rows_ = s.rows;
    base_ = s.base;
    values_ = s.values;
    weights_ = s.weights;
    cache_ = s.cache;
    test_ = s.test;
    test_of_ = s.test_of;
    test_columns_ = s.test_columns;
  }

  std::vector<Term> ripple_terms(const MatrixXd& residual) const {
    std::vector<Term> out = ripples(*rows_, residual, dictionary_);
    out.erase(std::remove_if(out.begin(), out.end(), [&](const Term& t) {
                const std::vector<std::string>& some = request_.scope.wanted;
                return (!some.empty() && std::none_of(some.begin(), some.end(), [&](const std::string& one) {
                         return one == effect_of(t.cause) || one == to_text(arm_, t.cause);
                       })) || request_.scope.silent.count(t.joint->value) != 0;
              }),
              out.end());
    return out;
  }

  // The arm with values and the corrections of a set.
  Model arm_of(const std::vector<Chosen>& some) const {
    return corrected(request_.scope.changes ? arm_ : with_values(arm_, values_, VectorXd()), some);
  }

  // Rows, base and columns at another arm; false if they are not the same rows.
  bool move_to(const Model& arm) {
    std::shared_ptr<Rows> rows;
    try {
      rows = std::make_shared<Rows>(arm, request_.recordings, request_.preprocessing);
    } catch (const InvalidInput&) {
      return false;  // no arm
    }
    if (rows->rows() != static_cast<Eigen::Index>(folds_.of_row.size()) || !rows->residual.allFinite()) return false;
    rows_ = std::move(rows);
    base_ = base_of(*rows_);
    cache_.clear();
    for (Chosen& c : chosen_) c.columns = columns_of(c.term, *rows_);
    return true;
  }

  // Steps of the k-th term, which is exact at the present arm only; false if even the first one makes it worse.
  bool linearise(size_t k) {
    bool moved = chosen_[k].gravity.has_value();
    if (moved && !move_to(arm_of(chosen_))) return false;
    for (int step = 0; step < kSteps; ++step) {
      const Round now = round();
      const Subset s = now.subset(all_but(chosen_.size(), {}));
      const Fitted fit = now.evaluate(s);
      const auto [first, count] = range(k);
      const VectorXd z = fit.x.segment(first, count);
      const MatrixXd covariance = now.covariance(s, fit).block(first, first, count, count);
      bool small = true;
      for (Eigen::Index c = 0; c < count; ++c) small = small && std::abs(z[c]) < kSettled * std::sqrt(std::max(covariance(c, c), numerics::kTiny));
      if (small) return true;
      const std::vector<Chosen> before = chosen_;
      const State state = kept();
      bool better = false;
      // What is taken from the recorded torque of another joint brings its noise: it need not do all that the model's torque does.
      double least = moved ? 0.0 : -kBetter;
      if (!moved && chosen_[k].term.candidate.from) least = -kHalf * now.gain(fit, now.evaluate(now.subset(all_but(chosen_.size(), {k})))).sum;
      for (double scale = 1.0; scale > kShortestStep && !better; scale *= 0.5) {
        std::vector<double> trial(static_cast<size_t>(count));
        for (Eigen::Index c = 0; c < count; ++c) trial[static_cast<size_t>(c)] = scale * z[c];
        if (!take_step(k, trial)) {
          chosen_ = before;
          continue;
        }
        if (!request_.scope.changes) values_ = state.values + state.base.T * fit.x.head(state.base.T.cols());
        better = move_to(arm_of(chosen_));
        if (better) {
          const Round then = round();
          const Fitted after = then.evaluate(then.subset(all_but(chosen_.size(), {})));
          const double gained = now.gain(after, fit).sum;
          better = gained > least;
          if (better && gained < kLittle && step > 0) return true;
        }
        if (!better) {
          chosen_ = before;
          restore(state);
        }
      }
      if (!better) return moved;
      moved = true;
    }
    return true;
  }

  // Adds a step to the offset of a term.
  bool take_step(size_t k, const std::vector<double>& step) {
    Chosen& c = chosen_[k];
    if (is_tilt(c.term)) {
      const Model now = with_step(rows_->arm(), c.term, step);
      c.gravity = now.gravity();
      return true;
    }
    const auto& parameters = c.term.kind == TermKind::kChannel ? find_effect(c.term.effect.effect).parameters() : std::vector<EffectParameter>(1);
    for (size_t p = 0; p < step.size(); ++p) {
      double& offset = c.offset[p];
      offset = scales(c.term) ? (1.0 + offset) * (1.0 + step[p]) - 1.0 : offset + step[p];
      if (parameters[p].sign == ParameterSign::kNonnegative && c.term.kind == TermKind::kChannel) offset = std::max(offset, 0.0);
      if (scales(c.term) && offset < kGainOfNothing) return false;
      if (c.term.kind == TermKind::kConstant && std::abs(offset) > reach_of(*c.term.constant)) return false;
    }
    return true;
  }

  std::pair<Eigen::Index, Eigen::Index> range(size_t k) const {
    Eigen::Index at = base_.T.cols();
    for (size_t c = 0; c < k; ++c) at += chosen_[c].columns.count();
    return {at, chosen_[k].columns.count()};
  }

  // Gravity that points elsewhere, or that the torques do not hold: far from the file's, where no derivative leads.
  void add_far_gravities(const Round& now, const Fitted& fit, std::vector<Option>& options) {
    const Term* tilt = nullptr;
    for (const Term& t : dictionary_) {
      if (is_tilt(t)) tilt = &t;
    }
    if (tilt == nullptr || far_asked_) return;
    far_asked_ = true;
    const double g = arm_.gravity().norm();
    if (g == 0.0) return;
    std::vector<Eigen::Vector3d> all = {Eigen::Vector3d::Zero()};
    for (int axis = 0; axis < 3; ++axis) {
      for (const double sign : {1.0, -1.0}) all.push_back(sign * g * Eigen::Vector3d::Unit(axis));
    }
    const State state = kept();
    for (const Eigen::Vector3d& gravity : all) {
      if ((gravity - arm_.gravity()).norm() < kFarGravity * g) continue;
      ModelDescription d = rows_->arm().description();
      d.gravity = gravity;
      if (!move_to(Model(std::move(d)))) continue;
      const Round then = round();
      Option o;
      o.term = *tilt;
      // Torques without gravity are as good as any direction that no joint feels.
      if (gravity != Eigen::Vector3d::Zero()) o.term.price += std::log(static_cast<double>(all.size()));
      o.fit = then.evaluate(then.subset(all_but(chosen_.size(), {})));
      const Gain gain = now.gain(o.fit, fit);
      o.value = fit.score - gain.sum + o.term.price;
      o.columns = std::make_shared<Columns>(columns_of(o.term, *rows_));
      o.ridge = VectorXd::Constant(o.columns->count(), kNoMass);
      o.gravity = gravity;
      restore(state);
      for (Chosen& c : chosen_) c.columns = columns_of(c.term, *rows_);
      if (o.value < fit.score) options.push_back(std::move(o));
    }
    std::sort(options.begin(), options.end(), [](const Option& a, const Option& b) { return a.value < b.value; });
  }

  void replace(const std::set<size_t>& gone, const Option& o) {
    std::vector<Chosen> kept;
    for (size_t k = 0; k < chosen_.size(); ++k) {
      if (gone.count(k) == 0) kept.push_back(std::move(chosen_[k]));
    }
    chosen_ = std::move(kept);
    chosen_.push_back(chosen_of(o));
    if (o.term.is_linearised()) linearise(chosen_.size() - 1);
  }

  // Each chosen term against nothing, against every other in its place, two against one.
  void exchange() {
    for (int turn = 0; turn < kTurns && !chosen_.empty(); ++turn) {
      if (!exchange_once()) return;
    }
  }

  bool exchange_once() {
    const Round now = round();
    const size_t count = chosen_.size();
    const std::vector<int> all = all_but(count, {});
    const Fitted full = now.evaluate(now.subset(all));
    const double value = full.score + price_of(all);
    const std::map<size_t, Cross> crossed = crosses(now);
    std::vector<Further> more = further(now, ripple_terms(full.residual));
    for (size_t k = 0; k < count; ++k) {
      if (chosen_[k].term.is_linearised()) continue;
      const std::vector<int> rest = all_but(count, {k});
      const Subset s = now.subset(rest);
      const Fitted without = now.evaluate(s);
      if (without.score + price_of(rest) <= value) {
        chosen_.erase(chosen_.begin() + static_cast<long>(k));
        return true;
      }
      more.push_back(further(now, chosen_[k].term));
      const double gained = without.score - full.score;
      std::vector<Option> options = best_terms(now, s, crossed, more, gained, [&](const Term& t) { return is_name(t) && !is_chosen(t, {k}) && shares_joint(t, {k}); });
      for (Option& o : options) {
        if (o.value + price_of(rest) >= value - kBetter) break;
        const Gain g = now.gain(o.fit, full);
        // A dearer name replaces a cheaper one only by the same margins as a term is added.
        if (o.term.price > chosen_[k].term.price + kGramRidge && g.sum < g.limit) continue;
        if (!passes(now.gain(o.fit, without), o.term)) continue;
        const bool same = same_place(o.term, chosen_[k].term);
        if (same && o.value + price_of(rest) >= value - 1.0) break;
        replace({k}, o);
        return true;
      }
      more.pop_back();
    }
    for (const std::set<size_t>& some : groups()) {
      const std::vector<int> rest = all_but(count, some);
      const Subset s = now.subset(rest);
      const Fitted without = now.evaluate(s);
      std::vector<Option> options = best_terms(now, s, crossed, more, without.score - full.score, [&](const Term& t) { return is_name(t) && !is_chosen(t, some) && shares_joint(t, some); });
      for (Option& o : options) {
        if (o.value + price_of(rest) >= value) break;
        if (!passes(now.gain(o.fit, without), o.term)) continue;
        replace(some, o);
        return true;
      }
    }
    return whole_arm();
  }

  // Terms that one other might stand for: two of a joint, and all of a joint.
  std::vector<std::set<size_t>> groups() const {
    std::set<std::set<size_t>> out;
    std::map<int, std::set<size_t>> of_joint;
    for (size_t k = 0; k < chosen_.size(); ++k) {
      if (chosen_[k].term.is_linearised()) continue;
      if (chosen_[k].term.joint) of_joint[chosen_[k].term.joint->value].insert(k);
      for (size_t c = 0; c < k; ++c) {
        if (chosen_[c].term.is_linearised()) continue;
        if (!chosen_[k].term.joint || !chosen_[c].term.joint || chosen_[k].term.joint == chosen_[c].term.joint) out.insert({c, k});
      }
    }
    for (const auto& [joint, all] : of_joint) {
      if (all.size() > 2) out.insert(all);
    }
    return {out.begin(), out.end()};
  }

  // The last curve in the place of all names of its joint, where these do less than half of what it does alone.
  void stand_for_names() {
    const size_t last = chosen_.size() - 1;
    std::set<size_t> names;
    for (size_t k = 0; k < last; ++k) {
      if (chosen_[k].term.kind != TermKind::kCurve && !chosen_[k].term.is_linearised() && chosen_[k].term.joint == chosen_[last].term.joint) names.insert(k);
    }
    if (names.empty()) return;
    const Round now = round();
    std::set<size_t> curve = {last};
    const Fitted with_names = now.evaluate(now.subset(all_but(chosen_.size(), curve)));
    const Fitted with_curve = now.evaluate(now.subset(all_but(chosen_.size(), names)));
    double paid = chosen_[last].term.price;
    for (const size_t k : names) paid -= chosen_[k].term.price;
    const Gain g = now.gain(with_curve, with_names);
    if (g.sum <= std::max(g.limit, paid)) return;
    std::set<size_t> both = names;
    both.insert(last);
    const Fitted neither = now.evaluate(now.subset(all_but(chosen_.size(), both)));
    if (now.gain(with_names, neither).sum > kHalf * now.gain(with_curve, neither).sum) return;
    std::vector<Chosen> kept;
    for (size_t k = 0; k <= last; ++k) {
      if (names.count(k) == 0) kept.push_back(std::move(chosen_[k]));
    }
    chosen_ = std::move(kept);
  }

  bool shares_joint(const Term& t, const std::set<size_t>& with) const {
    return !t.joint || std::any_of(with.begin(), with.end(), [&](size_t k) {
      return !chosen_[k].term.joint || chosen_[k].term.joint == t.joint;
    });
  }

  // All terms of several joints against one of several joints, linearised anew; what then is of no use goes.
  bool whole_arm() {
    const size_t own = std::count_if(chosen_.begin(), chosen_.end(), [](const Chosen& c) { return c.term.joint.has_value(); });
    if (own < 2) return false;
    const std::vector<Chosen> before = chosen_;
    const State state = kept();
    const Round now = round();
    const Fitted full = now.evaluate(now.subset(all_but(before.size(), {})));
    std::set<size_t> local;
    for (size_t k = 0; k < before.size(); ++k) {
      if (before[k].term.joint) local.insert(k);
    }
    const Subset s = now.subset(all_but(before.size(), local));
    const std::map<size_t, Cross> crossed = crosses(now);
    std::vector<Option> options = best_terms(now, s, crossed, {}, 1.0, [&](const Term& t) {
      return is_name(t) && !t.joint && !is_chosen(t) && tried_.count(t.place + std::to_string(before.size())) == 0;
    });
    options.resize(std::min(options.size(), kMostWholeArm));
    for (const Option& o : options) {
      tried_.insert(o.term.place + std::to_string(before.size()));
      if (!std::isfinite(o.value)) continue;
      chosen_.clear();
      for (size_t k = 0; k < before.size(); ++k) {
        if (local.count(k) == 0) chosen_.push_back(before[k]);
      }
      chosen_.push_back(chosen_of(o));
      if (o.term.is_linearised()) linearise(chosen_.size() - 1);
      for (const size_t k : local) {
        chosen_.push_back(before[k]);
        chosen_.back().columns = columns_of(before[k].term, *rows_);
      }
      drop_superfluous();
      const Round then = round();
      const Fitted after = then.evaluate(then.subset(all_but(chosen_.size(), {})));
      double change = 0.0;
      for (const Chosen& c : chosen_) change += c.term.price;
      for (const Chosen& c : before) change -= c.term.price;
      if (now.gain(after, full).sum > change + kBetter && !same_set(before)) return true;
      chosen_ = before;
      restore(state);
    }
    return false;
  }

  bool same_set(const std::vector<Chosen>& other) const {
    std::multiset<std::string> a, b;
    for (const Chosen& c : chosen_) a.insert(c.term.place);
    for (const Chosen& c : other) b.insert(c.term.place);
    return a == b;
  }

  // Takes terms out, the one of least use first, as long as the score falls.
  void drop_superfluous() {
    while (!chosen_.empty()) {
      const Round now = round();
      const double all = now.evaluate(now.subset(all_but(chosen_.size(), {}))).score;
      double best = 0.0;
      std::optional<size_t> gone;
      for (size_t k = 0; k < chosen_.size(); ++k) {
        if (chosen_[k].term.is_linearised()) continue;
        const double loss = now.evaluate(now.subset(all_but(chosen_.size(), {k}))).score - all - chosen_[k].term.price;
        if (loss < best) {
          best = loss;
          gone = k;
        }
      }
      if (!gone) return;
      chosen_.erase(chosen_.begin() + static_cast<long>(*gone));
    }
  }

  // The curves of a joint on which a name acts. A curve can do what a name does: names are judged without it.
  std::set<size_t> curves_beside(size_t k) const {
    std::set<size_t> out;
    const Term& t = chosen_[k].term;
    for (size_t c = 0; t.kind != TermKind::kCurve && t.joint && c < chosen_.size(); ++c) {
      if (chosen_[c].term.kind == TermKind::kCurve && chosen_[c].term.joint == t.joint) out.insert(c);
    }
    return out;
  }

  // The set without one term, at the arm without it.
  struct Without {
    Fitted with, fit;
    Gain gain;
    Gain on_test;  // of the held-out recordings; empty without any
  };
  Without without(size_t k, const Round& now, std::vector<Chosen::RivalTerm>* rivals = nullptr) {
    Without out;
    std::set<size_t> aside = curves_beside(k);
    const std::vector<int> set = all_but(chosen_.size(), aside);
    const Subset with = now.subset(set);
    out.with = now.evaluate(with);
    const bool is_tested = is_repeated();
    MatrixXd test_with, test_without;
    if (is_tested) test_with = left_on_test(out.with.x, set);
    aside.insert(k);
    if (!chosen_[k].term.is_linearised()) {
      const std::vector<int> rest = all_but(chosen_.size(), aside);
      const Subset s = now.subset(rest);
      out.fit = now.evaluate(s);
      if (is_tested) test_without = left_on_test(out.fit.x, rest);
    } else {
      const std::vector<Chosen> before = chosen_;
      const State state = kept();
      chosen_.erase(chosen_.begin() + static_cast<long>(k));
      if (move_to(arm_of(chosen_))) {
        const Round then = round();
        const std::vector<int> rest = all_but(chosen_.size(), {});
        const Subset all = then.subset(rest);
        out.fit = then.evaluate(all);
        if (is_tested) test_without = left_on_test(out.fit.x, rest);
        if (rivals != nullptr) take_rivals(then, all, out.fit, then.gain(out.with, out.fit).sum, before[k].term, *rivals);
      } else {
        out.fit = out.with;
        test_without = test_with;
      }
      chosen_ = before;
      restore(state);
    }
    out.gain = now.gain(out.with, out.fit);
    if (is_tested && test_with.rows() == test_without.rows()) out.on_test = gain_on(*test_rows(), test_with, test_without, now.samples_of_row());
    return out;
  }

  // Rows of the held-out recordings at the present arm.
  const std::shared_ptr<const Rows>& test_rows() {
    if (test_of_ != rows_) {
      test_ = std::make_shared<Rows>(rows_->arm(), request_.test, request_.test_preprocessing);
      test_columns_.clear();
      test_of_ = rows_;
    }
    return test_;
  }

  // What terms of the present set leave of them.
  MatrixXd left_on_test(const VectorXd& x, const std::vector<int>& set) {
    const Rows& test = *test_rows();
    MatrixXd residual = test.residual;
    for (int i = 0; i < rows_->joints(); ++i) residual.col(i) -= base_columns(test, i, base_.T) * x.head(base_.T.cols());
    for (const int k : set) {
      const auto [begin, count] = range(static_cast<size_t>(k));
      const Term& t = chosen_[k].term;
      std::string key = t.place;
      for (const auto& [name, value] : t.effect.values) key += fmt::format(" {} {:.17g}", name, value);
      for (int e = 0; e < 3; ++e) key += fmt::format(" {:.17g}", t.centre[e]);
      auto at = test_columns_.find(key);
      if (at == test_columns_.end()) at = test_columns_.emplace(key, std::make_shared<Columns>(columns_of(t, test))).first;
      const Columns& columns = *at->second;
      for (size_t j = 0; j < columns.joints.size(); ++j) residual.col(columns.joints[j]) -= columns.of[j] * x.segment(begin, count);
    }
    return residual;
  }

  // Held-out recordings do not repeat what a term gains.
  static bool is_contradicted(const Gain& on_test) {
    return on_test.of_joint.size() > 0 && on_test.sum < on_test.limit;
  }

  // What curves predict of the held-out recordings beside the causes that were asked about.
  VectorXd predicted_by_curves() {
    if (request_.scope.wanted.empty() || folds_.count == 0 || rows_->rows() == 0) return {};
    const auto left = [&] {
      const Round now = round();
      const std::vector<int> all = all_but(chosen_.size(), {});
      const Fitted fit = now.evaluate(now.subset(all));
      return request_.test.empty() ? fit.residual : left_on_test(fit.x, all);
    };
    const std::vector<Chosen> names = chosen_;
    const State state = kept();
    const MatrixXd before = left();
    while (chosen_.size() < names.size() + static_cast<size_t>(rows_->joints()) && add(true)) {}
    const MatrixXd after = left();
    VectorXd out = VectorXd::Constant(rows_->joints(), -1.0);
    for (size_t k = names.size(); k < chosen_.size(); ++k) {
      const int j = chosen_[k].term.joint.value_or(JointIndex{0}).value;
      out[j] = std::max(0.0, 1.0 - after.col(j).squaredNorm() / std::max(before.col(j).squaredNorm(), numerics::kTiny));
    }
    chosen_ = names;
    restore(state);
    return out;
  }

  // What does not pass beside all others goes, the least first; true if anything did. What went twice stays away.
  bool clean() {
    bool any = false;
    while (!chosen_.empty()) {
      const Round now = round();
      std::optional<size_t> gone;
      double least = 0.0;
      bool is_refuted = false;
      for (size_t k = 0; k < chosen_.size(); ++k) {
        const Without w = without(k, now);
        const bool refuted = is_contradicted(w.on_test);
        const double margin = refuted ? w.on_test.sum / std::max(w.on_test.error, numerics::kNoise) - numerics::kHuge : w.gain.sum / std::max(w.gain.error, numerics::kNoise);
        if ((refuted || !passes(w.gain, chosen_[k].term) || makes_worse(w.gain)) && (!gone || margin < least)) {
          gone = k;
          least = margin;
          is_refuted = refuted;
        }
      }
      if (!gone) return any;
      any = true;
      if (++cleaned_[chosen_[*gone].term.place] > 1 || is_refuted) aside_.insert(chosen_[*gone].term.place);
      const bool moved = chosen_[*gone].term.is_linearised();
      chosen_.erase(chosen_.begin() + static_cast<long>(*gone));
      if (moved) move_to(arm_of(chosen_));
    }
    return any;
  }

  SearchResult finish() {
    SearchResult out;
    out.folds = folds_;
    out.asked = static_cast<int>(places_.size());
    out.degrees_of_freedom = std::max(1, folds_.blocks - 1);
    if (folds_.count == 0 || rows_->rows() == 0) {
      out.rows = rows_;
      return out;
    }
    const Round now = round();
    const Subset s = now.subset(all_but(chosen_.size(), {}));
    const Fitted full = now.evaluate(s);
    const MatrixXd covariance = now.covariance(s, full);
    const std::map<size_t, Cross> crossed = crosses(now);
    const auto relative = [&](const Fitted& f) {
      VectorXd e(rows_->joints());
      for (Eigen::Index i = 0; i < e.size(); ++i) {
        double error = 0.0, torque = 0.0;
        for (Eigen::Index r = 0; r < rows_->rows(); ++r) {
          if (folds_.of_row[r] < 0 || rows_->used(r, i) == 0.0) continue;
          error += f.residual(r, i) * f.residual(r, i);
          torque += rows_->measured(r, i) * rows_->measured(r, i);
        }
        e[i] = torque > 0.0 ? std::sqrt(error / torque) : 0.0;
      }
      return e;
    };
    for (size_t k = 0; k < chosen_.size(); ++k) {
      const auto [first, count] = range(k);
      std::vector<Chosen::RivalTerm> rivals;
      const Without w = without(k, now, &rivals);
      Chosen& c = chosen_[k];
      c.rivals = std::move(rivals);
      c.gain = w.gain.sum;
      c.error = w.gain.error;
      c.of_joint = w.gain.of_joint;
      c.folds_before = relative(w.fit);
      c.folds_after = relative(w.with);
      c.values = full.x.segment(first, count);
      for (size_t p = 0; p < c.offset.size() && !c.gravity; ++p)
        c.values[static_cast<Eigen::Index>(p)] = scales(c.term) ? (1.0 + c.offset[p]) * (1.0 + c.values[static_cast<Eigen::Index>(p)]) - 1.0
                                                                   : c.values[static_cast<Eigen::Index>(p)] + c.offset[p];
      c.covariance = covariance.block(first, first, count, count);
      c.deviations = c.covariance.diagonal().cwiseSqrt();
      take_shape_deviations(now, k, c);
      if (!c.term.is_linearised()) take_rivals(now, crossed, full, k, c);
    }
    take_refused(now, s, full, crossed, out);
    out.rows = rows_;
    out.residual = full.residual;
    out.scale = now.scale();
    out.weights = MatrixXd::Ones(full.residual.rows(), full.residual.cols());
    for (Eigen::Index i = 0; i < out.weights.cols(); ++i)
      out.weights.col(i) = (kFreedom + 1.0) / (kFreedom + (full.residual.col(i).array() / out.scale[i]).square());
    out.values = values_ + base_.T * full.x.head(base_.T.cols());
    out.fitted = rows_->residual;
    for (int i = 0; i < rows_->joints(); ++i) out.fitted.col(i) -= base_.X[i] * full.x.head(base_.T.cols());
    for (Chosen& c : chosen_) {
      VectorXd z = c.values;
      if (c.term.is_linearised()) z.setZero();
      for (size_t at = 0; at < c.columns.joints.size(); ++at) out.fitted.col(c.columns.joints[at]) -= c.columns.of[at] * z;
    }
    std::stable_sort(chosen_.begin(), chosen_.end(), [](const Chosen& a, const Chosen& b) {
      const bool names[] = {a.term.kind != TermKind::kCurve, b.term.kind != TermKind::kCurve};
      return names[0] != names[1] ? names[0] : a.gain > b.gain;
    });
    out.rows = rows_;
    take_test_errors(out);
    out.chosen = std::move(chosen_);
    return out;
  }

  // The held-out recordings with the first terms of the set, fitted to all training rows.
  void take_test_errors(SearchResult& out) {
    if (request_.test.empty()) return;
    out.test_error.resize(static_cast<Eigen::Index>(chosen_.size()) + 1, rows_->joints());
    for (size_t m = chosen_.size() + 1; m-- > 0;) {
      const std::vector<Chosen> first(chosen_.begin(), chosen_.begin() + static_cast<long>(m));
      const bool again = m == chosen_.size() || chosen_[m].term.is_linearised();
      if (again && m < chosen_.size() && !move_to(arm_of(first))) {
        out.test_error.row(static_cast<Eigen::Index>(m)) = out.test_error.row(static_cast<Eigen::Index>(m) + 1);
        continue;
      }
      if (again) at_test_ = std::make_unique<Round>(round());
      std::vector<int> some(m);
      std::iota(some.begin(), some.end(), 0);
      const MatrixXd residual = left_on_test(at_test_->evaluate(at_test_->subset(some)).x, some);
      out.test_error.row(static_cast<Eigen::Index>(m)) = residual.colwise().norm() / std::sqrt(static_cast<double>(std::max<Eigen::Index>(1, residual.rows())));
      if (m < chosen_.size()) continue;
      out.test = test_rows();
      out.test_residual = residual;
    }
  }

  // The curvature of the score in each shape.
  void take_shape_deviations(const Round& now, size_t k, Chosen& c) {
    const Subset rest = now.subset(all_but(chosen_.size(), {k}));
    for (const TermShape& shape : c.term.shapes) {
      const double value = c.term.effect.values.at(shape.name);
      double deviation = std::numeric_limits<double>::quiet_NaN();
      const double centre = option(now, rest, c.term, nullptr).value;
      for (double step = kFirstProfile; step < 2.0; step *= 2.0) {
        const auto at = [&](double side) {
          Term t = c.term;
          t.effect.values[shape.name] = shape.logarithmic ? value * std::exp(side * step) : value + side * step * shape.step;
          return option(now, rest, t, nullptr).value;
        };
        const double rise = 0.5 * (at(1.0) + at(-1.0)) - centre;
        if (rise < 0.5) continue;
        // S rises by 1/2 at one standard deviation.
        deviation = step * std::sqrt(0.5 / rise) * (shape.logarithmic ? value : shape.step);
        break;
      }
      c.shape_deviations.push_back(deviation);
    }
  }

  // Of a linearised term, at the arm without it: what gains nearly as much to first order.
  void take_rivals(const Round& then, const Subset& all, const Fitted& fit, double gained, const Term& term, std::vector<Chosen::RivalTerm>& out) {
    const std::map<size_t, Cross> crossed = crosses(then);
    for (const Option& o : best_terms(then, all, crossed, {}, kHalf * gained, [&](const Term& t) { return !same_place(t, term) && t.kind != TermKind::kCurve; })) {
      const Gain g = then.gain(o.fit, fit);
      if (!std::isfinite(o.value) || gained - g.sum + o.term.price - term.price > 2.0 * g.error) continue;
      out.push_back({o.term, gained - g.sum, g.sum});
    }
    out.resize(std::min(out.size(), kMostRivals));
  }

  void take_rivals(const Round& now, const std::map<size_t, Cross>& crossed, const Fitted& full, size_t k, Chosen& c) {
    const std::vector<int> rest = all_but(chosen_.size(), {k});
    const Subset s = now.subset(rest);
    const Fitted without = now.evaluate(s);
    for (Option& o : best_terms(now, s, crossed, {}, without.score - full.score, [&](const Term& t) {
           return !is_chosen(t) && t.kind != TermKind::kCurve && shares_joint(t, {k});
         })) {
      if (!std::isfinite(o.value)) break;
      const Gain g = now.gain(full, o.fit);
      if (g.sum + o.term.price - c.term.price < 2.0 * g.error && without.score - o.fit.score > 0.0)
        c.rivals.push_back({o.term, g.sum, without.score - o.fit.score});
    }
    c.rivals.resize(std::min(c.rivals.size(), kMostRivals));
  }

  void take_refused(const Round& now, const Subset& s, const Fitted& full, const std::map<size_t, Cross>& crossed, SearchResult& out) {
    std::map<std::string, Refused> best;
    for (const auto& [k, cross] : crossed) {
      const Term& t = dictionary_[k];
      if (is_chosen(t) || t.kind == TermKind::kCurve) continue;
      const double gain = now.training_gain(s, cross);
      Refused one{t, gain, 0.0, false, gain < 0.0};
      const auto at = best.find(t.place);
      if (at == best.end() || at->second.gain < gain) best[t.place] = one;
    }
    std::vector<Refused> all;
    for (auto& [place, one] : best) all.push_back(one);
    std::sort(all.begin(), all.end(), [](const Refused& a, const Refused& b) { return a.gain > b.gain; });
    std::vector<Refused> shown(all.begin(), all.begin() + static_cast<long>(std::min(all.size(), kMostRefused)));
    parallel_for(static_cast<int>(shown.size()), request_.threads, [&](int k) {
      if (shown[k].collinear) return;
      const Option o = option(now, s, shown[k].term, nullptr);
      const Gain g = now.gain(o.fit, full);
      shown[k].impossible = !std::isfinite(o.value);
      shown[k].gain = g.sum;
      shown[k].error = g.error;
    });
    for (size_t k = shown.size(); k < all.size(); ++k) {
      if (all[k].collinear) shown.push_back(all[k]);
    }
    out.refused = std::move(shown);
  }

  const Model& arm_;
  const SearchRequest& request_;
  std::shared_ptr<const Rows> rows_;
  Folds folds_;
  Eigen::Index directions_ = 0;  // base parameters of the arm
  Base base_;
  VectorXd values_;
  MatrixXd weights_;
  std::vector<Term> dictionary_;
  std::set<std::string> places_, aside_, tried_;
  std::map<std::string, int> cleaned_;
  std::vector<std::shared_ptr<Columns>> cache_;
  std::vector<Chosen> chosen_;
  bool far_asked_ = false;
  std::shared_ptr<const Rows> test_, test_of_;
  std::map<std::string, std::shared_ptr<const Columns>> test_columns_;
  std::unique_ptr<Round> at_test_;
};

}  // namespace

Model corrected(const Model& arm, const std::vector<Chosen>& chosen) {
  Model out = arm;
  for (const Chosen& c : chosen) {
    if (!c.term.is_linearised()) continue;
    if (c.gravity) {
      ModelDescription d = out.description();
      d.gravity = *c.gravity;
      out = Model(std::move(d));
    } else if (std::any_of(c.offset.begin(), c.offset.end(), [](double x) { return x != 0.0; })) {
      out = with_step(out, c.term, c.offset);
    }
  }
  return out;
}

SearchResult search(const Model& arm, const SearchRequest& request) {
  return Search(arm, request).run();
}

}  // namespace veridyn::search
