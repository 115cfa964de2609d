#include "veridyn/kinematics/tree.hpp"

namespace veridyn {
namespace {

bool is_identity(const Posed& T) {
  const Mat3d& R = T.R;
  return T.p.x == 0 && T.p.y == 0 && T.p.z == 0 && R.row0.x == 1 && R.row1.y == 1 && R.row2.z == 1;
}

// Frames that the dynamics need: bodies and all moving frames above them.
std::vector<char> needed_frames(const Model& arm) {
  std::vector<char> needed(arm.frames().size(), 0);
  for (int k = static_cast<int>(arm.frames().size()) - 1; k >= 0; --k) {
    const Frame& frame = arm.frames()[k];
    if (frame.body) needed[k] = 1;
    if (needed[k] != 0 && frame.parent >= 0) needed[frame.parent] = 1;
  }
  return needed;
}

Motion motion_of(JointType type) {
  if (type == JointType::kRevolute) return Motion::kTurns;
  if (type == JointType::kPrismatic) return Motion::kSlides;
  return Motion::kNone;
}

// Appends the shares and movers of the last link.
void append_coordinates(const Model& arm, const Frame& frame, Tree& tree) {
  Link& link = tree.links.back();
  link.first_share = static_cast<int>(tree.shares.size());
  link.first_mover = static_cast<int>(tree.movers.size());
  for (int i = 0; i < tree.joints; ++i) {
    const double share = link.motion == Motion::kNone ? 0.0 : frame.variable.coefficients[i];
    if (share != 0.0) tree.shares.push_back({i, share});
    if (!arm.moves(link.frame, i)) continue;
    int above = -1;
    if (link.parent >= 0) {
      const Link& parent = tree.links[link.parent];
      for (int m = parent.first_mover; m < parent.end_mover; ++m) {
        if (tree.movers[m].coordinate == i) above = m;
      }
    }
    tree.movers.push_back({i, above, share});
  }
  link.end_share = static_cast<int>(tree.shares.size());
  link.end_mover = static_cast<int>(tree.movers.size());
}

}  // namespace

Tree::Tree(const Model& arm, Keep keep) : joints(arm.joints()) {
  const auto& frames = arm.frames();
  gravity = {arm.gravity().x(), arm.gravity().y(), arm.gravity().z()};
  const std::vector<char> needed =
      keep == Keep::kEveryFrame ? std::vector<char>(frames.size(), 1) : needed_frames(arm);
  link_of_frame.assign(frames.size(), -1);
  // T_link_frame: where a frame sits on the last link that was kept above it.
  std::vector<Posed> T_link_frame(frames.size(), identity_pose());
  std::vector<int> base(frames.size(), -1);
  for (int k = 0; k < static_cast<int>(frames.size()); ++k) {
    const Frame& frame = frames[k];
    const int above = frame.parent < 0 ? -1 : base[frame.parent];
    const Posed T_above_parent = frame.parent < 0 ? identity_pose() : T_link_frame[frame.parent];
    const bool fixed = frame.type == JointType::kFixed;
    if (needed[k] == 0 || (fixed && !frame.body && keep == Keep::kBodiesOnly)) {
      base[k] = above;
      T_link_frame[k] = T_above_parent * frame.A * frame.B;
      continue;
    }
    Link link{};
    link.frame = k;
    link.parent = above;
    link.body = -1;
    link.motion = motion_of(frame.type);
    link.A = fixed ? T_above_parent * frame.A * frame.B : T_above_parent * frame.A;
    link.B = fixed ? identity_pose() : frame.B;
    link.A_is_identity = is_identity(link.A);
    link.B_is_identity = is_identity(link.B);
    link.offset = frame.variable.offset;
    link_of_frame[k] = static_cast<int>(links.size());
    base[k] = link_of_frame[k];
    links.push_back(link);
    append_coordinates(arm, frame, *this);
  }
  for (const int k : arm.bodies()) {
    const int l = link_of_frame[k];
    links[l].body = static_cast<int>(body_links.size());
    body_links.push_back(l);
  }
}

Tree::operator Links() const {
  return {joints,
          static_cast<int>(links.size()),
          static_cast<int>(movers.size()),
          links.data(),
          shares.data(),
          movers.data(),
          gravity};
}

}  // namespace veridyn
