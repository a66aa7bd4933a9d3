#include <algorithm>
#include <array>
#include <cstring>

#include <gtest/gtest.h>
#include <wire_golden.h>

#include "tests/support/guarded.h"

// wire_golden.h is made by scripts/wire_table.py --golden when this is configured: of each message
// a value whose fields all differ, and the bytes that Python packs of it.
namespace stof::wire {
namespace {

template <typename T, std::size_t kBytes>
void expect_bytes(const golden::Golden<T, kBytes>& golden,
                  void (*encode)(const T&, std::span<std::byte, kBytes>) noexcept,
                  Result<T> (*decode)(std::span<const std::byte>) noexcept) {
  test::GuardedBuffer<std::byte> expected(kBytes);
  std::memcpy(expected.span().data(), golden.bytes.data(), kBytes);
  std::array<std::byte, kBytes> out;
  out.fill(std::byte{0xEE});
  encode(golden.value, out);
  EXPECT_TRUE(std::ranges::equal(out, expected.span())) << "encoded";

  const Result<T> decoded = decode(expected.span());
  ASSERT_TRUE(decoded);
  out.fill(std::byte{0xEE});
  encode(*decoded, out);
  EXPECT_TRUE(std::ranges::equal(out, expected.span())) << "decoded and encoded";

  for (std::size_t size = 0; size < kBytes; ++size) {
    const test::GuardedBuffer<std::byte> less(size);
    ASSERT_EQ(decode(less.span()).error(), Status::kCorrupt) << size;
  }
}

TEST(WireTable, HeaderIsWhatPythonPacks) {
  expect_bytes(golden::header, encode_header_fields, decode_header_fields);
}
TEST(WireTable, FrameInfoIsWhatPythonPacks) {
  expect_bytes(golden::frame_info, encode_frame_info, decode_frame_info);
}
TEST(WireTable, CalibrationIsWhatPythonPacks) {
  expect_bytes(golden::calibration, encode_calibration_packet, decode_calibration_packet);
}
TEST(WireTable, HealthIsWhatPythonPacks) {
  expect_bytes(golden::health, encode_health_report, decode_health_report);
}
TEST(WireTable, EventIsWhatPythonPacks) {
  expect_bytes(golden::event, encode_event_report, decode_event_report);
}
TEST(WireTable, ParityIsWhatPythonPacks) {
  expect_bytes(golden::parity, encode_parity_fields, decode_parity_fields);
}
TEST(WireTable, AnnounceIsWhatPythonPacks) {
  expect_bytes(golden::announce, encode_announce, decode_announce);
}
TEST(WireTable, SectorsAreWhatPythonPacks) {
  expect_bytes(golden::sectors, encode_sector_report, decode_sector_report);
}
TEST(WireTable, SubscribeIsWhatPythonPacks) {
  expect_bytes(golden::subscribe, encode_subscribe, decode_subscribe);
}
TEST(WireTable, SubscribedIsWhatPythonPacks) {
  expect_bytes(golden::subscribed, encode_subscribed, decode_subscribed);
}
TEST(WireTable, SettingsRequestIsWhatPythonPacks) {
  expect_bytes(golden::settings_request, encode_settings_request, decode_settings_request);
}
TEST(WireTable, SettingsAnswerIsWhatPythonPacks) {
  expect_bytes(golden::settings_answer, encode_settings_answer, decode_settings_answer);
}
TEST(WireTable, DiscoverIsWhatPythonPacks) {
  expect_bytes(golden::discover, encode_discover, decode_discover);
}

}  // namespace
}  // namespace stof::wire
