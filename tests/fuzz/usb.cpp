#include <array>

#include "hal/linux/usb/pmd_wire.h"
#include "tests/fuzz/fuzz_input.h"

// What a PMD camera on USB says of itself, of its clock, and a frame: any bytes. The input is 32
// bytes of info, 8 of clock, and the frame; where the info is none, a small camera's holds.
void stof::fuzz::run(std::span<const std::byte> input) {
  namespace usb = hal::linux;
  const std::size_t info_bytes = std::min(input.size(), usb::kPmdInfoBytes);
  const auto told = usb::parse_pmd_info(input.first(info_bytes));
  fuzz::require(!told ||
                (told->width >= 1 && told->width <= usb::kPmdMostSide && told->height >= 1 &&
                 told->height <= usb::kPmdMostSide && told->bits >= 10 && told->bits <= 15));
  input = input.subspan(info_bytes);
  const std::size_t clock_bytes = std::min(input.size(), usb::kPmdClockBytes);
  static_cast<void>(usb::parse_pmd_clock(input.first(clock_bytes)));
  input = input.subspan(clock_bytes);
  const usb::PmdInfo small{.width = 2, .height = 1, .bits = 12};
  for (const usb::PmdInfo& camera : std::array{small, told.value_or(small)}) {
    const auto header = usb::parse_pmd_frame(input, camera);
    if (!header) {
      continue;
    }
    fuzz::require(header->bytes >= usb::kPmdHeaderBytes &&
                  header->bytes <= usb::kPmdMostHeaderBytes && header->bytes % 2 == 0);
    fuzz::require(header->bytes + usb::pmd_picture_bytes(camera) == input.size());
    std::uint64_t end = 0;
    for (const usb::PmdSpan& sample : header->samples) {
      fuzz::require(sample.begin_ns >= end);
      end = std::uint64_t{sample.begin_ns} + sample.length_ns;
    }
  }
}
