#include "firmware/settings/fields/network_text.h"

#include <algorithm>

#include "dsp/base/parse_number.h"

namespace stof::settings {
namespace {

constexpr int kLeastPrefixBits = 8;
constexpr int kMostPrefixBits = 30;

// Of 0 to `most`, written in the one way.
std::optional<std::uint32_t> plain_number(std::string_view text, std::uint32_t most) noexcept {
  const bool plain = text.size() == 1 || !text.starts_with('0');
  const auto number = dsp::parse_number<std::uint32_t>(text);
  return plain && number && *number <= most ? number : std::nullopt;
}

// 0.0.0.0/8, 127.0.0.0/8, and all from 224.0.0.0 on.
bool is_of_a_host(std::uint32_t address) noexcept {
  const std::uint32_t first = address >> 24U;
  return first != 0 && first != 127 && first < 224;
}

}  // namespace

bool InterfaceAddress::has_host(std::uint32_t other) const noexcept {
  const std::uint32_t host = other & ~mask();
  return ((other ^ address) & mask()) == 0 && host != 0 && host != ~mask();
}

std::optional<std::uint32_t> parse_ipv4(std::string_view text) noexcept {
  std::uint32_t address = 0;
  for (int place = 0; place < 4; ++place) {
    const std::size_t dot = text.find('.');
    if ((place == 3) != (dot == std::string_view::npos)) {
      return std::nullopt;
    }
    const auto number = plain_number(text.substr(0, dot), 255);
    if (!number) {
      return std::nullopt;
    }
    address = address << 8U | *number;
    text.remove_prefix(place == 3 ? text.size() : dot + 1);
  }
  return address;
}

std::optional<InterfaceAddress> parse_interface_address(std::string_view text) noexcept {
  const std::size_t slash = text.find('/');
  if (slash == std::string_view::npos) {
    return std::nullopt;
  }
  const auto address = parse_ipv4(text.substr(0, slash));
  const auto bits = plain_number(text.substr(slash + 1), kMostPrefixBits);
  if (!address || !bits || *bits < kLeastPrefixBits || !is_of_a_host(*address)) {
    return std::nullopt;
  }
  const InterfaceAddress found{.address = *address, .prefix_bits = static_cast<int>(*bits)};
  return found.has_host(found.address) ? std::optional(found) : std::nullopt;
}

bool is_hostname(std::string_view text) noexcept {
  const auto takes = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-';
  };
  return !text.empty() && text.size() <= kHostnameBytes && std::ranges::all_of(text, takes) &&
         !text.starts_with('-') && !text.ends_with('-');
}

const char* problem(const NetworkSettings& network) noexcept {
  const auto address = parse_interface_address(network.address.view());
  if (!address && !network.dhcp && !network.link_local) {
    return "network: leaves the sensor without an address: give network.address, or keep "
           "network.dhcp or network.link_local";
  }
  const auto gateway = parse_ipv4(network.gateway.view());
  if (!gateway) {
    return "";
  }
  if (!address) {
    return "network.gateway: takes a network.address beside it; with network.dhcp alone the server "
           "names it";
  }
  return *gateway != address->address && address->has_host(*gateway)
             ? ""
             : "network.gateway: takes another address of the network of network.address";
}

}  // namespace stof::settings
