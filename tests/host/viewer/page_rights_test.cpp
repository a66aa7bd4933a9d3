#include "host/viewer/page_rights.h"

#include <gtest/gtest.h>

namespace stof::viewer {
namespace {

constexpr std::uint32_t kMe = 1000;

TEST(PageRights, AreThoseOfThisMachinesUserAlone) {
  const AccessRules rules;
  const auto judged = [&](PageOrigin page) { return judge_page(rules, page, kMe); };
  EXPECT_EQ(judged({.loopback = true, .user = kMe, .names_origin = true}), PageRight::kGranted);
  EXPECT_EQ(judged({.loopback = true, .user = 0, .names_origin = true}), PageRight::kGranted);
  EXPECT_EQ(judged({.loopback = true, .user = 1001, .names_origin = true}), PageRight::kOtherUser);
  EXPECT_EQ(judged({.loopback = true, .user = {}, .names_origin = true}), PageRight::kOtherUser);
  EXPECT_EQ(judged({.loopback = true, .user = kMe, .names_origin = false}), PageRight::kNoPage);
  EXPECT_EQ(judged({.loopback = false, .user = kMe, .names_origin = true}),
            PageRight::kOtherMachine);
  EXPECT_EQ(judged({}), PageRight::kNoPage);
}

TEST(PageRights, OfOtherMachinesTakeAFlagOfTheirOwn) {
  const PageOrigin other{.loopback = false, .user = {}, .names_origin = true};
  EXPECT_EQ(judge_page({.token = "t", .any_address = true}, other, kMe), PageRight::kOtherMachine);
  EXPECT_EQ(judge_page({.token = "t", .lan_control = true, .any_address = true}, other, kMe),
            PageRight::kGranted);
  EXPECT_EQ(judge_page({.token = "t", .lan_control = true, .any_address = true}, {}, kMe),
            PageRight::kNoPage);
}

TEST(PageRights, PairingTakesAPageOfThisMachinesUserWhateverLetsOthersControl) {
  const PageOrigin mine{.loopback = true, .user = kMe, .names_origin = true};
  const PageOrigin elsewhere{.address = "192.0.2.7", .user = kMe, .names_origin = true};
  const PageOrigin others{.loopback = true, .user = 1001, .names_origin = true};
  EXPECT_EQ(judge_pairing(mine, kMe), PageRight::kGranted);
  EXPECT_EQ(judge_pairing(elsewhere, kMe), PageRight::kOtherMachine);
  EXPECT_EQ(judge_pairing(others, kMe), PageRight::kOtherUser);
  EXPECT_EQ(judge_pairing({.loopback = true, .user = kMe}, kMe), PageRight::kNoPage);
  for (const PageRight right :
       {PageRight::kOtherMachine, PageRight::kOtherUser, PageRight::kNoPage}) {
    EXPECT_STRNE(pairing_reason(right), "");
  }
  EXPECT_STREQ(pairing_reason(PageRight::kGranted), "");
  EXPECT_EQ(place_of(mine), "this computer");
  EXPECT_EQ(place_of(elsewhere), "192.0.2.7");
}

constexpr const char* kTable =
    "  sl  local_address rem_address   st tx_queue rx_queue tr tm->when retrnsmt   uid  timeout "
    "inode\n"
    "   0: 0100007F:1D92 00000000:0000 0A 00000000:00000000 00:00000000 00000000  1000        0 1\n"
    "   1: 0100007F:1D92 0100007F:CD6A 01 00000000:00000000 00:00000000 00000000  1000        0 2\n"
    "   2: 0100007F:CD6A 0100007F:1D92 01 00000000:00000000 00:00000000 00000000  1001        0 3\n"
    "   3: 0100007F:CD6B 0100007F:1D93 01 00000000:00000000 00:00000000 00000000  1002        0 4\n"
    "   4: 0200007F:CD6A 0100007F:1D92 01 00000000:00000000 00:00000000 00000000  1003        0 "
    "5\n";
constexpr std::uint32_t kLocal = 0x0100007F;  // as the table has it

TEST(PageRights, FindTheUserOfTheOtherEnd) {
  EXPECT_EQ(user_in(kTable, kLocal, 0xCD6A, 0x1D92), 1001U);
  EXPECT_EQ(user_in(kTable, 0x0200007F, 0xCD6A, 0x1D92), 1003U);
  EXPECT_EQ(user_in(kTable, kLocal, 0xCD6B, 0x1D92), std::nullopt);
  EXPECT_EQ(user_in(kTable, kLocal, 0xCD6A, 0x1D93), std::nullopt);
  // A browser's socket of IPv6.
  EXPECT_EQ(user_in("  7: 0000000000000000FFFF00000100007F:CD6A "
                    "0000000000000000FFFF00000100007F:1D92 01 00000000:00000000 00:00000000 "
                    "00000000 1004 0 3\n",
                    kLocal, 0xCD6A, 0x1D92),
            1004U);
  EXPECT_EQ(user_in("  7: 20010DB800000000000000000100007F:CD6A "
                    "0000000000000000FFFF00000100007F:1D92 01 00000000:00000000 00:00000000 "
                    "00000000 1004 0 3\n",
                    kLocal, 0xCD6A, 0x1D92),
            std::nullopt);
}

TEST(PageRights, ATableThatIsNoneNamesNobody) {
  for (const char* const table :
       {"", "\n\n", "x", " 2: 0100007F:CD6A", " 2: 0100007F:CD6A 0100007F:1D92",
        " 2: 0100007F:CD6A 0100007F:1D92 01 a b c", " 2: 0100007F:CD6A 0100007F:1D92 01 a b c x",
        " 2: 0100007F:CD6A 92 01 a b c 5",
        " 2: 0100007F:CD6A 0100007F:1D92 01 a b c 99999999999"}) {
    EXPECT_EQ(user_in(table, kLocal, 0xCD6A, 0x1D92), std::nullopt) << table;
  }
}

}  // namespace
}  // namespace stof::viewer
