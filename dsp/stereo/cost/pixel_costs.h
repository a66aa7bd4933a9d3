#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/base/image.h"
#include "dsp/stereo/cost/cost_layout.h"
#include "dsp/stereo/match_params.h"

namespace stof::dsp {

enum class PixelCost : std::uint8_t {
  kCensus5x5,  // Hamming distance of 24 bits, 0..24
  kCensus9x7,  // Hamming distance of 62 bits, 0..62
  kAdCensus,   // census 7x7, grey values and their derivative (ad_census.h)
};

// The costs of single pixels, one row at a time, for costs that fit u8 and are dear to compute.
// Holds its buffers, allocates nothing; a row depends on the pictures alone.
class PixelCosts {
 public:
  // For pictures up to `width`, with these columns beyond either side. Uses the range of
  // disparities of params.
  PixelCosts(PixelCost cost, const MatchParams& params, int width, CostColumns columns,
             Arena& arena) noexcept;

  // Another pair of pictures, at most the constructor's width.
  void start(const CostPictures& pictures) noexcept;

  // Row y, inside the picture, laid out [column][candidate] as in sad.h: width + before + after
  // columns of lanes_of(params) costs. Candidates outside the right picture compare with its
  // border; mark_outside() tells them.
  void row(int y, std::span<std::uint8_t> costs) noexcept;

 private:
  // The rows of one picture in the layout of the kernels.
  struct Side {
    std::span<std::uint8_t> planes;
    std::span<std::uint8_t> grey;
    std::span<std::uint8_t> derivative;
  };

  void describe(ImageView<const std::uint8_t> picture, int y) noexcept;

  PixelCost cost_;
  int min_disparity_;
  CostColumns columns_;
  int width_;
  int lanes_;
  std::span<std::uint8_t> described_;  // census planes of a picture's own columns
  std::span<std::uint8_t> derived_;    // derivative of a picture's own columns
  Side left_;
  Side right_;
  CostPictures pictures_;
};

}  // namespace stof::dsp
