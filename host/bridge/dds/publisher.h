#pragma once

#include <chrono>
#include <cstdint>
#include <expected>
#include <memory>
#include <string>

#include "host/bridge/robot_feed.h"

namespace stof::bridge {

// Fits an Ethernet frame with all headers, also those of a tunnel: what is sent again is a datagram
// of one of these.
inline constexpr unsigned kNetworkFragment = 1344;
// Ten of them, and ten IP fragments on Ethernet, of which each lost one costs all; Cyclone DDS's
// own default, so what robots run. A datagram is a call: a frame of 640x480 takes 46 in place of
// 460.
inline constexpr unsigned kUsualDatagram = 14'720;
inline constexpr unsigned kNetworkDatagram = 1400;  // no IP fragments, for networks that lose
inline constexpr unsigned kMostDatagram = 65'000;
inline constexpr unsigned kLeastFragment = 512;
inline constexpr unsigned kMostFragment = 60'000;

struct PublisherOptions {
  std::uint32_t domain = 0;
  unsigned fragment = kNetworkFragment;  // bytes of a message that are sent again as one
  unsigned datagram = kUsualDatagram;    // bytes at most, but that a fragment and its headers fit
  std::string name_space = "stof";       // good_namespace()
};

// The topics of one sensor, to whoever reads them in the domain, over Cyclone DDS: reliable writers
// that keep the newest messages of a topic and never wait for a reader, and type hashes in
// USER_DATA. CYCLONEDDS_URI adds to the configuration, as usual. What Cyclone DDS says of it and of
// the network goes to standard error through a LineLimit, while there is one of these.
class Publisher final : public TopicSink {
 public:
  // The error: one line.
  static std::expected<Publisher, std::string> open(const PublisherOptions& options);
  Publisher(Publisher&&) noexcept;
  Publisher& operator=(Publisher&&) noexcept;
  ~Publisher() override;  // readers are told that the writers have gone

  bool wanted(Topic topic) override;
  bool publish(Topic topic, recording::Buffer&& message) override;
  // Waits until all readers have what was published; false: so long has passed.
  bool drain(std::chrono::milliseconds longest);

 private:
  struct Parts;
  explicit Publisher(std::unique_ptr<Parts> parts) noexcept;
  std::unique_ptr<Parts> parts_;
};

}  // namespace stof::bridge
