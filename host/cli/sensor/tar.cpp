#include "host/cli/sensor/tar.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include "dsp/base/check.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

constexpr std::size_t kBlock = 512;

using Block = std::array<char, kBlock>;

void put(Block& block, std::size_t at, std::string_view text) {
  std::ranges::copy(text, block.begin() + static_cast<std::ptrdiff_t>(at));
}

// POSIX.1-2017, pax, "ustar Interchange Format": fields are octal digits, filled up with zeros.
Block header_of(std::string_view name, std::size_t size, std::int64_t modified_s) {
  constexpr std::size_t kChecksum = 148;
  Block block{};
  put(block, 0, name);
  put(block, 100, "0000644");
  put(block, 108, "0000000");
  put(block, 116, "0000000");
  put(block, 124, printed("%011llo", static_cast<unsigned long long>(size)));
  put(block, 136, printed("%011llo", static_cast<unsigned long long>(modified_s)));
  put(block, kChecksum, "        ");
  put(block, 156, "0");  // a regular file
  put(block, 257,
      std::string_view("ustar\0"
                       "00",
                       8));
  unsigned sum = 0;
  for (const char byte : block) {
    sum += static_cast<unsigned char>(byte);
  }
  put(block, kChecksum, std::string_view(printed("%06o", sum)));
  block[kChecksum + 6] = '\0';
  return block;
}

}  // namespace

void Tar::add(std::string_view name, std::string_view bytes) {
  constexpr std::size_t kMostName = 100;
  STOF_CHECK(name.size() <= kMostName);
  const Block header = header_of(name, bytes.size(), modified_s_);
  bytes_.append(header.data(), header.size());
  bytes_.append(bytes);
  bytes_.append((kBlock - bytes.size() % kBlock) % kBlock, '\0');
}

std::string Tar::take() {
  bytes_.append(2 * kBlock, '\0');
  return std::exchange(bytes_, {});
}

}  // namespace stof::host
