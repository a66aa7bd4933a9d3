#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include <fastcdr/Cdr.h>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/domain/DomainParticipantListener.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>

// fast_dds_reader DOMAIN NAMESPACE SECONDS NAME=COUNT... [--best-effort] [--payloads FILE]
// [--arrivals FILE]: reads the topics of a bridge with Fast DDS, another implementation of DDS, and
// decodes them with Fast CDR; nothing of the project is in it. Ends when COUNT messages of each
// topic NAME (depth/image_raw, ...) have come, or after SECONDS. Prints "ready" when all writers
// have matched, be they gone since, and a JSON object at the end. FILE of payloads: for each
// message a line "TYPE LENGTH", then its bytes; of arrivals: a line "NAME STAMP_NS ARRIVED_NS",
// system time.
namespace {

namespace dds = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;
using eprosima::fastcdr::Cdr;
using eprosima::fastcdr::FastBuffer;

using Bytes = std::vector<char>;

// A type of which the name is known, and the bytes are kept.
class RawType : public dds::TopicDataType {
 public:
  explicit RawType(const std::string& name) {
    setName(name.c_str());
    m_typeSize = 4 << 20;
    m_isGetKeyDefined = false;
  }
  bool serialize(void* /*data*/, rtps::SerializedPayload_t* /*payload*/) override { return false; }
  bool deserialize(rtps::SerializedPayload_t* payload, void* data) override {
    const char* const bytes = reinterpret_cast<const char*>(payload->data);
    *static_cast<Bytes*>(data) = Bytes(bytes, bytes + payload->length);
    return true;
  }
  std::function<std::uint32_t()> getSerializedSizeProvider(void* /*data*/) override {
    return [] { return 0U; };
  }
  void* createData() override { return new Bytes; }
  void deleteData(void* data) override { delete static_cast<Bytes*>(data); }
  bool getKey(void* /*data*/, rtps::InstanceHandle_t* /*handle*/, bool /*md5*/) override {
    return false;
  }
};

std::int64_t system_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

void demand(bool good, const char* what) {
  if (!good) {
    throw std::runtime_error(what);
  }
}

template <typename T>
T take(Cdr& from) {
  T value{};
  from >> value;
  return value;
}

struct Header {
  std::int64_t stamp_ns;
  std::string frame;
};
Header take_header(Cdr& from) {
  const auto seconds = take<std::int32_t>(from);
  const auto nanoseconds = take<std::uint32_t>(from);
  demand(nanoseconds < 1'000'000'000, "nanosec");
  return {.stamp_ns = seconds * std::int64_t{1'000'000'000} + nanoseconds,
          .frame = take<std::string>(from)};
}

// What of a message is compared with others of its frame.
struct Decoded {
  std::optional<std::int64_t> stamp_ns;
  std::string text;  // what the summary tells of the newest
};

Decoded image(Cdr& from) {
  const Header header = take_header(from);
  const auto height = take<std::uint32_t>(from);
  const auto width = take<std::uint32_t>(from);
  const auto encoding = take<std::string>(from);
  demand(take<std::uint8_t>(from) == 0, "is_bigendian");
  const auto step = take<std::uint32_t>(from);
  const auto data = take<std::vector<std::uint8_t>>(from);
  demand(encoding == "16UC1" && step == 2 * width && data.size() == std::size_t{step} * height,
         "an image of another size than it says");
  std::size_t valid = 0;
  for (std::size_t at = 0; at < data.size(); at += 2) {
    valid += data[at] != 0 || data[at + 1] != 0 ? 1U : 0U;
  }
  return {header.stamp_ns, header.frame + " " + std::to_string(width) + "x" +
                               std::to_string(height) + " " + encoding + " " +
                               std::to_string(valid)};
}

Decoded camera_info(Cdr& from) {
  const Header header = take_header(from);
  const auto height = take<std::uint32_t>(from);
  const auto width = take<std::uint32_t>(from);
  const auto model = take<std::string>(from);
  const auto d = take<std::vector<double>>(from);
  const auto k = take<std::array<double, 9>>(from);
  const auto r = take<std::array<double, 9>>(from);
  const auto p = take<std::array<double, 12>>(from);
  for (int i = 0; i < 6; ++i) {
    demand(take<std::uint32_t>(from) == 0, "binning or region");
  }
  demand(!take<bool>(from), "do_rectify");
  demand(model == "plumb_bob" && d.size() == 5 && k[0] > 0 && k[8] == 1 && r[0] == 1 &&
             p[0] == k[0] && p[2] == k[2] && p[6] == k[5],
         "a camera matrix of no camera");
  return {header.stamp_ns,
          header.frame + " " + std::to_string(width) + "x" + std::to_string(height)};
}

Decoded point_cloud(Cdr& from) {
  const Header header = take_header(from);
  const auto height = take<std::uint32_t>(from);
  const auto width = take<std::uint32_t>(from);
  std::string names;
  const auto fields = take<std::uint32_t>(from);
  for (std::uint32_t i = 0; i < fields; ++i) {
    names += (i == 0 ? "" : ",") + take<std::string>(from);
    demand(take<std::uint32_t>(from) == 4 * i, "offset of a field");
    demand(take<std::uint8_t>(from) == 7, "type of a field");
    demand(take<std::uint32_t>(from) == 1, "count of a field");
  }
  demand(!take<bool>(from), "is_bigendian");
  const auto point_step = take<std::uint32_t>(from);
  const auto row_step = take<std::uint32_t>(from);
  const auto data = take<std::vector<std::uint8_t>>(from);
  demand(take<bool>(from), "is_dense");
  demand(height == 1 && point_step == 4 * fields && row_step == point_step * width &&
             data.size() == row_step,
         "a cloud of another size than it says");
  for (std::size_t at = 0; at < data.size(); at += point_step) {
    std::array<float, 3> place{};
    std::memcpy(place.data(), data.data() + at, sizeof place);
    demand(place[2] > 0, "a point that is not ahead");
  }
  return {header.stamp_ns, header.frame + " " + names + " " + std::to_string(width)};
}

Decoded diagnostics(Cdr& from) {
  const Header header = take_header(from);
  std::string text;
  const auto statuses = take<std::uint32_t>(from);
  for (std::uint32_t i = 0; i < statuses; ++i) {
    const auto level = take<std::uint8_t>(from);
    demand(level <= 3, "level");
    const auto name = take<std::string>(from);
    text += name + "=" + std::to_string(level) + " " + take<std::string>(from) + "; ";
    take<std::string>(from);
    const auto values = take<std::uint32_t>(from);
    for (std::uint32_t k = 0; k < values; ++k) {
      const auto key = take<std::string>(from);
      const auto value = take<std::string>(from);
      if (key == "stamp_bound_us" || key == "sensor_clock") {
        text += key + " " + value + "; ";
      }
    }
  }
  return {header.stamp_ns, text};
}

Decoded transforms(Cdr& from) {
  std::string text;
  const auto count = take<std::uint32_t>(from);
  for (std::uint32_t i = 0; i < count; ++i) {
    const Header header = take_header(from);
    text += header.frame + ">" + take<std::string>(from);
    double turn = 0;
    for (int k = 0; k < 7; ++k) {
      const auto value = take<double>(from);
      turn += k >= 3 ? value * value : 0;
      std::array<char, 32> number{};
      std::snprintf(number.data(), number.size(), " %.3f", value);
      text += number.data();
    }
    demand(turn > 0.999 && turn < 1.001, "a rotation that is none");
    text += "; ";
  }
  return {std::nullopt, text};
}

struct Kind {
  const char* name;
  const char* type;
  bool in_namespace;
  bool latched;
  Decoded (*decode)(Cdr&);
};
constexpr std::array<Kind, 5> kKinds{{
    {"depth/image_raw", "sensor_msgs::msg::dds_::Image_", true, false, image},
    {"depth/camera_info", "sensor_msgs::msg::dds_::CameraInfo_", true, false, camera_info},
    {"depth/points", "sensor_msgs::msg::dds_::PointCloud2_", true, false, point_cloud},
    {"diagnostics", "diagnostic_msgs::msg::dds_::DiagnosticArray_", false, false, diagnostics},
    {"tf_static", "tf2_msgs::msg::dds_::TFMessage_", false, true, transforms},
}};

struct Writer {  // as discovery tells it
  std::string type;
  std::string user_data;
  bool reliable = false;
  bool transient_local = false;
};

std::mutex g_mutex;                       // NOLINT: of a test's program, as what follows
std::map<std::string, Writer> g_writers;  // NOLINT
std::ofstream g_payloads;                 // NOLINT
std::ofstream g_arrivals;                 // NOLINT

class Discovery : public dds::DomainParticipantListener {
 public:
  void on_publisher_discovery(dds::DomainParticipant* /*participant*/,
                              rtps::WriterDiscoveryInfo&& info) override {
    const std::scoped_lock lock(g_mutex);
    const std::vector<rtps::octet>& data = info.info.m_qos.m_userData.data_vec();
    g_writers[info.info.topicName().to_string()] = {
        .type = info.info.typeName().to_string(),
        .user_data = std::string(data.begin(), data.end()),
        .reliable = info.info.m_qos.m_reliability.kind == dds::RELIABLE_RELIABILITY_QOS,
        .transient_local =
            info.info.m_qos.m_durability.kind == dds::TRANSIENT_LOCAL_DURABILITY_QOS};
  }
};

class Topic : public dds::DataReaderListener {
 public:
  explicit Topic(const Kind& kind) : kind_(kind) {}

  void on_data_available(dds::DataReader* reader) override {
    Bytes bytes;
    dds::SampleInfo info;
    while (reader->take_next_sample(&bytes, &info) == ReturnCode_t::RETCODE_OK) {
      if (info.valid_data) {
        note(bytes, system_ns());
      }
    }
  }
  void on_subscription_matched(dds::DataReader* /*reader*/,
                               const dds::SubscriptionMatchedStatus& status) override {
    matched = status.total_count;
  }
  void on_sample_lost(dds::DataReader* /*reader*/, const dds::SampleLostStatus& status) override {
    lost = status.total_count;
  }
  void on_requested_incompatible_qos(dds::DataReader* /*reader*/,
                                     const dds::RequestedIncompatibleQosStatus& /*s*/) override {
    incompatible = true;
  }

  void note(Bytes& bytes, std::int64_t arrived_ns) {
    const std::scoped_lock lock(g_mutex);
    try {
      demand(bytes.size() > 4 && bytes[0] == 0 && bytes[1] == 1, "not CDR of version 1");
      FastBuffer buffer(bytes.data(), bytes.size());
      Cdr from(buffer, Cdr::DEFAULT_ENDIAN, Cdr::DDS_CDR);
      from.read_encapsulation();
      const Decoded decoded = kind_.decode(from);
      // What is sent is a multiple of four bytes.
      demand(bytes.size() - from.getSerializedDataLength() < 4, "bytes behind the message");
      demand(!stamp_ns || !decoded.stamp_ns || *decoded.stamp_ns > *stamp_ns,
             "a stamp that is not later than the one before");
      stamp_ns = decoded.stamp_ns;
      newest = decoded.text;
      if (decoded.stamp_ns) {
        g_arrivals << kind_.name << ' ' << *decoded.stamp_ns << ' ' << arrived_ns << '\n';
      }
    } catch (const std::exception& problem) {
      error = problem.what();
      ++errors;
    }
    if (g_payloads.is_open()) {
      g_payloads << kind_.type << ' ' << bytes.size() << '\n';
      g_payloads.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    }
    ++count;
  }

  std::string dds_name(const std::string& name_space) const {
    return std::string("rt/") + (kind_.in_namespace ? name_space + "/" : "") + kind_.name;
  }
  const Kind& kind() const { return kind_; }

  std::atomic<int> matched{0};
  std::atomic<int> lost{0};
  std::atomic<bool> incompatible{false};
  std::atomic<int> count{0};
  int wanted = 0;
  int errors = 0;  // these with the lock
  std::string error;
  std::string newest;
  std::optional<std::int64_t> stamp_ns;

 private:
  const Kind& kind_;
};

dds::DomainParticipantQos participant_qos() {
  dds::DomainParticipantQos qos;
  auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
  udp->interfaceWhiteList.emplace_back("127.0.0.1");
  udp->receiveBufferSize = 4 << 20;
  qos.transport().use_builtin_transports = false;
  qos.transport().user_transports.push_back(udp);
  rtps::Locator_t peer;
  rtps::IPLocator::setIPv4(peer, "127.0.0.1");
  qos.wire_protocol().builtin.initialPeersList.push_back(peer);
  qos.wire_protocol().builtin.discovery_config.leaseDuration_announcementperiod = {0, 200'000'000};
  return qos;
}

std::string json_text(const std::string& text) {
  std::string json = "\"";
  for (const char c : text) {
    json += c == '"' || c == '\\' ? std::string("\\") + c : std::string(1, c);
  }
  return json + "\"";
}

void print(std::vector<std::unique_ptr<Topic>>& topics, const std::string& name_space) {
  const std::scoped_lock lock(g_mutex);
  std::printf("{");
  for (const auto& topic : topics) {
    const Writer& writer = g_writers[topic->dds_name(name_space)];
    std::printf(
        "%s%s: {\"count\": %d, \"errors\": %d, \"error\": %s, \"lost\": %d, \"newest\": %s, "
        "\"type\": %s, \"user_data\": %s, \"reliable\": %s, \"transient_local\": %s, "
        "\"incompatible\": %s}",
        topic == topics.front() ? "" : ", ", json_text(topic->kind().name).c_str(),
        topic->count.load(), topic->errors, json_text(topic->error).c_str(), topic->lost.load(),
        json_text(topic->newest).c_str(), json_text(writer.type).c_str(),
        json_text(writer.user_data).c_str(), writer.reliable ? "true" : "false",
        writer.transient_local ? "true" : "false", topic->incompatible ? "true" : "false");
  }
  std::printf("}\n");
}

struct Arguments {
  std::string name_space;
  std::uint32_t domain = 0;
  double seconds = 0;
  bool best_effort = false;
  std::map<std::string, int> wanted{};
};

Arguments arguments_of(int argc, char** argv) {
  Arguments arguments{.name_space = argv[2],
                      .domain = static_cast<std::uint32_t>(std::atoi(argv[1])),
                      .seconds = std::atof(argv[3])};
  for (int i = 4; i < argc; ++i) {
    const std::string word = argv[i];
    const std::size_t equals = word.find('=');
    if (word == "--best-effort") {
      arguments.best_effort = true;
    } else if (word == "--payloads") {
      g_payloads.open(argv[++i], std::ios::binary);
    } else if (word == "--arrivals") {
      g_arrivals.open(argv[++i]);
    } else if (equals != std::string::npos) {
      arguments.wanted[word.substr(0, equals)] = std::atoi(word.c_str() + equals + 1);
    }
  }
  return arguments;
}

bool read_all(const Arguments& arguments, std::vector<std::unique_ptr<Topic>>& topics) {
  const auto until =
      std::chrono::steady_clock::now() + std::chrono::duration<double>(arguments.seconds);
  bool ready = false;
  while (std::chrono::steady_clock::now() < until) {
    if (!ready && std::ranges::all_of(topics, [](const auto& t) { return t->matched > 0; })) {
      ready = true;
      std::printf("ready\n");
      std::fflush(stdout);
    }
    if (ready && std::ranges::all_of(topics, [](const auto& t) { return t->count >= t->wanted; })) {
      return true;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

int run(const Arguments& arguments) {
  Discovery discovery;
  auto* const factory = dds::DomainParticipantFactory::get_instance();
  auto* const participant = factory->create_participant(arguments.domain, participant_qos(),
                                                        &discovery, dds::StatusMask::none());
  demand(participant != nullptr, "no participant");
  auto* const subscriber = participant->create_subscriber(dds::SUBSCRIBER_QOS_DEFAULT);
  std::vector<std::unique_ptr<Topic>> topics;
  for (const Kind& kind : kKinds) {
    if (!arguments.wanted.contains(kind.name)) {
      continue;
    }
    auto topic = std::make_unique<Topic>(kind);
    topic->wanted = arguments.wanted.at(kind.name);
    dds::TypeSupport(new RawType(kind.type)).register_type(participant);
    auto* const there = participant->create_topic(topic->dds_name(arguments.name_space), kind.type,
                                                  dds::TOPIC_QOS_DEFAULT);
    dds::DataReaderQos qos;
    qos.reliability().kind =
        arguments.best_effort ? dds::BEST_EFFORT_RELIABILITY_QOS : dds::RELIABLE_RELIABILITY_QOS;
    qos.durability().kind =
        kind.latched ? dds::TRANSIENT_LOCAL_DURABILITY_QOS : dds::VOLATILE_DURABILITY_QOS;
    qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
    qos.history().depth = 10;
    qos.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    demand(there != nullptr && subscriber->create_datareader(there, qos, topic.get()) != nullptr,
           "no reader");
    topics.push_back(std::move(topic));
  }
  const bool all = read_all(arguments, topics);
  print(topics, arguments.name_space);
  participant->delete_contained_entities();
  factory->delete_participant(participant);
  return all ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 5) {
    std::fprintf(stderr, "fast_dds_reader DOMAIN NAMESPACE SECONDS NAME=COUNT...\n");
    return 2;
  }
  try {
    return run(arguments_of(argc, argv));
  } catch (const std::exception& problem) {
    std::fprintf(stderr, "fast_dds_reader: %s\n", problem.what());
    return 2;
  }
}
