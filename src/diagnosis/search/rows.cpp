#include "diagnosis/search/rows.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>

#include "diagnosis/numerics.hpp"
#include "diagnosis/search/numbers.hpp"
#include "math/zero_phase_filter.hpp"
#include "regressor/effect_along.hpp"
#include "veridyn/effects/channel_effect.hpp"
#include "veridyn/math/parallel.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::search {
namespace {

// The options of one recording, with all of its rows.
PreprocessingOptions with_all_rows(PreprocessingOptions how) {
  how.excluded_intervals.clear();
  how.min_speed = 0.0;
  return how;
}

// The usable samples of a segment's core at every `step`-th time of its grid.
std::vector<Eigen::Index> kept_samples(const Segment& s, int step) {
  std::vector<Eigen::Index> out;
  for (Eigen::Index k = s.core_begin; k < s.core_end; ++k) {
    if (s.use[k] != 0 && std::lround((s.time[k] - s.start) / s.dt) % step == 0) out.push_back(k);
  }
  return out;
}

bool is_excluded(const PreprocessingOptions& how, const std::string& source, int joint, double time) {
  return std::any_of(how.excluded_intervals.begin(), how.excluded_intervals.end(), [&](const ExcludedInterval& part) {
    return part.source == source && (!part.joint || part.joint->value == joint) && time >= part.from && time <= part.to;
  });
}

}  // namespace

Rows::Rows(const Model& arm, const std::vector<std::string>& recordings, const PreprocessingOptions& how, int threads)
    : arm_(arm), how_(how), bodies_(arm) {
  const int n = arm.joints();
  const PreprocessingOptions all = with_all_rows(how);
  const RegressorColumns columns(arm, all);
  names_ = parameter_names(columns.parameters());
  VectorXd values(names_.size());
  for (Eigen::Index p = 0; p < values.size(); ++p) values[p] = columns.parameters()[p].value;
  phi_ = arm.inertial_values().value_or(VectorXd::Zero(kBodyParameters * static_cast<Eigen::Index>(arm.bodies().size())));
  std::vector<std::vector<JointRows>> pieces;
  std::vector<MatrixXd> torques;
  for (size_t r = 0; r < recordings.size(); ++r) {
    for_each_segment(arm, recordings[r], all, [&](const Segment& s) {
      Stretch one{s, r, kept_samples(s, decimation(all, s.dt)), rows_, {}, {}};
      if (one.kept.empty()) return;
      const std::vector<RegressorColumns::Joints> groups = columns.groups(s.q.rows());
      std::vector<std::vector<JointRows>> of_group(groups.size());
      parallel_for(static_cast<int>(groups.size()) + 1, threads, [&](int k) {
        if (k > 0) {
          of_group[k - 1] = columns.rows(s, groups[k - 1]);
          return;
        }
        one.load = rigid_load(arm, bodies_, MotionView(s.time, s.q, s.dq, s.ddq));
        if (all.filtering == Filtering::kMatched && all.cutoff > 0.0)
          ZeroPhaseFilter(kLoadCutoffShare * all.cutoff, all.order, 1.0 / s.dt).apply(one.load);
        PreprocessingOptions raw = all;
        raw.cutoff = 0.0;
        one.torque = RegressorColumns(arm, raw).predict(s, values).modelled;
      });
      pieces.emplace_back();
      for (std::vector<JointRows>& some : of_group) std::move(some.begin(), some.end(), std::back_inserter(pieces.back()));
      torques.push_back(columns.filtered_torque(s));
      rows_ += static_cast<Eigen::Index>(one.kept.size());
      for (const Eigen::Index k : one.kept) {
        time_.push_back(s.time[k] - s.start);
        recording_.push_back(r);
      }
      stretches_.push_back(std::move(one));
    });
  }
  measured.resize(rows_, n);
  residual.resize(rows_, n);
  used.setOnes(rows_, n);
  own.resize(n);
  own_parameters.resize(n);
  for (size_t p = 0; p < pieces.size(); ++p) {
    const Stretch& one = stretches_[p];
    const auto count = static_cast<Eigen::Index>(one.kept.size());
    for (int i = 0; i < n; ++i) {
      const JointRows& rows = pieces[p][i];
      if (p == 0) {
        own[i].resize(rows_, rows.A.cols());
        own_parameters[i] = rows.parameters;
      }
      // Rows contain the torque with a wrong gain corrected; errors refer to the torque as recorded.
      const double gain = arm.coordinates()[i].recorded.torque_gain;
      own[i].middleRows(one.first, count) = gain * rows.A;
      residual.col(i).segment(one.first, count) = gain * (rows.b - rows.A * values(rows.parameters));
      for (Eigen::Index k = 0; k < count; ++k) {
        const Eigen::Index at = one.kept[k];
        measured(one.first + k, i) = gain * torques[p](at, i);
        const double time = time_[one.first + k];
        if (is_excluded(how, recordings[one.recording], i, time) || std::abs(one.segment.dq(at, i)) < how.min_speed)
          used(one.first + k, i) = 0.0;
      }
    }
  }
}

void Rows::put(const Stretch& stretch, MatrixXd columns, MatrixXd& into) const {
  if (how_.filtering == Filtering::kMatched && how_.cutoff > 0.0)
    ZeroPhaseFilter(how_.cutoff, how_.order, 1.0 / stretch.segment.dt).apply(columns);
  for (size_t k = 0; k < stretch.kept.size(); ++k)
    into.row(stretch.first + static_cast<Eigen::Index>(k)) = columns.row(stretch.kept[k]);
}

Folds folds_of(const Rows& rows, const std::vector<double>& periods, double cutoff, double block_seconds) {
  Folds out;
  const size_t recordings = periods.size();
  std::vector<double> first(recordings, 0.0), last(recordings, 0.0);
  for (Eigen::Index k = rows.rows(); k-- > 0;) first[rows.recording()[k]] = rows.time()[k];
  for (Eigen::Index k = 0; k < rows.rows(); ++k) last[rows.recording()[k]] = rows.time()[k];
  const int parts = recordings >= kWholeRecordings ? 1 : static_cast<int>((kParts + recordings - 1) / recordings);
  out.count = parts == 1 ? std::min(static_cast<int>(recordings), kParts) : parts * static_cast<int>(recordings);
  const auto phase = [&](Eigen::Index k) {
    const size_t r = rows.recording()[k];
    const double length = periods[r] > 0.0 ? periods[r] : last[r] - first[r] + numerics::kNoise;
    const double turns = (rows.time()[k] - (periods[r] > 0.0 ? 0.0 : first[r])) / length;
    return turns - std::floor(turns);
  };
  std::map<std::pair<size_t, int>, int> blocks;
  for (Eigen::Index k = 0; k < rows.rows(); ++k) {
    const size_t r = rows.recording()[k];
    const int part = std::min(static_cast<int>(phase(k) * parts), parts - 1);
    out.of_row.push_back(parts == 1 ? static_cast<int>(r) % out.count : part * static_cast<int>(recordings) + static_cast<int>(r));
    const double length = periods[r] > 0.0 ? periods[r] : last[r] - first[r];
    const int count = std::max((kFewestBlocks + static_cast<int>(recordings) - 1) / static_cast<int>(recordings), static_cast<int>(length / block_seconds));
    const int block = std::min(static_cast<int>(phase(k) * count), count - 1);
    out.block.push_back(blocks.emplace(std::make_pair(r, block), static_cast<int>(blocks.size())).first->second);
  }
  out.blocks = static_cast<int>(blocks.size());
  if (parts == 1 || cutoff <= 0.0) return out;
  // The filter spreads rows across a border, so that folds would share information.
  const double margin = 0.5 / cutoff;
  const std::vector<int> whole = out.of_row;
  for (Eigen::Index k = 1; k < rows.rows(); ++k) {
    if (whole[k] == whole[k - 1] || rows.recording()[k] != rows.recording()[k - 1]) continue;
    const double border = rows.time()[k];
    for (Eigen::Index at = k; at < rows.rows() && std::abs(rows.time()[at] - border) < margin; ++at) out.of_row[at] = -1;
    for (Eigen::Index at = k; at-- > 0 && std::abs(rows.time()[at] - border) < margin;) out.of_row[at] = -1;
  }
  return out;
}

}  // namespace veridyn::search
