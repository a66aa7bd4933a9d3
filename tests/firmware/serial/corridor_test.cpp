#include <algorithm>
#include <chrono>

#include <gtest/gtest.h>

#include "tests/firmware/serial/line.h"
#include "tests/firmware/wire/frame/corridor_frame.h"

namespace stof::firmware::test {
namespace {

using namespace std::chrono_literals;
using settings::SerialMode;
using settings::SerialProfile;

// Frames of the corridor at 30 Hz for three seconds; what arrived whole.
std::size_t frames_in_three_seconds(SenderBench& bench, const SerialParams& params) {
  bench.sender.set(params);
  wire::DatagramBuffer buffer{};
  LineReceiver receiver;
  for (int i = 0; i < 90; ++i) {
    const hal::Time now = hal::Time(1h) + i * 33'333'333ns;
    if (i % 30 == 0) {
      bench.sender.put(wire::seal_packet({.type = wire::PacketType::kHealth}, 300, buffer), now);
    }
    bench.frame(now);
    bench.drain();
  }
  for (const Bytes& record : bench.records) {
    Bytes code(hal::cobs_bound(record.size()) + 1);
    code.resize(hal::cobs_encode(record, code) + 1);
    receiver.feed(code);
  }
  EXPECT_EQ(receiver.damaged, 0U);
  EXPECT_EQ(bench.sender.counters().dropped, 0U);
  return receiver.whole_frames();
}

void show(SenderBench& bench) {
  static stof::test::CorridorFrame corridor;
  const dsp::DepthMap map = corridor.images().map;
  for (int y = 0; y < map.depth.height(); ++y) {
    std::ranges::copy(map.depth.row(y), bench.map().depth.row(y).begin());
    std::ranges::copy(map.width.row(y), bench.map().width.row(y).begin());
  }
}

TEST(SerialCorridor, IsCoarseAt20HzAnd921600Baud) {
  SenderBench bench;
  show(bench);
  EXPECT_GE(frames_in_three_seconds(bench, {.mode = SerialMode::kStof,
                                            .profile = SerialProfile::kCoarse,
                                            .baud = 921'600,
                                            .rate_hz = 20}),
            59U);
}

TEST(SerialCorridor, IsMediumAt15HzAnd3000000Baud) {
  SenderBench bench;
  show(bench);
  EXPECT_GE(frames_in_three_seconds(bench, {.mode = SerialMode::kStof,
                                            .profile = SerialProfile::kMedium,
                                            .baud = 3'000'000,
                                            .rate_hz = 15}),
            44U);
}

}  // namespace
}  // namespace stof::firmware::test
