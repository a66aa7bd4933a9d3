#include "firmware/serial/line/byte_ring.h"

#include <array>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/random.h"

namespace stof::firmware::test {
namespace {

using stof::test::Random;
using Bytes = std::vector<std::byte>;

Bytes take(ByteRing& ring) {
  Bytes record(ring.next());
  EXPECT_EQ(ring.take(record), record.size());
  return record;
}

TEST(ByteRing, GivesRecordsBackInOrderAndWhole) {
  std::array<std::byte, 64> memory{};
  ByteRing ring(memory);
  Random random(1);
  std::vector<Bytes> waiting;
  std::size_t first = 0;
  for (int i = 0; i < 10'000; ++i) {  // wraps round many times
    Bytes record(static_cast<std::size_t>(random.between(1, 20)));
    random.fill(std::span(record), 0, 255);
    if (ByteRing::cost(record.size()) <= ring.room()) {
      ring.put(record);
      ring.publish();
      waiting.push_back(record);
    } else {
      ASSERT_LT(first, waiting.size());
      ASSERT_EQ(take(ring), waiting[first++]);
    }
  }
}

TEST(ByteRing, FillsToTheLastByte) {
  std::array<std::byte, 16> memory{};
  ByteRing ring(memory);
  EXPECT_EQ(ring.room(), 16U);
  ring.put(Bytes(14, std::byte{7}));
  ring.publish();
  EXPECT_EQ(ring.room(), 0U);
  EXPECT_EQ(ring.waiting(), 16U);
  EXPECT_EQ(take(ring), Bytes(14, std::byte{7}));
  EXPECT_EQ(ring.room(), 16U);
  EXPECT_EQ(ring.next(), 0U);
}

TEST(ByteRing, ShowsAGroupOnlyWhenAllOfItIsThere) {
  std::array<std::byte, 64> memory{};
  ByteRing ring(memory);
  ring.put(Bytes(3));
  ring.put(Bytes(4));
  EXPECT_EQ(ring.next(), 0U);
  EXPECT_EQ(ring.room(), 64U - 5 - 6);
  ring.publish();
  EXPECT_EQ(take(ring).size(), 3U);
  EXPECT_EQ(take(ring).size(), 4U);
}

TEST(ByteRing, TakesARecordOutAlsoWhereItIsCut) {
  std::array<std::byte, 64> memory{};
  ByteRing ring(memory);
  ring.put(Bytes(10, std::byte{1}));
  ring.put(Bytes(1, std::byte{2}));
  ring.publish();
  std::array<std::byte, 4> little{};
  EXPECT_EQ(ring.take(little), 4U);
  EXPECT_EQ(take(ring), Bytes(1, std::byte{2}));
}

TEST(ByteRing, LosesNothingBetweenTwoThreads) {
  std::array<std::byte, 256> memory{};
  ByteRing ring(memory);
  constexpr int kRecords = 100'000;
  std::thread writer([&ring] {
    for (int i = 0; i < kRecords;) {
      const std::size_t size = static_cast<std::size_t>(i % 50 + 1);
      if (ByteRing::cost(size) > ring.room()) {
        std::this_thread::yield();
        continue;
      }
      ring.put(Bytes(size, static_cast<std::byte>(i)));
      ring.publish();
      ++i;
    }
  });
  int wrong = 0;
  for (int i = 0; i < kRecords;) {
    if (ring.next() == 0) {
      std::this_thread::yield();
      continue;
    }
    const Bytes expected(static_cast<std::size_t>(i % 50 + 1), static_cast<std::byte>(i));
    wrong += take(ring) == expected ? 0 : 1;
    ++i;
  }
  writer.join();
  EXPECT_EQ(wrong, 0);
}

}  // namespace
}  // namespace stof::firmware::test
