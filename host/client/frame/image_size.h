#pragma once

namespace stof::client {

struct ImageSize {
  int width = 0;
  int height = 0;

  friend bool operator==(const ImageSize&, const ImageSize&) = default;
};

}  // namespace stof::client
