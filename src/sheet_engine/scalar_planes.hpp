#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "base/process.hpp"
#include "raster/slice_buffer.hpp"
#include "screen/regions.hpp"
#include "sheet_engine/sheet_payload.hpp"
#include "sheet_engine/slice_blocks.hpp"
#include "sheet_engine/table_axis.hpp"
#include "volume/cell_ranges.hpp"

namespace ringsplat {

/// The slices of a Renderer's frame that are still needed, as planes of 16-bit numbers or floats. Round each
/// plane lie its linear extrapolations, so that central differences at the border are one-sided. Slices that
/// GPs gave a plane on a shelf stay for later frames; the others take slots in turn.
class ScalarPlanes {
 public:
  static constexpr int margin = 8;  ///< numbers that can be read on each side of a plane

  /// For slices of one frame; `slots`: how many of those without a plane of their own are there at once.
  /// Slots keep what they hold only while all arguments are as before, shelves until payloads void them.
  void begin_frame(int width, int height, int slots, const PlaneCode& code, const Fillers& fillers);
  int slots() const { return slots_; }
  std::ptrdiff_t pitch() const { return pitch_; }

  /// Puts a slice into its own plane, or into the place of the step `slots` before. `seen`: the columns and
  /// rows of blocks that may be read; what lies beside them takes neither time nor memory. Throws RunError
  /// when the payload has blocks kept that are not here, or a frame's payloads are of different shelves.
  void place(int step, const SheetPayload& payload, ScalarType type, const PixelRect& seen);
  /// Puts a slice's blocks into its own plane, also where it is not to be drawn. False when it has none.
  bool keep(const SheetPayload& payload, ScalarType type, const PixelRect& seen = {});
  /// Puts 2a - b into the place of a step that may be -1, where it is seen.
  void extrapolate(int step, int a, int b, const PixelRect& seen);
  /// Voxel (0, 0).
  const void* plane(int step) const;
  /// Its label, in a plane of as many bytes a row; null where there are none. Of blocks that are not needed
  /// labels are 0 or more than most_tints, whatever else is kept of them.
  const std::uint8_t* labels(int step) const;

 private:
  static constexpr std::size_t least_memory = std::size_t{8} << 20;  ///< for huge pages
  /// What a block holds instead of a filler: something that another frame must not find, or its own voxels
  /// in a plane that is kept.
  static constexpr std::uint8_t unknown = 0xff, voxels = 0xfe;
  static constexpr std::uint8_t unneeded = 0x80;  ///< a flag of labels that are kept
  static_assert(most_tints < unneeded);

  /// What the blocks of a plane hold, so that nothing is filled twice.
  struct Slot {
    std::vector<std::uint8_t> holds;  ///< by block: the filler in it, `voxels` or unknown
    Fillers fillers{};                ///< that `holds` speaks of
  };
  /// Planes, which are kept from frame to frame while what they are of stays the same.
  struct Shelf {
    int generation = -1;
    int width = 0, height = 0;
    PlaneCode code;
    std::vector<Slot> slots;           ///< by plane
    std::vector<MappedMemory> memory;  ///< of planes_together() planes each
  };

  /// Memory of a plane and what it holds.
  struct PlaneMemory {
    std::byte* memory;
    Slot& slot;
  };
  PlaneMemory memory_of_step(int step);
  void put(const PlaneMemory& place, std::uint8_t voxels_are, const SheetPayload& payload, ScalarType type,
           const PixelRect& seen);
  void use_shelf(const ShelfNumber& number);
  void empty(Shelf& shelf);
  MappedMemory memory_of_planes();
  PlaneMemory plane_on(Shelf& shelf, std::size_t plane);
  std::size_t planes_together() const { return std::max<std::size_t>(1, least_memory / plane_bytes_); }
  void renew_fillers(Slot& slot) const;
  /// Calls `use` with one of the planes' numbers, for its type.
  void with_number(auto&& use) const { code_.floats ? use(float{}) : use(std::int16_t{}); }
  template <class Number>
  Number* origin(std::byte* memory) const;
  std::uint8_t* labels_of(std::byte* memory) const;
  template <class Number, class T>
  void put_blocks(const PlaneMemory& place, std::uint8_t voxels_are, const SheetPayload& payload);
  template <class Number, class T>
  const std::byte* put_block(const PlaneMemory& place, std::uint32_t block, bool labelled,
                             const std::byte* from) const;
  void for_rows(std::uint32_t block, auto&& use) const;
  void for_labels(const PlaneMemory& place, std::uint32_t block, auto&& change) const;
  void fill_unsaid(const PlaneMemory& place, const SheetPayload& payload, const PixelRect& seen);
  void fill(const PlaneMemory& place, std::uint32_t block, std::uint8_t with);
  void note_change(std::uint32_t block);
  void extrapolate_border(auto* plane);
  std::uint32_t blocks() const { return std::uint32_t(columns_) * std::uint32_t(rows_); }
  int wide(int column) const { return std::min(CellRanges::side, width_ - column * CellRanges::side); }
  int high(int row) const { return std::min(CellRanges::side, height_ - row * CellRanges::side); }
  std::ptrdiff_t place_of(std::uint32_t block) const {
    return (std::ptrdiff_t(block) / columns_ * pitch_ + std::ptrdiff_t(block) % columns_) * CellRanges::side;
  }

  int width_ = 0, height_ = 0, slots_ = 0;
  int columns_ = 0, rows_ = 0;  ///< of blocks
  std::ptrdiff_t pitch_ = 0;
  PlaneCode code_;
  Fillers fillers_{};
  std::size_t plane_bytes_ = 0;
  Shelf passing_;  ///< its planes are the slots
  std::array<Shelf, ShelfNumber::shelves> shelves_;
  std::vector<MappedMemory> spare_;           ///< of emptied shelves
  bool most_seen_ = false;                    ///< of the last slice
  std::optional<ShelfNumber> shelf_;          ///< of the frame's payloads
  std::vector<std::uint16_t> plane_of_step_;  ///< by step + 1; no_plane: the slice is in a slot
  /// Along an axis, voxels of blocks that changed and lie at a border or next to one that does.
  PixelRun changed_columns_, changed_rows_;
};

/// Bytes of one plane.
std::size_t plane_bytes(int width, int height, const PlaneCode& code);

}  // namespace ringsplat
