#include "hal/linux/libcamera/libcamera_stereo.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdlib>
#include <optional>
#include <utility>
#include <vector>

#include <libcamera/libcamera.h>
#include <libcamera/logging.h>

#include "hal/linux/libcamera/libcamera_find.h"
#include "hal/linux/libcamera/libcamera_pairs.h"
#include "hal/linux/libcamera/libcamera_stream.h"
#include "hal/linux/system/clock.h"

namespace stof::hal::linux {
namespace {

// Libcamera aborts where there are two camera managers.
std::atomic<bool> in_use{false};

class LibcameraStereo final : public ReopenableStereo,
                              private SlotOwner,
                              private LibcameraRequeuer {
 public:
  explicit LibcameraStereo(const LibcameraOptions& options)
      : options_(options),
        pairs_({.exposure = options.exposure,
                .exposures = options.exposures,
                .most_delay = options.most_delay,
                .most_skew = options.most_skew},
               *this),
        streams_{LibcameraStream(wake_, pairs_.queue(kLeft)),
                 LibcameraStream(wake_, pairs_.queue(kRight))} {}
  ~LibcameraStereo() override {
    shut();
    in_use = false;
  }
  LibcameraStereo(const LibcameraStereo&) = delete;
  LibcameraStereo& operator=(const LibcameraStereo&) = delete;

  std::optional<OpenError> open();
  Result<BorrowedFrame<StereoFrame>> wait_frame(Time deadline) noexcept override;
  Status reopen() noexcept override;

 private:
  void shut() noexcept;
  void give_back(int slot) noexcept override { pairs_.give_back(slot); }
  void requeue(std::size_t side, int slot) noexcept override;
  BorrowedFrame<StereoFrame> lend(const LibcameraPairs::Pair& pair) noexcept;

  LibcameraOptions options_;
  posix::WakeEvent wake_;
  LibcameraPairs pairs_;
  std::unique_ptr<libcamera::CameraManager> manager_;
  std::array<LibcameraStream, 2> streams_;
  // Of cameras that were opened again while frames were lent.
  std::vector<std::shared_ptr<LibcameraPixels>> old_pixels_;
};

std::optional<OpenError> LibcameraStereo::open() {
  if (!wake_.works()) {
    return OpenError{"cannot open cameras of libcamera: too many open files; raise the limit"};
  }
  manager_ = std::make_unique<libcamera::CameraManager>();
  if (manager_->start() != 0) {
    return OpenError{
        "cannot start libcamera: it does not read the machine's devices; mount /sys and /dev"};
  }
  std::vector<std::shared_ptr<libcamera::Camera>> cameras = manager_->cameras();
  std::ranges::sort(cameras, {}, [](const auto& camera) { return camera->id(); });
  std::vector<LibcameraName> names;
  names.reserve(cameras.size());
  for (const std::shared_ptr<libcamera::Camera>& camera : cameras) {
    names.push_back(
        {camera->id(),
         camera->properties().get(libcamera::properties::Model).value_or(std::string())});
  }
  const std::expected<std::size_t, OpenError> left = find_libcamera(names, options_.left);
  const std::expected<std::size_t, OpenError> right = find_libcamera(names, options_.right);
  if (!left || !right) {
    return left ? right.error() : left.error();
  }
  if (*left == *right) {
    return OpenError{"camera '" + names[*left].id + "' cannot be left and right: name two"};
  }
  std::optional<OpenError> error = streams_[kLeft].open(cameras[*left], options_);
  if (!error) {
    error = streams_[kRight].open(cameras[*right], options_);
  }
  return error;
}

void LibcameraStereo::shut() noexcept {
  for (LibcameraStream& stream : streams_) {
    stream.close();
  }
  if (manager_ != nullptr) {
    manager_->stop();
    manager_.reset();
  }
}

Status LibcameraStereo::reopen() noexcept {
  shut();
  pairs_.start_over();
  if (!pairs_.old_ones_out()) {
    old_pixels_.clear();
  } else {
    for (const LibcameraStream& stream : streams_) {
      if (std::ranges::find(old_pixels_, stream.pixels()) == old_pixels_.end()) {
        old_pixels_.push_back(stream.pixels());
      }
    }
  }
  return open() ? Status::kDeviceLost : Status::kOk;
}

void LibcameraStereo::requeue(std::size_t side, int slot) noexcept { streams_[side].requeue(slot); }

BorrowedFrame<StereoFrame> LibcameraStereo::lend(const LibcameraPairs::Pair& pair) noexcept {
  const LibcameraPairs::Frame& left = pair.frames[kLeft];
  const LibcameraPairs::Frame& right = pair.frames[kRight];
  const StereoFrame frame{.left = streams_[kLeft].pixels()->read(left.slot),
                          .right = streams_[kRight].pixels()->read(right.slot),
                          .left_exposure = left.exposure,
                          .right_exposure = right.exposure,
                          .left_sequence = left.sequence,
                          .right_sequence = right.sequence};
  return {frame, *this, pair.number};
}

Result<BorrowedFrame<StereoFrame>> LibcameraStereo::wait_frame(Time deadline) noexcept {
  for (;;) {
    const Result<LibcameraPairs::Pair> pair = pairs_.next();
    if (pair) {
      return lend(*pair);
    }
    if (pair.error() != Status::kWouldBlock) {
      return fail(pair.error());
    }
    if (streams_[kLeft].lost() || streams_[kRight].lost()) {
      return fail(Status::kDeviceLost);
    }
    if (!wake_.wait(deadline - Clock().now())) {
      // Libcamera hears of a lost device from udevd alone.
      const bool gone = streams_[kLeft].node_gone() || streams_[kRight].node_gone();
      return fail(gone ? Status::kDeviceLost : Status::kTimeout);
    }
  }
}

}  // namespace

std::expected<std::unique_ptr<ReopenableStereo>, OpenError> open_libcamera(
    const LibcameraOptions& options) {
  if (options.width <= 0 || options.height <= 0 || options.buffers < 4 ||
      options.buffers > LibcameraBufferQueue::kMostSlots) {
    return std::unexpected(
        OpenError{"cannot open cameras of libcamera: give a size and 4 to 16 buffers"});
  }
  // Status and OpenError tell; libcamera writes about a lost device without end.
  if (std::getenv("LIBCAMERA_LOG_LEVELS") == nullptr) {
    libcamera::logSetTarget(libcamera::LoggingTargetNone);
  }
  if (in_use.exchange(true)) {
    return std::unexpected(OpenError{"libcamera is in use by this program: close the other pair"});
  }
  std::unique_ptr<LibcameraStereo> stereo = std::make_unique<LibcameraStereo>(options);
  if (std::optional<OpenError> error = stereo->open()) {
    return std::unexpected(std::move(*error));
  }
  return stereo;
}

}  // namespace stof::hal::linux
