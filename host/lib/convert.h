#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <optional>
#include <string_view>
#include <vector>

#include "firmware/wire/messages/calibration.h"
#include "firmware/wire/messages/event.h"
#include "firmware/wire/messages/health.h"
#include "host/client/frame/point_cloud.h"
#include "host/client/receiver.h"
#include "host/client/session/link_watch.h"
#include "host/client/statistics.h"
#include "host/lib/include/stof/stof.h"

// Between our structures and those of the C interface.
namespace stof::lib {

// stof_frame::self points to this.
struct Taken {
  client::Frame frame;
  std::vector<client::Point>* points = nullptr;  // of the sensor: keeps its memory
  client::Receiver* receiver = nullptr;          // that has the images; none: they are kept
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
stof_link to_link(const client::LinkState& state) noexcept;
stof_event to_event(const wire::EventReport& report) noexcept;
stof_statistics to_statistics(const client::Statistics& statistics, int socket_buffer) noexcept;

}  // namespace stof::lib
