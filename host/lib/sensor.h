#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstring>
#include <memory>
#include <mutex>
#include <new>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "host/client/control/control_client.h"
#include "host/client/frame/point_cloud.h"
#include "host/client/receiver.h"
#include "host/lib/include/stof/stof.h"

// What libstof keeps behind its C interface.
namespace stof::lib {

// What stof_frame::self points to.
struct Taken {
  client::Frame frame;
  std::vector<client::Point>* points = nullptr;  // of the sensor: keeps its memory
};

// Fills a structure of a caller who may know less of it, or more. False: it says no size.
template <typename T>
bool give(T* out, T value) noexcept {
  if (out == nullptr || out->struct_size < sizeof out->struct_size) {
    return false;
  }
  const std::uint32_t size = out->struct_size;
  value.struct_size = size;
  std::memcpy(out, &value, std::min<std::size_t>(size, sizeof value));
  return true;
}

// A structure of a caller who may know less of it: the rest is 0. None: it says no size.
template <typename T>
std::optional<T> read(const T* in) noexcept {
  if (in == nullptr || in->struct_size < sizeof in->struct_size) {
    return std::nullopt;
  }
  T value{};
  std::memcpy(&value, in, std::min<std::size_t>(in->struct_size, sizeof value));
  return value;
}

// As much of the text as fits, ended by 0.
void give_text(std::string_view text, char* out, std::size_t size) noexcept;

stof_status to_status(Status status) noexcept;
stof_frame to_frame(const Taken& taken) noexcept;
stof_calibration to_calibration(const wire::CalibrationPacket& packet) noexcept;
stof_health to_health(const wire::HealthReport& report) noexcept;
stof_event to_event(const wire::EventReport& report) noexcept;
stof_statistics to_statistics(const client::Statistics& statistics, int socket_buffer) noexcept;

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

// The type that stof.h names.
// NOLINTNEXTLINE(readability-identifier-naming): a name of the C interface.
struct stof_sensor {
  stof_sensor(stof::client::Receiver opened, std::string at)
      : receiver(std::move(opened)), sensor(std::move(at)) {}

  stof::client::Receiver receiver;  // of the thread below while it runs, else of the caller
  std::string sensor;               // as given; empty: none
  stof::lib::Taken taken{};
  std::vector<stof::client::Point> points{};

  std::thread thread{};
  std::atomic<bool> running{false};  // the thread owns the receiver
  std::atomic<bool> stopping{false};
  stof_callbacks callbacks{};
  std::uint64_t told_health_ms = 0;  // uptime of the one that was told last

  // What any thread may ask for.
  std::mutex shared{};
  stof_statistics statistics{};
  std::optional<stof_health> health{};
  std::string advice{};

  std::mutex control_mutex{};
  std::unique_ptr<stof::client::ControlClient> control{};

  // Reads the next frame into `taken` and renews what any thread may ask for.
  stof_status receive(stof::client::Duration timeout);
  void share();
  void run() noexcept;
};
