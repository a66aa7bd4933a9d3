#include "host/cli/pair.h"

#include <array>
#include <cstdio>
#include <cstdlib>
#include <limits>

#include <unistd.h>

#include "firmware/wire/bytes.h"
#include "firmware/wire/crypto/crypto.h"
#include "firmware/wire/keys/key_text.h"
#include "host/cli/failure.h"
#include "host/client/control/user_keys.h"

namespace stof::host {
namespace {

std::string user_and_host() {
  const char* const user = std::getenv("USER");  // NOLINT(concurrency-mt-unsafe): nobody sets one
  std::array<char, 64> host{};
  static_cast<void>(::gethostname(host.data(), host.size() - 1));
  return std::string(user == nullptr ? "user" : user) + "@" + host.data();
}

wire::Key random_key(const PairOptions& options) {
  if (!wire::start_crypto()) {
    throw Failure(Exit::kFailure, "pair: this system has no random numbers");
  }
  std::array<std::byte, 4> id{};
  wire::fill_random(id);
  wire::Key key{.id = std::max(wire::get_u32(id), 1U),
                .device = options.device,
                .role = wire::role_of(options.role),
                .name = wire::key_name(options.name.empty() ? user_and_host() : options.name)};
  wire::fill_random(key.secret);
  return key;
}

// Whether both files have a key in common already.
bool paired(const wire::KeyTable& sensor, const wire::KeyTable& user, std::uint32_t device) {
  for (const wire::Key& key : user.all()) {
    const wire::Key* const same = sensor.find(key.id);
    if (key.device == device && same != nullptr && same->role == key.role &&
        wire::equal_secrets(same->secret, key.secret)) {
      return true;
    }
  }
  return false;
}

}  // namespace

std::string keys_file(const std::string& named) {
  return named.empty() ? client::user_keys_file() : named;
}

void pair(const PairOptions& options) {
  const std::string own = keys_file(options.keys);
  wire::KeyTable sensor = value_or_fail(client::read_user_keys(options.into));
  if (paired(sensor, value_or_fail(client::read_user_keys(own)), options.device)) {
    std::printf("%s: has a key of %s already\n", options.into.c_str(), own.c_str());
    return;
  }
  const wire::Key key = random_key(options);
  if (sensor.add(key) != Status::kOk) {
    throw Failure(Exit::kFailure, options.into + ": takes no more keys");
  }
  value_or_fail(client::write_user_keys(options.into, sensor));
  value_or_fail(client::add_user_key(own, key));
  std::printf("key %08x, %s, is in %s and in %s\n", key.id, options.role.c_str(),
              options.into.c_str(), own.c_str());
}

void add_pair(CLI::App& app, PairOptions& options) {
  CLI::App& command = *app.add_subcommand("pair", "Make a key that a sensor and you share");
  command
      .add_option("--into", options.into,
                  "Key file of a sensor that does not run: gets the key (stofd --keys)")
      ->required();
  command.add_option("--device", options.device, "Its device number (stofd --device)")
      ->check(CLI::Range(std::uint32_t{0}, std::numeric_limits<std::uint32_t>::max()))
      ->capture_default_str();
  command.add_option("--role", options.role, "What the key may: view, tune or admin")
      ->check(CLI::IsMember({"view", "tune", "admin"}))
      ->capture_default_str();
  command.add_option("--name", options.name, "Whose it is (default: user@host)");
  command.add_option("--keys", options.keys,
                     "Your key file (default: ~/.config/stof/keys, or as XDG_CONFIG_HOME says)");
  command.callback([&options] { pair(options); });
}

}  // namespace stof::host
