#include "firmware/program/initial_settings.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <system_error>
#include <utility>
#include <vector>

#include "board/serial_lines.h"
#include "firmware/events/event_printer.h"
#include "firmware/settings/fields/document.h"
#include "firmware/settings/text/as_text.h"
#include "firmware/wire/keys/key_text.h"

namespace stof::firmware {
namespace {

constexpr std::size_t kLineBytes = 512;
constexpr const char* kCalibrationEnding = ".calibration";

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

// Where settings are kept, for whoever reads a line about them.
const std::string& place_of(const Options& options) {
  return options.records.empty() ? options.settings : options.records;
}

// Puts the command line's settings on top of the saved ones. Empty, or which flag takes what.
std::string activate(const Options& options, InitialSettings& initial, std::string& notes) {
  initial.active = initial.saved.settings;
  const std::string_view line = initial.active.serial.device.view();
  initial.serial_dropped = !board::takes_serial_line(line);
  if (initial.serial_dropped) {
    print_line(place_of(options) + ": serial.device: board " + board::kConfig.name +
               " has no line " + std::string(line) + " for settings, it is left alone");
    initial.active.serial.device = {};
  }
  return apply(options.assignments, initial.active, notes);
}

std::string keys_file(const Options& options) {
  return !options.keys.empty() || options.settings.empty() ? options.keys
                                                           : options.settings + ".keys";
}

// Of a file with secrets that others than its owner may read or write.
void say_readers(const std::string& file, const char* what, const char* advice) {
  namespace fs = std::filesystem;
  std::error_code unknown;
  const fs::file_status status = fs::symlink_status(file, unknown);
  const fs::perms others = status.permissions() & (fs::perms::group_all | fs::perms::others_all);
  if (!unknown && fs::is_regular_file(status) && others != fs::perms::none) {
    print_line(file + ": others than its owner could read or write " + what + ": " + advice);
  }
}

// Two names of one file, which need not exist.
bool same_file(const std::string& a, const std::string& b) {
  namespace fs = std::filesystem;
  std::error_code unknown;
  return fs::weakly_canonical(fs::absolute(a, unknown), unknown) ==
         fs::weakly_canonical(fs::absolute(b, unknown), unknown);
}

// Each document has a file of its own: what is no key file is set aside, and the sensor would be
// open; the port's number replaces what is there. Empty, or which flag takes what.
std::string check_files(const Options& options) {
  struct Named {
    std::string flag;
    std::string file;
  };
  std::vector<Named> named;
  if (!options.settings.empty()) {
    for (const char* const ending :
         {"", ".good", ".trial", ".limits", ".bad", ".new", ".calibration", ".calibration.bad",
          ".calibration.new", ".lock"}) {
      named.push_back({"--settings", options.settings + ending});
    }
  }
  if (!options.calibration.empty()) {
    named.push_back({"--calibration", options.calibration});
  }
  if (!options.label.empty()) {
    named.push_back({"--label", options.label});
  }
  if (const std::string keys = keys_file(options); !keys.empty()) {
    for (const char* const ending : {"", ".bad", ".new", ".lock"}) {
      named.push_back({"--keys", keys + ending});
    }
  }
  if (!options.records.empty()) {
    named.push_back({"--records", options.records});
  }
  for (const std::string& file : {options.network, options.network_done}) {
    if (!file.empty()) {
      named.push_back({file == options.network ? "--network" : "--network-done", file});
    }
  }
  if (!options.first_settings.empty()) {
    named.push_back({"--first-settings", options.first_settings});
  }
  if (!options.port_file.empty()) {
    named.push_back({"--port-file", options.port_file});
  }
  for (std::size_t i = 0; i < named.size(); ++i) {
    for (std::size_t k = i + 1; k < named.size(); ++k) {
      if (named[i].flag != named[k].flag && same_file(named[i].file, named[k].file)) {
        return named[k].flag + ": " + named[k].file + " is a file of " + named[i].flag +
               ": name another";
      }
    }
  }
  return {};
}

// Two programs that save in one place forget what the other one saved. The file beside it holds the
// lock: the file itself is another one after each save. Empty, or who has it.
std::string hold_files(const Options& options) {
  namespace fs = std::filesystem;
  struct Held {
    std::string name;
    std::string lock;
    bool make;
  };
  std::vector<Held> all;
  for (const std::string& name : {options.settings, keys_file(options)}) {
    std::error_code unknown;
    const fs::file_status status = fs::symlink_status(name, unknown);
    // Of what is no regular file nothing is kept.
    if (!name.empty() && (!fs::exists(status) || fs::is_regular_file(status))) {
      all.push_back({.name = name, .lock = name + ".lock", .make = true});
    }
  }
  if (!options.records.empty()) {
    all.push_back({.name = options.records, .lock = options.records, .make = false});
  }
  for (const Held& held : all) {
    if (board::hold_alone(held.lock, held.make) == Status::kWouldBlock) {
      return held.name +
             ": another stofd keeps its settings or keys there: end it, or name another";
    }
  }
  return {};
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
  if (!code || *code == keys::LabelCode{}) {
    return std::unexpected(options.label +
                           ": --label takes a file with 32 hexadecimal digits, not all of them 0");
  }
  say_readers(options.label, "the label's code",
              "its mode should be 0600, and the label another one");
  return code;
}

void open_files(const Options& options, InitialSettings& initial) {
  if (!options.settings.empty()) {
    initial.store = board::make_store(options.settings);
    initial.good = board::make_store(options.settings + ".good");
    initial.trial = board::make_store(options.settings + ".trial");
    initial.fixed = board::make_store(options.settings + ".limits");
    initial.calibration = board::make_store(options.settings + kCalibrationEnding);
  }
  if (const std::string keys = keys_file(options); !keys.empty()) {
    initial.keys = board::make_secret_store(keys);
    initial.damaged_keys = board::make_secret_store(keys + ".bad");
  }
}

void open_records(records::RecordDisk& disk, InitialSettings& initial) {
  using records::Document;
  const auto store = [&disk](Document document, std::optional<Document> aside = {}) {
    return std::make_unique<records::RecordStore>(disk, document, aside);
  };
  initial.store = store(Document::kSettings, Document::kDamagedSettings);
  initial.good = store(Document::kGoodSettings);
  initial.trial = store(Document::kTrial);
  initial.fixed = store(Document::kLimits);
  initial.calibration = store(Document::kCalibration, Document::kDamagedCalibration);
  initial.keys = store(Document::kKeys);
  initial.damaged_keys = store(Document::kDamagedKeys);
}

// Their names, with commas between them.
std::string lost_records(records::RecordDisk& disk) {
  std::string names;
  for (std::size_t i = 0; i < records::kDocuments; ++i) {
    if (disk.lost(static_cast<records::Document>(i))) {
      names.append(names.empty() ? "" : ", ").append(records::kDocumentNames[i]);
    }
  }
  return names;
}

// What became of them is said in a line; what is lost, by whoever reads it, too.
void mend_records(records::RecordDisk& disk, const std::string& name) {
  const bool mended = disk.mend() == Status::kOk;
  if (disk.cut_off()) {
    print_line(name +
               ": it has become smaller: what is left of what is kept there is read, and nothing "
               "saved, until it has its size again");
  } else if (disk.moved()) {
    print_line(name + ": its size has changed: what is kept there stays where it is");
  }
  const std::string lost = lost_records(disk);
  if (!lost.empty()) {
    print_line(
        name + ": lost, damaged or older than it was: " + lost +
        ": what holds in their place is said by conditions and lines; write the card again if "
        "it happens again");
  } else if (!mended && !disk.cut_off()) {
    print_line(name + ": cannot be written: nothing can be saved: write the card again");
  }
}

// What was put on the card before the first start.
void take_first_settings(const Options& options, const InitialSettings& initial) {
  if (options.first_settings.empty()) {
    return;
  }
  std::array<std::byte, settings::kMostDocumentBytes> bytes{};
  const Result<std::optional<std::size_t>> read =
      board::make_store(options.first_settings)->load(bytes);
  if (!read) {
    print_line(options.first_settings + ": cannot be read, or is longer than " +
               std::to_string(bytes.size()) + " bytes: none of it is taken");
  }
  if (!read || !*read) {
    return;
  }
  std::array<char, kLineBytes> space{};
  settings::PagedWriter line(space);
  settings::save_first(initial.stores(), settings::as_text(std::span(bytes).first(**read)),
                       options.first_settings, line);
  say(line);
}

// Empty, or which flag takes what.
std::string open_stores(const Options& options, InitialSettings& initial) {
  if (options.records.empty()) {
    open_files(options, initial);
    return {};
  }
  if (!options.settings.empty() || !options.keys.empty()) {
    return "--records: takes the place of --settings and --keys: leave them out";
  }
  Result<std::unique_ptr<hal::Disk>> disk = board::make_disk(options.records);
  std::string too_small =
      options.records + ": --records takes a partition of 12 MiB at least, or such a file";
  if (!disk) {
    return too_small;
  }
  initial.disk = std::move(*disk);
  initial.records = std::make_unique<records::RecordDisk>(*initial.disk);
  if (initial.disk->bytes() < records::kRecordsBytes && !initial.records->found()) {
    return too_small;
  }
  mend_records(*initial.records, options.records);
  open_records(*initial.records, initial);
  return {};
}

}  // namespace

void read_keys(const Options& options, keys::Keyring& ring) {
  std::array<char, kLineBytes> space{};
  settings::PagedWriter line(space);
  const std::string file = options.records.empty() ? keys_file(options) : options.records;
  if (!file.empty() && options.records.empty()) {  // before load(), which takes that back
    say_readers(file, "the keys",
                "its mode is 0600 from now on; renew the keys (stof pair --renew), or pair anew");
  }
  ring.load(file, line);
  say(line);
}

void forget_start(const InitialSettings& initial) noexcept {
  if (initial.store == nullptr || !initial.saved.on_trial) {
    return;
  }
  const settings::Settings& settings = initial.saved.settings;
  if (const int failed = settings::failed_starts(*initial.trial, settings); failed > 0) {
    static_cast<void>(settings::count_failed_starts(*initial.trial, settings, failed - 1));
  }
}

bool names(const Options& options, std::string_view path) {
  return std::ranges::find(options.assignments, path, &Assignment::path) !=
         options.assignments.end();
}

std::expected<InitialSettings, StartRefusal> read_settings(const Options& options) {
  if (std::string why = check_files(options); !why.empty()) {
    return std::unexpected(StartRefusal{.message = std::move(why)});
  }
  if (std::string why = hold_files(options); !why.empty()) {
    return std::unexpected(StartRefusal{.message = std::move(why), .in_use = true});
  }
  if (options.network.empty() != options.network_done.empty()) {
    return std::unexpected(
        StartRefusal{.message = "--network and --network-done: one takes the other beside it"});
  }
  InitialSettings initial;
  if (!keys_file(options).empty() || !options.records.empty() || !options.label.empty()) {
    board::keep_memory_private();
  }
  if (std::string why = open_stores(options, initial); !why.empty()) {
    return std::unexpected(StartRefusal{.message = std::move(why)});
  }
  if (initial.store != nullptr) {
    take_first_settings(options, initial);
    std::array<char, kLineBytes> space{};
    settings::PagedWriter line(space);
    initial.saved = settings::load_settings(initial.stores(), place_of(options), nullptr, line);
    say(line);
  }
  auto label = read_label(options);
  if (!label) {
    forget_start(initial);
    return std::unexpected(StartRefusal{.message = std::move(label.error())});
  }
  initial.label = *label;
  std::string notes;
  if (std::string why = activate(options, initial, notes); !why.empty()) {
    forget_start(initial);
    return std::unexpected(StartRefusal{.message = std::move(why)});
  }
  if (!notes.empty()) {
    print_line(notes);
  }
  return initial;
}

InstalledCalibration read_installed(const Options& options, const InitialSettings& initial) {
  InstalledCalibration installed{
      .place = place_of(options) + kCalibrationEnding, .file = {}, .unreadable = false};
  if (initial.calibration == nullptr) {
    return installed;
  }
  installed.file.resize(most_calibration_bytes(board::kConfig));
  const Result<std::optional<std::size_t>> loaded = initial.calibration->load(installed.file);
  if (loaded && !*loaded) {
    installed.file.clear();
  } else if (loaded) {
    installed.file.resize(std::max<std::size_t>(**loaded, 1));  // an empty one is damaged
  } else if (loaded.error() == Status::kTooLarge) {
    installed.file.resize(1);  // none of this board, and judged as one that is damaged
  } else {
    installed.file.clear();
    installed.unreadable = true;
  }
  return installed;
}

void begin_network(const Options& options, InitialSettings& initial) {
  if (options.network.empty()) {
    return;
  }
  initial.network_wanted = board::make_store(options.network);
  initial.network_done = board::make_store(options.network_done);
  initial.network.emplace(*initial.network_wanted, *initial.network_done);
  if (!initial.network->begin(initial.active.network)) {
    print_line(options.network + ": cannot be written: no address is set");
  }
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
    initial.saved = settings::reload_settings(initial.stores(), place_of(options), limits, line);
    say(line);
    static_cast<void>(activate(options, initial, told_at_first));
  }
  settings::PagedWriter clash(space);
  if (limits.accepts(initial.active, clash)) {
    return;
  }
  settings::Settings plain;
  const bool strictest = !settings::keep_fixed(initial.stores(), plain);
  std::array<char, kLineBytes> unused_space{};
  settings::PagedWriter unused(unused_space);
  if (apply(options.assignments, plain, told_at_first).empty() && limits.accepts(plain, unused)) {
    print_line(place_of(options) + ": " + std::string(clash.text()) +
               ", with this command line: the defaults hold");
    initial.saved = {.dropped = settings::Dropped::kUnusable, .strictest = strictest};
    initial.active = plain;
  }
}

}  // namespace stof::firmware
