#pragma once

#include "veridyn/diagnosis/diagnosis.hpp"

namespace veridyn {

/// The experiment that separates the first finding from a rival that these recordings cannot exclude; empty
/// if no finding has such a rival.
NextExperiment next_experiment(const Diagnosis& diagnosis);

}  // namespace veridyn
