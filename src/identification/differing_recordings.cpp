#include "identification/differing_recordings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "identification/base_solution.hpp"
#include "identification/estimation/least_squares.hpp"
#include "identification/identification_numbers.hpp"

namespace veridyn {
namespace {

using Joints = std::vector<SquareRootInformation>;

void merge(Joints& into, const Joints& other) {
  if (into.empty()) into = other;
  else for (size_t i = 0; i < into.size(); ++i) into[i].merge(other[i]);
}

// Sums of squares of the joints for these parameters.
VectorXd squares_of(const Joints& joints, const VectorRef& beta) {
  VectorXd out(static_cast<Eigen::Index>(joints.size()));
  for (size_t i = 0; i < joints.size(); ++i) out[static_cast<Eigen::Index>(i)] = joints[i].residual2(beta);
  return out;
}

class Comparison {
 public:
  Comparison(const Model& arm, const std::vector<CompressedRecording>& recordings) : weights_(range_weights(recordings)) {
    const std::vector<std::string> names = parameter_names(standard_parameters(arm));
    for (const int j : identifiable_base_parameters(arm).independent) columns_.push_back(names[static_cast<size_t>(j)]);
    for (const CompressedRecording& r : recordings) add(r);
  }

  // True if the common fit to `recordings` has a far larger error on one of `some` than a fit to that one
  // alone; sets `worst` to the joint and recording where it is largest, in any case.
  bool differ(const std::vector<size_t>& recordings, const std::vector<size_t>& some) {
    Joints total;
    for (const size_t r : recordings) merge(total, all_[r]);
    const VectorXd common = solution_of(total);
    double most = -1.0;
    for (const size_t r : some) {
      const VectorXd with = squares_of(all_[r], common);
      for (Eigen::Index i = 0; i < with.size(); ++i) {
        const double torque2 = all_[r][static_cast<size_t>(i)].rhs_norm2(), ratio = std::sqrt(with[i] / own_[r][i]);
        const double limit = identifying::numbers.far_above_floor * within_[r][i], error = std::sqrt(with[i] / torque2);
        const double excess = error > identifying::numbers.below_any_sensor ? ratio / limit : 0.0;
        if (!(excess > most)) continue;
        most = excess;
        worst = {r, static_cast<size_t>(i), error, std::sqrt(own_[r][i] / torque2)};
      }
    }
    return most > 1.0;
  }

  // Index in `recordings` of the one without which the others are fitted best.
  size_t outlier_recording(const std::vector<size_t>& recordings) const {
    std::vector<SquareRootInformation> each;
    for (const size_t r : recordings) each.push_back(weighted_total(all_[r], weights_, columns_));
    const MatrixXd without = solutions_without(each);
    VectorXd left = VectorXd::Zero(without.cols());
    for (size_t k = 0; k < each.size(); ++k)
      for (Eigen::Index o = 0; o < left.size(); ++o)
        left[o] += static_cast<size_t>(o) == k ? each[k].rho2() : each[k].residual2(without.col(o));
    Eigen::Index least = 0;
    left.minCoeff(&least);
    return static_cast<size_t>(least);
  }

  struct Worst {
    size_t recording, joint;
    double common, own;  // relative errors
  } worst = {};

 private:
  VectorXd solution_of(const Joints& joints) const { return least_squares(weighted_total(joints, weights_, columns_)); }

  void add(const CompressedRecording& recording) {
    Joints halves[2], all;
    for (size_t k = 0; k < recording.blocks.size(); ++k) {
      Joints block = recording.blocks[k];
      for (SquareRootInformation& joint : block) joint = joint.restricted(columns_);
      merge(halves[2 * k / recording.blocks.size()], block);
    }
    double rows = 0.0;
    VectorXd of_all = VectorXd::Zero(weights_.size()), of_own = of_all;
    for (const Joints& half : halves) {
      if (!half.empty()) merge(all, half);
    }
    for (const SquareRootInformation& joint : all) rows += joint.rows();
    const VectorXd beta = solution_of(all);
    for (const Joints& half : halves) {
      if (half.empty()) continue;
      of_all += squares_of(half, beta);
      of_own += squares_of(half, solution_of(half));
    }
    // The rows are sampled at four times the cut-off, so that two of them are one independent sample. With few
    // samples any parameters fit.
    const double freedom = std::max(0.0, 1.0 - 2.0 * static_cast<double>(columns_.size()) / rows);
    own_.push_back(squares_of(all, beta) / freedom);
    within_.push_back((of_all.array() / of_own.array()).sqrt().max(1.0));
    all_.push_back(std::move(all));
  }

  VectorXd weights_;
  std::vector<std::string> columns_;
  std::vector<Joints> all_;
  std::vector<VectorXd> own_, within_;  // squared errors with a recording's own parameters; ratio of the errors on
                                        // its halves, fitted together and apart
};

}  // namespace

std::string differing_recordings(const Model& arm, const Identification& id) {
  const bool small = std::all_of(id.train.begin(), id.train.end(), [](const RecordingError& r) { return (r.error.relative.array() <= identifying::numbers.below_any_sensor).all(); });
  if (id.factors.size() < 2 || small) return "";
  Comparison comparison(arm, id.factors);
  std::vector<size_t> all, odd;
  for (size_t r = 0; r < id.factors.size(); ++r) all.push_back(r);
  std::vector<size_t> alike = all;
  comparison.differ(all, all);
  const Comparison::Worst of_all = comparison.worst;
  while (alike.size() > 1 && comparison.differ(alike, alike)) {
    const auto at = alike.begin() + static_cast<long>(comparison.outlier_recording(alike));
    odd.push_back(*at);
    alike.erase(at);
  }
  if (odd.empty()) return "";
  std::sort(odd.begin(), odd.end());
  const bool pair = all.size() == 2;
  comparison.differ(all, pair ? all : odd);
  std::string names;
  for (const size_t r : pair ? all : odd) names += (names.empty() ? "" : pair ? " and " : ", ") + id.factors[r].source;
  const auto& worst = comparison.worst;
  if (!std::isfinite(worst.own)) return "";  // too short
  const std::string& source = id.factors[worst.recording].source;
  // What a recording that no arm fits does to the common fit may show in the others alone.
  const auto percent = [](double share) { return fmt::format("{:.2g} %", 100.0 * share); };
  const bool own = percent(worst.common) != percent(worst.own);
  const auto& shown = own ? worst : of_all;
  return fmt::format("{} differ{}: one fit to all leaves {} of the torque of {} in {}, a fit to {} alone {}. {} Identify without it "
                     "(--model-out M.yaml): `veridyn diagnose M.yaml --train {} --test REC` asks what changed",
                     names, pair ? "" : odd.size() == 1 ? "s from the other training recordings" : " from the other training recordings", percent(shown.common),
                     arm.coordinates()[shown.joint].name, id.factors[shown.recording].source, own ? "this one" : id.factors[shown.recording].source, percent(shown.own),
                     worst.own <= identifying::numbers.below_any_sensor ? "Another load, friction or time?" : fmt::format("No arm of this file fits {} alone: a wrong file or column, or something that the model lacks?", source), source);
}

std::string recordings_apart(const Identification& evaluated) {
  std::vector<const RecordingError*> all;
  for (const auto* list : {&evaluated.train, &evaluated.test}) {
    for (const RecordingError& r : *list) all.push_back(&r);
  }
  std::string names;
  const RecordingError *worst = nullptr, *best = nullptr;
  Eigen::Index joint = 0;
  double most = identifying::numbers.outstanding;
  for (const RecordingError* r : all) {
    bool apart = false;
    for (Eigen::Index i = 0; i < r->error.relative.size(); ++i) {
      const double floor = evaluated.noise_floor.size() > i ? evaluated.noise_floor[i] : 0.0;
      const double limit = std::max(identifying::numbers.below_any_sensor, identifying::numbers.far_above_floor * floor);
      const RecordingError* least = *std::min_element(all.begin(), all.end(), [i](const auto* a, const auto* b) { return a->error.relative[i] < b->error.relative[i]; });
      const double times = r->error.relative[i] / limit;
      if (!std::isfinite(times) || !(times > identifying::numbers.outstanding) || least->error.relative[i] > limit) continue;
      apart = true;
      if (times > most) most = times, worst = r, best = least, joint = i;
    }
    if (apart) names += (names.empty() ? "" : ", ") + r->source;
  }
  if (worst == nullptr) return "";
  return fmt::format("{} differ{} from the other recordings: the model leaves {:.2g} % of the torque of {} in {}, {:.2g} % in {}. Another load, friction, offset or arm? "
                     "`veridyn diagnose MODEL --train {} --test REC` asks what changed",
                     names, names == worst->source ? "s" : "", 100.0 * worst->error.relative[joint], evaluated.model->coordinates()[static_cast<size_t>(joint)].name, worst->source,
                     100.0 * best->error.relative[joint], best->source, worst->source);
}

}  // namespace veridyn
