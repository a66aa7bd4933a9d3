#include "firmware/settings/permission.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <string_view>

#include "firmware/settings/fields/field.h"
#include "firmware/settings/fields/field_value.h"

namespace stof::settings {
namespace {

using wire::Coding;
using wire::Stream;

// What depth is seen by.
constexpr std::array kKept{Stream::kDepth, Stream::kWidth, Stream::kSource, Stream::kCloud};

bool switched_off(const Settings& active, const Settings& next) noexcept {
  return std::ranges::any_of(kKept, [&](Stream stream) {
    return active.streams.of(stream) != Coding::kOff && next.streams.of(stream) == Coding::kOff;
  });
}

// Of what everybody but the admin changes.
bool within_limits(const Settings& active, const Settings& next, PagedWriter& why) noexcept {
  const LimitSettings& limits = active.limits;
  if (next.depth.max_range_mm != active.depth.max_range_mm &&
      next.depth.max_range_mm < limits.least_range_mm) {
    why << "depth.max_range_mm: limits.least_range_mm is " << limits.least_range_mm;
    return false;
  }
  if (next.period_ms != active.period_ms &&
      (next.period_ms < limits.least_period_ms || next.period_ms > limits.most_period_ms)) {
    why << "period_ms: limits.least_period_ms is " << limits.least_period_ms
        << ", limits.most_period_ms is " << limits.most_period_ms;
    return false;
  }
  const bool fixed = limits.streams == StreamLimit::kFixed && !(next.streams == active.streams);
  if (fixed || (limits.streams == StreamLimit::kKeep && switched_off(active, next))) {
    why << "streams: limits.streams is "
        << (fixed ? "fixed" : "keep: depth, width, source and cloud are not switched off");
    return false;
  }
  return true;
}

}  // namespace

bool deny(std::string_view what, Access access, Access least, PagedWriter& why) noexcept {
  why << what << ": takes a key with role " << (least == Access::kAdmin ? "admin" : "tune or admin")
      << (access < Access::kTune ? ": pair with the sensor (stof pair), or use its cable" : "");
  return false;
}

bool permitted(const Settings& active, const Settings& next, Access access,
               PagedWriter& why) noexcept {
  const std::size_t count = field_count();
  for (std::size_t place = 0; place < count; ++place) {
    const Field known = field(place);
    if (known.access > access && !equal(known, active, next)) {
      std::array<char, 64> space;
      PagedWriter path(space);
      path << known.group << (known.group.empty() ? "" : ".") << known.name;
      return deny(path.text(), access, known.access, why);
    }
  }
  return access == Access::kAdmin || within_limits(active, next, why);
}

}  // namespace stof::settings
