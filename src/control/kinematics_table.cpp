#include "control/kinematics_table.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "veridyn/control/inverse_kinematics.hpp"
#include "kinematics/motion_limits.hpp"
#include "files/output_file.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr double kSingular = 1e-9;  // threshold relative to the largest singular value
constexpr int kPrimes[] = {2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37};
constexpr Eigen::Index kMostJoints = 12;  // Halton's sequence needs one prime number for each joint
constexpr int kStarts = 60;
// Poses are printed with six decimals. Arms with fewer than six joints cannot reach such a rounded pose
// exactly.
constexpr double kPrintedPosition = 2e-6;  // [m]
constexpr double kPrintedAngle = 5e-6;     // [rad]
constexpr double kOnLimit = 2e-6;          // [rad], [m] rounded joints may exceed a limit by this

Conditioning conditioning(const MatrixXd& J) {
  const MatrixXd square = J.rows() <= J.cols() ? MatrixXd(J * J.transpose())
                                               : MatrixXd(J.transpose() * J);
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(square, Eigen::EigenvaluesOnly);
  const VectorXd s = solver.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  Conditioning out;
  out.smallest = J.rows() <= J.cols() ? s.minCoeff() : 0.0;
  // With fewer joints than rows, only the directions that the joints can move are compared.
  const double least = s.minCoeff();
  out.condition = least > kSingular * s.maxCoeff() ? s.maxCoeff() / least
                                                   : std::numeric_limits<double>::infinity();
  out.manipulability = s.prod();
  return out;
}

class Rows {
 public:
  Rows(const Model& arm, const std::string& frame) : tip_(arm, {frame, Eigen::Vector3d::Zero()}) {
    length_ = characteristic_length(arm, {frame, Eigen::Vector3d::Zero()});
    table_.robot = arm.name();
    table_.frame = frame;
    for (const Coordinate& c : arm.coordinates()) {
      table_.joints.push_back(c.name);
      table_.prismatic.push_back(c.prismatic);
      table_.limits.push_back(c.limits);
    }
  }

  // Pose, Jacobian, conditioning and exceeded limits at q; status and errors as by default.
  KinematicRow row(const VectorRef& q) {
    KinematicRow out;
    out.q = q;
    tip_.update(q, VectorXd::Zero(q.size()));
    out.T_world_tip.linear() = tip_.rotation();
    out.T_world_tip.translation() = tip_.position();
    for (std::size_t i = 0; i < table_.limits.size(); ++i) {
      const double at = q[static_cast<Eigen::Index>(i)];
      if (at < table_.limits[i].lower - kOnLimit || at > table_.limits[i].upper + kOnLimit)
        out.outside.push_back(table_.joints[i]);
    }
    out.jacobian = tip_.jacobian();
    MatrixXd J = out.jacobian;
    J.topRows(3) /= length_;
    for (Eigen::Index i = 0; i < J.cols(); ++i) {
      if (table_.prismatic[i]) J.col(i) *= length_;
    }
    out.position = conditioning(J.topRows(3));
    out.pose = conditioning(J);
    return out;
  }

  KinematicTable& table() { return table_; }

 private:
  TipKinematics tip_;
  double length_ = 1.0;
  KinematicTable table_;
};

// Halton's sequence in a prime base: numbers between 0 and 1 that fill this range evenly.
double halton(int index, int base) {
  double out = 0.0, part = 1.0;
  for (int k = index; k > 0; k /= base) {
    part /= base;
    out += part * (k % base);
  }
  return out;
}

// Point `index` of a sequence of joint positions that fills the ranges evenly.
VectorXd halton_configuration(const MotionLimits& limits, int index) {
  VectorXd q(limits.lower.size());
  for (Eigen::Index i = 0; i < q.size(); ++i)
    q[i] = limits.lower[i] + halton(index, kPrimes[i]) * (limits.upper[i] - limits.lower[i]);
  return q;
}

// Tries Newton steps from the present joints, from the start, and from points spread over the ranges, since
// steps may end at joint limits or at singularities between postures. If all fail, q is where those from the present joints end.
ReachStatus solve_from_several_starts(InverseKinematics& newton, const Eigen::Isometry3d& wanted,
                               const MotionLimits& limits, const VectorRef& start, VectorXd& q) {
  VectorXd trial = q;
  for (int k = -1; k <= kStarts; ++k) {
    if (k == 0) trial = start;
    if (k > 0) trial = halton_configuration(limits, k);
    const ReachStatus status = newton.solve(wanted.translation(), wanted.linear(), trial);
    const bool reached = status == ReachStatus::kReached ||
                         (newton.position_error() <= kPrintedPosition &&
                          newton.angle_error() <= kPrintedAngle);
    if (reached || k < 0) q = trial;
    if (reached) return ReachStatus::kReached;
    if (q.size() > kMostJoints) break;
  }
  return ReachStatus::kNotReached;
}

}  // namespace

const char* name_of(KinematicSolver solver) {
  static constexpr const char* kNames[] = {"forward", "workspace", "closed form", "Newton"};
  return kNames[static_cast<int>(solver)];
}

int KinematicTable::unreached() const {
  return static_cast<int>(std::count_if(rows.begin(), rows.end(), [](const KinematicRow& row) {
    return row.status != ReachStatus::kReached && row.status != ReachStatus::kSingular;
  }));
}

std::string KinematicTable::outside_words() const {
  std::string out;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const auto beyond = std::find_if(rows.begin(), rows.end(), [&](const KinematicRow& row) {
      return std::find(row.outside.begin(), row.outside.end(), joints[i]) != row.outside.end();
    });
    if (beyond == rows.end()) continue;
    out += fmt::format("{}{} {:.6g} (limits {:.6g} to {:.6g})", out.empty() ? "" : ", ", joints[i],
                       beyond->q[static_cast<Eigen::Index>(i)], limits[i].lower, limits[i].upper);
  }
  return out;
}

KinematicTable forward_kinematics(const Model& arm, const std::string& frame,
                                  const MatrixXd& joints) {
  require(joints.cols() == arm.joints(), "kinematics: found ", joints.cols(),
          " joint columns, expected the ", arm.joints(), " of ", arm.name(), ".");
  require(joints.allFinite(), "kinematics: found a joint position that is not finite.");
  Rows rows(arm, frame);
  for (Eigen::Index k = 0; k < joints.rows(); ++k)
    rows.table().rows.push_back(rows.row(joints.row(k).transpose()));
  return std::move(rows.table());
}

KinematicTable inverse_kinematics(const Model& arm, const std::string& frame,
                                  const InverseTask& task, const InverseSolver& solver) {
  Rows rows(arm, frame);
  rows.table().solver = solver ? KinematicSolver::kClosedForm : KinematicSolver::kNewton;
  rows.table().has_orientation = task.has_orientation;
  const MotionLimits limits = motion_limits(arm);
  VectorXd q = 0.5 * (limits.lower + limits.upper);
  if (task.start.size() > 0) {
    require(task.start.size() == arm.joints(), "kinematics: found a start of ", task.start.size(),
            " joints, expected ", arm.joints(), ".");
    q = task.start;
  }
  InverseKinematicsOptions options;
  options.rows = task.has_orientation ? TaskRows::kPose : TaskRows::kPosition;
  InverseKinematics newton(arm, {frame, Eigen::Vector3d::Zero()}, options);
  const VectorXd middle = q;
  for (const Eigen::Isometry3d& wanted : task.poses) {
    require(wanted.matrix().allFinite(), "kinematics: found a pose that is not finite.");
    const ReachStatus status = solver ? solver(wanted, q) : solve_from_several_starts(newton, wanted, limits, middle, q);
    KinematicRow row = rows.row(q);
    row.status = status;
    row.position_error = (row.T_world_tip.translation() - wanted.translation()).norm();
    if (task.has_orientation) {
      const Eigen::AngleAxisd off(Eigen::Matrix3d(row.T_world_tip.linear().transpose() * wanted.linear()));
      row.angle_error = std::abs(off.angle());
    }
    rows.table().rows.push_back(std::move(row));
  }
  return std::move(rows.table());
}

KinematicTable sample_workspace(const Model& arm, const std::string& frame, int count) {
  require(arm.joints() <= kMostJoints, "kinematics: found ", arm.joints(),
          " joints, expected at most 12 for a sampled workspace.");
  const MotionLimits limits = motion_limits(arm);
  Rows rows(arm, frame);
  rows.table().solver = KinematicSolver::kWorkspace;
  VectorXd q(arm.joints());
  for (int k = 1; k <= count; ++k) {
    for (Eigen::Index i = 0; i < q.size(); ++i)
      q[i] = limits.lower[i] + halton(k, kPrimes[i]) * (limits.upper[i] - limits.lower[i]);
    rows.table().rows.push_back(rows.row(q));
  }
  return std::move(rows.table());
}

std::string KinematicTable::report() const {
  std::vector<double> condition;
  double nearest = std::numeric_limits<double>::infinity(), farthest = 0.0;
  for (const KinematicRow& row : rows) {
    condition.push_back(row.position.condition);
    const double reach = row.T_world_tip.translation().norm();
    nearest = std::min(nearest, reach);
    farthest = std::max(farthest, reach);
  }
  std::sort(condition.begin(), condition.end());
  std::string out = fmt::format("{}, frame {}: {} posture{}, {}.\n", robot, frame, rows.size(),
                                rows.size() == 1 ? "" : "s", name_of(solver));
  if (is_inverse()) {
    double off = 0.0, turned = 0.0;
    for (const KinematicRow& row : rows) {
      off = std::max(off, row.position_error);
      turned = std::max(turned, row.angle_error);
    }
    out += fmt::format("{} of {} poses not reached; off by {:.2g} m{} at most.\n", unreached(), rows.size(), off,
                       has_orientation ? fmt::format(" and {:.2g} rad", turned) : "");
  }
  if (rows.size() == 1) {
    const Eigen::Vector3d p = rows.front().T_world_tip.translation();
    const Eigen::Quaterniond r(rows.front().T_world_tip.linear());
    out += fmt::format("Tip at {:.6f} {:.6f} {:.6f} m, quaternion (w, x, y, z) {:.6f} {:.6f} {:.6f} {:.6f}.\n",
                       p.x(), p.y(), p.z(), r.w(), r.x(), r.y(), r.z());
    out += "Joints";
    for (Eigen::Index i = 0; i < rows.front().q.size(); ++i)
      out += fmt::format(" {} {:.6f}", joints[i], rows.front().q[i]);
    out += ".\n";
  } else if (!rows.empty()) {
    out += fmt::format("Tip from {:.4g} to {:.4g} m off the base.\n", nearest, farthest);
  }
  if (!condition.empty())
    out += fmt::format("Condition of the position Jacobian: least {:.3g}, median {:.3g}, largest {:.3g}.\n",
                       condition.front(), condition[condition.size() / 2], condition.back());
  const std::string outside = outside_words();
  if (!outside.empty()) out += fmt::format("Outside the limits of {}.\n", outside);
  return out;
}

void write_kinematic_rows(const KinematicTable& table, const std::string& path,
                          JacobianColumns jacobian) {
  OutputFile file(path);
  std::ostream& out = file.stream();
  std::string head = table.has_time ? "t" : "";
  const auto add = [&](const std::string& name) { head += (head.empty() ? "" : ",") + name; };
  for (std::size_t i = 0; i < table.joints.size(); ++i) add(fmt::format("q{}", i + 1));
  for (const char* name : {"x", "y", "z", "qw", "qx", "qy", "qz", "condition", "smallest",
                           "manipulability", "pose_condition"})
    add(name);
  if (table.is_inverse()) head += ",status,position_error,angle_error";
  if (jacobian == JacobianColumns::kWith) {
    for (int r = 1; r <= 6; ++r) {
      for (std::size_t i = 0; i < table.joints.size(); ++i) head += fmt::format(",J{}_{}", r, i + 1);
    }
  }
  out << head << '\n';
  for (const KinematicRow& row : table.rows) {
    std::string line = table.has_time ? fmt::format("{:.9g}", row.time) : "";
    const auto number = [&](double x) {
      line += (line.empty() ? "" : ",") + (std::isfinite(x) ? fmt::format("{:.10g}", x) : std::string());
    };
    for (const double q : row.q) number(q);
    const Eigen::Vector3d p = row.T_world_tip.translation();
    const Eigen::Quaterniond r(row.T_world_tip.linear());
    for (const double x : {p.x(), p.y(), p.z(), r.w(), r.x(), r.y(), r.z(), row.position.condition,
                           row.position.smallest, row.position.manipulability, row.pose.condition})
      number(x);
    if (table.is_inverse())
      line += fmt::format(",{},{:.4g},{:.4g}", name_of(row.status), row.position_error, row.angle_error);
    if (jacobian == JacobianColumns::kWith) {
      for (Eigen::Index r6 = 0; r6 < 6; ++r6) {
        for (Eigen::Index i = 0; i < row.jacobian.cols(); ++i) number(row.jacobian(r6, i));
      }
    }
    out << line << '\n';
  }
  file.commit();
}

}  // namespace veridyn
