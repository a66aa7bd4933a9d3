#pragma once

#include <cstddef>
#include <cstdint>
#include <expected>
#include <memory>
#include <optional>
#include <string>

#include "dsp/base/status.h"
#include "host/client/control/subscription.h"
#include "host/client/error.h"
#include "host/client/frame/frame.h"
#include "host/client/frame/frame_pixels.h"
#include "host/client/reassembler.h"
#include "host/client/sensor_socket.h"
#include "host/client/serial/serial_line.h"
#include "host/client/session/link_watch.h"
#include "host/client/session/report_queue.h"
#include "host/client/statistics.h"

namespace stof::client {

struct ReceiverOptions {
  // HOST[:PORT] of a sensor to subscribe at, port 7560 without; an IPv6 address with a port in
  // brackets. Empty: no subscription, listens at `address` and `port` for a sensor that sends here.
  std::string sensor{};
  SubscriptionOptions subscription{};  // its device_id: where it has none, the reassembler's
  // Without a sensor only:
  std::string address = "0.0.0.0";    // IPv4 or IPv6 literal of the interface to listen at
  std::uint16_t port = kDefaultPort;  // 0: any free one, see Receiver::port()

  // A serial line in place of all that: its packets are received as the sensor's settings serial.*
  // send them, the Receiver has no subscription. Signed streams and raw pictures do not travel on
  // it.
  std::shared_ptr<SerialLine> line{};

  int socket_buffer = 4 << 20;  // bytes asked of the system
  ReassemblerOptions reassembler{};
};

// Receives the frames of one sensor. For one thread. A subscription ends with the receiver.
class Receiver {
 public:
  // kInvalidArgument: not an address, or what a line does not carry; kDeviceError: the port cannot
  // be had, or there is no such host. That the sensor answers is not waited for; with its name it
  // may block on a name server.
  static std::expected<Receiver, OpenError> open(const ReceiverOptions& options);

  Receiver(Receiver&&) noexcept;
  Receiver& operator=(Receiver&&) noexcept;
  ~Receiver();

  // The next frame, valid until the next call. Blocks no longer than `timeout`, and the time that
  // 4,096 datagrams take where more than that lie in the socket; with 0 it only looks. kTimeout:
  // none was finished; kDeviceLost: the socket failed, open again.
  // What waited in the socket, or was finished, for longer than ReassemblerOptions::max_age is not
  // delivered: after a pause the next frame is a new one.
  // Call it often: what the socket's buffer cannot hold in between is lost (socket_drops). It also
  // keeps the subscription alive, for which a call every second is enough.
  Result<Frame> next(Duration timeout);

  // The images of the frame that next() returned last move to `pixels`, as Reassembler::keep()
  // says.
  bool keep(FramePixels& pixels) noexcept;

  // Whose health and events these are: after a restart the new session, also before its first
  // frame. None: nothing came yet.
  const std::optional<wire::Origin>& origin() const noexcept;
  // The newest of the session, as far as next() has read; absent until the first one arrived.
  const std::optional<wire::HealthReport>& health() const noexcept;
  const std::optional<wire::CalibrationPacket>& calibration() const noexcept;
  // Of the sensor's trigger, as it tells and as frames come, so that nothing it tells alone makes
  // anybody wait longer; 0: not known.
  Duration period() const;
  // What is known of the sensor by this machine's clock, now.
  LinkState link() const noexcept;
  const LinkWatch& link_watch() const noexcept;  // the same for other times and threads, as a copy
  // Conditions that began or ended, each event once. Look after every next().
  std::optional<ToldEvent> take_event();
  // For who keeps them all: what health() was since the last calls, as Reassembler says.
  std::optional<ToldHealth> take_health();

  // What the cameras gave, where SubscriptionOptions::raw asked for it: the next exposure that has
  // come, valid until the next call. Look after every next(): two are kept. A picture that missed a
  // packet is missing.
  std::optional<RawExposure> take_raw();
  const RawStatistics& raw_statistics() const noexcept;
  // Why there are none: kRawDenied, they take a key; kRawTaken, another subscriber has them. kOk:
  // the sensor said nothing against it, but one that is older than them sends none.
  wire::SubscribeResult raw_refusal() const noexcept;

  const Statistics& statistics() const noexcept;
  std::uint16_t port() const noexcept;
  // Where the sensor is, or where this listens: "192.168.1.20:7560", "/dev/ttyUSB0".
  const std::string& place() const noexcept;
  // Who sent the packet that ended the newest frame, "192.168.1.20:7560"; empty: there was none, or
  // it came over a line.
  std::string sender() const;
  // None: without a sensor to subscribe at.
  std::optional<Subscription::State> subscription() const noexcept;
  // As those of Subscription.
  std::optional<std::uint32_t> other_sensor() const noexcept;
  std::uint32_t proven_key() const noexcept;
  // Of a sensor that signs streams in a way that this release does not know; else none.
  std::optional<std::uint8_t> other_tags() const noexcept;
  std::optional<Duration> round_trip() const noexcept;
  // Whether the sensor's computer answered that nobody listens there, since the last call.
  bool take_refusal() noexcept;
  // Readable when next(0) has something to do; so is it when next_due() has passed.
  int fd() const noexcept;
  std::optional<Time> next_due() const noexcept;

  // The part of ReceiverOptions::socket_buffer that the system granted.
  int socket_buffer() const noexcept;
  // Empty, or what to change to lose less, or to receive at all, in one line.
  std::string advice() const;

 private:
  struct Parts;
  explicit Receiver(std::unique_ptr<Parts> parts) noexcept;
  std::unique_ptr<Parts> parts_;
};

}  // namespace stof::client
