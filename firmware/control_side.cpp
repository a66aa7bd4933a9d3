#include "firmware/control_side.h"

#include <algorithm>

namespace stof::firmware {

void put_text(std::string_view text, std::span<char> to) noexcept {
  std::ranges::fill(to, '\0');
  std::ranges::copy(text.substr(0, to.size()), to.begin());
}

ControlSide::ControlSide(const Parts& parts, const settings::Settings& active,
                         const settings::Settings& saved)
    : parts_(parts),
      desk_(active, saved, {.limits = *this, .sink = *this, .store = parts.store}),
      gate_(parts.origin, make_cookie_secret(), subscribers_, &desk_),
      beacon_(parts.board.port, parts.board.network),
      mdns_name_(active.name),
      mdns_on_(active.discovery.mdns) {
  if (parts_.board.to) {
    // The first of them, and before the first frame: there is room for both.
    static_cast<void>(subscribers_.fix(*parts_.board.to));
    static_cast<void>(parts_.receivers.push(subscribers_.list()));
  }
  if (parts_.board.mdns != nullptr) {
    mdns_.emplace(*parts_.board.mdns, parts_.board.network,
                  Service{.announce = announce(), .device_id = parts_.origin.device_id},
                  parts_.origin.session_id);
  }
  if (parts_.serial != nullptr) {
    line_requests_.emplace(parts_.origin, &desk_);
    serial_.emplace(*parts_.board.serial, *parts_.serial, *line_requests_);
    serial_->set(active.serial.mode, static_cast<std::uint32_t>(active.serial.baud));
  }
  introduce(started_);  // nobody is answered before
  thread_.emplace(
      ControlParts{.port = parts_.board.port,
                   .gate = gate_,
                   .subscribers = subscribers_,
                   .ring = parts_.receivers,
                   .hooks = hooks_,
                   .turn = parts_.serial == nullptr
                               ? hal::Duration(std::chrono::milliseconds(20))
                               : SerialDesk::turn(static_cast<std::uint32_t>(active.serial.baud))});
}

ControlSide::~ControlSide() {
  thread_.reset();
  if (mdns_ && mdns_on_) {
    mdns_->stop(control_now());
  }
}

wire::Announce ControlSide::announce() const noexcept {
  wire::Announce announce = parts_.announce;
  put_text(desk_.active().name.view(), announce.name);
  announce.subscribers = static_cast<std::uint8_t>(subscribers_.count());
  announce.most_subscribers = kMostSubscribers;
  announce.rate_mhz = parts_.vitals.rate_mhz.load(std::memory_order_relaxed);
  return announce;
}

void ControlSide::tell_loop() noexcept {
  revision_.store(desk_.revision(), std::memory_order_relaxed);
  unsaved_.store(desk_.unsaved(), std::memory_order_relaxed);
  restart_needed_.store(desk_.restart_needed(), std::memory_order_relaxed);
  subscriber_count_.store(static_cast<std::uint8_t>(subscribers_.count()),
                          std::memory_order_relaxed);
}

wire::Announce ControlSide::introduce(hal::Time now) noexcept {
  const wire::Health health = parts_.vitals.health.load(std::memory_order_relaxed);
  wire::Announce told = announce();
  told.uptime_ms = static_cast<std::uint64_t>((now - started_) / std::chrono::milliseconds(1));
  gate_.set_announce(told, health);
  beacon_.set(told, parts_.origin, {.health = health});
  if (line_requests_) {
    line_requests_->set_announce(told, health);
  }
  return told;
}

void ControlSide::tick(hal::Time now) noexcept {
  tell_loop();
  const settings::Settings& active = desk_.active();
  const wire::Announce told = introduce(now);
  if (active.discovery.beacon) {
    beacon_.tick(now);
  }
  if (mdns_ && active.discovery.mdns) {
    if (!mdns_on_) {  // an agent that has said goodbye does not come back
      mdns_name_ = active.name;
      mdns_.emplace(*parts_.board.mdns, parts_.board.network,
                    Service{.announce = told, .device_id = parts_.origin.device_id},
                    parts_.origin.session_id);
    } else if (active.name != mdns_name_) {
      mdns_name_ = active.name;
      mdns_->set_service({.announce = told, .device_id = parts_.origin.device_id}, now);
    }
    mdns_->tick(now);
  } else if (mdns_ && mdns_on_) {
    mdns_->stop(now);
  }
  mdns_on_ = active.discovery.mdns;
  if (serial_) {
    serial_->tick(now);
  }
}

bool ControlSide::accepts(const settings::Settings& settings, settings::PagedWriter& why) noexcept {
  const auto plan = make_plan(parts_.rig, board::kConfig, settings);
  if (!plan) {
    why << plan.error();
  }
  return plan.has_value();
}

bool ControlSide::apply(const settings::Settings& settings, std::uint32_t revision) noexcept {
  auto plan = make_plan(parts_.rig, board::kConfig, settings);
  if (!plan) {
    return false;
  }
  plan->stream.revision = revision;
  if (!parts_.plans.push(*plan)) {
    return false;
  }
  if (serial_) {
    serial_->set(settings.serial.mode, static_cast<std::uint32_t>(settings.serial.baud));
  }
  return true;
}

Surroundings ControlSide::surroundings(const SerialSender::Counters& made) const noexcept {
  Surroundings around{.control = control_counters(gate_, parts_.board.port),
                      .settings_revision = revision_.load(std::memory_order_relaxed),
                      .subscribers = subscriber_count_.load(std::memory_order_relaxed),
                      .settings_unsaved = unsaved_.load(std::memory_order_relaxed),
                      .restart_needed = restart_needed_.load(std::memory_order_relaxed)};
  if (serial_) {
    const SerialDesk::Counters line = serial_->counters();
    around.serial_sent = line.sent;
    around.serial_dropped = made.dropped + line.lost;
    around.serial_refused = line.refused;
    around.serial_lost = serial_->lost();
  }
  return around;
}

}  // namespace stof::firmware
