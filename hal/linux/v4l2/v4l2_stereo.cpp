#include "hal/linux/v4l2/v4l2_stereo.h"

#include <algorithm>
#include <chrono>
#include <span>
#include <utility>

#include "dsp/base/check.h"

namespace stof::hal::linux {
namespace {

std::string exposure_text(const std::optional<Duration>& exposure) {
  if (!exposure) {
    return "for a time that it does not tell";
  }
  const auto time = std::chrono::duration_cast<std::chrono::microseconds>(*exposure);
  return "for " + std::to_string(time.count()) + " us";
}

}  // namespace

V4l2Stereo::V4l2Stereo(V4l2Calls& calls, hal::Clock& clock, V4l2StereoOptions options)
    : calls_(calls), clock_(clock), options_(std::move(options)) {
  used_ = options_.nodes[1].empty() ? 1 : 2;
  for (std::size_t i = 0; i < used_; ++i) {
    STOF_CHECK(options_.exposures[i] != nullptr);
    V4l2Options device{.node = options_.nodes[i],
                       .width = side_by_side() ? 2 * options_.width : options_.width,
                       .height = options_.height,
                       .formats = options_.formats,
                       .exposure = options_.exposure,
                       .gain = options_.gain,
                       .sysfs = options_.sysfs};
    feeds_[i] = std::make_unique<V4l2Feed>(calls, clock, std::move(device), *options_.exposures[i],
                                           options_.most_delay);
    polled_[i] = feeds_[i].get();
  }
}

V4l2Stereo::~V4l2Stereo() {
  STOF_CHECK(out_ == 0);
  for (std::size_t i = 0; i < used_; ++i) {
    feeds_[i]->drop_all();
  }
}

std::expected<std::unique_ptr<V4l2Stereo>, OpenError> V4l2Stereo::open(V4l2Calls& calls,
                                                                       hal::Clock& clock,
                                                                       V4l2StereoOptions options) {
  std::unique_ptr<V4l2Stereo> camera(new V4l2Stereo(calls, clock, std::move(options)));
  if (auto started = camera->start(); !started) {
    return std::unexpected(std::move(started.error()));
  }
  return camera;
}

Status V4l2Stereo::reopen() noexcept { return start() ? Status::kOk : Status::kDeviceLost; }

std::expected<void, OpenError> V4l2Stereo::start() {
  const std::span<V4l2Feed* const> feeds = std::span(polled_).first(used_);
  for (V4l2Feed* const feed : feeds) {
    feed->forget();
    feed->device().shut();
  }
  corrupt_ = false;
  std::expected<void, OpenError> done;
  for (V4l2Feed* const feed : feeds) {
    done = done ? feed->device().open() : done;
  }
  if (done && !side_by_side()) {
    const V4l2Device& left = feeds_[0]->device();
    const V4l2Device& right = feeds_[1]->device();
    if (left.exposure() != right.exposure()) {
      done = std::unexpected(OpenError{left.name() + ": exposes " + exposure_text(left.exposure()) +
                                       ", " + right.name() + " " + exposure_text(right.exposure()) +
                                       "; use two cameras of one kind"});
    }
  }
  if (!done) {
    for (V4l2Feed* const feed : feeds) {
      feed->device().shut();
    }
    return done;
  }
  const auto pixels =
      static_cast<std::size_t>(options_.width) * static_cast<std::size_t>(options_.height);
  for (std::size_t side = 0; side < 2; ++side) {
    if (converts(side)) {
      for (Slot& slot : slots_) {
        slot.grey[side].resize(pixels);  // once: what is lent stays where it is
      }
    }
  }
  return done;
}

Result<BorrowedFrame<StereoFrame>> V4l2Stereo::wait_frame(Time deadline) noexcept {
  for (;;) {
    if (drain() == Status::kDeviceLost) {
      return fail(Status::kDeviceLost);
    }
    if (match()) {
      return hand_out();
    }
    if (std::exchange(corrupt_, false)) {
      return fail(Status::kCorrupt);
    }
    const Time now = clock_.now();
    if (now >= deadline) {
      return fail(Status::kTimeout);
    }
    wait_for_any(calls_, std::span(polled_).first(used_), deadline - now);
  }
}

// kOk or kDeviceLost.
Status V4l2Stereo::drain() noexcept {
  for (V4l2Feed* const feed : std::span(polled_).first(used_)) {
    const Status status = feed->drain(kSlots - out_);
    if (status == Status::kDeviceLost) {
      return status;
    }
    // Both views of one exposure may be damaged: that is told once.
    if (status == Status::kCorrupt && feed->damaged().begin != corrupt_at_) {
      corrupt_ = true;
      corrupt_at_ = feed->damaged().begin;
    }
  }
  return Status::kOk;
}

// Whether the oldest pictures belong together, after those were dropped whose other view is lost.
bool V4l2Stereo::match() noexcept {
  if (side_by_side()) {
    return feeds_[0]->oldest() != nullptr;
  }
  for (;;) {
    const V4l2Arrival* const left = feeds_[0]->oldest();
    const V4l2Arrival* const right = feeds_[1]->oldest();
    if (left == nullptr || right == nullptr) {
      return false;
    }
    if (together(*left, *right)) {
      return true;
    }
    if (left->matched != right->matched) {
      drop(left->matched ? 1 : 0);
    } else {
      drop(left->exposure.begin < right->exposure.begin ? 0 : 1);
    }
  }
}

bool V4l2Stereo::together(const V4l2Arrival& left, const V4l2Arrival& right) const noexcept {
  if (left.matched && right.matched) {
    return left.exposure.begin < right.exposure.end && right.exposure.begin < left.exposure.end;
  }
  const Duration apart = left.exposure.begin - right.exposure.begin;
  return left.matched == right.matched && apart <= options_.most_delay &&
         apart >= -options_.most_delay;
}

void V4l2Stereo::drop(std::size_t side) noexcept {
  const V4l2Arrival gone = feeds_[side]->take();
  feeds_[side]->device().release(gone.buffer);
  ++counters_.unpaired;
  if (!gone.matched) {
    ++counters_.unmatched;
  }
}

BorrowedFrame<StereoFrame> V4l2Stereo::hand_out() noexcept {
  const auto free = std::ranges::find(slots_, false, &Slot::out);
  STOF_CHECK(free != slots_.end());  // drain() keeps no more than there are slots
  Slot& slot = *free;
  slot.out = true;
  ++out_;
  ++counters_.frames;
  std::array<V4l2Arrival, 2> pair;
  pair[0] = feeds_[0]->take();
  pair[1] = side_by_side() ? pair[0] : feeds_[1]->take();
  const StereoFrame frame{.left = view(slot, 0, pair[0].buffer),
                          .right = view(slot, 1, pair[1].buffer),
                          .left_exposure = pair[0].exposure,
                          .right_exposure = pair[1].exposure,
                          .left_sequence = pair[0].buffer.sequence,
                          .right_sequence = pair[1].buffer.sequence};
  for (std::size_t i = 0; i < used_; ++i) {
    if (converts(i)) {
      feeds_[i]->device().release(pair[i].buffer);
    } else {
      slot.held[i] = pair[i].buffer;
    }
  }
  return {frame, *this, static_cast<int>(free - slots_.begin())};
}

const V4l2Format& V4l2Stereo::format(std::size_t side) const noexcept {
  return polled_[std::min(side, used_ - 1)]->device().format();
}

bool V4l2Stereo::converts(std::size_t side) const noexcept {
  return options_.copy || format(side).pixels != kGrey;
}

dsp::ImageView<const std::uint8_t> V4l2Stereo::view(Slot& slot, std::size_t side,
                                                    const V4l2Buffer& buffer) noexcept {
  const auto [pixels, stride] = format(side);
  const std::size_t row = row_bytes(pixels, options_.width);
  const std::uint8_t* const first = buffer.data + (side_by_side() ? side * row : 0);
  if (!converts(side)) {
    return {first, options_.width, options_.height, static_cast<std::ptrdiff_t>(stride)};
  }
  const dsp::ImageView<std::uint8_t> grey(slot.grey[side].data(), options_.width, options_.height);
  for (int y = 0; y < options_.height; ++y) {
    to_grey(pixels, {first + static_cast<std::size_t>(y) * stride, row}, grey.row(y));
  }
  return grey;
}

void V4l2Stereo::give_back(int slot) noexcept {
  Slot& home = slots_[static_cast<std::size_t>(slot)];
  STOF_CHECK(home.out);
  for (std::size_t i = 0; i < used_; ++i) {
    if (home.held[i]) {
      feeds_[i]->device().release(*home.held[i]);
      home.held[i].reset();
    }
  }
  home.out = false;
  --out_;
}

V4l2StereoCounters V4l2Stereo::counters() const noexcept {
  V4l2StereoCounters all = counters_;
  for (std::size_t side = 0; side < 2; ++side) {
    all.devices[side] = polled_[std::min(side, used_ - 1)]->device().counters();
  }
  return all;
}

}  // namespace stof::hal::linux
