#include "cli/identification/ranks.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <cstring>

#include "math/parallel.hpp"
#include "veridyn/math/require.hpp"

#ifdef VERIDYN_WITH_MPI
#include <mpi.h>
#endif

namespace veridyn::cli {
namespace {

// The number in an environment variable that mpirun (or srun) sets for its processes; 0: it is not set.
int from_environment(const char* open_mpi, const char* others) {
  for (const char* name : {open_mpi, others}) {
    const char* value = std::getenv(name);
    if (value != nullptr) return std::atoi(value);
  }
  return 0;
}

std::array<char, 1024> last_words{};

extern "C" void print_last_line(int) {
  const ssize_t written = ::write(STDERR_FILENO, last_words.data(), std::strlen(last_words.data()));
  ::_exit(written < 0 ? 1 : 143);
}

#ifdef VERIDYN_WITH_MPI

constexpr std::uint64_t kPiece = std::uint64_t{1} << 28;  // largest message in bytes; counts of MPI are ints

class MpiRanks final : public Communicator {
 public:
  MpiRanks() {
    MPI_Init(nullptr, nullptr);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
    MPI_Comm_size(MPI_COMM_WORLD, &size_);
  }
  ~MpiRanks() override { MPI_Finalize(); }
  MpiRanks(const MpiRanks&) = delete;
  MpiRanks& operator=(const MpiRanks&) = delete;

  int rank() const override { return rank_; }
  int size() const override { return size_; }

  void send(int to, const std::string& bytes) override {
    const std::uint64_t size = bytes.size();
    MPI_Send(&size, 1, MPI_UINT64_T, to, 0, MPI_COMM_WORLD);
    for (std::uint64_t at = 0; at < size; at += kPiece)
      MPI_Send(bytes.data() + at, static_cast<int>(std::min(kPiece, size - at)), MPI_BYTE, to, 1,
               MPI_COMM_WORLD);
  }

  std::string receive(int from) override {
    std::uint64_t size = 0;
    MPI_Recv(&size, 1, MPI_UINT64_T, from, 0, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
    std::string bytes(size, '\0');
    for (std::uint64_t at = 0; at < size; at += kPiece)
      MPI_Recv(bytes.data() + at, static_cast<int>(std::min(kPiece, size - at)), MPI_BYTE, from, 1,
               MPI_COMM_WORLD, MPI_STATUS_IGNORE);
    return bytes;
  }

 private:
  int rank_ = 0;
  int size_ = 1;
};

#endif

}  // namespace

std::unique_ptr<Communicator> mpi_ranks() {
  const int started = from_environment("OMPI_COMM_WORLD_SIZE", "PMI_SIZE");
  if (started < 1) return nullptr;
#ifdef VERIDYN_WITH_MPI
  return std::make_unique<MpiRanks>();
#else
  require(started == 1, "mpirun started ", started,
          " processes, but this veridyn was built without MPI; expected a build with "
          "VERIDYN_MPI=ON.");
  return nullptr;
#endif
}

int threads_of_a_rank(int asked) {
  if (asked > 0) return asked;
  const int neighbours = from_environment("OMPI_COMM_WORLD_LOCAL_SIZE", "MPI_LOCALNRANKS");
  return std::max(1, number_of_threads(0) / std::max(1, neighbours));
}

void end_all_ranks(int status) {
#ifdef VERIDYN_WITH_MPI
  MPI_Abort(MPI_COMM_WORLD, status);
#endif
  std::_Exit(status);
}

void print_on_abort(const std::string& line) {
  const std::string words = line + "\n";
  std::strncpy(last_words.data(), words.c_str(), last_words.size() - 1);
  std::signal(SIGTERM, &print_last_line);
}

}  // namespace veridyn::cli
