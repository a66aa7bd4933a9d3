#include "host/discovery/discover.h"

#include <algorithm>
#include <chrono>
#include <cstring>

#include "host/lib/sensor.h"

using namespace stof;

namespace {

template <std::size_t kSize>
void put(const std::string& text, char (&out)[kSize]) noexcept {
  lib::give_text(text, out, kSize);
}

stof_found to_found(const client::FoundSensor& sensor) noexcept {
  stof_found out{};
  put(sensor.serial, out.serial);
  put(sensor.name, out.name);
  put(sensor.version, out.version);
  put(sensor.board, out.board);
  put(sensor.endpoint(), out.endpoint);
  out.device_id = sensor.device_id;
  constexpr std::uint32_t kFlags[]{STOF_FOUND_BY_MDNS, STOF_FOUND_BY_BEACON, STOF_FOUND_DIRECTLY};
  for (std::size_t method = 0; method < client::kDiscoveryMethods; ++method) {
    out.found_by |= sensor.methods[method] ? kFlags[method] : 0;
  }
  out.health = sensor.health ? static_cast<std::int32_t>(*sensor.health) : -1;
  out.rate_hz = static_cast<float>(sensor.rate_millihertz.value_or(0)) / 1000;
  out.subscribers = sensor.subscribers;
  out.most_subscribers = sensor.most_subscribers;
  return out;
}

}  // namespace

extern "C" {

stof_status stof_discover(int timeout_ms, const char* const* addresses, size_t address_count,
                          stof_found* found, size_t capacity, size_t found_size, size_t* count,
                          char* why, size_t why_size) {
  lib::give_text("", why, why_size);
  if (count == nullptr || timeout_ms < 0 || (addresses == nullptr && address_count != 0) ||
      (found == nullptr && capacity != 0) || found_size == 0) {
    return STOF_BAD_ARGUMENT;
  }
  *count = 0;
  return lib::guarded([&] {
    client::DiscoverOptions options{.timeout = std::chrono::milliseconds(timeout_ms)};
    options.addresses.assign(addresses, addresses + address_count);
    const auto sensors = client::discover(options);
    if (!sensors) {
      lib::give_text(sensors.error().message, why, why_size);
      return STOF_BAD_ARGUMENT;
    }
    *count = sensors->size();
    // The caller's structure may be shorter or longer than ours.
    auto* const bytes = reinterpret_cast<std::byte*>(found);
    for (std::size_t i = 0; i < std::min(*count, capacity); ++i) {
      const stof_found one = to_found((*sensors)[i]);
      std::memset(bytes + i * found_size, 0, found_size);
      std::memcpy(bytes + i * found_size, &one, std::min(found_size, sizeof one));
    }
    return *count > capacity ? STOF_TOO_SMALL : STOF_OK;
  });
}

}  // extern "C"
