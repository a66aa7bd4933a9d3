#pragma once

#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <stof/stof.hpp>

#include "firmware/wire/bytes.h"
#include "tests/firmware/control/sensor.h"
#include "tests/host/client/test_pattern.h"

// libstof before the network end of a sensor.
namespace stof::test {

inline std::string endpoint(const Sensor& sensor) {
  return "127.0.0.1:" + std::to_string(sensor.number());
}

// Takes frames however long they lay in this machine's queue: one that a busy machine reads too
// late would be missed.
inline stof::Sensor open(const Sensor& sensor) {
  std::string why;
  const std::string at = endpoint(sensor);
  stof_options options = STOF_INIT(stof_options);
  options.sensor = at.c_str();
  options.max_age_ms = 60'000;
  auto opened = stof::Sensor::open(options, &why);
  if (!opened) {
    ADD_FAILURE() << why;
    std::abort();
  }
  return std::move(*opened);
}

// Subscribed: what the sensor sends now arrives.
inline void subscribe(stof::Sensor& client, Sensor& sensor) {
  for (int i = 0; i < 6000 && sensor.list().count != 1; ++i) {
    static_cast<void>(client.next(std::chrono::milliseconds(5)));
  }
  ASSERT_EQ(sensor.list().count, 1U);
}

// As of this sensor.
inline void send(Sensor& sensor, std::vector<Datagram> datagrams) {
  for (Datagram& datagram : datagrams) {
    stof::wire::put_u32(std::span(datagram).subspan<8, 4>(), sensor.origin.device_id);
    stof::wire::put_u32(std::span(datagram).subspan<12, 4>(), sensor.origin.session_id);
    reseal(datagram);
    ASSERT_EQ(sensor.send(datagram), stof::Status::kOk);
  }
}

inline Datagram calibration() {
  FrameSpec spec = frame_spec(1);
  spec.width = 64;
  spec.height = 48;
  return calibration_datagram(spec, 33'000'000);
}

inline std::vector<Datagram> all_streams(std::uint32_t number) {
  return pattern_datagrams(
      frame_spec(number), {},
      every_stream(stof::wire::Coding::kRvl, /*parity=*/false, /*cloud_step=*/8));
}

}  // namespace stof::test
