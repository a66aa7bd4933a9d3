#include "firmware/pipeline/raw_sender.h"

#include <algorithm>
#include <span>
#include <utility>

namespace stof::firmware {
namespace {

wire::Window window_of(const hal::Exposure& exposure) noexcept {
  return {.begin_ns = exposure.begin.time_since_epoch().count(),
          .end_ns = exposure.end.time_since_epoch().count()};
}

std::uint8_t pictures_of(const Shot& shot) noexcept {
  std::uint8_t pictures = 0;
  if (shot.stereo) {
    pictures |= wire::kRawLeft | wire::kRawRight;
  }
  if (shot.pmd) {
    pictures |= wire::kRawPmd;
  }
  return pictures;
}

}  // namespace

void RawSender::ask(const wire::RawRequest& request) noexcept {
  release();
  request_ = request;
  wait_ = 0;
  number_ = 0;
  dropped_ = 0;
  state_ = 0;
}

void RawSender::offer(Shot& shot, const wire::FrameStamp& stamp) noexcept {
  state_ |= shot.state;
  const std::uint8_t wanted = request_.pictures & wire::kRawPictures;
  const std::uint8_t pictures = wanted & pictures_of(shot);
  if (wait_ > 0) {
    --wait_;
    return;
  }
  const bool whole = pictures == wanted;
  if (pictures == 0 || (!whole && (request_.pictures & wire::kRawWhole) != 0)) {
    return;
  }
  wait_ = request_.every > 0 ? request_.every - 1U : 0;
  if (underway()) {
    ++dropped_;
    return;
  }
  begin(shot, pictures, stamp);
}

void RawSender::begin(Shot& shot, std::uint8_t pictures, const wire::FrameStamp& stamp) noexcept {
  told_state_ = std::exchange(state_, std::uint8_t{0});
  wire::RawInfo info{.edge_ns = shot.edge.time_since_epoch().count(),
                     .number = ++number_,
                     .dropped = dropped_,
                     .state = told_state_,
                     .pmd_every = pmd_every_,
                     .disparities = disparities_};
  wire::RawImages images;
  if ((pictures & (wire::kRawLeft | wire::kRawRight)) != 0) {
    stereo_.emplace(std::move(*shot.stereo));
    const hal::StereoFrame& pair = **stereo_;
    info.pair_exposures = {window_of(pair.left_exposure), window_of(pair.right_exposure)};
    info.sequences[0] = pair.left_sequence;
    info.sequences[1] = pair.right_sequence;
    if ((pictures & wire::kRawLeft) != 0) {
      images.left = pair.left;
    }
    if ((pictures & wire::kRawRight) != 0) {
      images.right = pair.right;
    }
  }
  if ((pictures & wire::kRawPmd) != 0) {
    pmd_.emplace(std::move(*shot.pmd));
    const hal::PmdFrame& set = **pmd_;
    std::ranges::transform(set.exposures, info.pmd_exposures.begin(), window_of);
    info.sequences[2] = set.sequence;
    images.samples = set.samples;
  }
  packets_ = wire::RawPackets(origin_, stamp, images, request_, info);
  next_ = 0;
  start_ = clock_.now();
  not_before_ = start_;
  hurries_ = false;
  retry_ = kRetry / 2;
  if (packets_.count() == 0) {
    lose();
    release();
  }
}

// Spread evenly over most of the time up to the next exposure that is due.
hal::Time RawSender::burst_due() const noexcept {
  if (hurries_) {
    return not_before_;
  }
  const hal::Duration whole =
      std::clamp(std::max<std::int64_t>(request_.every, 1) * period_ * 3 / 4, hal::Duration::zero(),
                 kMostSpread);
  return std::max(start_ + whole * static_cast<std::int64_t>(next_) /
                               static_cast<std::int64_t>(packets_.count()),
                  not_before_);
}

void RawSender::send_until(hal::Time until, Way& way) noexcept {
  while (underway()) {
    const hal::Time now = clock_.now();
    if (now - start_ >= kGiveUp) {
      give_up();
      return;
    }
    const hal::Time due = std::max(burst_due(), now);
    if (due + kMargin > until) {
      return;
    }
    if (due > now) {
      clock_.wait_until(due);
    }
    send_burst(way);
  }
}

void RawSender::send_burst(Way& way) noexcept {
  std::array<std::span<const std::byte>, kBurst> burst;
  const std::size_t count = std::min(kBurst, packets_.count() - next_);
  for (std::size_t i = 0; i < count; ++i) {
    burst[i] = packets_.seal(next_ + i, buffers_[i]);
  }
  std::size_t sent = 0;
  const Status status = way.send_raw(std::span(burst).first(count), sent);
  next_ += sent;
  if (status != Status::kOk && status != Status::kWouldBlock) {
    give_up();
    return;
  }
  retry_ = sent > 0 ? kRetry : std::min(2 * retry_, kMostRetry);
  not_before_ = clock_.now() + (status == Status::kOk ? kGap : retry_);
  if (!underway()) {
    release();
  }
}

void RawSender::give_back(bool pair, bool samples) noexcept {
  if ((pair && stereo_) || (samples && pmd_)) {
    give_up();
  }
}

void RawSender::give_up() noexcept {
  if (underway()) {
    lose();
  }
  release();
}

// An exposure of which nothing has left was not begun, for its receiver: it is counted once, and
// the next one tells what it would have told.
void RawSender::lose() noexcept {
  ++dropped_;
  if (next_ == 0) {
    --number_;
    state_ |= told_state_;
  }
}

void RawSender::release() noexcept {
  packets_ = {};
  next_ = 0;
  stereo_.reset();
  pmd_.reset();
}

}  // namespace stof::firmware
