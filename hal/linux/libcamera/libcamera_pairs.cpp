#include "hal/linux/libcamera/libcamera_pairs.h"

#include <algorithm>
#include <chrono>

#include "dsp/base/check.h"

namespace stof::hal::linux {

std::optional<Exposure> LibcameraPairs::exposure_of(std::size_t side,
                                                    const LibcameraArrival& arrival) noexcept {
  if (!matchers_[side]) {
    return Exposure{arrival.stamp - matching_.exposure, arrival.stamp};
  }
  const MatchedExposure matched = matchers_[side]->match(arrival.stamp, arrival.sequence);
  return matched.sure ? std::optional(matched.exposure) : std::nullopt;
}

void LibcameraPairs::send_home(std::size_t side, int slot) noexcept {
  queues_[side].give_back(slot);
  requeuer_.requeue(side, slot);
}

Status LibcameraPairs::fill(std::size_t side) noexcept {
  while (!heads_[side]) {
    const std::optional<int> slot = queues_[side].take();
    if (!slot) {
      return Status::kWouldBlock;
    }
    const LibcameraArrival arrival = queues_[side].arrival(*slot);
    const std::optional<Exposure> exposure = exposure_of(side, arrival);
    if (arrival.damaged) {
      send_home(side, *slot);
      return Status::kCorrupt;
    }
    if (matchers_[side] && matchers_[side]->hopeless()) {
      send_home(side, *slot);
      return Status::kDeviceLost;
    }
    if (exposure) {
      heads_[side] = Frame{.slot = *slot, .exposure = *exposure, .sequence = arrival.sequence};
    } else {
      send_home(side, *slot);
    }
  }
  return Status::kOk;
}

Result<LibcameraPairs::Pair> LibcameraPairs::next() noexcept {
  for (;;) {
    // Both, so that a damaged frame is told of even where the other side waits.
    const Status left = fill(kLeft);
    const bool told = left == Status::kCorrupt || left == Status::kDeviceLost;
    const Status right = told ? left : fill(kRight);
    if (right != Status::kOk || left != Status::kOk) {
      return fail(right != Status::kOk ? right : left);
    }
    const Duration skew = heads_[kRight]->exposure.begin - heads_[kLeft]->exposure.begin;
    Lent* const spare = std::ranges::find(lent_, false, &Lent::out);
    if (std::chrono::abs(skew) > matching_.most_skew || spare == lent_.end()) {
      const std::size_t older = skew < Duration{0} ? kRight : kLeft;
      send_home(older, heads_[older]->slot);
      heads_[older].reset();
      continue;
    }
    *spare = {.out = true, .old = false, .slots = {heads_[kLeft]->slot, heads_[kRight]->slot}};
    const Pair pair{.number = static_cast<int>(spare - lent_.begin()),
                    .frames = {*heads_[kLeft], *heads_[kRight]}};
    heads_ = {};
    return pair;
  }
}

void LibcameraPairs::give_back(int number) noexcept {
  Lent& lent = lent_[static_cast<std::size_t>(number)];
  STOF_CHECK(lent.out);
  lent.out = false;
  if (!lent.old) {
    send_home(kLeft, lent.slots[kLeft]);
    send_home(kRight, lent.slots[kRight]);
  }
}

void LibcameraPairs::start_over() noexcept {
  heads_ = {};
  for (std::optional<ExposureMatcher>& matcher : matchers_) {
    if (matcher) {
      matcher->forget();
    }
  }
  for (Lent& lent : lent_) {
    lent.old = lent.out;
  }
}

bool LibcameraPairs::old_ones_out() const noexcept {
  return std::ranges::any_of(lent_, [](const Lent& lent) { return lent.out && lent.old; });
}

}  // namespace stof::hal::linux
