#include <vector>

#include <gtest/gtest.h>

#include "firmware/wire/codec/rvl_encode.h"
#include "firmware/wire/frame/frame_coder.h"
#include "firmware/wire/frame/tiles.h"
#include "tests/firmware/wire/frame/coder_in_memory.h"
#include "tests/firmware/wire/frame/corridor_frame.h"

// What RVL makes of a depth map that the emulated rig computes.
namespace stof::wire {
namespace {

struct Cost {
  std::size_t pixels = 0;
  std::size_t packets = 0;
  std::size_t payloads = 0;  // bytes
};

Cost cost_of(const std::vector<std::uint16_t>& values, const Raster& raster) {
  std::vector<DatagramBuffer> buffers(1000);
  std::vector<Part> parts(1000);
  PartStore store(buffers, parts);
  add_rvl_tiles<std::uint16_t>(values, raster, store);
  Cost cost{.packets = store.size()};
  for (std::size_t i = 0; i < store.size(); ++i) {
    cost.pixels += store.part(i).pixel_count;
    cost.payloads += store.part(i).payload_bytes;
  }
  return cost;
}

// The same without any restart: sequences of as many rows as one may have.
std::size_t bytes_without_restart(const std::vector<std::uint16_t>& values) {
  std::vector<std::byte> out(2 * values.size() * sizeof(std::uint16_t));
  std::size_t bytes = 0;
  for (std::size_t at = 0; at < values.size();) {
    const auto rest = std::span<const std::uint16_t>(values).subspan(at);
    const RvlCoded coded = rvl_encode(rest, out);
    bytes += coded.bytes;
    at += coded.values;
  }
  return bytes;
}

TEST(CorridorTest, RvlMakesDepthSmallAndRestartsCostLittle) {
  test::CorridorFrame frame;
  const dsp::ImageView<const std::uint16_t> depth = frame.images().map.depth;
  const std::vector<std::uint16_t> values(depth.data(), depth.data() + 640 * 480);
  const Cost cost = cost_of(values, {.stream = Stream::kDepth, .width = 640, .height = 480});
  EXPECT_EQ(cost.pixels, values.size());
  const double ratio =
      2.0 * static_cast<double>(values.size()) / static_cast<double>(cost.payloads);
  const double restarts =
      static_cast<double>(cost.payloads) / static_cast<double>(bytes_without_restart(values));
  RecordProperty("ratio", std::to_string(ratio));
  RecordProperty("restarts", std::to_string(restarts));
  EXPECT_GE(ratio, 2.0);  // 2.05: steps of the disparity and the noise of the PMD take most of it
  EXPECT_LT(restarts, 1.01);
}

std::size_t payloads(std::span<const std::span<const std::byte>> datagrams, Stream stream) {
  std::size_t bytes = 0;
  for (const std::span<const std::byte> datagram : datagrams) {
    const PacketView packet = parse_packet(datagram).value();
    bytes += packet.header.stream == stream ? packet.payload.size() : 0;
  }
  return bytes;
}

TEST(CorridorTest, RoundedDepthAndWidthAreAThird) {
  test::CorridorFrame frame;
  test::CoderInMemory coder({}, frame.sizes(), {.fx = 65'536, .fy = 65'536});
  StreamChoice choice;
  choice.of(Stream::kDepth) = Coding::kQuantised;
  choice.of(Stream::kWidth) = Coding::kQuantised;
  const auto datagrams = coder->code({}, {}, frame.images(), choice).value();
  const auto ratio = [&datagrams](Stream stream) {
    return 2.0 * 640 * 480 / static_cast<double>(payloads(datagrams, stream));
  };
  RecordProperty("depth", std::to_string(ratio(Stream::kDepth)));
  RecordProperty("width", std::to_string(ratio(Stream::kWidth)));
  EXPECT_GE(ratio(Stream::kDepth), 2.9);  // 3.09
  EXPECT_GE(ratio(Stream::kWidth), 2.6);
}

}  // namespace
}  // namespace stof::wire
