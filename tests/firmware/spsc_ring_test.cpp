#include "firmware/spsc_ring.h"

#include <array>
#include <cstdint>
#include <thread>

#include <gtest/gtest.h>

namespace stof::test {
namespace {

using firmware::SpscRing;

TEST(SpscRing, GivesBackInOrderAndRefusesWhenFull) {
  SpscRing<int, 4> ring;
  EXPECT_FALSE(ring.pop());
  for (int round = 0; round < 3; ++round) {  // over the end of the array
    for (int i = 0; i < 4; ++i) {
      EXPECT_TRUE(ring.push(i));
    }
    EXPECT_FALSE(ring.push(4));
    EXPECT_EQ(ring.size(), 4U);
    EXPECT_EQ(ring.pop(), 0);
    EXPECT_TRUE(ring.push(5));
    for (const int expected : {1, 2, 3, 5}) {
      EXPECT_EQ(ring.pop(), expected);
    }
    EXPECT_EQ(ring.size(), 0U);
  }
}

// Items of several words: one that is seen half written would differ in itself.
TEST(SpscRing, CarriesWholeItemsInOrderBetweenThreads) {
  using Item = std::array<std::uint32_t, 20>;
  constexpr std::uint32_t kItems = 50'000;
  SpscRing<Item, 8> ring;
  std::thread writer([&ring] {
    for (std::uint32_t number = 0; number < kItems;) {
      Item item{};
      item.fill(number);
      if (ring.push(item)) {
        ++number;
      } else {
        std::this_thread::yield();
      }
    }
  });
  std::uint32_t torn = 0;
  std::uint32_t displaced = 0;
  for (std::uint32_t number = 0; number < kItems;) {
    const std::optional<Item> item = ring.pop();
    if (!item) {
      std::this_thread::yield();
      continue;
    }
    torn += item->front() == item->back() ? 0U : 1U;
    displaced += item->front() == number ? 0U : 1U;
    ++number;
  }
  writer.join();
  EXPECT_EQ(torn, 0U);
  EXPECT_EQ(displaced, 0U);
}

}  // namespace
}  // namespace stof::test
