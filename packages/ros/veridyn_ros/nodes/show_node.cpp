// Input of RViz: NAME/robot_description (URDF with rods for links), transforms of all its links, and
// ~markers: forces at the tips, their paths, members between them. Arms are those of ~arms, or of ~scenario,
// as run by veridyn_cooperate.
//
// The force at a tip is NAME/measured_cf, in the arm's base; a member's is MEMBER/force, positive if it
// pulls.

#include <geometry_msgs/WrenchStamped.h>
#include <sensor_msgs/JointState.h>
#include <std_msgs/Float64.h>
#include <tf2_msgs/TFMessage.h>
#include <visualization_msgs/MarkerArray.h>

#include <deque>

#include "nodes/looks.hpp"
#include "nodes/parameters.hpp"
#include "veridyn/cooperation/scenario.hpp"
#include "veridyn/kinematics/kinematics.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/model_file.hpp"

namespace veridyn_ros {
namespace {

using namespace veridyn;
using Eigen::Isometry3d;
using Eigen::Vector3d;
using visualization_msgs::Marker;

constexpr std::size_t kTrail = 400;        // number of positions of a tip that are shown
constexpr double kTrailStep = 0.0005;      // [m] distance of two of these positions
constexpr double kLeastForce = 0.05;       // [N] least force that is shown

struct Arm {
  Arm(std::string its_name, Model links) : name(std::move(its_name)), model(std::move(links)) {}
  std::string name;
  Model model;  // all links of the URDF
  FrameIndex tip;
  Isometry3d base = Isometry3d::Identity();  // pose of the base in the world
  VectorXd q;
  bool seen = false;
  Vector3d force = Vector3d::Zero();  // [N] force at the tip in the base
  std::deque<Vector3d> trail;
  std::vector<ros::Subscriber> subscribers;
  Vector3d tip_in_world() const { return base * frame_pose(model, q, tip).translation(); }
};

struct Member {
  std::string name;
  std::size_t from = 0, to = 1;
  double force = 0.0;  // [N] tension of the member
  ros::Subscriber subscriber;
};

geometry_msgs::Point point(const Vector3d& p) {
  geometry_msgs::Point out;
  out.x = p.x();
  out.y = p.y();
  out.z = p.z();
  return out;
}

Marker marker(const std::string& space, int id, int type, float r, float g, float b) {
  Marker m;
  m.header.frame_id = "world";
  m.header.stamp = ros::Time::now();
  m.ns = space;
  m.id = id;
  m.type = type;
  m.pose.orientation.w = 1.0;
  m.color.r = r;
  m.color.g = g;
  m.color.b = b;
  m.color.a = 1.0F;
  return m;
}

class Show {
 public:
  explicit Show(ros::NodeHandle& own) : scale_(own.param("metres_per_newton", 0.02)) {
    require(scale_ > 0.0, own.resolveName("metres_per_newton"), ": found ", scale_, ", expected a number above zero.");
    std::string scenario;
    if (own.getParam("scenario", scenario)) add_arms(read_scenario(scenario));
    else add_arms(own);
    transforms_ = root_.advertise<tf2_msgs::TFMessage>("/tf", 100);
    markers_ = own.advertise<visualization_msgs::MarkerArray>("markers", 10);
  }

  void run(double rate) {
    for (ros::WallRate pace(rate); ros::ok(); pace.sleep()) {
      ros::spinOnce();
      send_transforms();
      send_markers();
    }
  }

 private:
  void add_arms(const Scenario& scenario) {
    for (const ScenarioArm& a : scenario.arms) {
      add(a.name, read_model(a.model), a.frame, a.start);
      arms_.back().base = placed(a.position, a.turn);
    }
    for (const ScenarioMember& m : scenario.members) {
      Member& member = members_.emplace_back();
      member.name = m.name;
      member.from = static_cast<std::size_t>(m.from);
      member.to = static_cast<std::size_t>(m.to);
      member.subscriber = root_.subscribe<std_msgs::Float64>(
          m.name + "/force", 10, [&member](const std_msgs::Float64::ConstPtr& f) { member.force = f->data; });
    }
  }

  void add_arms(ros::NodeHandle& own) {
    for (const ArmParameters& p : read_arms(own)) {
      add(p.name, p.model, p.tip, p.start);
      std::vector<double> base;
      if (!own.getParam(p.name + "/base", base)) continue;
      require(base.size() == 6, own.resolveName(p.name + "/base"), ": found ", base.size(),
              " numbers, expected x, y, z [m] and angles about x, y, z [rad].");
      arms_.back().base = placed(Vector3d(base[0], base[1], base[2]), Vector3d(base[3], base[4], base[5]));
    }
  }

  // Pose from a position [m] and angles [rad]: R = Rz Ry Rx.
  static Isometry3d placed(const Vector3d& position, const Vector3d& turn) {
    Isometry3d out = Isometry3d::Identity();
    out.translation() = position;
    out.linear() = (Eigen::AngleAxisd(turn.z(), Vector3d::UnitZ()) * Eigen::AngleAxisd(turn.y(), Vector3d::UnitY()) *
                    Eigen::AngleAxisd(turn.x(), Vector3d::UnitX())).toRotationMatrix();
    return out;
  }

  void add(const std::string& name, const Model& model, const std::string& tip, const VectorXd& start) {
    const Looks looks = appearance_of(model);
    root_.setParam(name + "/robot_description", looks.urdf);
    Arm& arm = arms_.emplace_back(name, looks.links);
    const std::string frame = !tip.empty() ? tip : model.find_frame("tool") ? "tool" : model.frames().back().name;
    const std::optional<FrameIndex> found = arm.model.find_frame(frame);
    require(found.has_value(), name, ": found no frame '", frame, "' for its tip.");
    arm.tip = *found;
    arm.q = start;
    arm.subscribers = {
        root_.subscribe<sensor_msgs::JointState>(name + "/measured_js", 1, [&arm](const sensor_msgs::JointState::ConstPtr& m) {
          if (m->position.size() != static_cast<std::size_t>(arm.q.size())) return;
          arm.q = Eigen::Map<const VectorXd>(m->position.data(), arm.q.size());
          arm.seen = arm.q.allFinite();
        }),
        root_.subscribe<geometry_msgs::WrenchStamped>(
            name + "/measured_cf", 1, [&arm](const geometry_msgs::WrenchStamped::ConstPtr& m) {
              arm.force = Vector3d(m->wrench.force.x, m->wrench.force.y, m->wrench.force.z);
            })};
  }

  void transform(tf2_msgs::TFMessage& out, const std::string& parent, const std::string& child, const Isometry3d& T) {
    geometry_msgs::TransformStamped t;
    t.header.stamp = ros::Time::now();
    t.header.frame_id = parent;
    t.child_frame_id = child;
    t.transform.translation.x = T.translation().x();
    t.transform.translation.y = T.translation().y();
    t.transform.translation.z = T.translation().z();
    const Eigen::Quaterniond q(T.linear());
    t.transform.rotation.x = q.x();
    t.transform.rotation.y = q.y();
    t.transform.rotation.z = q.z();
    t.transform.rotation.w = q.w();
    out.transforms.push_back(t);
  }

  void send_transforms() {
    tf2_msgs::TFMessage out;
    for (const Arm& arm : arms_) {
      transform(out, "world", arm.name + "_base", arm.base);
      transform(out, arm.name + "_base", arm.name + "/world", Isometry3d::Identity());
      if (!arm.q.allFinite()) continue;
      for (std::size_t f = 0; f < arm.model.frames().size(); ++f)
        transform(out, arm.name + "_base", arm.name + "/" + arm.model.frames()[f].name,
                  frame_pose(arm.model, arm.q, {static_cast<int>(f)}));
    }
    transforms_.publish(out);
  }

  // Appends an arrow from a point [m] for a force [N], both in the world; a small force removes the arrow.
  void arrow(visualization_msgs::MarkerArray& out, const std::string& name, const Vector3d& from, const Vector3d& force) const {
    Marker m = marker(name + "/force", 0, Marker::ARROW, 0.85F, 0.1F, 0.1F);
    if (force.norm() < kLeastForce || !force.allFinite()) {
      m.action = Marker::DELETE;
    } else {
      m.points = {point(from), point(from + scale_ * force)};
      m.scale.x = 0.006;
      m.scale.y = 0.014;
      m.scale.z = 0.02;
    }
    out.markers.push_back(m);
  }

  void send_markers() {
    visualization_msgs::MarkerArray out;
    std::vector<Vector3d> pull(arms_.size(), Vector3d::Zero());
    for (const Member& member : members_) {
      const Vector3d a = arms_[member.from].tip_in_world(), b = arms_[member.to].tip_in_world();
      const Vector3d along = (b - a).norm() > 0.0 ? Vector3d((b - a).normalized()) : Vector3d::Zero();
      pull[member.from] -= member.force * along;  // force of the tip on the object
      pull[member.to] += member.force * along;
      Marker line = marker(member.name, 0, Marker::LINE_STRIP, 0.95F, 0.75F, 0.1F);
      line.points = coil(a, b);
      line.scale.x = 0.002;
      out.markers.push_back(line);
      Marker words = marker(member.name, 1, Marker::TEXT_VIEW_FACING, 0.1F, 0.1F, 0.1F);
      words.pose.position = point(0.5 * (a + b) + Vector3d(0.0, 0.0, 0.05));
      words.scale.z = 0.03;
      char text[80];
      std::snprintf(text, sizeof text, "%s %.2f N", member.name.c_str(), member.force);
      words.text = text;
      out.markers.push_back(words);
    }
    for (std::size_t k = 0; k < arms_.size(); ++k) {
      Arm& arm = arms_[k];
      const Vector3d tip = arm.tip_in_world();
      arrow(out, arm.name, tip, members_.empty() ? Vector3d(arm.base.linear() * arm.force) : pull[k]);
      if (arm.seen && (arm.trail.empty() || (tip - arm.trail.back()).norm() > kTrailStep)) arm.trail.push_back(tip);
      if (arm.trail.size() > kTrail) arm.trail.pop_front();
      Marker trail = marker(arm.name + "/way", 0, Marker::LINE_STRIP, 0.1F, 0.35F, 0.9F);
      trail.scale.x = 0.003;
      if (arm.trail.size() < 2) continue;
      for (const Vector3d& p : arm.trail) trail.points.push_back(point(p));
      out.markers.push_back(trail);
    }
    markers_.publish(out);
  }

  // A spring from tip to tip.
  static std::vector<geometry_msgs::Point> coil(const Vector3d& a, const Vector3d& b) {
    constexpr int kTurns = 12, kSides = 12;
    constexpr double kRadius = 0.01, kStraight = 0.1;
    const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitX(), b - a);
    std::vector<geometry_msgs::Point> out{point(a)};
    for (int k = 0; k <= kTurns * kSides; ++k) {
      const double s = static_cast<double>(k) / (kTurns * kSides), angle = 2.0 * M_PI * k / kSides;
      const Vector3d round = turn * Vector3d(0.0, kRadius * std::cos(angle), kRadius * std::sin(angle));
      out.push_back(point(a + (kStraight + (1.0 - 2.0 * kStraight) * s) * (b - a) + round));
    }
    out.push_back(point(b));
    return out;
  }

  ros::NodeHandle root_;
  double scale_;  // [m/N] length of a drawn force
  std::deque<Arm> arms_;
  std::deque<Member> members_;
  ros::Publisher transforms_, markers_;
};

void run(ros::NodeHandle& own) {
  Show show(own);
  show.run(own.param("rate", 30.0));
}

}  // namespace
}  // namespace veridyn_ros

int main(int argc, char** argv) {
  return veridyn_ros::run_node(argc, argv, "veridyn_show", veridyn_ros::run);
}
