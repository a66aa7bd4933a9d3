#include "dsp/fusion/drift/rig_motion.h"

#include <cmath>
#include <cstdlib>

namespace stof::dsp {
namespace {

// A turn is known to this share of itself: its rate is that of the frame before, and samples of
// another phase have another middle, up to an eighth of the exposure from it. As much of it may
// last for as long as a rig turns.
constexpr double kTurnShare = 0.25;
// What turned by more says nothing, rad: half a degree, 80 degrees a second during 6 ms.
constexpr double kLargestTurn = 0.009;
// A rig drives this fast at most, metres a second: FusionParams::max_speed_mm_s. Of speeds up to it
// the standard deviation is 0.58 of it.
constexpr double kSpeed = 1.5;
constexpr double kSpeedShare = 0.58;
// Pictures further apart do not tell a rate, us.
constexpr std::int32_t kLongestGap = 250'000;
constexpr double kSecondsPerUs = 1e-6;

}  // namespace

RigMotion::RigMotion(const Pinhole& left, Arena& arena) noexcept
    : left_(left), shift_(left.width, left.height, arena) {}

void RigMotion::forget() noexcept {
  shift_.forget();
  rate_.reset();
}

void RigMotion::follow(ImageView<const std::uint8_t> picture, std::int32_t since_us) noexcept {
  rate_.reset();
  if (picture.width() != left_.width || picture.height() != left_.height) {
    shift_.forget();
    return;
  }
  const std::optional<Shift> shift = shift_.look(picture);
  if (shift && shift->x == 0 && shift->y == 0) {
    rate_ = Shift{};
  } else if (shift && since_us > 0 && since_us <= kLongestGap) {
    rate_ = Shift{.x = shift->x / since_us, .y = shift->y / since_us};
  }
}

std::optional<Moved> RigMotion::during(std::int32_t lag_us, bool something_moves) const noexcept {
  Moved out{.moved = something_moves};
  if (lag_us == 0) {
    return out;
  }
  if (!rate_) {
    return std::nullopt;
  }
  // What is looked at more to the right moves to the left in the picture; further up, down.
  out.pitch = rate_->y * lag_us / left_.fy;
  out.yaw = -rate_->x * lag_us / left_.fx;
  out.moved = something_moves || rate_->x != 0 || rate_->y != 0;
  if (!(std::abs(out.pitch) <= kLargestTurn) || !(std::abs(out.yaw) <= kLargestTurn)) {
    return std::nullopt;
  }
  if (out.moved) {
    out.unsure = {kTurnShare * std::abs(out.pitch), kTurnShare * std::abs(out.yaw), 0,
                  kSpeedShare * kSpeed * kSecondsPerUs * std::abs(lag_us), 0};
  }
  return out;
}

}  // namespace stof::dsp
