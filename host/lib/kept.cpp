#include <memory>

#include "host/lib/sensor.h"

using namespace stof;
using lib::guarded;

namespace {

// A frame that nobody else holds, to be written to. The holder of the last reference is alone.
bool alone(const stof_kept& kept) noexcept {
  return kept.holders.load(std::memory_order_acquire) == 1;
}

}  // namespace

extern "C" {

stof_status stof_keep(stof_frame* frame, stof_kept** kept) {
  const lib::Taken* const taken = lib::taken_of(frame);
  if (taken == nullptr || kept == nullptr) {
    return STOF_BAD_ARGUMENT;
  }
  return guarded([&] {
    if ((taken->receiver == nullptr && taken->played == nullptr) ||
        taken->frame.stamp.number != frame->number) {
      return STOF_BAD_ARGUMENT;
    }
    // What others hold as well is theirs.
    const bool reuse = *kept != nullptr && alone(**kept);
    std::unique_ptr<stof_kept> made = reuse ? nullptr : std::make_unique<stof_kept>();
    stof_kept* const to = reuse ? *kept : made.get();
    if (!(taken->played != nullptr ? taken->played->keep(to->recorded)
                                   : taken->receiver->keep(to->pixels))) {
      return STOF_BAD_ARGUMENT;
    }
    to->taken = *taken;
    to->taken.receiver = nullptr;
    to->taken.played = nullptr;
    frame->self = &to->taken;
    if (!reuse) {
      stof_release(*kept);
      *kept = made.release();
    }
    return STOF_OK;
  });
}

stof_kept* stof_hold(stof_kept* kept) {
  if (kept != nullptr) {
    kept->holders.fetch_add(1, std::memory_order_relaxed);
  }
  return kept;
}

void stof_release(stof_kept* kept) {
  if (kept != nullptr && kept->holders.fetch_sub(1, std::memory_order_acq_rel) == 1) {
    delete kept;
  }
}

}  // extern "C"
