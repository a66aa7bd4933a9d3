#include "tests/campaign/world.h"

#include <algorithm>
#include <span>

#include "firmware/wire/calibration/calibration_packet.h"
#include "tests/support/guarded_memory.h"

namespace stof::campaign {
namespace {

using namespace std::chrono_literals;

constexpr hal::Duration kPmdIntegration = 16ms;

board::TimingConfig timing() noexcept {
  return {.period = kPeriod,
          .stereo_exposure = 4ms,
          .pmd_integration = kPmdIntegration,
          .edge_tolerance = 200us,
          .pmd_every = 1};
}

class NoNetwork final : public hal::NetworkInterfaces {
 public:
  std::size_t addresses(std::span<hal::InterfaceAddress>) noexcept override { return 0; }
};

firmware::RunConfig run_config(const RigSize& size) {
  return {.setup = setup_of(size),
          .timing = timing(),
          .publisher = {.choice = {.coding = {wire::Coding::kRaw, wire::Coding::kRaw,
                                              wire::Coding::kRaw}},
                        .pace_percent = 60,
                        .period = kPeriod,
                        .revision = 1},
          .serial = {}};
}

// The control thread's clock has no state of its own.
thread_local Clock* current_clock = nullptr;
hal::Time control_time() noexcept { return current_clock->peek(); }

}  // namespace

struct Sensor {
  Sensor(World& world, const RigSize& size, std::uint32_t session)
      : board{.clock = world.clock,
              .trigger = world.trigger,
              .stereo = world.stereo,
              .pmd = &world.pmd,
              .port = world.network,
              .serial = nullptr,
              .to = std::nullopt,
              .network = interfaces,
              .mdns = nullptr,
              .calibration = setup_of(size).calibration,
              .disparities = size.disparities,
              .emulated_time = true,
              .recorded = false,
              .notes = {}},
        handler({.device_id = 7, .session_id = session}, firmware::CookieSecret{}, subscribers,
                nullptr),
        control({.port = world.network,
                 .handler = handler,
                 .subscribers = subscribers,
                 .ring = receivers}),
        appliance(
            {.board = board,
             .events = events,
             .run_configs = run_configs,
             .receivers = receivers,
             .serial = nullptr,
             .threads = {}},
            {.origin = {.device_id = 7, .session_id = session},
             .clock = wire::ClockState::kEmulated,
             .calibration =
                 wire::make_calibration_packet(board.calibration, 40'000, kPeriod.count()).value()},
            run_config(size), {.images = images.span(), .coded = coded.span()}) {}

  NoNetwork interfaces;
  board::Board board;
  firmware::Events events;
  firmware::RunConfigRing run_configs;
  firmware::ReceiverRing receivers;
  firmware::LeaseTable subscribers;
  firmware::RequestHandler handler;
  firmware::ControlServer control;
  test::GuardedBuffer<std::byte> images{std::size_t{8} << 20};
  test::GuardedBuffer<std::byte> coded{std::size_t{1} << 20};
  firmware::Appliance appliance;
};

World::World(const RigSize& size, const CallFaults& faults, std::size_t edges, std::uint64_t seed,
             const Belief& belief)
    : log(edges),
      imagery(size),
      emulated_stereo(clock, imagery, {.exposure = timing().stereo_exposure}, faults.stereo),
      emulated_pmd(clock, imagery, {.integration = kPmdIntegration, .readout = 4ms}, faults.pmd),
      stereo(emulated_stereo, clock, log, size),
      pmd(emulated_pmd, clock, log, size, kPmdIntegration),
      gate(log, emulated_stereo, emulated_pmd),
      emulated_trigger(clock, 50us, {&gate}, faults.trigger),
      trigger(emulated_trigger, clock, gate),
      network(clock, faults.link),
      attacker(seed),
      robot(log, belief, clock.peek()),
      size_(size) {
  start();
}

World::~World() = default;

void World::start() {
  sensor_.reset();
  sensor_ = std::make_unique<Sensor>(*this, size_, 100 + ++sessions_);
}

std::optional<firmware::Counters> World::counters() const noexcept {
  return sensor_ ? std::optional(sensor_->events.counters) : std::nullopt;
}

void World::step() {
  const hal::Time from = clock.peek();
  if (off_.holds(from)) {
    sensor_.reset();
    clock.wait_until(std::min(off_.end, from + 5ms));
  } else {
    if (!sensor_) {
      start();
    }
    current_clock = &clock;
    static_cast<void>(sensor_->control.receive(0ms, control_time));
    sensor_->control.tick(clock.peek());
    firmware::ControlStatus status;
    status.requests = firmware::control_counters(sensor_->handler, network);
    status.subscribers = static_cast<std::uint8_t>(sensor_->subscribers.count());
    status.settings_revision = 1;
    static_cast<void>(sensor_->appliance.step(status));
    while (sensor_->events.take()) {
    }
  }
  attacker.act(network, from, clock.peek());
  robot.run(network, clock.peek());
}

}  // namespace stof::campaign
