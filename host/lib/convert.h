#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string_view>

#include "firmware/wire/messages/calibration.h"
#include "firmware/wire/messages/event.h"
#include "firmware/wire/messages/health.h"
#include "host/client/raw/raw_exposure.h"
#include "host/client/receiver.h"
#include "host/client/session/clock_map.h"
#include "host/client/session/link_events.h"
#include "host/client/session/link_watch.h"
#include "host/client/statistics.h"
#include "host/lib/include/stof/stof.h"
#include "host/lib/played.h"

// Between our structures and those of the C interface.
namespace stof::lib {

// stof_frame::self points to this.
struct Taken {
  client::Frame frame;
  // One of them has the images; none: they are kept.
  client::Receiver* receiver = nullptr;
  Played* played = nullptr;
  std::int64_t exposure_here_ns = 0;  // 0: unknown
  std::int64_t recorded_ns = 0;       // 0: not of a recording
};

// Of a frame that stof_next() filled in; nullptr: of another one, or of a program that does not
// know that field.
inline const Taken* taken_of(const stof_frame* frame) noexcept {
  constexpr std::size_t kUpToSelf = offsetof(stof_frame, self) + sizeof(stof_frame::self);
  return frame == nullptr || frame->struct_size < kUpToSelf
             ? nullptr
             : static_cast<const Taken*>(frame->self);
}

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
// The same, and how old it is by this machine's clock.
stof_health with_age(stof_health health, const client::LinkState& state) noexcept;
// CLOCK_MONOTONIC of a stamp of the sensor.
std::int64_t here_ns(std::int64_t sensor_ns, const client::ClockMapping& mapping) noexcept;
stof_link to_link(const client::LinkState& state) noexcept;
stof_link_event to_link_event(const client::LinkEvent& event) noexcept;
stof_raw to_raw(const client::RawExposure& exposure) noexcept;
stof_event to_event(const wire::EventReport& report) noexcept;
stof_statistics to_statistics(const client::Statistics& statistics, int socket_buffer) noexcept;

}  // namespace stof::lib
