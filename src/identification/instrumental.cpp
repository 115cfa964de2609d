#include "identification/instrumental.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "identification/identification_numbers.hpp"
#include "math/decompositions.hpp"
#include "math/student_t.hpp"
#include "math/zero_phase_filter.hpp"
#include "veridyn/identification/regressor_columns.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

// A whole recording on its uniform grid: low-passed positions with their derivatives.
struct SmoothMotion {
  double dt = 0.0, start = 0.0, period = 0.0;
  VectorXd time;
  MatrixXd q, dq, ddq;
  std::vector<char> use;

  // The mean over the same phase of other periods, or the motion itself where there is none.
  void at(double t, Eigen::Ref<VectorXd> q_out, Eigen::Ref<VectorXd> dq_out, Eigen::Ref<VectorXd> ddq_out) const {
    q_out.setZero();
    dq_out.setZero();
    ddq_out.setZero();
    int count = 0;
    const auto add = [&](double when) {
      const double place = (when - time[0]) / dt;
      const auto k = static_cast<Eigen::Index>(std::floor(place));
      if (k < 0 || k + 1 >= time.size() || use[k] == 0 || use[k + 1] == 0) return;
      const double share = place - static_cast<double>(k);
      q_out += (1.0 - share) * q.row(k).transpose() + share * q.row(k + 1).transpose();
      dq_out += (1.0 - share) * dq.row(k).transpose() + share * dq.row(k + 1).transpose();
      ddq_out += (1.0 - share) * ddq.row(k).transpose() + share * ddq.row(k + 1).transpose();
      ++count;
    };
    const double last = time[time.size() - 1];
    for (double when = t + period; period > 0.0 && when <= last; when += period) add(when);
    for (double when = t - period; period > 0.0 && when >= time[0]; when -= period) add(when);
    if (count > 0) {
      q_out /= count;
      dq_out /= count;
      ddq_out /= count;
      return;
    }
    const auto nearest = std::clamp<Eigen::Index>(std::lround((t - time[0]) / dt), 0, time.size() - 1);
    q_out = q.row(nearest).transpose();
    dq_out = dq.row(nearest).transpose();
    ddq_out = ddq.row(nearest).transpose();
  }
};

SmoothMotion smooth_motion(const Model& arm, const CompressedRecording& recording, const PreprocessingOptions& how) {
  SmoothMotion out;
  out.period = recording.period.seconds;
  std::vector<double> time;
  std::vector<VectorXd> rows;
  for_each_segment(arm, recording.source, how, [&](const Segment& s) {
    out.dt = s.dt;
    out.start = s.start;
    for (Eigen::Index k = s.core_begin; k < s.core_end; ++k) {
      time.push_back(s.time[k]);
      rows.push_back(s.q.row(k).transpose());
      out.use.push_back(s.use[k]);
    }
  });
  out.time = VectorXd::Map(time.data(), static_cast<Eigen::Index>(time.size()));
  out.q.resize(out.time.size(), arm.joints());
  for (Eigen::Index k = 0; k < out.time.size(); ++k) out.q.row(k) = rows[k].transpose();
  const double rate = 1.0 / out.dt;
  if (how.cutoff > 0.0 && how.cutoff < identifying::kBelowNyquist * rate) ZeroPhaseFilter(how.cutoff, how.order, rate).apply(out.q);
  out.dq = differentiate(out.q, out.dt);
  out.ddq = differentiate(out.dq, out.dt);
  return out;
}

// One joint's columns: measured, without noise, and the torque that belongs to the latter.
struct JointColumns {
  std::vector<int> unknowns;  // indices of base parameters
  std::vector<std::string> names;

  JointColumns(const std::vector<int>& parameters, const BaseParameters& base) {
    for (size_t u = 0; u < base.independent.size(); ++u) {
      if (std::find(parameters.begin(), parameters.end(), base.independent[u]) != parameters.end()) unknowns.push_back(static_cast<int>(u));
    }
    for (const char* kind : {"measured ", "clean "}) {
      for (const int u : unknowns) names.push_back(kind + std::to_string(u));
    }
    names.emplace_back("torque");
  }

  Eigen::Index count() const { return static_cast<Eigen::Index>(unknowns.size()); }
};

MatrixXd chosen(const JointRows& rows, const JointColumns& joint, const BaseParameters& base) {
  MatrixXd out(rows.A.rows(), joint.count());
  for (Eigen::Index c = 0; c < joint.count(); ++c) {
    const int parameter = base.independent[joint.unknowns[c]];
    const auto at = std::find(rows.parameters.begin(), rows.parameters.end(), parameter) - rows.parameters.begin();
    out.col(c) = rows.A.col(at);
  }
  return out;
}

using BlocksOfJoints = std::vector<std::vector<SquareRootInformation>>;  // [block][joint]

void absorb(const Model& arm, const CompressedRecording& recording, const IdentificationOptions& options,
            const BaseParameters& base, const std::vector<JointColumns>& joints, BlocksOfJoints& blocks) {
  PreprocessingOptions how = options.preprocessing;
  how.excluded_intervals.erase(std::remove_if(how.excluded_intervals.begin(), how.excluded_intervals.end(),
                                    [&](const ExcludedInterval& part) { return part.source != recording.source; }),
                     how.excluded_intervals.end());
  const SmoothMotion smooth = smooth_motion(arm, recording, how);
  const RegressorColumns columns(arm, how);
  const size_t first = blocks.size();
  const size_t count = recording.blocks.size();  // those of least squares, for the jackknife
  for (size_t b = 0; b < count; ++b) {
    blocks.emplace_back();
    for (const JointColumns& joint : joints) blocks.back().emplace_back(joint.names);
  }
  const double length = std::max(smooth.time[smooth.time.size() - 1] - smooth.start, smooth.dt);
  const auto block_of = [&](double time) {
    const double turns = smooth.period > 0.0 ? time / smooth.period : identifying::kEndOfTime * std::clamp(time / length, 0.0, 1.0);
    return first + std::min(count - 1, static_cast<size_t>(static_cast<double>(count) * (turns - std::floor(turns))));
  };
  for_each_segment(arm, recording.source, how, [&](const Segment& s) {
    Segment clean = s;
    VectorXd q(arm.joints()), dq(arm.joints()), ddq(arm.joints());
    for (Eigen::Index k = 0; k < s.time.size(); ++k) {
      smooth.at(s.time[k], q, dq, ddq);
      clean.q.row(k) = q.transpose();
      clean.dq.row(k) = dq.transpose();
      clean.ddq.row(k) = ddq.transpose();
    }
    const std::vector<JointRows> measured = columns.rows(s);
    const std::vector<JointRows> without = columns.rows(clean);
    for (size_t i = 0; i < joints.size(); ++i) {
      const JointRows& rows = measured[i];
      MatrixXd A(rows.b.size(), 2 * joints[i].count() + 1);
      A.leftCols(joints[i].count()) = chosen(rows, joints[i], base);
      A.middleCols(joints[i].count(), joints[i].count()) = chosen(without[i], joints[i], base);
      A.rightCols(1) = without[i].b;
      for (Eigen::Index at = 0; at < rows.b.size();) {
        const size_t block = block_of(rows.time[at]);
        Eigen::Index end = at;
        while (end < rows.b.size() && block_of(rows.time[end]) == block) ++end;
        blocks[block][i].absorb(A.middleRows(at, end - at), rows.b.segment(at, end - at));
        at = end;
      }
    }
  });
}

// Moments of a block over all base parameters.
struct CrossMoments {
  MatrixXd ZA, ZZ;
  VectorXd Zb, Zc;

  explicit CrossMoments(Eigen::Index k) : ZA(MatrixXd::Zero(k, k)), ZZ(ZA), Zb(VectorXd::Zero(k)), Zc(Zb) {}

  void add(double sign, const CrossMoments& o) {
    ZA += sign * o.ZA;
    ZZ += sign * o.ZZ;
    Zb += sign * o.Zb;
    Zc += sign * o.Zc;
  }
};

CrossMoments cross_moments(const std::vector<SquareRootInformation>& block, const std::vector<JointColumns>& joints,
                           const VectorRef& weights, const VectorXd& scale) {
  CrossMoments out(scale.size());
  for (size_t i = 0; i < joints.size(); ++i) {
    const double w = std::pow(weights[static_cast<Eigen::Index>(i)], 2);
    const MatrixXd R = block[i].R();
    const MatrixXd G = R.transpose() * R;
    const VectorXd g = R.transpose() * block[i].z();
    const Eigen::Index k = joints[i].count();
    for (Eigen::Index r = 0; r < k; ++r) {
      const int row = joints[i].unknowns[r];
      for (Eigen::Index c = 0; c < k; ++c) {
        const int column = joints[i].unknowns[c];
        const double size = scale[row] * scale[column];
        out.ZA(row, column) += w * G(k + r, c) / size;
        out.ZZ(row, column) += w * G(k + r, k + c) / size;
      }
      out.Zb[row] += w * g[k + r] / scale[row];
      out.Zc[row] += w * G(k + r, 2 * k) / scale[row];
    }
  }
  return out;
}

VectorXd estimate(const CrossMoments& m, Method method, const VectorXd& scale) {
  const bool instruments = method == Method::kIv;
  const Eigen::ColPivHouseholderQR<MatrixXd> qr(instruments ? m.ZA : m.ZZ);
  return qr.solve(instruments ? m.Zb : m.Zc).cwiseQuotient(scale);
}

// Residual of least squares on some columns of a factor, and their rank.
std::pair<double, int> residual_on(const SquareRootInformation& factor, const MatrixXd& T) {
  const Eigen::ColPivHouseholderQR<MatrixXd> qr = [&] {
    MatrixXd A = factor.R() * T;
    for (Eigen::Index c = 0; c < A.cols(); ++c) A.col(c) /= std::max(A.col(c).norm(), 1e-300);
    Eigen::ColPivHouseholderQR<MatrixXd> out(A.rows(), A.cols());
    out.setThreshold(identifying::kDependentColumn);
    out.compute(A);
    return out;
  }();
  const auto rank = static_cast<int>(qr.rank());
  VectorXd turned = qr.householderQ().transpose() * factor.z();
  turned.head(rank).setZero();
  return {turned.squaredNorm() + factor.rho2(), rank};
}

// Durbin-Wu-Hausman by the augmented regression: if the measured columns carry no noise that is
// correlated with the torque's, the difference of the two motions' columns explains nothing more.
EndogeneityTest endogeneity(const SquareRootInformation& factor, Eigen::Index k, double independent_share) {
  if (k == 0) return {};  // all of the joint's parameters are facts
  MatrixXd measured = MatrixXd::Zero(2 * k + 1, k);
  measured.topRows(k).setIdentity();
  MatrixXd both = MatrixXd::Zero(2 * k + 1, 2 * k);
  both.leftCols(k) = measured;
  both.topRightCorner(k, k).setIdentity();
  both.block(k, k, k, k) = -MatrixXd::Identity(k, k);
  const auto [plain, rank] = residual_on(factor, measured);
  const auto [augmented, all] = residual_on(factor, both);
  EndogeneityTest out;
  out.numerator_freedom = all - rank;
  out.denominator_freedom = std::max(1.0, independent_share * factor.rows() - all);
  if (all == rank || !(augmented > 0.0)) return out;
  const double per_row = augmented / std::max(1.0, factor.rows() - all);
  out.statistic = independent_share * std::max(0.0, plain - augmented) / (out.numerator_freedom * per_row);
  out.p_value = fisher_f_upper_tail(out.statistic, out.numerator_freedom, out.denominator_freedom);
  return out;
}

}  // namespace

InstrumentalFit fit_with_instruments(const Model& arm, const std::vector<CompressedRecording>& recordings,
                                     const BaseParameters& base, const VectorRef& weights,
                                     const IdentificationOptions& options) {
  require(options.preprocessing.min_speed == 0.0,
          "identify: found a least speed together with instruments, whose motion is another one; expected none.");
  const RegressorColumns columns(arm, options.preprocessing);
  std::vector<JointColumns> joints;
  for (int i = 0; i < arm.joints(); ++i) joints.emplace_back(columns.parameters_of(i), base);
  BlocksOfJoints blocks;
  for (const CompressedRecording& recording : recordings) {
    require(!recording.detached, recording.source,
            ": found factors alone, expected the recording itself: instruments need its samples.");
    absorb(arm, recording, options, base, joints, blocks);
  }
  VectorXd scale = VectorXd::Zero(base.size());
  double rows = 0.0;
  std::vector<SquareRootInformation> totals;
  for (size_t i = 0; i < joints.size(); ++i) {
    totals.emplace_back(joints[i].names);
    for (const auto& block : blocks) totals.back().merge(block[i]);
    rows += totals.back().rows();
    const VectorXd norms = totals.back().column_norms();
    for (Eigen::Index c = 0; c < joints[i].count(); ++c)
      scale[joints[i].unknowns[c]] += std::pow(weights[static_cast<Eigen::Index>(i)] * norms[c], 2);
  }
  scale = scale.cwiseSqrt().cwiseMax(1e-300);
  std::vector<CrossMoments> moments;
  CrossMoments all(base.size());
  for (const auto& block : blocks) {
    moments.push_back(cross_moments(block, joints, weights, scale));
    all.add(1.0, moments.back());
  }
  const std::vector<std::string> names = parameter_names(standard_parameters(arm));
  InstrumentalFit out;
  out.solution = solve_base(recordings, weights, base, names);
  out.solution.beta = estimate(all, options.method, scale);
  std::vector<std::string> leading;
  for (const int j : base.independent) leading.push_back(names[j]);
  out.objective = weighted_total(joint_totals(recordings), weights, names).restricted(leading).residual2(out.solution.beta);
  MatrixXd without(base.size(), static_cast<Eigen::Index>(blocks.size()));
  for (size_t b = 0; b < blocks.size(); ++b) {
    CrossMoments rest = all;
    rest.add(-1.0, moments[b]);
    without.col(b) = estimate(rest, options.method, scale);
  }
  take_deviations(without, out.solution);
  const double share = std::clamp(out.solution.effective_samples / std::max(1.0, rows), 0.0, 1.0);
  for (size_t i = 0; i < joints.size(); ++i) out.tests.push_back(endogeneity(totals[i], joints[i].count(), share));
  return out;
}

}  // namespace veridyn
