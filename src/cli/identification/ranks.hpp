#pragma once

#include <memory>
#include <string>

#include "veridyn/identification/many_machines.hpp"

namespace veridyn::cli {

/// The ranks of `mpirun -n N veridyn ...`; null where the tool runs alone.
/// @throws InvalidInput  mpirun started several processes of a tool built without MPI.
std::unique_ptr<Communicator> mpi_ranks();

/// Default number of threads of one rank: the machine's number of threads divided by that of its ranks.
int threads_of_a_rank(int asked);

/// Ends all ranks with this exit status.
[[noreturn]] void end_all_ranks(int status);

/// Prints one line on standard error if mpirun ends this rank because another one failed.
void print_on_abort(const std::string& line);

}  // namespace veridyn::cli
