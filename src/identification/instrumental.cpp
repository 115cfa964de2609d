#include "identification/instrumental.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "identification/identification_numbers.hpp"
#include "math/clustered_statistics.hpp"
#include "math/decompositions.hpp"
#include "math/student_t.hpp"
#include "math/zero_phase_filter.hpp"
#include "veridyn/identification/regressor_columns.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

// Source of the instruments' motion: low-passed positions and their derivatives, or the measurements of the
// other repeats; rows that are not repeated are then left out.
enum class Instruments { kPositions, kRepeats };

// A whole recording on its uniform grid.
struct SmoothMotion {
  double dt = 0.0, start = 0.0, period = 0.0;
  VectorXd time;
  MatrixXd q, dq, ddq;
  std::vector<char> use;

  // Computes the mean of the motion at the same phase of all other periods. Returns false, with the motion
  // itself, if there is no other period.
  bool at(double t, Eigen::Ref<VectorXd> q_out, Eigen::Ref<VectorXd> dq_out, Eigen::Ref<VectorXd> ddq_out) const {
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
      return true;
    }
    const auto nearest = std::clamp<Eigen::Index>(std::lround((t - time[0]) / dt), 0, time.size() - 1);
    q_out = q.row(nearest).transpose();
    dq_out = dq.row(nearest).transpose();
    ddq_out = ddq.row(nearest).transpose();
    return false;
  }
};

SmoothMotion smooth_motion(const Model& arm, const CompressedRecording& recording, const PreprocessingOptions& how, Instruments kind) {
  SmoothMotion out;
  out.period = recording.period.seconds;
  std::vector<double> time;
  std::vector<MatrixXd> rows;  // (joints x 3)
  for_each_segment(arm, recording.source, how, [&](const Segment& s) {
    out.dt = s.dt;
    out.start = s.start;
    for (Eigen::Index k = s.core_begin; k < s.core_end; ++k) {
      time.push_back(s.time[k]);
      rows.emplace_back(arm.joints(), 3);
      rows.back() << s.q.row(k).transpose(), s.dq.row(k).transpose(), s.ddq.row(k).transpose();
      out.use.push_back(s.use[k]);
    }
  });
  out.time = VectorXd::Map(time.data(), static_cast<Eigen::Index>(time.size()));
  out.q.resize(out.time.size(), arm.joints());
  out.dq = out.ddq = out.q;
  for (Eigen::Index k = 0; k < out.time.size(); ++k) {
    out.q.row(k) = rows[k].col(0).transpose();
    out.dq.row(k) = rows[k].col(1).transpose();
    out.ddq.row(k) = rows[k].col(2).transpose();
  }
  if (kind == Instruments::kRepeats) return out;
  const double rate = 1.0 / out.dt;
  if (how.cutoff > 0.0 && how.cutoff < identifying::kBelowNyquist * rate) ZeroPhaseFilter(how.cutoff, how.order, rate).apply(out.q);
  out.dq = differentiate(out.q, out.dt);
  out.ddq = differentiate(out.dq, out.dt);
  return out;
}

// One joint's columns along the measured motion and along the noise-free one, and the measured torque.
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

// The columns of a joint's rows that belong to the independent base parameters.
MatrixXd columns_of_base(const JointRows& rows, const JointColumns& joint, const BaseParameters& base) {
  MatrixXd out(rows.A.rows(), joint.count());
  for (Eigen::Index c = 0; c < joint.count(); ++c) {
    const int parameter = base.independent[joint.unknowns[c]];
    const auto at = std::find(rows.parameters.begin(), rows.parameters.end(), parameter) - rows.parameters.begin();
    out.col(c) = rows.A.col(at);
  }
  return out;
}

using BlocksOfJoints = std::vector<std::vector<SquareRootInformation>>;  // [block][joint]

void absorb(const Model& arm, const CompressedRecording& recording, PreprocessingOptions how, Instruments kind,
            const BaseParameters& base, const std::vector<JointColumns>& joints, BlocksOfJoints& blocks) {
  how.excluded_intervals.erase(std::remove_if(how.excluded_intervals.begin(), how.excluded_intervals.end(),
                                    [&](const ExcludedInterval& part) { return part.source != recording.source; }),
                     how.excluded_intervals.end());
  SmoothMotion smooth = smooth_motion(arm, recording, how, kind);
  const RegressorColumns columns(arm, how);
  for (Eigen::Index k = 0; kind == Instruments::kRepeats && k < smooth.time.size(); ++k) {
    bool excluded = true;
    for (int i = 0; i < arm.joints(); ++i) excluded = excluded && columns.is_excluded({i}, smooth.time[k] - smooth.start);
    if (excluded) smooth.use[k] = 0;
  }
  const size_t first = blocks.size();
  const size_t count = recording.blocks.size();  // as many blocks as least squares have, for the jackknife
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
    Segment here = s;
    Segment clean = s;
    VectorXd q(arm.joints()), dq(arm.joints()), ddq(arm.joints());
    for (Eigen::Index k = 0; k < s.time.size(); ++k) {
      const bool repeated = smooth.at(s.time[k], q, dq, ddq);
      if (kind == Instruments::kRepeats && !repeated) here.use[k] = clean.use[k] = 0;
      clean.q.row(k) = q.transpose();
      clean.dq.row(k) = dq.transpose();
      clean.ddq.row(k) = ddq.transpose();
    }
    const std::vector<JointRows> measured = columns.rows(here);
    const std::vector<JointRows> without = columns.rows(clean);
    for (size_t i = 0; i < joints.size(); ++i) {
      const JointRows& rows = measured[i];
      MatrixXd A(rows.b.size(), 2 * joints[i].count() + 1);
      A.leftCols(joints[i].count()) = columns_of_base(rows, joints[i], base);
      A.middleCols(joints[i].count(), joints[i].count()) = columns_of_base(without[i], joints[i], base);
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
  MatrixXd AA, ZA, ZZ;
  VectorXd Ab, Zb, Zc;

  explicit CrossMoments(Eigen::Index k) : AA(MatrixXd::Zero(k, k)), ZA(AA), ZZ(AA), Ab(VectorXd::Zero(k)), Zb(Ab), Zc(Ab) {}

  void add(double sign, const CrossMoments& o) {
    AA += sign * o.AA;
    ZA += sign * o.ZA;
    ZZ += sign * o.ZZ;
    Ab += sign * o.Ab;
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
        out.AA(row, column) += w * G(r, c) / size;
        out.ZA(row, column) += w * G(k + r, c) / size;
        out.ZZ(row, column) += w * G(k + r, k + c) / size;
      }
      out.Ab[row] += w * g[r] / scale[row];
      out.Zb[row] += w * g[k + r] / scale[row];
      out.Zc[row] += w * G(k + r, 2 * k) / scale[row];
    }
  }
  return out;
}

VectorXd solved(const MatrixXd& A, const VectorXd& b, const VectorXd& scale) {
  return Eigen::ColPivHouseholderQR<MatrixXd>(A).solve(b).cwiseQuotient(scale);
}

VectorXd estimate(const CrossMoments& m, Method method, const VectorXd& scale) {
  return method == Method::kIv ? solved(m.ZA, m.Zb, scale) : solved(m.ZZ, m.Zc, scale);
}

// Moments of all recordings, for each block and in total.
struct AllMoments {
  std::vector<JointColumns> joints;
  std::vector<SquareRootInformation> totals;  // factors of the joints
  VectorXd scale;                             // scale of the base parameters' columns
  std::vector<CrossMoments> blocks;
  CrossMoments sum;
  double rows = 0.0;

  AllMoments(const Model& arm, const std::vector<CompressedRecording>& recordings, const BaseParameters& base,
             const VectorRef& weights, const PreprocessingOptions& how, Instruments kind)
      : scale(VectorXd::Zero(base.size())), sum(base.size()) {
    const RegressorColumns columns(arm, how);
    for (int i = 0; i < arm.joints(); ++i) joints.emplace_back(columns.parameters_of({i}), base);
    BlocksOfJoints factors;
    for (const CompressedRecording& recording : recordings) absorb(arm, recording, how, kind, base, joints, factors);
    for (size_t i = 0; i < joints.size(); ++i) {
      totals.emplace_back(joints[i].names);
      for (const auto& block : factors) totals.back().merge(block[i]);
      rows += totals.back().rows();
      const VectorXd norms = totals.back().column_norms();
      for (Eigen::Index c = 0; c < joints[i].count(); ++c)
        scale[joints[i].unknowns[c]] += std::pow(weights[static_cast<Eigen::Index>(i)] * norms[c], 2);
    }
    scale = scale.cwiseSqrt().cwiseMax(1e-300);
    for (const auto& block : factors) {
      blocks.push_back(cross_moments(block, joints, weights, scale));
      sum.add(1.0, blocks.back());
    }
  }

  // (base x blocks) Estimates that leave one block out each.
  template <typename Estimate>
  MatrixXd leave_one_out(const Estimate& estimate) const {
    MatrixXd out(scale.size(), static_cast<Eigen::Index>(blocks.size()));
    for (size_t b = 0; b < blocks.size(); ++b) {
      CrossMoments rest = sum;
      rest.add(-1.0, blocks[b]);
      out.col(b) = estimate(rest);
    }
    return out;
  }
};

// Residual of least squares on the columns T of a factor, and their rank.
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

// Durbin-Wu-Hausman test by augmented regression: if the noise in the measured columns is uncorrelated with
// that of the torque, the difference between the columns of the two motions explains nothing in addition.
EndogeneityTest endogeneity(const SquareRootInformation& factor, Eigen::Index k, double independent_share) {
  if (k == 0) return {};  // all parameters of the joint are known
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
  for (const CompressedRecording& recording : recordings)
    require(!recording.detached, recording.source,
            ": found factors alone, expected the recording itself: instruments need its samples.");
  const AllMoments all(arm, recordings, base, weights, options.preprocessing, Instruments::kPositions);
  const auto estimated = [&](const CrossMoments& m) { return estimate(m, options.method, all.scale); };
  const std::vector<std::string> names = parameter_names(standard_parameters(arm));
  InstrumentalFit out;
  out.solution = solve_base(recordings, weights, base, names);
  out.solution.beta = estimated(all.sum);
  std::vector<std::string> leading;
  for (const int j : base.independent) leading.push_back(names[j]);
  out.objective = weighted_total(joint_totals(recordings), weights, names).restricted(leading).residual2(out.solution.beta);
  set_deviations(all.leave_one_out(estimated), out.solution);
  const double share = std::clamp(out.solution.effective_samples / std::max(1.0, all.rows), 0.0, 1.0);
  for (size_t i = 0; i < all.joints.size(); ++i) out.tests.push_back(endogeneity(all.totals[i], all.joints[i].count(), share));
  return out;
}

InstrumentalContrast contrast_with_repeats(const Model& arm, const std::vector<CompressedRecording>& recordings,
                                           const BaseParameters& base, const VectorRef& weights,
                                           const PreprocessingOptions& how) {
  std::vector<CompressedRecording> repeated;
  for (const CompressedRecording& r : recordings) {
    if (r.period.seconds > 0.0 && !r.detached) repeated.push_back(r);
  }
  PreprocessingOptions every_speed = how;
  every_speed.min_speed = 0.0;  // a row may be slow in one repeat and not in another
  const AllMoments all(arm, repeated, base, weights, every_speed, Instruments::kRepeats);
  InstrumentalContrast out;
  out.p_value = VectorXd::Ones(base.size());
  if (all.rows < 2.0 * base.size() * arm.joints() || all.blocks.size() < 2) return out;
  const auto least_squares = [&](const CrossMoments& m) { return solved(m.AA, m.Ab, all.scale); };
  const auto instrumental = [&](const CrossMoments& m) { return solved(m.ZA, m.Zb, all.scale); };
  out.least_squares = least_squares(all.sum);
  out.instrumental = instrumental(all.sum);
  const VectorXd deviation =
      jackknife_deviations(all.leave_one_out([&](const CrossMoments& m) { return VectorXd(instrumental(m) - least_squares(m)); }));
  for (Eigen::Index k = 0; k < deviation.size(); ++k) {
    const double contrast = out.instrumental[k] - out.least_squares[k];
    if (deviation[k] > 0.0 && std::isfinite(contrast))
      out.p_value[k] = student_t_two_sided(contrast / deviation[k], static_cast<double>(all.blocks.size()) - 1.0);
  }
  return out;
}

}  // namespace veridyn
