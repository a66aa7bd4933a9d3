#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "dataset/dataset.h"
#include "host/evaluate/ifm/pcic.h"

// The files of one frame of an ifm O3R camera.
namespace stof::host {

struct FrameInfo {
  dsp::Pinhole lens;
  double unit_m = 0;
};

// The files beside info.json, and the buffer.
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
