#pragma once

#include <cmath>

namespace veridyn {

// Three-dimensional vectors and rotations over any scalar: double, packs of samples, dual numbers.
// Fixed-size and free of Eigen, so that kernels compiled for several instruction sets share no
// symbols.

template <typename S>
struct Vec3 {
  S x, y, z;
};

template <typename S>
struct Mat3 {
  Vec3<S> row0, row1, row2;
};

using Vec3d = Vec3<double>;
using Mat3d = Mat3<double>;

// The operands may differ in scalar: a constant and a variable, one number and a pack of them.

template <typename A, typename B>
inline auto operator+(const Vec3<A>& a, const Vec3<B>& b) -> Vec3<decltype(a.x + b.x)> {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}

template <typename A, typename B>
inline auto operator-(const Vec3<A>& a, const Vec3<B>& b) -> Vec3<decltype(a.x - b.x)> {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}

template <typename A, typename B>
inline auto operator*(const A& k, const Vec3<B>& a) -> Vec3<decltype(k * a.x)> {
  return {k * a.x, k * a.y, k * a.z};
}

template <typename A, typename B>
inline auto dot(const Vec3<A>& a, const Vec3<B>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

template <typename A, typename B>
inline auto cross(const Vec3<A>& a, const Vec3<B>& b) -> Vec3<decltype(a.x * b.x)> {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// The product R * a.
template <typename A, typename B>
inline auto rotate(const Mat3<A>& R, const Vec3<B>& a) -> Vec3<decltype(R.row0.x * a.x)> {
  return {dot(R.row0, a), dot(R.row1, a), dot(R.row2, a)};
}

/// The product R' * a.
template <typename A, typename B>
inline auto rotate_back(const Mat3<A>& R, const Vec3<B>& a) -> Vec3<decltype(R.row0.x * a.x)> {
  return {R.row0.x * a.x + R.row1.x * a.y + R.row2.x * a.z,
          R.row0.y * a.x + R.row1.y * a.y + R.row2.y * a.z,
          R.row0.z * a.x + R.row1.z * a.y + R.row2.z * a.z};
}

template <typename A, typename B>
inline auto operator*(const Mat3<A>& R, const Mat3<B>& Q) -> Mat3<decltype(R.row0.x * Q.row0.x)> {
  return {rotate_back(Q, R.row0), rotate_back(Q, R.row1), rotate_back(Q, R.row2)};
}

template <typename S>
inline Mat3<S> transpose(const Mat3<S>& R) {
  return {{R.row0.x, R.row1.x, R.row2.x},
          {R.row0.y, R.row1.y, R.row2.y},
          {R.row0.z, R.row1.z, R.row2.z}};
}

inline Mat3d identity3() {
  return {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
}

inline Mat3d rotation_x(double angle) {
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  return {{1, 0, 0}, {0, c, -s}, {0, s, c}};
}

inline Mat3d rotation_y(double angle) {
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  return {{c, 0, s}, {0, 1, 0}, {-s, 0, c}};
}

inline Mat3d rotation_z(double angle) {
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  return {{c, -s, 0}, {s, c, 0}, {0, 0, 1}};
}

/// A pose T_a_b: rotation R_a_b and position of the origin of b, written in a.
template <typename S>
struct Pose {
  Mat3<S> R;
  Vec3<S> p;
};

using Posed = Pose<double>;

inline Posed identity_pose() {
  return {identity3(), {0, 0, 0}};
}

/// T_a_c = T_a_b * T_b_c.
template <typename A, typename B>
inline auto operator*(const Pose<A>& T_a_b, const Pose<B>& T_b_c)
    -> Pose<decltype(T_a_b.p.x * T_b_c.p.x)> {
  const auto moved = rotate(T_a_b.R, T_b_c.p);
  return {T_a_b.R * T_b_c.R, {T_a_b.p.x + moved.x, T_a_b.p.y + moved.y, T_a_b.p.z + moved.z}};
}

template <typename S>
inline Pose<S> inverse(const Pose<S>& T) {
  const Vec3<S> p = rotate_back(T.R, T.p);
  return {transpose(T.R), {-p.x, -p.y, -p.z}};
}

}  // namespace veridyn
