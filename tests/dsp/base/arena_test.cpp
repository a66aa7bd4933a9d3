#include "dsp/base/arena.h"

#include <algorithm>
#include <array>

#include <gtest/gtest.h>

#include "dsp/base/image.h"

namespace stof::dsp {
namespace {

TEST(Arena, PartsAreAlignedAndDoNotOverlap) {
  alignas(Arena::kAlign) std::array<std::byte, 256> memory{};
  Arena arena(memory);
  const std::span<std::uint8_t> a = arena.take<std::uint8_t>(3);
  const std::span<std::uint32_t> b = arena.take<std::uint32_t>(16);
  EXPECT_EQ(reinterpret_cast<std::byte*>(a.data()), memory.data());
  EXPECT_EQ(reinterpret_cast<std::byte*>(b.data()), memory.data() + 64);
  EXPECT_EQ(Arena::bytes_for<std::uint8_t>(3) + Arena::bytes_for<std::uint32_t>(16), 128U);
}

// A part as all of them are: its constructor takes memory, and fills it where there is any.
struct Part {
  Part(int width, int height, Arena& arena) noexcept
      : image(arena.take_image<std::uint16_t>(width, height)), table(arena.take<std::uint8_t>(3)) {
    if (!arena.is_measuring()) {
      std::ranges::fill(table, std::uint8_t{1});
    }
  }
  ImageView<std::uint16_t> image;
  std::span<std::uint8_t> table;
};

TEST(Arena, MeasuresWhatAConstructorTakes) {
  const std::size_t bytes = bytes_taken([](Arena& arena) noexcept { Part(5, 7, arena); });
  EXPECT_EQ(bytes, 192U);  // 70 bytes and 3, each from an aligned place
  alignas(Arena::kAlign) std::array<std::byte, 192> memory{};
  Arena arena(memory);
  EXPECT_FALSE(arena.is_measuring());
  const Part part(5, 7, arena);
  EXPECT_EQ(part.table[2], 1);
  EXPECT_EQ(bytes_taken([](Arena&) noexcept {}), 0U);
}

TEST(ArenaDeathTest, MeasuredMemoryIsNobodys) {
  Arena arena = Arena::measuring();
  const std::span<std::byte> bytes = arena.take<std::byte>(1 << 20);
  EXPECT_DEATH(bytes[1000] = std::byte{1}, "");
}

TEST(ArenaDeathTest, RunningOutIsOurOwnBug) {
  alignas(Arena::kAlign) std::array<std::byte, 64> memory{};
  Arena arena(memory);
  EXPECT_DEATH(arena.take<std::uint8_t>(65), "internal error");
}

}  // namespace
}  // namespace stof::dsp
