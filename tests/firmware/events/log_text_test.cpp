#include "firmware/events/log_text.h"

#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>

#include <gtest/gtest.h>

#include "hal/network_interfaces.h"
#include "tests/support/heap_guard.h"

namespace stof::firmware {
namespace {

constexpr auto kLastEvent = static_cast<int>(EventKind::kRelease);

constexpr std::array<std::uint8_t, 16> kLongest{0xFD, 0x11, 0xFD, 0x11, 0xFD, 0x11, 0xFD, 0x11,
                                                0xFD, 0x11, 0xFD, 0x11, 0xFD, 0x11, 0xFD, 0x11};

std::string text_of(const Event& event) {
  std::array<char, kMostLine> space;
  settings::PagedWriter line(space);
  describe(event, line);
  EXPECT_TRUE(line.complete()) << line.text();
  return std::string(line.text());
}

// A system that refuses memory while the sensor runs ends nothing, and costs no line.
TEST(LogText, EveryEventFitsItsLineAndTakesNoMemory) {
  for (int kind = 0; kind <= kLastEvent; ++kind) {
    for (std::size_t component = 0; component < kComponents; ++component) {
      for (const std::uint32_t value : {0U, 1U, 3U, std::numeric_limits<std::uint32_t>::max()}) {
        for (const std::uint32_t former : {0U, 1U, 2U}) {
          std::array<char, kMostLine> space;
          settings::PagedWriter line(space);
          test::heap_forbidden = true;
          describe({.kind = static_cast<EventKind>(kind),
                    .component = static_cast<Component>(component),
                    .status = Status::kInvalidArgument,
                    .value = value,
                    .former = former,
                    .role = wire::Role::kAdmin,
                    .address = kLongest},
                   line);
          test::heap_forbidden = false;
          EXPECT_TRUE(line.complete()) << line.text();
          EXPECT_NE(line.text(), "unknown event") << kind;
          EXPECT_EQ(line.text().find('\n'), std::string_view::npos);
        }
      }
    }
  }
}

TEST(LogText, SaysWhatChanged) {
  EXPECT_EQ(text_of({.kind = EventKind::kPublishing}), "publishing");
  EXPECT_EQ(text_of({.kind = EventKind::kPublishing, .value = 7}),
            "publishing, after 7 edges without a frame");
  EXPECT_EQ(text_of({.kind = EventKind::kLost, .component = Component::kStereo}),
            "stereo camera lost, trying to get it back");
  EXPECT_EQ(text_of({.kind = EventKind::kCalibrationChanged, .value = 0x12, .former = 0xABCDEF01}),
            "calibration 00000012 in place of abcdef01, put there over the serial line");
  EXPECT_EQ(text_of({.kind = EventKind::kRelease, .value = kReleaseLeft, .former = 0x12}),
            "release 00000012 was not confirmed: each start takes the former one");
  EXPECT_EQ(text_of({.kind = EventKind::kRelease, .value = kReleaseConfirmed, .former = 0x12}),
            "release 00000012 is confirmed: each start takes it");
  EXPECT_EQ(text_of({.kind = EventKind::kSettingsChanged,
                     .address = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF, 192, 168, 1, 20}}),
            "settings changed by 192.168.1.20");
  EXPECT_EQ(text_of({.kind = EventKind::kSettingsChanged,
                     .former = kNetworkOnTrial,
                     .address = hal::kAllOfLink}),
            "settings changed by broadcast; network is on trial");
  EXPECT_EQ(text_of({.kind = EventKind::kSettingsChanged, .former = kNetworkOnTrial}),
            "settings changed over the serial line; network is on trial");
  EXPECT_EQ(text_of({.kind = EventKind::kSettingsChanged, .former = kNetworkTakenBack}),
            "settings changed: network is as before, because nobody saved its change in time");
  EXPECT_EQ(text_of({.kind = EventKind::kKeyEnded, .value = 0xA2B, .role = wire::Role::kAdmin}),
            "key 00000a2b, role admin, ended over the serial line");
  EXPECT_EQ(
      text_of({.kind = EventKind::kPairing,
               .value = 1'000'000 + 12'034,
               .role = wire::Role::kAdmin,
               .address = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF, 192, 0, 2, 7}}),
      "pairing: the digits are 012 034, role admin, asked for by 192.0.2.7. Type them into stof "
      "pair; only if it accepts them hold the button for three seconds");
  std::array<std::uint8_t, 16> longest{};
  longest.fill(0xFD);
  const std::string line = text_of({.kind = EventKind::kPairing,
                                    .value = 1'999'999,
                                    .role = wire::Role::kAdmin,
                                    .address = longest});
  EXPECT_TRUE(
      line.ends_with("fdfd:fdfd. Type them into stof pair; only if it accepts them hold "
                     "the button for three seconds"))
      << line;
}

TEST(LogText, WhoHoldsTheButtonIsToldWhatItDoes) {
  EXPECT_EQ(text_of({.kind = EventKind::kPairing, .former = kPairingPressed}),
            "pairing has ended without a key: the button was pressed, or held for less than three "
            "seconds. Press it again to begin anew");
  const auto vain = [](std::uint32_t state) {
    return text_of({.kind = EventKind::kPairing, .value = state, .former = kPairingHeldInVain});
  };
  EXPECT_EQ(vain(kPairingTold + 5),
            "pairing: the hold of the button counts for nothing: it began before the digits were "
            "told. Let go, read the digits, hold again");
  EXPECT_TRUE(vain(kPairingOpen)
                  .ends_with(": no digits are told yet. Let go, wait for the digits, "
                             "read them, hold again"));
  EXPECT_TRUE(vain(kPairingClosed)
                  .ends_with(": there are no digits to accept. A short press opens pairing"));
}

}  // namespace
}  // namespace stof::firmware
