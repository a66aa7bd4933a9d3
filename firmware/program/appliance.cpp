#include "firmware/program/appliance.h"

#include <algorithm>

#include "dsp/base/check.h"

namespace stof::firmware {

namespace {

// Every page that the loop will use is written once, so that it meets none for the first time.
std::span<std::byte> written(std::span<std::byte> memory, std::size_t bytes) noexcept {
  STOF_CHECK(bytes <= memory.size());
  std::ranges::fill(memory.first(bytes), std::byte{0});
  return memory;
}

SerialSetup serial_setup(const StreamSetup& stream) noexcept {
  return {.origin = stream.origin, .calibration = stream.calibration, .clock = stream.clock};
}

}  // namespace

std::size_t coded_bytes_needed(const Setup& setup) noexcept {
  const dsp::Pinhole& left = setup.calibration.stereo.left;
  SerialSetup serial;
  serial.calibration.image_width = static_cast<std::uint16_t>(left.width);
  serial.calibration.image_height = static_cast<std::uint16_t>(left.height);
  const wire::FrameSizes sizes = sizes_of(setup);
  return wire::FrameCoder::bytes_needed(sizes, wire::FrameCoder::usual_packets(sizes)) +
         SerialSender::bytes_needed(serial);
}

Appliance::Appliance(const Parts& parts, const StreamSetup& stream, const Plan& plan,
                     const Memory& memory) noexcept
    : parts_(parts),
      plan_(plan),
      arena_(written(memory.coded, coded_bytes_needed(plan.setup))),
      side_(),
      stream_(stream, sizes_of(plan.setup), parts.board.clock, parts.board.port,
              parts.serial == nullptr
                  ? nullptr
                  : &side_.emplace(serial_setup(stream), *parts.serial, parts.board.clock, arena_),
              parts.events, arena_),
      images_(memory.images) {
  build(plan);
  stream_.set_params(plan.stream);
  if (side_) {
    side_->sender.set(plan.serial);
  }
  loop_.emplace(parts_.board, plan.timing, plan.setup, *pipeline_, stream_, parts_.events);
}

void Appliance::build(const Plan& plan) noexcept {
  pipeline_.reset();
  dsp::Arena arena(written(images_, Pipeline::bytes_needed(plan.setup)));
  pipeline_.emplace(plan.setup, parts_.board.clock, arena,
                    parts_.threads.first(plan.setup.threads));
}

void Appliance::apply(const Plan& plan) noexcept {
  stream_.set_params(plan.stream);
  if (side_) {
    side_->sender.set(plan.serial);
  }
  const bool rebuilt =
      !(plan.setup.depth == plan_.setup.depth) || plan.setup.threads != plan_.setup.threads;
  if (rebuilt) {
    build(plan);
  }
  if (rebuilt || plan.timing != plan_.timing) {
    loop_->restart(plan.timing);
  }
  plan_ = plan;
}

Status Appliance::step(const Surroundings& around) noexcept {
  while (const std::optional<SubscriberList> receivers = parts_.receivers.pop()) {
    stream_.set_receivers(receivers->all(), receivers->refused);
  }
  std::optional<Plan> newest;
  while (const std::optional<Plan> plan = parts_.plans.pop()) {
    newest = plan;
  }
  if (newest) {
    apply(*newest);
  }
  const Status status = loop_->step();
  stream_.report(around);
  if (side_) {
    side_->sender.tick(parts_.board.clock.now(), stream_.reporter().summary());
  }
  return status;
}

}  // namespace stof::firmware
