#pragma once

#include <cstddef>
#include <cstdint>

#include "firmware/wire/keys/key_table.h"
#include "tests/support/random.h"

namespace stof::test {

// A key, of every number another one.
inline wire::Key numbered_key(std::uint32_t number, wire::Role role = wire::Role::kAdmin) {
  wire::Key key{.id = number, .device = 1, .role = role, .name = wire::key_name("test")};
  Random random(number);
  for (std::byte& byte : key.secret) {
    byte = static_cast<std::byte>(random.next());
  }
  return key;
}

}  // namespace stof::test
