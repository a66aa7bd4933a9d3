#include "host/client/receiver.h"

#include <algorithm>
#include <chrono>
#include <random>
#include <utility>

#include "host/client/sensor_socket.h"
#include "host/client/serial/serial_source.h"
#include "posix/datagram_batch.h"

namespace stof::client {
namespace {

// Read before the time is looked at: a frame is up to 4,000 datagrams.
constexpr std::size_t kLeastBatches = 4096 / posix::DatagramBatch::kMost;
// So long may be on its way what was sent before the sensor had no place left for us, and what was
// signed with an earlier key, of a sensor that started again too.
constexpr Duration kOnTheWay = std::chrono::milliseconds(500);
constexpr Duration kFormerKeys = std::chrono::seconds(1);
constexpr Duration kForever = std::chrono::hours(24 * 365);  // keeps sums of times in range

}  // namespace

struct Receiver::Parts {
  Parts(std::unique_ptr<PacketSource> bound, const ReceiverOptions& options)
      : socket(std::move(bound)),
        reassembler(with_subscription(options)),
        asked_buffer(options.socket_buffer),
        watch(std::chrono::steady_clock::now()) {
    if (!options.sensor.empty()) {
      SubscriptionOptions terms = options.subscription;
      terms.device_id = terms.device_id ? terms.device_id : options.reassembler.device_id;
      subscription.emplace(terms, static_cast<std::uint32_t>(std::random_device()()));
    }
  }

  // What was not signed for this receiver is not looked at where it asked for that.
  ReassemblerOptions with_subscription(const ReceiverOptions& options) {
    ReassemblerOptions wanted = options.reassembler;
    wanted.raw_pictures = options.subscription.raw.pictures != 0;
    wanted.serial_line = options.line != nullptr;
    if (options.subscription.signed_streams) {
      wanted.verifier = &verifier;
    }
    return wanted;
  }

  Parts(const Parts&) = delete;
  Parts& operator=(const Parts&) = delete;
  ~Parts() {
    for (int i = 0; i < 2 && subscription; ++i) {
      const std::span<const std::byte> farewell = subscription->farewell();
      if (!farewell.empty()) {
        static_cast<void>(socket->send(farewell));
      }
    }
  }

  // What does not leave is asked for again soon.
  void ask(Time now) {
    if (!subscription) {
      return;
    }
    if (const std::span<const std::byte> request = subscription->due(now); !request.empty()) {
      static_cast<void>(socket->send(request));
    }
  }

  // Pushes what was read until a frame is finished.
  std::optional<Frame> push_read() {
    const Time now = std::chrono::steady_clock::now();
    std::optional<Frame> frame = reassembler.take(now);
    while (!frame && next < read) {
      const Time arrived = socket->arrived(next);
      const std::span<const std::byte> datagram = socket->packet(next++);
      if (subscription && subscription->take(datagram, now)) {
        watch.keys_refused(subscription->state() == Subscription::State::kNoKey);
        full_since = subscription->state() == Subscription::State::kFull
                         ? std::optional(full_since.value_or(now))
                         : std::nullopt;
        if (!subscription->signs() && subscription->answerer()) {
          reassembler.expect(*subscription->answerer());
        }
        if (subscription->stream_key().number != 0) {
          take_key(now);
        }
        ask(now);  // a cookie is shown at once
        continue;
      }
      const std::uint64_t verified = verifier.good();
      const std::uint64_t doubtful = doubtful_packets();
      verifier.await_key(subscription &&
                         (subscription->awaits_answer() || now - key_since < kFormerKeys));
      reassembler.push(datagram, arrived, now);
      if (subscription && doubtful_packets() > doubtful) {
        subscription->doubt(now);
      }
      if (full_since && now - *full_since > kOnTheWay) {
        watch.uninvited(now);
      }
      if (subscription && reassembler.delay().held_back()) {
        subscription->renew_key(now);
      }
      if (subscription && verifier.good() > verified) {
        subscription->heard(now);
      }
      frame = reassembler.take(now);
      if (frame) {
        const posix::SocketAddress* const from = socket->from(next - 1);
        sender = from != nullptr ? std::optional(*from) : std::nullopt;
      }
    }
    return frame;
  }

  // What the sensor's next answer may explain.
  std::uint64_t doubtful_packets() const noexcept {
    return reassembler.statistics().foreign + reassembler.statistics().not_signed;
  }

  // A new one may be asked for as a proof.
  void take_key(Time now) {
    const wire::StreamKey& key = subscription->stream_key();
    if (key.number != key_number || subscription->session() != key_session) {
      key_since = now;
    }
    if (key.number != key_number && key_number != 0 && subscription->session() == key_session) {
      reassembler.delay().prove(key.number, subscription->key_asked());
    }
    key_number = key.number;
    key_session = subscription->session();
    verifier.set_key(key, key_session);
  }

  Result<Frame> receive(Duration timeout);

  std::optional<Time> next_due() const {
    if (socket->holds_packets()) {
      return Time::clock::now();
    }
    const std::optional<Time> expiry = reassembler.next_expiry();
    if (!subscription) {
      return expiry;
    }
    const Time asking = subscription->next_due();
    return std::min(asking, expiry.value_or(asking));
  }

  std::unique_ptr<PacketSource> socket;
  StreamVerifier verifier;
  Reassembler reassembler;
  std::optional<Subscription> subscription;
  int asked_buffer;
  LinkWatch watch;
  std::optional<Time> full_since;  // the sensor has no place for us
  std::uint32_t key_number = 0;    // of the stream key; 0: none yet
  std::uint32_t key_session = 0;
  Time key_since{};
  Duration slept{time_asleep(Duration(0))};
  std::size_t read = 0;                        // datagrams in the socket's space
  std::size_t next = 0;                        // of these, to push
  std::optional<posix::SocketAddress> sender;  // of the newest frame that a packet ended
  mutable Statistics statistics;
};

std::expected<Receiver, OpenError> Receiver::open(const ReceiverOptions& options) {
  if (options.sensor.empty() && options.subscription.signed_streams) {
    return std::unexpected(OpenError{
        .status = Status::kInvalidArgument,
        .message = "signed streams: name the sensor; one that sends by itself does not sign"});
  }
  if (options.line) {
    if (!options.sensor.empty() || options.subscription.signed_streams ||
        options.subscription.raw.pictures != 0) {
      return std::unexpected(OpenError{
          .status = Status::kInvalidArgument,
          .message = options.line->device() +
                     ": a serial line has no subscription: no address, signed streams or raw "
                     "pictures with it"});
    }
    return Receiver(std::make_unique<Parts>(std::make_unique<SerialSource>(options.line), options));
  }
  auto socket = options.sensor.empty()
                    ? SensorSocket::open(options.address, options.port, options.socket_buffer)
                    : SensorSocket::connect(options.sensor, options.socket_buffer);
  if (!socket) {
    return std::unexpected(std::move(socket.error()));
  }
  return Receiver(std::make_unique<Parts>(std::move(*socket), options));
}

Receiver::Receiver(std::unique_ptr<Parts> parts) noexcept : parts_(std::move(parts)) {}
Receiver::Receiver(Receiver&&) noexcept = default;
Receiver& Receiver::operator=(Receiver&&) noexcept = default;
Receiver::~Receiver() = default;

Result<Frame> Receiver::Parts::receive(Duration timeout) {
  const Time deadline = std::chrono::steady_clock::now() + std::min(timeout, kForever);
  for (std::size_t batches = 0;; ++batches) {
    ask(std::chrono::steady_clock::now());
    if (const std::optional<Frame> frame = push_read()) {
      return *frame;
    }
    if (batches >= kLeastBatches && std::chrono::steady_clock::now() >= deadline) {
      return fail(Status::kTimeout);
    }
    const Result<std::size_t> got = socket->receive();
    if (!got) {
      return fail(got.error());
    }
    read = *got;
    next = 0;
    slept = time_asleep(slept);
    reassembler.slept(slept);
    if (read > 0) {
      if (subscription && !subscription->signs()) {  // else anybody could keep it from asking
        subscription->heard(std::chrono::steady_clock::now());
      }
      continue;
    }
    // Only now: while the socket held packets, no frame was known to wait in vain.
    const Time now = std::chrono::steady_clock::now();
    reassembler.expire(now);
    if (const std::optional<Frame> frame = reassembler.take(now)) {
      return *frame;
    }
    if (now >= deadline) {
      return fail(Status::kTimeout);
    }
    const Time until = std::min(deadline, next_due().value_or(deadline));
    if (socket->wait(until - now) == Status::kDeviceLost) {
      return fail(Status::kDeviceLost);
    }
  }
}

Result<Frame> Receiver::next(Duration timeout) {
  const Result<Frame> frame = parts_->receive(timeout);
  parts_->watch.look(parts_->reassembler, std::chrono::steady_clock::now());
  if (frame) {
    parts_->watch.delivered(*frame);
  }
  return frame;
}

bool Receiver::keep(FramePixels& pixels) noexcept { return parts_->reassembler.keep(pixels); }

LinkState Receiver::link() const noexcept {
  return parts_->watch.state(std::chrono::steady_clock::now());
}

const LinkWatch& Receiver::link_watch() const noexcept { return parts_->watch; }

const Statistics& Receiver::statistics() const noexcept {
  parts_->statistics = parts_->reassembler.statistics();
  parts_->statistics.socket_drops = parts_->socket->dropped();
  return parts_->statistics;
}

const std::optional<wire::Origin>& Receiver::origin() const noexcept {
  return parts_->reassembler.origin();
}

const std::optional<wire::HealthReport>& Receiver::health() const noexcept {
  return parts_->reassembler.health();
}

Duration Receiver::period() const { return parts_->reassembler.period(); }

const std::optional<wire::CalibrationPacket>& Receiver::calibration() const noexcept {
  return parts_->reassembler.calibration();
}

std::optional<ToldEvent> Receiver::take_event() { return parts_->reassembler.take_event(); }

std::optional<ToldHealth> Receiver::take_health() { return parts_->reassembler.take_health(); }

std::optional<RawExposure> Receiver::take_raw() { return parts_->reassembler.raw().take(); }

const RawStatistics& Receiver::raw_statistics() const noexcept {
  return parts_->reassembler.raw().statistics();
}

wire::SubscribeResult Receiver::raw_refusal() const noexcept {
  return parts_->subscription ? parts_->subscription->raw_refusal() : wire::SubscribeResult::kOk;
}

std::uint16_t Receiver::port() const noexcept { return parts_->socket->port(); }

const std::string& Receiver::place() const noexcept { return parts_->socket->place(); }

std::string Receiver::sender() const {
  return parts_->sender ? parts_->sender->text() : std::string();
}

std::optional<Subscription::State> Receiver::subscription() const noexcept {
  return parts_->subscription ? std::optional(parts_->subscription->state()) : std::nullopt;
}

std::optional<std::uint32_t> Receiver::other_sensor() const noexcept {
  return parts_->subscription ? parts_->subscription->other_sensor() : std::nullopt;
}

std::optional<std::uint8_t> Receiver::other_tags() const noexcept {
  return subscription() == Subscription::State::kOtherTags
             ? std::optional(parts_->subscription->other_tags())
             : std::nullopt;
}

std::uint32_t Receiver::proven_key() const noexcept {
  return parts_->subscription ? parts_->subscription->proven_key() : 0;
}

std::optional<Duration> Receiver::round_trip() const noexcept {
  return parts_->subscription ? parts_->subscription->round_trip() : std::nullopt;
}

bool Receiver::take_refusal() noexcept { return parts_->socket->take_refusal(); }

int Receiver::fd() const noexcept { return parts_->socket->fd(); }

std::optional<Time> Receiver::next_due() const noexcept { return parts_->next_due(); }

int Receiver::socket_buffer() const noexcept { return parts_->socket->buffer_bytes(); }

std::string Receiver::advice() const {
  if (const std::optional<std::uint8_t> tags = other_tags()) {
    return other_tags_text(*tags);
  }
  if (socket_buffer() == 0 || socket_buffer() >= parts_->asked_buffer) {
    return "";
  }
  return "socket buffer: " + std::to_string(socket_buffer()) + " bytes instead of " +
         std::to_string(parts_->asked_buffer) +
         ", bursts of packets may be lost; allow more with: sysctl -w net.core.rmem_max=" +
         std::to_string(parts_->asked_buffer);
}

}  // namespace stof::client
