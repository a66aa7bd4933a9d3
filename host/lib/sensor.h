#pragma once

#include <atomic>
#include <cstddef>
#include <deque>
#include <memory>
#include <mutex>
#include <new>
#include <optional>
#include <string>
#include <thread>

#include "host/client/control/control_client.h"
#include "host/client/receiver.h"
#include "host/client/serial/serial_line.h"
#include "host/client/session/clock_map.h"
#include "host/client/session/link_events.h"
#include "host/lib/convert.h"
#include "host/lib/include/stof/stof.h"
#include "host/lib/played.h"
#include "host/lib/record.h"

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
  stof::client::FramePixels pixels{};         // of a sensor
  stof::recording::RecordedFrame recorded{};  // of a recording
  stof::lib::Taken taken{};
  std::atomic<std::uint32_t> holders{1};
};

// NOLINTNEXTLINE(readability-identifier-naming): a name of the C interface.
struct stof_sensor {
  stof_sensor(stof::client::Receiver&& opened, std::string at, std::string key_file,
              std::uint32_t number, std::uint32_t key)
      : receiver(std::move(opened)),
        sensor(std::move(at)),
        keys(std::move(key_file)),
        device_id(number),
        key_id(key),
        watch(receiver->link_watch()) {}
  explicit stof_sensor(std::unique_ptr<stof::lib::Played> recorded) : played(std::move(recorded)) {}

  // One of the two, of the thread below while it runs, else of the caller.
  std::optional<stof::client::Receiver> receiver{};
  std::unique_ptr<stof::lib::Played> played{};
  std::shared_ptr<stof::client::SerialLine> line{};  // that the receiver reads; none: a socket
  std::string sensor;                                // as given; empty: none
  std::string keys;                                  // file of keys; empty: none
  std::uint32_t device_id = 0;                       // 0: whoever answers
  std::uint32_t key_id = 0;                          // that alone counts; 0: any
  bool raw = false;                                  // what the cameras gave was asked for
  bool is_signed = false;                            // only what is signed counts
  stof::lib::Taken taken{};

  std::thread thread{};
  std::atomic<bool> running{false};  // the thread owns the receiver
  std::atomic<bool> stopping{false};
  stof_callbacks callbacks{};
  std::optional<std::uint64_t> told_health_ms{};  // uptime of the one that was reported last
  static constexpr std::size_t kMostEvents = 64;
  std::deque<stof::wire::EventReport> events{};  // that nobody took yet

  // The state that any thread may ask for.
  std::mutex shared{};
  stof_statistics statistics{};
  std::optional<stof_health> health{};
  std::string advice{};
  stof::client::LinkWatch watch{{}};
  std::optional<stof::client::LinkState> played_link{};  // of a recording, in place of the watch
  stof::client::LinkEvents link_events{};
  stof::client::ClockMap clock{};

  std::mutex control_mutex{};
  std::unique_ptr<stof::client::ControlClient> control{};
  std::string schema{};  // of the settings, once it was asked for

  std::mutex record_mutex{};
  std::unique_ptr<stof::lib::Record> record{};  // that goes on
  std::optional<stof_recorded> recorded{};      // of the last one, at its end

  // Reads the next frame into `taken` and renews what any thread may ask for.
  stof_status receive(stof::client::Duration timeout);
  stof_status receive_live(stof::client::Duration timeout);
  stof_status receive_played(stof::client::Duration timeout);
  void keep(const stof::wire::EventReport& event);  // until somebody takes it
  void share();
  void run() noexcept;
  // What came beside a frame, to the callbacks.
  void call_back_reports();
  std::optional<stof::client::LinkEvent> take_link_event();
  stof::client::LinkState link_state();         // locks `shared`
  stof::client::LinkState link_state_shared();  // with `shared`
};

namespace stof::lib {

struct Refusal {
  std::string text;
  stof_status status;
};
// Makes sensor.control, with its mutex.
std::optional<Refusal> open_control(stof_sensor& sensor);

}  // namespace stof::lib
