#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <new>
#include <optional>
#include <string>
#include <thread>

#include "host/client/control/control_client.h"
#include "host/client/receiver.h"
#include "host/client/session/clock_map.h"
#include "host/client/session/link_events.h"
#include "host/lib/convert.h"
#include "host/lib/include/stof/stof.h"

// The state behind libstof's C interface.
namespace stof::lib {

// No exception passes the interface.
template <typename Work>
stof_status guarded(Work&& work) noexcept {
  try {
    return std::forward<Work>(work)();
  } catch (const std::bad_alloc&) {
    return STOF_NO_MEMORY;
  } catch (...) {
    return STOF_INTERNAL;
  }
}

}  // namespace stof::lib

// The types that stof.h names.
// NOLINTNEXTLINE(readability-identifier-naming): a name of the C interface.
struct stof_kept {
  stof::client::FramePixels pixels{};
  stof::lib::Taken taken{};
  std::atomic<std::uint32_t> holders{1};
};

// NOLINTNEXTLINE(readability-identifier-naming): a name of the C interface.
struct stof_sensor {
  stof_sensor(stof::client::Receiver opened, std::string at, std::string key_file,
              std::uint32_t number, std::uint32_t key)
      : receiver(std::move(opened)),
        sensor(std::move(at)),
        keys(std::move(key_file)),
        device_id(number),
        key_id(key),
        watch(receiver.link_watch()) {}

  stof::client::Receiver receiver;  // of the thread below while it runs, else of the caller
  std::string sensor;               // as given; empty: none
  std::string keys;                 // file of keys; empty: none
  std::uint32_t device_id;          // 0: whoever answers
  std::uint32_t key_id;             // that alone counts; 0: any
  bool raw = false;                 // what the cameras gave was asked for
  stof::lib::Taken taken{};

  std::thread thread{};
  std::atomic<bool> running{false};  // the thread owns the receiver
  std::atomic<bool> stopping{false};
  stof_callbacks callbacks{};
  std::uint64_t told_health_ms = 0;  // uptime of the one that was reported last

  // The state that any thread may ask for.
  std::mutex shared{};
  stof_statistics statistics{};
  std::optional<stof_health> health{};
  std::string advice{};
  stof::client::LinkWatch watch;
  stof::client::LinkEvents link_events{};
  stof::client::ClockMap clock{};

  std::mutex control_mutex{};
  std::unique_ptr<stof::client::ControlClient> control{};
  std::string schema{};  // of the settings, once it was asked for

  // Reads the next frame into `taken` and renews what any thread may ask for.
  stof_status receive(stof::client::Duration timeout);
  void share();
  void run() noexcept;
  // What came beside a frame, to the callbacks.
  void call_back_reports();
  std::optional<stof::client::LinkEvent> take_link_event();
  stof::client::LinkState link_state();
};
