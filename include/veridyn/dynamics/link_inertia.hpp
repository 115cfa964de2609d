#pragma once

#include "veridyn/kinematics/links.hpp"

namespace veridyn {

/// The integrals of 1, x and x x' over the mass of a link, about its origin: the ten inertial
/// parameters in the form in which a change of frame is one product, T Pi T'.
template <typename S>
struct InertiaOf {
  S m;
  Vec3<S> h;
  S xx, xy, yy, xz, yz, zz;
};
using LinkInertia = InertiaOf<double>;

/// A wrench that the environment exerts on a link, at the origin of the link's frame and written in it.
struct LinkWrench {
  int link;
  Vec3d force;   ///< [N]
  Vec3d moment;  ///< [N m]
};

namespace inertia_detail {

/// Adds inertia I, given in a frame whose pose is T, to the inertia `to`.
inline void add(const LinkInertia& I, const Posed& T, LinkInertia& to) {
  const Vec3d h = rotate(T.R, I.h);
  const Vec3d& p = T.p;
  // The second moments: R X R' + h p' + p h' + m p p'.
  const Mat3d X{{I.xx, I.xy, I.xz}, {I.xy, I.yy, I.yz}, {I.xz, I.yz, I.zz}};
  const Mat3d RX = T.R * X;
  const Vec3d s = 0.5 * I.m * p + h;
  to.m += I.m;
  to.h = to.h + h + I.m * p;
  to.xx += dot(RX.row0, T.R.row0) + 2.0 * s.x * p.x;
  to.xy += dot(RX.row0, T.R.row1) + s.x * p.y + s.y * p.x;
  to.yy += dot(RX.row1, T.R.row1) + 2.0 * s.y * p.y;
  to.xz += dot(RX.row0, T.R.row2) + s.x * p.z + s.z * p.x;
  to.yz += dot(RX.row1, T.R.row2) + s.y * p.z + s.z * p.y;
  to.zz += dot(RX.row2, T.R.row2) + 2.0 * s.z * p.z;
}

/// Converts phi = [m, h, Lxx, Lxy, Lyy, Lxz, Lyz, Lzz] of InertialParameters.
inline LinkInertia inertia_from_parameters(const double* phi) {
  const double half = 0.5 * (phi[4] + phi[6] + phi[9]);
  return {phi[0], {phi[1], phi[2], phi[3]}, half - phi[4], -phi[5],
          half - phi[6], -phi[7], -phi[8], half - phi[9]};
}

}  // namespace inertia_detail

/// Inertias of the links of a tree of moving links (Tree::Keep::kMovingLinks) that give the same
/// torques as the bodies with phi, with the most zeros that every arm admits: mass on a revolute
/// joint's axis can be assigned to its parent, and so can the second moments of a prismatic link. A
/// revolute link keeps h_x, h_y and the moments without zz; a prismatic one m and h. Source: Khalil
/// and Dombre, Modeling, Identification and Control of Robots, 2002, ch. 9.
///
/// @param phi  ten parameters of every body. @param out  one inertia per link.
inline void link_inertias(const Links& tree, const double* phi, LinkInertia* out) {
  for (int k = 0; k < tree.count; ++k) out[k] = LinkInertia{};
  for (int b = 0; b < tree.bodies; ++b) {
    const BodyPlace& place = tree.body[b];
    if (place.link < 0) continue;
    inertia_detail::add(inertia_detail::inertia_from_parameters(phi + 10 * b), place.T_link_body, out[place.link]);
  }
  for (int k = tree.count - 1; k >= 0; --k) {
    const Link& link = tree.link[k];
    LinkInertia& I = out[k];
    LinkInertia moved{};
    if (link.type == JointType::kRevolute) {
      moved.m = I.m;
      moved.h.z = I.h.z;
      moved.zz = I.zz;
      I.m = I.h.z = I.zz = 0.0;
    } else {
      moved = I;
      moved.m = 0.0;
      moved.h = {0, 0, 0};
      I = {I.m, I.h, 0, 0, 0, 0, 0, 0};
    }
    // A prismatic link has the axes of its parent, and a couple is the same about every origin.
    if (link.parent >= 0) inertia_detail::add(moved, link.A, out[link.parent]);
  }
}

}  // namespace veridyn
