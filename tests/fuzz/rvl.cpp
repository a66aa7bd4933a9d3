#include <algorithm>
#include <vector>

#include "firmware/wire/codec/rvl_decode.h"
#include "firmware/wire/codec/rvl_encode.h"
#include "tests/fuzz/fuzz_input.h"

// Input: kind, a number, bytes. Kind 0 and 1: code of that many values of 16 or 8 bits. Kind 2 and
// 3: values of 16 or 8 bits, to be coded into that many bytes.
namespace stof {
namespace {

constexpr std::size_t kMostValues = 4096;

template <typename T>
void decode(std::size_t count, std::span<const std::byte> code) {
  std::vector<T> values(std::min(count, kMostValues));
  if (wire::rvl_decode<T>(code, values) != Status::kOk) {
    return;
  }
  std::vector<std::byte> space(4 * (3 * values.size() + 8));
  const wire::RvlCoded coded = wire::rvl_encode<T>(values, space);
  fuzz::require(coded.values == values.size());
  std::vector<T> again(values.size());
  fuzz::require(wire::rvl_decode<T>(std::span(space).first(coded.bytes), again) == Status::kOk);
  fuzz::require(again == values);
}

template <typename T>
void encode(std::size_t room, std::span<const std::byte> bytes) {
  std::vector<T> values(bytes.size() / sizeof(T));
  wire::get_pixels<T>(bytes.first(values.size() * sizeof(T)), values);
  std::vector<std::byte> space(std::min<std::size_t>(room, wire::kMaxPayload));
  const wire::RvlCoded coded = wire::rvl_encode<T>(values, space);
  fuzz::require(coded.values <= values.size() && coded.bytes <= space.size() &&
                coded.bytes % 4 == 0);
  std::vector<T> again(coded.values);
  fuzz::require(wire::rvl_decode<T>(std::span(space).first(coded.bytes), again) == Status::kOk);
  fuzz::require(std::ranges::equal(again, std::span(values).first(coded.values)));
}

}  // namespace
}  // namespace stof

void stof::fuzz::run(std::span<const std::byte> input) {
  if (input.size() < 3) {
    return;
  }
  const std::size_t number = wire::get_u16(input.subspan(1).first<2>());
  switch (wire::get_u8(input.first<1>()) % 4) {
    case 0:
      decode<std::uint16_t>(number, input.subspan(3));
      break;
    case 1:
      decode<std::uint8_t>(number, input.subspan(3));
      break;
    case 2:
      encode<std::uint16_t>(number, input.subspan(3));
      break;
    default:
      encode<std::uint8_t>(number, input.subspan(3));
      break;
  }
}
