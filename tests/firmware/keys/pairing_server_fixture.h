#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include <gtest/gtest.h>

#include "firmware/keys/pairing_server.h"
#include "hal/emu/devices/store.h"
#include "tests/firmware/keys/pairing_client.h"

namespace stof::keys {

inline constexpr wire::Origin kSensor{.device_id = 1, .session_id = 77};
inline constexpr LabelCode kCode{std::byte{1}, std::byte{2}, std::byte{3}};

// A sensor's end of pairing, with a label and without one, and a client that does what it has to.
class PairingServerTest : public testing::Test {
 protected:
  void SetUp() override { ASSERT_TRUE(wire::start_crypto()); }

  wire::PairAnswer ask(const wire::PairRequest& request, PairingWay way = PairingWay::kNetwork) {
    return server_.serve(request, way, now_, from_);
  }
  // All steps until the client's user has confirmed: the last answer.
  wire::PairAnswer run(test::PairingClient& client, PairingWay way = PairingWay::kNetwork) {
    const wire::PairAnswer begun = ask(client.begin(), way);
    if (begun.result != wire::PairResult::kOk) {
      return begun;
    }
    const wire::PairAnswer revealed = ask(client.reveal(begun), way);
    EXPECT_EQ(revealed.result, wire::PairResult::kOk);
    EXPECT_EQ(wire::bytes_in<wire::Tag>(revealed.value), client.secrets().sensor_tag());
    return ask(client.confirm(), way);
  }
  // Whoever is at the sensor has read what it tells, and holds the button.
  void hold() {
    server_.tick(now_);
    server_.hold(now_);
  }
  bool has_key_of(const test::PairingClient& client, std::uint32_t id) const {
    const wire::Key* const key = ring_.keys().find(id);
    return key != nullptr && key->secret == client.secrets().secret();
  }

  hal::Peer from_{};
  hal::Time now_{std::chrono::seconds(1000)};
  hal::emu::Store store_;
  Keyring ring_{&store_, nullptr};
  PairingServer server_{kSensor, ring_, kCode};
  PairingServer without_code_{kSensor, ring_, std::nullopt};
};

}  // namespace stof::keys
