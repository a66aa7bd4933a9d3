#include "host/cli/config/config.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <optional>
#include <span>
#include <string_view>
#include <utility>

#include "host/cli/config/settings_text.h"
#include "host/cli/failure.h"
#include "host/cli/help_text.h"
#include "host/cli/output.h"
#include "host/cli/own_keys.h"
#include "host/cli/sensor/find_sensor.h"
#include "host/cli/words.h"
#include "host/client/control/known_sensors.h"
#include "host/client/control/user_keys.h"
#include "host/client/printable.h"
#include "host/client/serial/serial_line.h"

namespace stof::host {
namespace {

using Operation = wire::SettingsOperation;
using Document = wire::SettingsDocument;
using Words = std::span<const std::string>;

// Of a change that no start will know of. What applies at a restart is then in force at no time.
constexpr const char* kUnsaved = "in force, until the next start: save keeps it";
constexpr const char* kUnsavedWaits =
    "taken; save it: some settings come into force with the next start, and only if they are saved";

// Of who may save nothing.
constexpr const char* kPassing = "in force, until the next start";
constexpr const char* kPassingWaits =
    "taken, but some settings come into force with the next start, and only if they are saved, "
    "which takes a key";

constexpr const char* kActions =
    "get, set, stage, commit, revert, preset, save, reset, diff or schema";

struct NamedDocument {
  std::string_view name;
  Document document;
};
constexpr std::array<NamedDocument, 4> kDocuments{{{"active", Document::kActive},
                                                   {"staged", Document::kStaged},
                                                   {"saved", Document::kSaved},
                                                   {"defaults", Document::kDefaults}}};

client::ControlOptions control_options(const ConfigOptions& options) {
  client::ControlOptions control{.timeout = std::chrono::duration_cast<client::Duration>(
                                     std::chrono::duration<double>(options.timeout_s))};
  if (!options.keys.empty()) {
    control.keys = value_or_fail(client::read_user_keys(options.keys));
  }
  control.device_id = options.device;
  if (!options.sensor.empty() || !options.key.empty()) {
    client::Meant meant = meant_by(options.keys, control.keys, options.sensor,
                                   {.device = options.device, .key_id = key_id_of(options.key)});
    control.device_id = meant.device;
    control.keys = meant.keys;
    control.doubt = std::move(meant.doubt);
  }
  if (!control.device_id) {
    control.device_id = found_device(options.sensor);
  }
  if (!options.serial.empty()) {
    control.unsigned_answers = client::Unsigned::kAlways;
  }
  control.overall = std::max(control.overall, 2 * control.attempts * control.timeout);
  return control;
}

class Session {
 public:
  Session(std::unique_ptr<client::ControlTransport> transport,
          const client::ControlOptions& control, const ConfigOptions& options)
      : place_(transport->place()),
        client_(std::move(transport), control),
        unclear_(!control.doubt.empty()),
        json_(options.json),
        may_save_(options.may_save) {}

  const std::optional<client::ControlClient::Proof>& proven() const { return client_.proven(); }

  void check_called(const std::string& called) { host::check_called(client_, called); }

  // An answer that is no refusal, or throws.
  client::ControlAnswer ask(Operation operation, std::string_view text = {},
                            Document document = {}) {
    auto answer = client_.request(operation, document, text);
    if (!answer) {
      // Nobody knows which sensor is meant: that one may be read, and nothing else.
      const bool unclear = unclear_ && answer.error().status == Status::kUnsupported;
      throw Failure(unclear ? Exit::kBadInput : Exit::kFailure, answer.error().message);
    }
    switch (answer->result) {
      case wire::SettingsResult::kOk:
        return std::move(*answer);
      case wire::SettingsResult::kInvalid:
        throw Failure(Exit::kBadInput, place_ + ": " + answer->text);
      case wire::SettingsResult::kDenied:
      case wire::SettingsResult::kNotSaved:
        throw Failure(Exit::kFailure, place_ + ": " + answer->text);
      case wire::SettingsResult::kUnknownKey:
        throw Failure(Exit::kFailure, place_ + ": " + unknown_key_text(answer->text));
      case wire::SettingsResult::kBusy:
        throw Failure(Exit::kFailure, place_ + ": is busy: try again");
      default:
        throw Failure(Exit::kFailure, place_ + ": does not know this request: update the sensor");
    }
  }

  Json read(Document document) {
    std::optional<Json> parsed = read_json(ask(Operation::kGet, {}, document).text);
    if (!parsed || !parsed->is_object()) {
      throw Failure(Exit::kFailure,
                    place_ + ": answers with what is no document: update the sensor");
    }
    return *std::move(parsed);
  }

  std::string get(Words words, std::string_view name) {
    const auto* const found = std::ranges::find(kDocuments, name, &NamedDocument::name);
    const Json value = settings_at(read(found->document), words.empty() ? "" : words[0]);
    return (value.is_object() || json_ ? value.dump(2) : settings_value(value)) + "\n";
  }

  std::string schema() { return ask(Operation::kGet, {}, Document::kSchema).text; }

  std::string diff() {
    const Json defaults = read(Document::kDefaults);
    const std::vector<SettingsChange> changes = settings_diff(read(Document::kActive), defaults);
    if (json_) {
      Json all = Json::object();
      for (const SettingsChange& change : changes) {
        all[change.path] = {{"value", change.value}, {"default", change.before}};
      }
      return all.dump(2) + "\n";
    }
    std::size_t width = 0;
    for (const SettingsChange& change : changes) {
      width = std::max(width, change.path.size());
    }
    std::string text;
    for (const SettingsChange& change : changes) {
      text += change.path + std::string(width - change.path.size() + 2, ' ') +
              settings_value(change.value) + "  (default " + settings_value(change.before) + ")\n";
    }
    return text.empty() ? "every setting is at its default\n" : text;
  }

  std::string stage(Words words) {
    client::ControlAnswer last;
    std::string notes;
    for (const std::string& piece : pieces(words)) {
      last = ask(Operation::kStage, piece);
      add_note(last.text, notes);
    }
    last.text = notes;
    return done(last, "staged: commit brings it into force");
  }

  // At once, and whole: what does not fit one request is staged and committed.
  std::string set(Words words) {
    const std::vector<std::string> texts = pieces(words);
    if (texts.size() == 1) {
      return done(ask(Operation::kSet, texts.front()), kUnsaved);
    }
    static_cast<void>(ask(Operation::kRevert));
    try {
      std::string notes;
      for (const std::string& text : texts) {
        add_note(ask(Operation::kStage, text).text, notes);
      }
      client::ControlAnswer answer = ask(Operation::kCommit);
      add_note(answer.text, notes);
      answer.text = notes;
      return done(answer, "in force and saved");
    } catch (const Failure&) {
      // Whatever comes of it, the first failure is the one to tell.
      static_cast<void>(client_.request(Operation::kRevert, {}, {}));
      throw;
    }
  }

  std::string change(Operation operation, std::string_view text, const char* what) {
    return done(ask(operation, text), what);
  }

  // Tells the new name, too: by the former one nobody finds the sensor any more.
  std::string reset() {
    const std::string former = name_in_settings(read(Document::kActive));
    const std::string name = name_in_settings(read(Document::kDefaults));
    client::ControlAnswer answer = ask(Operation::kReset);
    if (name != former) {
      add_note("it was called \"" + former + "\" and is called \"" + name + "\" now", answer.text);
    }
    return done(answer, "every setting at its default, until the next start: save keeps it");
  }

 private:
  static std::vector<std::string> pieces(Words words) {
    return settings_pieces(settings_from_words(words), client::ControlClient::kMaxText);
  }

  static void add_note(const std::string& note, std::string& notes) {
    notes += (notes.empty() || note.empty() ? "" : "; ") + note;
  }

  const char* unsaved_text(bool restart) const {
    if (may_save_) {
      return restart ? kUnsavedWaits : kUnsaved;
    }
    return restart ? kPassingWaits : kPassing;
  }

  // The text of an answer that is no refusal says which fields the sensor has otherwise than asked.
  std::string done(const client::ControlAnswer& answer, const char* what) const {
    if (json_) {
      Json told{{"revision", answer.revision}, {"restart", answer.restart}};
      if (!answer.text.empty()) {
        told["note"] = answer.text;
      }
      if (client_.proven()) {
        told["sensor"] = client_.proven()->device;
      }
      return told.dump() + "\n";
    }
    const std::string sensor =
        client_.proven() ? " of sensor " + std::to_string(client_.proven()->device) : "";
    const bool unsaved = what == std::string_view(kUnsaved);
    const char* const waits =
        answer.restart && !unsaved ? "; some settings wait for the next start" : "";
    return "revision " + std::to_string(answer.revision) + sensor + ", " +
           (unsaved ? unsaved_text(answer.restart) : what) + waits + "\n" +
           (answer.text.empty() ? "" : answer.text + "\n");
  }

  std::string place_;
  client::ControlClient client_;
  bool unclear_;
  bool json_;
  bool may_save_;
};

void expect_words(const std::string& action, std::size_t count, std::size_t least,
                  std::size_t most) {
  if (count < least) {
    throw Failure(Exit::kBadInput, action + ": something is missing behind it: try --help");
  }
  if (count > most) {
    throw Failure(Exit::kBadInput, action + ": too much behind it: try --help");
  }
}

std::string act(Session& session, const std::string& action, Words words, const std::string& name) {
  const std::size_t count = words.size();
  if (action == "get") {
    expect_words(action, count, 0, 1);
    return session.get(words, name);
  }
  if (action == "set") {
    return session.set(words);
  }
  if (action == "stage") {
    return session.stage(words);
  }
  if (action == "preset") {
    expect_words(action, count, 1, 1);
    return session.change(Operation::kPreset, words[0], kUnsaved);
  }
  expect_words(action, count, 0, 0);
  if (action == "commit") {
    return session.change(Operation::kCommit, {}, "in force and saved");
  }
  if (action == "revert") {
    return session.change(Operation::kRevert, {}, "nothing is staged");
  }
  if (action == "save") {
    return session.change(Operation::kSave, {}, "saved");
  }
  if (action == "reset") {
    return session.reset();
  }
  return action == "diff" ? session.diff() : session.schema();
}

constexpr std::array<std::string_view, 10> kNames{"get",    "set",  "stage", "commit", "revert",
                                                  "preset", "save", "reset", "diff",   "schema"};

bool is_action(std::string_view word) { return std::ranges::find(kNames, word) != kNames.end(); }

// A sensor may be called "get", where an action follows.
bool names_no_sensor(Words words) {
  return words.empty() || (is_action(words[0]) && (words.size() == 1 || !is_action(words[1])));
}

// Before anything is sent.
void judge_config_words(const std::vector<std::string>& words) {
  if (words.empty()) {
    throw Failure(Exit::kBadInput, "config: what to do is missing: " + std::string(kActions));
  }
  if (!is_action(words[0])) {
    const std::vector<std::string> known(kNames.begin(), kNames.end());
    const std::string near = nearest_word(words[0], known);
    throw Failure(Exit::kBadInput, "config: \"" + words[0] + "\" is none of " + kActions +
                                       (near.empty() ? "" : ": did you mean " + near));
  }
}

}  // namespace

std::string config_over(std::unique_ptr<client::ControlTransport> transport,
                        const std::vector<std::string>& words, const ConfigOptions& options) {
  judge_config_words(words);
  const std::string address = transport->place();
  const client::ControlOptions control = control_options(options);
  // Whoever is read from where nobody knows which sensor is meant proves nothing of this place.
  const bool certain = !options.sensor.empty() && control.doubt.empty();
  Session session(std::move(transport), control, options);
  session.check_called(options.sensor);
  std::string text = client::printable(
      act(session, words[0], Words(words).subspan(1), options.document), client::Lines::kSeveral);
  if (session.proven() && certain) {
    remember_place(options.keys, {.named = options.sensor, .address = address},
                   session.proven()->key_id);
  }
  return text;
}

void config(const ConfigOptions& options) {
  std::vector<std::string> words = options.words;
  std::unique_ptr<client::ControlTransport> transport;
  ConfigOptions whole = options;
  whole.keys = keys_file(options.keys);
  if (options.serial.empty()) {
    if (names_no_sensor(words)) {
      throw Failure(Exit::kBadInput, "config: which sensor is missing" +
                                         (words.empty() ? "" : " before " + words[0]) +
                                         ": HOST[:PORT], or --serial");
    }
    whole.sensor = words.front();
    words.erase(words.begin());
    judge_config_words(words);
    transport = open_sensor(whole.sensor);
  } else {
    judge_config_words(words);
    transport = value_or_fail(client::open_serial_transport(options.serial, options.baud));
  }
  const std::string text = config_over(std::move(transport), words, whole);
  say_text(text);
}

void add_config(CLI::App& app, ConfigOptions& options) {
  CLI::App& command = *app.add_subcommand("config", "Read or change a sensor's settings");
  show_example(command, "stof config 192.168.1.20 set depth.max_range_mm=5000",
               "Ends with 0 (done), 1 (no answer, refused, or the output cannot be written) or 2 "
               "(bad input, or a setting that the sensor does not take).");
  command.add_option("WORDS", options.words,
                     std::string("SENSOR (serial number, name or HOST[:PORT]; none with --serial), "
                                 "then get [PATH], set PATH=VALUE... or FILE, stage (the same), "
                                 "commit, revert, preset NAME (") +
                         kPresetNames + "), save, reset, diff, schema");
  command.add_option("--document", options.document, "Of get: active, staged, saved or defaults")
      ->check(CLI::IsMember({"active", "staged", "saved", "defaults"}))
      ->capture_default_str();
  add_control_flags(command, options);
  command.add_flag("--json", options.json, "Print JSON");
  command.callback([&options] { config(options); });
}

}  // namespace stof::host
