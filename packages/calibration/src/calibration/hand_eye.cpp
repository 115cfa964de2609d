#include "veridyn/calibration/hand_eye.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "contradiction.hpp"
#include "deviations.hpp"
#include "hand_eye_fit.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

using internal::PairFit;

constexpr double kAsGood = 1.5;       // largest noise of a form that fits, relative to the smallest
constexpr double kSixDigits = 2e-6;    // [m], [rad] rounding of files with six digits
// [m] largest noise of a form that has no other form to compare with
constexpr double kCloseFit = 0.005;
constexpr double kCloseTurn = 2.0 * kDegree;
// Orientations with a larger difference do not correspond.
constexpr double kNoTurn = 5.0 * kDegree;

// In the order of their number of unknowns.
constexpr HandEyeForm kForms[] = {HandEyeForm::kCommonPoses, HandEyeForm::kHandEye,
                                  HandEyeForm::kEyeInHand, HandEyeForm::kTwoBases,
                                  HandEyeForm::kCommonPoints};

// Index in kForms of the first form whose noise is close to the smallest; the most general one if none is; -1
// if that is not identifiable.
int first_good_form(const std::vector<PairFit>& fits) {
  double noise = INFINITY;
  double angle = INFINITY;
  bool compared = false;
  for (std::size_t k = 0; k + 1 < fits.size(); ++k) {
    if (!fits[k].reason.empty()) continue;
    // Position and orientation noise of a form, each compared with the smallest of its kind.
    if (fits[k].noise < noise) noise = fits[k].noise;
    if (fits[k].noise_angle < angle) angle = fits[k].noise_angle;
    compared = compared || k > 0;
  }
  const PairFit& points = fits.back();
  const auto fits_as = [&](const PairFit& f) {
    return f.reason.empty() && f.noise <= kAsGood * noise + kSixDigits &&
           f.noise_angle <= kAsGood * angle + kSixDigits;
  };
  // Tips that touch in any orientation: only positions correspond.
  const bool any = std::any_of(fits.begin(), fits.end() - 1, [&](const PairFit& f) {
    return fits_as(f) && f.noise_angle < kNoTurn;
  });
  const bool points_alone =
      points.reason.empty() && !any && points.noise < kCloseFit &&
      points.noise <= kAsGood * noise + kSixDigits;
  if (points_alone || (!compared && points.reason.empty() && !fits[0].reason.empty()))
    return static_cast<int>(fits.size()) - 1;
  if (!compared) {
    const bool close = fits[0].reason.empty() && fits[0].noise < kCloseFit &&
                       fits[0].noise_angle < kCloseTurn;
    return close ? 0 : -1;
  }
  for (std::size_t k = 0; k + 1 < fits.size(); ++k) {
    if (fits_as(fits[k])) return static_cast<int>(k);
  }
  // No form is close to the best in both positions and orientations: takes the most general one.
  return fits[3].reason.empty() ? 3 : -1;
}

// Copies a fit to `out`, with 95 % radii in place of covariances.
void copy_result(const PairFit& fit, HandEye& out) {
  out.status = CalibrationStatus::kDone;
  const bool is_hand = out.form == HandEyeForm::kEyeInHand;
  const bool has_other = is_hand || out.form == HandEyeForm::kTwoBases;
  const auto radii = [&](const MatrixXd& C, double& metres, double& radians) {
    radians = internal::error_radius(C.topLeftCorner<3, 3>(), fit.degrees_of_freedom);
    metres = internal::error_radius(C.bottomRightCorner<3, 3>(), fit.degrees_of_freedom);
  };
  out.transform = is_hand ? fit.X : fit.Y;
  radii(is_hand ? fit.covariance_X : fit.covariance_Y, out.radius, out.radius_angle);
  if (has_other) {
    out.other = is_hand ? fit.Y : fit.X;
    radii(is_hand ? fit.covariance_Y : fit.covariance_X, out.other_radius, out.other_radius_angle);
  }
  out.residuals = fit.residuals;
  out.residual_angles = fit.angles;
  double metres = 0.0;
  double radians = 0.0;
  for (std::size_t k = 0; k < fit.residuals.size(); ++k) {
    if (fit.is_outlier[k] != 0) {
      ++out.outliers;
      continue;
    }
    metres += fit.residuals[k].squaredNorm();
    radians += fit.angles[k] * fit.angles[k];
  }
  const double kept = std::max(1.0, 1.0 * out.pairs - out.outliers);
  out.rms = std::sqrt(metres / kept);
  out.rms_angle = std::sqrt(radians / kept);
}

}  // namespace

const char* name_of(HandEyeForm form) {
  switch (form) {
    case HandEyeForm::kCommonPoses: return "common-poses";
    case HandEyeForm::kCommonPoints: return "common-points";
    case HandEyeForm::kHandEye: return "hand-eye";
    case HandEyeForm::kEyeInHand: return "eye-in-hand";
    case HandEyeForm::kTwoBases: return "two-bases";
  }
  return "";
}

HandEye calibrate_hand_eye(const PoseCapture& A, const PoseCapture& B,
                           const HandEyeOptions& options) {
  require(A.file_rows == B.file_rows, B.source, ": found ", B.file_rows, " rows, expected ",
          A.file_rows, " as in ", A.source, " (rows belong together in pairs).");
  HandEye out;
  for (const PoseCapture* one : {&A, &B}) {
    if (!one->fault.empty()) out.reason = one->source + ": " + one->fault;
  }
  if (!out.reason.empty()) return out;
  internal::Isometries a;
  internal::Isometries b;
  for (std::size_t i = 0, j = 0; i < A.rows.size() && j < B.rows.size();) {
    if (A.rows[i] == B.rows[j]) {
      a.push_back(A.poses[i++]);
      b.push_back(B.poses[j++]);
    } else if (A.rows[i] < B.rows[j]) {
      ++i;
    } else {
      ++j;
    }
  }
  out.pairs = static_cast<int>(a.size());
  const bool oriented = A.has_orientation && B.has_orientation;
  if (out.pairs > 0) {
    const internal::RotationSpread spread = internal::rotation_spread(a);
    out.swing = spread.eigenvalues.cwiseSqrt() / kDegree;
  }
  std::vector<PairFit> fits(std::size(kForms));
  for (std::size_t k = 0; k < fits.size(); ++k) {
    const HandEyeForm form = kForms[k];
    const bool asked = !options.form || *options.form == form;
    if (!asked) {
      fits[k].reason = "not asked for";
    } else if (!oriented && form != HandEyeForm::kCommonPoints) {
      fits[k].reason = "the files have no orientations";
    } else {
      fits[k] = internal::fit_pairs(a, b, form, options.smallest_swing);
    }
    if (asked) out.forms.push_back({form, fits[k].noise, fits[k].noise_angle, fits[k].reason});
  }
  int found = -1;
  if (options.form) {
    found = static_cast<int>(std::find(std::begin(kForms), std::end(kForms), *options.form) -
                             std::begin(kForms));
  } else {
    found = first_good_form(fits);
  }
  if (found < 0 || !fits[found].reason.empty()) {
    out.reason = found >= 0 ? fits[found].reason
                            : oriented ? fits[3].reason : fits.back().reason;
    return out;
  }
  out.form = kForms[found];
  copy_result(fits[found], out);
  out.reason = internal::contradiction_reason(a, {out.outliers, out.rms, out.rms_angle});
  if (out.reason.empty()) return out;
  out.status = CalibrationStatus::kCannotAnswer;
  out.reason += fmt::format("; rows of the two files may not belong together, or not in this form ({})", name_of(out.form));
  return out;
}

std::string HandEye::report() const {
  if (status != CalibrationStatus::kDone) return "Hand-eye: " + reason + ".\n";
  const auto pose = [](const Eigen::Isometry3d& T, double metres, double radians) {
    const Eigen::Quaterniond q(T.linear());
    return fmt::format(
        "    translation {:.3f} {:.3f} {:.3f} mm, within {:.3f} mm (95 %)\n"
        "    quaternion (w, x, y, z) {:.6f} {:.6f} {:.6f} {:.6f}, within {:.4f} deg (95 %)\n",
        1e3 * T.translation().x(), 1e3 * T.translation().y(), 1e3 * T.translation().z(),
        1e3 * metres, q.w(), q.x(), q.y(), q.z(), radians / kDegree);
  };
  static const char* const kRelations[] = {"A = T B", "a = T b, positions only", "A T = T B",
                                           "A T B = target", "A tool = T B"};
  std::string text = fmt::format("Pose T from {} pairs, {} of them left out; {}: {}\n  T\n", pairs,
                                 outliers, name_of(form), kRelations[static_cast<int>(form)]);
  text += pose(transform, radius, radius_angle);
  if (other) {
    text += form == HandEyeForm::kEyeInHand ? "  target\n" : "  tool\n";
    text += pose(*other, other_radius, other_radius_angle);
  }
  text += fmt::format("  Left over: {:.3f} mm rms, {:.4f} deg rms.\n", 1e3 * rms,
                      rms_angle / kDegree);
  if (forms.size() < 2) return text;
  text += "  Forms tried (deviation of one component):";
  for (const Alternative& f : forms) {
    text += f.reason.empty() ? fmt::format(" {} {:.3g} mm {:.3g} deg;", name_of(f.form),
                                           1e3 * f.rms, f.rms_angle / kDegree)
                             : fmt::format(" {} not told;", name_of(f.form));
  }
  text.back() = '.';
  return text + "\n";
}

}  // namespace veridyn
