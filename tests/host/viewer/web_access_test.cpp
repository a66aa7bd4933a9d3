#include "host/viewer/web_access.h"

#include <array>
#include <string>

#include <gtest/gtest.h>

namespace stof::viewer {
namespace {

const AccessRules kLocalRules{.host_name = "robot"};
const AccessRules kLan{.host_name = "robot", .token = "0123456789abcdef", .any_address = true};

Access of_host(const AccessRules& rules, std::string_view host) {
  return judge(rules, {.host = host, .token = rules.token});
}

TEST(WebAccessTest, TakesThisMachineByAnyOfItsNamesWithAnyPort) {
  for (const char* host :
       {"localhost", "LocalHost:7570", "127.0.0.1", "127.0.0.1:1", "[::1]", "[::1]:65535"}) {
    EXPECT_EQ(of_host(kLocalRules, host), Access::kGranted) << host;
    EXPECT_EQ(of_host(kLan, host), Access::kGranted) << host;
  }
}

TEST(WebAccessTest, RefusesNamesThatANameServerCouldAnswerFor) {
  for (const char* host : {"evil.example",
                           "localhost.evil.example",
                           "127.0.0.1.evil.example",
                           "localhost.",
                           "localhost:",
                           "localhost:x",
                           "localhost:123456",
                           "localhost:1:1",
                           ":80",
                           "[::1",
                           "[::1]x",
                           "[]",
                           "[localhost]",
                           "127.0.0.1,evil.example",
                           "127.1",
                           "0x7f000001",
                           "robots",
                           "robot.local.evil.example",
                           "robot.evil",
                           "127.0.0.1 ",
                           " "}) {
    EXPECT_EQ(of_host(kLocalRules, host), Access::kForeignHost) << host;
    EXPECT_EQ(of_host(kLan, host), Access::kForeignHost) << host;
  }
  EXPECT_EQ(of_host(kLan, std::string(100'000, '1')), Access::kForeignHost);
  EXPECT_EQ(of_host(kLocalRules, ""), Access::kNoHost);
}

TEST(WebAccessTest, TakesOtherAddressesOnlyWhereOthersMayLook) {
  for (const char* host :
       {"192.168.1.20", "10.0.0.1:7570", "[fe80::1]:7570", "robot", "ROBOT.local:80"}) {
    EXPECT_EQ(of_host(kLocalRules, host), Access::kForeignHost) << host;
    EXPECT_EQ(of_host(kLan, host), Access::kGranted) << host;
  }
}

TEST(WebAccessTest, RefusesPagesOfOtherOrigins) {
  const auto from = [](std::string_view origin) {
    return judge(kLocalRules, {.host = "localhost:7570", .origin = origin});
  };
  EXPECT_EQ(from("http://localhost:7570"), Access::kGranted);
  EXPECT_EQ(from(""), Access::kGranted);
  for (const char* origin :
       {"http://localhost", "http://localhost:7571", "https://localhost:7570",
        "http://evil.example", "http://127.0.0.1:7570", "null", "http://", "file://",
        "http://localhost:7570/", "http://localhost:7570,http://evil.example"}) {
    EXPECT_EQ(from(origin), Access::kForeignPage) << origin;
  }
}

TEST(WebAccessTest, AFoxgloveOfANamedOriginMayLookByItsProtocolAlone) {
  AccessRules rules = kLocalRules;
  rules.foxglove_origins = {"https://app.foxglove.dev"};
  WebRequest request{.host = "localhost:7570", .origin = "https://app.foxglove.dev"};
  EXPECT_EQ(judge(rules, request), Access::kForeignPage);
  request.foxglove = true;
  EXPECT_EQ(judge(rules, request), Access::kGranted);
  EXPECT_EQ(judge(kLocalRules, request), Access::kForeignPage);
  for (const char* origin : {"http://app.foxglove.dev", "https://app.foxglove.dev:444",
                             "https://app.foxglove.dev.evil.example", "null"}) {
    request.origin = origin;
    EXPECT_EQ(judge(rules, request), Access::kForeignPage) << origin;
  }
  request.origin = "https://app.foxglove.dev";
  request.host = "evil.example";
  EXPECT_EQ(judge(rules, request), Access::kForeignHost);
}

TEST(WebAccessTest, WantsTheWholeToken) {
  const auto with = [](std::string_view token) {
    return judge(kLan, {.host = "localhost", .token = token});
  };
  EXPECT_EQ(with(kLan.token), Access::kGranted);
  for (const char* token : {"", "0", "0123456789abcde", "0123456789abcdeF", "0123456789abcdef0"}) {
    EXPECT_EQ(with(token), Access::kNoToken) << token;
  }
}

TEST(WebAccessTest, TokensAreRandom) {
  const std::string one = random_token();
  EXPECT_EQ(one.size(), 32U);
  EXPECT_EQ(one.find_first_not_of("0123456789abcdef"), std::string::npos);
  EXPECT_NE(one, random_token());
}

TEST(WebAccessTest, SaysWhyInOneLine) {
  for (const Access access :
       {Access::kNoHost, Access::kForeignHost, Access::kForeignPage, Access::kNoToken}) {
    EXPECT_NE(std::string(reason(access)), "");
    EXPECT_EQ(std::string(reason(access)).find('\n'), std::string::npos);
  }
}

}  // namespace
}  // namespace stof::viewer
