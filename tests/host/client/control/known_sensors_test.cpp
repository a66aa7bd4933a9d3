#include "host/client/control/known_sensors.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "tests/firmware/keys/some_keys.h"

namespace stof::client {
namespace {

constexpr std::uint32_t kFront = 1;  // also of its key
constexpr std::uint32_t kRear = 2;
constexpr Place kFrontPlace{.named = "127.0.0.1:7001", .address = "127.0.0.1:7001"};
constexpr Place kRearPlace{.named = "127.0.0.1", .address = "127.0.0.1:7560"};

class KnownSensorsTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = (std::filesystem::temp_directory_path() / "stof_known_sensors_XXXXXX").string();
    ASSERT_NE(mkdtemp(folder_.data()), nullptr);
    file_ = folder_ + "/keys";
    add(1, kFront);
    add(2, kRear);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  void add(std::uint32_t id, std::uint32_t device) {
    wire::Key key = test::numbered_key(id);
    key.device = device;
    ASSERT_EQ(keys_.add(key), Status::kOk);
  }
  Meant meant(std::string_view named, std::optional<std::uint32_t> asked = {}) const {
    const auto found = meant_sensor(file_, keys_, named, {.device = asked});
    EXPECT_TRUE(found) << found.error().message;
    return found.value_or(Meant{});
  }
  void remember(const Place& place, std::uint32_t device) const {
    const auto kept = remember_sensor(file_, keys_, place, device);
    ASSERT_TRUE(kept) << kept.error().message;
  }

  std::string folder_;
  std::string file_;
  wire::KeyTable keys_;
};

TEST_F(KnownSensorsTest, OfSeveralTheOneThatWasProvenThereIsMeant) {
  remember(kFrontPlace, kFront);
  remember(kRearPlace, kRear);
  EXPECT_EQ(meant("127.0.0.1:7001").device, kFront);
  EXPECT_EQ(meant("127.0.0.1").device, kRear);
  EXPECT_EQ(meant("127.0.0.1:7560").device, kRear) << "the port may be left out";
  EXPECT_TRUE(meant("127.0.0.1:7001").doubt.empty());
}

TEST_F(KnownSensorsTest, OfSeveralNobodyIsMeantWhereNoneWasProven) {
  remember(kFrontPlace, kFront);
  const Meant nobody = meant("127.0.0.1:7002");
  EXPECT_FALSE(nobody.device);
  EXPECT_NE(nobody.doubt.find("several sensors (1, 2)"), std::string::npos) << nobody.doubt;
  EXPECT_FALSE(meant("").doubt.empty()) << "a serial line";
}

TEST_F(KnownSensorsTest, WhoNamesOneMeansThatOne) {
  remember(kFrontPlace, kFront);
  for (const char* const named : {"127.0.0.1:7001", "127.0.0.1:7002"}) {
    EXPECT_EQ(meant(named, 9).device, 9U);
    EXPECT_TRUE(meant(named, 9).doubt.empty());
  }
}

// Nobody is locked out where addresses change: one that was named and proven is the one from then
// on.
TEST_F(KnownSensorsTest, AnAddressThatChangedIsAnothersOnceThatOneIsProvenThere) {
  remember(kFrontPlace, kFront);
  remember(kFrontPlace, kRear);
  EXPECT_EQ(meant("127.0.0.1:7001").device, kRear);
}

TEST_F(KnownSensorsTest, ANameCountsBeforeTheAddressThatItHasNow) {
  remember(kFrontPlace, kFront);
  remember({.named = "LocalHost:7001", .address = "127.0.0.2:7001"}, kRear);
  EXPECT_EQ(meant("localhost:7001").device, kRear);
  EXPECT_EQ(meant("127.0.0.1:7001").device, kFront);
  remember({.named = "elsewhere", .address = "127.0.0.1:7003"}, kRear);
  EXPECT_FALSE(meant("localhost:7003").device) << "a name leads where whoever answers for it wants";
  EXPECT_EQ(meant("[::ffff:7f00:1]:7001").device, meant("[::ffff:127.0.0.1]:7001").device);
}

TEST_F(KnownSensorsTest, KeysOfOneSensorNeedNoName) {
  keys_ = {};
  EXPECT_FALSE(meant("127.0.0.1:7001").device);
  EXPECT_TRUE(meant("127.0.0.1:7001").doubt.empty());
  add(1, kFront);
  add(3, kFront);
  EXPECT_FALSE(meant("127.0.0.1:7001").device);
  EXPECT_TRUE(meant("127.0.0.1:7001").doubt.empty());
  remember(kFrontPlace, kFront);
  EXPECT_EQ(meant("127.0.0.1:7001").device, kFront);
}

// What a hostile sensor says of its number proves nothing: where a key was proven, only that one is
// believed.
TEST_F(KnownSensorsTest, OfTwoWithOneNumberOnlyTheProvenKeyCounts) {
  add(7, kFront);
  remember(kFrontPlace, kFront);
  for (const std::optional<std::uint32_t> asked : {std::optional<std::uint32_t>{}, {kFront}}) {
    const Meant front = meant("127.0.0.1:7001", asked);
    EXPECT_EQ(front.device, kFront);
    ASSERT_EQ(front.keys.count(), 1U);
    EXPECT_EQ(front.keys.all()[0].id, kFront);
  }
  EXPECT_EQ(meant("127.0.0.1:7001", kRear).keys.count(), 3U);
  EXPECT_EQ(meant("127.0.0.1:7002", kFront).keys.count(), 3U);
}

TEST_F(KnownSensorsTest, TwoOfOneNumberThatWereProvenAtTwoPlacesAreTwoSensors) {
  ASSERT_TRUE(keys_.remove(kRear));
  add(7, kFront);
  remember(kFrontPlace, kFront);
  EXPECT_TRUE(meant("127.0.0.1:7002").doubt.empty()) << "the other may be an older one of it";
  remember(kRearPlace, 7);
  for (const std::optional<std::uint32_t> asked : {std::optional<std::uint32_t>{}, {kFront}}) {
    EXPECT_NE(meant("127.0.0.1:7002", asked).doubt.find("number 1 (keys 00000001, 00000007)"),
              std::string::npos)
        << meant("127.0.0.1:7002", asked).doubt;
    EXPECT_EQ(meant("127.0.0.1", asked).keys.all()[0].id, 7U);
  }
}

TEST_F(KnownSensorsTest, AKeyThatIsNamedCountsAloneWhateverWasProven) {
  add(7, kFront);
  remember(kFrontPlace, kFront);
  for (const char* const named : {"127.0.0.1:7001", "127.0.0.1:7002", ""}) {
    const auto found = meant_sensor(file_, keys_, named, {.key_id = 7});
    ASSERT_TRUE(found);
    EXPECT_EQ(found->device, kFront);
    ASSERT_EQ(found->keys.count(), 1U);
    EXPECT_EQ(found->keys.all()[0].id, 7U);
    EXPECT_TRUE(found->doubt.empty());
  }
  for (const Asked& wrong : {Asked{.key_id = 9}, Asked{.device = kRear, .key_id = 7}}) {
    const auto found = meant_sensor(file_, keys_, "127.0.0.1:7001", wrong);
    ASSERT_FALSE(found);
    EXPECT_EQ(found.error().status, Status::kInvalidArgument);
  }
}

TEST_F(KnownSensorsTest, TellsWhichKeyWasProvenSomewhere) {
  remember(kFrontPlace, kFront);
  EXPECT_EQ(key_proven_at(file_, keys_, "127.0.0.1:7001"), kFront);
  EXPECT_EQ(key_proven_at(file_, keys_, "127.0.0.1:7002"), 0U);
  EXPECT_EQ(key_proven_at(file_, keys_, ""), 0U);
}

TEST_F(KnownSensorsTest, ASensorWithoutAKeyIsForgotten) {
  remember(kFrontPlace, kFront);
  ASSERT_TRUE(keys_.remove(1));
  EXPECT_FALSE(meant("127.0.0.1:7001").device);
  add(4, 3);
  EXPECT_FALSE(meant("127.0.0.1:7001").doubt.empty());
}

TEST_F(KnownSensorsTest, TheOldestPlacesGoFirstAndTheFileIsForItsOwnerAlone) {
  for (int port = 1; port <= 200; ++port) {
    const std::string place = "127.0.0.1:" + std::to_string(port);
    remember({.named = place, .address = place}, kFront);
  }
  EXPECT_FALSE(meant("127.0.0.1:1").device);
  EXPECT_FALSE(meant("127.0.0.1:136").device);
  EXPECT_EQ(meant("127.0.0.1:137").device, kFront);
  EXPECT_EQ(meant("127.0.0.1:200").device, kFront);
  struct stat found{};
  ASSERT_EQ(::stat((file_ + ".sensors").c_str(), &found), 0);
  EXPECT_EQ(found.st_mode & 0777U, 0600U);
}

TEST_F(KnownSensorsTest, WhatIsKnownIsNotWrittenAgain) {
  remember(kFrontPlace, kFront);
  std::filesystem::remove(file_ + ".lock");
  std::filesystem::permissions(
      folder_, std::filesystem::perms::owner_read | std::filesystem::perms::owner_exec);
  remember(kFrontPlace, kFront);
  std::filesystem::permissions(folder_, std::filesystem::perms::owner_all);
  EXPECT_FALSE(std::filesystem::exists(file_ + ".lock"));
}

TEST_F(KnownSensorsTest, WhatIsNoSuchFileIsRefusedAndStays) {
  const std::string sensors = file_ + ".sensors";
  for (const std::string& text :
       {std::string("notes\n"), std::string("stof sensors 1\n00000001 here"),
        std::string("stof sensors 1\n0000000g here:1\n"),
        std::string("stof sensors 1\n00000001 \n"), std::string("stof sensors 1\n00000001 a b\n"),
        std::string("stof sensors 1\n\n"), std::string("stof sensors 2\n"),
        std::string(100'000, 'a')}) {
    std::ofstream(sensors, std::ios::trunc) << text;
    ASSERT_EQ(::chmod(sensors.c_str(), 0600), 0);
    const auto found = meant_sensor(file_, keys_, "127.0.0.1:7001", {});
    ASSERT_FALSE(found) << text.substr(0, 40);
    EXPECT_EQ(found.error().status, Status::kCorrupt);
    EXPECT_FALSE(remember_sensor(file_, keys_, kFrontPlace, kFront));
  }
  std::ofstream(sensors, std::ios::trunc) << "stof sensors 1\n00000001 127.0.0.1:7001\n";
  EXPECT_EQ(meant("127.0.0.1:7001").device, kFront);
  ASSERT_EQ(::chmod(sensors.c_str(), 0644), 0);
  EXPECT_FALSE(meant_sensor(file_, keys_, "127.0.0.1:7001", {}));
}

}  // namespace
}  // namespace stof::client
