#include "host/evaluate/ifm/pcic.h"

namespace stof::host {
namespace {

constexpr std::size_t kLeastHeader = 48;
constexpr int kMaxSide = 4096;

std::uint32_t u32_at(std::string_view bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    value |= std::uint32_t{static_cast<std::uint8_t>(bytes[at + i])} << (8 * i);
  }
  return value;
}

}  // namespace

dataset::Loaded<std::vector<PcicChunk>> pcic_chunks(std::string_view buffer,
                                                    const std::filesystem::path& file) {
  const auto refuse = [&file](const char* what) {
    return std::unexpected(
        dataset::Problem{file.string() + ": " + what + ": give the camera's untouched buffer"});
  };
  constexpr std::string_view kStart = "star";
  constexpr std::string_view kStop = "stop";
  const std::size_t start = buffer.find(kStart);
  if (start == std::string_view::npos) {
    return refuse("has no \"star\", where chunks begin");
  }
  std::vector<PcicChunk> chunks;
  std::size_t at = start + kStart.size();
  while (at < buffer.size() && !buffer.substr(at).starts_with(kStop)) {
    if (buffer.size() - at < kLeastHeader) {
      return refuse("ends inside the header of a chunk");
    }
    const auto field = [&buffer, at](std::size_t n) { return u32_at(buffer, at + 4 * n); };
    const PcicChunk chunk{.type = field(0),
                          .size = field(1),
                          .header_size = field(2),
                          .version = field(3),
                          .width = static_cast<int>(field(4)),
                          .height = static_cast<int>(field(5)),
                          .format = field(6),
                          .at = at};
    if (chunk.header_size < kLeastHeader || chunk.size < chunk.header_size ||
        chunk.size > buffer.size() - at || chunk.width < 0 || chunk.width > kMaxSide ||
        chunk.height < 0 || chunk.height > kMaxSide) {
      return refuse("has a chunk whose sizes contradict each other");
    }
    chunks.push_back(chunk);
    at += chunk.size;
  }
  if (chunks.empty()) {
    return refuse("has no chunk");
  }
  return chunks;
}

}  // namespace stof::host
