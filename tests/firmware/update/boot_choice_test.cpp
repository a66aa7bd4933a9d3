#include "firmware/update/boot_choice.h"

#include <algorithm>
#include <array>
#include <string_view>

#include <gtest/gtest.h>

namespace stof::update {
namespace {

using SectorBytes = std::array<std::byte, kSectorBytes>;

SectorBytes sector_of(const BootChoice& choice) {
  SectorBytes sector;
  sector.fill(std::byte{0xAA});
  write_choice(choice, sector);
  return sector;
}

TEST(BootChoice, IsTheTextThatARaspberryPiReads) {
  constexpr std::string_view kText =
      "[all]\ntryboot_a_b=1\nboot_partition=2\n[tryboot]\nboot_partition=3\n";
  const SectorBytes sector = sector_of({.usual = Slot::kA, .trial = Slot::kB});
  EXPECT_TRUE(
      std::ranges::equal(std::as_bytes(std::span(kText)), std::span(sector).first(kText.size())));
  EXPECT_TRUE(std::ranges::all_of(std::span(sector).subspan(kText.size()),
                                  [](std::byte byte) { return byte == std::byte{0}; }));
}

TEST(BootChoice, ReadsWhatItWrites) {
  for (const Slot usual : {Slot::kA, Slot::kB}) {
    for (const Slot trial : {Slot::kA, Slot::kB}) {
      const BootChoice choice{.usual = usual, .trial = trial};
      EXPECT_EQ(read_choice(sector_of(choice)), choice);
    }
  }
}

TEST(BootChoice, AnyOtherByteIsNoChoice) {
  const SectorBytes good = sector_of(settled(Slot::kA));
  for (std::size_t i = 0; i < good.size(); ++i) {
    SectorBytes bad = good;
    bad[i] ^= std::byte{0x40};
    EXPECT_FALSE(read_choice(bad)) << i;
  }
}

// The medium has written the first bytes of the sector and not the last, or the other way round.
TEST(BootChoice, ATornSectorNamesSlotsAndSettlesNobodyElse) {
  for (const Slot running : {Slot::kA, Slot::kB}) {
    const SectorBytes before = sector_of(settled(other(running)));
    const SectorBytes after = sector_of(settled(running));
    for (std::size_t cut = 0; cut <= before.size(); ++cut) {
      for (const bool first : {false, true}) {
        SectorBytes torn = first ? after : before;
        const SectorBytes& rest = first ? before : after;
        std::copy(rest.begin() + static_cast<std::ptrdiff_t>(cut), rest.end(),
                  torn.begin() + static_cast<std::ptrdiff_t>(cut));
        const auto choice = read_choice(torn);
        ASSERT_TRUE(choice) << cut;
        // Whichever starts then was whole before the sector was written.
        const Slot starts = started(*choice, false);
        EXPECT_FALSE(on_trial(*choice, starts));
      }
    }
  }
}

TEST(BootChoice, OnlyAStartThatAsksForItTakesTheOtherSlot) {
  const BootChoice choice = settled(Slot::kB);
  EXPECT_EQ(started(choice, false), Slot::kB);
  EXPECT_EQ(started(choice, true), Slot::kA);
  EXPECT_TRUE(on_trial(choice, Slot::kA));
  EXPECT_FALSE(on_trial(choice, Slot::kB));
}

}  // namespace
}  // namespace stof::update
