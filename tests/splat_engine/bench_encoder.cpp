// Times a GP's and a Renderer's part of a frame alone: encodes all slices of a volume for one Renderer, with
// the news of opaque tiles of a real run, and draws them, for an orbit of views. Prints medians over the
// views of the best of several repetitions, in milliseconds of thread time.
//   bench_encoder VOLUME TRANSFER-FUNCTION [repetitions] [slices]
#include <time.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <vector>

#include "classify/empty_space.hpp"
#include "net/message.hpp"
#include "ringsplat/formats/open.hpp"
#include "session/render_frames.hpp"
#include "splat_engine/splat_engine.hpp"

using namespace ringsplat;

namespace {

constexpr int views = 24;

double thread_milliseconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return 1e3 * double(t.tv_sec) + 1e-6 * double(t.tv_nsec);
}

struct View {
  std::shared_ptr<const SplatFrame> frame;
  std::vector<Bytes> news;  ///< after each step
  std::uint64_t visible = 0, sent = 0;
  double make = 1e300, encode = 1e300, draw = 1e300;  ///< milliseconds, the best so far
};

View make_view_of(const FrameSpec& orbit, const Grid& grid, int view) {
  View v;
  FrameSpec spec = orbit;
  spec.shown.camera.azimuth = 360.0 * view / views;
  v.frame = std::make_shared<SplatFrame>(spec, make_geometry(spec, grid), 1, 1);
  return v;
}

std::span<const std::byte> body_of(const Bytes& wire) {
  return wire.empty() ? std::span(wire) : std::span(wire).subspan(sizeof(Header));
}

EncodedStep encode_slice(Encoder& encoder, int step) {
  encoder.begin(step);
  while (!encoder.work()) {
  }
  return encoder.finish();
}

void draw_slice(Painter& painter, int step, const Bytes& payload) {
  painter.begin({step, 0, body_of(payload)});
  while (!painter.work()) {
  }
}

/// Draws the frame once to get a Renderer's news of opaque tiles.
void gather_news(View& v, const SliceStore& store, EmptySpace& empty_space) {
  ThreadTeam alone;
  const auto encoder = make_splat_encoder(v.frame, 1, store, empty_space, alone);
  const auto painter = make_splat_painter(0, alone);
  painter->begin_frame(v.frame);
  for (int step = 0; step < v.frame->geometry.slices; ++step) {
    const EncodedStep slice = encode_slice(*encoder, step);
    v.visible += slice.counts.visible;
    v.sent += slice.parts[0].items;
    Bytes news;
    if (!slice.parts[0].payload.empty()) {
      draw_slice(*painter, step, slice.parts[0].payload);
      painter->news(0, news);
      encoder->take_news(body_of(news));
    }
    v.news.push_back(std::move(news));
  }
}

void measure(View& v, const SliceStore& store, EmptySpace& empty_space) {
  ThreadTeam alone;
  const double start = thread_milliseconds();
  const auto encoder = make_splat_encoder(v.frame, 1, store, empty_space, alone);
  const double made = thread_milliseconds();
  const auto painter = make_splat_painter(0, alone);
  painter->begin_frame(v.frame);
  double encode = 0, draw = 0;
  for (int step = 0; step < v.frame->geometry.slices; ++step) {
    const double begin = thread_milliseconds();
    const EncodedStep slice = encode_slice(*encoder, step);
    encoder->take_news(body_of(v.news[std::size_t(step)]));
    const double encoded = thread_milliseconds();
    if (!slice.parts[0].payload.empty()) draw_slice(*painter, step, slice.parts[0].payload);
    encode += encoded - begin;
    draw += thread_milliseconds() - encoded;
  }
  v.make = std::min(v.make, made - start);
  v.encode = std::min(v.encode, encode);
  v.draw = std::min(v.draw, draw);
}

template <class Figure>
double median(const std::vector<View>& all, const Figure& figure) {
  std::vector<double> values;
  for (const View& v : all) values.push_back(double(figure(v)));
  std::nth_element(values.begin(), values.begin() + views / 2, values.end());
  return values[views / 2];
}

FrameSpec orbit_from(const std::string& transfer_function, const Histogram& histogram) {
  FrameSpec spec{.how = Splats{}};
  spec.shown.camera.elevation = 25;
  spec.shown.transfer_function = preset(transfer_function, histogram);
  return spec;
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc < 3)
    throw std::invalid_argument("usage: bench_encoder VOLUME TRANSFER-FUNCTION [repetitions] [slices]");
  SoloCollectives solo;
  OpenedVolume volume = open_everywhere(solo, [&] { return open_volume(argv[1]); });
  const Scene scene = load_scene(volume, {}, Layout{1, 1, Placement::dedicated}, {solo});
  const SliceStore& store = scene.stores.at(0);
  FrameSpec orbit = orbit_from(argv[2], scene.values.histogram);
  if (argc > 4 && std::string(argv[4]) == "slices") orbit.as<Splats>().image_plane = ImagePlane::slices;
  const int repetitions = argc > 3 ? std::max(1, std::atoi(argv[3])) : 5;
  EmptySpace empty_space;
  std::vector<View> all;
  for (int view = 0; view < views; ++view) {
    all.push_back(make_view_of(orbit, scene.grid, view));
    gather_news(all.back(), store, empty_space);
  }
  for (int k = 0; k < repetitions; ++k)
    for (View& v : all) measure(v, store, empty_space);
  std::printf(
      "visible %.0f, sent %.0f, encoder made in %.3f ms, slices encoded in %.2f ms, %.1f ns a splat, drawn "
      "in %.2f ms\n",
      median(all, [](const View& v) { return v.visible; }), median(all, [](const View& v) { return v.sent; }),
      median(all, [](const View& v) { return v.make; }), median(all, [](const View& v) { return v.encode; }),
      median(all, [](const View& v) { return 1e6 * v.encode / double(v.sent); }),
      median(all, [](const View& v) { return v.draw; }));
} catch (const std::exception& e) {
  std::fprintf(stderr, "%s\n", e.what());
  return 1;
}
