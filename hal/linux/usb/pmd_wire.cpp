#include "hal/linux/usb/pmd_wire.h"

namespace stof::hal::linux {
namespace {

template <typename T>
T get(std::span<const std::byte> bytes, std::size_t at) noexcept {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    value |= std::to_integer<std::uint64_t>(bytes[at + i]) << (8 * i);
  }
  return static_cast<T>(value);
}

template <typename T>
void put(std::span<std::byte> bytes, std::size_t at, T value) noexcept {
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    bytes[at + i] = static_cast<std::byte>(static_cast<std::uint64_t>(value) >> (8 * i));
  }
}

bool good_side(int side) noexcept { return side >= 1 && side <= kPmdMostSide; }

// One after the other, each of some length.
bool in_order(const std::array<PmdSpan, 4>& samples) noexcept {
  std::uint32_t end = 0;
  for (const PmdSpan& sample : samples) {
    if (sample.begin_ns < end || sample.begin_ns > kPmdMostExposureNs || sample.length_ns == 0 ||
        sample.length_ns > kPmdMostExposureNs) {
      return false;
    }
    end = sample.begin_ns + sample.length_ns;
  }
  return true;
}

}  // namespace

std::optional<PmdInfo> parse_pmd_info(std::span<const std::byte> bytes) noexcept {
  if (bytes.size() != kPmdInfoBytes || get<std::uint32_t>(bytes, 0) != kPmdInfoMagic ||
      get<std::uint16_t>(bytes, 4) != kPmdVersion) {
    return std::nullopt;
  }
  const PmdInfo info{.width = get<std::uint16_t>(bytes, 6),
                     .height = get<std::uint16_t>(bytes, 8),
                     .bits = get<std::uint16_t>(bytes, 10),
                     .least_khz = get<std::uint32_t>(bytes, 12),
                     .most_khz = get<std::uint32_t>(bytes, 16),
                     .least_integration_us = get<std::uint32_t>(bytes, 20),
                     .most_integration_us = get<std::uint32_t>(bytes, 24),
                     .serial = get<std::uint32_t>(bytes, 28)};
  const bool good = good_side(info.width) && good_side(info.height) && info.bits >= 10 &&
                    info.bits <= 15 && info.least_khz >= 1 && info.least_khz <= info.most_khz &&
                    info.least_integration_us >= 1 &&
                    info.least_integration_us <= info.most_integration_us;
  return good ? std::optional(info) : std::nullopt;
}

std::optional<std::uint64_t> parse_pmd_clock(std::span<const std::byte> bytes) noexcept {
  return bytes.size() == kPmdClockBytes ? std::optional(get<std::uint64_t>(bytes, 0))
                                        : std::nullopt;
}

std::optional<PmdHeader> parse_pmd_frame(std::span<const std::byte> bytes,
                                         const PmdInfo& info) noexcept {
  if (bytes.size() < kPmdHeaderBytes || get<std::uint32_t>(bytes, 0) != kPmdFrameMagic ||
      get<std::uint16_t>(bytes, 6) != kPmdVersion || get<std::uint16_t>(bytes, 12) != info.width ||
      get<std::uint16_t>(bytes, 14) != info.height || get<std::uint16_t>(bytes, 16) != info.bits) {
    return std::nullopt;
  }
  PmdHeader header{.sequence = get<std::uint32_t>(bytes, 8),
                   .flags = get<std::uint16_t>(bytes, 18),
                   .modulation_khz = get<std::uint32_t>(bytes, 20),
                   .edge = get<std::uint64_t>(bytes, 24),
                   .samples = {},
                   .temperature = get<std::int16_t>(bytes, 64),
                   .bytes = get<std::uint16_t>(bytes, 4)};
  for (std::size_t k = 0; k < header.samples.size(); ++k) {
    header.samples[k] = {.begin_ns = get<std::uint32_t>(bytes, 32 + 8 * k),
                         .length_ns = get<std::uint32_t>(bytes, 36 + 8 * k)};
  }
  const bool good = header.bytes >= kPmdHeaderBytes && header.bytes <= kPmdMostHeaderBytes &&
                    header.bytes % 2 == 0 &&
                    bytes.size() == header.bytes + pmd_picture_bytes(info) &&
                    in_order(header.samples);
  return good ? std::optional(header) : std::nullopt;
}

std::array<std::byte, kPmdConfigBytes> compose_pmd_config(const PmdConfig& config) noexcept {
  std::array<std::byte, kPmdConfigBytes> bytes{};
  put(bytes, 0, config.modulation_khz);
  put(bytes, 4, config.integration_us);
  put(bytes, 8, config.delay_us);
  return bytes;
}

}  // namespace stof::hal::linux
