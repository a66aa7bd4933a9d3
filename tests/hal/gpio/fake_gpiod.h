#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "hal/time.h"

namespace stof::test {

// A chip behind a libgpiod that this test program defines itself (fake_gpiod.cpp): eight lines,
// "GPIO0" to "GPIO3" and four without a name. There is one at a time.
class FakeGpioChip {
 public:
  static constexpr std::size_t kLines = 8;

  FakeGpioChip();
  ~FakeGpioChip();
  FakeGpioChip(const FakeGpioChip&) = delete;
  FakeGpioChip& operator=(const FakeGpioChip&) = delete;

  const std::string& devices() const { return devices_; }  // where its node is

  struct Level {
    hal::Time at{};
    std::array<bool, kLines> high{};  // on the pins
  };
  struct Event {
    unsigned line = 0;
    bool rising = false;
    hal::Time at{};
    std::uint64_t number = 0;
  };
  void tell(unsigned line, bool rising, hal::Time at) {
    events.push_back({line, rising, at, ++numbers.at(line)});
  }

  std::vector<Level> levels;  // after each call that set some
  std::vector<Event> events;  // not read yet
  std::array<std::uint64_t, kLines> numbers{};
  std::array<bool, kLines> high{};
  std::array<bool, kLines> active_low{};
  std::array<bool, kLines> output{};
  std::array<bool, kLines> tells_edges{};
  std::array<bool, kLines> pulled_up{};
  int open_error = 0;
  int request_error = 0;
  int set_error = 0;
  int value_error = 0;  // of reading a line
  hal::Duration set_takes{};
  int open_chips = 0;
  int requests = 0;

 private:
  std::string devices_;
};

}  // namespace stof::test
