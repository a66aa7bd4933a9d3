#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "host/cli/live/link_teller.h"
#include "host/cli/receive.h"

namespace stof::host {

// Receives from one sensor until something ends it: `stof stats`, `health`, `check`, `export`,
// `info` and `report` share it.
class Reception {
 public:
  struct Listener {
    std::function<void(const client::Frame&)> frame{};  // its views end with the call
    std::function<void(const wire::EventReport&)> event{};
    std::function<void(const std::string&)> line{};           // for people, at once
    std::function<void(const LinkTeller::Change&)> change{};  // the link's, of `line` one by one
  };

  // Subscribes, or listens where no sensor is named. Throws Failure.
  Reception(const ReceiveOptions& options, Listener listener);

  enum class Awaited : std::uint8_t {
    kFrames,
    kAnything,  // health is enough
  };
  // Until done() says so, a signal, or ReceiveOptions::timeout_s without what is awaited of the
  // sensor. Throws Failure where the socket fails.
  void run(const std::function<bool()>& done, Awaited awaited = Awaited::kFrames);

  client::Receiver& receiver() noexcept { return receiver_; }
  std::string place() const { return place_of(receiver_); }
  std::uint64_t frames() const noexcept { return frames_; }
  bool silent() const noexcept { return silent_; }  // the last run() ended by the timeout
  const LinkTeller& link() const noexcept { return teller_; }
  // Of the first frame; none: no frame came.
  std::optional<std::uint32_t> device() const noexcept { return device_; }

  // Throws Failure, code 1: why no frame came, or why there are too few, and what to do.
  [[noreturn]] void fail();

 private:
  void take(const Result<client::Frame>& frame);

  ReceiveOptions options_;
  Listener listener_;
  client::Receiver receiver_;
  LinkTeller teller_;
  std::optional<std::uint32_t> device_;
  std::uint64_t frames_ = 0;
  wire::ClockState clock_ = wire::ClockState::kMonotonic;  // of the last frame
  bool silent_ = false;
};

}  // namespace stof::host
