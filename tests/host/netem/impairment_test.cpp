#include "host/netem/impairment.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

namespace stof::netem {
namespace {

using std::chrono::milliseconds;

constexpr Time kStart{};
constexpr std::uint32_t kMany = 100'000;

std::vector<std::byte> datagram(std::uint32_t number) {
  std::vector<std::byte> bytes(8);
  for (std::size_t i = 0; i < 4; ++i) {
    bytes[i] = static_cast<std::byte>(number >> (8 * i));
  }
  return bytes;
}
std::uint32_t number_of(std::span<const std::byte> bytes) {
  std::uint32_t number = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    number |= std::to_integer<std::uint32_t>(bytes[i]) << (8 * i);
  }
  return number;
}

// Numbers in the order of arrival, all sent at once, then time goes on.
std::vector<std::uint32_t> pass(Impairment& link, std::uint32_t count) {
  std::vector<std::uint32_t> out;
  const auto pop_all = [&](Time now) {
    while (const auto bytes = link.pop(now)) {
      out.push_back(number_of(*bytes));
    }
  };
  for (std::uint32_t number = 0; number < count; ++number) {
    link.push(datagram(number), kStart);
    pop_all(kStart);
  }
  pop_all(kStart + std::chrono::hours(1));
  pop_all(kStart + std::chrono::hours(2));
  return out;
}

double share(std::uint64_t part, std::uint64_t all) {
  return static_cast<double>(part) / static_cast<double>(all);
}

TEST(Impairment, AGoodNetworkChangesNothing) {
  Impairment link({});
  EXPECT_FALSE(link.next());
  const std::vector<std::uint32_t> out = pass(link, 1000);
  ASSERT_EQ(out.size(), 1000U);
  EXPECT_TRUE(std::ranges::is_sorted(out));
  EXPECT_FALSE(link.next());
  EXPECT_EQ(link.counts().out, 1000U);
}

TEST(Impairment, LosesTheShareThatWasAskedFor) {
  for (const double loss : {0.0, 0.001, 0.01, 0.3, 0.9, 1.0}) {
    Impairment link({.loss = loss});
    const std::vector<std::uint32_t> out = pass(link, kMany);
    EXPECT_NEAR(share(out.size(), kMany), 1 - loss, 0.005) << loss;
    EXPECT_EQ(link.counts().lost + out.size(), kMany);
    EXPECT_TRUE(std::ranges::is_sorted(out));
  }
}

TEST(Impairment, BurstsHaveTheirMeanLengthAndTheSameShare) {
  Impairment link({.loss = 0.05, .burst = 10});
  const std::vector<std::uint32_t> out = pass(link, 4 * kMany);
  EXPECT_NEAR(share(out.size(), 4 * kMany), 0.95, 0.01);
  std::uint64_t bursts = 0;
  for (std::size_t i = 1; i < out.size(); ++i) {
    bursts += out[i] != out[i - 1] + 1 ? 1U : 0U;
  }
  EXPECT_NEAR(share(link.counts().lost, bursts), 10, 1);
}

TEST(Impairment, DuplicatesTheShareThatWasAskedFor) {
  Impairment link({.duplicate = 0.2});
  const std::vector<std::uint32_t> out = pass(link, kMany);
  EXPECT_NEAR(share(out.size(), kMany), 1.2, 0.01);
  EXPECT_EQ(link.counts().duplicated + kMany, out.size());
}

TEST(Impairment, ADatagramIsOvertakenByAsManyAsAskedForAndNoMore) {
  Impairment link({.reorder = 64});
  const std::vector<std::uint32_t> out = pass(link, kMany);
  ASSERT_EQ(out.size(), kMany);
  std::vector<std::uint32_t> place(kMany);
  for (std::uint32_t i = 0; i < kMany; ++i) {
    place[out[i]] = i;
  }
  std::uint32_t most = 0;
  std::uint32_t newest = 0;
  for (std::uint32_t i = 0; i < kMany; ++i) {
    newest = std::max(newest, out[i]);
    most = std::max(most, newest - out[i]);
  }
  EXPECT_LE(most, 64U);
  EXPECT_GT(most, 55U);
}

TEST(Impairment, WhatIsHeldBackForOthersGoesOnWithoutThem) {
  Impairment link({.reorder = 1000});
  for (std::uint32_t number = 0; number < 10; ++number) {
    link.push(datagram(number), kStart);
  }
  ASSERT_TRUE(link.next());
  EXPECT_LE(*link.next(), kStart + milliseconds(20));
  std::size_t out = 0;
  while (link.pop(kStart + milliseconds(20))) {
    ++out;
  }
  EXPECT_EQ(out, 10U);
}

TEST(Impairment, DelayAndJitterAreKeptTo) {
  Impairment link({.delay = milliseconds(30), .jitter = milliseconds(10)});
  for (std::uint32_t number = 0; number < 1000; ++number) {
    link.push(datagram(number), kStart);
  }
  EXPECT_FALSE(link.pop(kStart + milliseconds(30) - Duration(1)));
  std::vector<std::uint32_t> out;
  for (int half = 60; half <= 80; ++half) {
    while (const auto bytes = link.pop(kStart + milliseconds(half) / 2)) {
      out.push_back(number_of(*bytes));
    }
    if (half == 70) {
      EXPECT_NEAR(share(out.size(), 1000), 0.5, 0.1);
    }
  }
  EXPECT_EQ(out.size(), 1000U);
  EXPECT_FALSE(std::ranges::is_sorted(out));
}

TEST(Impairment, DamagesOneToThreeBits) {
  Impairment link({.corrupt = 0.1});
  std::uint64_t damaged = 0;
  for (std::uint32_t number = 0; number < kMany; ++number) {
    const std::vector<std::byte> sent = datagram(number);
    link.push(sent, kStart);
    const auto bytes = link.pop(kStart);
    ASSERT_TRUE(bytes);
    ASSERT_EQ(bytes->size(), sent.size());
    int bits = 0;
    for (std::size_t i = 0; i < sent.size(); ++i) {
      bits += std::popcount(std::to_integer<unsigned>(sent[i] ^ (*bytes)[i]));
    }
    ASSERT_LE(bits, 3);
    damaged += bits != 0 ? 1U : 0U;
  }
  EXPECT_NEAR(share(damaged, kMany), 0.1, 0.01);
  EXPECT_NEAR(share(link.counts().corrupted, kMany), 0.1, 0.01);
  link.push({}, kStart);  // nothing to damage
  EXPECT_TRUE(link.pop(kStart)->empty());
}

TEST(Impairment, TheSameSeedDoesTheSame) {
  const ImpairmentOptions options{.loss = 0.1, .duplicate = 0.1, .reorder = 8, .seed = 5};
  Impairment first(options);
  Impairment second(options);
  ImpairmentOptions other = options;
  other.seed = 6;
  Impairment third(other);
  const std::vector<std::uint32_t> out = pass(first, 1000);
  EXPECT_EQ(out, pass(second, 1000));
  EXPECT_NE(out, pass(third, 1000));
}

TEST(Impairment, KeepsBoundedMemory) {
  Impairment link({.delay = std::chrono::hours(1)});
  for (std::uint32_t number = 0; number < 70'000; ++number) {
    link.push(datagram(number), kStart);
  }
  EXPECT_EQ(link.counts().overflowed, 70'000U - 65'536U);
}

}  // namespace
}  // namespace stof::netem
