#include "firmware/wire/frame/raw_packets.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "firmware/wire/bytes.h"
#include "firmware/wire/messages/stream_signature.h"
#include "tests/support/guarded_memory.h"
#include "tests/support/random.h"

namespace stof::wire {
namespace {

constexpr Origin kOrigin{.device_id = 7, .session_id = 9};
constexpr FrameStamp kStamp{.number = 3, .freshness = 5, .exposure_middle_ns = 77};

template <typename T>
struct Picture {
  Picture(int w, int h, std::uint64_t seed, int gap = 0)
      : width(w), height(h), stride(w + gap), pixels(static_cast<std::size_t>(stride * h)) {
    test::Random random(seed);
    for (T& pixel : pixels) {
      pixel = static_cast<T>(random.between(0, sizeof(T) == 1 ? 255 : 65'535));
    }
  }
  dsp::ImageView<const T> view() const { return {pixels.data(), width, height, stride}; }

  int width, height, stride;
  std::vector<T> pixels;
};

// A camera's own: the rows of a picture that lie further apart than its width.
struct Exposure {
  Exposure(int w, int h, int pmd_w, int pmd_h)
      : left(w, h, 1, 13),
        right(w, h, 2),
        samples{{{pmd_w, pmd_h, 3, 1}, {pmd_w, pmd_h, 4}, {pmd_w, pmd_h, 5}, {pmd_w, pmd_h, 6}}} {}
  RawImages images() const {
    return {
        .left = left.view(),
        .right = right.view(),
        .samples = {samples[0].view(), samples[1].view(), samples[2].view(), samples[3].view()}};
  }

  Picture<std::uint8_t> left, right;
  std::array<Picture<std::uint16_t>, kRawSamples> samples;
};

// The pixels of a stream as a receiver puts them together; each is written once.
struct Received {
  std::vector<std::byte> bytes;
  std::vector<int> times;  // each pixel came
  int width = 0, height = 0;
};

Received receive(const RawPackets& packets, Stream stream) {
  Received got;
  for (std::size_t i = 0; i < packets.count(); ++i) {
    DatagramBuffer buffer;
    const std::span<const std::byte> datagram = packets.seal(i, buffer);
    EXPECT_LE(datagram.size() + kStreamSignatureBytes, kMaxDatagram);
    const PacketView packet = parse_packet(datagram).value();
    EXPECT_EQ(packet.header.index, i);
    EXPECT_EQ(packet.header.count, packets.count());
    EXPECT_EQ(packet.header.frame.freshness, kStamp.freshness);
    EXPECT_EQ(packet.header.type, i == 0 ? PacketType::kRawInfo : PacketType::kRawTile);
    if (i == 0 || packet.header.stream != stream) {
      continue;
    }
    EXPECT_TRUE(consistent_raw_tile(packet)) << i;
    const std::size_t bytes = raw_pixel_bytes(packet.header.codec);
    got.width = packet.header.image_width;
    got.height = packet.header.image_height;
    const auto all = static_cast<std::size_t>(got.width * got.height);
    got.bytes.resize(all * bytes);
    got.times.resize(all);
    const std::size_t first =
        packet.header.first_row * static_cast<std::size_t>(got.width) + packet.header.first_column;
    std::ranges::copy(packet.payload,
                      got.bytes.begin() + static_cast<std::ptrdiff_t>(first * bytes));
    for (std::size_t k = 0; k < packet.header.pixel_count; ++k) {
      ++got.times.at(first + k);
    }
  }
  EXPECT_TRUE(std::ranges::all_of(got.times, [](int times) { return times == 1; }));
  return got;
}

RawInfo info_of(const RawPackets& packets) {
  DatagramBuffer buffer;
  return decode_raw_info(parse_packet(packets.seal(0, buffer))->payload).value();
}

void expect_eye(const Received& got, const Picture<std::uint8_t>& camera, const RawInfo& info) {
  ASSERT_EQ(got.width, info.width);
  ASSERT_EQ(got.height, info.height);
  for (int y = 0; y < got.height; ++y) {
    for (int x = 0; x < got.width; ++x) {
      ASSERT_EQ(static_cast<std::uint8_t>(got.bytes[static_cast<std::size_t>(y * got.width + x)]),
                camera.view().at(info.column + x * info.step, info.row + y * info.step))
          << x << ", " << y;
    }
  }
}

TEST(RawPackets, WholePicturesAreTheCamerasBitForBit) {
  for (const auto& [w, h] : {std::pair{640, 480}, std::pair{1, 1}, std::pair{1148, 2},
                             std::pair{1149, 3}, std::pair{31, 77}}) {
    const Exposure exposure(w, h, 64, 16);
    const RawPackets packets(kOrigin, kStamp, exposure.images(), {}, {.edge_ns = 11});
    const RawInfo info = info_of(packets);
    EXPECT_EQ(info.edge_ns, 11);
    EXPECT_EQ(info.pictures, kRawPictures);
    EXPECT_EQ(info.camera_width, w);
    EXPECT_EQ(info.width, w);
    EXPECT_EQ(info.height, h);
    expect_eye(receive(packets, Stream::kRawLeft), exposure.left, info);
    expect_eye(receive(packets, Stream::kRawRight), exposure.right, info);
    const Received pmd = receive(packets, Stream::kRawPmd);
    ASSERT_EQ(pmd.height, 4 * 16);
    for (int y = 0; y < pmd.height; ++y) {
      for (int x = 0; x < pmd.width; ++x) {
        const std::size_t at = 2 * static_cast<std::size_t>(y * pmd.width + x);
        ASSERT_EQ(get_u16(std::span(pmd.bytes).subspan(at).first<2>()),
                  exposure.samples.at(static_cast<std::size_t>(y / 16)).view().at(x, y % 16));
      }
    }
  }
}

TEST(RawPackets, APartAndEachStepthPixelAsAskedFor) {
  const Exposure exposure(64, 48, 4, 2);
  struct Case {
    RawRequest asked;
    int width, height;
  };
  for (const Case& one :
       {Case{{.step = 2}, 32, 24}, Case{{.step = 3}, 22, 16}, Case{{.step = 255}, 1, 1},
        Case{{.column = 60, .row = 40, .width = 100, .height = 5}, 4, 5},
        Case{{.step = 2, .column = 3, .row = 1, .width = 5, .height = 4}, 3, 2},
        Case{{.column = 63, .row = 47}, 1, 1}}) {
    const RawPackets packets(kOrigin, kStamp, exposure.images(), one.asked, {});
    const RawInfo info = info_of(packets);
    EXPECT_EQ(info.width, one.width);
    EXPECT_EQ(info.height, one.height);
    expect_eye(receive(packets, Stream::kRawLeft), exposure.left, info);
    expect_eye(receive(packets, Stream::kRawRight), exposure.right, info);
    EXPECT_EQ(info.pmd_width, 4);  // always whole
  }
}

TEST(RawPackets, APartOutsideHasNoPicturesOfThePairAndSaysHowLargeTheyAre) {
  const Exposure exposure(64, 48, 4, 2);
  for (const RawRequest& asked : {RawRequest{.column = 64}, RawRequest{.row = 48},
                                  RawRequest{.column = 65'535, .row = 65'535}}) {
    const RawPackets packets(kOrigin, kStamp, exposure.images(), asked, {});
    const RawInfo info = info_of(packets);
    EXPECT_EQ(info.pictures, kRawPmd);
    EXPECT_EQ(info.width, 0);
    EXPECT_EQ(info.height, 0);
    EXPECT_EQ(info.camera_width, 64);
    EXPECT_EQ(packets.count(), 2U);
  }
}

TEST(RawPackets, WhatIsNotThereIsLeftOut) {
  const Exposure exposure(64, 48, 4, 2);
  RawImages images = exposure.images();
  images.left = {};
  images.samples = {};
  const RawPackets packets(kOrigin, kStamp, images, {}, {});
  EXPECT_EQ(info_of(packets).pictures, kRawRight);
  expect_eye(receive(packets, Stream::kRawRight), exposure.right, info_of(packets));
  EXPECT_TRUE(receive(packets, Stream::kRawLeft).bytes.empty());
  EXPECT_EQ(RawPackets(kOrigin, kStamp, {}, {}, {}).count(), 1U);
  EXPECT_EQ(RawPackets().count(), 0U);
}

// The last pixels lie before a page that nobody may read.
TEST(RawPackets, ReadsNothingBehindThePictures) {
  test::GuardedImage<std::uint8_t> left(33, 17, 40, 1);
  test::GuardedImage<std::uint16_t> sample(5, 3, 8, 1);
  const RawImages images{.left = left.view(),
                         .right = left.view(),
                         .samples = {sample.view(), sample.view(), sample.view(), sample.view()}};
  for (std::uint8_t step = 1; step < 40; ++step) {
    const RawPackets packets(kOrigin, kStamp, images, {.step = step}, {});
    EXPECT_FALSE(receive(packets, Stream::kRawRight).bytes.empty());
    EXPECT_FALSE(receive(packets, Stream::kRawPmd).bytes.empty());
  }
}

TEST(RawPackets, ATileThatContradictsItselfIsNone) {
  const Exposure exposure(64, 48, 4, 2);
  const RawPackets packets(kOrigin, kStamp, exposure.images(), {}, {});
  DatagramBuffer buffer;
  const PacketView good = parse_packet(packets.seal(1, buffer)).value();
  ASSERT_TRUE(consistent_raw_tile(good));
  const auto broken = [&](auto change) {
    PacketView packet = good;
    change(packet);
    return !consistent_raw_tile(packet);
  };
  EXPECT_TRUE(broken([](PacketView& p) { p.header.stream = Stream::kDepth; }));
  EXPECT_TRUE(broken([](PacketView& p) { p.header.stream = Stream::kRawPmd; }));
  EXPECT_TRUE(broken([](PacketView& p) { p.header.codec = Codec::kRaw16; }));
  EXPECT_TRUE(broken([](PacketView& p) { p.header.codec = Codec::kRvl8; }));
  EXPECT_TRUE(broken([](PacketView& p) { p.header.pixel_count = 0; }));
  EXPECT_TRUE(broken([](PacketView& p) { ++p.header.pixel_count; }));
  EXPECT_TRUE(broken([](PacketView& p) { p.header.first_column = 64; }));
  EXPECT_TRUE(broken([](PacketView& p) { p.header.first_row = 47; }));
  EXPECT_TRUE(broken([](PacketView& p) { p.header.image_width = 0; }));
  EXPECT_TRUE(broken([](PacketView& p) { p.payload = p.payload.first(5); }));
}

}  // namespace
}  // namespace stof::wire
