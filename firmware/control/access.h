#pragma once

#include <cstdint>

#include "firmware/wire/messages/enums.h"

namespace stof::firmware {

// What somebody may change, from least to most; everybody may read.
enum class Access : std::uint8_t {
  kRead,      // nothing
  kHarmless,  // settings that neither blind the sensor nor put it out of reach; never saves
  kTune,      // how depth is computed and sent, within the installer's limits; saves
  kAdmin,     // everything
};

constexpr Access access_of(wire::Role role) noexcept {
  switch (role) {
    case wire::Role::kTune:
      return Access::kTune;
    case wire::Role::kAdmin:
      return Access::kAdmin;
    default:
      return Access::kRead;
  }
}

}  // namespace stof::firmware
