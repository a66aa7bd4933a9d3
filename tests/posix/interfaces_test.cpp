#include "posix/interfaces.h"

#include <algorithm>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <net/if.h>

namespace stof::posix {
namespace {

in_addr ipv4(const char* text) {
  in_addr address{};
  EXPECT_EQ(inet_pton(AF_INET, text, &address), 1);
  return address;
}

bool has_loopback() {
  return std::ranges::any_of(interface_entries(), [](const InterfaceEntry& entry) {
    return entry.address && entry.address->host() == "127.0.0.1";
  });
}

TEST(Interfaces, EntriesNameTheirInterfaceWithItsAddress) {
  const std::vector<InterfaceEntry> all = interface_entries();
  const auto loopback = std::ranges::find_if(all, [](const InterfaceEntry& entry) {
    return entry.address && entry.address->host() == "127.0.0.1";
  });
  if (loopback == all.end()) {
    GTEST_SKIP() << "this machine has no 127.0.0.1";
  }
  EXPECT_EQ(loopback->index, if_nametoindex(loopback->name.c_str()));
  EXPECT_NE(loopback->flags & IFF_LOOPBACK, 0U);
  EXPECT_EQ(loopback->address->family(), AF_INET);
  EXPECT_FALSE(loopback->broadcast.has_value());
}

TEST(Interfaces, OwnAddressesAreThoseOfTheInterfacesAlone) {
  if (!has_loopback()) {
    GTEST_SKIP() << "this machine has no 127.0.0.1";
  }
  EXPECT_TRUE(is_own_address(ipv4("127.0.0.1")));
  EXPECT_FALSE(is_own_address(ipv4("203.0.113.7")));  // of documents alone, RFC 5737
}

TEST(Interfaces, NoWayToNeighboursLeadsThroughLoopback) {
  const Interfaces ways = list_interfaces();
  for (const InterfaceEntry& entry : interface_entries()) {
    if ((entry.flags & IFF_LOOPBACK) != 0) {
      EXPECT_EQ(std::ranges::find(ways.links, entry.index), ways.links.end()) << entry.name;
    }
  }
}

}  // namespace
}  // namespace stof::posix
