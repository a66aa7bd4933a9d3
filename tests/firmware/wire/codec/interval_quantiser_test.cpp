#include "firmware/wire/codec/interval_quantiser.h"

#include <algorithm>
#include <cstdlib>
#include <vector>

#include <gtest/gtest.h>

#include "dsp/base/target.h"
#include "firmware/wire/bytes.h"
#include "firmware/wire/codec/rvl_decode.h"
#include "tests/firmware/wire/frame/coder_in_memory.h"
#include "tests/firmware/wire/frame/corridor_frame.h"
#include "tests/firmware/wire/wire_support.h"

namespace stof::wire {
namespace {

using test::Random;
using Values = std::vector<std::uint16_t>;

// Whether [d - w / 2, d + w / 2] lies in the interval of the others.
bool holds(int depth, int width, int rounded_depth, int rounded_width) {
  return 2 * rounded_depth - rounded_width <= 2 * depth - width &&
         2 * depth + width <= 2 * rounded_depth + rounded_width;
}

struct Map {
  Map(int across, int down)
      : depth(static_cast<std::size_t>(across * down)),
        width(depth.size()),
        columns(across),
        rows(down) {}

  dsp::DepthMap view() {
    return {{depth.data(), columns, rows}, {width.data(), columns, rows}, {}, {}};
  }

  Values depth, width;
  int columns, rows;
};

TEST(FitTest, WhatLayInAnIntervalLiesInTheRoundedOne) {
  Random random(3);
  for (unsigned scale = 0; scale <= kMostQuantiserScale; ++scale) {
    const int most = scale == 0 ? 65'535 : static_cast<int>(kMostQuantisedWidth);
    Values depth(20'000);
    Values width(depth.size());
    random.fill(std::span(depth).first(10'000), 0, 65'535);
    random.fill(std::span(depth).subspan(10'000, 5'000), 0, 100);
    random.fill(std::span(depth).subspan(15'000), 65'400, 65'535);
    random.fill(std::span(width).first(8'000), 0, most);
    random.fill(std::span(width).subspan(8'000, 6'000), 0, 100);
    random.fill(std::span(width).subspan(14'000), most - 100, most);
    Values units(depth.size());
    quantise_depth(depth, scale, units);
    Values grown(depth.size());
    grow_width(depth, width, scale, grown);
    Values widths = grown;
    quantise_width(widths, scale);
    for (std::size_t i = 0; i < depth.size(); ++i) {
      const int rounded = units[i] << scale;
      ASSERT_EQ(rounded == 0, depth[i] == 0);
      ASSERT_LE(rounded, 65'535);
      const bool inner = depth[i] >= 1 << scale && depth[i] <= 65'535 - (1 << scale);
      ASSERT_LE(2 * std::abs(rounded - depth[i]), inner ? 1 << scale : 2 << scale);
      ASSERT_LE(widths[i] << scale, 65'535);
      ASSERT_LT((widths[i] << scale) - grown[i], 1 << scale);
      ASSERT_EQ(grown[i], width[i] + 2 * std::abs(rounded - depth[i]));
      ASSERT_TRUE(holds(depth[i], width[i], rounded, widths[i] << scale))
          << depth[i] << " " << width[i] << " scale " << scale;
    }
  }
}

TEST(FitTest, TheScaleSuitsAllWidthsButOneOf256) {
  Map map(64, 12);
  std::ranges::fill(map.depth, std::uint16_t{8000});
  const auto scale_of_all = [&map](std::uint16_t width) {
    std::ranges::fill(map.width, width);
    return int{quantiser_scale(map.view(), 0)};
  };
  EXPECT_EQ(scale_of_all(15), 0);
  EXPECT_EQ(scale_of_all(16), 1);
  EXPECT_EQ(scale_of_all(127), 3);
  EXPECT_EQ(scale_of_all(128), 4);
  EXPECT_EQ(scale_of_all(256), 5);
  EXPECT_EQ(scale_of_all(60'000), 5);
  EXPECT_EQ(scale_of_all(kMostQuantisedWidth), 5);
  EXPECT_EQ(scale_of_all(kMostQuantisedWidth + 1), 0);
  scale_of_all(256);
  map.width[0] = 0;
  map.width[511] = 40;
  EXPECT_EQ(quantiser_scale(map.view(), 0), 5);  // two of 512
  map.width[8] = 40;
  EXPECT_EQ(quantiser_scale(map.view(), 0), 2);  // one of them may be narrower yet
  map.depth[8] = 0;
  map.width[8] = 0;
  EXPECT_EQ(quantiser_scale(map.view(), 0), 2);  // two of 511
  EXPECT_EQ(quantiser_scale(map.view(), 8), 5);  // the other band, of four rows
  map.width[512] = 40;
  EXPECT_EQ(quantiser_scale(map.view(), 8), 5);
  map.width[767] = 65'535;  // without room to grow, with depth or without
  EXPECT_EQ(quantiser_scale(map.view(), 8), 0);
  map.depth[767] = 0;
  EXPECT_EQ(quantiser_scale(map.view(), 8), 0);
  std::ranges::fill(map.depth, std::uint16_t{0});
  EXPECT_EQ(quantiser_scale(map.view(), 0), 0);
}

// One stream of what a coder sent, and the scale of each pixel.
struct Sent {
  Values values;
  Values scales;
  std::size_t payloads = 0;  // bytes
  std::size_t tiles = 0;
};

Sent sent(std::span<const std::span<const std::byte>> datagrams, Stream stream) {
  Sent sent;
  for (const std::span<const std::byte> datagram : datagrams) {
    const PacketView packet = parse_packet(datagram).value();
    EXPECT_TRUE(packet.header.type == PacketType::kTile || packet.header.flags == 0);
    if (packet.header.type != PacketType::kTile || packet.header.stream != stream) {
      continue;
    }
    EXPECT_TRUE(consistent_tile(packet));
    EXPECT_EQ(packet.header.first_row * std::size_t{packet.header.image_width} +
                  packet.header.first_column,
              sent.values.size());
    const unsigned scale = scale_of(packet.header);
    Values values(packet.header.pixel_count);
    if (packet.header.codec == Codec::kRvl16) {
      EXPECT_EQ(rvl_decode<std::uint16_t>(packet.payload, values), Status::kOk);
    } else {
      get_pixels(packet.payload, std::span(values));
    }
    for (const std::uint16_t value : values) {
      EXPECT_LE(value << scale, 65'535);
      sent.values.push_back(static_cast<std::uint16_t>(value << scale));
      sent.scales.push_back(static_cast<std::uint16_t>(scale));
    }
    sent.payloads += packet.payload.size();
    ++sent.tiles;
  }
  return sent;
}

StreamChoice choice_of(Coding depth, Coding width) {
  StreamChoice choice{.parity = true};
  choice.of(Stream::kDepth) = depth;
  choice.of(Stream::kWidth) = width;
  return choice;
}

void expect_scales(const dsp::DepthMap& map, const Sent& sent) {
  const auto columns = static_cast<std::size_t>(map.depth.width());
  for (int y = 0; y < map.depth.height(); ++y) {
    const std::uint16_t scale = quantiser_scale(map, y / kQuantiserRows * kQuantiserRows);
    const auto row = std::span(sent.scales).subspan(static_cast<std::size_t>(y) * columns, columns);
    ASSERT_TRUE(std::ranges::all_of(row, [scale](auto one) { return one == scale; })) << y;
  }
}

// The map through a coder with every pair of codings of which one is fit.
void expect_honest(const dsp::DepthMap& map, bool scaled) {
  const FrameSizes sizes{.width = map.depth.width(), .height = map.depth.height()};
  test::CoderInMemory coder(test::kOrigin, sizes, {.fx = 65'536, .fy = 65'536});
  const auto pixels = static_cast<std::size_t>(sizes.width * sizes.height);
  const std::span<const std::uint16_t> depth(map.depth.data(), pixels);
  const std::span<const std::uint16_t> width(map.width.data(), pixels);
  for (const Coding first : {Coding::kOff, Coding::kRaw, Coding::kRvl, Coding::kQuantised}) {
    for (const Coding second : {Coding::kOff, Coding::kRaw, Coding::kRvl, Coding::kQuantised}) {
      if (first != Coding::kQuantised && second != Coding::kQuantised) {
        continue;
      }
      const auto datagrams = coder->code({}, {}, {.map = map}, choice_of(first, second)).value();
      const Sent depths = sent(datagrams, Stream::kDepth);
      const Sent widths = sent(datagrams, Stream::kWidth);
      ASSERT_EQ(depths.values.size(), first == Coding::kOff ? 0 : pixels);
      ASSERT_EQ(widths.values.size(), second == Coding::kOff ? 0 : pixels);
      const std::span<const std::uint16_t> d = first == Coding::kOff ? depth : depths.values;
      for (std::size_t i = 0; i < widths.values.size(); ++i) {
        ASSERT_TRUE(holds(depth[i], width[i], d[i], widths.values[i])) << i;
        ASSERT_TRUE(second == Coding::kQuantised ||
                    widths.values[i] == width[i] + 2 * std::abs(d[i] - depth[i]));
      }
      ASSERT_TRUE(first == Coding::kQuantised || std::ranges::equal(d, depth));
      if (scaled && first == Coding::kQuantised) {
        expect_scales(map, depths);
      }
      if (scaled && second == Coding::kQuantised) {
        expect_scales(map, widths);
      }
    }
  }
}

TEST(FitTest, TheCorridorStaysHonest) {
  test::CorridorFrame frame;
  expect_honest(frame.images().map, true);
}

TEST(FitTest, RandomMapsStayHonest) {
  Random random(5);
  for (const auto& [columns, rows] : {std::pair{37, 29}, {1, 1}, {640, 17}, {64, 8}}) {
    Map map(columns, rows);
    random.fill(std::span(map.depth), 0, 65'535);
    const auto band = static_cast<std::size_t>(columns * kQuantiserRows);
    for (std::size_t i = 0; i < map.width.size(); i += band) {
      const auto part = std::span(map.width).subspan(i, std::min(band, map.width.size() - i));
      const int least = 1 << random.between(2, 12);
      random.fill(part, least, random.between(0, 3) == 0 ? 65'535 : 2 * least);
    }
    expect_honest(map.view(), false);
  }
}

// What is compiled for all processors, and for those with longer vectors.
TEST(FitTest, IsTheSameOnAllProcessors) {
  if (dsp::widest_vectors() < dsp::Vectors::kAvx2) {
    GTEST_SKIP() << "this processor runs one kind of code only";
  }
  Random random(7);
  for (int columns = 1; columns < 100; ++columns) {
    Map map(columns, 9);
    random.fill(std::span(map.depth), 0, columns % 3 == 0 ? 3 : 65'535);
    random.fill(std::span(map.width), random.between(0, 300), columns % 7 == 0 ? 65'535 : 65'000);
    for (unsigned scale = 0; scale <= kMostQuantiserScale; ++scale) {
      const auto rounded = [&](dsp::Vectors vectors) {
        const dsp::UseVectors use(vectors);
        const dsp::DepthMap view = map.view();
        Values depth(static_cast<std::size_t>(columns));
        Values width(depth.size());
        quantise_depth(view.depth.row(8), scale, depth);
        grow_width(view.depth.row(8), view.width.row(8), scale, width);
        depth.insert(depth.end(), width.begin(), width.end());
        depth.push_back(quantiser_scale(view, 0));
        depth.push_back(quantiser_scale(view, kQuantiserRows));
        return depth;
      };
      const Values narrow = rounded(dsp::Vectors::kNeon);
      ASSERT_EQ(rounded(dsp::Vectors::kAvx2), narrow) << columns << " columns, scale " << scale;
    }
  }
}

// Noise that nothing makes shorter, with another scale in every band: cut at each of them it would
// take more packets than raw.
TEST(FitTest, NoiseTakesNoMorePacketsThanRaw) {
  Random random(6);
  Map map(640, 480);
  random.fill(std::span(map.depth), 1, 65'535);
  for (std::size_t i = 0; i < map.width.size(); ++i) {
    const bool odd = i / (640UL * kQuantiserRows) % 2 != 0;
    map.width[i] = static_cast<std::uint16_t>(random.between(odd ? 16 : 32, odd ? 31 : 20'000));
  }
  expect_honest(map.view(), false);
  test::CoderInMemory coder(test::kOrigin, {.width = 640, .height = 480}, {.fx = 1, .fy = 1});
  const auto datagrams =
      coder->code({}, {}, {.map = map.view()}, choice_of(Coding::kQuantised, Coding::kQuantised));
  const Sent depths = sent(datagrams.value(), Stream::kDepth);
  EXPECT_LE(depths.tiles, raw_tiles(640, 480, 2));
  EXPECT_EQ(std::ranges::max(depths.scales), 0);
}

}  // namespace
}  // namespace stof::wire
