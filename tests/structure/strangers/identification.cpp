#include "pendulum.hpp"
#include "veridyn/excitation/excitation.hpp"

int main() {
  veridyn::ModelDescription limited = pendulum().description();
  limited.coordinates[0].limits = {-1.0, 1.0, 2.0, 10.0, 20.0};
  veridyn::ExcitationOptions options;
  options.iterations = 20;
  options.threads = 1;
  return veridyn::optimise_excitation(veridyn::Model(limited), options).condition_number >= 1.0 ? 0 : 1;
}
