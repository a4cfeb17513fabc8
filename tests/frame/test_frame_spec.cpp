#include "ringsplat/base/error.hpp"
#include "ringsplat/frame/frame_spec.hpp"
#include "support/catch.hpp"
#include "support/scenes.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

/// No field as it is by default.
FrameSpec unusual_spec() {
  FrameSpec spec;
  spec.frame = 1LL << 40;
  spec.camera = {.azimuth = 1.0 / 3, .elevation = -21, .roll = 8, .zoom = 1.2, .matrix = {{1, 2, 3}}};
  spec.width = 120;
  spec.height = 104;
  spec.image_plane = ImagePlane::slices;
  spec.plane_samples = 4;
  spec.region_size = 32;
  spec.dealt_to = 7;
  spec.transfer_function = ramp(20, 255, 0.9);
  spec.transfer_function.name = "bone, thin";
  spec.transfer_function.nan_srgb = {0, 0.25, 1};
  spec.shading = Shading::none;
  spec.material = {.ambient = 0.125, .diffuse = 0.5, .specular = 0.75, .exponent = 3};
  spec.light = {1, 2, 3};
  spec.kernel_radius = 1.25;
  spec.kernel = {
      .method = KernelMethod::texture, .phases = 2, .qee_bits = 10, .normalisation = Normalisation::exact};
  spec.opacity_correction = false;
  spec.opaque_threshold = 0;
  spec.reduction = {.factor = 2, .prefilter = true};
  spec.payload = PayloadForm::words;
  spec.precision = Precision::u8;
  return spec;
}

}  // namespace

TEST_CASE("an announced frame arrives as it was sent, field by field") {
  CHECK(decode_frame_spec(encode(FrameSpec())) == FrameSpec());
  const FrameSpec spec = unusual_spec(), arrived = decode_frame_spec(encode(spec));
  CHECK(arrived == spec);
  CHECK(to_json_text(arrived) == to_json_text(spec));
}

TEST_CASE("bytes that are no frame announcement are refused, whatever their length") {
  const Bytes whole = encode(unusual_spec());
  for (std::size_t count = 0; count < whole.size(); ++count)
    REQUIRE_THROWS_AS(decode_frame_spec(std::span(whole).first(count)), RunError);
  Bytes longer = whole;
  longer.push_back(std::byte{0});
  REQUIRE_THROWS_AS(decode_frame_spec(longer), RunError);
  REQUIRE_THROWS_AS(decode_frame_spec(Bytes(whole.size(), std::byte{0xff})), RunError);
  for (const int unknown : {-1, 3, 1 << 30}) {
    FrameSpec odd = unusual_spec();
    odd.precision = static_cast<Precision>(unknown);
    REQUIRE_THROWS_AS(decode_frame_spec(encode(odd)), RunError);
  }
}
