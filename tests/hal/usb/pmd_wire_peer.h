#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "firmware/wire/bytes.h"
#include "hal/linux/usb/pmd_wire.h"

// The camera's side of hal/linux/usb/pmd_wire.h.
namespace stof::hal::linux {

template <typename T>
void put(std::span<std::byte> bytes, std::size_t at, T value) noexcept {
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    bytes[at + i] = static_cast<std::byte>(static_cast<std::uint64_t>(value) >> (8 * i));
  }
}

inline std::optional<PmdConfig> parse_pmd_config(std::span<const std::byte> bytes) noexcept {
  if (bytes.size() != kPmdConfigBytes || wire::get_u32(bytes.subspan<12, 4>()) != 0) {
    return std::nullopt;
  }
  return PmdConfig{.modulation_khz = wire::get_u32(bytes.subspan<0, 4>()),
                   .integration_us = wire::get_u32(bytes.subspan<4, 4>()),
                   .delay_us = wire::get_u32(bytes.subspan<8, 4>())};
}

inline std::array<std::byte, kPmdInfoBytes> compose_pmd_info(const PmdInfo& info) noexcept {
  std::array<std::byte, kPmdInfoBytes> bytes{};
  put(bytes, 0, kPmdInfoMagic);
  put(bytes, 4, kPmdVersion);
  put(bytes, 6, static_cast<std::uint16_t>(info.width));
  put(bytes, 8, static_cast<std::uint16_t>(info.height));
  put(bytes, 10, static_cast<std::uint16_t>(info.bits));
  put(bytes, 12, info.least_khz);
  put(bytes, 16, info.most_khz);
  put(bytes, 20, info.least_integration_us);
  put(bytes, 24, info.most_integration_us);
  put(bytes, 28, info.serial);
  return bytes;
}

inline std::array<std::byte, kPmdHeaderBytes> compose_pmd_header(const PmdHeader& header,
                                                                 const PmdInfo& info) noexcept {
  std::array<std::byte, kPmdHeaderBytes> bytes{};
  put(bytes, 0, kPmdFrameMagic);
  put(bytes, 4, static_cast<std::uint16_t>(header.bytes));
  put(bytes, 6, kPmdVersion);
  put(bytes, 8, header.sequence);
  put(bytes, 12, static_cast<std::uint16_t>(info.width));
  put(bytes, 14, static_cast<std::uint16_t>(info.height));
  put(bytes, 16, static_cast<std::uint16_t>(info.bits));
  put(bytes, 18, header.flags);
  put(bytes, 20, header.modulation_khz);
  put(bytes, 24, header.edge);
  for (std::size_t k = 0; k < header.samples.size(); ++k) {
    put(bytes, 32 + 8 * k, header.samples[k].begin_ns);
    put(bytes, 36 + 8 * k, header.samples[k].length_ns);
  }
  put(bytes, 64, header.temperature);
  return bytes;
}

}  // namespace stof::hal::linux
