#include "firmware/wire/frame/tiles.h"

#include <limits>
#include <optional>

#include "firmware/wire/bytes.h"
#include "firmware/wire/codec/rvl_encode.h"

namespace stof::wire {
namespace {

template <typename T>
constexpr Codec kRaw = sizeof(T) == 1 ? Codec::kRaw8 : Codec::kRaw16;
template <typename T>
constexpr Codec kRvl = sizeof(T) == 1 ? Codec::kRvl8 : Codec::kRvl16;

// A tile that was coded but may still end in one of two places.
struct OpenTile {
  std::size_t first = 0;
  bool raw = false;
  RvlFit rvl{};
  std::size_t rows = 0;  // pixels up to the end of its last whole row; 0: holds none
  std::size_t all = 0;   // all that fit
  bool more = false;     // there may be more: the rows that do not fit were not tried

  std::size_t chosen() const noexcept { return rows > 0 ? rows : all; }
};

template <typename T>
class RvlTiles {
 public:
  RvlTiles(std::span<const T> values, const Raster& raster, PartStore& store) noexcept
      : values_(values), raster_(raster), store_(store) {}

  // false: more than `most` tiles.
  bool add(std::size_t most) noexcept {
    const std::size_t begin = store_.size();
    std::optional<OpenTile> open;  // the last tile of the store
    std::size_t at = 0;
    while (at < values_.size()) {
      const OpenTile tile = code(at, promising(at), store_.space());
      if (open && tile.rows == 0) {
        // The row does not fit alone: it begins where there is space for it.
        at = fill(*open);
        open.reset();
        continue;
      }
      if (open) {
        close(*open, open->rows);
        open.reset();
      }
      if (store_.size() - begin == most) {
        return false;
      }
      store_.add({});
      at = tile.first + tile.chosen();
      if (tile.more || tile.chosen() < tile.all) {
        open = tile;
      } else {
        close(tile, tile.all);
      }
    }
    if (open) {
      close(*open, open->rows);
    }
    return true;
  }

 private:
  static constexpr std::uint32_t kMostNibbles = 2 * kMaxTilePayload;

  std::span<const T> rest(std::size_t first) const noexcept { return values_.subspan(first); }
  std::size_t row_left(std::size_t first) const noexcept {
    return raster_.width - first % raster_.width;
  }

  // Pixels from `first` to the end of a row, behind which no further row fits a packet.
  std::size_t promising(std::size_t first) noexcept {
    const std::size_t most = std::min(values_.size() - first, kMostRvlValues);
    std::size_t end = row_left(first);
    std::uint32_t nibbles =
        end == raster_.width ? least_nibbles(first) : rvl_least_nibbles(rest(first).first(end));
    while (end < most) {
      nibbles += least_nibbles(first + end);
      if (nibbles > kMostNibbles) {
        break;
      }
      end += raster_.width;
    }
    return end;
  }

  // Of the row that begins at `first`. The row that did not fit is the next that is asked for.
  std::uint32_t least_nibbles(std::size_t first) noexcept {
    if (known_row_ != first) {
      known_row_ = first;
      known_nibbles_ = rvl_least_nibbles(rest(first).first(raster_.width));
    }
    return known_nibbles_;
  }

  // Offers `pixels` to a packet.
  OpenTile code(std::size_t first, std::size_t pixels, std::span<std::byte> out) noexcept {
    const std::size_t column = first % raster_.width;
    const std::size_t left = rest(first).size();
    const RvlFit rvl = fit(rest(first).first(pixels), row_left(first), out);
    const RawFit raw = raw_fit(column, raster_.width, left, sizeof(T));
    const RvlCut& best = rvl.rows.values > 0 ? rvl.rows : rvl.all;
    const bool raw_is_shorter = rvl_bytes(best) > best.values * sizeof(T);
    const bool only_raw_holds_a_row = rvl.rows.values == 0 && raw.rows > 0;
    if (raw_is_shorter || only_raw_holds_a_row) {
      return {.first = first, .raw = true, .rows = raw.rows, .all = raw.all};
    }
    return {.first = first,
            .rvl = rvl,
            .rows = rvl.rows.values,
            .all = rvl.all.values,
            .more = rvl.all.values == pixels && pixels < left};
  }

  RvlFit fit(std::span<const T> values, std::size_t row_left, std::span<std::byte> out) noexcept {
    const RvlFit fit = rvl_fit(values, row_left, raster_.width, out);
    const bool nearly = fit.rows.values == 0 && fit.all.values + kRvlNumberNibbles > row_left;
    // The row alone may fit where the length of a run that goes on behind it took the last nibbles.
    return nearly ? rvl_fit(values.first(row_left), row_left, raster_.width, out) : fit;
  }

  // Closes the last part of the store with all that fits; returns where that ends.
  std::size_t fill(const OpenTile& tile) noexcept {
    if (!tile.more) {
      close(tile, tile.all);
      return tile.first + tile.all;
    }
    const std::span<std::byte> out = store_.payload(store_.size() - 1);
    const std::span<std::byte> payload = out.first(kMaxTilePayload);
    const OpenTile filled = code(tile.first, rest(tile.first).size(), payload);
    if (filled.all > tile.rows) {
      close(filled, filled.all);
      return filled.first + filled.all;
    }
    // The longer length of its last run took the last nibbles.
    close(code(tile.first, tile.rows, payload), tile.rows);
    return tile.first + tile.rows;
  }

  // The last part of the store becomes `pixels` of this tile: tile.rows or tile.all.
  void close(const OpenTile& tile, std::size_t pixels) noexcept {
    const std::size_t index = store_.size() - 1;
    const std::span<std::byte> payload = store_.payload(index).template first<kMaxTilePayload>();
    const RvlCut& cut = pixels == tile.all ? tile.rvl.all : tile.rvl.rows;
    const std::size_t raw_bytes = pixels * sizeof(T);
    if (tile.raw || rvl_bytes(cut) > raw_bytes) {
      put_pixels<T>(payload.first(raw_bytes), values_.subspan(tile.first, pixels));
      store_.part(index) = raster_.part(kRaw<T>, tile.first, pixels, raw_bytes);
      return;
    }
    store_.part(index) = raster_.part(kRvl<T>, tile.first, pixels, rvl_finish(cut, payload));
  }

  std::span<const T> values_;
  Raster raster_;
  PartStore& store_;
  std::size_t known_row_ = std::numeric_limits<std::size_t>::max();  // its first pixel; none yet
  std::uint32_t known_nibbles_ = 0;
};

}  // namespace

Part Raster::part(Codec codec, std::size_t first, std::size_t pixels,
                  std::size_t payload_bytes) const noexcept {
  return {.stream = stream,
          .codec = codec,
          .flags = static_cast<std::uint8_t>(scale | (xor_delta ? kXorDeltaFlag : 0)),
          .image_width = static_cast<std::uint16_t>(width),
          .image_height = static_cast<std::uint16_t>(image_height == 0 ? height : image_height),
          .first_row = static_cast<std::uint16_t>(first_row + first / width),
          .first_column = static_cast<std::uint16_t>(first % width),
          .pixel_count = static_cast<std::uint16_t>(pixels),
          .payload_bytes = static_cast<std::uint16_t>(payload_bytes)};
}

template <typename T>
void add_raw_tiles(std::span<const T> values, const Raster& raster, PartStore& store) noexcept {
  STOF_CHECK(values.size() == raster.width * raster.height);
  for (std::size_t first = 0; first < values.size();) {
    const std::size_t pixels = raw_pixels(raster, first, sizeof(T));
    const std::size_t bytes = pixels * sizeof(T);
    put_pixels<T>(store.space().first(bytes), values.subspan(first, pixels));
    store.add(raster.part(kRaw<T>, first, pixels, bytes));
    first += pixels;
  }
}

template <typename T>
bool try_rvl_tiles(std::span<const T> values, const Raster& raster, std::size_t most,
                   PartStore& store) noexcept {
  STOF_CHECK(values.size() == raster.width * raster.height);
  const std::size_t begin = store.size();
  const bool added = RvlTiles<T>(values, raster, store).add(most);
  if (!added) {
    store.cut_back(begin);
  }
  return added;
}

template <typename T>
bool add_rvl_tiles(std::span<const T> values, const Raster& raster, PartStore& store) noexcept {
  if (try_rvl_tiles(values, raster, raw_tiles(raster.width, raster.height, sizeof(T)), store)) {
    return true;
  }
  add_raw_tiles(values, raster, store);
  return false;
}

template void add_raw_tiles(std::span<const std::uint8_t>, const Raster&, PartStore&) noexcept;
template void add_raw_tiles(std::span<const std::uint16_t>, const Raster&, PartStore&) noexcept;
template bool try_rvl_tiles(std::span<const std::uint16_t>, const Raster&, std::size_t,
                            PartStore&) noexcept;
template bool add_rvl_tiles(std::span<const std::uint8_t>, const Raster&, PartStore&) noexcept;
template bool add_rvl_tiles(std::span<const std::uint16_t>, const Raster&, PartStore&) noexcept;

}  // namespace stof::wire
