#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

// Pixel formats of V4L2 that hold one brightness a pixel, and what is made of them
// (kernel documentation, userspace-api/media/v4l/yuv-formats.html).
namespace stof::hal::linux {

using FourCc = std::uint32_t;

constexpr FourCc fourcc(const char (&name)[5]) noexcept {
  FourCc code = 0;
  for (int i = 3; i >= 0; --i) {
    code = code << 8 | static_cast<std::uint8_t>(name[i]);
  }
  return code;
}

inline constexpr FourCc kGrey = fourcc("GREY");  // 8 bits
// 10, 12 and 16 bits in 16, little-endian, unused bits above.
inline constexpr FourCc kY10 = fourcc("Y10 ");
inline constexpr FourCc kY12 = fourcc("Y12 ");
inline constexpr FourCc kY16 = fourcc("Y16 ");
inline constexpr FourCc kYuyv = fourcc("YUYV");  // 8 bits, each followed by one of colour
// Two pixels in three bytes as MIPI CSI-2 packs RAW12: bits 11..4 of the first, of the second, then
// bits 3..0 of the second above those of the first.
inline constexpr FourCc kY12p = fourcc("Y12P");

// "GREY"; what cannot be printed is a dot.
std::string to_string(FourCc format);

// Bytes that `width` pixels take; 0: not one of these formats, or not that many pixels (Y12P takes
// an even number).
std::size_t row_bytes(FourCc format, int width) noexcept;

// One row to 8 bits, for all formats but Y12P. Deeper ones lose their low bits (Y10 2, Y12 4, Y16
// 8), without rounding up; what has bits above its depth becomes 255. `row` holds
// row_bytes(format, out.size()) at least.
void to_grey(FourCc format, std::span<const std::uint8_t> row,
             std::span<std::uint8_t> out) noexcept;

// One row of Y10, Y12, Y16 or Y12P as it is. `row` holds row_bytes(format, out.size()) at least.
void to_samples(FourCc format, std::span<const std::uint8_t> row,
                std::span<std::uint16_t> out) noexcept;

}  // namespace stof::hal::linux
