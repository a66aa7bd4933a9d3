#include "firmware/program/initial_settings.h"

#include <algorithm>
#include <array>
#include <utility>

#include "board/serial_lines.h"
#include "firmware/events/event_printer.h"
#include "firmware/settings/text/as_text.h"
#include "firmware/wire/keys/key_text.h"

namespace stof::firmware {
namespace {

constexpr std::size_t kLineBytes = 512;

// Of a board whose rig is known.
class RigLimits final : public settings::Limits {
 public:
  explicit RigLimits(const RigInfo& rig) : rig_(rig) {}
  bool accepts(const settings::Settings& settings, settings::PagedWriter& why) noexcept override {
    const auto run_config = make_run_config(rig_, board::kConfig, settings);
    if (!run_config) {
      why << run_config.error();
    }
    return run_config.has_value();
  }

 private:
  const RigInfo& rig_;
};

void say(const settings::PagedWriter& line) {
  if (!line.text().empty()) {
    print_line(std::string(line.text()));
  }
}

// Puts the command line's settings on top of the saved ones. Empty, or which flag takes what.
std::string activate(const Options& options, InitialSettings& initial, std::string& notes) {
  initial.active = initial.saved.settings;
  const std::string_view line = initial.active.serial.device.view();
  initial.serial_dropped = !board::takes_serial_line(line);
  if (initial.serial_dropped) {
    print_line(options.settings + ": serial.device: board " + board::kConfig.name +
               " has no line " + std::string(line) + " for settings, it is left alone");
    initial.active.serial.device = {};
  }
  return apply(options.assignments, initial.active, notes);
}

std::string keys_file(const Options& options) {
  return !options.keys.empty() || options.settings.empty() ? options.keys
                                                           : options.settings + ".keys";
}

// Error: one line.
std::expected<std::optional<keys::LabelCode>, std::string> read_label(const Options& options) {
  if (options.label.empty()) {
    return std::nullopt;
  }
  std::array<std::byte, 64> bytes{};
  const Result<std::optional<std::size_t>> read = board::make_store(options.label)->load(bytes);
  const std::string_view text = settings::as_text(bytes);
  const auto code = !read || !*read ? std::nullopt : wire::code_of(text.substr(0, **read));
  wire::wipe(bytes);
  if (!code) {
    return std::unexpected(options.label + ": --label takes a file with 32 hexadecimal digits");
  }
  return code;
}

}  // namespace

void read_keys(const Options& options, keys::Keyring& ring) {
  std::array<char, kLineBytes> space{};
  settings::PagedWriter line(space);
  ring.load(keys_file(options), line);
  say(line);
}

bool names(const Options& options, std::string_view path) {
  return std::ranges::find(options.assignments, path, &Assignment::path) !=
         options.assignments.end();
}

std::expected<InitialSettings, std::string> read_settings(const Options& options) {
  InitialSettings initial;
  if (!options.settings.empty()) {
    initial.store = board::make_store(options.settings);
    initial.good = board::make_store(options.settings + ".good");
    initial.trial = board::make_store(options.settings + ".trial");
    std::array<char, kLineBytes> space{};
    settings::PagedWriter line(space);
    initial.saved = settings::load_settings(initial.stores(), options.settings, nullptr, line);
    say(line);
  }
  if (const std::string keys = keys_file(options); !keys.empty()) {
    initial.keys = board::make_secret_store(keys);
    initial.damaged_keys = board::make_secret_store(keys + ".bad");
  }
  auto label = read_label(options);
  if (!label) {
    return std::unexpected(std::move(label.error()));
  }
  initial.label = *label;
  std::string notes;
  if (std::string why = activate(options, initial, notes); !why.empty()) {
    return std::unexpected(std::move(why));
  }
  if (!notes.empty()) {
    print_line(notes);
  }
  return initial;
}

void drop_unusable(const RigInfo& rig, const Options& options, InitialSettings& initial) {
  if (initial.store == nullptr) {
    return;
  }
  RigLimits limits(rig);
  std::string told_at_first;
  std::array<char, kLineBytes> space{};
  settings::PagedWriter why(space);
  if (!limits.accepts(initial.saved.settings, why)) {
    std::array<char, kLineBytes> line_space{};
    settings::PagedWriter line(line_space);
    initial.saved = settings::reload_settings(initial.stores(), options.settings, limits, line);
    say(line);
    static_cast<void>(activate(options, initial, told_at_first));
  }
  settings::PagedWriter clash(space);
  if (limits.accepts(initial.active, clash)) {
    return;
  }
  settings::Settings plain;
  std::array<char, kLineBytes> unused_space{};
  settings::PagedWriter unused(unused_space);
  if (apply(options.assignments, plain, told_at_first).empty() && limits.accepts(plain, unused)) {
    print_line(options.settings + ": " + std::string(clash.text()) +
               ", with this command line: the defaults hold");
    initial.saved = {.dropped = settings::Dropped::kUnusable};
    initial.active = plain;
  }
}

}  // namespace stof::firmware
