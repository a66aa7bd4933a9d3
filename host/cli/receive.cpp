#include "host/cli/receive.h"

#include "dataset/files/file.h"
#include "host/cli/control_flags.h"
#include "host/cli/failure.h"
#include "host/cli/help_text.h"
#include "host/cli/json_output.h"
#include "host/cli/live/frame_wait.h"
#include "host/cli/live/link_teller.h"
#include "host/cli/own_keys.h"
#include "host/cli/sensor/find_sensor.h"
#include "host/cli/view/status_line.h"
#include "host/client/control/known_sensors.h"
#include "host/client/control/user_keys.h"

namespace stof::host {
namespace {

constexpr double kAnswerS = 0.3;

// Of --signed.
client::Meant signer_of(const ReceiveOptions& options) {
  const std::string file = keys_file(options.keys);
  return meant_or_fail(file, value_or_fail(client::read_user_keys(file)), options.sensor,
                       {.device = options.device, .key_id = key_id_of(options.key)});
}

// Of signed streams with the keys, and with the sensor that is meant, also in `options`.
client::SubscriptionOptions subscription(ReceiveOptions& options, const wire::RawRequest& raw) {
  client::SubscriptionOptions terms{.raw = raw, .signed_streams = options.signed_streams};
  if (options.signed_streams) {
    options.keys = keys_file(options.keys);
    const client::Meant meant = signer_of(options);
    terms.keys = meant.keys;
    terms.reread = client::rereading(options.keys);
    options.device = meant.device;
    if (meant.keys.count() != 0) {  // else the subscription says what is missing
      check_called(options.sensor, reading_control(options), meant.keys);
    }
  }
  return terms;
}

}  // namespace

client::Receiver open_receiver(ReceiveOptions& options, const wire::RawRequest& raw) {
  client::ReceiverOptions where{.sensor = sensor_address(options.sensor),
                                .subscription = subscription(options, raw)};
  where.address = options.bind.value_or(where.address);
  where.port = options.port.value_or(where.port);
  where.reassembler = options.reassembler;
  if (!options.device) {
    options.device = found_device(options.sensor);
  }
  where.reassembler.device_id = options.device;
  std::expected<client::Receiver, client::OpenError> receiver = client::Receiver::open(where);
  if (!receiver) {
    throw Failure(Exit::kBadInput, receiver.error().message);
  }
  return std::move(*receiver);
}

client::ControlOptions reading_control(const ReceiveOptions& options) {
  client::ControlOptions control = timing(kAnswerS);
  control.signed_alone = options.signed_streams;
  control.device_id = options.device ? options.device : found_device(options.sensor);
  if (options.signed_streams) {
    const client::Meant meant = signer_of(options);
    control.keys = meant.keys;
    control.device_id = meant.device ? meant.device : control.device_id;
  }
  return control;
}

std::string place_of(const client::Receiver& receiver) { return "UDP " + receiver.place(); }

std::string silence_text(client::Receiver& receiver, std::optional<std::uint32_t> meant) {
  if (meant && receiver.other_sensor()) {
    return ": " + client::other_sensor(*receiver.other_sensor(), *meant);
  }
  if (receiver.subscription() == client::Subscription::State::kFull) {
    return std::string(": the sensor has as many subscribers as it takes (") + kPlacesText +
           "): end another one";
  }
  if (receiver.subscription() == client::Subscription::State::kNoKey) {
    return ": no key of yours is one of this sensor: pair, see stof pair --help";
  }
  if (const std::optional<std::uint8_t> tags = receiver.other_tags()) {
    return ": " + client::other_tags_text(*tags);
  }
  const client::Statistics& counted = receiver.statistics();
  if (counted.packets() != 0 && counted.not_signed + counted.forged == counted.packets()) {
    return ": none is signed for this program: somebody sends in the sensor's name, or the sensor "
           "does not sign; stof check tells";
  }
  const client::LinkState link = receiver.link();
  if (const std::string alone = health_alone_text(link, receiver.health()); !alone.empty()) {
    return alone;
  }
  const bool was_there = link.frame_age || link.health_age;
  if (receiver.take_refusal()) {
    return was_there ? ": nobody listens there any more: what sent there was stopped"
                     : ": nobody listens there: start stofd, or check its port";
  }
  return ": check that the sensor runs, its address and the network";
}

std::string absence_text(client::Receiver& receiver, const ReceiveOptions& options) {
  if (!options.sensor.empty()) {
    return silence_text(receiver, options.device);
  }
  const std::string alone = health_alone_text(receiver.link(), receiver.health());
  return alone.empty() ? ": start stofd with --to, or check the network" : alone;
}

std::string no_frame_text(client::Receiver& receiver, const ReceiveOptions& options) {
  const bool heard = receiver.statistics().packets() != 0;
  return (heard ? "packets came, but no frame" : "no packet came") +
         absence_text(receiver, options) +
         (heard ? "; " + summary_line(receiver.statistics()) : "");
}

std::string ended_text(client::Receiver& receiver, const ReceiveOptions& options,
                       wire::ClockState last) {
  if (last == wire::ClockState::kRecorded) {
    return ": a recording was played, which is over";
  }
  const client::LinkState link = receiver.link();
  if (receiver.subscription() == client::Subscription::State::kNoKey || receiver.other_tags()) {
    return silence_text(receiver, options.device);
  }
  const std::string alone = health_alone_text(link, receiver.health());
  return alone.empty() ? ", last health " + age_text(link.health_age) +
                             " ago: check that it runs, and the network"
                       : alone;
}

std::string first_frame_line(const ReceiveOptions& options, const client::Receiver& receiver,
                             std::uint32_t device) {
  if (options.signed_streams) {
    // A name was not read of the sensor itself.
    const std::string& place = receiver.place();
    remember_place(
        options.keys,
        {.named = is_sensor_name(options.sensor) ? place : options.sensor, .address = place},
        receiver.proven_key());
  }
  return "frames of sensor " + std::to_string(device) +
         (options.signed_streams ? ", signed for this program" : "");
}

void tell_port(const ReceiveOptions& options, const client::Receiver& receiver) {
  if (!options.port_file.empty()) {
    value_or_fail(dataset::write_whole(options.port_file, std::to_string(receiver.port()) + "\n"));
  }
}

void add_key_flags(CLI::App& command, ReceiveOptions& options, KeyUse use) {
  const bool page = use == KeyUse::kPage;
  CLI::Option* const is_signed =
      command.add_flag("--signed", options.signed_streams,
                       "Subscribe with your key of the sensor, and take only what it signs for "
                       "this program: nobody else can send a frame");
  CLI::Option* const keys = command.add_option(
      "--keys", options.keys,
      page ? "File of keys, of --signed and of what the page changes; none: the usual one, as of "
             "stof pair"
           : "File of keys, of --signed; none: the usual one, as of stof pair");
  add_device_flag(command, options.device);
  CLI::Option* const key = command.add_option(
      "--key", options.key,
      page ? "8 digits, of your key of the sensor, of --signed and of what the page changes: only "
             "it counts"
           : "8 digits, of your key of the sensor, of --signed: only it is believed");
  key->check(CLI::Validator(
      [](const std::string& text) {
        static_cast<void>(key_id_of(text));
        return std::string();
      },
      ""));
  if (!page) {  // without it they would do nothing
    keys->needs(is_signed);
    key->needs(is_signed);
  }
}

void add_place_flags(CLI::App& command, ReceiveOptions& options) {
  command.add_option("--port", options.port,
                     "Without a sensor: UDP port to listen at, 0: any free one (default: 7560)");
  command.add_option("--bind", options.bind,
                     "Likewise: address of the interface to listen at (default: every one)");
  command.add_option("--port-file", options.port_file,
                     "File that gets the number of the opened port");
}

void add_subscription_flags(CLI::App& command, ReceiveOptions& options, KeyUse use) {
  command
      .add_option(
          "--timeout", options.timeout_s,
          "Give up after so many seconds without a frame that was due (stof health: without "
          "a packet)")
      ->check(CLI::Range(0.01, 1e6))
      ->capture_default_str();
  add_key_flags(command, options, use);
}

void add_reading_flags(CLI::App& command, ReceiveOptions& options, bool& json) {
  command.add_option("SENSOR", options.sensor, kSensorOrFile)->required()->check(not_empty());
  add_json_flag(command, json);
  add_subscription_flags(command, options);
}

void add_receive_flags(CLI::App& command, ReceiveOptions& options, KeyUse use) {
  add_place_flags(command, options);
  add_subscription_flags(command, options, use);
}

void judge_reading_flags(const CLI::App& command, const std::string& sensor) {
  if (!is_recorded(sensor)) {
    return;
  }
  for (const char* const name : {"--seconds", "--signed", "--keys", "--key", "--device"}) {
    const CLI::Option* const flag = command.get_option_no_throw(name);
    if (flag != nullptr && flag->count() != 0) {
      throw Failure(Exit::kBadInput, std::string(name) + ": is for a sensor, " + sensor +
                                         " is a file: all of it is read");
    }
  }
}

void judge_receive_options(const ReceiveOptions& options) {
  if (options.signed_streams && options.sensor.empty()) {
    throw Failure(Exit::kBadInput, "--signed: takes a SENSOR to subscribe at");
  }
  if (!options.sensor.empty() && (options.bind || options.port)) {
    throw Failure(Exit::kBadInput,
                  std::string(options.bind ? "--bind" : "--port") +
                      ": is where a sensor that sends by itself is listened for: beside " +
                      options.sensor + " leave it out");
  }
}

}  // namespace stof::host
