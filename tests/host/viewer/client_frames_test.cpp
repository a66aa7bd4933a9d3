#include "host/viewer/client_frames.h"

#include <string_view>

#include <gtest/gtest.h>

namespace stof::viewer {
namespace {

using Octets = std::vector<std::uint8_t>;

// A frame of that many bytes behind its mask.
Octets client_frame(std::size_t size, bool masked = true) {
  const std::uint8_t mask = masked ? 0x80 : 0;
  Octets bytes{0x81};
  const auto number = [&](std::size_t count) {
    for (std::size_t i = count; i > 0; --i) {
      bytes.push_back(static_cast<std::uint8_t>(size >> (8 * (i - 1))));
    }
  };
  if (size < 126) {
    bytes.push_back(static_cast<std::uint8_t>(mask | size));
  } else if (size < 65536) {
    bytes.push_back(static_cast<std::uint8_t>(mask | 126U));
    number(2);
  } else {
    bytes.push_back(static_cast<std::uint8_t>(mask | 127U));
    number(8);
  }
  for (std::size_t i = 0; i < (masked ? 4U : 0U) + size; ++i) {
    bytes.push_back(static_cast<std::uint8_t>(i));  // 0x01 and so on look like heads
  }
  return bytes;
}

Octets joined(const Octets& a, const Octets& b) {
  Octets all = a;
  all.insert(all.end(), b.begin(), b.end());
  return all;
}

TEST(ClientFramesTest, PassesMaskedFramesHoweverTheyArePartedAndOfAnySize) {
  for (const std::size_t size : {0U, 1U, 125U, 126U, 127U, 300U, 65535U, 65536U}) {
    const Octets two = joined(client_frame(size), client_frame(3));
    for (const std::size_t part : {1U, 2U, 3U, 7U, 100'000U}) {
      ClientFrames frames;
      Octets passed;
      for (std::size_t at = 0; at < two.size(); at += part) {
        ASSERT_TRUE(
            frames.take(std::span(two).subspan(at, std::min(part, two.size() - at)), passed));
      }
      EXPECT_EQ(passed, two) << size << " in parts of " << part;
    }
  }
}

TEST(ClientFramesTest, PassesNothingOfAFrameThatIsNotMaskedNorWhatFollows) {
  for (const std::size_t size : {0U, 5U, 126U, 65536U}) {
    for (const std::size_t part : {1U, 2U, 100'000U}) {
      const Octets good = client_frame(4);
      const Octets all = joined(joined(good, client_frame(size, false)), good);
      ClientFrames frames;
      Octets passed;
      bool taken = true;
      for (std::size_t at = 0; at < all.size(); at += part) {
        taken = frames.take(std::span(all).subspan(at, std::min(part, all.size() - at)), passed);
      }
      EXPECT_FALSE(taken);
      EXPECT_EQ(passed, good) << size << " in parts of " << part;
    }
  }
}

TEST(ClientFramesTest, AnEndlessFrameIsPassedAsItComes) {
  ClientFrames frames;
  Octets passed;
  const Octets head{0x82, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 1, 2, 3, 4};
  EXPECT_TRUE(frames.take(head, passed));
  EXPECT_TRUE(frames.take(Octets(1000, 0), passed));
  EXPECT_EQ(passed.size(), head.size() + 1000);
}

}  // namespace
}  // namespace stof::viewer
