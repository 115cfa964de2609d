#include <cmath>
#include <algorithm>
#include <iostream>
#include <memory>
#include <sstream>

#include "files/words.hpp"
#include "veridyn/tool/column_file.hpp"
#include "veridyn/tool/common_options.hpp"
#include "veridyn/tool/messages.hpp"
#include "veridyn/tool/open_commands.hpp"
#include "veridyn/tool/option_checks.hpp"
#include "veridyn/tool/sound_arguments.hpp"
#include "control/kinematics_table.hpp"
#include "files/output_file.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/model_file.hpp"
#include "report/json/kinematics_json.hpp"

namespace veridyn::cli {
namespace {

constexpr int kPostures = 1000;  // default number of random postures in the workspace

struct KinematicsRequest {
  std::string robot, forward, inverse, frame, output, solver = "closed-form";
  std::vector<double> start;
  int workspace = 0;
  bool jacobian = false;
  CommonOptions common;
  KinematicsExtension extension;
};

// Parses "0.1,0.2,0.3"; empty if the word is a file name.
std::vector<double> numbers_of(const std::string& word) {
  std::vector<double> out;
  std::istringstream parts(word);
  for (std::string part; std::getline(parts, part, ',');) {
    const std::optional<double> number = number_in(part);
    if (!number || !std::isfinite(*number)) return {};
    out.push_back(*number);
  }
  return out;
}

Eigen::Isometry3d pose_of(const ColumnFile& file, Eigen::Index row, bool oriented) {
  const auto value = [&](const char* name) { return file.values(row, file.at(name)); };
  Eigen::Isometry3d out = Eigen::Isometry3d::Identity();
  out.translation() << value("x"), value("y"), value("z");
  if (!oriented) return out;
  const Eigen::Quaterniond q(value("qw"), value("qx"), value("qy"), value("qz"));
  require(q.norm() > 1e-6, file.path, ":", row + 2,
          ": found a quaternion of length zero, expected one of length one.");
  out.linear() = q.normalized().toRotationMatrix();
  return out;
}

// An arm with its closed-form kinematics, if it has one.
struct Arm {
  Model model;
  std::string frame;
  InverseSolver closed_form;
};

std::string chosen_frame(const Model& model, const std::string& asked) {
  if (!asked.empty()) {
    expect_one_of("--frame", asked, frame_names(model));
    return asked;
  }
  for (const char* usual : {"tip", "tool"}) {
    if (model.find_frame(usual)) return usual;
  }
  return model.frames().back().name;
}

// Reads a robot file or name, or a name that a package knows.
Arm read_kinematic_arm(const std::string& robot, const std::string& frame, const KinematicsExtension& extension) {
  std::optional<KinematicsExtension::Arm> known;
  if (extension.read) known = extension.read(robot);
  Model model = known ? std::move(known->model) : read_model(robot);
  std::string at = chosen_frame(model, frame);
  const bool closed = known && at == "tip";
  return {std::move(model), std::move(at), closed ? known->closed_form : InverseSolver{}};
}

// Column t of a file of positions [s].
struct Times {
  bool has = false;
  VectorXd values;
};

KinematicTable forward_table(const KinematicsRequest& request, const Arm& arm, Times& times) {
  const std::vector<double> given = numbers_of(request.forward);
  if (!given.empty()) {
    expect_value(static_cast<int>(given.size()) == arm.model.joints(), "--forward", "found ",
                 given.size(), " joints, expected the ", arm.model.joints(), " of ",
                 arm.model.name(), ".");
    return forward_kinematics(arm.model, arm.frame,
                              Eigen::Map<const Eigen::RowVectorXd>(
                                  given.data(), static_cast<Eigen::Index>(given.size())));
  }
  const ColumnFile file = read_columns(request.forward, "joints as CSV: [t,]q1,q2 and so on");
  MatrixXd q(file.values.rows(), arm.model.joints());
  for (Eigen::Index i = 0; i < q.cols(); ++i)
    q.col(i) = file.values.col(file.at("q" + std::to_string(i + 1)));
  times = {file.find("t") >= 0, file.find("t") >= 0 ? VectorXd(file.values.col(file.find("t"))) : VectorXd()};
  return forward_kinematics(arm.model, arm.frame, q);
}

KinematicTable inverse(const KinematicsRequest& request, const Arm& arm, Times& times) {
  InverseTask task;
  task.start = Eigen::Map<const VectorXd>(request.start.data(),
                                          static_cast<Eigen::Index>(request.start.size()));
  const std::vector<double> given = numbers_of(request.inverse);
  if (!given.empty()) {
    expect_value(given.size() == 3 || given.size() == 7, "--inverse", "found ", given.size(),
                 " numbers, expected x,y,z or x,y,z,qw,qx,qy,qz.");
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translation() << given[0], given[1], given[2];
    task.has_orientation = given.size() == 7;
    if (task.has_orientation) {
      const double length = Eigen::Vector4d(given[3], given[4], given[5], given[6]).norm();
      expect_value(length > 1e-6, "--inverse",
                   "found a quaternion of length zero, expected one of length one.");
      pose.linear() =
          Eigen::Quaterniond(given[3], given[4], given[5], given[6]).normalized().toRotationMatrix();
    }
    task.poses.push_back(pose);
  } else {
    const ColumnFile file = read_columns(request.inverse, "poses as CSV: [t,]x,y,z[,qw,qx,qy,qz]");
    task.has_orientation = file.find("qw") >= 0;
    for (Eigen::Index k = 0; k < file.values.rows(); ++k)
      task.poses.push_back(pose_of(file, k, task.has_orientation));
    times = {file.find("t") >= 0, file.find("t") >= 0 ? VectorXd(file.values.col(file.find("t"))) : VectorXd()};
  }
  const bool closed = request.solver == "closed-form" && arm.closed_form && task.has_orientation;
  return inverse_kinematics(arm.model, arm.frame, task, closed ? arm.closed_form : InverseSolver{});
}

ExitStatus run(const CLI::App& used, KinematicsRequest request, const std::string& command) {
  require_writable(request.output, request.common.json, request.common.report);
  const int asked = (request.forward.empty() ? 0 : 1) + (request.inverse.empty() ? 0 : 1) +
                    (request.workspace > 0 ? 1 : 0);
  if (asked == 0) request.workspace = kPostures;
  if (asked > 1)
    throw CLI::ValidationError("kinematics", "expected one of --forward, --inverse, --workspace.");
  const Arm arm = read_kinematic_arm(request.robot, request.frame, request.extension);
  expect_prerequisites(used, {{"--start", !request.inverse.empty(), "--inverse"},
                              {"--solver", !request.inverse.empty(), "--inverse"},
                              {"--solver", arm.closed_form || request.solver == "newton",
                               "the tip of an arm with a closed form, as PSM1"},
                              {"--jacobian", !request.output.empty(), "-o"}});
  expect_value(request.start.empty() || static_cast<int>(request.start.size()) == arm.model.joints(),
               "--start", "found ", request.start.size(), " joints, expected the ", arm.model.joints(),
               " of ", arm.model.name());
  Times times;
  std::optional<Busy> busy(std::in_place, request.common, "computing postures");
  KinematicTable table = request.workspace > 0
                             ? sample_workspace(arm.model, arm.frame, request.workspace)
                         : request.inverse.empty() ? forward_table(request, arm, times)
                                                   : inverse(request, arm, times);
  table.has_time = times.has;
  for (std::size_t k = 0; times.has && k < table.rows.size(); ++k)
    table.rows[k].time = times.values[static_cast<Eigen::Index>(k)];
  if (!request.output.empty())
    write_kinematic_rows(table, request.output,
                         request.jacobian ? JacobianColumns::kWith : JacobianColumns::kWithout);
  write_results(request.common, table, arm.model, command);
  busy.reset();
  std::cout << table.report();
  return table.unreached() > 0 ? kDataCannotAnswer : kDone;
}

}  // namespace

void add_kinematics_command(CLI::App& tool, Outcome& outcome, const KinematicsExtension& extension) {
  const auto request = std::make_shared<KinematicsRequest>();
  request->extension = extension;
  CLI::App& command =
      *tool.add_subcommand("kinematics", "Forward and inverse kinematics, Jacobians, conditioning");
  add_value(command, "ROBOT", request->robot,
            "Robot file or name" + extension.robots)
      ->required();
  add_value(command, "--forward FILE.csv|Q1,Q2,...", request->forward,
            "Forward kinematics of these joint positions");
  add_value(command, "--inverse FILE.csv|X,Y,Z[,QW,QX,QY,QZ]", request->inverse,
            "Inverse kinematics of these poses");
  add_value(command, "--workspace COUNT", request->workspace,
            "Conditioning over the joint ranges, at so many random postures (1000 if no other "
            "output is selected)",
            CLI::Range(1, 1000000));
  add_value(command, "--frame NAME", request->frame, "Frame (default: tip, tool, or the last)");
  add_value(command, "--start Q1,Q2,...", request->start, "Start of inverse kinematics")
      ->delimiter(',');
  add_value(command, "--solver closed-form|newton", request->solver,
            "Solver of inverse kinematics; closed-form where the arm has one",
            CLI::IsMember({"closed-form", "newton"}));
  command.add_flag("--jacobian", request->jacobian, "Also write the Jacobian");
  add_output_option(command, "-o,--output", request->output, "Write the results as CSV", {".csv"});
  add_common_options(command, request->common);
  add_report_option(command, request->common);
  command.callback([request, &outcome, &command] {
    outcome.status = run(command, *request, outcome.command_line);
  });
}

}  // namespace veridyn::cli
