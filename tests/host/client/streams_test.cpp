#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "host/client/frame/point_cloud.h"
#include "host/client/reassembler.h"
#include "tests/host/client/test_pattern.h"

namespace stof::client {
namespace {

using test::Datagram;
using test::frame_spec;
using test::judge;
using test::Judgement;
using test::pattern_datagrams;
using test::PatternSizes;
using test::push_all;
using wire::Coding;
using wire::Stream;

constexpr Time kStart{};
constexpr std::size_t kMapPixels = 64 * 48;
constexpr std::size_t kPmdPixels = 4 * 16 * 12;
// Depth, width, source, cause, disparity, left, right; then the four samples.
constexpr std::size_t kJudged = 7 * kMapPixels + kPmdPixels;

std::optional<wire::PacketView> tile_of(const Datagram& packet) {
  const auto parsed = wire::parse_packet(packet);
  return parsed && parsed->header.type == wire::PacketType::kTile ? std::optional(*parsed)
                                                                  : std::nullopt;
}

TEST(Streams, AllEightArrivePixelForPixel) {
  for (const Coding coding : {Coding::kRaw, Coding::kRvl}) {
    for (const bool parity : {false, true}) {
      Reassembler reassembler;
      const PatternSizes sizes;
      const auto packets = pattern_datagrams(frame_spec(7), sizes,
                                             test::every_stream(coding, parity, sizes.cloud_step));
      const std::optional<Frame> frame = push_all(reassembler, packets);
      ASSERT_TRUE(frame);
      EXPECT_TRUE(frame->complete());
      const Judgement judgement = judge(*frame);
      EXPECT_EQ(judgement.arrived, kJudged);
      EXPECT_EQ(judgement.wrong, 0U);
      EXPECT_EQ(frame->missing, decltype(frame->missing){});
      EXPECT_EQ(frame->recovered_packets, 0U);
      EXPECT_EQ(frame->pmd[3].width(), 16);
      EXPECT_EQ(frame->pmd[3].height(), 12);
      ASSERT_TRUE(frame->info);
      EXPECT_EQ(frame->info->cloud_step, sizes.cloud_step);
      const Statistics& statistics = reassembler.statistics();
      EXPECT_EQ(statistics.packets_ok, packets.size());
      EXPECT_EQ(statistics.packets(), packets.size());
    }
  }
}

TEST(Streams, RoundedDepthAndWidthArriveAsTheyWereSent) {
  Reassembler reassembler;
  const std::optional<Frame> frame = push_all(
      reassembler,
      pattern_datagrams(frame_spec(7), {}, test::every_stream(Coding::kQuantised, false, 8)));
  ASSERT_TRUE(frame);
  EXPECT_TRUE(frame->complete());
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 64; ++x) {
      const auto place = static_cast<std::size_t>(64 * y + x);
      const std::uint16_t depth = test::pattern16(7, place, 4);
      ASSERT_EQ(frame->depth.at(x, y), test::quantised_depth_of(depth));
      ASSERT_EQ(frame->interval_width.at(x, y),
                test::quantised_width_of(depth, test::pattern16(7, place, 1)));
    }
  }
  EXPECT_EQ(judge(*frame).wrong, 2 * kMapPixels - 2 * 48);  // all others: one of 32 is a multiple
}

// A tile of one pixel.
std::uint64_t bad_fields(Stream stream, std::uint8_t scale, std::uint16_t value) {
  const bool byte = stream == Stream::kSource;
  wire::DatagramBuffer buffer{};
  wire::put_u16(wire::payload_space(buffer).first<2>(), value);
  const std::span<const std::byte> packet =
      wire::seal_packet({.flags = scale,
                         .origin = test::kOrigin,
                         .frame = {.number = 1, .freshness = 1},
                         .stream = stream,
                         .codec = byte ? wire::Codec::kRaw8 : wire::Codec::kRaw16,
                         .image_width = 1,
                         .image_height = 1,
                         .pixel_count = 1},
                        byte ? 1 : 2, buffer);
  Reassembler reassembler;
  reassembler.push(packet, kStart);
  return reassembler.statistics().bad_field;
}

TEST(Streams, AScaleThatDoesNotFitIsRefused) {
  for (const Stream stream : {Stream::kDepth, Stream::kWidth}) {
    EXPECT_EQ(bad_fields(stream, 5, 2047), 0U);
    EXPECT_EQ(bad_fields(stream, 5, 2048), 1U);
    EXPECT_EQ(bad_fields(stream, 15, 1), 0U);
    EXPECT_EQ(bad_fields(stream, 15, 2), 1U);
  }
  EXPECT_EQ(bad_fields(Stream::kSource, 0, 1), 0U);
  EXPECT_EQ(bad_fields(Stream::kSource, 1, 1), 1U);
  EXPECT_EQ(bad_fields(Stream::kDisparity, 0, 1), 0U);
  EXPECT_EQ(bad_fields(Stream::kDisparity, 1, 1), 1U);
}

TEST(Streams, TheCloudIsThatOfItsFrame) {
  Reassembler reassembler;
  const PatternSizes sizes{.width = 61, .height = 45};  // the last blocks are cut
  const std::optional<Frame> frame =
      push_all(reassembler,
               pattern_datagrams(frame_spec(7), sizes, test::every_stream(Coding::kRvl, false, 8)));
  ASSERT_TRUE(frame);
  ASSERT_EQ(frame->cloud.width(), 8);
  ASSERT_EQ(frame->cloud.height(), 6);
  const test::PatternFrame told(7, sizes);
  std::vector<Point> points;
  cloud_points(*frame, points);
  ASSERT_EQ(points.size(), 48U);
  for (int y = 0; y < 6; ++y) {
    for (int x = 0; x < 8; ++x) {
      const CloudPoint point = told.point(x, y);
      EXPECT_EQ(frame->cloud.at(x, y), point);
      const Point& metres = points[static_cast<std::size_t>(8 * y + x)];
      EXPECT_FLOAT_EQ(metres.x, static_cast<float>(point.x_mm) / 1000);
      EXPECT_FLOAT_EQ(metres.y, static_cast<float>(point.y_mm) / 1000);
      EXPECT_FLOAT_EQ(metres.z, static_cast<float>(point.depth) / 4000);
      EXPECT_FLOAT_EQ(metres.z_width, static_cast<float>(point.interval_width) / 4000);
    }
  }
}

TEST(Streams, WhatIsNotSentIsEmptyAndShowsNothingOfEarlierFrames) {
  Reassembler reassembler;
  const PatternSizes sizes;
  for (std::uint32_t number = 1; number <= 5; ++number) {  // every slot has held every stream
    ASSERT_TRUE(push_all(
        reassembler,
        pattern_datagrams(frame_spec(number), sizes, test::every_stream(Coding::kRvl, false, 8))));
  }
  wire::StreamChoice choice;
  choice.of(Stream::kWidth) = Coding::kRvl;
  choice.of(Stream::kGreyRight) = Coding::kRaw;
  const std::optional<Frame> frame =
      push_all(reassembler, pattern_datagrams(frame_spec(6), sizes, choice));
  ASSERT_TRUE(frame);
  EXPECT_TRUE(frame->complete());
  EXPECT_TRUE(frame->depth.empty() && frame->source.empty() && frame->cause.empty());
  EXPECT_TRUE(frame->disparity.empty() && frame->pmd[0].empty() && frame->left.empty());
  EXPECT_TRUE(frame->cloud.empty());
  const Judgement judgement = judge(*frame);
  EXPECT_EQ(judgement.arrived, 2 * kMapPixels);
  EXPECT_EQ(judgement.wrong + judgement.missing, 0U);
  std::vector<Point> points(3);
  cloud_points(*frame, points);
  EXPECT_TRUE(points.empty());
}

// Whichever packet is lost: its pixels are none, all others are there.
TEST(Streams, EachLostTileCostsItsPixelsOnly) {
  const PatternSizes sizes;
  const wire::StreamChoice choice = test::every_stream(Coding::kRvl, false, 8);
  const std::size_t count = pattern_datagrams(frame_spec(1), sizes, choice).size();
  for (std::size_t lost = 0; lost < count; ++lost) {
    Reassembler reassembler;
    for (std::uint32_t number = 1; number <= 5; ++number) {
      push_all(reassembler, pattern_datagrams(frame_spec(number), sizes, choice));
    }
    std::vector<Datagram> packets = pattern_datagrams(frame_spec(6), sizes, choice);
    const auto tile = tile_of(packets[lost]);
    const wire::Header header = tile ? tile->header : wire::Header{};
    packets.erase(packets.begin() + static_cast<std::ptrdiff_t>(lost));
    push_all(reassembler, packets);
    reassembler.expire(kStart + std::chrono::seconds(1));
    const std::optional<Frame> frame = reassembler.take();
    ASSERT_TRUE(frame) << lost;
    const Judgement judgement = judge(*frame);
    EXPECT_EQ(judgement.wrong, 0U) << lost;
    EXPECT_EQ(frame->missing_packets, 1U);
    if (!tile) {
      EXPECT_FALSE(frame->info);
      EXPECT_EQ(judgement.arrived, kJudged);
    } else if (header.stream != Stream::kCloud) {
      const bool twice = header.stream == Stream::kSource;  // its pixels carry the cause as well
      const bool size_known = header.stream < Stream::kDisparity || header.pixel_count < kMapPixels;
      EXPECT_EQ(judgement.arrived, kJudged - (twice ? 2U : 1U) * header.pixel_count) << lost;
      if (size_known && !(header.stream == Stream::kPmdRaw && judgement.missing == 0)) {
        EXPECT_EQ(judgement.missing, (twice ? 2U : 1U) * header.pixel_count) << lost;
        EXPECT_EQ(frame->missing_pixels(header.stream), header.pixel_count) << lost;
      }
    }
  }
}

// A tile that is undamaged but no code of its pixels is a sender's bug: it leaves no pixel.
TEST(Streams, ATileThatIsNoCodeLeavesNoPixel) {
  const PatternSizes sizes;
  const auto packets =
      pattern_datagrams(frame_spec(9), sizes, test::every_stream(Coding::kRvl, false, 8));
  int tried = 0;
  for (std::size_t i = 0; i < packets.size(); ++i) {
    const auto tile = tile_of(packets[i]);
    if (!tile ||
        (tile->header.codec != wire::Codec::kRvl16 && tile->header.codec != wire::Codec::kRvl8)) {
      continue;
    }
    ++tried;
    Datagram bad = packets[i];  // without the last word of its code
    bad.erase(bad.end() - 8, bad.end() - 4);
    wire::put_u16(std::span(bad).subspan<50, 2>(),
                  static_cast<std::uint16_t>(tile->payload.size() - 4));
    test::reseal(bad);
    Reassembler reassembler;
    reassembler.push(bad, kStart);
    EXPECT_EQ(reassembler.statistics().bad_field, 1U) << i;
    std::vector<Datagram> rest = packets;
    rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(i));
    push_all(reassembler, rest);
    reassembler.expire(kStart + std::chrono::seconds(1));
    const std::optional<Frame> frame = reassembler.take();
    ASSERT_TRUE(frame) << i;
    EXPECT_EQ(frame->missing_packets, 1U);
    EXPECT_EQ(judge(*frame).wrong, 0U) << i;
  }
  EXPECT_GT(tried, 8);
}

TEST(Streams, TilesOfOneStreamAgreeInSize) {
  std::vector<Datagram> packets =
      pattern_datagrams(frame_spec(9), {.width = 640}, test::every_stream(Coding::kRaw, false, 8));
  Reassembler reassembler;
  int refused = 0;
  for (std::size_t i = 0; i + 1 < packets.size(); ++i) {
    const auto tile = tile_of(packets[i]);
    const auto next = tile_of(packets[i + 1]);
    if (tile && next && tile->header.stream == next->header.stream) {
      reassembler.push(packets[i], kStart);
      Datagram other = packets[i + 1];
      wire::put_u16(std::span(other).subspan<42, 2>(),
                    static_cast<std::uint16_t>(next->header.image_height + 4));
      test::reseal(other);
      reassembler.push(other, kStart);
      ++refused;
      i += 1;
    }
  }
  EXPECT_GT(refused, 7);
  EXPECT_EQ(reassembler.statistics().bad_field, static_cast<std::uint64_t>(refused));
}

TEST(Streams, SamplesOfThePmdCameraAreFourImages) {
  const auto packets =
      pattern_datagrams(frame_spec(9), {}, test::every_stream(Coding::kRaw, false, 8));
  for (const Datagram& packet : packets) {
    const auto tile = tile_of(packet);
    if (tile && tile->header.stream == Stream::kPmdRaw) {
      Datagram uneven = packet;
      wire::put_u16(std::span(uneven).subspan<42, 2>(), 4 * 12 + 1);
      test::reseal(uneven);
      Reassembler reassembler;
      reassembler.push(uneven, kStart);
      EXPECT_EQ(reassembler.statistics().bad_field, 1U);
    }
  }
}

// A packet whose CRC is right and whose fields and code are anything.
Datagram nonsense(Datagram packet, test::Random& random) {
  for (int i = random.between(1, 3); i > 0; --i) {
    const std::size_t at = 16 + random.next() % (packet.size() - 20);
    packet[at] = random.between(0, 1) == 0 ? static_cast<std::byte>(random.between(0, 9))
                                           : static_cast<std::byte>(random.next());
  }
  if (random.between(0, 9) == 0) {
    constexpr std::uint8_t kTypes[] = {1, 2, 64, 65, 66, 67, 68, 69, 128};
    packet[5] = std::byte{kTypes[random.next() % std::size(kTypes)]};
  }
  test::reseal(packet);
  return packet;
}

// No crash, and every datagram is counted once.
TEST(Streams, NonsenseAmongGoodPacketsIsCountedAndHarmless) {
  constexpr PatternSizes kSmall{.width = 40, .height = 24, .pmd_width = 8, .pmd_height = 4};
  test::Random random(12);
  Reassembler reassembler({.max_pixels = 20'000});
  std::uint64_t pushed = 0;
  std::uint64_t taken = 0;
  const auto push = [&](const Datagram& packet, std::uint32_t number) {
    reassembler.push(packet, kStart + std::chrono::milliseconds(number));
    ++pushed;
    taken += reassembler.take() ? 1U : 0U;
    static_cast<void>(reassembler.take_event());
  };
  for (std::uint32_t number = 1; number <= 1000; ++number) {
    test::FrameSpec spec = frame_spec(number);
    spec.origin.session_id = number / 50;  // numbers may have run far ahead
    reassembler.expect(spec.origin);
    const Coding coding = number % 2 == 0 ? Coding::kRvl : Coding::kRaw;
    for (const Datagram& packet :
         pattern_datagrams(spec, kSmall, test::every_stream(coding, true, 8))) {
      if (random.between(0, 19) == 0) {
        push(nonsense(packet, random), number);
      }
      if (random.between(0, 29) != 0) {
        push(packet, number);
      }
    }
    reassembler.expire(kStart + std::chrono::milliseconds(number));
  }
  while (reassembler.take()) {
    ++taken;
  }
  const Statistics& statistics = reassembler.statistics();
  EXPECT_EQ(statistics.packets(), pushed);
  EXPECT_EQ(statistics.frames_complete + statistics.frames_incomplete, taken);
  EXPECT_GT(statistics.bad_field, 50U);
  EXPECT_GT(statistics.recovered, 100U);
  EXPECT_GT(taken, 300U);
}

}  // namespace
}  // namespace stof::client
