#pragma once

#include <expected>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "dsp/base/status.h"
#include "hal/lease.h"
#include "hal/linux/open_error.h"
#include "hal/time.h"

namespace stof::board {

// A camera that need not be there when the board starts: until it is, it is lost. `Camera` is the
// interface, `Frame` what it gives.
template <typename Camera, typename Frame>
class Late final : public Camera {
 public:
  struct Opened {
    std::unique_ptr<Camera> camera;
    std::function<Status()> reopen;  // of this camera, in place
  };
  using Open = std::function<std::expected<Opened, hal::posix::OpenError>()>;

  explicit Late(Open open) : open_(std::move(open)) { static_cast<void>(reopen()); }

  Result<hal::Lease<Frame>> wait_frame(hal::Time deadline) noexcept override {
    if (lost_) {
      return fail(Status::kDeviceLost);
    }
    Result<hal::Lease<Frame>> frame = opened_.camera->wait_frame(deadline);
    lost_ = !frame && frame.error() == Status::kDeviceLost;
    return frame;
  }

  // Nothing where it is not lost. May allocate.
  Status reopen() noexcept {
    if (!lost_) {
      return Status::kOk;
    }
    if (opened_.camera == nullptr) {
      auto opened = open_();
      if (!opened) {
        why_ = std::move(opened.error().message);
        return Status::kDeviceLost;
      }
      opened_ = std::move(*opened);
      lost_ = false;
      return Status::kOk;
    }
    const Status status = opened_.reopen();
    lost_ = status != Status::kOk;
    return lost_ ? Status::kDeviceLost : Status::kOk;
  }

  // Why it could not be opened when the board started; empty: it was.
  const std::string& why() const noexcept { return why_; }

 private:
  Open open_;
  Opened opened_{};
  std::string why_;
  bool lost_ = true;
};

}  // namespace stof::board
