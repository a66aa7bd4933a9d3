#include "board/emu/fault_orders.h"

#include <gtest/gtest.h>

namespace stof::test {
namespace {

using board::Device;
using board::FaultOrders;
using hal::emu::FaultKind;

TEST(FaultOrders, GivesAFaultForSoManyEdgesOrUntilItIsEnded) {
  FaultOrders orders(true);
  hal::emu::LiveFault& pmd = orders.of(Device::kPmd);
  EXPECT_EQ(pmd.take(), FaultKind::kNone);
  EXPECT_TRUE(orders.obey("pmd:dark:2").starts_with("ok\n"));
  EXPECT_NE(orders.obey("list").find("\npmd dark 2 drop,"), std::string::npos);
  EXPECT_EQ(pmd.take(), FaultKind::kDark);
  EXPECT_EQ(pmd.take(), FaultKind::kDark);
  EXPECT_EQ(pmd.take(), FaultKind::kNone);
  EXPECT_NE(orders.obey("stereo:vanish").find("\nstereo vanish - drop,"), std::string::npos);
  for (int i = 0; i < 100; ++i) {
    ASSERT_EQ(orders.of(Device::kStereo).take(), FaultKind::kVanish);
  }
  EXPECT_EQ(orders.of(Device::kTrigger).take(), FaultKind::kNone);
  EXPECT_TRUE(orders.obey("stereo:none").starts_with("ok\n"));
  EXPECT_EQ(orders.of(Device::kStereo).take(), FaultKind::kNone);
}

TEST(FaultOrders, RefusesWhatNoDeviceHas) {
  FaultOrders orders(true);
  EXPECT_TRUE(orders.obey("stereo:drop:3").starts_with("ok\n"));
  for (const char* const order :
       {"", ":", "stereo", "stereo:", "moon:drop", "stereo:moon", "stereo:dark", "trigger:freeze",
        "trigger:hang", "stereo:drop:", "stereo:drop:0", "stereo:drop:-1", "stereo:drop:x",
        "stereo:drop:4294967296", "stereo:drop:1:1", "LIST", "stereo:drop\n"}) {
    EXPECT_TRUE(orders.obey(order).starts_with("refused: ")) << order;
  }
  EXPECT_EQ(orders.of(Device::kStereo).left().calls, 3U);  // nothing of it did anything
}

TEST(FaultOrders, ARigWithoutPmdCameraHasNoneToFail) {
  FaultOrders orders(false);
  EXPECT_TRUE(orders.obey("pmd:drop").starts_with("refused: "));
  EXPECT_EQ(orders.obey("list").find("pmd"), std::string::npos);
}

}  // namespace
}  // namespace stof::test
