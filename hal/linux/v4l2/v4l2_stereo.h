#pragma once

#include <array>
#include <cstdint>
#include <expected>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hal/clock.h"
#include "hal/linux/camera/exposures.h"
#include "hal/linux/open_error.h"
#include "hal/linux/v4l2/v4l2_feed.h"
#include "hal/stereo_camera.h"

namespace stof::hal::linux {

struct V4l2StereoOptions {
  // Left and right, as find_v4l2_node() takes them. No right one: one node gives both side by side,
  // the left one on the left, in pictures of twice the width.
  std::array<std::string, 2> nodes;
  int width = 0;  // of one view
  int height = 0;
  Duration exposure = std::chrono::milliseconds(4);
  std::optional<std::int32_t> gain;  // in the driver's units
  // Where exposures are looked up, of left and right (side by side: of both, the left one). They
  // outlive the camera.
  std::array<Exposures*, 2> exposures{};
  // From an exposure's end to the stamp of its picture: readout and the way to the driver. Shorter
  // than the way to the next exposure's end, or pictures could be taken for those of the next one.
  Duration most_delay = std::chrono::milliseconds(25);
  std::vector<FourCc> formats = {kGrey, kY10, kY12, kY16, kYuyv};  // the best one first
  // Copies GREY, too: where the driver's buffers are not cached, as on some CSI bridges.
  bool copy = false;
  std::string sysfs = "/sys";
};

struct V4l2StereoCounters {
  std::array<V4l2Counters, 2> devices;  // left and right
  std::uint64_t frames = 0;             // handed out
  std::uint64_t unpaired = 0;           // pictures dropped because the other view's never came
  std::uint64_t unmatched = 0;          // of these, such as no exposure was found for
};

// Two V4L2 cameras on one trigger, or one that gives both views side by side. Pictures are matched
// by the exposures behind their stamps, so that a lost one costs one frame and never shifts the
// views. Where neither view has a known exposure, the frame carries its raw stamps, as exposures of
// no length, which belong to no edge.
// GREY is a view into the driver's buffer, whose rows may be padded, if it is not to be copied;
// other formats are converted as to_grey() says when they are handed out. Sequences are the
// driver's. Four slots, and eight buffers of each driver: of what waits unread the newest four are
// kept; with more than eight waiting the driver itself loses the newest. Allocates in open() and
// reopen() alone. For one thread.
class V4l2Stereo final : public hal::StereoCamera, private SlotOwner {
 public:
  static constexpr int kSlots = V4l2Feed::kMostWaiting;

  // Refuses cameras that expose for different times. The error is one line: what, where, what to
  // do. `calls` and `clock` outlive the camera.
  static std::expected<std::unique_ptr<V4l2Stereo>, OpenError> open(V4l2Calls& calls,
                                                                    hal::Clock& clock,
                                                                    V4l2StereoOptions options);
  ~V4l2Stereo() override;
  V4l2Stereo(const V4l2Stereo&) = delete;
  V4l2Stereo& operator=(const V4l2Stereo&) = delete;

  // After kDeviceLost every call returns it at once, until reopen().
  Result<BorrowedFrame<StereoFrame>> wait_frame(Time deadline) noexcept override;

  // Opens the cameras anew, wherever they are now. Frames that were not handed out are lost; lent
  // ones stay readable. May allocate and takes as long as the drivers do. kOk, or kDeviceLost: not
  // yet back.
  Status reopen() noexcept;

  // The exposure that the drivers set; none where they do not report it.
  std::optional<Duration> exposure() const noexcept { return feeds_[0]->device().exposure(); }
  V4l2StereoCounters counters() const noexcept;

 private:
  struct Slot {
    bool out = false;
    std::array<std::optional<V4l2Buffer>, 2> held;  // by feed
    std::array<std::vector<std::uint8_t>, 2> grey;  // converted views
  };

  V4l2Stereo(V4l2Calls& calls, hal::Clock& clock, V4l2StereoOptions options);
  bool side_by_side() const noexcept { return used_ == 1; }
  std::expected<void, OpenError> start();
  Status drain() noexcept;
  bool match() noexcept;
  bool together(const V4l2Arrival& left, const V4l2Arrival& right) const noexcept;
  void drop(std::size_t side) noexcept;
  const V4l2Format& format(std::size_t side) const noexcept;
  bool converts(std::size_t side) const noexcept;
  BorrowedFrame<StereoFrame> hand_out() noexcept;
  dsp::ImageView<const std::uint8_t> view(Slot& slot, std::size_t side,
                                          const V4l2Buffer& buffer) noexcept;
  void give_back(int slot) noexcept override;

  V4l2Calls& calls_;
  hal::Clock& clock_;
  V4l2StereoOptions options_;
  std::array<std::unique_ptr<V4l2Feed>, 2> feeds_;
  std::array<V4l2Feed*, 2> polled_{};
  std::size_t used_ = 2;  // feeds
  std::array<Slot, kSlots> slots_;
  int out_ = 0;
  bool corrupt_ = false;  // to be reported
  Time corrupt_at_;       // the exposure that was reported last
  V4l2StereoCounters counters_;
};

}  // namespace stof::hal::linux
