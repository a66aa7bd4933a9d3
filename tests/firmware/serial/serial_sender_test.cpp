#include "firmware/serial/serial_sender.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "dsp/fusion/decimate.h"
#include "firmware/serial/mavlink/mavlink_reader.h"
#include "firmware/wire/bytes.h"
#include "firmware/wire/messages/calibration.h"
#include "firmware/wire/messages/sectors.h"
#include "tests/firmware/serial/line.h"
#include "tests/support/random.h"

namespace stof::firmware::test {
namespace {

using namespace std::chrono_literals;
using settings::SerialMode;
using settings::SerialProfile;
using stof::test::Random;
using wire::PacketType;

constexpr hal::Time kStart{1h};

LineReceiver receive(const SenderBench& bench) {
  LineReceiver receiver;
  for (const Bytes& record : bench.records) {
    Bytes code(hal::cobs_bound(record.size()) + 1);
    code.resize(hal::cobs_encode(record, code) + 1);
    receiver.feed(code);
  }
  return receiver;
}

// Frames at `rate` for `seconds`, the ring emptied after each; returns the bytes of all of them.
std::size_t run(SenderBench& bench, int rate, int seconds, hal::Time start = kStart) {
  std::size_t bytes = 0;
  for (int i = 0; i < rate * seconds; ++i) {
    const hal::Time now = start + i * (hal::Duration(1s) / rate);
    bench.sender.tick(now, wire::Health::kOk);
    bench.frame(now);
    bytes += bench.drain();
  }
  return bytes;
}

TEST(LineBudget, IsFreeWhenTheLineIs) {
  LineBudget budget;
  budget.set_baud(100'000);  // 10,000 bytes a second
  EXPECT_EQ(budget.backlog(kStart), 0ns);
  budget.spend(500, kStart);
  EXPECT_EQ(budget.backlog(kStart), 50ms);
  budget.spend(500, kStart + 20ms);
  EXPECT_EQ(budget.backlog(kStart + 20ms), 80ms);
  EXPECT_EQ(budget.backlog(kStart + 1s), 0ns);
}

TEST(SerialSender, SendsNothingWhileItIsOff) {
  SenderBench bench;
  EXPECT_EQ(run(bench, 30, 1), 0U);
  bench.sender.put(Bytes(100), kStart);
  EXPECT_EQ(bench.drain(), 0U);
}

TEST(SerialSender, SendsTheDecimatedPicture) {
  struct Case {
    SerialProfile profile;
    int width, height, step, columns, rows, unit;
  };
  for (const Case& c : {Case{SerialProfile::kCoarse, 640, 480, 8, 80, 60, 64},
                        Case{SerialProfile::kMedium, 640, 480, 4, 160, 120, 16},
                        Case{SerialProfile::kCoarse, 640, 400, 8, 80, 50, 64},
                        Case{SerialProfile::kMedium, 100, 400, 4, 25, 100, 16},
                        Case{SerialProfile::kMedium, 40, 30, 1, 40, 30, 16},
                        Case{SerialProfile::kCoarse, 641, 481, 9, 72, 54, 64}}) {
    SenderBench bench(c.width, c.height);
    Random random(9);
    for (std::size_t i = 0; i < bench.depth.size(); ++i) {
      bench.depth[i] = static_cast<dsp::QuarterMm>(random.between(0, 2) * random.between(0, 999));
      bench.width[i] = static_cast<dsp::QuarterMm>(random.between(0, 300));
    }
    bench.sender.set(
        {.mode = SerialMode::kStof, .profile = c.profile, .baud = 12'000'000, .width = true});
    bench.frame(kStart);
    bench.drain();
    const LineReceiver receiver = receive(bench);
    ASSERT_EQ(receiver.damaged, 0U);
    ASSERT_EQ(receiver.frames.size(), 1U);
    const LineFrame& frame = receiver.frames.at(0);  // numbered on its own
    EXPECT_TRUE(frame.whole());
    EXPECT_EQ(frame.columns, c.columns);
    EXPECT_EQ(frame.rows, c.rows);
    std::vector<dsp::QuarterMm> depth(static_cast<std::size_t>(c.columns * c.rows));
    std::vector<dsp::QuarterMm> width(depth.size());
    dsp::decimate(bench.map(), c.step, {depth.data(), c.columns, c.rows},
                  {width.data(), c.columns, c.rows});
    for (std::size_t i = 0; i < depth.size(); ++i) {
      ASSERT_EQ(frame.depth[i] > 0, depth[i] > 0);
      if (depth[i] == 0) {
        continue;
      }
      // The interval that arrives holds the one that was measured, and is little wider.
      const int low = 2 * c.unit * frame.depth[i] - c.unit * frame.width[i];
      const int high = 2 * c.unit * frame.depth[i] + c.unit * frame.width[i];
      ASSERT_LE(low, 2 * depth[i] - width[i]);
      ASSERT_GE(high, 2 * depth[i] + width[i]);
      ASSERT_LT(c.unit * frame.width[i], width[i] + 3 * c.unit);
      ASSERT_TRUE(c.unit * frame.depth[i] <= depth[i] || frame.depth[i] == 1);
    }
    EXPECT_EQ(receiver.count(PacketType::kFrameInfo), 1U);
  }
}

TEST(SerialSender, TellsTheLensOfTheDecimatedPicture) {
  SenderBench bench;
  bench.sender.set(
      {.mode = SerialMode::kStof, .profile = SerialProfile::kCoarse, .baud = 12'000'000});
  run(bench, 30, 3);
  const LineReceiver receiver = receive(bench);
  EXPECT_EQ(receiver.count(PacketType::kCalibration), 3U);  // once a second
  const LinePacket* const packet = receiver.last(PacketType::kCalibration);
  ASSERT_NE(packet, nullptr);
  const auto lens = wire::decode_calibration_packet(packet->payload);
  ASSERT_TRUE(lens);
  EXPECT_EQ(lens->image_width, 80);
  EXPECT_EQ(lens->image_height, 60);
  EXPECT_EQ(lens->fx, (500 << 16) / 8);
  EXPECT_EQ(lens->depth_unit_um, 16'000U);
  EXPECT_EQ(lens->max_range, 625U);  // 10 m of 16 mm
  // The middle of the picture stays the middle: 319.5 of 640 columns, 39.5 of 80.
  EXPECT_EQ(lens->cx, 39.5 * 65'536);
  EXPECT_EQ(lens->cy, 29.5 * 65'536);
}

TEST(SerialSender, TellsRangeAndPeriodAsItsFramesDo) {
  SenderBench bench;
  bench.sender.set(
      {.mode = SerialMode::kStof, .profile = SerialProfile::kCoarse, .baud = 12'000'000});
  bench.info.max_range_um = 4'000'000;
  bench.info.period_ns = 40'000'000;
  run(bench, 30, 1);
  const LineReceiver receiver = receive(bench);
  const LinePacket* const packet = receiver.last(PacketType::kCalibration);
  ASSERT_NE(packet, nullptr);
  const auto lens = wire::decode_calibration_packet(packet->payload);
  ASSERT_TRUE(lens);
  EXPECT_EQ(lens->max_range, 250U);  // of 16 mm
  EXPECT_EQ(lens->period_ns, 40'000'000);
}

TEST(SerialSender, KeepsToTheRate) {
  for (const std::uint32_t rate : {1U, 7U, 10U, 20U, 30U, 60U}) {
    SenderBench bench(160, 120);
    bench.sender.set({.mode = SerialMode::kStof, .baud = 3'000'000, .rate_hz = rate});
    run(bench, 30, 10);
    const std::size_t sectors = receive(bench).count(PacketType::kSectors);
    EXPECT_NEAR(static_cast<double>(sectors), std::min(rate, 30U) * 10, 1) << rate;
    EXPECT_EQ(bench.sender.counters().dropped, 0U) << rate;
  }
}

TEST(SerialSender, NeverSendsMoreThanTheLineCarries) {
  SenderBench bench;
  Random random(10);
  random.fill(std::span(bench.depth));  // does not compress
  bench.sender.set({.mode = SerialMode::kStof,
                    .profile = SerialProfile::kCoarse,
                    .baud = 115'200,
                    .rate_hz = 20});
  const std::size_t bytes = run(bench, 30, 20);
  EXPECT_LE(bytes, 11'520U * 20 + 12'000);  // and a frame that is on its way
  EXPECT_GE(bytes, 11'520U * 20 / 2);       // but it is not idle either
  EXPECT_GT(bench.sender.counters().dropped, 0U);
  const LineReceiver receiver = receive(bench);
  EXPECT_EQ(receiver.whole_frames(), receiver.frames.size());  // whole frames only
}

TEST(SerialSender, DropsWholeFramesWhereTheRingIsFull) {
  SenderBench bench(640, 480, 16'384);
  Random random(11);
  random.fill(std::span(bench.depth));
  bench.sender.set({.mode = SerialMode::kStof,
                    .profile = SerialProfile::kCoarse,
                    .baud = 12'000'000,
                    .rate_hz = 30});
  for (int i = 0; i < 30; ++i) {
    bench.frame(kStart + i * 34ms);  // nobody takes
  }
  bench.drain();
  const LineReceiver receiver = receive(bench);
  EXPECT_GE(receiver.whole_frames(), 1U);
  EXPECT_EQ(receiver.frames.size(), receiver.whole_frames());
  EXPECT_GE(bench.sender.counters().dropped, 25U);
}

TEST(SerialSender, CarriesSectorsAt57600) {
  SenderBench bench(160, 120);
  std::ranges::fill(bench.depth, dsp::QuarterMm{8000});
  bench.sender.set({.mode = SerialMode::kStof, .baud = 57'600, .rate_hz = 20});
  run(bench, 30, 10);
  EXPECT_EQ(bench.sender.counters().dropped, 0U);
  const LineReceiver receiver = receive(bench);
  EXPECT_EQ(receiver.count(PacketType::kSectors), 200U);
  const auto report = wire::decode_sector_report(receiver.last(PacketType::kSectors)->payload);
  ASSERT_TRUE(report);
  EXPECT_EQ(report->distances_cm[36], 200);
}

TEST(SerialSender, PutsPacketsBetweenTheFrames) {
  SenderBench bench;
  bench.sender.set({.mode = SerialMode::kStof});
  wire::DatagramBuffer buffer{};
  bench.sender.put(wire::seal_packet({.type = PacketType::kHealth}, 10, buffer), kStart);
  bench.drain();
  EXPECT_EQ(receive(bench).count(PacketType::kHealth), 1U);
  bench.sender.set({.mode = SerialMode::kMavlink});
  bench.sender.put(wire::seal_packet({.type = PacketType::kHealth}, 10, buffer), kStart);
  EXPECT_EQ(bench.drain(), 0U);
}

std::size_t count_id(const SenderBench& bench, unsigned id) {
  return static_cast<std::size_t>(std::ranges::count_if(bench.records, [id](const Bytes& record) {
    return record[0] == std::byte{0xFD} && (std::to_integer<unsigned>(record[7]) |
                                            (std::to_integer<unsigned>(record[8]) << 8)) == id;
  }));
}

TEST(SerialSender, SpeaksMavlinkAt57600) {
  SenderBench bench(160, 120);
  std::ranges::fill(bench.depth, dsp::QuarterMm{8000});
  bench.sender.set({.mode = SerialMode::kMavlink,
                    .baud = 57'600,
                    .rate_hz = 20,
                    .system_id = 3,
                    .component_id = 196});
  run(bench, 30, 10);
  EXPECT_EQ(count_id(bench, 0), 10U);
  EXPECT_EQ(count_id(bench, 330), 200U);
  EXPECT_EQ(count_id(bench, 132), 200U);
  EXPECT_EQ(bench.sender.counters().dropped, 0U);
  for (std::size_t i = 0; i < bench.records.size(); ++i) {
    EXPECT_EQ(std::to_integer<unsigned>(bench.records[i][4]), i % 256);
    EXPECT_EQ(std::to_integer<unsigned>(bench.records[i][5]), 3U);
    EXPECT_EQ(std::to_integer<unsigned>(bench.records[i][6]), 196U);
  }
  const Bytes& obstacle = bench.records[1];
  EXPECT_EQ(wire::get_u16(std::span(obstacle).subspan(10 + 8 + 2 * 36).first<2>()), 200);
}

TEST(SerialSender, BeatsItsHeartAlsoWithoutFrames) {
  SenderBench bench;
  bench.sender.set({.mode = SerialMode::kMavlink});
  for (int i = 0; i < 100; ++i) {
    bench.sender.tick(kStart + i * 33ms, wire::Health::kFault);
  }
  bench.drain();
  EXPECT_EQ(count_id(bench, 0), 4U);
  EXPECT_EQ(bench.records.size(), 4U);
  EXPECT_EQ(std::to_integer<unsigned>(bench.records[0][10 + 7]), 6U);  // MAV_STATE_EMERGENCY
}

// Unknown is told as unknown, and as nearer than near to whoever does not look at the quality.
TEST(SerialSender, NeverTellsThatTheWayIsFree) {
  SenderBench bench;  // no depth at all
  bench.sender.set({.mode = SerialMode::kMavlink});
  bench.frame(kStart);
  bench.drain();
  ASSERT_EQ(bench.records.size(), 2U);
  const std::span<const std::byte> obstacle = std::span(bench.records[0]).subspan(10);
  for (std::size_t i = 0; i < 72; ++i) {
    EXPECT_EQ(wire::get_u16(obstacle.subspan(8 + 2 * i).first<2>()), 65'535);
  }
  const std::span<const std::byte> ahead = std::span(bench.records[1]).subspan(10);
  EXPECT_EQ(wire::get_u16(ahead.subspan<8, 2>()), 0);  // current_distance
  EXPECT_EQ(ahead[13], std::byte{255});                // covariance: unknown
  EXPECT_EQ(ahead[38], std::byte{1});                  // signal_quality: invalid
}

TEST(SerialSender, ChangesItsMindBetweenFrames) {
  SenderBench bench;
  bench.sender.set({.mode = SerialMode::kStof, .profile = SerialProfile::kCoarse});
  bench.frame(kStart);
  bench.sender.set({.mode = SerialMode::kMavlink});
  bench.frame(kStart + 200ms);
  bench.sender.set({.mode = SerialMode::kStof, .profile = SerialProfile::kSectors});
  bench.frame(kStart + 400ms);
  bench.drain();
  EXPECT_EQ(count_id(bench, 330), 1U);
  const LineReceiver receiver = receive(bench);
  EXPECT_EQ(receiver.whole_frames(), 1U);
  EXPECT_EQ(receiver.count(PacketType::kSectors), 1U);
}

}  // namespace
}  // namespace stof::firmware::test
