#pragma once

#include <cstdint>
#include <optional>
#include <utility>

#include "host/recording/mcap/records.h"
#include "host/recording/recorded_frame.h"
#include "host/recording/ros_messages.h"
#include "host/recording/told_lenses.h"
#include "host/recording/topics.h"

namespace stof::recording {

// Frames of a recording, put together of its messages in the order in which they were written.
class FrameAssembler {
 public:
  // calibration: that holds where the messages begin.
  explicit FrameAssembler(const std::optional<wire::CalibrationPacket>& calibration = {})
      : calibration_(calibration) {}
  // The frame that this message ends, if it begins another one.
  std::optional<RecordedFrame> take(Topic topic, const mcap::Message& message);
  // The last one, behind the last message.
  std::optional<RecordedFrame> end() { return std::exchange(frame_, std::nullopt); }
  // Of what was taken.
  const Sights& sights() const noexcept { return sights_; }
  const ToldLenses& lenses() const noexcept { return lenses_; }
  std::uint64_t damaged() const noexcept { return damaged_; }  // messages

 private:
  void take_picture(Topic topic, const Image& image);
  void take_image(Topic topic, const Image& image);
  void take_packet(Topic topic, const mcap::Message& message, const Packet& packet);

  std::optional<RecordedFrame> frame_;  // that is being put together
  std::optional<wire::CalibrationPacket> calibration_;
  ToldLenses lenses_;
  std::optional<wire::Origin> origin_;  // of the newest message
  Sights sights_;
  std::uint64_t damaged_ = 0;
};

}  // namespace stof::recording
