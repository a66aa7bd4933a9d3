#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "dataset/dataset.h"

// The files of one frame of an ifm O3R camera.
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
  kPcicNoise = 105,
  kPcicX = 200,  // Cartesian; y and z are the next two
  kPcicConfidence = 300,
  kPcicTofInfo = 420,  // intrinsics, and those of the way back
};

// All chunks between "star" and "stop". One line that names `file` where there are none or one
// reaches beyond the end.
dataset::Loaded<std::vector<PcicChunk>> pcic_chunks(std::string_view buffer,
                                                    const std::filesystem::path& file);

struct FrameInfo {
  dsp::Pinhole lens;
  double unit_m = 0;
};

// What lies beside info.json, and the buffer.
struct CameraFrame {
  FrameInfo info;
  dataset::Image<std::uint16_t> radial;
  std::optional<dataset::Image<std::uint16_t>> amplitude;
  std::optional<dataset::Image<std::uint16_t>> noise;
  std::optional<dataset::Image<std::uint8_t>> confidence;
  std::string buffer;
  std::vector<PcicChunk> chunks;

  // Whether the camera gives a distance there and does not call it invalid.
  bool valid(std::size_t i) const;
  // The first chunk of a type, or null.
  const PcicChunk* chunk(std::uint32_t type) const;
  // Number n of a chunk's words of 1, 2 or 4 bytes, which must be there.
  std::uint32_t word(const PcicChunk& chunk, std::size_t n, std::size_t bytes) const;
  // Per pixel what an amplitude was multiplied by because of its exposure (bits 4 and 5 of the
  // confidence count from 1, the shortest): the factors that the amplitude chunk names. Empty where
  // the buffer or the confidence does not tell.
  std::vector<double> amplitude_factors() const;
};

// info.json, radial_distance.pgm, and where they are there amplitude.pgm, distance_noise.pgm,
// confidence.pgm, O3RBuffer.data. One line for what is bad.
dataset::Loaded<CameraFrame> read_camera_frame(const std::filesystem::path& folder);

}  // namespace stof::host
