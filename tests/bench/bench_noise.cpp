#include "tests/bench/bench_work.h"

namespace stof::bench {
namespace {

// A random number for a point of a grid, the same on every machine.
std::uint32_t scattered(std::uint32_t x, std::uint32_t y) {
  std::uint32_t h = x * 0x9E3779B1U ^ (y + 0x7F4A7C15U) * 0x85EBCA77U;
  h = (h ^ (h >> 15U)) * 0xC2B2AE3DU;
  return h ^ (h >> 13U);
}

// Noise with cells of 2^shift px, 0..255, linear between the corners of a cell.
std::uint32_t noise(std::uint32_t x, std::uint32_t y, unsigned shift) {
  const std::uint32_t size = 1U << shift;
  const std::uint32_t fx = x & (size - 1);
  const std::uint32_t fy = y & (size - 1);
  const auto corner = [&](std::uint32_t dx, std::uint32_t dy) {
    return scattered((x >> shift) + dx, (y >> shift) + dy + (shift << 20U)) & 255U;
  };
  const std::uint32_t top = corner(0, 0) * (size - fx) + corner(1, 0) * fx;
  const std::uint32_t bottom = corner(0, 1) * (size - fx) + corner(1, 1) * fx;
  return (top * (size - fy) + bottom * fy) >> (2 * shift);
}

std::uint8_t grey(int x, int y) {
  const auto u = static_cast<std::uint32_t>(x + 4096);
  const auto v = static_cast<std::uint32_t>(y + 4096);
  return static_cast<std::uint8_t>((2 * noise(u, v, 4) + noise(u, v, 2) + noise(u, v, 1)) / 4);
}

}  // namespace

Pictures made_pictures(int width, int height) {
  Pictures pictures{.name = "noise", .left = {width, height}, .right = {width, height}};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      // Surfaces are tiles of 80x60 px, each at a disparity of its own, in the right picture.
      const std::uint32_t tile =
          scattered(static_cast<std::uint32_t>(x / 80), static_cast<std::uint32_t>(y / 60));
      const int disparity = 4 + static_cast<int>(tile % 48U);
      pictures.left.view().at(x, y) = grey(x, y);
      pictures.right.view().at(x, y) = grey(x + disparity, y);
    }
  }
  return pictures;
}

}  // namespace stof::bench
