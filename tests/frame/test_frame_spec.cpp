#include "ringsplat/base/error.hpp"
#include "ringsplat/frame/frame_spec.hpp"
#include "support/catch.hpp"
#include "support/scenes.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

/// No field has its default value.
FrameSpec unusual_spec() {
  FrameSpec spec;
  spec.frame = 1LL << 40;
  spec.shown.camera = {.azimuth = 1.0 / 3, .elevation = -21, .roll = 8, .zoom = 1.2, .matrix = {{1, 2, 3}}};
  spec.shown.width = 120;
  spec.shown.height = 104;
  spec.as<Splats>().image_plane = ImagePlane::slices;
  spec.as<Splats>().plane_samples = 4;
  spec.division.region_size = 32;
  spec.division.dealt_to = 7;
  spec.shown.transfer_function = ramp(20, 255, 0.9);
  spec.shown.transfer_function.name = "bone, thin";
  spec.shown.transfer_function.nan_srgb = {0, 0.25, 1};
  spec.shown.shading = Shading::none;
  spec.shown.material = {.ambient = 0.125, .diffuse = 0.5, .specular = 0.75, .exponent = 3};
  spec.shown.light = {1, 2, 3};
  spec.as<Splats>().kernel_radius = 1.25;
  spec.as<Splats>().kernel = {
      .method = KernelMethod::texture, .phases = 2, .qee_bits = 10, .normalisation = Normalisation::exact};
  spec.shown.opacity_correction = false;
  spec.shown.opaque_threshold = 0;
  spec.shown.reduction = {.factor = 2, .prefilter = true};
  spec.as<Splats>().payload = PayloadForm::words;
  spec.as<Splats>().precision = Precision::u8;
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
  CHECK(method_of(whole) == "splats");
  for (const Bytes& other : {Bytes(), Bytes(whole.size(), std::byte{7})})
    REQUIRE_THROWS_AS(method_of(other), RunError);
  for (const int unknown : {-1, 3, 1 << 30}) {
    FrameSpec odd = unusual_spec();
    odd.as<Splats>().precision = static_cast<Precision>(unknown);
    REQUIRE_THROWS_AS(decode_frame_spec(encode(odd)), RunError);
  }
}
