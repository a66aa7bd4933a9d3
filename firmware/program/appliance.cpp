#include "firmware/program/appliance.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "dsp/base/check.h"

namespace stof::firmware {

namespace {

// For who asks for raw pictures the pipeline is built anew at most once in this time.
constexpr hal::Duration kAnewPeriod = std::chrono::seconds(3);

// Every page that the loop will use is written once, so that it meets none for the first time.
std::span<std::byte> written(std::span<std::byte> memory, std::size_t bytes) noexcept {
  STOF_CHECK(bytes <= memory.size());
  std::ranges::fill(memory.first(bytes), std::byte{0});
  return memory;
}

SerialSetup serial_setup(const PublisherSetup& publisher) noexcept {
  return {
      .origin = publisher.origin, .calibration = publisher.calibration, .clock = publisher.clock};
}

}  // namespace

Appliance::Appliance(const Parts& parts, const PublisherSetup& publisher,
                     const RunConfig& run_config, const Memory& memory) noexcept
    : parts_(parts),
      run_config_(run_config),
      arena_(written(memory.coded, memory.coded.size())),
      serial_(),
      publisher_(publisher, sizes_of(run_config.setup), parts.board.clock, parts.board.port,
                 parts.serial == nullptr ? nullptr
                                         : &serial_.emplace(serial_setup(publisher), *parts.serial,
                                                            parts.board.clock, arena_),
                 parts.events, arena_),
      images_(memory.images) {
  build(run_config);
  publisher_.set_params(run_config.publisher);
  if (serial_) {
    serial_->sender.set(run_config.serial);
  }
  loop_.emplace(parts_.board, run_config.timing, run_config.setup, *pipeline_, publisher_,
                parts_.events, parts_.lending);
}

void Appliance::build(const RunConfig& run_config) noexcept {
  pipeline_.reset();
  dsp::Arena arena(written(images_, run_config.image_bytes));
  pipeline_.emplace(run_config.setup, arena, parts_.threads.first(run_config.setup.threads));
}

void Appliance::apply(const RunConfig& run_config) noexcept {
  publisher_.set_params(run_config.publisher);
  if (serial_) {
    serial_->sender.set(run_config.serial);
  }
  const bool recalibrated = run_config.installs != run_config_.installs;
  const bool rebuilt = recalibrated || !(run_config.setup.depth == run_config_.setup.depth) ||
                       run_config.setup.threads != run_config_.setup.threads;
  if (recalibrated) {
    publisher_.set_calibration(run_config.calibration);
    loop_->recalibrate(run_config.setup);
  }
  if (recalibrated && serial_) {
    serial_->sender.set_calibration(run_config.calibration);
  }
  if (rebuilt) {
    build(run_config);
    loop_->note_begun_anew();
  }
  if (rebuilt || run_config.timing != run_config_.timing) {
    loop_->restart(run_config.timing);
  }
  loop_->require_both(run_config.setup.require_both);
  run_config_ = run_config;
}

void Appliance::begin_anew() noexcept {
  build(run_config_);
  loop_->note_begun_anew();
}

void Appliance::note(Event event) noexcept {
  event.at = parts_.board.clock.now();
  parts_.events.note(event);
  publisher_.health().observe(event);
}

void Appliance::note_changes(const ControlStatus& control) noexcept {
  while (const std::optional<Event> change =
             parts_.changes == nullptr ? std::nullopt : parts_.changes->pop()) {
    note(*change);
  }
  if (std::exchange(release_, control.release) != release_ && release_ != kNoRelease) {
    note({.kind = EventKind::kRelease, .value = release_, .former = control.release_fingerprint});
  }
}

void Appliance::update_standby(const ControlStatus& control, hal::Time now) noexcept {
  const bool serial = serial_ && run_config_.serial.mode != settings::SerialMode::kOff;
  const bool needed = receiving_ || serial || control.keep_awake || loop_->has_trouble();
  const bool before = standby_.active();
  if (standby_.update(run_config_.standby && parts_.board.replay == nullptr, needed, now) ==
      before) {
    return;
  }
  if (before) {
    loop_->wake();
  }
  note({.kind = EventKind::kStandby, .value = before ? 0U : 1U});
}

Status Appliance::step(const ControlStatus& control) noexcept {
  while (const std::optional<ReceiverList> receivers = parts_.receivers.pop()) {
    anew_wanted_ = publisher_.set_receivers(*receivers) || anew_wanted_;
    receiving_ = receivers->count > 0;
  }
  std::optional<RunConfig> newest;
  while (const std::optional<RunConfig> run_config = parts_.run_configs.pop()) {
    newest = run_config;
  }
  if (newest) {
    apply(*newest);
  }
  const hal::Time now = parts_.board.clock.now();
  if (anew_wanted_ && (!begun_anew_ || now - *begun_anew_ >= kAnewPeriod)) {
    anew_wanted_ = false;
    begun_anew_ = now;
    begin_anew();
  }
  note_changes(control);
  update_standby(control, now);
  Status status = Status::kOk;
  if (standby_.active()) {
    loop_->rest_part();
  } else if (loop_->wait_part()) {
    status = loop_->step();
  }
  publisher_.report(control);
  if (serial_) {
    serial_->sender.tick(parts_.board.clock.now(), publisher_.health().summary());
  }
  return status;
}

}  // namespace stof::firmware
