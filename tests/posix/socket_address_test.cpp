#include "posix/socket_address.h"

#include <optional>
#include <string>
#include <string_view>

#include <gtest/gtest.h>

#include "tests/support/loopback.h"

namespace stof::posix {
namespace {

// "HOST PORT"; empty: refused.
std::string split(std::string_view text, std::uint16_t default_port = 0) {
  const std::optional<HostPort> parts = split_host_port(text, default_port);
  return parts ? parts->host + " " + std::to_string(parts->port) : "";
}

TEST(SplitHostPort, TakesNamesNumbersAndBrackets) {
  EXPECT_EQ(split("robot:7560"), "robot 7560");
  EXPECT_EQ(split("192.168.1.20:1"), "192.168.1.20 1");
  EXPECT_EQ(split("[fe80::1%eth0]:65535"), "fe80::1%eth0 65535");
}

TEST(SplitHostPort, TakesTheDefaultPortWhereThereIsOne) {
  EXPECT_EQ(split("robot", 9), "robot 9");
  EXPECT_EQ(split("robot:8", 9), "robot 8");
  EXPECT_EQ(split("::1", 9), "::1 9");
  EXPECT_EQ(split("[::1]", 9), "::1 9");
}

TEST(SplitHostPort, RefusesWhatIsNoPlace) {
  for (const char* const text : {"", ":", ":1", "a:", "a:0", "a:65536", "a:1x", "a:-1", "a:+1",
                                 "[]:1", "[::1:1", "[::1]1", "[::1]x:1"}) {
    EXPECT_EQ(split(text), "") << text;
    EXPECT_EQ(split(text, 9), "") << text;
  }
  EXPECT_EQ(split("robot"), "");
  EXPECT_EQ(split("::1:7560"), "");  // which of both would be the port?
}

TEST(SocketAddress, SaysWhatItIs) {
  EXPECT_EQ(test::loopback_address(7560).text(), "127.0.0.1:7560");
  EXPECT_EQ(test::loopback_address(7560).host(), "127.0.0.1");
  EXPECT_EQ(make_address(in6addr_loopback, 1).text(), "[::1]:1");
  EXPECT_EQ(make_address(in6addr_loopback, 65'535).port(), 65'535);
  EXPECT_EQ(test::loopback_address(1), test::loopback_address(1));
  EXPECT_FALSE(test::loopback_address(1) == test::loopback_address(2));
  EXPECT_FALSE(test::loopback_address(1) == make_address(in6addr_loopback, 1));
}

TEST(Resolve, FindsNames) {
  if (!test::knows_localhost()) {
    GTEST_SKIP() << test::kNoLocalhost;
  }
  EXPECT_TRUE(resolve({.host = "localhost", .port = 5}, Names::kLookUp));
}

TEST(Resolve, FindsAddresses) {
  const auto literal = resolve({.host = "127.0.0.1", .port = 5}, Names::kAddressesOnly);
  ASSERT_TRUE(literal);
  EXPECT_EQ(literal->front(), test::loopback_address(5));
  const auto name = resolve({.host = "localhost", .port = 5}, Names::kAddressesOnly);
  ASSERT_FALSE(name);
  EXPECT_FALSE(name.error().empty());
  EXPECT_FALSE(resolve({.host = "", .port = 5}, Names::kAddressesOnly));
}

}  // namespace
}  // namespace stof::posix
