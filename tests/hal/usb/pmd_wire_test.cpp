#include "hal/linux/usb/pmd_wire.h"

#include <array>
#include <cstring>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "tests/hal/usb/pmd_wire_peer.h"

namespace stof::test {
namespace {

using hal::linux::compose_pmd_config;
using hal::linux::compose_pmd_header;
using hal::linux::compose_pmd_info;
using hal::linux::parse_pmd_config;
using hal::linux::parse_pmd_frame;
using hal::linux::parse_pmd_info;
using hal::linux::PmdConfig;
using hal::linux::PmdHeader;
using hal::linux::PmdInfo;

constexpr PmdInfo kInfo{.width = 3,
                        .height = 2,
                        .bits = 12,
                        .least_khz = 1000,
                        .most_khz = 80'000,
                        .least_integration_us = 10,
                        .most_integration_us = 4000,
                        .serial = 0xDEADBEEF};

PmdHeader some_header() {
  return {.sequence = 0x01020304,
          .flags = PmdHeader::kTooWarm,
          .modulation_khz = 20'000,
          .edge = 0x1122334455667788,
          .samples = {{{0, 100}, {100, 100}, {250, 50}, {300, 1}}},
          .temperature = -512};
}

std::vector<std::byte> message(const PmdHeader& header) {
  const auto head = compose_pmd_header(header, kInfo);
  std::vector<std::byte> bytes(head.begin(), head.end());
  bytes.resize(header.bytes + pmd_picture_bytes(kInfo));
  return bytes;
}

void set(std::span<std::byte> bytes, std::size_t at, std::uint32_t value, std::size_t size) {
  std::memcpy(bytes.data() + at, &value, size);
}

TEST(PmdWire, InfoOfTheDocumentIsUnderstood) {
  const auto bytes = compose_pmd_info(kInfo);
  constexpr std::array<std::uint8_t, 12> kBegin{0x53, 0x50, 0x4D, 0x44, 1, 0, 3, 0, 2, 0, 12, 0};
  EXPECT_EQ(std::memcmp(bytes.data(), kBegin.data(), kBegin.size()), 0);
  EXPECT_EQ(bytes[28], std::byte{0xEF});
  EXPECT_EQ(parse_pmd_info(bytes), kInfo);
}

TEST(PmdWire, InfoOutOfRangeIsRefused) {
  struct Case {
    std::size_t at;
    std::size_t size;
    std::uint32_t value;
  };
  for (const Case& bad : {Case{0, 4, 0}, Case{4, 2, 2}, Case{6, 2, 0}, Case{6, 2, 4097},
                          Case{8, 2, 0}, Case{10, 2, 9}, Case{10, 2, 16}, Case{12, 4, 0},
                          Case{12, 4, 80'001}, Case{20, 4, 0}, Case{24, 4, 9}}) {
    auto bytes = compose_pmd_info(kInfo);
    set(bytes, bad.at, bad.value, bad.size);
    EXPECT_FALSE(parse_pmd_info(bytes)) << "at " << bad.at;
  }
  const auto bytes = compose_pmd_info(kInfo);
  EXPECT_FALSE(parse_pmd_info(std::span(bytes).first(31)));
  EXPECT_FALSE(parse_pmd_info({}));
}

TEST(PmdWire, ConfigComesBack) {
  const PmdConfig config{.modulation_khz = 20'000, .integration_us = 1000, .delay_us = 7};
  auto bytes = compose_pmd_config(config);
  EXPECT_EQ(parse_pmd_config(bytes), config);
  bytes[15] = std::byte{1};
  EXPECT_FALSE(parse_pmd_config(bytes));
  EXPECT_FALSE(parse_pmd_config(std::span(bytes).first(15)));
}

TEST(PmdWire, FrameComesBack) {
  EXPECT_EQ(parse_pmd_frame(message(some_header()), kInfo), some_header());
  PmdHeader longer = some_header();
  longer.bytes = 512;
  EXPECT_EQ(parse_pmd_frame(message(longer), kInfo), longer);
}

TEST(PmdWire, FrameThatIsNotThatOfTheCameraIsRefused) {
  struct Case {
    std::size_t at;
    std::size_t size;
    std::uint32_t value;
  };
  for (const Case& bad :
       {Case{0, 4, 0}, Case{4, 2, 94}, Case{4, 2, 97}, Case{4, 2, 98}, Case{4, 2, 0xFFFF},
        Case{6, 2, 2}, Case{12, 2, 4}, Case{14, 2, 1}, Case{16, 2, 11}, Case{32, 4, 0xFFFFFFFF},
        Case{36, 4, 0}, Case{36, 4, 0xFFFFFFFF}, Case{36, 4, 101}, Case{56, 4, 299}}) {
    std::vector<std::byte> bytes = message(some_header());
    set(bytes, bad.at, bad.value, bad.size);
    EXPECT_FALSE(parse_pmd_frame(bytes, kInfo)) << "at " << bad.at << ": " << bad.value;
  }
}

TEST(PmdWire, FrameOfAnyOtherLengthIsRefused) {
  const std::vector<std::byte> whole = message(some_header());
  std::vector<std::byte> bytes = whole;
  bytes.resize(whole.size() + 8);
  for (std::size_t size = 0; size <= bytes.size(); ++size) {
    EXPECT_EQ(parse_pmd_frame(std::span(bytes).first(size), kInfo).has_value(),
              size == whole.size());
  }
}

TEST(PmdWire, RandomDamageNeverReadsBeyondTheMessage) {
  constexpr unsigned kSeed = 5;
  std::mt19937 random(kSeed);
  for (int i = 0; i < 20'000; ++i) {
    std::vector<std::byte> bytes = message(some_header());
    for (int k = 0; k < 3; ++k) {
      bytes[random() % bytes.size()] = static_cast<std::byte>(random());
    }
    bytes.resize(random() % 2 == 0 ? bytes.size() : random() % (bytes.size() + 1));
    if (const auto header = parse_pmd_frame(bytes, kInfo)) {
      EXPECT_LE(header->bytes + pmd_picture_bytes(kInfo), bytes.size());
    }
  }
}

}  // namespace
}  // namespace stof::test
