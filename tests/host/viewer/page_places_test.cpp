#include "host/viewer/page_places.h"

#include <gtest/gtest.h>

namespace stof::viewer {
namespace {

constexpr std::uint32_t kUser = 1000;

PageOrigin of_user(std::uint32_t user) { return {.loopback = true, .user = user}; }
PageOrigin of_address(const char* address) { return {.address = address}; }

class PagePlacesTest : public testing::Test {
 protected:
  // How many of a hundred that come and stay get a place.
  int crowd(const PageOrigin& who) {
    int taken = 0;
    for (int i = 0; i < 100; ++i) {
      taken += places_.take(who) ? 1 : 0;
    }
    return taken;
  }
  PagePlaces places_{{}, kUser};
};

TEST_F(PagePlacesTest, ACrowdOfOneAddressLocksNobodyOut) {
  EXPECT_EQ(crowd(of_address("192.0.2.7")), 4);
  EXPECT_TRUE(places_.has_room_for(of_address("192.0.2.8")));
  EXPECT_TRUE(places_.has_room_for(of_user(kUser)));
}

TEST_F(PagePlacesTest, CrowdsOfManyAddressesLeaveTheUserPlaces) {
  EXPECT_EQ(crowd(of_address("192.0.2.7")) + crowd(of_address("192.0.2.8")) +
                crowd(of_address("192.0.2.9")),
            6);
  EXPECT_EQ(crowd(of_user(kUser)), 2);
  EXPECT_FALSE(places_.has_room_for(of_user(kUser)));
}

TEST_F(PagePlacesTest, AnotherUserOfThisMachineIsNoOwnOne) {
  EXPECT_EQ(crowd(of_user(1001)), 4);
  EXPECT_EQ(crowd({.loopback = true}), 2);  // nobody knows whose
  EXPECT_EQ(crowd(of_user(0)), 2);          // the superuser may all
}

TEST_F(PagePlacesTest, APlaceThatIsGivenBackIsTheNexts) {
  EXPECT_EQ(crowd(of_user(kUser)), 8);
  EXPECT_FALSE(places_.take(of_address("192.0.2.7")));
  places_.give_back(of_user(kUser));
  EXPECT_TRUE(places_.take(of_address("192.0.2.7")));
  places_.give_back(of_address("192.0.2.7"));
  places_.give_back(of_address("192.0.2.7"));  // has none
  EXPECT_TRUE(places_.take(of_user(kUser)));
  EXPECT_FALSE(places_.take(of_user(kUser)));
}

}  // namespace
}  // namespace stof::viewer
