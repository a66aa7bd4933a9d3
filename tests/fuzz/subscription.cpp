#include "host/client/control/subscription.h"

#include <chrono>

#include "tests/fuzz/fuzz_input.h"

// Datagrams to whoever subscribes: whatever is answered, it asks in measure and again.
void stof::fuzz::run(std::span<const std::byte> input) {
  client::Subscription subscription({}, 0);
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
  now += std::chrono::hours(1);
  require(!subscription.due(now).empty());
}
