#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "board/board.h"
#include "firmware/control/control_server.h"
#include "firmware/program/appliance.h"
#include "tests/campaign/attack.h"
#include "tests/campaign/devices.h"
#include "tests/campaign/network.h"
#include "tests/campaign/robot.h"
#include "tests/campaign/wall.h"

namespace stof::campaign {

// Faults of the devices of hal/emu, by calls.
struct CallFaults {
  emu::FaultPlan trigger{};
  emu::FaultPlan stereo{};
  emu::FaultPlan pmd{};
  emu::FaultPlan link{};
};

// The appliance without threads: what the loop's and the control thread do, in turns.
struct Sensor;

// An emulated rig with the appliance, a network and a robot, in one emulated time.
class World {
 public:
  // edges: room for so many.
  World(const RigSize& size, const CallFaults& faults, std::size_t edges, std::uint64_t seed)
      : World(size, faults, edges, seed, {.truth = size}) {}
  World(const RigSize& size, const CallFaults& faults, std::size_t edges, std::uint64_t seed,
        const Belief& belief);
  ~World();
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  // Some milliseconds to a few periods.
  void step();
  void run(hal::Time until) {
    while (clock.peek() < until) {
      step();
    }
  }
  // The power is off, or the program killed, in that time: nothing is remembered.
  void power_off(const Span& span) noexcept { off_ = span; }

  // Since the start of the program; none: the power is off.
  std::optional<firmware::Counters> counters() const noexcept;

  Clock clock;
  EdgeLog log;
  NoImagery imagery;
  emu::StereoCamera emulated_stereo;
  emu::PmdCamera emulated_pmd;
  StereoCamera stereo;
  PmdCamera pmd;
  Gate gate;
  emu::Trigger emulated_trigger;
  Trigger trigger;
  Network network;
  Attacker attacker;
  Robot robot;

 private:
  void start();

  RigSize size_;
  Span off_{};
  std::uint32_t sessions_ = 0;
  std::unique_ptr<Sensor> sensor_;
};

}  // namespace stof::campaign
