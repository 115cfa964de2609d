#include "recordings/bags/inflate.hpp"

#include <bzlib.h>
#include <lz4frame.h>
#include <zstd.h>

#include <algorithm>
#include <memory>

#include "veridyn/math/require.hpp"

namespace veridyn::bags {
namespace {

constexpr std::size_t kFirstPiece = 1 << 16;

// Enlarges the buffer for the next piece: doubles it, up to the limit.
std::size_t grow(std::string* bytes, std::size_t used, std::size_t limit) {
  const std::size_t wanted = std::min(limit, std::max(kFirstPiece, 2 * used));
  if (wanted > bytes->size()) bytes->resize(wanted);
  return bytes->size() - used;
}

// The inflate functions return what they unpacked, at most `limit` bytes.
Inflated inflate_lz4(std::string_view packed, std::size_t limit) {
  LZ4F_dctx* raw = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&raw, LZ4F_VERSION)) != 0) return {};
  const std::unique_ptr<LZ4F_dctx, void (*)(LZ4F_dctx*)> context(
      raw, [](LZ4F_dctx* c) { LZ4F_freeDecompressionContext(c); });
  Inflated out;
  std::size_t used = 0;
  while (true) {
    std::size_t space = grow(&out.bytes, used, limit);
    std::size_t taken = packed.size();
    const std::size_t room_before = space;
    const std::size_t hint = LZ4F_decompress(context.get(), out.bytes.data() + used, &space,
                                             packed.data(), &taken, nullptr);
    if (LZ4F_isError(hint) != 0) break;
    used += space;
    packed.remove_prefix(taken);
    out.whole = hint == 0;
    if (out.whole || room_before == 0) break;
    if (packed.empty() && space < room_before) break;
  }
  out.bytes.resize(used);
  return out;
}

Inflated inflate_zstd(std::string_view packed, std::size_t limit) {
  const std::unique_ptr<ZSTD_DStream, std::size_t (*)(ZSTD_DStream*)> stream(ZSTD_createDStream(),
                                                                            ZSTD_freeDStream);
  if (stream == nullptr) return {};
  ZSTD_initDStream(stream.get());
  ZSTD_inBuffer in{packed.data(), packed.size(), 0};
  Inflated out;
  std::size_t used = 0;
  while (true) {
    const std::size_t space = grow(&out.bytes, used, limit);
    ZSTD_outBuffer place{out.bytes.data() + used, space, 0};
    const std::size_t hint = ZSTD_decompressStream(stream.get(), &place, &in);
    if (ZSTD_isError(hint) != 0) break;
    used += place.pos;
    out.whole = hint == 0;
    if (out.whole || space == 0) break;
    if (in.pos == in.size && place.pos < space) break;
  }
  out.bytes.resize(used);
  return out;
}

Inflated inflate_bz2(std::string_view packed, std::size_t limit) {
  bz_stream stream{};
  if (BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK) return {};
  const std::unique_ptr<bz_stream, int (*)(bz_stream*)> guard(&stream, BZ2_bzDecompressEnd);
  Inflated out;
  std::size_t used = 0;
  while (true) {
    const std::size_t space = std::min<std::size_t>(grow(&out.bytes, used, limit), 1u << 30);
    const auto in = static_cast<unsigned>(std::min<std::size_t>(packed.size(), 1u << 30));
    stream.next_in = const_cast<char*>(packed.data());
    stream.avail_in = in;
    stream.next_out = out.bytes.data() + used;
    stream.avail_out = static_cast<unsigned>(space);
    const int state = BZ2_bzDecompress(&stream);
    packed.remove_prefix(in - stream.avail_in);
    used += space - stream.avail_out;
    out.whole = state == BZ_STREAM_END;
    if (state != BZ_OK || space == 0) break;
    if (packed.empty() && stream.avail_out > 0) break;
  }
  out.bytes.resize(used);
  return out;
}

}  // namespace

Inflated inflate(std::string_view compression, std::string_view packed, std::size_t limit) {
  if (compression.empty() || compression == "none") {
    return {std::string(packed.substr(0, limit)), packed.size() <= limit};
  }
  if (compression == "lz4") return inflate_lz4(packed, limit);
  if (compression == "zstd") return inflate_zstd(packed, limit);
  if (compression == "bz2") return inflate_bz2(packed, limit);
  throw InvalidInput(text("found compression '", compression.substr(0, 40),
                          "', expected none, bz2, lz4 or zstd."));
}

}  // namespace veridyn::bags
