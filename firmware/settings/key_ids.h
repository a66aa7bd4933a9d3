#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "firmware/wire/keys/key_table.h"

namespace stof::settings {

// Ids of keys, 0 for the cable, each once; as many as a sensor has. Where more come, the oldest
// goes.
class KeyIds {
 public:
  void add(std::uint32_t id) noexcept {
    static_cast<void>(take(id));
    if (count_ == ids_.size()) {
      static_cast<void>(take(ids_[0]));
    }
    ids_[count_++] = id;
  }

  bool has(std::uint32_t id) const noexcept {
    return std::find(ids_.begin(), ids_.begin() + count_, id) != ids_.begin() + count_;
  }

  // Removes it; false: it is not here.
  bool take(std::uint32_t id) noexcept {
    const auto end = ids_.begin() + count_;
    const auto rest = std::remove(ids_.begin(), end, id);
    count_ = static_cast<std::size_t>(rest - ids_.begin());
    return rest != end;
  }

 private:
  std::array<std::uint32_t, wire::kMostSensorKeys + 1> ids_{};
  std::size_t count_ = 0;
};

}  // namespace stof::settings
