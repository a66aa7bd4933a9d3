#pragma once

#include <array>
#include <cstdint>
#include <expected>
#include <memory>
#include <string>
#include <vector>

#include "hal/clock.h"
#include "hal/linux/camera/exposures.h"
#include "hal/linux/open_error.h"
#include "hal/linux/v4l2/v4l2_feed.h"
#include "hal/pmd_camera.h"

namespace stof::hal::linux {

struct V4l2PmdOptions {
  std::string node;  // as find_v4l2_node() takes it
  int width = 0;     // of one sample
  int height = 0;
  // Where exposures are looked up, each of all four samples. Outlives the camera.
  Exposures* exposures = nullptr;
  // The time of all four samples, from the exposure's begin. 0: as long as the exposure.
  Duration integration{};
  // As V4l2StereoOptions::most_delay.
  Duration most_delay = std::chrono::milliseconds(25);
  std::vector<FourCc> formats = {kY12p, kY12, kY16};  // the best one first
  std::string sysfs = "/sys";
};

// A PMD sensor on CSI: one V4L2 node whose pictures hold the four samples one below the other, A0
// first, so four times as high as a sample. Samples are unpacked as to_samples() says into the slot
// when a frame is handed out.
// The sensor takes the samples one after the other without pause: sample k carries the k-th quarter
// of the exposure. Without a known exposure all four carry the raw stamp, as exposures of no
// length, which belong to no edge.
// The sensor itself (frequency, integration) is set elsewhere. Slots, buffers, heap and threads as
// V4l2Stereo.
class V4l2Pmd final : public hal::PmdCamera, private SlotOwner {
 public:
  static constexpr int kSlots = V4l2Feed::kMostWaiting;

  // The error is one line: what, where, what to do. `calls` and `clock` outlive the camera.
  static std::expected<std::unique_ptr<V4l2Pmd>, OpenError> open(V4l2Calls& calls,
                                                                 hal::Clock& clock,
                                                                 V4l2PmdOptions options);
  ~V4l2Pmd() override;
  V4l2Pmd(const V4l2Pmd&) = delete;
  V4l2Pmd& operator=(const V4l2Pmd&) = delete;

  Result<BorrowedFrame<PmdFrame>> wait_frame(Time deadline) noexcept override;
  // As V4l2Stereo::reopen().
  Status reopen() noexcept;

  const V4l2Counters& counters() const noexcept { return feed_.device().counters(); }

 private:
  V4l2Pmd(V4l2Calls& calls, hal::Clock& clock, V4l2PmdOptions options);
  BorrowedFrame<PmdFrame> hand_out() noexcept;
  std::array<Exposure, 4> quarters(const V4l2Arrival& arrival) const noexcept;
  void give_back(int slot) noexcept override;

  V4l2Calls& calls_;
  hal::Clock& clock_;
  V4l2PmdOptions options_;
  V4l2Feed feed_;
  std::vector<std::uint16_t> samples_;  // of all slots
  std::array<bool, kSlots> taken_{};
  int out_ = 0;
  bool corrupt_ = false;  // to be reported
};

}  // namespace stof::hal::linux
