#include "sort_last/layers.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "frame/frame_geometry.hpp"
#include "ringsplat/base/error.hpp"
#include "simulate/charge.hpp"
#include "sort_last/layer_pixels.hpp"
#include "sort_last/section_painter.hpp"

namespace ringsplat::sort_last {
namespace {

/// A run of a layer's regions, drawn by one rank.
struct Piece {
  int rank, layer;
  Section regions;
};

Section common(const Section& a, const Section& b) {
  return {std::max(a.first, b.first), std::min(a.end, b.end)};
}

/// What the regions of each layer cost, and what a piece of it costs besides.
struct LayerCosts {
  int layers, regions;
  std::vector<double> costs;  ///< by layer: those of its regions, and the piece's
  double of(int layer, int region) const { return costs[std::size_t(layer * (regions + 1) + region)]; }
  double of_piece(int layer) const { return of(layer, regions); }
  bool shows(int layer) const {
    for (int region = 0; region < regions; ++region)
      if (of(layer, region) > 0) return true;
    return false;
  }
};

/// Pieces for ranks one after another, each with as many regions as `most` allows.
std::vector<Piece> pieces_within(const LayerCosts& costs, double most) {
  std::vector<Piece> pieces;
  int rank = 0;
  double spent = 0;
  for (int layer = 0; layer < costs.layers; ++layer) {
    if (!costs.shows(layer)) continue;
    for (int region = 0; region < costs.regions; ++region) {
      const double cost = costs.of(layer, region);
      if (spent + cost + (region == 0 ? costs.of_piece(layer) : 0) > most && spent > 0) {
        ++rank;
        spent = 0;
      }
      if (region == 0 || spent == 0) {
        pieces.push_back({rank, layer, {region, region}});
        spent += costs.of_piece(layer);
      }
      pieces.back().regions.end = region + 1;
      spent += cost;
    }
  }
  return pieces;
}

/// Those whose costliest rank has the least to do.
std::vector<Piece> deal(const LayerCosts& costs, int ranks) {
  double low = 0, high = 0;
  for (const double cost : costs.costs) high += 2 * cost;
  for (int k = 0; k < 24; ++k) {
    const double middle = 0.5 * (low + high);
    const std::vector<Piece> pieces = pieces_within(costs, middle);
    (pieces.empty() || pieces.back().rank < ranks ? high : low) = middle;
  }
  return pieces_within(costs, high);
}

class SheetLayers final : public Layers {
 public:
  SheetLayers(const LayersSetup& setup, const FrameSpec& spec, MPI_Comm comm) : setup_(setup), comm_(comm) {
    MPI_Comm_rank(comm, &rank_);
    MPI_Comm_size(comm, &ranks_);
    const FrameGeometry geometry = make_geometry(spec, setup.source.grid());
    axis_ = geometry.traversal.axis;
    regions_ = geometry.regions;
    const LayerCosts costs = measure(spec);
    pieces_ = deal(costs, ranks_);
    deal_owners(costs);
    for (const Piece& piece : pieces_)
      if (piece.rank == rank_)
        painters_.push_back(make_sheet_section(part_of(piece), axis_, setup.low, setup.high));
  }

  LayersDrawn draw(const FrameSpec& spec, Image& picture) override {
    LayersDrawn drawn;
    const bool ascending = make_geometry(spec, setup_.source.grid()).traversal.ascending;
    std::vector<Incoming> incoming = expect(ascending);
    std::vector<Bytes> gathered = rank_ == 0 ? expect_tiles() : std::vector<Bytes>{};
    paint(spec, ascending, drawn);
    Image own(spec.shown.width, spec.shown.height);
    composite(incoming, float(spec.shown.opaque_threshold), own);
    if (rank_ == 0) {
      picture = std::move(own);
      put_together(gathered, picture);
    } else {
      Bytes tiles;
      put_regions(own, owned_[std::size_t(rank_)], false, tiles);
      send(std::move(tiles), 0, tiles_tag, drawn);
    }
    MPI_Waitall(int(sending_.size()), sending_.data(), MPI_STATUSES_IGNORE);
    sending_.clear();
    sent_.clear();
    return drawn;
  }

  std::uint64_t slice_memory() const override {
    std::uint64_t bytes = 0;
    for (const auto& painter : painters_) bytes += painter->slice_memory();
    return bytes;
  }

 private:
  static constexpr int tiles_tag = 1 << 14;
  /// A part of a layer that comes to this rank; from itself without a message.
  struct Incoming {
    Section regions;
    int layer = 0;
    bool own = false;
    MPI_Request request = MPI_REQUEST_NULL;
    Bytes bytes;
  };

  Section slices_of(int layer) const {
    const int all = setup_.source.grid().slices(axis_);
    return {layer * setup_.slices, std::min((layer + 1) * setup_.slices, all)};
  }

  SectionSetup part_of(const Piece& piece) const {
    return {setup_.source, slices_of(piece.layer), setup_.machine, 1, 1, piece.regions, painters_.empty()};
  }

  LayerCosts measure(const FrameSpec& spec) const {
    const int layers = (setup_.source.grid().slices(axis_) + setup_.slices - 1) / setup_.slices;
    LayerCosts all{layers, regions_.count(),
                   std::vector<double>(std::size_t(layers * (regions_.count() + 1)))};
    for (int layer = rank_; layer < layers; layer += ranks_) {
      const auto costs = region_costs(part_of({rank_, layer, {}}), axis_, setup_.low, setup_.high, spec);
      std::copy(costs.begin(), costs.end(), all.costs.begin() + layer * (regions_.count() + 1));
    }
    MPI_Allreduce(MPI_IN_PLACE, all.costs.data(), int(all.costs.size()), MPI_DOUBLE, MPI_SUM, comm_);
    return all;
  }

  /// By how many layers show something in a region.
  void deal_owners(const LayerCosts& costs) {
    std::vector<double> work(std::size_t(regions_.count()), 0.5);
    for (int layer = 0; layer < costs.layers; ++layer)
      for (int region = 0; region < costs.regions; ++region)
        if (costs.of(layer, region) > 0) work[std::size_t(region)] += 1;
    for (int rank = 0; rank < ranks_; ++rank) owned_.push_back(section_of(rank, ranks_, work));
  }

  std::size_t most_bytes(const Section& regions, bool halves) const {
    return std::size_t(regions.slices()) *
           most_region_bytes(std::size_t(layer_region * layer_region), halves);
  }

  /// Pieces are dealt by ascending layers; a frame draws and composites them from the front.
  std::vector<Piece> from_front(bool ascending) const {
    std::vector<Piece> pieces = pieces_;
    if (!ascending)
      std::ranges::stable_sort(pieces, [](const Piece& a, const Piece& b) { return a.layer > b.layer; });
    return pieces;
  }

  std::vector<Incoming> expect(bool ascending) {
    std::vector<Incoming> incoming;
    for (const Piece& piece : from_front(ascending)) {
      const Section regions = common(piece.regions, owned_[std::size_t(rank_)]);
      if (regions.slices() < 1) continue;
      Incoming& next =
          incoming.emplace_back(Incoming{regions, piece.layer, piece.rank == rank_, MPI_REQUEST_NULL, {}});
      if (next.own) continue;
      next.bytes.resize(most_bytes(regions, setup_.halves));
      MPI_Irecv(next.bytes.data(), int(next.bytes.size()), MPI_BYTE, piece.rank, piece.layer, comm_,
                &next.request);
    }
    return incoming;
  }

  std::vector<Bytes> expect_tiles() {
    std::vector<Bytes> gathered(static_cast<std::size_t>(ranks_));
    gathering_.assign(std::size_t(ranks_), MPI_REQUEST_NULL);
    for (int rank = 1; rank < ranks_; ++rank) {
      Bytes& bytes = gathered[std::size_t(rank)];
      bytes.resize(most_bytes(owned_[std::size_t(rank)], false));
      MPI_Irecv(bytes.data(), int(bytes.size()), MPI_BYTE, rank, tiles_tag, comm_,
                &gathering_[std::size_t(rank)]);
    }
    return gathered;
  }

  void put_regions(const Image& image, const Section& regions, bool halves, Bytes& bytes) const {
    for (int region = regions.first; region < regions.end; ++region)
      put_region(image, regions_.rect(region), halves, bytes);
  }

  void paint(const FrameSpec& spec, bool ascending, LayersDrawn& drawn) {
    const auto own = [this](const Piece& piece) { return piece.rank == rank_; };
    std::vector<int> numbers;  // of own pieces, from the front
    std::vector<Piece> pieces;
    std::ranges::copy_if(pieces_, std::back_inserter(pieces), own);
    for (int k = 0; k < int(pieces.size()); ++k)
      numbers.push_back(ascending ? k : int(pieces.size()) - 1 - k);
    for (const int number : numbers) {
      const double start = MPI_Wtime();
      Image image(spec.shown.width, spec.shown.height);
      const Drawn part = painters_[std::size_t(number)]->draw(spec, image);
      drawn.items += part.items;
      double pixels = 0;
      for (const int region : part.regions)
        pixels += double(regions_.rect(region).width()) * double(regions_.rect(region).height());
      drawn.pixels += pixels;
      // While the clock passes others draw, too: only what is sent stays.
      std::vector<std::pair<int, Bytes>> parts = parts_for_owners(pieces[std::size_t(number)], image);
      image = {};
      charge(setup_.per_pixel * pixels);
      drawn.painting += MPI_Wtime() - start;
      for (auto& [owner, bytes] : parts)
        if (owner == rank_)
          own_parts_.emplace_back(pieces[std::size_t(number)].layer, std::move(bytes));
        else
          send(std::move(bytes), owner, pieces[std::size_t(number)].layer, drawn);
    }
  }

  std::vector<std::pair<int, Bytes>> parts_for_owners(const Piece& piece, const Image& image) const {
    std::vector<std::pair<int, Bytes>> parts;
    for (int owner = 0; owner < ranks_; ++owner) {
      const Section regions = common(piece.regions, owned_[std::size_t(owner)]);
      if (regions.slices() < 1) continue;
      put_regions(image, regions, setup_.halves, parts.emplace_back(owner, Bytes{}).second);
    }
    return parts;
  }

  void send(Bytes bytes, int to, int tag, LayersDrawn& drawn) {
    ++drawn.messages;
    drawn.bytes += double(bytes.size());
    if (setup_.machine) charge(sending_seconds(*setup_.machine, double(bytes.size())));
    sent_.push_back(std::move(bytes));
    MPI_Isend(sent_.back().data(), int(sent_.back().size()), MPI_BYTE, to, tag, comm_,
              &sending_.emplace_back());
  }

  void composite(std::vector<Incoming>& incoming, float opaque_threshold, Image& own) {
    for (Incoming& part : incoming) {
      if (part.own)
        part.bytes =
            std::move(std::ranges::find(own_parts_, part.layer, &std::pair<int, Bytes>::first)->second);
      else
        wait(part.request);
      std::size_t pixels = 0;
      std::span<const std::byte> bytes = part.bytes;
      for (int region = part.regions.first; region < part.regions.end; ++region)
        pixels += composite_region(bytes, regions_.rect(region), setup_.halves, opaque_threshold, own);
      part.bytes = {};
      charge(setup_.per_byte * double(pixels) * 4 * sizeof(float));
    }
    own_parts_.clear();
  }

  void wait(MPI_Request& request) const {
    MPI_Wait(&request, MPI_STATUS_IGNORE);
    if (setup_.machine) charge(setup_.machine->message.receive);
  }

  void put_together(const std::vector<Bytes>& gathered, Image& picture) {
    for (int rank = 1; rank < ranks_; ++rank) {
      wait(gathering_[std::size_t(rank)]);
      std::size_t pixels = 0;
      std::span<const std::byte> bytes = gathered[std::size_t(rank)];
      const Section& regions = owned_[std::size_t(rank)];
      for (int region = regions.first; region < regions.end; ++region)
        pixels += composite_region(bytes, regions_.rect(region), false, 0, picture);
      charge(setup_.per_byte * double(pixels) * 4 * sizeof(float));
    }
  }

  LayersSetup setup_;
  MPI_Comm comm_;
  int rank_ = 0, ranks_ = 1;
  Axis axis_ = Axis::z;
  Regions regions_;
  std::vector<Piece> pieces_;                              ///< of all ranks, by ascending layers
  std::vector<Section> owned_;                             ///< by rank, its regions of the picture
  std::vector<std::unique_ptr<SectionPainter>> painters_;  ///< of the own pieces
  std::vector<std::pair<int, Bytes>> own_parts_;           ///< by layer: what comes from this rank itself
  std::vector<MPI_Request> sending_, gathering_;
  std::vector<Bytes> sent_;
};

}  // namespace

std::unique_ptr<Layers> make_layers(const LayersSetup& setup, const FrameSpec& spec, MPI_Comm comm) {
  return std::make_unique<SheetLayers>(setup, spec, comm);
}

}  // namespace ringsplat::sort_last
