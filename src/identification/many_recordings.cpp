#include "many_recordings.hpp"

#include <algorithm>
#include <utility>

#include "identification/identification_numbers.hpp"
#include "math/parallel.hpp"

namespace veridyn {
int blocks_of_each(int recordings) {
  return std::max(1, identifying::numbers.blocks_of_all / std::max(1, recordings));
}

void merge_blocks(CompressedRecording& recording, int most) {
  auto& blocks = recording.blocks;
  while (static_cast<int>(blocks.size()) > most) {
    for (size_t k = 0; 2 * k < blocks.size(); ++k) {
      std::vector<SquareRootInformation> pair = std::move(blocks[2 * k]);
      if (2 * k + 1 < blocks.size()) {
        for (size_t i = 0; i < pair.size(); ++i) pair[i].merge(blocks[2 * k + 1][i]);
      }
      blocks[k] = std::move(pair);
    }
    blocks.resize((blocks.size() + 1) / 2);
  }
  blocks.shrink_to_fit();
}

std::vector<CompressedRecording> compress_many(const Model& arm,
                                               const std::vector<std::string>& paths,
                                               const PreprocessingOptions& options, int threads) {
  const auto count = static_cast<int>(paths.size());
  std::vector<CompressedRecording> out(paths.size());
  parallel_for(count, threads, [&](int k) {
    CompressedRecording one = compress(arm, paths[k], options,
                                       threads_of_each(count, threads));
    merge_blocks(one, blocks_of_each(count));
    out[k] = std::move(one);
  });
  return out;
}

}  // namespace veridyn
