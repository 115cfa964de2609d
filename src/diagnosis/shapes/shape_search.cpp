#include "diagnosis/shapes/shape_search.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include "veridyn/effects/effect.hpp"
#include "diagnosis/evidence/clustered_fit.hpp"
#include "diagnosis/evidence/numerics.hpp"
#include "math/student_t.hpp"

namespace veridyn {
namespace {

// One hypothesis with one choice of constants.
struct Variant {
  Hypothesis hypothesis;
  Shapes shapes;
  size_t of = 0;      // which accepted one
  std::string moved;  // the constant that differs from the present choice; empty: none
  double factor = 1.0;
};

// The baseline arm with these variants in place of all hypotheses.
AugmentedModel model_with(const Model& arm, const AugmentedModel& asked,
                          std::vector<Variant>& variants) {
  ModelDescription d = arm.description();
  auto bodies = static_cast<int>(arm.bodies().size());
  for (Variant& v : variants) {
    Hypothesis& h = v.hypothesis;
    if (const auto* body = std::get_if<BodyIndex>(&h.part)) {
      const int frame = asked.model.bodies()[body->value];
      d.frames.push_back(asked.model.frames()[frame]);
      h.part = BodyIndex{bodies++};
      continue;
    }
    EffectTerm term = term_of(asked.model, h);
    for (const auto& [key, value] : v.shapes) term.values[key] = value;
    h.part = TermIndex{d.effects.size()};
    d.effects.push_back(std::move(term));
  }
  AugmentedModel out{Model(std::move(d)), {}};
  const std::vector<StandardParameter> parameters = standard_parameters(out.model);
  for (Variant& v : variants) {
    Hypothesis& h = v.hypothesis;
    h.columns = columns_in(parameters, h);
    out.hypotheses.push_back(h);
  }
  return out;
}

std::optional<EffectShape> shape_of(const std::string& effect, const std::string& key) {
  if (!has_effect(effect)) return std::nullopt;
  for (const EffectShape& s : find_effect(effect).shapes()) {
    if (s.name == key) return s;
  }
  return std::nullopt;
}

bool searched(const Hypothesis& h, const std::string& key) {
  if (is_change(h)) return false;
  const auto shape = shape_of(effect_of(h.cause), key);
  if (!shape) return false;
  // A wave number comes from a spectrum and is close to its peak already.
  const bool asked = shape->searched || is_other_constant(h);
  return shape->scale == ShapeScale::kWaves || (asked && shape->lower > 0.0);
}

// Residual per joint's weight of a choice of variants, one per accepted hypothesis.
double misfit(const NormalBlocks& data, const ColumnSet& set, const VectorXd& w,
              VectorXd* solution) {
  const VectorXd x = data.solve(set, w, data.total(), nullptr);
  if (solution != nullptr) *solution = x;
  return (w.array() * data.residual2(set, x, data.total()).array()).sum();
}

// Where, coming from outside, the first value lies that is not certainly worse; between two of them where a
// straight line passes the limit. `end` where the outermost one is as good.
template <typename Iterator>
double border(Iterator at, Iterator behind, double limit, double end) {
  if (at->second <= limit) return end;
  Iterator before = at;
  for (; at != behind && at->second > limit; ++at) before = at;
  const double share = (before->second - limit) / (before->second - at->second);
  return before->first + share * (at->first - before->first);
}

class Refiner {
 public:
  Refiner(const Identification& start, const CandidateData& asked, const Selection& selection,
          bool changes, const std::vector<std::string>& train, const IdentificationOptions& how,
          const std::vector<Shapes>& known)
      : start_(start), asked_(asked), changes_(changes), train_(train), how_(how) {
    arm_.emplace(changes ? with_fixed_parameters(*start.model) : *start.model);
    for (const Accepted& a : selection.accepted) {
      const Hypothesis& h = asked.augmented.hypotheses[a.evidence.hypothesis];
      chosen_.push_back(h);
      shapes_.emplace_back();
      if (is_load(h)) continue;
      for (const auto& [key, value] : term_of(asked.augmented.model, h).values) {
        if (searched(h, key)) shapes_.back()[key] = value;
      }
    }
    if (!known.empty()) shapes_ = known;
  }

  const std::vector<Shapes>& shapes() const { return shapes_; }

  bool anything() const {
    return std::any_of(shapes_.begin(), shapes_.end(), [](const Shapes& s) { return !s.empty(); });
  }

  void descend() {
    for (size_t round = 0; round < numerics::kShapeFactors.size(); ++round) run(numerics::kShapeFactors[round]);
  }

  AugmentedModel model() const {
    std::vector<Variant> variants = present();
    return model_with(*arm_, asked_.augmented, variants);
  }

  // All values of a constant, everything else fitted anew for each, whose misfit is not certainly larger
  // than the least one: the ratio of likelihoods, scaled by what differs between clusters. To either side of
  // the least one a difference is half of its slope's share, hence the factor of two.
  std::vector<ShapeInterval> profile() const {
    std::vector<Variant> variants = variants_at(numerics::kShapeProfile);
    const CandidateData q =
        prepare(start_, model_with(*arm_, asked_.augmented, variants), changes_, train_, {}, how_);
    const NormalBlocks data(q.train, q.columns);
    std::vector<ColumnSet> columns;
    for (const Hypothesis& h : q.augmented.hypotheses) columns.push_back(columns_of(data, h));
    const auto set_with = [&](size_t k, size_t variant) {
      ColumnSet out = q.base;
      for (size_t other = 0; other < chosen_.size(); ++other) {
        const ColumnSet& own = columns[other == k ? variant : other];
        out.insert(out.end(), own.begin(), own.end());
      }
      return out;
    };
    const VectorXd w = joint_weights(data, set_with(0, 0));
    const VectorXd least = misfits(data, set_with(0, 0), w);
    const auto clusters = static_cast<double>(data.clusters());
    const double t = student_t_quantile(numerics::kOutside, std::max(1, data.clusters() - 1));
    std::vector<ShapeInterval> out;
    for (size_t k = 0; k < chosen_.size(); ++k) {
      for (const auto& [key, value] : shapes_[k]) {
        std::map<double, double> worse = {{std::log(value), 0.0}};  // over its deviation, by ln(constant)
        for (size_t v = chosen_.size(); v < variants.size(); ++v) {
          if (variants[v].of != k || variants[v].moved != key) continue;
          const VectorXd more = misfits(data, set_with(k, v), w) - least;
          const double square = (more.array() - more.mean()).square().sum() * clusters / std::max(1.0, clusters - 1.0);
          worse[std::log(variants[v].shapes.at(key))] =
              2.0 * more.sum() / std::max(std::sqrt(square), numerics::kTiny);
        }
        const EffectShape shape = *shape_of(effect_of(chosen_[k].cause), key);
        const double open = std::exp(numerics::kShapeOpen);
        out.push_back({static_cast<int>(k), key,
                       std::min(value / open, std::exp(border(worse.begin(), worse.end(), t, std::log(shape.lower)))),
                       std::max(value * open, std::exp(border(worse.rbegin(), worse.rend(), t, std::log(shape.upper))))});
      }
    }
    return out;
  }

 private:
  std::vector<Variant> present() const {
    std::vector<Variant> out;
    for (size_t k = 0; k < chosen_.size(); ++k) out.push_back({chosen_[k], shapes_[k], k, "", 1.0});
    return out;
  }

  // One wave per travel, in the units of an order.
  double one_wave(JointIndex joint) const {
    double travel = numerics::kSmallestTravel;
    for (const CompressedRecording& r : start_.factors)
      travel = std::max(travel, r.joints[joint.value].travel());
    return 2.0 * M_PI / travel;
  }

  template <typename Factors>
  std::vector<Variant> variants_at(const Factors& factors) const {
    std::vector<Variant> variants = present();
    // Two memories of one joint may reach the same value; columns are identified by name, so only
    // one of them may have it.
    std::set<std::tuple<Candidate, std::string, std::string>> taken;
    const auto label = [](const Variant& v, const std::string& key) {
      return std::make_tuple(Candidate(v.hypothesis), key, fmt::format("{:.4g}", v.shapes.at(key)));
    };
    for (const Variant& v : variants) {
      for (const auto& [key, value] : v.shapes) taken.insert(label(v, key));
    }
    for (size_t k = 0; k < chosen_.size(); ++k) {
      for (const auto& [key, value] : shapes_[k]) {
        const EffectShape shape = *shape_of(effect_of(chosen_[k].cause), key);
        for (const double wide : factors) {
          // A wave number is known to a share of one wave per travel.
          const double factor =
              shape.scale == ShapeScale::kWaves
                  ? 1.0 + numerics::kWaveStep * (wide - 1.0) * one_wave(*chosen_[k].joint) / value
                  : wide;
          const double moved = value * factor;
          if (moved < shape.lower || moved > shape.upper) continue;
          Variant v{chosen_[k], shapes_[k], k, key, factor};
          v.shapes[key] = moved;
          if (!taken.insert(label(v, key)).second) continue;
          variants.push_back(std::move(v));
        }
      }
    }
    return variants;
  }

  void run(const std::array<double, 6>& factors) {
    std::vector<Variant> variants = variants_at(factors);
    const CandidateData q =
        prepare(start_, model_with(*arm_, asked_.augmented, variants), changes_, train_, {}, how_);
    const NormalBlocks data(q.train, q.columns);
    std::vector<ColumnSet> columns;
    for (const Hypothesis& h : q.augmented.hypotheses) columns.push_back(columns_of(data, h));
    std::vector<size_t> pick(chosen_.size());
    for (size_t k = 0; k < pick.size(); ++k) pick[k] = k;
    const auto set_of = [&](const std::vector<size_t>& choice) {
      ColumnSet set = q.base;
      for (const size_t v : choice) set.insert(set.end(), columns[v].begin(), columns[v].end());
      return set;
    };
    const VectorXd w = joint_weights(data, set_of(pick));
    // Twice round the constants: a later one may move an earlier one again.
    for (int turn = 0; turn < 2; ++turn) {
      for (size_t v = chosen_.size(); v < variants.size(); ++v) {
        std::vector<size_t> other = pick;
        other[variants[v].of] = v;
        if (misfit(data, set_of(other), w, nullptr) < misfit(data, set_of(pick), w, nullptr))
          pick = other;
      }
    }
    for (size_t k = 0; k < chosen_.size(); ++k) shapes_[k] = variants[pick[k]].shapes;
  }

  // Misfit of every cluster with the linear parameters that all of them give.
  static VectorXd misfits(const NormalBlocks& data, const ColumnSet& set, const VectorXd& w) {
    VectorXd x;
    misfit(data, set, w, &x);
    VectorXd out(data.clusters());
    for (int c = 0; c < data.clusters(); ++c)
      out[c] = (w.array() * data.residual2(set, x, data.cluster(c)).array()).sum();
    return out;
  }

  const Identification& start_;
  const CandidateData& asked_;
  bool changes_;
  const std::vector<std::string>& train_;
  const IdentificationOptions& how_;
  std::optional<Model> arm_;
  std::vector<Hypothesis> chosen_;
  std::vector<Shapes> shapes_;
};

}  // namespace

bool has_searched_shape(const CandidateData& asked, const Hypothesis& hypothesis) {
  if (is_load(hypothesis)) return false;
  const EffectTerm& term = term_of(asked.augmented.model, hypothesis);
  return std::any_of(term.values.begin(), term.values.end(),
                     [&](const auto& value) { return searched(hypothesis, value.first); });
}

RefinedShapes refine_shapes(const Identification& start, const CandidateData& asked,
                            const Selection& selection, bool changes,
                            const std::vector<std::string>& train, const IdentificationOptions& how,
                            const std::vector<Shapes>& known) {
  Refiner refiner(start, asked, selection, changes, train, how, known);
  const bool anything = refiner.anything();
  if (anything) refiner.descend();
  return {refiner.model(), refiner.shapes(), anything};
}

std::vector<ShapeInterval> shape_intervals(const Identification& start, const CandidateData& asked,
                                           const Selection& selection, bool changes,
                                           const std::vector<std::string>& train,
                                           const IdentificationOptions& how, const std::vector<Shapes>& found) {
  const Refiner refiner(start, asked, selection, changes, train, how, found);
  return refiner.anything() ? refiner.profile() : std::vector<ShapeInterval>();
}

}  // namespace veridyn
