#include "host/recording/mcap/zstd.h"

#include <new>

#include <zstd.h>

namespace stof::mcap {

void ZstdCompressor::Close::operator()(void* context) const noexcept {
  ZSTD_freeCCtx(static_cast<ZSTD_CCtx*>(context));
}

ZstdCompressor::ZstdCompressor(int level) : context_(ZSTD_createCCtx()) {
  auto* const context = static_cast<ZSTD_CCtx*>(context_.get());
  if (context == nullptr ||
      ZSTD_isError(ZSTD_CCtx_setParameter(context, ZSTD_c_compressionLevel, level)) != 0) {
    throw std::bad_alloc();
  }
}

void ZstdCompressor::compress(Bytes bytes, Buffer& out) {
  out.resize(ZSTD_compressBound(bytes.size()));
  const std::size_t size = ZSTD_compress2(static_cast<ZSTD_CCtx*>(context_.get()), out.data(),
                                          out.size(), bytes.data(), bytes.size());
  if (ZSTD_isError(size) != 0) {
    throw std::bad_alloc();  // the bound holds: nothing else can be missing
  }
  out.resize(size);
}

bool decompress_zstd(Bytes bytes, std::span<std::byte> out) noexcept {
  const std::size_t size = ZSTD_decompress(out.data(), out.size(), bytes.data(), bytes.size());
  return ZSTD_isError(size) == 0 && size == out.size();
}

}  // namespace stof::mcap
