#pragma once

#include "veridyn/diagnosis/diagnosis.hpp"

namespace veridyn {

/// The first finding whose cause has a rival that these recordings cannot separate; failing that,
/// nothing.
NextExperiment next_experiment(const Diagnosis& diagnosis);

}  // namespace veridyn
