#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "host/viewer/web_access.h"

// Whether a page may have something done beside looking: only one of this machine and of the user
// whose program this is, whose keys it would use. AccessRules::lan_control lets others use these
// keys, and make none.
namespace stof::viewer {

// What is known of the other end of a connection.
struct PageOrigin {
  bool loopback = false;                // its address
  std::string address{};                // "192.0.2.7"
  std::optional<std::uint32_t> user{};  // of the program that holds it; none: nobody knows
  bool names_origin = false;            // it sent the header Origin, as browsers do
};

enum class PageRight : std::uint8_t {
  kGranted,
  kOtherMachine,  // and AccessRules::lan_control is not set
  kOtherUser,
  kNoPage,  // no header Origin: no browser's page
};
// One line: why not, and what to do; empty where it is granted.
const char* reason(PageRight right) noexcept;

// user: who runs this program. The superuser, 0, may as well: he could anyway.
PageRight judge_page(const AccessRules& rules, const PageOrigin& page, std::uint32_t user) noexcept;

// Whether it may pair with the sensor, which gives the user a key: as judge_page() where nothing
// lets others.
PageRight judge_pairing(const PageOrigin& page, std::uint32_t user) noexcept;
// One line: why it may not pair; empty where it may.
const char* pairing_reason(PageRight right) noexcept;

// "this computer", or its address: what pages are told of who began something.
std::string place_of(const PageOrigin& page);

// A line of /proc/net/tcp: the user of the connection from 127.x.y.z:from to this program's port
// `to`. table: its text, or that of tcp6.
std::optional<std::uint32_t> user_in(std::string_view table, std::uint32_t from_address,
                                     std::uint16_t from, std::uint16_t to);

// Of a connected TCP socket of IPv4: its other end. Reads /proc/net.
PageOrigin origin_of(int socket);

}  // namespace stof::viewer
