#include "many_recordings.hpp"

#include <algorithm>
#include <utility>

#include "identification/identification_numbers.hpp"
#include "math/parallel.hpp"

namespace veridyn {
int blocks_of_each(int recordings) {
  return std::max(1, identifying::numbers.blocks_of_all / std::max(1, recordings));
}

void merge_pairs(std::vector<std::vector<SquareRootInformation>>& blocks) {
  for (size_t k = 0; 2 * k < blocks.size(); ++k) {
    std::vector<SquareRootInformation> pair = std::move(blocks[2 * k]);
    if (2 * k + 1 < blocks.size()) {
      for (size_t i = 0; i < pair.size(); ++i) pair[i].merge(blocks[2 * k + 1][i]);
    }
    blocks[k] = std::move(pair);
  }
  blocks.resize((blocks.size() + 1) / 2);
}

void merge_blocks(CompressedRecording& recording, int most) {
  while (static_cast<int>(recording.blocks.size()) > most) merge_pairs(recording.blocks);
  recording.blocks.shrink_to_fit();
}

std::vector<CompressedRecording> compress_each(const std::vector<std::string>& paths, int threads,
                                         const std::function<CompressedRecording(const std::string&, int)>& read) {
  const auto count = static_cast<int>(paths.size());
  std::vector<CompressedRecording> out(paths.size());
  parallel_for(count, threads, [&](int k) { out[k] = read(paths[k], threads_of_each(count, threads)); });
  return out;
}

std::vector<CompressedRecording> compress_many(const Model& arm,
                                               const std::vector<std::string>& paths,
                                               const PreprocessingOptions& options, int threads) {
  return compress_each(paths, threads, [&](const std::string& path, int own) {
    CompressedRecording one = compress(arm, path, options, own);
    merge_blocks(one, blocks_of_each(static_cast<int>(paths.size())));
    return one;
  });
}

}  // namespace veridyn
