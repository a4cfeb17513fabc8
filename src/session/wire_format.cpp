#include "session/wire_format.hpp"

#include <fmt/format.h>

#include <bit>
#include <cstdint>
#include <type_traits>

#include "frame/frame_fields.hpp"
#include "net/link_counts.hpp"
#include "net/message.hpp"
#include "protocol/bundle_engine.hpp"
#include "record/stats.hpp"
#include "record/trace.hpp"
#include "ringsplat/frame/frame_spec.hpp"
#include "session/wire_hash.hpp"
#include "sheet_engine/sheet_payload.hpp"
#include "splat/splat.hpp"
#include "splat/voxel_run.hpp"

namespace ringsplat {
namespace {

void add_messages(WireHash& hash) {
  hash.text(std::endian::native == std::endian::big ? "big" : "little");
  hash.layout(&Header::magic, &Header::kind, &Header::source_role, &Header::destination_role, &Header::unused,
              &Header::source, &Header::destination, &Header::frame, &Header::fields, &Header::bytes);
  hash.layout(&TokenPlace::step, &TokenPlace::renderer, &TokenPlace::sequence);
  hash.layout(&TokenFields::place, &TokenFields::credits);
  hash.layout(&PayloadFields::place, &PayloadFields::passes);
  hash.layout(&AcceptFields::place, &AcceptFields::free_slots);
  hash.layout(&FrameEndFields::payloads);
  hash.layout(&TileFields::tile);
  hash.layout(&CreditFields::channel, &CreditFields::slots);
  hash.number(Header{}.magic);
  for (std::uint8_t kind = 0; kind < kinds; ++kind) hash.text(name(Kind(kind)));
  for (auto role = std::uint8_t(Role::gp); role <= std::uint8_t(Role::host); ++role)
    hash.text(to_string(NodeId{Role(role), 0}));
}

/// Adds the fields of a frame in the order of their bytes.
struct AddFields {
  WireHash& hash;
  template <class T>
  void operator()(const char* name, const T& value) {
    hash.text(name);
    if constexpr (HasFields<const T>)
      fields(value, *this);
    else if constexpr (std::is_trivially_copyable_v<T>)
      hash.number(sizeof(T));
    else
      hash.number(sizeof(typename T::value_type));
  }
};

void add_announcement(WireHash& hash) {
  for (const Method& how : {Method(Splats{}), Method(Sheets{})}) {
    FrameSpec frame;
    frame.how = how;
    fields(frame, AddFields{hash});
  }
  using Function = TransferFunction;
  hash.layout(&Function::ColourPoint::value, &Function::ColourPoint::srgb);
  hash.layout(&Function::OpacityPoint::value, &Function::OpacityPoint::opacity);
  hash.layout(&PhongMaterial::ambient, &PhongMaterial::diffuse, &PhongMaterial::specular,
              &PhongMaterial::exponent);
  hash.layout(&VoxelBox::first, &VoxelBox::end);
  hash.order({ImagePlane::screen, ImagePlane::slices});
  hash.order({Interpolation::linear, Interpolation::nearest});
  hash.order({Shading::none, Shading::phong});
  hash.order({KernelMethod::qee, KernelMethod::texture});
  hash.order({Normalisation::none, Normalisation::constant, Normalisation::exact});
  hash.order({PayloadForm::words, PayloadForm::runs});
  hash.order({Precision::float32, Precision::half, Precision::u8});
}

void add_payloads(WireHash& hash) {
  hash.layout(&SplatGroup::region, &SplatGroup::base_x, &SplatGroup::base_y, &SplatGroup::count);
  hash.layout(&Splat::a, &Splat::b, &Splat::c, &Splat::opacity, &Splat::red, &Splat::green, &Splat::blue,
              &Splat::anchor_x, &Splat::anchor_y);
  hash.layout(&BlockGroup::region, &BlockGroup::blocks, &BlockGroup::voxels);
  hash.layout(&VoxelBlock::row, &VoxelBlock::first, &VoxelBlock::mask);
  hash.layout(&FloatVoxel::opacity, &FloatVoxel::rgb);
  hash.layout(&BundlePart::slice_step, &BundlePart::passes, &BundlePart::bytes);
  hash.layout(&HalfVoxel::rgba);
  hash.layout(&ShelfNumber::shelf, &ShelfNumber::live, &ShelfNumber::generation);
  hash.layout(&SheetHeader::low, &SheetHeader::high, &SheetHeader::present, &SheetHeader::first_row,
              &SheetHeader::rows, &SheetHeader::elsewhere, &SheetHeader::scalar, &SheetHeader::plane,
              &SheetHeader::shelf);
  hash.layout(&ByteVoxel::rgba);
}

void add_reports(WireHash& hash) {
  using S = NodeStats;
  hash.layout(&S::computing, &S::waiting_for_token, &S::sending, &S::drawing, &S::compositing, &S::delivering,
              &S::idle, &S::splats_sent, &S::splats_drawn, &S::splats_clipped, &S::splats_hidden,
              &S::payloads_sent, &S::payloads_drawn, &S::payload_bytes_sent, &S::payload_bytes_received,
              &S::tokens_issued, &S::tokens_retired, &S::tokens_passed, &S::tiles, &S::tile_bytes, &S::slices,
              &S::passes, &S::blocks, &S::samples, &S::visible_voxels, &S::voxels_outside, &S::peak_memory,
              &S::slice_memory);
  hash.layout(&LinkCounts::link, &LinkCounts::messages, &LinkCounts::bytes, &LinkCounts::payloads,
              &LinkCounts::payload_bytes, &LinkCounts::shared, &LinkCounts::waited,
              &LinkCounts::wait_seconds);
  hash.layout<3>(&Link::from, &Link::direction);
  hash.layout<3>(&Span::begin, &Span::end, &Span::busy, &Span::stages, &Span::frame, &Span::step,
                 &Span::activity);
  hash.layout<7>(&Mark::time, &Mark::frame, &Mark::step, &Mark::renderer, &Mark::moment);
}

}  // namespace

std::string wire_format() {
  WireHash hash;
  add_messages(hash);
  add_announcement(hash);
  add_payloads(hash);
  add_reports(hash);
  return fmt::format("{:016x}", hash.value());
}

}  // namespace ringsplat
