#include <algorithm>
#include <chrono>
#include <cstddef>
#include <limits>
#include <memory>
#include <string>
#include <utility>

#include "host/client/control/known_sensors.h"
#include "host/client/control/user_keys.h"
#include "host/lib/sensor.h"

using namespace stof;
using lib::guarded;

namespace {

client::ReceiverOptions receiver_options(const stof_options& options) {
  client::ReceiverOptions out;
  if (options.sensor != nullptr) {
    out.sensor = options.sensor;
  }
  if (options.bind != nullptr) {
    out.address = options.bind;
  }
  out.port = options.port != 0 ? options.port : out.port;
  if (options.device_id != 0) {
    out.reassembler.device_id = options.device_id;
  }
  constexpr std::uint32_t kMost = std::numeric_limits<int>::max();
  if (options.socket_buffer != 0) {
    out.socket_buffer = static_cast<int>(std::min(options.socket_buffer, kMost));
  }
  if (options.max_pixels != 0) {
    out.reassembler.max_pixels = options.max_pixels;
  }
  if (options.max_age_ms != 0) {
    out.reassembler.max_age = std::chrono::milliseconds(options.max_age_ms);
  }
  return out;
}

// What cannot be wanted together; nullptr: it can.
const char* other_ways_doubt(const stof_options& options) noexcept {
  const int ways = (options.sensor != nullptr ? 1 : 0) + (options.recording != nullptr ? 1 : 0) +
                   (options.line != nullptr ? 1 : 0);
  if (ways > 1) {
    return "stof_open: sensor, recording and line are three ways: name one";
  }
  const bool other = options.recording != nullptr || options.line != nullptr;
  if (other && (options.signed_streams != 0 || options.key_id != 0 || options.raw_pictures != 0)) {
    return "stof_open: signed_streams, key_id and raw_pictures take a sensor to subscribe at, and "
           "no "
           "recording or line";
  }
  return nullptr;
}

stof_status open_recording(const stof_options& options, stof_sensor** sensor, char* why,
                           std::size_t why_size) {
  auto playback = recording::Playback::open(options.recording);
  if (!playback) {
    lib::give_text(playback.error().message, why, why_size);
    return STOF_FILE;
  }
  auto opened = std::make_unique<stof_sensor>(
      std::make_unique<lib::Played>(*std::move(playback), options.pace_percent));
  opened->share();
  *sensor = opened.release();
  return STOF_OK;
}

constexpr std::uint16_t kMostRawStep = 255;

wire::RawRequest raw_request(const stof_options& options) noexcept {
  return {.pictures = static_cast<std::uint8_t>(options.raw_pictures & 15U),
          .step = static_cast<std::uint8_t>(options.raw_step),
          .every = options.raw_every,
          .column = options.raw_part[0],
          .row = options.raw_part[1],
          .width = options.raw_part[2],
          .height = options.raw_part[3]};
}

// What signs and is believed. False: `why` says why not.
bool take_keys(const stof_options& options, const std::string& file,
               client::ReceiverOptions& wanted, std::string& why) {
  if (options.signed_streams == 0 && options.key_id == 0) {
    return true;
  }
  auto keys = client::read_user_keys(file);
  if (!keys) {
    why = keys.error().message;
    return false;
  }
  auto meant =
      client::meant_sensor(file, *keys, wanted.sensor,
                           {.device = wanted.reassembler.device_id, .key_id = options.key_id});
  if (!meant || !meant->doubt.empty()) {
    why = meant ? "stof_open: " + meant->doubt + " in stof_options::device_id or key_id"
                : meant.error().message;
    return false;
  }
  wanted.subscription.signed_streams = options.signed_streams != 0;
  wanted.subscription.keys = meant->keys;
  wanted.subscription.reread = client::rereading(file);
  wanted.reassembler.device_id = meant->device;
  return true;
}

// Likewise.
bool take_raw(const stof_options& options, client::ReceiverOptions& wanted, std::string& why) {
  if (options.raw_pictures == 0) {
    return true;
  }
  if (wanted.sensor.empty() || options.raw_step > kMostRawStep) {
    why = "stof_open: raw_pictures: takes a sensor to subscribe at, and a raw_step of at most 255";
    return false;
  }
  wanted.subscription.raw = raw_request(options);
  return true;
}

}  // namespace

extern "C" {

stof_status stof_open(const stof_options* options, stof_sensor** sensor, char* why,
                      size_t why_size) {
  const auto known = lib::read(options);
  lib::give_text("", why, why_size);
  if (sensor == nullptr || !known) {
    lib::give_text("stof_open: no options, or without struct_size: use STOF_INIT(stof_options)",
                   why, why_size);
    return STOF_BAD_ARGUMENT;
  }
  *sensor = nullptr;
  return guarded([&] {
    if (const char* const doubt = other_ways_doubt(*known); doubt != nullptr) {
      lib::give_text(doubt, why, why_size);
      return STOF_BAD_ARGUMENT;
    }
    if (known->recording != nullptr) {
      return open_recording(*known, sensor, why, why_size);
    }
    client::ReceiverOptions wanted = receiver_options(*known);
    if (known->line != nullptr) {
      const unsigned baud = known->baud != 0 ? known->baud : client::kDefaultBaud;
      auto line = client::SerialLine::open(known->line, baud);
      if (!line) {
        lib::give_text(line.error().message, why, why_size);
        return lib::to_status(line.error().status);
      }
      wanted.line = *std::move(line);
    }
    const std::string key_file = known->keys == nullptr ? client::user_keys_file() : known->keys;
    if (std::string wrong;
        !take_keys(*known, key_file, wanted, wrong) || !take_raw(*known, wanted, wrong)) {
      lib::give_text(wrong, why, why_size);
      return STOF_BAD_ARGUMENT;
    }
    auto receiver = client::Receiver::open(wanted);
    if (!receiver) {
      lib::give_text(receiver.error().message, why, why_size);
      return lib::to_status(receiver.error().status);
    }
    auto opened = std::make_unique<stof_sensor>(std::move(*receiver), wanted.sensor, key_file,
                                                known->device_id, known->key_id);
    opened->raw = known->raw_pictures != 0;
    opened->line = wanted.line;
    opened->is_signed = known->signed_streams != 0;
    opened->share();
    *sensor = opened.release();
    return STOF_OK;
  });
}

}  // extern "C"
