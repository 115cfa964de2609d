// Arms that hold an object, commanded by topics: a scenario of `veridyn cooperate` under run_live(), the
// cooperative controller of the thesis. Commands are those of `--live`, as lines on ~command; cmd_vel is the
// object's velocity, and cmd_force is added to the reference force of a member, as in the thesis's keyboard
// node. Each arm publishes NAME/measured_js and NAME/tip, each member MEMBER/force, so that a bag of them is
// a recording of every arm. With ~phases true the scenario's own phases run first.

#include <geometry_msgs/PointStamped.h>
#include <geometry_msgs/Twist.h>
#include <sensor_msgs/JointState.h>
#include <std_msgs/Float64.h>
#include <std_msgs/String.h>

#include <cmath>
#include <cstring>
#include <deque>
#include <map>
#include <sstream>

#include "core/lock_free.hpp"
#include "nodes/parameters.hpp"
#include "veridyn/cooperation/live.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/model_file.hpp"

namespace veridyn_ros {
namespace {

using namespace veridyn;

constexpr std::size_t kLongest = 160;

struct Line {
  char text[kLongest] = {};
};

// Lines from topics, without locks.
class TopicLines final : public LineSource {
 public:
  void push(const std::string& text) {
    Line line;
    if (text.size() >= kLongest || text.find('\n') != std::string::npos) {
      ROS_WARN("found a command of %zu characters, expected one line below %zu", text.size(), kLongest);
      return;
    }
    std::memcpy(line.text, text.c_str(), text.size());
    if (!lines_.push(line)) ROS_WARN_THROTTLE(1.0, "commands come faster than they are taken");
  }
  /// Sets lines that are executed before all others; call it before the node runs.
  void prepend_script(std::deque<std::string> script) { script_ = std::move(script); }
  bool next(std::string& line) override {
    if (!script_.empty()) {
      line = script_.front();
      script_.pop_front();
      return true;
    }
    Line one;
    if (!lines_.pop(one)) return false;
    line = one.text;
    return true;
  }
  bool closed() const override { return !ros::ok(); }

 private:
  Queue<Line, 64> lines_;
  std::deque<std::string> script_;
};

// The command as a line of parse_live_command().
std::string line_of(const ScenarioCommand& c, const Scenario& scenario) {
  using Kind = ScenarioCommand::Kind;
  std::ostringstream out;
  out.precision(17);
  const auto member = [&] { return scenario.members[c.member].name; };
  const auto way = [&] { out << c.way.x() << ' ' << c.way.y() << ' ' << c.way.z() << ' ' << c.over; };
  switch (c.kind) {
    case Kind::kMove: out << "move ", way(); break;
    case Kind::kTurn: out << "turn ", way(); break;
    case Kind::kTighten: out << "tighten " << c.amount << ' ' << c.over; break;
    case Kind::kForce: out << "force " << member() << ' ' << c.amount << ' ' << c.over; break;
    case Kind::kMoveArm: out << "arm " << scenario.arms[c.arm].name << ' ', way(); break;
    case Kind::kRelease: out << "release " << member(); break;
    case Kind::kTake: out << "take " << member(); break;
  }
  return out.str();
}

// The scenario's own phases, after a pause in which subscribers connect, and then the end.
std::deque<std::string> phases_of(const Scenario& scenario) {
  std::deque<std::string> out{"wait 2"};
  for (const ScenarioPhase& phase : scenario.phases) {
    for (const ScenarioCommand& c : phase.commands) out.push_back(line_of(c, scenario));
    std::ostringstream wait;
    wait << "wait " << phase.duration;
    out.push_back(wait.str());
  }
  out.push_back("quit");
  return out;
}

class Cooperation {
 public:
  explicit Cooperation(ros::NodeHandle& own) : scenario_(scenario_of(own)) {
    ros::NodeHandle root;
    for (const ScenarioArm& arm : scenario_.arms) {
      tips_[arm.name] = root.advertise<geometry_msgs::PointStamped>(arm.name + "/tip", 10);
      joints_.push_back(root.advertise<sensor_msgs::JointState>(arm.name + "/measured_js", 10));
      names_.emplace_back();
      const Model model = read_model(arm.model);
      for (const Coordinate& c : model.coordinates()) names_.back().push_back(c.name);
    }
    for (const ScenarioMember& member : scenario_.members)
      forces_[member.name] = root.advertise<std_msgs::Float64>(member.name + "/force", 10);
    if (own.param("phases", false)) lines_.prepend_script(phases_of(scenario_));
    state_ = own.advertise<std_msgs::String>("state", 10);
    warning_ = own.advertise<std_msgs::String>("warning", 10);
    const std::string space = own.param("space", std::string("psm"));
    subscribers_.push_back(own.subscribe<std_msgs::String>(
        "command", 10, [this](const std_msgs::String::ConstPtr& m) { lines_.push(m->data); }));
    subscribers_.push_back(root.subscribe<geometry_msgs::Twist>(
        space + "/cmd_vel", 10, [this](const geometry_msgs::Twist::ConstPtr& m) { move(*m); }));
    if (scenario_.members.empty()) return;
    member_ = own.param("member", scenario_.members.front().name);
    subscribers_.push_back(root.subscribe<std_msgs::Float64>(
        space + "/cmd_force", 10, [this](const std_msgs::Float64::ConstPtr& m) { press(m->data); }));
  }

  void run(ros::NodeHandle& own) {
    LiveOptions options;
    options.engine = own.param("engine", options.engine);
    options.silence = own.param("silence", 0.1);
    options.longest = own.param("longest", options.longest);
    options.tell = own.param("tell", 0.005);
    ros::AsyncSpinner spinner(1);
    spinner.start();
    LiveReport report;
    report.state = [this](const std::string& line) { publish_state(line); };
    report.refused = [this](const std::string& why) {
      std_msgs::String m;
      m.data = why;
      warning_.publish(m);
      ROS_WARN("command refused: %s", why.c_str());
    };
    began_ = ros::Time::now().toSec();
    report.arms = [this](double time, const std::vector<LiveArm>& arms) { publish_state(time, arms); };
    const LiveRun done = run_live(scenario_, lines_, options, report);
    ROS_INFO("%s", done.report().c_str());
  }

 private:
  static Scenario scenario_of(ros::NodeHandle& own) {
    std::string file;
    require(own.getParam("scenario", file), own.resolveName("scenario"),
            ": found no scenario, expected a file of `veridyn cooperate`.");
    return read_scenario(file);
  }

  // Queues a turn [rad] if the angular part is not zero, else a jog [m/s].
  void move(const geometry_msgs::Twist& t) {
    std::ostringstream line;
    const geometry_msgs::Vector3 &v = t.linear, &w = t.angular;
    if (w.x != 0.0 || w.y != 0.0 || w.z != 0.0)  // an increment of Euler angles, as in the thesis
      line << "turn " << w.x << ' ' << w.y << ' ' << w.z << " 0.5";
    else
      line << "jog " << v.x << ' ' << v.y << ' ' << v.z;
    lines_.push(line.str());
  }

  // Adds `more` [N] to the reference force of the member.
  void press(double more) {
    if (!std::isfinite(more)) {
      ROS_WARN("cmd_force: found a number that is not finite");
      return;
    }
    wanted_ += more;
    std::ostringstream line;
    line << "force " << member_ << ' ' << wanted_ << " 0.5";
    lines_.push(line.str());
  }

  // Publishes at the run's own steady clock.
  void publish_state(double time, const std::vector<LiveArm>& arms) {
    for (std::size_t k = 0; k < arms.size(); ++k) {
      sensor_msgs::JointState m;
      m.header.stamp = ros::Time(began_ + time);
      m.header.frame_id = scenario_.arms[k].name + "_base";
      m.name = names_[k];
      m.position.assign(arms[k].q.data(), arms[k].q.data() + arms[k].q.size());
      m.velocity.assign(arms[k].dq.data(), arms[k].dq.data() + arms[k].dq.size());
      m.effort.assign(arms[k].tau.data(), arms[k].tau.data() + arms[k].tau.size());
      joints_[k].publish(m);
    }
  }

  // Publishes the part after the quoted state of `t=1.200 state="tracks" master=x,y,z spring=5.0` as topics.
  void publish_state(const std::string& line) {
    std_msgs::String whole;
    whole.data = line;
    state_.publish(whole);
    std::istringstream words(line.substr(line.find_last_of('"') + 1));
    for (std::string word; words >> word;) {
      const std::string name = word.substr(0, word.find('='));
      const char* value = word.c_str() + name.size() + 1;
      const auto tip = tips_.find(name);
      if (tip != tips_.end()) {
        geometry_msgs::PointStamped p;
        p.header.stamp = ros::Time::now();
        p.header.frame_id = "world";
        if (std::sscanf(value, "%lf,%lf,%lf", &p.point.x, &p.point.y, &p.point.z) == 3)
          tip->second.publish(p);
      } else if (forces_.count(name) > 0) {
        std_msgs::Float64 f;
        f.data = std::atof(value);
        forces_[name].publish(f);
      }
    }
  }

  Scenario scenario_;
  TopicLines lines_;
  std::string member_;
  double wanted_ = 0.0, began_ = 0.0;  // [N] reference force, [s] start of the run
  std::vector<ros::Publisher> joints_;
  std::vector<std::vector<std::string>> names_;
  std::map<std::string, ros::Publisher> tips_, forces_;
  ros::Publisher state_, warning_;
  std::vector<ros::Subscriber> subscribers_;
};

void run(ros::NodeHandle& own) {
  Cooperation cooperation(own);
  cooperation.run(own);
}

}  // namespace
}  // namespace veridyn_ros

int main(int argc, char** argv) {
  return veridyn_ros::run_node(argc, argv, "veridyn_cooperate", veridyn_ros::run);
}
