#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "dataset/dataset.h"

// The camera's own buffer of one frame, as its PCIC protocol sends it.
namespace stof::host {

// A chunk of the camera's PCIC buffer. All of it is little-endian.
struct PcicChunk {
  std::uint32_t type = 0;
  std::size_t size = 0;         // with header
  std::size_t header_size = 0;  // pixels begin behind it
  std::uint32_t version = 0;
  int width = 0;
  int height = 0;
  std::uint32_t format = 0;  // of a pixel: 0 u8, 2 u16, 3 i16, 6 float
  std::size_t at = 0;        // in the buffer
};
enum PcicType : std::uint32_t {
  kPcicRadial = 100,
  kPcicAmplitude = 101,
  kPcicX = 200,        // Cartesian; y and z are the next two
  kPcicTofInfo = 420,  // intrinsics, and those of the way back
};

// All chunks between "star" and "stop". One line that names `file` where there are none or one
// reaches beyond the end.
dataset::Loaded<std::vector<PcicChunk>> pcic_chunks(std::string_view buffer,
                                                    const std::filesystem::path& file);

}  // namespace stof::host
