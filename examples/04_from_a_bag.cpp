// From recordings, bags as they are, to what the model of the arm lacks; the last one is held out:
//
//   example_04_from_a_bag psm-3dof monday.bag tuesday.bag wednesday.mcap
//   example_04_from_a_bag ur10e monday.bag tuesday.bag tau=A      efforts are motor currents

#include <iostream>

#include "veridyn/diagnosis/diagnosis.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/model/model_file.hpp"

int main(int argc, char** argv) {
  std::vector<std::string> recordings;
  veridyn::DiagnosisOptions how;
  for (int k = 2; k < argc; ++k) {
    const std::string word = argv[k];
    const std::size_t equals = word.find('=');
    if (equals == std::string::npos) {
      recordings.push_back(word);
    } else {
      how.identification.preprocessing.signals.units[word.substr(0, equals)] = word.substr(equals + 1);
    }
  }
  if (recordings.size() < 2) {
    std::cerr << "found " << recordings.size() << " recordings, expected ROBOT TRAIN... TEST\n";
    return 2;
  }
  const std::string held_out = recordings.back();
  recordings.pop_back();
  try {
    const veridyn::Model arm = veridyn::read_model(argv[1]);
    const veridyn::Diagnosis lacks = veridyn::diagnose(arm, recordings, {held_out}, how);
    for (const veridyn::Finding& cause : lacks.findings) std::cout << lacks.sentence(cause) << "\n";
    if (lacks.findings.empty()) std::cout << "The model explains what was recorded.\n";
  } catch (const veridyn::InvalidInput& bad) {
    std::cerr << bad.what() << "\n";
    return 3;
  }
}
