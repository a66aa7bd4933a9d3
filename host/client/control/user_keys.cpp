#include "host/client/control/user_keys.h"

#include <cstdlib>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "firmware/wire/keys/key_text.h"
#include "host/client/control/own_file.h"

namespace stof::client {
namespace {

const char* variable(const char* name) {
  const char* const value = std::getenv(name);  // NOLINT(concurrency-mt-unsafe): nobody sets one
  return value == nullptr ? "" : value;
}

}  // namespace

std::string user_keys_file() {
  const std::string_view config = variable("XDG_CONFIG_HOME");
  if (!config.empty()) {
    return std::string(config) + "/stof/keys";
  }
  const std::string_view home = variable("HOME");
  return home.empty() ? "" : std::string(home) + "/.config/stof/keys";
}

std::expected<wire::KeyTable, OpenError> read_user_keys(const std::string& file) {
  auto text =
      read_own_file(file, wire::kMostKeyText,
                    "others may read these keys: chmod 600, and pair again if somebody did");
  if (!text) {
    return std::unexpected(std::move(text.error()));
  }
  wire::KeyTable keys;
  if (!*text) {
    return keys;
  }
  const Status read = wire::read_keys({(*text)->data(), (*text)->size()}, keys);
  wire::wipe(std::as_writable_bytes(std::span(**text)));
  if (read != Status::kOk) {
    return refuse_file(Status::kCorrupt, file,
                       read == Status::kUnsupported
                           ? "of a later version: update this program"
                           : "no key file, or damaged: move it away and pair again");
  }
  return keys;
}

std::function<std::optional<wire::KeyTable>()> rereading(const std::string& file) {
  return [file]() -> std::optional<wire::KeyTable> {
    const auto keys = read_user_keys(file);
    return keys ? std::optional(*keys) : std::nullopt;
  };
}

std::expected<void, OpenError> write_user_keys(const std::string& file,
                                               const wire::KeyTable& keys) {
  std::vector<char> space(wire::kMostKeyText);
  const auto written = write_own_file(file, wire::write_keys(keys, space));
  wire::wipe(std::as_writable_bytes(std::span(space)));
  return written;
}

std::expected<void, OpenError> update_user_keys(const std::string& file, const ChangeKeys& change) {
  const std::expected<posix::Fd, OpenError> lock = lock_own_file(file);
  if (!lock) {
    return std::unexpected(lock.error());
  }
  const std::expected<wire::KeyTable, OpenError> keys = read_user_keys(file);
  if (!keys) {
    return std::unexpected(keys.error());
  }
  const std::expected<wire::KeyTable, OpenError> next = change(*keys);
  return next ? write_user_keys(file, *next) : std::unexpected(next.error());
}

std::expected<void, OpenError> add_user_key(const std::string& file, const wire::Key& key) {
  return update_user_keys(
      file, [&](const wire::KeyTable& keys) -> std::expected<wire::KeyTable, OpenError> {
        wire::KeyTable next;
        for (const wire::Key& old : keys.all()) {
          if (old.id != key.id || old.device != key.device) {
            static_cast<void>(next.add(old));
          }
        }
        if (const Status added = next.add(key); added != Status::kOk) {
          return refuse_file(
              added, file,
              added == Status::kTooLarge
                  ? "holds as many keys as it takes: stof unpair ends one, with --forget "
                    "those of a sensor that is gone"
                  : "has another sensor's key of that number: pair again");
        }
        return next;
      });
}

}  // namespace stof::client
