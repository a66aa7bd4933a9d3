#pragma once

#include <optional>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/hal/cameras/camera_fixture.h"

// What every camera promises, whatever it is made of:
//   INSTANTIATE_TYPED_TEST_SUITE_P(Name, CameraContract, Types<Rig, ...>), Rig as camera_fixture.h
//   says.
namespace stof::test {

TYPED_TEST_SUITE_P(CameraContract);

TYPED_TEST_P(CameraContract, WithoutAnEdgeTimesOutAtTheDeadline) {
  const hal::Time deadline = this->rig_.clock().now() + std::chrono::milliseconds(3);
  const auto frame = this->rig_.wait_frame(deadline);
  ASSERT_FALSE(frame);
  EXPECT_EQ(frame.error(), Status::kTimeout);
  EXPECT_GE(this->rig_.clock().now(), deadline);
}

TYPED_TEST_P(CameraContract, DeadlineInThePastIsATimeout) {
  const auto frame = this->rig_.wait_frame(this->rig_.clock().now() - std::chrono::seconds(1));
  ASSERT_FALSE(frame);
  EXPECT_EQ(frame.error(), Status::kTimeout);
}

TYPED_TEST_P(CameraContract, FrameThatIsThereComesWhateverTheDeadline) {
  this->expose();
  EXPECT_TRUE(this->rig_.wait_frame(this->rig_.clock().now() - std::chrono::seconds(1)));
}

TYPED_TEST_P(CameraContract, ExposesAfterTheEdgeAndBeforeTheFrame) {
  for (int i = 0; i < 3; ++i) {
    const hal::Time edge = this->rig_.pulse();
    const auto frame = this->read();
    ASSERT_TRUE(frame);
    for (const hal::Exposure& exposure : TypeParam::exposures(**frame)) {
      EXPECT_GE(exposure.begin, edge);
      EXPECT_LT(exposure.begin, exposure.end);
      EXPECT_LE(exposure.end, edge + this->rig_.frame_time());
      EXPECT_LE(exposure.end, this->rig_.clock().now());
    }
  }
}

TYPED_TEST_P(CameraContract, SequenceAdvancesByOne) {
  std::optional<std::uint32_t> last;
  for (int i = 0; i < 10; ++i) {
    const auto frame = this->shoot();
    ASSERT_TRUE(frame);
    const std::uint32_t sequence = TypeParam::sequence(**frame);
    EXPECT_TRUE(!last || sequence == *last + 1);
    last = sequence;
  }
}

TYPED_TEST_P(CameraContract, HandsOutTheOldestFirstAndEachOnce) {
  this->expose();
  this->expose();
  const auto first = this->read();
  const auto second = this->read();
  ASSERT_TRUE(first && second);
  EXPECT_EQ(TypeParam::sequence(**first) + 1, TypeParam::sequence(**second));
  EXPECT_FALSE(this->read());
}

TYPED_TEST_P(CameraContract, WithTwoLeasesOutAThirdFrameArrives) {
  const auto first = this->shoot();
  const auto second = this->shoot();
  const auto third = this->shoot();
  EXPECT_TRUE(first && second && third);
}

TYPED_TEST_P(CameraContract, LeasesBringTheirSlotsHome) {
  for (int i = 0; i < 5 * TypeParam::kSlots; ++i) {
    ASSERT_TRUE(this->shoot()) << "frame " << i;
  }
}

TYPED_TEST_P(CameraContract, WithAllSlotsOutFramesAreLostAndThenComeAgain) {
  std::vector<hal::BorrowedFrame<typename TypeParam::Frame>> frames;
  for (int i = 0; i < TypeParam::kSlots; ++i) {
    auto frame = this->shoot();
    ASSERT_TRUE(frame);
    frames.push_back(std::move(*frame));
  }
  const std::uint32_t last = TypeParam::sequence(*frames.back());
  const auto lost = this->shoot();
  ASSERT_FALSE(lost);
  EXPECT_EQ(lost.error(), Status::kTimeout);
  frames.pop_back();
  const auto next = this->shoot();
  ASSERT_TRUE(next);
  EXPECT_EQ(TypeParam::sequence(**next), last + 2);
}

TYPED_TEST_P(CameraContract, UnreadFramesMakeRoomForNewOnes) {
  for (int i = 0; i < TypeParam::kSlots + 2; ++i) {
    this->expose();
  }
  std::vector<std::uint32_t> came;
  while (const auto frame = this->read()) {
    came.push_back(TypeParam::sequence(**frame));
    EXPECT_EQ(came.back(), came.front() + came.size() - 1);
  }
  EXPECT_EQ(came.size(), static_cast<std::size_t>(TypeParam::kSlots));
  const auto next = this->shoot();
  ASSERT_TRUE(next);
  EXPECT_EQ(TypeParam::sequence(**next), came.back() + 1) << "the newest was lost, not the oldest";
}

TYPED_TEST_P(CameraContract, PixelsStayAsTheyAreWhileLeased) {
  const auto held = this->shoot();
  ASSERT_TRUE(held);
  const std::vector<std::uint8_t> before = TypeParam::bytes(**held);
  for (int i = 0; i < 2 * TypeParam::kSlots; ++i) {
    ASSERT_TRUE(this->shoot());
  }
  EXPECT_EQ(before, TypeParam::bytes(**held));
}

REGISTER_TYPED_TEST_SUITE_P(CameraContract, WithoutAnEdgeTimesOutAtTheDeadline,
                            DeadlineInThePastIsATimeout, FrameThatIsThereComesWhateverTheDeadline,
                            ExposesAfterTheEdgeAndBeforeTheFrame, SequenceAdvancesByOne,
                            HandsOutTheOldestFirstAndEachOnce, WithTwoLeasesOutAThirdFrameArrives,
                            LeasesBringTheirSlotsHome, WithAllSlotsOutFramesAreLostAndThenComeAgain,
                            UnreadFramesMakeRoomForNewOnes, PixelsStayAsTheyAreWhileLeased);

}  // namespace stof::test
