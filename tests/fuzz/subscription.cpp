#include "host/client/control/subscription.h"

#include <chrono>

#include "tests/fuzz/fuzz_input.h"

// Datagrams to whoever subscribes: whatever is answered, it asks in measure and again.
namespace stof {
namespace {

client::SubscriptionOptions options(bool signs) {
  client::SubscriptionOptions options{.signed_streams = signs};
  wire::Key key{.id = 1, .device = 0x0A0B0C0D, .role = wire::Role::kView};
  key.name[0] = 'a';
  if (signs) {
    fuzz::require(options.keys.add(key) == Status::kOk);
  }
  return options;
}

}  // namespace
}  // namespace stof

void stof::fuzz::run(std::span<const std::byte> input) {
  require(wire::start_crypto());
  const bool signs = input.size() % 2 != 0;  // whether streams have to be signed
  client::Subscription subscription(options(signs), 0);
  client::Time now{};
  int asked = 0;
  int pushed = 0;
  const auto ask = [&] { asked += subscription.due(now).empty() ? 0 : 1; };
  ask();
  for_each_record(input, [&](const Record& record) {
    wire::DatagramBuffer space{};
    const bool seal = (record.flags & kSeal) != 0;
    static_cast<void>(subscription.take(seal ? sealed(record.bytes, space) : record.bytes, now));
    ++pushed;
    ask();
    now += std::chrono::milliseconds(20 * record.seconds());
    ask();
  });
  require(asked <= 1 + 2 * pushed);
  // Nobody here can sign, so there is no key, and no subscription that was asked to have one.
  require(subscription.stream_key().number == 0);
  require(!signs || subscription.state() != client::Subscription::State::kActive);
  now += std::chrono::hours(1);
  require(!subscription.due(now).empty());
}
