#include <gtest/gtest.h>

#include "tests/hal/cameras/emu_cameras.h"

namespace stof::test {
namespace {

using namespace std::chrono_literals;
using hal::emu::Fault;
using hal::emu::FaultKind;
using hal::emu::FaultPlan;
using Stereo = StereoRig<hal::emu::Clock>;
using Pmd = PmdRig<hal::emu::Clock>;

constexpr hal::Duration kPeriod = 33ms;

TEST(FaultPlan, EmptyNeverStrikes) {
  for (const std::uint32_t call : {0U, 1U, 1000U, 0xFFFFFFFFU}) {
    EXPECT_EQ(FaultPlan{}.at(call).kind, FaultKind::kNone);
  }
}

TEST(FaultPlan, StrikesAtItsCallOnly) {
  const FaultPlan plan{{.kind = FaultKind::kDrop, .call = 3}};
  for (std::uint32_t call = 0; call < 10; ++call) {
    EXPECT_EQ(plan.at(call).kind, call == 3 ? FaultKind::kDrop : FaultKind::kNone);
  }
}

TEST(FaultPlan, StrikesInRowsAndAgain) {
  const FaultPlan plan{{.kind = FaultKind::kTear, .call = 2, .calls = 2, .every = 5}};
  const std::string struck = [&] {
    std::string out;
    for (std::uint32_t call = 0; call < 12; ++call) {
      out += plan.at(call).kind == FaultKind::kTear ? 'x' : '.';
    }
    return out;
  }();
  EXPECT_EQ(struck, "..xx...xx...");
}

TEST(FaultPlan, ForeverHasNoEndAndTheFirstEntryCounts) {
  const FaultPlan plan{{.kind = FaultKind::kDrop, .call = 4},
                       {.kind = FaultKind::kVanish, .call = 2, .calls = Fault::kForever}};
  EXPECT_EQ(plan.at(1).kind, FaultKind::kNone);
  EXPECT_EQ(plan.at(2).kind, FaultKind::kVanish);
  EXPECT_EQ(plan.at(4).kind, FaultKind::kDrop);
  EXPECT_EQ(plan.at(0xFFFFFFFF).kind, FaultKind::kVanish);
}

// One pulse a period, as the loop does, and what came until the next.
template <typename Rig>
auto period(Rig& rig, hal::Time* edge = nullptr) {
  const Result<hal::Time> at = rig.trigger().pulse();
  if (edge != nullptr && at) {
    *edge = *at;
  }
  return rig.wait_frame(rig.clock().now() + kPeriod);
}

TEST(StereoFaults, DroppedExposureNeverArrives) {
  Stereo rig({{.kind = FaultKind::kDrop, .call = 1}});
  ASSERT_TRUE(period(rig));
  EXPECT_EQ(period(rig).error(), Status::kTimeout);
  const auto next = period(rig);
  ASSERT_TRUE(next);
  EXPECT_EQ((*next)->left_sequence, 3U);  // the sensor made number 2
}

TEST(StereoFaults, DelayedFrameKeepsItsStampsAndItsPlace) {
  Stereo rig({{.kind = FaultKind::kDelay, .call = 0, .duration = 50ms}});
  hal::Time edge{};
  EXPECT_EQ(period(rig, &edge).error(), Status::kTimeout);
  const auto late = period(rig);
  ASSERT_TRUE(late);
  EXPECT_EQ((*late)->left_sequence, 1U);
  EXPECT_EQ((*late)->left_exposure.begin, edge);
  EXPECT_EQ(rig.clock().now(), edge + 51ms);
  const auto behind = rig.wait_frame(rig.clock().now());
  ASSERT_TRUE(behind);
  EXPECT_EQ((*behind)->left_sequence, 2U);
}

TEST(StereoFaults, RepeatedFrameIsThePreviousOneToTheLastBit) {
  Stereo rig({{.kind = FaultKind::kRepeat, .call = 1}});
  const auto first = period(rig);
  const auto again = period(rig);
  ASSERT_TRUE(first && again);
  EXPECT_EQ((*again)->left_sequence, (*first)->left_sequence);
  EXPECT_EQ((*again)->right_sequence, (*first)->right_sequence);
  EXPECT_EQ((*again)->left_exposure.begin, (*first)->left_exposure.begin);
  EXPECT_EQ((*again)->right_exposure.end, (*first)->right_exposure.end);
  EXPECT_EQ(Stereo::bytes(**again), Stereo::bytes(**first));
  const auto third = period(rig);
  ASSERT_TRUE(third);
  EXPECT_EQ((*third)->left_sequence, 3U);
}

TEST(StereoFaults, AFrozenRightViewIsThePreviousOneUnderNewStamps) {
  Stereo rig({{.kind = FaultKind::kFreeze, .call = 1, .calls = 2}});
  ASSERT_TRUE(period(rig));
  for (std::uint32_t number = 2; number < 5; ++number) {
    hal::Time edge{};
    const auto frame = period(rig, &edge);
    ASSERT_TRUE(frame);
    EXPECT_EQ((*frame)->left_sequence, number);
    EXPECT_EQ((*frame)->right_sequence, number);
    EXPECT_EQ((*frame)->right_exposure.begin, edge);
    EXPECT_EQ((*frame)->left.at(0, 0), FakeImagery::left_value(number));
    EXPECT_EQ((*frame)->right.at(0, 0), FakeImagery::right_value(number < 4 ? 1 : number));
  }
}

TEST(StereoFaults, WhatHangsIsFrozenUntilItIsOpenedAgain) {
  Stereo rig({{.kind = FaultKind::kHang, .call = 1, .calls = 4},
              {.kind = FaultKind::kHang, .call = 6, .calls = 2}});
  ASSERT_TRUE(period(rig));
  const auto right_of = [&] { return (*period(rig))->right.at(0, 0); };
  EXPECT_EQ(right_of(), FakeImagery::right_value(1));
  EXPECT_EQ(right_of(), FakeImagery::right_value(1));
  rig.camera().reopen();
  EXPECT_EQ(right_of(), FakeImagery::right_value(4));
  EXPECT_EQ(right_of(), FakeImagery::right_value(5));
  EXPECT_EQ(right_of(), FakeImagery::right_value(6));
  EXPECT_EQ(right_of(), FakeImagery::right_value(6)) << "it hangs again";
  EXPECT_EQ(right_of(), FakeImagery::right_value(6));
  EXPECT_EQ(right_of(), FakeImagery::right_value(9));
}

TEST(PmdFaults, WhatHangsIsFrozenUntilItIsOpenedAgain) {
  Pmd rig({{.kind = FaultKind::kHang, .call = 1, .calls = 9}});
  const auto bytes_of = [&] { return Pmd::bytes(**period(rig)); };
  const auto first = bytes_of();
  EXPECT_EQ(bytes_of(), first);
  rig.camera().reopen();
  EXPECT_NE(bytes_of(), first);
}

TEST(PmdFaults, FrozenSamplesAreThePreviousOnesUnderNewStamps) {
  Pmd rig({{.kind = FaultKind::kFreeze, .call = 1}});
  const auto first = period(rig);
  hal::Time edge{};
  const auto frozen = period(rig, &edge);
  ASSERT_TRUE(first && frozen);
  EXPECT_EQ((*frozen)->sequence, (*first)->sequence + 1);
  EXPECT_EQ((*frozen)->exposures[0].begin, edge);
  EXPECT_EQ(Pmd::bytes(**frozen), Pmd::bytes(**first));
}

TEST(PmdFaults, WithoutItsLampThereIsTheDarkLevelAndNoise) {
  Pmd rig({{.kind = FaultKind::kDark, .call = 0, .calls = 2}});
  const auto first = period(rig);
  const auto second = period(rig);
  ASSERT_TRUE(first && second);
  EXPECT_NE(Pmd::bytes(**first), Pmd::bytes(**second));
  for (const auto& sample : (*first)->samples) {
    for (int y = 0; y < sample.height(); ++y) {
      for (const std::uint16_t value : sample.row(y)) {
        EXPECT_NEAR(value, 100, 10);
      }
    }
  }
}

TEST(StereoFaults, RepeatAtTheFirstCallHasNothingToRepeat) {
  Stereo rig({{.kind = FaultKind::kRepeat, .call = 0}});
  EXPECT_EQ(period(rig).error(), Status::kTimeout);
  EXPECT_TRUE(period(rig));
}

TEST(StereoFaults, TornFrameHasThePreviousRightViewAndSaysSo) {
  Stereo rig({{.kind = FaultKind::kTear, .call = 1}});
  hal::Time first{};
  hal::Time second{};
  ASSERT_TRUE(period(rig, &first));
  const auto torn = period(rig, &second);
  ASSERT_TRUE(torn);
  const hal::StereoFrame& frame = **torn;
  EXPECT_EQ(frame.left_sequence, 2U);
  EXPECT_EQ(frame.right_sequence, 1U);
  EXPECT_EQ(frame.left_exposure.begin, second);
  EXPECT_EQ(frame.right_exposure.begin, first);
  EXPECT_EQ(frame.left.at(0, 0), FakeImagery::left_value(2));
  EXPECT_EQ(frame.right.at(0, 0), FakeImagery::right_value(1));
}

TEST(StereoFaults, DamageThatTheAdapterSeesIsCorruptAtTheFramesTime) {
  Stereo rig({{.kind = FaultKind::kCorrupt, .call = 0}});
  hal::Time edge{};
  EXPECT_EQ(period(rig, &edge).error(), Status::kCorrupt);
  EXPECT_EQ(rig.clock().now(), edge + 1ms);
  EXPECT_TRUE(period(rig));
}

TEST(StereoFaults, VanishedCameraIsLostWithAllThatWaitedUntilItIsBack) {
  Stereo rig({{.kind = FaultKind::kVanish, .call = 1, .calls = 2}});
  rig.pulse();
  rig.clock().wait_until(rig.clock().now() + kPeriod);
  EXPECT_EQ(period(rig).error(), Status::kDeviceLost);
  EXPECT_EQ(rig.wait_frame(rig.clock().now() + kPeriod).error(), Status::kDeviceLost);
  EXPECT_EQ(period(rig).error(), Status::kDeviceLost);
  const auto back = period(rig);
  ASSERT_TRUE(back);
  EXPECT_EQ((*back)->left_sequence, 2U);
}

TEST(PmdFaults, TornSetMixesTwoSetsAndSaysSo) {
  Pmd rig({{.kind = FaultKind::kTear, .call = 1}});
  hal::Time first{};
  hal::Time second{};
  ASSERT_TRUE(period(rig, &first));
  const auto torn = period(rig, &second);
  ASSERT_TRUE(torn);
  const hal::PmdFrame& frame = **torn;
  EXPECT_EQ(frame.sequence, 2U);
  for (int k = 0; k < 4; ++k) {
    const std::size_t i = static_cast<std::size_t>(k);
    EXPECT_EQ(frame.samples[i].at(0, 0), FakeImagery::pmd_value(k < 2 ? 2 : 1, k));
    EXPECT_EQ(frame.exposures[i].begin, (k < 2 ? second : first) + k * 200us);
  }
}

TEST(PmdFaults, CallsCountTheEdgesAtWhichItWouldExpose) {
  Pmd rig({{.kind = FaultKind::kDrop, .call = 1}}, {},
          {.integration = 800us, .readout = 200us, .every = 2});
  std::string came;
  for (int edge = 0; edge < 8; ++edge) {
    came += period(rig) ? 'x' : '.';
  }
  EXPECT_EQ(came, "x...x.x.");
}

TEST(TriggerFaults, DroppedPulseLooksFineButNobodySawIt) {
  Stereo rig({}, {{.kind = FaultKind::kDrop, .call = 0}});
  EXPECT_TRUE(rig.trigger().pulse());
  EXPECT_EQ(rig.wait_frame(rig.clock().now() + kPeriod).error(), Status::kTimeout);
}

TEST(TriggerFaults, DelayedEdgeIsLateAndItsTimeTrue) {
  Stereo rig({}, {{.kind = FaultKind::kDelay, .call = 0, .duration = 7ms}});
  const hal::Time asked = rig.clock().now();
  hal::Time edge{};
  const auto frame = period(rig, &edge);
  ASSERT_TRUE(frame);
  EXPECT_EQ(edge, asked + 7ms);
  EXPECT_EQ((*frame)->left_exposure.begin, edge);
}

TEST(TriggerFaults, RepeatedPulseMakesASecondFrame) {
  Stereo rig({}, {{.kind = FaultKind::kRepeat, .call = 0, .duration = 9ms}});
  hal::Time edge{};
  const auto first = period(rig, &edge);
  const auto second = rig.wait_frame(rig.clock().now() + kPeriod);
  ASSERT_TRUE(first && second);
  EXPECT_EQ((*first)->left_exposure.begin, edge);
  EXPECT_EQ((*second)->left_exposure.begin, edge + 9ms);
}

TEST(TriggerFaults, TornPulseIsAnErrorThoughTheEdgeWentOut) {
  Stereo rig({}, {{.kind = FaultKind::kTear, .call = 0}});
  EXPECT_EQ(rig.trigger().pulse().error(), Status::kDeviceError);
  EXPECT_TRUE(rig.wait_frame(rig.clock().now() + kPeriod));
}

TEST(TriggerFaults, CorruptAndVanishedPulsesDriveNothing) {
  Stereo rig({},
             {{.kind = FaultKind::kCorrupt, .call = 0}, {.kind = FaultKind::kVanish, .call = 1}});
  EXPECT_EQ(rig.trigger().pulse().error(), Status::kDeviceError);
  EXPECT_EQ(rig.trigger().pulse().error(), Status::kDeviceLost);
  EXPECT_EQ(rig.wait_frame(rig.clock().now() + kPeriod).error(), Status::kTimeout);
  EXPECT_TRUE(period(rig));
}

TEST(Trigger, ReturnsTheRisingEdgeAndTakesThePulseWidth) {
  Stereo rig;
  const hal::Time before = rig.clock().now();
  EXPECT_EQ(rig.pulse(), before);
  EXPECT_EQ(rig.clock().now(), before + Stereo::kPulse);
}

// Whatever strikes whenever: what is handed out as a frame of the newest edge with matching stamps
// shows that exposure, and the device works again two periods later.
template <typename Rig>
void recovers_from_everything() {
  for (const FaultKind kind : hal::emu::kAllFaultKinds) {
    for (std::uint32_t call = 0; call < 6; ++call) {
      for (const bool on_trigger : {false, true}) {
        const FaultPlan plan{{.kind = kind, .call = call, .duration = 12ms}};
        Rig rig(on_trigger ? FaultPlan{} : plan, on_trigger ? plan : FaultPlan{});
        bool good = false;
        for (std::uint32_t i = 0; i < call + 3; ++i) {
          hal::Time edge{};
          const hal::Time next = rig.clock().now() + kPeriod;
          auto frame = period(rig, &edge);
          while (frame && Rig::exposures(**frame).front().begin != edge) {
            frame = rig.wait_frame(next);
          }
          good = frame.has_value() && Rig::exposures(**frame).back().begin >= edge;
          EXPECT_TRUE(good || i >= call) << "kind " << int(kind) << " call " << call;
          rig.clock().wait_until(next);
        }
        EXPECT_TRUE(good) << "kind " << int(kind) << " at call " << call
                          << (on_trigger ? " of the trigger" : " of the camera");
      }
    }
  }
}

TEST(StereoFaults, CameraRecoversFromEveryFaultAtEveryCall) { recovers_from_everything<Stereo>(); }
TEST(PmdFaults, CameraRecoversFromEveryFaultAtEveryCall) { recovers_from_everything<Pmd>(); }

}  // namespace
}  // namespace stof::test
