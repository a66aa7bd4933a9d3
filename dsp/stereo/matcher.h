#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/base/fixed.h"
#include "dsp/base/image.h"
#include "dsp/base/status.h"
#include "dsp/stereo/match_params.h"

namespace stof::dsp {

// Block matching of one stereo pair: prefilter, SAD, lowest cost, left-right check, subpixel fit.
// Holds its buffers, allocates nothing. Disparities in the left image, none where no candidate
// lies inside the right image, where all of them cost the same (a flat, black or saturated picture)
// or where a check failed.
// Source: Kuhnert & Stommel 2006 sections 2.1, 2.3.
class Matcher {
 public:
  // Bytes of the Arena that a Matcher for images up to width x height takes.
  static std::size_t bytes_needed(const MatchParams& params, int width, int height) noexcept;

  // params, width and height must pass check().
  Matcher(const MatchParams& params, int width, int height, Arena& arena) noexcept;

  // left, right, out: equal size, at most the constructor's. Any size from 1x1; empty does nothing.
  void match(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right,
             ImageView<Disparity> out) noexcept;

  // The two halves of match(), for splitting: prefilter all rows, then match any rows.
  // The result of a row does not depend on the split.
  void prefilter(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right,
                 Rows rows) noexcept;
  void match_rows(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right,
                  Rows rows, ImageView<Disparity> out) noexcept;

 private:
  // What one row needs, cut from the Arena; `Sum` is u16 where the block allows it.
  template <typename Sum>
  struct Buffers;
  template <typename Sum>
  void match_rows_with(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right,
                       Rows rows, ImageView<Disparity> out) noexcept;
  template <typename Sum>
  void finish_row(const Buffers<Sum>& buffers, int lanes, std::span<Disparity> out) noexcept;

  MatchParams params_;
  int width_;
  int height_;
  ImageView<std::uint8_t> left_filtered_;
  ImageView<std::uint8_t> right_filtered_;
  std::span<std::byte> scratch_;  // one row's Buffers
};

}  // namespace stof::dsp
