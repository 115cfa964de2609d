#include "veridyn/control/tip_kinematics.hpp"

#include <cassert>
#include <utility>
#include <vector>

#include "kinematics/link_pose.hpp"
#include "veridyn/math/require.hpp"
#include "model/suggestion.hpp"

namespace veridyn {
namespace {

int tip_frame(const Model& arm, const Tip& tip) {
  std::vector<std::string> names;
  for (const Frame& frame : arm.frames()) names.push_back(frame.name);
  const int frame = arm.find_frame(tip.frame);
  require(frame >= 0, "tip of arm '", arm.name(), "': found the frame '", tip.frame, "'",
          did_you_mean(tip.frame, names), ", expected one of: ", listed(names), ".");
  require(tip.offset_frame.allFinite(), "tip of arm '", arm.name(),
          "': found an offset that is not finite, expected three numbers in metres.");
  return frame;
}

// The frames from the world to the tip; the tip is the only body, so that the tree folds everything
// fixed.
Model chain_to(const Model& arm, const Tip& tip) {
  std::vector<int> chain;
  for (int k = tip_frame(arm, tip); k >= 0; k = arm.frames()[k].parent)
    chain.insert(chain.begin(), k);
  ModelDescription out;
  out.name = arm.name();
  out.coordinates = arm.coordinates();
  for (size_t i = 0; i < chain.size(); ++i) {
    Frame frame = arm.frames()[chain[i]];
    frame.parent = static_cast<int>(i) - 1;
    frame.body.reset();
    out.frames.push_back(std::move(frame));
  }
  Frame end = out.frames.back();
  end.name += " tip";
  while (arm.find_frame(end.name) >= 0) end.name += "'";
  end.parent = static_cast<int>(chain.size()) - 1;
  end.type = JointType::kFixed;
  end.variable.coefficients.setZero();
  end.variable.offset = 0.0;
  end.A = {identity3(), {tip.offset_frame.x(), tip.offset_frame.y(), tip.offset_frame.z()}};
  end.B = identity_pose();
  end.dh.reset();
  end.body = Body{};
  out.frames.push_back(std::move(end));
  return Model(std::move(out));
}

void write(MatrixXd& J, int column, const Vec3d& linear, const Vec3d& angular) {
  double* to = J.data() + 6 * column;
  to[0] = linear.x;
  to[1] = linear.y;
  to[2] = linear.z;
  to[3] = angular.x;
  to[4] = angular.y;
  to[5] = angular.z;
}

}  // namespace

std::string default_tip(const Model& arm) {
  std::vector<int> joints;  // above each frame, its own included
  int best = -1;
  for (const Frame& frame : arm.frames()) {
    const int above = frame.parent < 0 ? 0 : joints[frame.parent];
    joints.push_back(above + (frame.type == JointType::kFixed ? 0 : 1));
    if (best < 0 || joints.back() >= joints[best])
      best = static_cast<int>(joints.size()) - 1;
  }
  return best < 0 ? "" : arm.frames()[best].name;
}

TipKinematics::TipKinematics(const Model& arm, const Tip& tip)
    : tree_(chain_to(arm, tip)),
      link_(tree_.body_links.front()),
      recursion_(tree_),
      rest_(VectorXd::Zero(arm.joints())),
      J_(MatrixXd::Zero(6, arm.joints())),
      dJ_(J_) {}

void TipKinematics::update(const VectorXd& q, const VectorXd& dq) noexcept {
  assert(q.size() == joints() && dq.size() == joints());
  const Links links = tree_;
  forward_pass(links, q.data(), dq.data(), rest_.data(), {0, 0, 0}, recursion_);
  jacobian_pass(links, recursion_);
  jacobian_rate_pass(links, recursion_);
  const Posed T = link_pose(tree_, recursion_, link_);
  // clang-format off
  rotation_ << T.R.row0.x, T.R.row0.y, T.R.row0.z,
               T.R.row1.x, T.R.row1.y, T.R.row1.z,
               T.R.row2.x, T.R.row2.y, T.R.row2.z;
  // clang-format on
  position_ << T.p.x, T.p.y, T.p.z;
  const Link& link = links.link[link_];
  const Vec3d omega = recursion_.link[link_].omega;
  twist_.setZero();
  for (int m = link.first_support; m < link.end_support; ++m) {
    // d(R c)/dt = R (dc/dt + omega x c), omega and c in the link's frame.
    const int i = links.support[m].coordinate;
    const Column<double>& c = recursion_.jacobian[m];
    const Column<double>& rate = recursion_.jacobian_rate[m];
    write(J_, i, rotate(T.R, c.v), rotate(T.R, c.w));
    write(dJ_, i, rotate(T.R, rate.v + cross(omega, c.v)), rotate(T.R, rate.w + cross(omega, c.w)));
    twist_ += dq[i] * J_.col(i);
  }
}

}  // namespace veridyn
