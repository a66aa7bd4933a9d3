#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "firmware/program/appliance.h"
#include "tests/firmware/rig.h"
#include "tests/support/guarded_memory.h"

namespace stof::firmware::test {

inline RunConfig small_run_config() {
  return {.setup = small_setup(true),
          .timing = timing(),
          .publisher = {.choice = {.coding = {wire::Coding::kRaw, wire::Coding::kRaw,
                                              wire::Coding::kRaw}},
                        .pace_percent = 60,
                        .period = timing().period,
                        .revision = 1},
          .serial = {}};
}

// The appliance in the place of the rig's own loop.
struct ApplianceRig {
  Rig rig;
  RunConfigRing run_configs;
  ReceiverRing receivers;
  ChangeRing changes;
  stof::test::GuardedBuffer<std::byte> images{std::size_t{4} << 20};
  stof::test::GuardedBuffer<std::byte> coded{std::size_t{1} << 20};
  std::vector<std::byte> line = std::vector<std::byte>(SerialSender::kRingBytes);
  ByteRing serial{line};
  Appliance appliance;

  explicit ApplianceRig(bool with_serial = false, dsp::ThreadTeam threads = {})
      : appliance({.board = rig.board,
                   .events = rig.events,
                   .run_configs = run_configs,
                   .receivers = receivers,
                   .serial = with_serial ? &serial : nullptr,
                   .threads = threads,
                   .changes = &changes},
                  {.origin = {.device_id = 7, .session_id = 9},
                   .clock = wire::ClockState::kEmulated,
                   .calibration = wire::make_calibration_packet(rig.setup.calibration, 40'000,
                                                                timing().period.count())
                                      .value()},
                  small_run_config(), {.images = images.span(), .coded = coded.span()}) {}

  void subscribe(std::uint16_t port) {
    ReceiverList list;
    list.peers[0] = {.address = {}, .port = port};
    list.count = 1;
    ASSERT_TRUE(receivers.push(list));
  }
  Receiver run(int steps) {
    Receiver receiver;
    for (int i = 0; i < steps; ++i) {
      static_cast<void>(appliance.step({}));
      receiver.drain(rig.port);
    }
    return receiver;
  }
};

}  // namespace stof::firmware::test
