#include "host/lib/sensor.h"

#include <chrono>
#include <cstddef>
#include <limits>
#include <system_error>
#include <utility>

#include "host/client/control/known_sensors.h"
#include "host/client/control/user_keys.h"

using namespace stof;
using lib::guarded;

namespace {

constexpr client::Duration kPoll = std::chrono::milliseconds(100);  // how soon a stop is seen

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

}  // namespace

void stof_sensor::share() {
  const stof_statistics now = lib::to_statistics(receiver.statistics(), receiver.socket_buffer());
  std::string new_advice = receiver.advice();
  const std::scoped_lock lock(shared);
  statistics = now;
  advice = std::move(new_advice);
  watch = receiver.link_watch();
  const client::Time time = client::Time::clock::now();
  link_events.look(watch.state(time), receiver.statistics().sessions, time);
  if (receiver.health()) {
    health = lib::to_health(*receiver.health());
  }
}

stof_status stof_sensor::receive(client::Duration timeout) {
  const Result<client::Frame> frame = receiver.next(timeout);
  share();
  if (!frame) {
    return lib::to_status(frame.error());
  }
  taken = {.frame = *frame, .receiver = &receiver};
  const std::scoped_lock lock(shared);
  clock.add(*frame);
  if (const auto mapping = clock.mapping(); mapping && !clock.unmappable()) {
    taken.exposure_here_ns = lib::here_ns(frame->stamp.exposure_middle_ns, *mapping);
  }
  return STOF_OK;
}

void stof_sensor::run() noexcept {
  stof_status status = STOF_OK;
  while (!stopping && (status == STOF_OK || status == STOF_TIMEOUT)) {
    status = guarded([this] { return receive(kPoll); });
    if (status == STOF_OK && callbacks.frame != nullptr) {
      stof_frame frame = lib::to_frame(taken);
      frame.struct_size = sizeof frame;
      callbacks.frame(callbacks.user, &frame);
    }
    call_back_reports();
  }
  if (!stopping && callbacks.failed != nullptr) {
    callbacks.failed(callbacks.user, status);
  }
}

void stof_sensor::call_back_reports() {
  while (const auto event = receiver.take_event()) {
    stof_event told = lib::to_event(*event);
    told.struct_size = sizeof told;
    if (callbacks.event != nullptr) {
      callbacks.event(callbacks.user, &told);
    }
  }
  while (const auto event = take_link_event()) {
    stof_link_event told = lib::to_link_event(*event);
    told.struct_size = sizeof told;
    if (callbacks.link != nullptr) {
      callbacks.link(callbacks.user, &told);
    }
  }
  while (const auto exposure = receiver.take_raw()) {
    stof_raw told = lib::to_raw(*exposure);
    told.struct_size = sizeof told;
    if (callbacks.raw != nullptr) {
      callbacks.raw(callbacks.user, &told);
    }
  }
  const auto& report = receiver.health();
  if (report && report->uptime_ms != told_health_ms && callbacks.health != nullptr) {
    told_health_ms = report->uptime_ms;
    stof_health told = lib::with_age(lib::to_health(*report), link_state());
    told.struct_size = sizeof told;
    callbacks.health(callbacks.user, &told);
  }
}

std::optional<client::LinkEvent> stof_sensor::take_link_event() {
  const std::scoped_lock lock(shared);
  return link_events.take();
}

client::LinkState stof_sensor::link_state() {
  const std::scoped_lock lock(shared);
  return watch.state(client::Time::clock::now());
}

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
    client::ReceiverOptions wanted = receiver_options(*known);
    const std::string key_file = known->keys == nullptr ? client::user_keys_file() : known->keys;
    if (known->signed_streams != 0 || known->key_id != 0) {
      auto keys = client::read_user_keys(key_file);
      if (!keys) {
        lib::give_text(keys.error().message, why, why_size);
        return STOF_BAD_ARGUMENT;
      }
      auto meant =
          client::meant_sensor(key_file, *keys, wanted.sensor,
                               {.device = wanted.reassembler.device_id, .key_id = known->key_id});
      if (!meant || !meant->doubt.empty()) {
        lib::give_text(meant
                           ? "stof_open: " + meant->doubt + " in stof_options::device_id or key_id"
                           : meant.error().message,
                       why, why_size);
        return STOF_BAD_ARGUMENT;
      }
      wanted.subscription.signed_streams = known->signed_streams != 0;
      wanted.subscription.keys = meant->keys;
      wanted.subscription.reread = client::rereading(key_file);
      wanted.reassembler.device_id = meant->device;
    }
    if (known->raw_pictures != 0) {
      if (wanted.sensor.empty() || known->raw_step > kMostRawStep) {
        lib::give_text(
            "stof_open: raw_pictures: takes a sensor to subscribe at, and a raw_step of "
            "at most 255",
            why, why_size);
        return STOF_BAD_ARGUMENT;
      }
      wanted.subscription.raw = raw_request(*known);
    }
    auto receiver = client::Receiver::open(wanted);
    if (!receiver) {
      lib::give_text(receiver.error().message, why, why_size);
      return lib::to_status(receiver.error().status);
    }
    auto opened = std::make_unique<stof_sensor>(std::move(*receiver), wanted.sensor, key_file,
                                                known->device_id, known->key_id);
    opened->raw = known->raw_pictures != 0;
    opened->share();
    *sensor = opened.release();
    return STOF_OK;
  });
}

void stof_close(stof_sensor* sensor) {
  if (sensor != nullptr && stof_stop(sensor) == STOF_OK) {
    delete sensor;
  }
}

stof_status stof_next(stof_sensor* sensor, int timeout_ms, stof_frame* frame) {
  if (sensor == nullptr || frame == nullptr || frame->struct_size < sizeof frame->struct_size) {
    return STOF_BAD_ARGUMENT;
  }
  if (sensor->running) {
    return STOF_BUSY;
  }
  return guarded([&] {
    const stof_status status = sensor->receive(std::chrono::milliseconds(std::max(timeout_ms, 0)));
    if (status == STOF_OK) {
      static_cast<void>(lib::give(frame, lib::to_frame(sensor->taken)));
    }
    return status;
  });
}

int stof_fd(const stof_sensor* sensor) { return sensor == nullptr ? -1 : sensor->receiver.fd(); }

int stof_due_ms(const stof_sensor* sensor) {
  constexpr int kSoon = 1000;
  if (sensor == nullptr || sensor->running) {
    return kSoon;
  }
  const auto due = sensor->receiver.next_due();
  if (!due) {
    return kSoon;
  }
  // Compared before they are subtracted: the past may be very long ago.
  const client::Time now = client::Time::clock::now();
  if (*due <= now) {
    return 0;
  }
  const auto left = std::chrono::ceil<std::chrono::milliseconds>(
      std::min<client::Duration>(*due - now, std::chrono::milliseconds(kSoon)));
  return static_cast<int>(left.count());
}

stof_status stof_get_health(stof_sensor* sensor, stof_health* health) {
  if (sensor == nullptr) {
    return STOF_BAD_ARGUMENT;
  }
  const std::scoped_lock lock(sensor->shared);
  if (!sensor->health) {
    return STOF_NOT_YET;
  }
  const client::LinkState state = sensor->watch.state(client::Time::clock::now());
  return lib::give(health, lib::with_age(*sensor->health, state)) ? STOF_OK : STOF_BAD_ARGUMENT;
}

stof_status stof_get_link(stof_sensor* sensor, stof_link* link) {
  if (sensor == nullptr) {
    return STOF_BAD_ARGUMENT;
  }
  const std::scoped_lock lock(sensor->shared);
  stof_link told = lib::to_link(sensor->watch.state(client::Time::clock::now()));
  told.restarts = sensor->link_events.restarts();
  return lib::give(link, told) ? STOF_OK : STOF_BAD_ARGUMENT;
}

stof_status stof_next_link_event(stof_sensor* sensor, stof_link_event* event) {
  if (sensor == nullptr || event == nullptr || event->struct_size < sizeof event->struct_size) {
    return STOF_BAD_ARGUMENT;
  }
  if (sensor->running) {
    return STOF_BUSY;
  }
  const auto told = sensor->take_link_event();
  if (!told) {
    return STOF_TIMEOUT;
  }
  static_cast<void>(lib::give(event, lib::to_link_event(*told)));
  return STOF_OK;
}

stof_status stof_get_clock(stof_sensor* sensor, stof_clock* clock) {
  if (sensor == nullptr || clock == nullptr || clock->struct_size < sizeof clock->struct_size) {
    return STOF_BAD_ARGUMENT;
  }
  const std::scoped_lock lock(sensor->shared);
  if (sensor->clock.unmappable()) {
    return STOF_UNSUPPORTED;
  }
  const auto mapping = sensor->clock.mapping();
  if (!mapping) {
    return STOF_NOT_YET;
  }
  stof_clock told{};
  told.offset_ns = mapping->offset_ns;
  told.spread_ns = mapping->spread_ns;
  told.age_ns = std::chrono::nanoseconds(client::Time::clock::now() - mapping->newest).count();
  static_cast<void>(lib::give(clock, told));
  return STOF_OK;
}

stof_status stof_next_raw(stof_sensor* sensor, stof_raw* raw) {
  if (sensor == nullptr || raw == nullptr || raw->struct_size < sizeof raw->struct_size) {
    return STOF_BAD_ARGUMENT;
  }
  if (sensor->running) {
    return STOF_BUSY;
  }
  if (!sensor->raw) {
    return STOF_UNSUPPORTED;
  }
  return guarded([&] {
    const auto exposure = sensor->receiver.take_raw();
    if (!exposure) {
      switch (sensor->receiver.raw_refusal()) {
        case wire::SubscribeResult::kRawDenied:
          return STOF_REFUSED;
        case wire::SubscribeResult::kRawTaken:
          return STOF_NOT_YET;
        default:
          return STOF_TIMEOUT;
      }
    }
    static_cast<void>(lib::give(raw, lib::to_raw(*exposure)));
    return STOF_OK;
  });
}

stof_status stof_next_event(stof_sensor* sensor, stof_event* event) {
  if (sensor == nullptr || event == nullptr || event->struct_size < sizeof event->struct_size) {
    return STOF_BAD_ARGUMENT;
  }
  if (sensor->running) {
    return STOF_BUSY;
  }
  return guarded([&] {
    const auto report = sensor->receiver.take_event();
    if (!report) {
      return STOF_TIMEOUT;
    }
    static_cast<void>(lib::give(event, lib::to_event(*report)));
    return STOF_OK;
  });
}

stof_status stof_start(stof_sensor* sensor, const stof_callbacks* callbacks) {
  const auto known = lib::read(callbacks);
  if (sensor == nullptr || !known) {
    return STOF_BAD_ARGUMENT;
  }
  if (sensor->running) {
    return STOF_BUSY;
  }
  return guarded([&] {
    sensor->callbacks = *known;
    sensor->stopping = false;
    sensor->running = true;
    try {
      sensor->thread = std::thread([sensor] { sensor->run(); });
    } catch (const std::system_error&) {
      sensor->running = false;
      return STOF_INTERNAL;
    }
    return STOF_OK;
  });
}

stof_status stof_stop(stof_sensor* sensor) {
  if (sensor == nullptr) {
    return STOF_BAD_ARGUMENT;
  }
  if (sensor->running) {
    if (sensor->thread.get_id() == std::this_thread::get_id()) {
      return STOF_BUSY;
    }
    sensor->stopping = true;
    sensor->thread.join();
    sensor->running = false;
  }
  return STOF_OK;
}

stof_status stof_get_statistics(stof_sensor* sensor, stof_statistics* statistics) {
  if (sensor == nullptr) {
    return STOF_BAD_ARGUMENT;
  }
  const std::scoped_lock lock(sensor->shared);
  return lib::give(statistics, sensor->statistics) ? STOF_OK : STOF_BAD_ARGUMENT;
}

size_t stof_advice(stof_sensor* sensor, char* text, size_t size) {
  if (sensor == nullptr) {
    lib::give_text("", text, size);
    return 0;
  }
  const std::scoped_lock lock(sensor->shared);
  lib::give_text(sensor->advice, text, size);
  return sensor->advice.size();
}

}  // extern "C"
