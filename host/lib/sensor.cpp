#include "host/lib/sensor.h"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <system_error>
#include <utility>

using namespace stof;
using lib::guarded;

namespace {

constexpr client::Duration kPoll = std::chrono::milliseconds(100);  // how soon a stop is seen

}  // namespace

void stof_sensor::share() {
  if (played) {
    const client::Statistics& counted = played->playback().statistics();
    const stof_statistics now = lib::to_statistics(counted, 0);
    const std::scoped_lock lock(shared);
    statistics = now;
    played_link = played->link();
    link_events.look(*played_link, counted.sessions, client::Time::clock::now());
    if (played->playback().health()) {
      health = lib::to_health(*played->playback().health());
    }
    return;
  }
  const stof_statistics now = lib::to_statistics(receiver->statistics(), receiver->socket_buffer());
  std::string new_advice = receiver->advice();
  const std::scoped_lock lock(shared);
  statistics = now;
  advice = std::move(new_advice);
  watch = receiver->link_watch();
  const client::Time time = client::Time::clock::now();
  link_events.look(watch.state(time), receiver->statistics().sessions, time);
  if (receiver->health()) {
    health = lib::to_health(*receiver->health());
  }
}

stof_status stof_sensor::receive(client::Duration timeout) {
  return played ? receive_played(timeout) : receive_live(timeout);
}

stof_status stof_sensor::receive_played(client::Duration timeout) {
  client::Frame frame;
  const stof_status status = played->next(timeout, frame);
  if (status == STOF_OK) {
    taken = {.frame = frame, .played = played.get(), .recorded_ns = played->recorded_ns()};
  }
  share();
  while (const auto event = played->playback().take_event()) {
    keep(*event);
  }
  return status;
}

void stof_sensor::keep(const wire::EventReport& event) {
  if (events.size() == kMostEvents) {
    events.pop_front();
  }
  events.push_back(event);
}

stof_status stof_sensor::receive_live(client::Duration timeout) {
  const Result<client::Frame> frame = receiver->next(timeout);
  share();
  {
    const std::scoped_lock lock(record_mutex);
    if (record) {
      record->look(*receiver);
    }
    while (const auto event = receiver->take_event()) {
      if (record) {
        record->take(*event);
      }
      keep(event->report);
    }
    if (record && frame) {
      record->take(*frame, receiver->place());
    }
  }
  if (!frame) {
    return lib::to_status(frame.error());
  }
  taken = {.frame = *frame, .receiver = &*receiver};
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
  for (; !events.empty(); events.pop_front()) {
    stof_event told = lib::to_event(events.front());
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
  while (receiver) {
    const auto exposure = receiver->take_raw();
    if (!exposure) {
      break;
    }
    stof_raw told = lib::to_raw(*exposure);
    told.struct_size = sizeof told;
    if (callbacks.raw != nullptr) {
      callbacks.raw(callbacks.user, &told);
    }
  }
  const auto& report = played ? played->playback().health() : receiver->health();
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
  return link_state_shared();
}

client::LinkState stof_sensor::link_state_shared() {
  return played_link ? *played_link : watch.state(client::Time::clock::now());
}

extern "C" {

void stof_close(stof_sensor* sensor) {
  if (sensor != nullptr && stof_stop(sensor) == STOF_OK) {
    static_cast<void>(stof_record_end(sensor, nullptr, nullptr, 0));
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

int stof_fd(const stof_sensor* sensor) {
  return sensor == nullptr || !sensor->receiver ? -1 : sensor->receiver->fd();
}

int stof_due_ms(const stof_sensor* sensor) {
  constexpr int kSoon = 1000;
  if (sensor == nullptr || sensor->running) {
    return kSoon;
  }
  const auto due =
      sensor->played ? std::optional(sensor->played->due()) : sensor->receiver->next_due();
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
  const client::LinkState state = sensor->link_state_shared();
  return lib::give(health, lib::with_age(*sensor->health, state)) ? STOF_OK : STOF_BAD_ARGUMENT;
}

stof_status stof_get_link(stof_sensor* sensor, stof_link* link) {
  if (sensor == nullptr) {
    return STOF_BAD_ARGUMENT;
  }
  const std::scoped_lock lock(sensor->shared);
  stof_link told = lib::to_link(sensor->link_state_shared());
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
  if (sensor->played || sensor->clock.unmappable()) {
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
    const auto exposure = sensor->receiver->take_raw();
    if (!exposure) {
      switch (sensor->receiver->raw_refusal()) {
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
    if (sensor->events.empty()) {
      return STOF_TIMEOUT;
    }
    static_cast<void>(lib::give(event, lib::to_event(sensor->events.front())));
    sensor->events.pop_front();
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
