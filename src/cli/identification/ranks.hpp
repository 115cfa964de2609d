#pragma once

#include <memory>
#include <string>

#include "veridyn/identification/many_machines.hpp"

namespace veridyn::cli {

/// The ranks of `mpirun -n N veridyn ...`; null where the tool runs alone.
/// @throws InvalidInput  mpirun started several of a tool that was built without MPI.
std::unique_ptr<Communicator> mpi_ranks();

/// Threads of one rank where none are asked for: those of the machine, shared with its other ranks.
int threads_of_a_rank(int asked);

/// Ends all ranks with this exit status.
[[noreturn]] void end_all_ranks(int status);

/// One line for standard error if mpirun ends this rank because another one was lost.
void when_another_rank_is_lost(const std::string& line);

}  // namespace veridyn::cli
