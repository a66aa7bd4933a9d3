#include <array>
#include <vector>

#include "firmware/wire/calibration/calibration_file.h"
#include "tests/fuzz/fuzz_input.h"

// A calibration file. First byte odd: magic, length and CRC of what follows are set right.
namespace stof {
namespace {

constexpr std::size_t kMostPattern = 1024;
constexpr std::size_t kLeast = 20;  // header and CRC

void seal(std::vector<std::byte>& file) {
  if (file.size() >= kLeast) {
    const std::span<std::byte> bytes(file);
    wire::put_u64(bytes.first<8>(), 0x004c'4143'464f'5453);
    wire::put_u32(bytes.subspan(12).first<4>(), static_cast<std::uint32_t>(file.size()));
    wire::put_u32(bytes.last<4>(), wire::crc32c(bytes.first(file.size() - wire::kCrcBytes)));
  }
}

// What was read says the same when it is written and read again.
void judge(std::span<const std::byte> file) {
  std::array<std::int16_t, kMostPattern> pattern{};
  const Result<dsp::Calibration> read = wire::decode_calibration_file(file, pattern);
  if (!read) {
    return;
  }
  std::vector<std::byte> once(wire::calibration_file_bytes(*read));
  fuzz::require(wire::encode_calibration_file(*read, once) == once.size());
  std::array<std::int16_t, kMostPattern> again_pattern{};
  const Result<dsp::Calibration> again = wire::decode_calibration_file(once, again_pattern);
  fuzz::require(again.has_value());
  std::vector<std::byte> twice(wire::calibration_file_bytes(*again));
  fuzz::require(wire::encode_calibration_file(*again, twice) == twice.size());
  fuzz::require(once == twice);
}

}  // namespace
}  // namespace stof

void stof::fuzz::run(std::span<const std::byte> input) {
  if (input.empty()) {
    return;
  }
  std::vector<std::byte> file(input.begin() + 1, input.end());
  if (wire::get_u8(input.first<1>()) % 2 != 0) {
    seal(file);
  }
  judge(file);
}
