#include "host/bridge/dds/publisher.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <utility>

#include <dds/dds.h>

#include "host/bridge/dds/cdr_type.h"
#include "host/bridge/line_limit.h"
#include "host/bridge/type_hash.h"

namespace stof::bridge {
namespace {

// The high-water mark is above all that KEEP_LAST keeps, so that no reader makes a writer wait. A
// user's own settings come behind and win.
std::string configuration(unsigned fragment, unsigned datagram) {
  constexpr unsigned kHeaders = 56;  // of a fragment in its datagram
  const unsigned least = fragment + kHeaders;
  const std::string ours = "<General><MaxMessageSize>" + std::to_string(std::max(datagram, least)) +
                           "B</MaxMessageSize><MaxRexmitMessageSize>" + std::to_string(least) +
                           "B</MaxRexmitMessageSize><FragmentSize>" + std::to_string(fragment) +
                           "B</FragmentSize></General><Internal><Watermarks><WhcHigh>64MB"
                           "</WhcHigh></Watermarks></Internal>";
  const char* const users = std::getenv("CYCLONEDDS_URI");  // NOLINT: before there are threads
  return users == nullptr || *users == '\0' ? ours : ours + "," + users;
}

std::string trouble(const std::string& what, dds_return_t code) {
  return what + ": " + dds_strretcode(-code);
}

// A line for each bad datagram, of any thread.
void say(void* limit, const dds_log_data_t* data) {
  const auto text =
      static_cast<LineLimit*>(limit)->pass({data->message, data->size}, LineLimit::Clock::now());
  if (text) {
    std::fputs(("stof: Cyclone DDS: " + *text + "\n").c_str(), stderr);
  }
}

using Qos = std::unique_ptr<dds_qos_t, decltype(&dds_delete_qos)>;

Qos qos_of(const TopicInfo& topic) {
  Qos qos(dds_create_qos(), dds_delete_qos);
  constexpr dds_duration_t kMostWait = DDS_MSECS(1);
  dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, kMostWait);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, topic.depth);
  if (topic.latched) {
    dds_qset_durability(qos.get(), DDS_DURABILITY_TRANSIENT_LOCAL);
    dds_qset_durability_service(qos.get(), 0, DDS_HISTORY_KEEP_LAST, topic.depth,
                                DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED);
  }
  constexpr dds_data_representation_id_t kXcdr1 = DDS_DATA_REPRESENTATION_XCDR1;
  dds_qset_data_representation(qos.get(), 1, &kXcdr1);
  return qos;
}

}  // namespace

struct Publisher::Parts {
  struct Writer {
    dds_entity_t entity = 0;
    ddsi_sertype* type = nullptr;  // lives as long as the writer
  };

  Parts() { dds_set_log_sink(say, &lines); }
  ~Parts() {
    if (domain > 0) {
      dds_delete(domain);  // and all that is in it
    }
    dds_set_log_sink(nullptr, nullptr);
  }

  std::expected<void, std::string> add(Topic topic, const std::string& name_space) {
    const TopicInfo& info = info_of(topic);
    const mcap::Schema schema = info.schema();
    const std::string name = dds_topic_name(topic, name_space);
    const Qos qos = qos_of(info);
    Writer& writer = writers[static_cast<std::size_t>(topic)];
    writer.type = new_cdr_type(dds_type_name(schema.name));
    const dds_entity_t there = dds_create_topic_sertype(participant, name.c_str(), &writer.type,
                                                        qos.get(), nullptr, nullptr);
    if (there < 0) {
      return std::unexpected(trouble("topic " + name, there));
    }
    const std::string hash = "typehash=" + type_hash(schema) + ";";
    dds_qset_userdata(qos.get(), hash.data(), hash.size());
    writer.entity = dds_create_writer(participant, there, qos.get(), nullptr);
    return writer.entity < 0 ? std::expected<void, std::string>(
                                   std::unexpected(trouble("writer of " + name, writer.entity)))
                             : std::expected<void, std::string>();
  }

  LineLimit lines;
  dds_entity_t domain = 0;
  dds_entity_t participant = 0;
  std::array<Writer, kTopics> writers{};
};

std::expected<Publisher, std::string> Publisher::open(const PublisherOptions& options) {
  auto parts = std::make_unique<Parts>();
  parts->domain =
      dds_create_domain(options.domain, configuration(options.fragment, options.datagram).c_str());
  if (parts->domain < 0) {
    return std::unexpected(trouble(
        "DDS domain " + std::to_string(options.domain) + ": check the network and CYCLONEDDS_URI",
        parts->domain));
  }
  parts->participant = dds_create_participant(options.domain, nullptr, nullptr);
  if (parts->participant < 0) {
    return std::unexpected(
        trouble("DDS domain " + std::to_string(options.domain), parts->participant));
  }
  for (std::size_t k = 0; k < kTopics; ++k) {
    if (const auto added = parts->add(static_cast<Topic>(k), options.name_space); !added) {
      return std::unexpected(added.error());
    }
  }
  return Publisher(std::move(parts));
}

Publisher::Publisher(std::unique_ptr<Parts> parts) noexcept : parts_(std::move(parts)) {}
Publisher::Publisher(Publisher&&) noexcept = default;
Publisher& Publisher::operator=(Publisher&&) noexcept = default;
Publisher::~Publisher() = default;

bool Publisher::publish(Topic topic, recording::Buffer&& message) {
  const Parts::Writer& writer = parts_->writers[static_cast<std::size_t>(topic)];
  return dds_writecdr(writer.entity, new_cdr_message(writer.type, std::move(message))) ==
         DDS_RETCODE_OK;
}

bool Publisher::wanted(Topic topic) {
  dds_publication_matched_status_t status{};
  const Parts::Writer& writer = parts_->writers[static_cast<std::size_t>(topic)];
  return dds_get_publication_matched_status(writer.entity, &status) == DDS_RETCODE_OK &&
         status.current_count > 0;
}

bool Publisher::drain(std::chrono::milliseconds longest) {
  const dds_time_t until = dds_time() + DDS_MSECS(longest.count());
  return std::ranges::all_of(parts_->writers, [&](const Parts::Writer& writer) {
    const dds_duration_t left = std::max<dds_duration_t>(until - dds_time(), 0);
    return dds_wait_for_acks(writer.entity, left) == DDS_RETCODE_OK;
  });
}

}  // namespace stof::bridge
