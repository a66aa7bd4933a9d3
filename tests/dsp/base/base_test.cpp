#include <algorithm>
#include <array>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "dsp/base/arena.h"
#include "dsp/base/fixed.h"
#include "dsp/base/image.h"
#include "dsp/base/status.h"

namespace stof::dsp {
namespace {

TEST(Fixed, RoundShiftRoundsHalvesUp) {
  EXPECT_EQ(round_shift(7, 3), 1);
  EXPECT_EQ(round_shift(4, 3), 1);
  EXPECT_EQ(round_shift(3, 3), 0);
  EXPECT_EQ(round_shift(-4, 3), 0);
  EXPECT_EQ(round_shift(-5, 3), -1);
}

TEST(Fixed, DisparityNoneIsNoDisparity) {
  EXPECT_FALSE(Disparity::none().valid());
  EXPECT_FALSE(Disparity{}.valid());
  EXPECT_TRUE(Disparity::from_pixels(0).valid());
  EXPECT_EQ(Disparity::from_pixels(-3).raw, -48);
  EXPECT_FLOAT_EQ(Disparity::from_raw(24).pixels(), 1.5F);
}

TEST(ImageView, RowsFollowTheStrideAndBordersReplicate) {
  const std::array<std::uint8_t, 10> pixels{1, 2, 3, 99, 99, 4, 5, 6, 99, 99};
  const ImageView<const std::uint8_t> image(pixels.data(), 3, 2, 5);
  EXPECT_EQ(image.at(0, 1), 4);
  EXPECT_EQ(image.row(1).size(), 3U);
  EXPECT_EQ(image.row_clamped(-7)[2], 3);
  EXPECT_EQ(image.row_clamped(50)[2], 6);
}

TEST(ImageViewDeathTest, RowsOutsideAreOurOwnBug) {
  std::array<std::uint8_t, 4> pixels{};
  const ImageView<std::uint8_t> image(pixels.data(), 2, 2);
  EXPECT_DEATH(image.row(2), "internal error");
  EXPECT_DEATH(image.at(-1, 0), "internal error");
  EXPECT_DEATH((ImageView<std::uint8_t>(pixels.data(), 2, 2, 1)), "internal error");
}

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

TEST(Status, EveryStatusHasItsOwnName) {
  std::set<std::string> names;
  for (int i = 0; i <= static_cast<int>(Status::kUnsupported); ++i) {
    names.insert(to_string(static_cast<Status>(i)));
  }
  EXPECT_EQ(names.size(), 9U);
}

}  // namespace
}  // namespace stof::dsp
