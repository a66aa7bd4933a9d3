#include "firmware/program/control_services.h"

#include <algorithm>

#include "board/serial_lines.h"

namespace stof::firmware {
namespace {

// The value of condition settings_dropped.
std::uint32_t dropped_value(const settings::StartSettings& start) noexcept {
  constexpr std::uint32_t kGood = 16;
  constexpr std::uint32_t kStrictest = 32;
  return static_cast<std::uint32_t>(start.dropped) + (start.good ? kGood : 0) +
         (start.strictest ? kStrictest : 0);
}

using Trial = update::TrialOutcome::What;
static_assert(static_cast<std::uint32_t>(Trial::kNone) == kNoRelease &&
              static_cast<std::uint32_t>(Trial::kRuns) == kReleaseOnTrial &&
              static_cast<std::uint32_t>(Trial::kConfirmed) == kReleaseConfirmed &&
              static_cast<std::uint32_t>(Trial::kLeft) == kReleaseLeft);

}  // namespace

void put_text(std::string_view text, std::span<char> to) noexcept {
  std::ranges::fill(to, '\0');
  std::ranges::copy(text.substr(0, to.size()), to.begin());
}

ControlServices::ControlServices(const Parts& parts, const settings::Settings& active)
    : parts_(parts),
      settings_server_(active, parts.saved.settings,
                       {.limits = *this,
                        .sink = *this,
                        .store = parts.store,
                        .fixed = parts.fixed,
                        .changes = &parts.changes,
                        .network = parts.network,
                        .interfaces = &parts.board.network,
                        .fell_back = parts.saved.fell_back,
                        .dropped = parts.saved.dropped != settings::Dropped::kNot}),
      authenticator_(parts.keys),
      key_service_(parts.keys, settings_server_, &parts.changes),
      installer_(
          {.rig = parts.rig, .store = parts.installed, .changes = &parts.changes, .sink = *this}),
      uploads_(key_service_, installer_, &parts.updater),
      handler_(parts.origin, make_cookie_secret(), subscribers_, &uploads_, &authenticator_),
      beacon_(parts.board.beacon, parts.board.network),
      mdns_name_(active.name),
      mdns_on_(active.discovery.mdns) {
  parts_.pairing.set_changes(&parts_.changes);
  handler_.set_pairing(&parts_.pairing);
  if (parts_.board.button != nullptr) {
    button_.emplace(*parts_.board.button);
  }
  if (parts_.board.to) {
    // The first of them, and before the first frame: there is room for both.
    static_cast<void>(subscribers_.fix(*parts_.board.to));
    static_cast<void>(parts_.receivers.push(subscribers_.list()));
  }
  if (parts_.board.mdns != nullptr) {
    mdns_.emplace(*parts_.board.mdns, parts_.board.network,
                  Service{.announce = make_announce(), .device_id = parts_.origin.device_id},
                  parts_.origin.session_id);
  }
  if (parts_.serial != nullptr) {
    line_requests_.emplace(parts_.origin, &uploads_, &handler_);
    line_requests_->set_pairing(&parts_.pairing);
    line_requests_->set_remote(active.serial.remote);
    serial_.emplace(*parts_.board.serial, *parts_.serial, *line_requests_);
    serial_->set(active.serial.mode, static_cast<std::uint32_t>(active.serial.baud));
  }
  update_announce(started_);  // nobody is answered before
  publish_status();
  thread_.emplace(
      ControlParts{.port = parts_.board.port,
                   .handler = handler_,
                   .subscribers = subscribers_,
                   .ring = parts_.receivers,
                   .tasks = tasks_,
                   .link = parts_.board.beacon,
                   .turn = parts_.serial == nullptr
                               ? hal::Duration(std::chrono::milliseconds(20))
                               : SerialLink::turn(static_cast<std::uint32_t>(active.serial.baud))});
}

ControlServices::~ControlServices() {
  thread_.reset();
  if (mdns_ && mdns_on_) {
    mdns_->stop(control_now());
  }
  if (parts_.trial != nullptr) {
    parts_.trial->end(parts_.loop_status.published.load(std::memory_order_relaxed));
  }
}

wire::Announce ControlServices::make_announce() const noexcept {
  wire::Announce announce = parts_.announce;
  put_text(settings_server_.active().name.view(), announce.name);
  announce.subscribers = static_cast<std::uint8_t>(subscribers_.count());
  announce.most_subscribers = kMostSubscribers;
  announce.rate_millihertz = parts_.loop_status.rate_millihertz.load(std::memory_order_relaxed);
  announce.state = static_cast<std::uint8_t>(
      parts_.loop_status.standby.load(std::memory_order_relaxed) ? wire::SensorState::kStandby
                                                                 : wire::SensorState::kMeasuring);
  return announce;
}

void ControlServices::publish_status() noexcept {
  published_.unsaved.store(settings_server_.unsaved(), std::memory_order_relaxed);
  published_.fell_back.store(settings_server_.fell_back(), std::memory_order_relaxed);
  published_.restart_needed.store(settings_server_.restart_needed(), std::memory_order_relaxed);
  published_.dropped.store(settings_server_.dropped() ? dropped_value(parts_.saved) : 0,
                           std::memory_order_relaxed);
  published_.calibration_dropped.store(static_cast<std::uint32_t>(installer_.dropped()),
                                       std::memory_order_relaxed);
  published_.paired.store(parts_.keys.pairing(), std::memory_order_relaxed);
  // New settings and a new release are proven by frames.
  const bool proving = parts_.trial != nullptr && !parts_.trial->proven() &&
                       settings_server_.saved_in_force() != nullptr;
  published_.keep_awake.store(proving || parts_.updater.trial_runs(), std::memory_order_relaxed);
  const update::TrialOutcome& trial = parts_.updater.outcome();
  published_.release_fingerprint.store(trial.release, std::memory_order_relaxed);
  published_.release.store(static_cast<std::uint32_t>(trial.what), std::memory_order_release);
  published_.revision.store(settings_server_.revision(), std::memory_order_release);
  published_.subscribers.store(static_cast<std::uint8_t>(subscribers_.count()),
                               std::memory_order_relaxed);
}

wire::Announce ControlServices::update_announce(hal::Time now) noexcept {
  const wire::Health health = parts_.loop_status.health.load(std::memory_order_relaxed);
  wire::Announce announce = make_announce();
  announce.uptime_ms = static_cast<std::uint64_t>((now - started_) / std::chrono::milliseconds(1));
  handler_.set_announce(announce, health);
  subscribers_.keep_raw_for_admins(settings_server_.active().limits.streams ==
                                   settings::StreamLimit::kFixed);
  beacon_.set(announce, parts_.origin, {.health = health});
  if (line_requests_) {
    line_requests_->set_announce(announce, health);
  }
  return announce;
}

void ControlServices::watch_pairing(hal::Time now) noexcept {
  if (button_) {
    parts_.pairing.take(*button_, now);
  }
  parts_.pairing.tick(now);
}

void ControlServices::watch_update(hal::Time now) noexcept {
  const LoopStatus& loop = parts_.loop_status;
  const int period_ms = settings_server_.active().period_ms;
  parts_.updater.tick(now,
                      {.rounds = loop.rounds.load(std::memory_order_relaxed),
                       .frames = loop.published.load(std::memory_order_relaxed),
                       .with_pair = loop.with_pair.load(std::memory_order_relaxed),
                       .with_pmd = loop.with_pmd.load(std::memory_order_relaxed),
                       .standby = loop.standby.load(std::memory_order_relaxed)},
                      period_ms == 0 ? board::kConfig.timing.period
                                     : hal::Duration(std::chrono::milliseconds(period_ms)));
  if (const update::Restart wish = parts_.updater.restart(now); wish != update::Restart::kNone) {
    parts_.restart.store(wish, std::memory_order_relaxed);
  }
}

void ControlServices::tick(hal::Time now) noexcept {
  watch_pairing(now);
  watch_update(now);
  settings_server_.tick(now);
  subscribers_.drop_ended_keys(parts_.keys.keys());
  uploads_.drop_ended_keys(parts_.keys.keys());
  publish_status();
  if (parts_.trial != nullptr) {
    parts_.trial->tick(now, parts_.loop_status.published.load(std::memory_order_relaxed),
                       parts_.loop_status.standby.load(std::memory_order_relaxed)
                           ? nullptr
                           : settings_server_.saved_in_force());
  }
  const settings::Settings& active = settings_server_.active();
  const wire::Announce announce = update_announce(now);
  if (active.discovery.beacon) {
    beacon_.tick(now);
  }
  if (mdns_ && active.discovery.mdns) {
    if (!mdns_on_) {  // an agent that has said goodbye does not come back
      mdns_name_ = active.name;
      mdns_.emplace(*parts_.board.mdns, parts_.board.network,
                    Service{.announce = announce, .device_id = parts_.origin.device_id},
                    parts_.origin.session_id);
    } else if (active.name != mdns_name_) {
      mdns_name_ = active.name;
      mdns_->set_service({.announce = announce, .device_id = parts_.origin.device_id}, now);
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

bool ControlServices::accepts(const settings::Settings& settings,
                              settings::PagedWriter& why) noexcept {
  if (parts_.board.replay != nullptr) {
    why << "this is a replay: settings and calibration are those of the recording";
    return false;
  }
  if (parts_.network == nullptr && settings.network != settings_server_.active().network) {
    why << "network: the addresses of this machine are its administrator's; in the image of "
           "scripts/image they are settings";
    return false;
  }
  const auto& line = settings.serial.device;
  if (line != settings_server_.active().serial.device && !board::takes_serial_line(line.view())) {
    why << "serial.device: takes a line of board " << board::kConfig.name << ":";
    for (const std::string_view known : board::kSerialLines) {
      why << " " << known;
    }
    return false;
  }
  const auto run_config = make_run_config(parts_.rig, board::kConfig, settings);
  if (!run_config) {
    why << run_config.error();
  }
  return run_config.has_value();
}

bool ControlServices::apply(const settings::Settings& settings, std::uint32_t revision) noexcept {
  auto run_config = make_run_config(parts_.rig, board::kConfig, settings);
  if (!run_config) {
    return false;
  }
  run_config->publisher.revision = revision;
  if (!parts_.run_configs.push(*run_config)) {
    return false;
  }
  if (serial_) {
    serial_->set(settings.serial.mode, static_cast<std::uint32_t>(settings.serial.baud));
    line_requests_->set_remote(settings.serial.remote);
  }
  return true;
}

bool ControlServices::rig_in_force() noexcept {
  return parts_.loop_status.installs.load(std::memory_order_acquire) == parts_.rig.installs;
}

wire::SettingsResult ControlServices::takes_rig(settings::PagedWriter& why) noexcept {
  if (parts_.run_configs.full()) {
    why << "other settings are not in force yet: try again";
    return wire::SettingsResult::kBusy;
  }
  return accepts(settings_server_.active(), why) ? wire::SettingsResult::kOk
                                                 : wire::SettingsResult::kInvalid;
}

void ControlServices::use_rig() noexcept {
  static_cast<void>(apply(settings_server_.active(), settings_server_.revision()));
}

ControlStatus ControlServices::status(const SerialSender::Counters& made) const noexcept {
  ControlStatus status{
      .requests = control_counters(handler_, parts_.board.port),
      .settings_revision = published_.revision.load(std::memory_order_acquire),
      .settings_dropped = published_.dropped.load(std::memory_order_relaxed),
      .connection_replaced = parts_.connection_replaced,
      .calibration_dropped = published_.calibration_dropped.load(std::memory_order_relaxed),
      .subscribers = published_.subscribers.load(std::memory_order_relaxed),
      .settings_unsaved = published_.unsaved.load(std::memory_order_relaxed),
      .settings_fell_back = published_.fell_back.load(std::memory_order_relaxed),
      .restart_needed = published_.restart_needed.load(std::memory_order_relaxed)};
  const keys::Pairing paired = published_.paired.load(std::memory_order_relaxed);
  status.unpaired = paired == keys::Pairing::kUnpaired;
  status.keys_lost = paired == keys::Pairing::kLost;
  status.keep_awake = published_.keep_awake.load(std::memory_order_relaxed);
  status.release = published_.release.load(std::memory_order_acquire);
  status.release_fingerprint = published_.release_fingerprint.load(std::memory_order_relaxed);
  if (serial_) {
    const SerialLink::Counters line = serial_->counters();
    status.serial_sent = line.sent;
    status.serial_dropped = made.dropped + line.lost;
    status.serial_refused = line.refused;
    status.serial_lost = serial_->lost();
  }
  return status;
}

}  // namespace stof::firmware
