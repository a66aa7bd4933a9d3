#include "hal/linux/v4l2/grey_formats.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "dsp/base/check.h"

namespace stof::hal::linux {
namespace {

static_assert(std::endian::native == std::endian::little);

// Rows come from a driver, whose strides may be odd.
std::uint16_t load(const std::uint8_t* from) noexcept {
  std::uint16_t value = 0;
  std::memcpy(&value, from, sizeof value);
  return value;
}

template <int kShift>
void shift(const std::uint8_t* row, std::span<std::uint8_t> out) noexcept {
  for (std::size_t x = 0; x < out.size(); ++x) {
    const int value = load(row + 2 * x) >> kShift;
    out[x] = static_cast<std::uint8_t>(std::min(value, 255));
  }
}

void unpack_y12p(const std::uint8_t* row, std::span<std::uint16_t> out) noexcept {
  for (std::size_t x = 0; x + 1 < out.size(); x += 2) {
    const std::uint8_t* const three = row + x / 2 * 3;
    out[x] = static_cast<std::uint16_t>(three[0] << 4 | (three[2] & 0x0F));
    out[x + 1] = static_cast<std::uint16_t>(three[1] << 4 | three[2] >> 4);
  }
}

}  // namespace

std::string to_string(FourCc format) {
  std::string name;
  for (int i = 0; i < 4; ++i) {
    const char letter = static_cast<char>(format >> (8 * i) & 0x7F);
    name += letter >= ' ' && letter <= '~' ? letter : '.';
  }
  return name.erase(name.find_last_not_of(' ') + 1);
}

std::size_t row_bytes(FourCc format, int width) noexcept {
  const std::size_t pixels = width > 0 ? static_cast<std::size_t>(width) : 0;
  switch (format) {
    case kGrey:
      return pixels;
    case kY10:
    case kY12:
    case kY16:
      return 2 * pixels;
    case kYuyv:  // pairs of pixels share their colour
      return pixels % 2 == 0 ? 2 * pixels : 0;
    case kY12p:
      return pixels % 2 == 0 ? pixels / 2 * 3 : 0;
    default:
      return 0;
  }
}

void to_grey(FourCc format, std::span<const std::uint8_t> row,
             std::span<std::uint8_t> out) noexcept {
  switch (format) {
    case kGrey:
      STOF_CHECK(row.size() >= out.size());
      std::ranges::copy(row.first(out.size()), out.begin());
      return;
    case kYuyv:
      STOF_CHECK(row.size() >= 2 * out.size());
      for (std::size_t x = 0; x < out.size(); ++x) {
        out[x] = row[2 * x];
      }
      return;
    default:
      break;
  }
  STOF_CHECK(format == kY10 || format == kY12 || format == kY16);
  STOF_CHECK(row.size() >= 2 * out.size());
  if (format == kY10) {
    shift<2>(row.data(), out);
  } else if (format == kY12) {
    shift<4>(row.data(), out);
  } else {
    shift<8>(row.data(), out);
  }
}

void to_samples(FourCc format, std::span<const std::uint8_t> row,
                std::span<std::uint16_t> out) noexcept {
  if (format == kY12p) {
    STOF_CHECK(out.size() % 2 == 0 && row.size() >= out.size() / 2 * 3);
    unpack_y12p(row.data(), out);
    return;
  }
  STOF_CHECK(format == kY10 || format == kY12 || format == kY16);
  STOF_CHECK(row.size() >= 2 * out.size());
  std::memcpy(out.data(), row.data(), 2 * out.size());
}

}  // namespace stof::hal::linux
