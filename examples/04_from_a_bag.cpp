// From two recordings, bags as they are, to what the model of the arm lacks:
//
//   example_04_from_a_bag psm-3dof monday.bag tuesday.mcap
//   example_04_from_a_bag ur10e monday.bag tuesday.bag tau=A      efforts are motor currents

#include <iostream>

#include "veridyn/diagnosis/diagnosis.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/model/model_file.hpp"

int main(int argc, char** argv) {
  if (argc < 4) {
    std::cerr << "found " << argc - 1 << " arguments, expected ROBOT TRAIN TEST [SIGNAL=UNIT...]\n";
    return 2;
  }
  try {
    const veridyn::Model arm = veridyn::read_model(argv[1]);
    veridyn::DiagnosisOptions how;
    for (int k = 4; k < argc; ++k) {
      const std::string unit = argv[k];
      const std::size_t equals = unit.find('=');
      veridyn::require(equals != std::string::npos, "found '", unit, "', expected SIGNAL=UNIT.");
      how.identification.preprocessing.signals.units[unit.substr(0, equals)] = unit.substr(equals + 1);
    }
    const veridyn::Diagnosis lacks = veridyn::diagnose(arm, {argv[2]}, {argv[3]}, how);
    for (const veridyn::Finding& cause : lacks.findings) std::cout << cause.sentence << "\n";
    if (lacks.findings.empty()) std::cout << "The model explains what was recorded.\n";
  } catch (const veridyn::InvalidInput& bad) {
    std::cerr << bad.what() << "\n";
    return 3;
  }
}
