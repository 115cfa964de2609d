#include "cli/models/export_dvrk.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <memory>
#include <optional>

#include "veridyn/tool/common_options.hpp"
#include "veridyn/tool/option_checks.hpp"
#include "veridyn/tool/sound_arguments.hpp"
#include "dvrk/arms/effort_scales.hpp"
#include "dvrk/arms/gravity_chain.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/model/suggestion.hpp"

namespace veridyn::cli {
namespace {

struct DvrkExport {
  std::string gravity;  // file for the rows of gravity compensation
  std::string scales;   // file for current per effort
  std::string arm;      // "PSM1"; empty: from the model's name
  std::string config;   // configuration to correct by the scales; empty: the arm's nominal one
  std::string torques;  // static torques to compare the rows with
};

// The named arm, or the first whose name begins with the first three letters of the model's.
dvrk::ArmFacts find_arm(const Model& model, const std::string& name) {
  if (!name.empty()) {
    expect_one_of("--dvrk-arm", name, dvrk::arm_names());
    return dvrk::read_arm(name);
  }
  std::string start = model.name().substr(0, 3);
  for (char& letter : start)
    letter = static_cast<char>(std::toupper(static_cast<unsigned char>(letter)));
  for (const std::string& known : dvrk::arm_names())
    if (known.rfind(start, 0) == 0 && start.size() == 3) return dvrk::read_arm(known);
  throw InvalidInput(text("model '", model.name(),
                          "': found no dVRK arm in its name, expected --dvrk-arm with one of: ",
                          listed(dvrk::arm_names()), "."));
}

// "N" or "N m"; empty if the chain does not have the joint.
std::string effort_unit_of(const dvrk::GravityChain& chain, const std::string& joint) {
  for (const dvrk::GravityRow& row : chain.rows)
    if (row.joint == joint) return row.prismatic ? "N" : "N m";
  return "";
}

void print_gravity(const dvrk::GravityChain& chain) {
  fmt::print("{}: gravity of the model in {} rows\n", chain.arm, chain.rows.size());
  for (std::size_t k = 0; k < chain.joints.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    fmt::print("  {:<12} up to {:.4g} {unit}, the rows differ by up to {:.2g} {unit}\n",
               chain.joints[k], chain.largest_torque[i], chain.largest_error[i],
               fmt::arg("unit", effort_unit_of(chain, chain.joints[k])));
  }
  for (const dvrk::GravityRow& row : chain.rows) {
    if (row.mass < 0.0)
      fmt::print("  the mass of {} is {:.4g} kg: counterweights outweigh it\n", row.joint,
                 row.mass);
  }
  if (!chain.left_out.empty())
    fmt::print("  torques at rest that rows cannot carry: {}\n", listed(chain.left_out));
}

// Compares reported efforts with the rows: root mean square of the residual and of the efforts.
void print_static_torques(const dvrk::GravityChain& chain, const dvrk::StaticTorques& measured, const std::string& path) {
  const auto n =
      std::min<Eigen::Index>(measured.q.cols(), static_cast<Eigen::Index>(chain.rows.size()));
  VectorXd rest = VectorXd::Zero(n);
  VectorXd all = VectorXd::Zero(n);
  for (Eigen::Index s = 0; s < measured.q.rows(); ++s) {
    VectorXd q = VectorXd::Zero(chain.rows.size());
    q.head(n) = measured.q.row(s).head(n);
    const VectorXd tau = dvrk::gravity_torques(chain, q);
    for (Eigen::Index i = 0; i < n; ++i) {
      rest[i] += std::pow(measured.tau(s, i) - tau[i], 2);
      all[i] += std::pow(measured.tau(s, i), 2);
    }
  }
  const double samples = static_cast<double>(measured.q.rows());
  fmt::print("{}: {} samples at rest\n", path, measured.q.rows());
  for (Eigen::Index i = 0; i < n; ++i) {
    const dvrk::GravityRow& row = chain.rows[i];
    fmt::print("  {:<12} {:.4g} {unit} rms, without gravity {:.4g} {unit}\n", row.joint,
               std::sqrt(all[i] / samples), std::sqrt(rest[i] / samples),
               fmt::arg("unit", row.prismatic ? "N" : "N m"));
  }
}

void print_scales(const std::string& arm, const std::vector<dvrk::EffortScale>& scales) {
  fmt::print("{}: current per effort\n", arm);
  for (const dvrk::EffortScale& scale : scales) {
    fmt::print("  {:<12} {:.7g} {}", scale.actuator, scale.scale, scale.unit);
    if (scale.source.empty())
      fmt::print(", unchanged\n");
    else
      fmt::print(", was {:.7g} ({})\n", scale.before, scale.source);
  }
}

void add_dvrk_export_options(CLI::App& command, DvrkExport& request) {
  add_output_option(command, "--dvrk-gravity", request.gravity,
                  "Write gravity as rows of a PSM or ECM for the dVRK's compensation (JSON)");
  add_output_option(command, "--dvrk-scales", request.scales,
                  "Write current per effort with identified gains (JSON)");
  add_value(command, "--dvrk-arm NAME", request.arm,
            "Arm, such as PSM1 [the first whose name the model's begins with]");
  add_value(command, "--dvrk-config FILE", request.config,
            "Configuration of the controllers whose scales are corrected (XML or JSON) [nominal]");
  add_value(command, "--static-torques FILE", request.torques,
            "Compare the gravity rows with efforts of the resting arm (CSV)");
}

void check_dvrk_export(const DvrkExport& request) {
  if (!request.config.empty() && request.scales.empty())
    throw CLI::RequiresError("--dvrk-config", "--dvrk-scales");
  if (!request.torques.empty() && request.gravity.empty())
    throw CLI::RequiresError("--static-torques", "--dvrk-gravity");
  if (!request.arm.empty() && request.gravity.empty() && request.scales.empty())
    throw CLI::RequiresError("--dvrk-arm", "--dvrk-gravity or --dvrk-scales");
}

void add_dvrk_files(const Model& model, const DvrkExport& request, std::vector<FileToWrite>& files) {
  if (request.gravity.empty() && request.scales.empty()) return;
  const dvrk::ArmFacts arm = find_arm(model, request.arm);
  if (!request.gravity.empty()) {
    const dvrk::GravityChain chain = dvrk::fit_gravity_chain(model, arm);
    std::optional<dvrk::StaticTorques> measured;
    if (!request.torques.empty()) measured = dvrk::read_static_torques(request.torques);
    files.push_back({request.gravity, dvrk::to_gravity_json(chain, model.name()), [chain, measured, path = request.torques] {
                       print_gravity(chain);
                       if (measured) print_static_torques(chain, *measured, path);
                     }});
  }
  if (!request.scales.empty()) {
    const dvrk::IoConfig config =
        request.config.empty() ? dvrk::nominal_config(arm) : dvrk::read_io_config(request.config);
    const std::vector<dvrk::EffortScale> scales = dvrk::corrected_scales(model, arm, config.robot(arm.name));
    files.push_back({request.scales, dvrk::to_scales_json(arm.name, scales), [name = arm.name, scales] { print_scales(name, scales); }});
  }
}

}  // namespace

ExportExtension export_dvrk() {
  const auto request = std::make_shared<DvrkExport>();
  return {"--dvrk-gravity or --dvrk-scales",
          [request](CLI::App& command) { add_dvrk_export_options(command, *request); },
          [request] { check_dvrk_export(*request); },
          [request] { return std::vector<std::string>{request->gravity, request->scales}; },
          [request](const Model& model, std::vector<FileToWrite>& files) { add_dvrk_files(model, *request, files); }};
}

}  // namespace veridyn::cli
