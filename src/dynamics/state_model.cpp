#include "state_model.hpp"

#include <cstdint>

namespace veridyn {
namespace {

constexpr std::size_t kAlignment = 64;

void put(const Mat3d& R, double* to) {
  const double rows[9] = {R.row0.x, R.row0.y, R.row0.z, R.row1.x, R.row1.y,
                          R.row1.z, R.row2.x, R.row2.y, R.row2.z};
  for (int e = 0; e < 9; ++e) to[e] = rows[e];
}

void put(const Vec3d& v, double* to) {
  to[0] = v.x;
  to[1] = v.y;
  to[2] = v.z;
}

bool is_zero(const Vec3d& v) {
  return v.x == 0.0 && v.y == 0.0 && v.z == 0.0;
}

StateMotion motion_of(Motion motion) {
  if (motion == Motion::kTurns) return StateMotion::kTurns;
  return motion == Motion::kSlides ? StateMotion::kSlides : StateMotion::kNone;
}

// R_parent_link = A Rz(s) B, taken apart: Rz(s) = along z + cosine across z + sine (z x).
StateLink folded(const Link& link) {
  StateLink out{};
  out.parent = link.parent;
  out.body = link.body;
  out.joint = -1;
  out.motion = motion_of(link.motion);
  out.offset = link.offset;
  out.first_share = link.first_share;
  out.end_share = link.end_share;
  if (link.motion == Motion::kTurns) {
    put(link.A.R * Mat3d{{0, 0, 0}, {0, 0, 0}, {0, 0, 1}} * link.B.R, out.still);
    put(link.A.R * Mat3d{{1, 0, 0}, {0, 1, 0}, {0, 0, 0}} * link.B.R, out.cosine);
    put(link.A.R * Mat3d{{0, -1, 0}, {1, 0, 0}, {0, 0, 0}} * link.B.R, out.sine);
  } else {
    put(link.A.R * link.B.R, out.still);
  }
  put(link.A.p, out.a);
  put(rotate_back(link.B.R, link.B.p), out.b);
  put(rotate_back(link.B.R, Vec3d{0, 0, 1}), out.z);
  out.has_a = !is_zero(link.A.p);
  out.has_b = !is_zero(link.B.p) || link.motion == Motion::kSlides;
  return out;
}

void add_quad(double x, double y, double z, std::vector<double>& quads) {
  quads.insert(quads.end(), {x, y, z, 0.0});
}

void add_quads(const StateLink& link, std::vector<double>& quads) {
  for (const double* R : {link.still, link.cosine, link.sine})
    for (int r = 0; r < 3; ++r) add_quad(R[3 * r], R[3 * r + 1], R[3 * r + 2], quads);
  for (const double* R : {link.still, link.cosine, link.sine})
    for (int c = 0; c < 3; ++c) add_quad(R[c], R[3 + c], R[6 + c], quads);
  for (const double* v : {link.a, link.b, link.z}) add_quad(v[0], v[1], v[2], quads);
}

void add_quads(const double* phi, std::vector<double>& quads) {
  add_quad(phi[1], phi[2], phi[3], quads);
  add_quad(phi[4], phi[5], phi[7], quads);
  add_quad(phi[5], phi[6], phi[8], quads);
  add_quad(phi[7], phi[8], phi[9], quads);
  add_quad(phi[0], 0.0, 0.0, quads);
}

}  // namespace

StateModel::StateModel(const Tree& tree, const VectorXd& phi)
    : coordinates_(tree.joints),
      joints_(0),
      bodies_(static_cast<int>(tree.body_links.size())),
      phi_(phi.data(), phi.data() + phi.size()),
      gravity_(tree.gravity) {
  for (const Link& link : tree.links) {
    links_.push_back(folded(link));
    if (link.motion != Motion::kNone) links_.back().joint = joints_++;
  }
  for (const StateLink& link : links_) add_quads(link, quads_);
  for (size_t k = 0; k < phi_.size(); k += 10) add_quads(phi_.data() + k, quads_);
  for (const Share& share : tree.shares) shares_.push_back({share.coordinate, share.coefficient});
}

StateTree StateModel::view() const {
  return {coordinates_,
          static_cast<int>(links_.size()),
          joints_,
          bodies_,
          links_.data(),
          shares_.data(),
          phi_.empty() ? nullptr : phi_.data(),
          quads_.data(),
          {gravity_.x, gravity_.y, gravity_.z}};
}

std::size_t StateModel::workspace() const {
  return state_kernels().workspace(view()) + kAlignment / sizeof(double);
}

double* StateModel::aligned(std::vector<double>& memory) {
  const auto at = reinterpret_cast<std::uintptr_t>(memory.data());
  return memory.data() + (kAlignment - at % kAlignment) % kAlignment / sizeof(double);
}

}  // namespace veridyn
