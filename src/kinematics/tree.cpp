#include "veridyn/kinematics/tree.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "veridyn/model/model.hpp"

namespace veridyn {
namespace {

// Marks the frames that the dynamics need: those with bodies, and all frames above them.
std::vector<char> needed_frames(const Model& arm) {
  std::vector<char> needed(arm.frames().size(), 0);
  for (int k = static_cast<int>(arm.frames().size()) - 1; k >= 0; --k) {
    const Frame& frame = arm.frames()[k];
    if (frame.body) needed[k] = 1;
    if (needed[k] != 0 && frame.parent) needed[frame.parent->value] = 1;
  }
  return needed;
}

std::vector<JointCoefficient> terms_of(const Axis& axis) {
  std::vector<JointCoefficient> terms;
  for (Eigen::Index i = 0; i < axis.coefficients.size(); ++i) {
    if (axis.coefficients[i] != 0.0)
      terms.push_back({static_cast<int>(i), axis.coefficients[i]});
  }
  return terms;
}

// Makes right angles, and offsets along an axis, exact: cos(pi/2) is 6e-17 in doubles, and generated code would
// contain products with it.
Posed snapped(Posed T) {
  constexpr double kRounding = 4.0 * std::numeric_limits<double>::epsilon();
  for (Vec3d* row : {&T.R.row0, &T.R.row1, &T.R.row2}) {
    for (double* entry : {&row->x, &row->y, &row->z}) {
      if (std::abs(*entry - std::round(*entry)) < kRounding) *entry = std::round(*entry) + 0.0;
    }
  }
  const double rounding = kRounding * std::max({std::abs(T.p.x), std::abs(T.p.y), std::abs(T.p.z)});
  for (double* entry : {&T.p.x, &T.p.y, &T.p.z}) {
    if (std::abs(*entry) < rounding) *entry = 0.0;
  }
  return T;
}

}  // namespace

Tree::Tree(const Model& arm, Keep keep)
    : Tree(arm.joints(), {arm.gravity().x(), arm.gravity().y(), arm.gravity().z()}) {
  const auto& all = arm.frames();
  const std::vector<char> needed =
      keep == Keep::kBodiesOnly ? needed_frames(arm) : std::vector<char>(all.size(), 1);
  link_of_frame.assign(all.size(), -1);
  // Each frame is placed on the last kept link at or above it.
  frames.assign(all.size(), {-1, true, identity_pose(), -1});
  for (int k = 0; k < static_cast<int>(all.size()); ++k) {
    const Frame& frame = all[k];
    const BodyPlace above =
        frame.parent ? frames[frame.parent->value] : BodyPlace{-1, true, identity_pose(), -1};
    const bool fixed = frame.type == JointType::kFixed;
    const bool carries = keep == Keep::kBodiesOnly && frame.body;
    if (needed[k] == 0 || (fixed && !carries && keep != Keep::kEveryFrame)) {
      const Posed T = above.T_link_body * frame.A * frame.B;
      frames[k] = {above.link, is_identity(T), T, -1};
      continue;
    }
    const bool in_joint = keep == Keep::kMovingLinks;
    Posed A = above.T_link_body * frame.A;
    if (in_joint) A = snapped(A);
    link_of_frame[k] =
        fixed ? add_link(above.link, frame.type, {}, frame.variable.offset, A * frame.B)
              : add_link(above.link, frame.type, terms_of(frame.variable), frame.variable.offset, A,
                         in_joint ? identity_pose() : frame.B);
    links.back().frame = k;
    const Posed T = in_joint ? frame.B : identity_pose();
    frames[k] = {link_of_frame[k], is_identity(T), T, -1};
  }
  for (const auto [k] : arm.bodies()) {
    const BodyPlace& at = frames[k];
    body_links.push_back(at.link);
    add_body(at.link, at.T_link_body);
  }
}

}  // namespace veridyn
