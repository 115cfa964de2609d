#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iostream>

#include "fuzz/targets.hpp"

// libFuzzer's target, built with clang and VERIDYN_FUZZ=ON. `make fuzz` starts it:
//
//   veridyn_fuzzer --target=NAME CORPUS...   fuzzes one reader
//   veridyn_fuzzer --targets                 lists the readers
//   veridyn_fuzzer --target=NAME --seeds=DIR writes its seeds into a folder

namespace {

const veridyn::FuzzTarget* chosen = nullptr;

void write_seeds(const std::string& folder) {
  int number = 0;
  for (const std::string& seed : chosen->seeds()) {
    std::ofstream file(folder + "/seed-" + std::to_string(number++), std::ios::binary);
    file << seed;
    if (!file.flush()) std::exit(3);
  }
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  std::string seeds;
  for (int k = 1; k < *argc; ++k) {
    const std::string word = (*argv)[k];
    if (word == "--targets") {
      for (const veridyn::FuzzTarget& target : veridyn::fuzz_targets())
        std::cout << target.name << "\n";
      std::cout.flush();
      std::_Exit(0);
    }
    if (word.rfind("--seeds=", 0) == 0) seeds = word.substr(8);
    if (word.rfind("--target=", 0) != 0) continue;
    for (const veridyn::FuzzTarget& target : veridyn::fuzz_targets()) {
      if (target.name == word.substr(9)) chosen = &target;
    }
  }
  if (chosen == nullptr) {
    std::cerr << "found no reader of that name, expected --target=NAME, see --targets\n";
    std::_Exit(2);
  }
  if (!seeds.empty()) {
    write_seeds(seeds);
    std::_Exit(0);
  }
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string wrong = chosen->probe({reinterpret_cast<const char*>(data), size});
  if (!wrong.empty()) {
    std::fprintf(stderr, "contradiction: %s\n", wrong.c_str());
    std::abort();
  }
  return 0;
}
