#pragma once

#include <chrono>
#include <cstdint>
#include <expected>
#include <memory>
#include <string>

#include "host/bridge/robot_feed.h"

namespace stof::bridge {

struct PublisherOptions {
  std::uint32_t domain = 0;
  std::string name_space = "stof";  // good_namespace()
};

// The topics of one sensor, to whoever reads them in the domain, over Cyclone DDS: reliable writers
// that keep the newest messages of a topic and never wait for a reader, type hashes in USER_DATA,
// fragments of at most 1,344 bytes in datagrams of at most 1,400. CYCLONEDDS_URI adds to the
// configuration, as usual.
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
