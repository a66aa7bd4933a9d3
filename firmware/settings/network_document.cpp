#include "firmware/settings/network_document.h"

#include <array>
#include <cstddef>
#include <span>

#include "firmware/settings/permission.h"

namespace stof::settings {
namespace {

constexpr std::size_t kMostAddresses = 8;  // that are told

}  // namespace

wire::SettingsResult write_network(hal::NetworkInterfaces* interfaces, firmware::Access access,
                                   PagedWriter& out) noexcept {
  if (access < firmware::Access::kAdmin) {
    static_cast<void>(deny("network", access, firmware::Access::kAdmin, out));
    return wire::SettingsResult::kDenied;
  }
  if (interfaces == nullptr) {
    return wire::SettingsResult::kUnsupported;
  }
  std::array<hal::InterfaceAddress, 2 * kMostAddresses> all;  // of IPv6, too
  std::size_t told = 0;
  out << R"({"ipv4": [)";
  for (const hal::InterfaceAddress& one : std::span(all).first(interfaces->addresses(all))) {
    if (!hal::is_ipv4(one.address) || one.address[12] == 127 || told == kMostAddresses) {
      continue;
    }
    out << (told++ == 0 ? "\"" : ", \"") << one.address[12] << '.' << one.address[13] << '.'
        << one.address[14] << '.' << one.address[15] << '"';
  }
  out << "]}";
  return wire::SettingsResult::kOk;
}

}  // namespace stof::settings
