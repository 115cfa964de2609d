// From recordings, such as bags, to what the model of the arm lacks; the last one is held out:
//
//   example_04_from_a_bag psm-3dof monday.bag tuesday.bag wednesday.mcap
//   example_04_from_a_bag ur10e monday.bag tuesday.bag tau=A      efforts are motor currents

#include <iostream>

#include "veridyn/veridyn.hpp"

using namespace veridyn;

int main(int argc, char** argv) try {
  std::vector<std::string> train;
  PreprocessingOptions how;
  for (const std::string& word : std::vector<std::string>(argv + std::min(argc, 2), argv + argc)) {
    const std::size_t equals = word.find('=');
    if (equals == std::string::npos) train.push_back(word);
    else how.signals.units[word.substr(0, equals)] = word.substr(equals + 1);
  }
  if (train.size() < 2) {
    std::cerr << "found " << train.size() << " recordings, expected ROBOT TRAIN... TEST\n";
    return 2;
  }
  const Model arm = read_model(argv[1]);
  const Recordings test = read_recordings(arm, {train.back()}, how);
  train.pop_back();
  const Diagnosis lacks = diagnose(identify(arm, read_recordings(arm, train, how)), test);
  for (const Finding& cause : lacks.findings) std::cout << cause << "\n";
  if (lacks.findings.empty()) std::cout << "The model explains what was recorded.\n";
} catch (const InvalidInput& bad) {
  std::cerr << bad.what() << "\n";
  return 3;
}
