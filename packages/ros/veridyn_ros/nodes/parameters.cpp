#include "nodes/parameters.hpp"

#include <chrono>
#include <cmath>
#include <thread>

#include "veridyn/identification/identification.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/simulation/plausible_model.hpp"

namespace veridyn_ros {
namespace {

using namespace veridyn;

constexpr int kBadInput = 3;

// The middle of the joints' ranges; zero where there are none.
VectorXd middle_positions(const Model& arm) {
  VectorXd q = VectorXd::Zero(arm.joints());
  for (int i = 0; i < arm.joints(); ++i) {
    const Limits& l = arm.coordinates()[i].limits;
    const double m = 0.5 * (l.lower + l.upper);
    if (std::isfinite(m)) q[i] = m;
  }
  return q;
}

// Warns once if the master is gone: existing connections continue, new ones fail.
void watch_master(const std::string& name) {
  constexpr int kPause = 20;  // pause between two checks, in tenths of a second
  bool there = true;
  for (int k = 1; ros::ok(); ++k) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    if (k % kPause != 0) continue;
    const bool now = ros::master::check();
    if (now != there)
      std::fprintf(stderr, "%s: %s %s\n", name.c_str(),
                   now ? "the master is back at" : "what is connected goes on without a master; found none any more at",
                   ros::master::getURI().c_str());
    there = now;
  }
}

}  // namespace

std::vector<ArmParameters> read_arms(const ros::NodeHandle& own) {
  std::vector<std::string> names;
  require(own.getParam("arms", names) && !names.empty(), own.resolveName("arms"),
          ": found no list of arms, expected e.g. [PSM1].");
  std::vector<ArmParameters> out;
  for (const std::string& name : names) {
    std::string file;
    require(own.getParam(name + "/model", file), own.resolveName(name + "/model"),
            ": found no robot file, expected a MODEL or the name of a robot.");
    Model model = read_model(file);
    if (!has_all_values(model)) {
      model = plausible_model(model, static_cast<unsigned>(own.param(name + "/seed", 1))).arm;
      ROS_WARN("%s: %s has no values; plausible ones are used", name.c_str(), file.c_str());
    }
    std::vector<double> start;
    VectorXd q = middle_positions(model);
    if (own.getParam(name + "/start", start)) {
      require(static_cast<int>(start.size()) == model.joints(), own.resolveName(name + "/start"),
              ": found ", start.size(), " numbers, expected ", model.joints(), ".");
      q = Eigen::Map<const VectorXd>(start.data(), q.size());
    }
    out.push_back({name, std::move(model), std::move(q), own.param(name + "/tip", std::string())});
  }
  return out;
}

int run_node(int argc, char** argv, const std::string& name, void (*run)(ros::NodeHandle& own)) {
  ros::init(argc, argv, name);
  // Without a master the client library would retry for ever, with ten messages a second.
  if (!ros::master::check()) {
    std::fprintf(stderr, "%s: found no master at %s; start roscore or roslaunch\n", name.c_str(),
                 ros::master::getURI().c_str());
    return kBadInput;
  }
  int status = 0;
  try {
    ros::NodeHandle own("~");
    std::thread watch([&name] { watch_master(name); });
    try {
      run(own);
    } catch (const std::exception& error) {
      std::fprintf(stderr, "%s: %s\n", name.c_str(), error.what());
      status = kBadInput;
    }
    ros::shutdown();
    watch.join();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", name.c_str(), error.what());
    status = kBadInput;
  }
  return status;
}

}  // namespace veridyn_ros
