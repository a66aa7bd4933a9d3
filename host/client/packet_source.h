#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "dsp/base/status.h"
#include "host/client/frame/frame.h"
#include "posix/socket_address.h"

namespace stof::client {

// Where a receiver has whole packets of a sensor from: a socket (SensorSocket) or a serial line
// (SerialSource).
class PacketSource {
 public:
  virtual ~PacketSource() = default;

  // One packet to the sensor, without blocking. kUnsupported: it takes none this way;
  // kWouldBlock: the buffer is full; kDeviceError: no way to the sensor now; kDeviceLost.
  virtual Status send(std::span<const std::byte> packet) = 0;
  // Reads what has arrived, without blocking: the number of packets now in packet(0 ...), which are
  // valid until the next call. kDeviceLost: it failed.
  virtual Result<std::size_t> receive() = 0;
  virtual std::span<const std::byte> packet(std::size_t index) const = 0;
  // When it reached this machine; when it was read, where the system does not stamp arrivals.
  virtual Time arrived(std::size_t index) const = 0;
  // Who sent it; nullptr: whoever is at the other end.
  virtual const posix::SocketAddress* from(std::size_t index) const = 0;

  // Blocks until something can be read (kOk) or the time is over (kTimeout). kDeviceLost.
  virtual Status wait(Duration timeout) const = 0;
  // Whether the sensor's computer answered that nobody listens there, since the last call.
  virtual bool take_refusal() { return false; }
  // Whether receive() has something to do that fd() does not tell.
  virtual bool holds_packets() const { return false; }

  // Becomes readable when receive() has something to do.
  virtual int fd() const = 0;
  virtual std::uint16_t port() const { return 0; }
  virtual const std::string& place() const = 0;        // where the sensor is, or this listens
  virtual int buffer_bytes() const { return 0; }       // granted; 0: it has none to ask for
  virtual std::uint64_t dropped() const { return 0; }  // packets that this machine had no room for
};

}  // namespace stof::client
