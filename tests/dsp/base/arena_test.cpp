#include "dsp/base/arena.h"

#include <algorithm>
#include <array>

#include <gtest/gtest.h>

#include "dsp/base/arena_phase.h"
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

// A part with a phase of its own, in which it has two more.
struct Phases {
  explicit Phases(Arena& arena) noexcept
      : through(arena.take_passing<std::uint8_t>(64)),
        first(Buffer(ArenaPhase(arena), 128).bytes),
        second(Buffer(ArenaPhase(arena), 64).bytes) {}

  struct Buffer {
    Buffer(Arena& arena, std::size_t size) noexcept
        : bytes(arena.take_passing<std::uint8_t>(size)) {}
    std::span<std::uint8_t> bytes;
  };

  std::span<std::uint8_t> through;  // both
  std::span<std::uint8_t> first;
  std::span<std::uint8_t> second;
};

TEST(Arena, PhasesShareWhatTheyTakeInPassing) {
  EXPECT_EQ(bytes_taken([](Arena& arena) noexcept { const Phases all(arena); }), 192U);
  const auto whole = [](Arena& arena) noexcept {
    const Phases one{ArenaPhase(arena)};
    arena.take<std::uint8_t>(1);
    const Phases other{ArenaPhase(arena)};
    return std::array{one, other};
  };
  ASSERT_EQ(bytes_taken(whole), 256U);
  alignas(Arena::kAlign) std::array<std::uint8_t, 256 + 1> memory{};  // an end that is not aligned
  Arena arena(std::as_writable_bytes(std::span(memory)));
  const auto [one, other] = whole(arena);
  EXPECT_EQ(one.through.data(), other.through.data());
  EXPECT_EQ(one.through.data(), memory.data() + 192);  // what passes lies at the end
  EXPECT_EQ(one.first.data() + one.first.size(), one.through.data());
  EXPECT_EQ(one.second.data() + one.second.size(), one.through.data());
  EXPECT_EQ(one.first.data(), memory.data() + 64);  // behind what lasts
  EXPECT_DEATH(arena.take<std::uint8_t>(1), "internal error");
}

TEST(Arena, WithoutPhasesNothingIsShared) {
  alignas(Arena::kAlign) std::array<std::byte, 256> memory{};
  Arena arena(memory);
  const std::span<std::uint8_t> a = arena.take_passing<std::uint8_t>(64);
  const std::span<std::uint8_t> b = arena.take_passing<std::uint8_t>(64);
  EXPECT_EQ(b.data() + 64, a.data());
  EXPECT_DEATH(arena.take<std::uint8_t>(129), "internal error");
  EXPECT_DEATH(arena.take_passing<std::uint8_t>(129), "internal error");
  EXPECT_EQ(arena.take<std::uint8_t>(128).data() + 128, b.data());
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
