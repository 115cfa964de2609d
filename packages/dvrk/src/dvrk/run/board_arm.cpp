#include "veridyn/dvrk/board_arm.hpp"

#include <algorithm>
#include <filesystem>

#include "dvrk/arms/arm_facts.hpp"
#include "dvrk/protocol/udp_link.hpp"
#include "dvrk/run/arm_session.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

using namespace dvrk;

// An arm's wiring and, for a known arm, its coupling and the usual PID gains.
struct Wiring {
  RobotConfig robot;
  MatrixXd coupling;  // empty: identity
  VectorXd kp, kd;
};

// Reads the configuration; zero gains for an arm that is not known. @throws InvalidInput  see BoardArm.
Wiring wiring_of(const BoardArmOptions& options) {
  const std::vector<std::string> names = arm_names();
  const auto is_known = [&](const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  std::error_code ignored;
  const bool is_file = std::filesystem::is_regular_file(options.config, ignored);
  Wiring out;
  out.robot = (is_file ? read_io_config(options.config) : nominal_config(read_arm(options.config))).robot(options.robot);
  const int n = out.robot.size();
  out.kp = out.kd = VectorXd::Zero(n);
  const std::string& name = is_file ? out.robot.name : options.config;
  require(is_known(name) || options.instrument.empty(), "instrument: found '", options.instrument,
          "', but '", name, "' is no known arm.");
  if (!is_known(name)) return out;
  const ArmFacts facts = read_arm(name);
  out.coupling = facts.coupling(options.instrument);
  require(out.coupling.rows() == n, options.config, ": found ", n, " actuators, expected ",
          out.coupling.rows(), ", as ", name, " has.");
  for (int j = 0; j < n; ++j) {
    out.kp[j] = facts.actuators[j].kp;
    out.kd[j] = facts.actuators[j].kd;
  }
  return out;
}

ArmSessionOptions session_of(const Wiring& wiring, const BoardArmOptions& options) {
  ArmSessionOptions o;
  o.actuator_to_joint = wiring.coupling;
  o.rate = options.rate;
  o.watchdog = options.watchdog;
  o.reply_timeout = options.reply_timeout;
  return o;
}

}  // namespace

struct BoardArm::Parts {
  Parts(const Wiring& wiring, const BoardArmOptions& options)
      : kp(wiring.kp),
        kd(wiring.kd),
        link(options.host, options.port),
        session(link, wiring.robot, session_of(wiring, options)),
        held(VectorXd::Zero(session.joints())),
        all(held) {}

  VectorXd kp, kd;
  UdpLink link;
  ArmSession session;
  VectorXd held, all;  // positions at power-up; torques
  bool was_ready = false;
};

BoardArm::BoardArm(const BoardArmOptions& options) {
  require(options.rate >= 100.0 && options.rate <= 10000.0, "rate: found ", options.rate,
          " Hz, expected 100 to 10000.");
  parts_ = std::make_unique<Parts>(wiring_of(options), options);
  parts_->session.start();
}

BoardArm::~BoardArm() = default;

int BoardArm::joints() const { return parts_->session.joints(); }
const VectorXd& BoardArm::q() const { return parts_->session.state().q; }
const VectorXd& BoardArm::dq() const { return parts_->session.state().dq; }
const VectorXd& BoardArm::tau() const { return parts_->session.state().tau; }

bool BoardArm::read() noexcept {
  Parts& p = *parts_;
  const bool valid = p.session.update();
  const bool now = p.session.ready();
  if (!p.was_ready && valid) p.held = p.session.state().q;
  p.was_ready = now;
  return valid;
}

void BoardArm::set_torques(const VectorRef& tau) noexcept {
  Parts& p = *parts_;
  const Eigen::Index n = std::min<Eigen::Index>(tau.size(), p.all.size());
  for (Eigen::Index j = 0; j < p.all.size(); ++j)
    p.all[j] = j < n ? tau[j] : p.kp[j] * (p.held[j] - q()[j]) - p.kd[j] * dq()[j];
  p.session.set_torques(p.all);
}

const VectorXd& BoardArm::sent() const { return parts_->session.command().tau; }

void BoardArm::write() noexcept { parts_->session.commit(); }

const char* BoardArm::power_on() noexcept {
  BoardSession& boards = parts_->session.boards();
  if (boards.state() == PowerState::kFault && !boards.acknowledge())
    return "a board was rebooted, or does not answer: begin anew";
  return parts_->session.power_on();
}

void BoardArm::power_off() noexcept { parts_->session.power_off(); }
bool BoardArm::ready() const { return parts_->session.ready(); }

bool BoardArm::powered() const {
  const PowerState state = parts_->session.boards().state();
  return state != PowerState::kOff && state != PowerState::kFault;
}

const char* BoardArm::fault() const noexcept {
  const BoardSession& boards = parts_->session.boards();
  return boards.state() == PowerState::kFault ? describe(boards.cause()) : nullptr;
}

bool BoardArm::shutdown() noexcept {
  Parts& p = *parts_;
  p.session.power_off();
  for (int k = 0; k < 10; ++k) {
    p.session.update();
    p.session.commit();
  }
  return p.session.boards().shutdown() == OffState::kConfirmed;
}

}  // namespace veridyn
