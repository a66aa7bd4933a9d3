#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include <sys/mman.h>
#include <unistd.h>

#include "host/recording/mcap/record_bytes.h"
#include "host/recording/raw_reader.h"
#include "host/recording/topics.h"
#include "posix/fd.h"
#include "tests/fuzz/fuzz_input.h"

// Raw recordings from anywhere, as `stofd --replay` reads them. The first byte of the input says
// how; kMessages: records of a topic, a sequence number and bytes are messages in a file with the
// channels of a recording and a calibration, so that what lies behind magic and index is reached.
namespace stof {
namespace {

constexpr unsigned kMessages = 1;
constexpr int kMostInputs = 200;  // of one file

mcap::Buffer file_of(std::span<const std::byte> records) {
  mcap::Buffer file;
  mcap::append_bytes(file, std::as_bytes(std::span(mcap::kMagic)));
  append(file, mcap::Header{.profile = std::string(recording::kProfile)});
  append(file, mcap::Schema{.id = 1, .name = "a"});
  for (std::size_t k = 0; k < recording::kTopics; ++k) {
    append(file, mcap::Channel{.id = static_cast<std::uint16_t>(k + 1),
                               .schema_id = 1,
                               .topic = std::string(recording::kTopicInfos[k].name),
                               .message_encoding = std::string(recording::kEncoding)});
  }
  constexpr std::array kFile{std::byte{1}};
  append(file, mcap::Attachment{.name = recording::kCalibrationAttachment, .data = kFile});
  std::uint64_t time = 1;
  fuzz::for_each_record(records, [&](const fuzz::Record& record) {
    const std::span<const std::byte> data = record.bytes;
    const auto sequence = data.empty() ? 0U : std::to_integer<unsigned>(data[0]);
    append(file, mcap::Message{.channel_id = static_cast<std::uint16_t>(1 + record.flags %
                                                                                recording::kTopics),
                               .sequence = sequence,
                               .log_time = time,
                               .publish_time = time,
                               .data = data.empty() ? data : data.subspan(1)});
    ++time;
  });
  mcap::append_data_end(file, 0);
  append(file, mcap::Footer{});
  mcap::append_bytes(file, std::as_bytes(std::span(mcap::kMagic)));
  return file;
}

void judge(const recording::RawInput& input) {
  const wire::RawInfo& info = input.info;
  const std::size_t eye = std::size_t{info.width} * info.height;
  const std::size_t samples = std::size_t{info.pmd_width} * info.pmd_height;
  fuzz::require(input.left.empty() || input.left.size() == eye);
  fuzz::require(input.right.empty() || input.right.size() == eye);
  for (const auto& one : input.pmd) {
    fuzz::require(one.empty() || one.size() == samples);
  }
  fuzz::require((input.missing & ~info.pictures) == 0);
  fuzz::require(!input.frame || input.frame->stamp.freshness == input.stamp.freshness);
}

void read(const std::filesystem::path& file) {
  auto reader = recording::RawReader::open(file);
  if (!reader) {
    fuzz::require(!reader.error().message.empty());
    fuzz::require(reader.error().message.find('\n') == std::string::npos);
    return;
  }
  fuzz::require(reader->summary().exposures > 0);
  std::uint64_t count = 0;
  for (int k = 0; k < kMostInputs; ++k) {
    const std::unique_ptr<recording::RawInput> input = reader->next();
    if (!input) {
      fuzz::require(count == reader->summary().exposures);
      return;
    }
    ++count;
    judge(*input);
  }
}

}  // namespace
}  // namespace stof

void stof::fuzz::run(std::span<const std::byte> input) {
  if (input.empty()) {
    return;
  }
  const bool messages = (std::to_integer<unsigned>(input[0]) & kMessages) != 0;
  const auto rest = input.subspan(1);
  const mcap::Buffer bytes = messages ? file_of(rest) : mcap::Buffer(rest.begin(), rest.end());
  const posix::Fd file(::memfd_create("raw_recording", MFD_CLOEXEC));
  require(file.is_open());
  require(::write(file.get(), bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size()));
  read("/proc/self/fd/" + std::to_string(file.get()));
}
