#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "firmware/wire/bytes.h"
#include "firmware/wire/calibration/calibration_packet.h"
#include "firmware/wire/frame_info.h"
#include "tests/support/guarded_memory.h"
#include "tests/support/random.h"

namespace stof::wire {
namespace {

dsp::Calibration some_calibration() {
  dsp::Calibration calibration;
  calibration.stereo = {
      .left = {.width = 450, .height = 375, .fx = 615.25, .fy = 615.5, .cx = 224.75, .cy = -0.5},
      .baseline_m = 0.160000001,
      .doff_px = -32.0625};
  calibration.pmd.lens = {.width = 64, .height = 16, .fx = 45.28, .fy = 45.28};
  calibration.pmd.frequency.modulation = dsp::Hertz{20'000'000};
  calibration.pmd_to_stereo = {.rotation = {1, 0.25, -0.5, 0, -1, 0, 0.125, 0, 1},
                               .translation_m = {-0.05, 0.000000001, 2.5}};
  return calibration;
}

// Bytes are random, so that every field has another value; a field at a wrong offset shows.
TEST(FrameInfo, IsDecodedAndEncodedToTheSameBytes) {
  test::Random random(1);
  for (int round = 0; round < 100; ++round) {
    test::GuardedBuffer<std::byte> bytes(kFrameInfoBytes);
    for (std::byte& byte : bytes.span()) {
      byte = static_cast<std::byte>(random.next());
    }
    bytes[203] = std::byte{0};  // reserved
    const Result<FrameInfo> info = decode_frame_info(bytes.span());
    ASSERT_TRUE(info);
    std::array<std::byte, kFrameInfoBytes> again{};
    encode_frame_info(*info, again);
    ASSERT_TRUE(std::ranges::equal(bytes.span(), again)) << "round " << round;
  }
}

TEST(FrameInfo, TellsPixelsBySourceAndSignificantDrifts) {
  const FrameInfo info{.pixels_by_source = {10, 11, 12, 13, 14, 15}, .drift_significant = 0b01010};
  EXPECT_EQ(pixels(info, dsp::Source::kBoth), 13U);
  EXPECT_FALSE(significant(info, 0));
  EXPECT_TRUE(significant(info, 1));
  EXPECT_TRUE(significant(info, 3));
}

TEST(FrameInfo, RefusesLessAndIgnoresMore) {
  for (std::size_t size = 0; size < kFrameInfoBytes; ++size) {
    const test::GuardedBuffer<std::byte> bytes(size);
    ASSERT_EQ(decode_frame_info(bytes.span()).error(), Status::kCorrupt) << size;
  }
  EXPECT_TRUE(decode_frame_info(std::vector<std::byte>(kFrameInfoBytes + 9)));
}

TEST(CalibrationPacket, StatesTheRigInItsUnits) {
  const Result<CalibrationPacket> packet =
      make_calibration_packet(some_calibration(), 40'000, 33'333'000);
  ASSERT_TRUE(packet);
  EXPECT_EQ(packet->image_width, 450);
  EXPECT_EQ(packet->image_height, 375);
  EXPECT_EQ(packet->pmd_width, 64);
  EXPECT_EQ(packet->pmd_height, 16);
  EXPECT_EQ(packet->fx, 40'321'024);  // 615.25 * 65536
  EXPECT_EQ(packet->fy, 40'337'408);  // 615.5 * 65536
  EXPECT_EQ(packet->cx, 14'729'216);  // 224.75 * 65536
  EXPECT_EQ(packet->cy, -32'768);
  EXPECT_EQ(packet->doff, -2'101'248);  // -32.0625 * 65536
  EXPECT_EQ(packet->depth_unit_um, 250U);
  EXPECT_EQ(packet->max_range, 40'000U);
  EXPECT_EQ(packet->modulation_hz, 20'000'000U);
  EXPECT_EQ(packet->baseline_nm, 160'000'001);
  EXPECT_EQ(packet->period_ns, 33'333'000);
  EXPECT_EQ(packet->rotation[0], 1 << 30);
  EXPECT_EQ(packet->rotation[1], 1 << 28);
  EXPECT_EQ(packet->rotation[2], -(1 << 29));
  EXPECT_EQ(packet->rotation[4], -(1 << 30));
  EXPECT_EQ(packet->translation_nm, (std::array<std::int64_t, 3>{-50'000'000, 1, 2'500'000'000}));
}

TEST(CalibrationPacket, HasItsFieldsAtTheDocumentsOffsets) {
  const CalibrationPacket packet{.image_width = 1,
                                 .image_height = 2,
                                 .pmd_width = 3,
                                 .pmd_height = 4,
                                 .fx = 5,
                                 .fy = 6,
                                 .cx = -7,
                                 .cy = 8,
                                 .doff = 9,
                                 .depth_unit_um = 10,
                                 .max_range = 11,
                                 .modulation_hz = 12,
                                 .baseline_nm = -13,
                                 .period_ns = 14,
                                 .rotation = {20, 21, 22, 23, 24, 25, 26, 27, 28},
                                 .translation_nm = {30, 31, 32}};
  std::array<std::byte, kCalibrationPacketBytes> out{};
  encode_calibration_packet(packet, out);
  const std::span<const std::byte> bytes(out);
  for (std::uint16_t i = 0; i < 4; ++i) {
    EXPECT_EQ(get_u16(bytes.subspan(2U * i).first<2>()), 1 + i);
  }
  for (std::int32_t i = 0; i < 8; ++i) {
    const std::size_t at = 8 + 4 * static_cast<std::size_t>(i);
    EXPECT_EQ(get_i32(bytes.subspan(at).first<4>()), i == 2 ? -7 : 5 + i);
  }
  EXPECT_EQ(get_i64(bytes.subspan<40, 8>()), -13);
  EXPECT_EQ(get_i64(bytes.subspan<48, 8>()), 14);
  for (std::int32_t i = 0; i < 9; ++i) {
    const std::size_t at = 56 + 4 * static_cast<std::size_t>(i);
    EXPECT_EQ(get_i32(bytes.subspan(at).first<4>()), 20 + i);
  }
  EXPECT_EQ(get_u32(bytes.subspan<92, 4>()), 0U);
  for (std::int64_t i = 0; i < 3; ++i) {
    const std::size_t at = 96 + 8 * static_cast<std::size_t>(i);
    EXPECT_EQ(get_i64(bytes.subspan(at).first<8>()), 30 + i);
  }
}

TEST(CalibrationPacket, RoundTripsExactly) {
  const Result<CalibrationPacket> packet = make_calibration_packet(some_calibration(), 1, 2);
  ASSERT_TRUE(packet);
  test::GuardedBuffer<std::byte> bytes(kCalibrationPacketBytes);
  encode_calibration_packet(*packet, bytes.span().first<kCalibrationPacketBytes>());
  const Result<CalibrationPacket> again = read_calibration_packet(bytes.span());
  ASSERT_TRUE(again);
  EXPECT_EQ(*again, *packet);
}

TEST(CalibrationPacket, IsDecodedAndEncodedToTheSameBytes) {
  test::Random random(2);
  for (int round = 0; round < 100; ++round) {
    std::array<std::byte, kCalibrationPacketBytes> bytes{};
    for (std::byte& byte : bytes) {
      byte = static_cast<std::byte>(random.next());
    }
    bytes[11] &= std::byte{0x7F};  // focal lengths are positive
    bytes[15] &= std::byte{0x7F};
    put_u32(std::span(bytes).subspan<92, 4>(), 0);
    const Result<CalibrationPacket> packet = read_calibration_packet(bytes);
    ASSERT_TRUE(packet);
    std::array<std::byte, kCalibrationPacketBytes> again{};
    encode_calibration_packet(*packet, again);
    ASSERT_EQ(again, bytes) << "round " << round;
  }
}

TEST(CalibrationPacket, RefusesNumbersThatDoNotFit) {
  using Limits = std::numeric_limits<double>;
  for (const double bad : {32768.0, 1e300, Limits::infinity(), Limits::quiet_NaN()}) {
    dsp::Calibration calibration = some_calibration();
    calibration.stereo.left.fx = bad;
    EXPECT_EQ(make_calibration_packet(calibration, 1, 1).error(), Status::kTooLarge) << bad;
    calibration = some_calibration();
    calibration.stereo.doff_px = -bad - 1;
    EXPECT_EQ(make_calibration_packet(calibration, 1, 1).error(), Status::kTooLarge) << bad;
  }
  dsp::Calibration calibration = some_calibration();
  calibration.stereo.left.width = 65536;
  EXPECT_EQ(make_calibration_packet(calibration, 1, 1).error(), Status::kTooLarge);
  calibration.stereo.left.width = -1;
  EXPECT_EQ(make_calibration_packet(calibration, 1, 1).error(), Status::kTooLarge);
  calibration.stereo.left.width = 65535;
  EXPECT_TRUE(make_calibration_packet(calibration, 1, 1));
}

TEST(CalibrationPacket, RefusesLessAndWhatNobodyCanDivideBy) {
  const Result<CalibrationPacket> packet = make_calibration_packet(some_calibration(), 1, 2);
  ASSERT_TRUE(packet);
  std::array<std::byte, kCalibrationPacketBytes> bytes{};
  encode_calibration_packet(*packet, bytes);
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    ASSERT_EQ(read_calibration_packet(std::span(bytes).first(size)).error(), Status::kCorrupt);
  }
  for (const std::size_t field : {8U, 12U, 28U}) {  // fx, fy, depth unit
    std::array<std::byte, kCalibrationPacketBytes> zero = bytes;
    put_u32(std::span(zero).subspan(field).first<4>(), 0);
    EXPECT_EQ(read_calibration_packet(zero).error(), Status::kCorrupt) << field;
  }
}

}  // namespace
}  // namespace stof::wire
