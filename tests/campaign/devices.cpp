#include "tests/campaign/devices.h"

#include <algorithm>

namespace stof::campaign {
namespace {

using emu::FaultKind;

constexpr hal::Duration kReadout = std::chrono::milliseconds(6);

// The emulated camera's own memory behind a read-only view.
template <typename T>
dsp::ImageView<T> writable(dsp::ImageView<const T> view) noexcept {
  return {const_cast<T*>(view.data()), view.width(), view.height(), view.stride()};
}

// A frame is a copy of views in the lease: its stamps may be rewritten there.
template <typename Frame>
Frame& frame_of(hal::BorrowedFrame<Frame>& borrowed) noexcept {
  return const_cast<Frame&>(*borrowed);
}

void rewrite(Lie lie, hal::Exposure& exposure) noexcept {
  switch (lie) {
    case Lie::kLaterStamps:
      exposure = {exposure.begin + kPeriod, exposure.end + kPeriod};
      break;
    case Lie::kEarlierStamps:
      exposure = {exposure.begin - kPeriod, exposure.end - kPeriod};
      break;
    case Lie::kNoStamps:
      exposure = {};
      break;
    case Lie::kEndsBeforeItBegins:
      std::swap(exposure.begin, exposure.end);
      break;
    default:
      break;
  }
}

// The part of wait_frame that both cameras share: a device that is gone, frames that never come,
// come late or damaged. `strike(frame)`: whether the fault met its exposure or readout.
template <typename Frame, typename Camera, typename Met>
Result<hal::BorrowedFrame<Frame>> fetch(Camera& camera, Clock& clock, const TimedFault& fault,
                                        hal::Time deadline, const Met& met) noexcept {
  for (;;) {
    const bool vanishes = fault.kind == FaultKind::kVanish;
    if (vanishes && fault.span.holds(clock.peek())) {
      return fail(Status::kDeviceLost);
    }
    const bool soon = vanishes && clock.peek() < fault.span.begin && fault.span.begin < deadline;
    Result<hal::BorrowedFrame<Frame>> frame = camera.wait_frame(soon ? fault.span.begin : deadline);
    if (!frame) {
      if (soon && frame.error() == Status::kTimeout) {
        return fail(Status::kDeviceLost);
      }
      return frame;
    }
    if (!met(**frame)) {
      return frame;
    }
    switch (fault.kind) {
      case FaultKind::kDrop:
      case FaultKind::kVanish:
        continue;  // it never comes
      case FaultKind::kCorrupt:
        return fail(Status::kCorrupt);
      case FaultKind::kDelay:
        // Later than somebody waits is later than anybody asks for: the frame is gone.
        if (clock.peek() + fault.duration > deadline) {
          clock.wait_until(deadline);
          return fail(Status::kTimeout);
        }
        clock.wait_until(clock.peek() + fault.duration);
        return frame;
      default:
        return frame;
    }
  }
}

}  // namespace

void Clock::strike() noexcept {
  if (now_ >= stop_.begin) {
    now_ = std::max(now_, stop_.end);
    stop_ = {};
  }
  if (busy_.holds(now_)) {
    now_ += most_ * random_.between(0, 1000) / 1000;
  }
}

hal::Time Clock::now() noexcept {
  strike();
  return now_;
}

void Clock::wait_until(hal::Time time) noexcept {
  now_ = std::max(now_, time);
  strike();
}

Result<hal::BorrowedFrame<hal::StereoFrame>> StereoCamera::wait_frame(hal::Time deadline) noexcept {
  const auto met = [this](const hal::StereoFrame& frame) noexcept {
    return fault.span.meets(frame.left_exposure.begin, frame.left_exposure.end + kReadout);
  };
  auto borrowed = fetch<hal::StereoFrame>(camera_, clock_, fault, deadline, met);
  if (borrowed) {
    hal::StereoFrame& frame = frame_of(*borrowed);
    const bool struck = met(frame);
    if (struck && before_ && fault.kind == FaultKind::kRepeat) {
      frame.left_exposure = before_->left_exposure;
      frame.right_exposure = before_->right_exposure;
      frame.left_sequence = before_->left_sequence;
      frame.right_sequence = before_->right_sequence;
    } else if (struck && before_ && fault.kind == FaultKind::kTear) {
      frame.right_exposure = before_->right_exposure;
      frame.right_sequence = before_->right_sequence;
    }
    paint(frame, struck);
    if (struck) {
      lie(frame);
    } else {
      before_ = frame;
      edge_before_ = log_.find(frame.left_exposure.begin);
    }
  }
  return borrowed;
}

void StereoCamera::paint(hal::StereoFrame& frame, bool struck) noexcept {
  const std::size_t left = log_.find(frame.left_exposure.begin);
  const std::size_t right = log_.find(frame.right_exposure.begin);
  const bool both = struck && fault.lie == Lie::kOldPixelsOfBoth;
  const bool one = both || (struck && fault.lie == Lie::kOldPixels);
  paint_view(writable(frame.left), both ? edge_before_ : left, 0);
  const std::size_t shown = one ? edge_before_ : right;
  paint_view(writable(frame.right), shown, size_.disparity(shown));
}

void StereoCamera::lie(hal::StereoFrame& frame) noexcept {
  rewrite(fault.lie, frame.left_exposure);
  rewrite(fault.lie, frame.right_exposure);
  if (fault.lie == Lie::kSequenceStands && before_) {
    frame.left_sequence = before_->left_sequence;
    frame.right_sequence = before_->right_sequence;
  }
}

Result<hal::BorrowedFrame<hal::PmdFrame>> PmdCamera::wait_frame(hal::Time deadline) noexcept {
  const auto met = [this](const hal::PmdFrame& frame) noexcept {
    return fault.span.meets(frame.exposures[0].begin, frame.exposures[3].end + kReadout);
  };
  auto borrowed = fetch<hal::PmdFrame>(camera_, clock_, fault, deadline, met);
  if (borrowed) {
    hal::PmdFrame& frame = frame_of(*borrowed);
    const bool struck = met(frame);
    if (struck && before_ && fault.kind == FaultKind::kRepeat) {
      frame.exposures = before_->exposures;
      frame.sequence = before_->sequence;
    } else if (struck && before_ && fault.kind == FaultKind::kTear) {
      frame.exposures[2] = before_->exposures[2];
      frame.exposures[3] = before_->exposures[3];
    }
    paint(frame, struck);
    if (struck) {
      lie(frame);
    } else {
      before_ = frame;
      edge_before_ = log_.find(frame.exposures[0].begin);
    }
  }
  return borrowed;
}

void PmdCamera::paint(hal::PmdFrame& frame, bool struck) noexcept {
  for (int k = 0; k < 4; ++k) {
    const auto i = static_cast<std::size_t>(k);
    const std::size_t edge = log_.find(frame.exposures[i].begin - integration_ * k / 4);
    const bool old = struck && (fault.lie == Lie::kOldPixels || fault.lie == Lie::kOldPixelsOfBoth);
    if (struck && fault.lie == Lie::kDark) {
      paint_dark(writable(frame.samples[i]), 4 * edge + i);
    } else {
      paint_sample(writable(frame.samples[i]), size_.depth_m(old ? edge_before_ : edge), k, lens_);
    }
  }
}

void PmdCamera::lie(hal::PmdFrame& frame) noexcept {
  for (hal::Exposure& exposure : frame.exposures) {
    rewrite(fault.lie, exposure);
  }
  if (fault.lie == Lie::kSequenceStands && before_) {
    frame.sequence = before_->sequence;
  }
}

Result<hal::Time> Trigger::pulse() noexcept {
  if (call_times_.size() < kTimedCalls) {
    call_times_.push_back(clock_.peek());
  }
  if (!fault.span.holds(clock_.peek())) {
    return trigger_.pulse();
  }
  switch (fault.kind) {
    case FaultKind::kVanish:
      return fail(Status::kDeviceLost);
    case FaultKind::kTear:
    case FaultKind::kCorrupt:
      return fail(Status::kDeviceError);
    case FaultKind::kDelay:
      clock_.wait_until(clock_.peek() + fault.duration);
      return trigger_.pulse();
    case FaultKind::kDrop: {
      gate_.shut = true;
      const Result<hal::Time> edge = trigger_.pulse();
      gate_.shut = false;
      return edge;
    }
    case FaultKind::kRepeat: {
      const Result<hal::Time> edge = trigger_.pulse();
      if (edge) {
        gate_.on_edge(*edge + fault.duration);
      }
      return edge;
    }
    default:
      break;
  }
  Result<hal::Time> edge = trigger_.pulse();
  if (edge && fault.lie != Lie::kNone) {
    *edge += fault.duration;
  }
  return edge;
}

}  // namespace stof::campaign
