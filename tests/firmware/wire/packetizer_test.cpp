#include "firmware/wire/packetizer.h"

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "firmware/wire/bytes.h"
#include "tests/firmware/wire/wire_support.h"

namespace stof::wire {
namespace {

using test::Datagram;
using test::KeepingSink;
using test::kOrigin;
using test::RandomMap;

constexpr FrameStamp kStamp{.number = 41,
                            .freshness = 40,
                            .exposure_middle_ns = 5,
                            .health = Health::kDegraded,
                            .clock = ClockState::kEmulated};

struct Size {
  int width;
  int height;
};

std::string name(const Size& size) {
  return std::to_string(size.width) + "x" + std::to_string(size.height);
}

// One, a row, a column; rows of 16 bits (588) and of 8 bits (1,176) just below, at and above a
// datagram; the sizes of cameras.
const std::vector<Size> kSizes{{1, 1},   {1, 7},     {7, 1},    {1, 3000}, {3000, 1}, {3, 5},
                               {64, 16}, {293, 5},   {294, 5},  {295, 5},  {587, 3},  {588, 3},
                               {589, 3}, {640, 480}, {1175, 3}, {1176, 3}, {1177, 3}, {1280, 720}};

// Places every tile by its own packet alone; counts how often each pixel came.
template <typename T>
struct Canvas {
  Canvas(int w, int h)
      : width(static_cast<std::size_t>(w)),
        pixels(width * static_cast<std::size_t>(h)),
        times(pixels.size()) {}

  void place(const PacketView& packet) {
    const std::size_t first = packet.header.first_row * width + packet.header.first_column;
    const std::span<T> target = std::span(pixels).subspan(first, packet.header.pixel_count);
    get_pixels(packet.payload, target);
    for (int& t : std::span(times).subspan(first, packet.header.pixel_count)) {
      ++t;
    }
  }
  bool equals(dsp::ImageView<const T> image) const {
    for (int y = 0; y < image.height(); ++y) {
      const auto row = std::span(pixels).subspan(static_cast<std::size_t>(y) * width, width);
      if (!std::ranges::equal(image.row(y), row)) {
        return false;
      }
    }
    return std::ranges::all_of(times, [](int t) { return t == 1; });
  }

  std::size_t width;
  std::vector<T> pixels;
  std::vector<int> times;
};

TEST(Packetizer, EveryPixelOfEverySizeArrivesOnce) {
  for (const Size& size : kSizes) {
    RandomMap map(size.width, size.height, 7);
    KeepingSink sink;
    Packetizer packetizer(kOrigin, sink);
    const Sent sent = packetizer.publish(kStamp, {}, map.view());
    ASSERT_EQ(sent.status, Status::kOk);
    ASSERT_EQ(sent.packets, sink.sent.size());
    ASSERT_EQ(sent.dropped, 0U);
    Canvas<dsp::QuarterMm> depth(size.width, size.height);
    Canvas<dsp::QuarterMm> width(size.width, size.height);
    Canvas<dsp::Source> source(size.width, size.height);
    for (std::size_t i = 1; i < sink.sent.size(); ++i) {
      const auto packet = parse_packet(sink.sent[i]);
      ASSERT_TRUE(packet && consistent_tile(*packet)) << name(size) << " packet " << i;
      const Stream stream = packet->header.stream;
      if (stream == Stream::kSource) {
        source.place(*packet);
      } else {
        (stream == Stream::kDepth ? depth : width).place(*packet);
      }
    }
    EXPECT_TRUE(depth.equals(map.view().depth)) << name(size);
    EXPECT_TRUE(width.equals(map.view().width)) << name(size);
    EXPECT_TRUE(source.equals(map.view().source)) << name(size);
  }
}

TEST(Packetizer, EveryPacketTellsItsFrameItsPlaceAndTheCount) {
  for (const Size& size : kSizes) {
    RandomMap map(size.width, size.height, 8);
    KeepingSink sink;
    Packetizer packetizer(kOrigin, sink);
    ASSERT_EQ(packetizer.publish(kStamp, {}, map.view()).status, Status::kOk);
    for (std::size_t i = 0; i < sink.sent.size(); ++i) {
      ASSERT_LE(sink.sent[i].size(), kMaxDatagram);
      const auto packet = parse_packet(sink.sent[i]);
      ASSERT_TRUE(packet);
      const Header& header = packet->header;
      ASSERT_EQ(header.index, i);
      ASSERT_EQ(header.count, sink.sent.size());
      ASSERT_EQ(header.image_width, size.width);
      ASSERT_EQ(header.image_height, size.height);
      ASSERT_EQ(header.origin.device_id, kOrigin.device_id);
      ASSERT_EQ(header.origin.session_id, kOrigin.session_id);
      ASSERT_EQ(header.frame.number, 41U);
      ASSERT_EQ(header.frame.freshness, 40U);
      ASSERT_EQ(header.frame.exposure_middle_ns, 5);
      ASSERT_EQ(header.frame.health, Health::kDegraded);
      ASSERT_EQ(header.frame.clock, ClockState::kEmulated);
    }
  }
}

TEST(Packetizer, ALostPacketCostsItsRowsOnlyWhereRowsFit) {
  for (const Size& size : kSizes) {
    RandomMap map(size.width, size.height, 9);
    KeepingSink sink;
    Packetizer packetizer(kOrigin, sink);
    ASSERT_EQ(packetizer.publish(kStamp, {}, map.view()).status, Status::kOk);
    for (std::size_t i = 1; i < sink.sent.size(); ++i) {
      const Header header = parse_packet(sink.sent[i])->header;
      const std::size_t bytes = pixel_bytes(header.stream, header.codec);
      if (bytes * static_cast<std::size_t>(size.width) <= kMaxPayload) {
        ASSERT_EQ(header.first_column, 0) << name(size);
        ASSERT_EQ(header.pixel_count % size.width, 0) << name(size);
      }
    }
  }
}

TEST(Packetizer, CutsAsTheDocumentSays) {
  EXPECT_EQ(tile_pixels(640, 2), 588U);
  EXPECT_EQ(tile_pixels(640, 1), 640U);
  EXPECT_EQ(tile_count(640, 480, 2), 523U);
  EXPECT_EQ(tile_count(640, 480, 1), 480U);
  EXPECT_EQ(tile_pixels(64, 2), 576U);
  EXPECT_EQ(tile_count(0, 5, 2), 0U);
  EXPECT_EQ(tile_count(5, 0, 2), 0U);
}

TEST(Packetizer, FrameInfoComesFirstAndCountsTheTiles) {
  RandomMap map(640, 48, 10);
  KeepingSink sink;
  Packetizer packetizer(kOrigin, sink);
  const FrameInfo info{.latency_ns = 123, .pixels_by_source = {1, 2, 3, 4, 5, 6}};
  ASSERT_EQ(packetizer.publish(kStamp, info, map.view()).status, Status::kOk);
  const auto packet = parse_packet(sink.sent.front());
  ASSERT_TRUE(packet);
  EXPECT_EQ(packet->header.type, PacketType::kFrameInfo);
  EXPECT_EQ(packet->header.stream, Stream::kNone);
  const Result<FrameInfo> got = decode_frame_info(packet->payload);
  ASSERT_TRUE(got);
  EXPECT_EQ(got->latency_ns, 123);
  EXPECT_EQ(got->pixels_by_source, info.pixels_by_source);
  EXPECT_EQ(got->tiles[0], tile_count(640, 48, 2));
  EXPECT_EQ(got->tiles[1], tile_count(640, 48, 2));
  EXPECT_EQ(got->tiles[2], tile_count(640, 48, 1));
}

TEST(Packetizer, CalibrationIsOnePacketOutsideTheFrame) {
  KeepingSink sink;
  Packetizer packetizer(kOrigin, sink);
  const CalibrationPacket calibration{.image_width = 8, .image_height = 4, .fx = 1, .fy = 2};
  ASSERT_EQ(packetizer.publish(kStamp, calibration), Status::kOk);
  ASSERT_EQ(sink.sent.size(), 1U);
  const auto packet = parse_packet(sink.sent.front());
  ASSERT_TRUE(packet);
  EXPECT_EQ(packet->header.type, PacketType::kCalibration);
  EXPECT_EQ(packet->header.index, 0);
  EXPECT_EQ(packet->header.count, 1);
  EXPECT_EQ(packet->header.frame.number, 41U);
  const Result<CalibrationPacket> got = read_calibration_packet(packet->payload);
  ASSERT_TRUE(got);
  EXPECT_EQ(*got, calibration);
}

TEST(Packetizer, AFullLinkCostsTheDatagramsItRefusedAndNoOther) {
  RandomMap map(64, 48, 11);
  KeepingSink whole;
  Packetizer reference(kOrigin, whole);
  const Sent all = reference.publish(kStamp, {}, map.view());
  KeepingSink sink;
  sink.refuse_begin = 2;
  sink.refuse_end = 5;
  Packetizer packetizer(kOrigin, sink);
  const Sent sent = packetizer.publish(kStamp, {}, map.view());
  EXPECT_EQ(sent.status, Status::kWouldBlock);
  EXPECT_EQ(sent.packets, all.packets);
  EXPECT_EQ(sent.dropped, 3U);
  std::vector<Datagram> expected = whole.sent;
  expected.erase(expected.begin() + 2, expected.begin() + 5);
  EXPECT_EQ(sink.sent, expected);
}

TEST(Packetizer, ALostDeviceEndsTheFrame) {
  RandomMap map(64, 48, 12);
  KeepingSink sink;
  sink.refuse_begin = 3;
  sink.refuse_end = 4;
  sink.refusal = Status::kDeviceLost;
  Packetizer packetizer(kOrigin, sink);
  const Sent sent = packetizer.publish(kStamp, {}, map.view());
  EXPECT_EQ(sent.status, Status::kDeviceLost);
  EXPECT_EQ(sink.sent.size(), 3U);
  EXPECT_EQ(sent.dropped, sent.packets - 3);
}

TEST(Packetizer, AnEmptyImageIsItsFrameInfo) {
  KeepingSink sink;
  Packetizer packetizer(kOrigin, sink);
  const Sent sent = packetizer.publish(kStamp, {}, {});
  EXPECT_EQ(sent.status, Status::kOk);
  EXPECT_EQ(sent.packets, 1U);
  EXPECT_EQ(sink.sent.size(), 1U);
}

TEST(Packetizer, RefusesImagesThatDiffer) {
  RandomMap map(8, 8, 13);
  RandomMap other(8, 9, 13);
  KeepingSink sink;
  Packetizer packetizer(kOrigin, sink);
  dsp::DepthMap mixed = map.view();
  mixed.source = other.view().source;
  const Sent sent = packetizer.publish(kStamp, {}, mixed);
  EXPECT_EQ(sent.status, Status::kInvalidArgument);
  EXPECT_EQ(sent.packets, 0U);
  EXPECT_TRUE(sink.sent.empty());
}

TEST(Packetizer, RefusesWhatItsCountersCannotHold) {
  std::vector<dsp::QuarterMm> pixels(65536);
  std::vector<dsp::Source> sources(65536);
  KeepingSink sink;
  Packetizer packetizer(kOrigin, sink);
  const dsp::DepthMap wide{
      {pixels.data(), 65536, 1}, {pixels.data(), 65536, 1}, {sources.data(), 65536, 1}};
  EXPECT_EQ(packetizer.publish(kStamp, {}, wide).status, Status::kTooLarge);
  const dsp::DepthMap high{
      {pixels.data(), 1, 65536}, {pixels.data(), 1, 65536}, {sources.data(), 1, 65536}};
  EXPECT_EQ(packetizer.publish(kStamp, {}, high).status, Status::kTooLarge);
  EXPECT_TRUE(sink.sent.empty());
}

}  // namespace
}  // namespace stof::wire
