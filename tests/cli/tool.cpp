#include "cli/tool.hpp"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "veridyn/regressor/standard_parameters.hpp"
#include "veridyn/files/model_file.hpp"

namespace veridyn {
namespace {

constexpr double kRate = 100.0;  // [Hz]

void redirect(int stream, const std::string& path) {
  const int file = ::open(path.c_str(), O_RDWR | O_CREAT | O_TRUNC, 0600);
  if (file < 0 || ::dup2(file, stream) < 0) ::_exit(126);
}

[[noreturn]] void become_tool(const Words& arguments) {
  std::vector<char*> argv;
  for (const std::string& word : arguments) argv.push_back(const_cast<char*>(word.c_str()));
  argv.push_back(nullptr);
  ::execv(VERIDYN_TOOL, argv.data());
  ::_exit(127);
}

}  // namespace

long ToolRun::error_lines() const {
  return std::count(err.begin(), err.end(), '\n');
}

ToolRun run_tool(const Words& arguments, const std::string& working_folder, unsigned longest) {
  const TemporaryFolder folder;
  const std::string out = folder.path("out");
  const std::string err = folder.path("err");
  const pid_t child = ::fork();
  if (child == 0) {
    redirect(STDIN_FILENO, folder.path("in"));
    redirect(STDOUT_FILENO, out);
    redirect(STDERR_FILENO, err);
    if (!working_folder.empty() && ::chdir(working_folder.c_str()) != 0) ::_exit(126);
    ::alarm(longest);  // which the tool inherits
    become_tool(Words{"veridyn"} + arguments);
  }
  int status = 0;
  rusage usage{};
  if (child < 0 || ::wait4(child, &status, 0, &usage) != child) {
    throw std::runtime_error("the tool could not be started");
  }
  ToolRun run;
  run.status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  run.out = content_of(out);
  run.err = content_of(err);
  run.peak_kib = usage.ru_maxrss;
  return run;
}

Words operator+(Words a, const Words& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

TemporaryFolder::TemporaryFolder() {
  std::string name = (std::filesystem::temp_directory_path() / "veridyn-test-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
  folder_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

std::string TemporaryFolder::write(const std::string& name, const std::string& content) const {
  std::ofstream(path(name), std::ios::binary) << content;
  return path(name);
}

Words TemporaryFolder::files() const {
  Words names;
  for (const auto& entry : std::filesystem::directory_iterator(folder_)) {
    names.push_back(entry.path().filename().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::string content_of(const std::string& path) {
  std::ostringstream content;
  content << std::ifstream(path, std::ios::binary).rdbuf();
  return content.str();
}

nlohmann::json json_of(const std::string& path) {
  return nlohmann::json::parse(content_of(path));
}

std::string planar_recording(double seconds, double shoulder, double elbow) {
  const Model arm = read_model("planar-2r");
  const std::vector<StandardParameter> parameters = standard_parameters(arm);
  VectorXd values(parameters.size());
  for (std::size_t j = 0; j < parameters.size(); ++j) {
    values[static_cast<Eigen::Index>(j)] = parameters[j].value;
  }
  const Eigen::Vector2d size(shoulder, elbow);
  // Sums of two sines without a common period visit many states.
  const Eigen::Vector2d slow(1.9, 2.3);
  const Eigen::Vector2d fast(4.1, 5.3);
  std::string out = "t,q1,q2,dq1,dq2,tau1,tau2\n";
  char line[256];
  for (int k = 0; k < static_cast<int>(seconds * kRate); ++k) {
    const double t = k / kRate;
    const auto sum = [&](double a, double b, double phase) {
      const Eigen::Array2d s = (slow * t).array() + phase;
      const Eigen::Array2d f = (fast * t).array() + phase;
      return VectorXd(size.array() * (a * slow.array().pow(b) * s.sin() +
                                      0.4 * a * fast.array().pow(b) * f.sin()));
    };
    const VectorXd q = sum(1.0, 0.0, 0.3);
    const VectorXd dq = sum(1.0, 1.0, 0.3 + M_PI / 2);
    const VectorXd ddq = sum(-1.0, 2.0, 0.3);
    const VectorXd tau = full_regressor(arm, q, dq, ddq) * values;
    std::snprintf(line, sizeof line, "%.2f,%.9f,%.9f,%.9f,%.9f,%.9f,%.9f\n", t, q[0], q[1], dq[0],
                  dq[1], tau[0], tau[1]);
    out += line;
  }
  return out;
}

}  // namespace veridyn
