// What earns the interior point of src/excitation its place: criterion and processor seconds beside
// NLopt's SLSQP and Ipopt, which get the same searches (trial descents, starts, exact gradients). On
// one core; see docs/excitation.md for the table.
//
//   veridyn-excitation-solvers [SEEDS [SOLVER...]]

#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "veridyn/excitation/excitation.hpp"
#include "veridyn/files/model_file.hpp"

namespace veridyn {
namespace {

double processor_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_utime.tv_sec) +
         1e-6 * static_cast<double>(usage.ru_utime.tv_usec);
}

void compare(const std::string& robot, ExcitationCriterion criterion, int seeds,
             const std::vector<ExcitationSolver>& solvers) {
  const Model arm = read_model(robot);
  for (const ExcitationSolver solver : solvers) {
    std::vector<double> values, seconds;
    for (int seed = 1; seed <= seeds; ++seed) {
      ExcitationOptions options;
      options.criterion = criterion;
      options.solver = solver;
      options.threads = 1;
      options.seed = static_cast<unsigned>(seed);
      const double begun = processor_seconds();
      const Excitation e = optimise_excitation(arm, options);
      seconds.push_back(processor_seconds() - begun);
      values.push_back(criterion == ExcitationCriterion::kCondition ? e.condition_number
                                                                    : e.log_determinant);
    }
    std::sort(values.begin(), values.end());
    std::sort(seconds.begin(), seconds.end());
    const auto middle = static_cast<size_t>(seeds / 2);
    std::printf("| %s | %s | %s | %.4g | %.4g to %.4g | %.2f |\n", robot.c_str(),
                name_of(criterion), name_of(solver), values[middle], values.front(),
                values.back(), seconds[middle]);
    std::fflush(stdout);
  }
}

}  // namespace
}  // namespace veridyn

int main(int count, char** words) {
  using namespace veridyn;
  const int seeds = count > 1 ? std::max(1, std::atoi(words[1])) : 5;
  const std::vector<std::string> wanted(words + std::min(count, 2), words + count);
  std::vector<ExcitationSolver> solvers;
  for (const ExcitationSolver solver :
       {ExcitationSolver::kInteriorPoint, ExcitationSolver::kIpopt, ExcitationSolver::kNlopt}) {
    const bool named = std::find(wanted.begin(), wanted.end(), name_of(solver)) != wanted.end();
    if (is_built_in(solver) && (named || wanted.empty())) solvers.push_back(solver);
  }
  std::printf("| arm | criterion | solver | median | range | processor seconds |\n");
  std::printf("|---|---|---|---|---|---|\n");
  for (const auto criterion : {ExcitationCriterion::kCondition, ExcitationCriterion::kDOptimal}) {
    for (const char* robot : {"psm-3dof", "psm-wrist", "kuka-lwr4"})
      compare(robot, criterion, seeds, solvers);
  }
  return 0;
}
