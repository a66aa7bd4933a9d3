#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/wire/frame/parity.h"
#include "firmware/wire/frame/part_store.h"
#include "firmware/wire/packet.h"

// Images cut into tiles. A tile holds whole rows wherever one row alone, coded, fits a payload of
// kMaxTilePayload bytes: as many as fit. A row that does not fit is split, and its packets are
// filled.
namespace stof::wire {

// How far a raw tile may go that begins in column `column`: to the last row's end that fits (0:
// none does) and to the last pixel that fits.
struct RawFit {
  std::size_t rows = 0;
  std::size_t all = 0;
};
constexpr RawFit raw_fit(std::size_t column, std::size_t width, std::size_t pixels_left,
                         std::size_t pixel_bytes) noexcept {
  const std::size_t all = std::min(kMaxTilePayload / pixel_bytes, pixels_left);
  const std::size_t first = width - column;
  return {.rows = all < first ? 0 : first + (all - first) / width * width, .all = all};
}
constexpr std::size_t chosen(const RawFit& fit) noexcept {
  return fit.rows > 0 ? fit.rows : fit.all;
}

// The kind and number of values: an image of a stream, or whole rows of one.
struct Raster {
  Stream stream = Stream::kNone;
  std::size_t width = 0;
  std::size_t height = 0;
  std::size_t first_row = 0;
  std::size_t image_height = 0;  // 0: they are the image
  std::uint8_t scale = 0;        // 0 to 15: they stand for what is 1 << scale times as large
  bool xor_delta = false;        // is_xor_delta() of each tile

  Part part(Codec codec, std::size_t first, std::size_t pixels,
            std::size_t payload_bytes) const noexcept;
};

// Tiles of a raw image, none of an empty one. It grows with width and height.
constexpr std::size_t raw_tiles(std::size_t width, std::size_t height,
                                std::size_t pixel_bytes) noexcept {
  const std::size_t capacity = kMaxTilePayload / pixel_bytes;
  if (width == 0 || height == 0) {
    return 0;
  }
  const std::size_t pixels = width <= capacity ? capacity / width * width : capacity;
  return (width * height + pixels - 1) / pixels;
}

// Pixels of a raw tile that begins with pixel `first` of a raster: whole rows, or, where no row
// fits, as many as fit.
constexpr std::size_t raw_pixels(const Raster& raster, std::size_t first,
                                 std::size_t pixel_bytes) noexcept {
  const RawFit fit = raw_fit(first % raster.width, raster.width,
                             raster.width * raster.height - first, pixel_bytes);
  return raster.width * pixel_bytes <= kMaxTilePayload ? fit.rows : fit.all;
}

// Add the tiles of an image of raster.width * raster.height values. T: std::uint8_t,
// std::uint16_t.
template <typename T>
void add_raw_tiles(std::span<const T> values, const Raster& raster, PartStore& store) noexcept;

// RVL, or raw where that is shorter: single tiles, or all of them where there would be more than
// raw_tiles(). Needs the space of one part more than that. try_rvl_tiles fails and changes nothing
// if more than `most` tiles are needed. add_rvl_tiles returns false if it stored all tiles raw.
template <typename T>
bool try_rvl_tiles(std::span<const T> values, const Raster& raster, std::size_t most,
                   PartStore& store) noexcept;
template <typename T>
bool add_rvl_tiles(std::span<const T> values, const Raster& raster, PartStore& store) noexcept;

}  // namespace stof::wire
