#pragma once

#include "veridyn/diagnosis/diagnosis.hpp"

namespace veridyn {

/// The first finding whose cause has a rival that these recordings cannot separate; if there is none,
/// nothing.
NextExperiment next_experiment(const Diagnosis& diagnosis);

}  // namespace veridyn
