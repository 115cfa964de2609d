#include <fstream>
#include <iostream>

#include "dvrk/vectors.hpp"

// Writes the vectors of section 19 into a folder, one file each, for the fuzzer to start from.
int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "expected one argument, the folder to write into\n";
    return 2;
  }
  int number = 0;
  for (const veridyn::dvrk::Vector& v : veridyn::dvrk::vectors()) {
    const std::vector<std::uint8_t> bytes = veridyn::dvrk::bytes_of(v.hex);
    std::ofstream file(std::string(argv[1]) + "/vector-" + std::to_string(number++),
                       std::ios::binary);
    file.write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
    if (!file) return 3;
  }
  return 0;
}
