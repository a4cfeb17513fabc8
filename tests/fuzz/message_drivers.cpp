// Messages between ranks while they render: headers, announcements, payloads, news and reports.
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "base/byte_stream.hpp"
#include "frame/frame_geometry.hpp"
#include "frame/frame_spec_bytes.hpp"
#include "fuzz/driver.hpp"
#include "fuzz/other_process.hpp"
#include "fuzz/small_scene.hpp"
#include "net/mesh.hpp"
#include "net/message.hpp"
#include "ringsplat/base/error.hpp"
#include "support/scenes.hpp"

namespace ringsplat::fuzz {
namespace {

Input input_of(std::span<const std::byte> bytes) { return Input(text_of(bytes)); }
std::span<const std::byte> body_of(const Bytes& wire) {
  return std::span(wire).last(Message::body_size(wire));
}

void run_message(std::span<const std::byte> input) {
  Message message = Message::from_wire(copy_of(input), 3);
  check(message.header, Layout{2, 2});
  static_cast<void>(name(message.header.kind));
  if (message.seal().size() != input.size() || message.body().size() != message.header.bytes)
    throw std::logic_error("a message is not as long as it came");
}

std::vector<Input> message_seeds() {
  Bytes body = Message::body_buffer();
  append(body, std::uint64_t{7});
  Message payload(make_header({Role::gp, 0}, {Role::renderer, 0}, 1, PayloadFields{.place = {.step = 3}}),
                  body);
  Message token(make_header({Role::gp, 0}, {Role::gp, 1}, 0, TokenFields{}));
  return {input_of(payload.seal()), input_of(token.seal())};
}

void run_frame_spec(std::span<const std::byte> input) {
  const FrameSpec spec = decode_frame_spec(copy_of(input));
  static_cast<void>(to_json(spec).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
  check(spec);
  // Small, because a rank that announces a picture also holds it.
  constexpr std::int64_t most_pixels = 1 << 16;
  if (std::int64_t{spec.shown.width} * spec.shown.height > most_pixels) return;
  const FrameGeometry geometry = make_geometry(spec, small_grid());
  if (std::int64_t{geometry.width} * geometry.height > most_pixels) return;
  SmallRun run(spec, small_grid());
  for (int step = 0; step < run.geometry().slices; ++step)
    if (const Bytes payload = run.encode(step); !payload.empty()) run.draw(step, body_of(payload));
  run.finish();
}

std::vector<Input> frame_spec_seeds() {
  std::vector<Input> seeds;
  for (unsigned choice = 0; choice < frame_choices; ++choice)
    seeds.push_back(input_of(encode(small_frame(choice))));
  FrameSpec other = small_frame(0);
  other.shown.camera.matrix = {4, 0, 0, 20, 0, 4, 0, 18, 0, 0, 1, 0};
  other.shown.reduction = {.factor = 2, .prefilter = true};
  other.shown.shading = Shading::none;
  seeds.push_back(input_of(encode(other)));
  return seeds;
}

/// Input: a choice of frame, then parts, each a step and a payload.
void run_payload(std::span<const std::byte> input) {
  SmallRun run(small_frame(take_choice(input)), small_grid());
  try {
    for (std::span<const std::byte> part; take_part(input, part);) {
      const int step = int(take_choice(part));
      const Bytes payload = copy_of(part);
      run.draw(step, payload);
      Bytes news;
      run.painter().news(0, news);
    }
  } catch (const InputError&) {
    throw std::logic_error("a payload from another rank is no bad input");
  }
  run.finish();
}

std::vector<Input> payload_seeds() {
  std::vector<Input> seeds;
  for (unsigned choice = 0; choice < frame_choices; ++choice) {
    SmallRun run(small_frame(choice), small_grid());
    Input seed(1, char(choice));
    for (int step = 0; step < run.geometry().slices; step += 2) {
      const Bytes payload = run.encode(step);
      if (payload.empty()) continue;
      Bytes part{std::byte(step)};
      const auto body = body_of(payload);
      part.insert(part.end(), body.begin(), body.end());
      append_part(seed, part);
    }
    seeds.push_back(seed);
  }
  return seeds;
}

/// Input: a choice of frame, then parts, the news before each slice. Renderers must be able to draw the
/// payloads that follow.
void run_opaque_news(std::span<const std::byte> input) {
  SmallRun run(small_frame(take_choice(input)), small_grid());
  int step = 0;
  for (std::span<const std::byte> part; take_part(input, part) && step < run.geometry().slices; ++step) {
    try {
      run.encoder().take_news(copy_of(part));
    } catch (const InputError&) {
      throw std::logic_error("news from another rank are no bad input");
    }
    const Bytes payload = run.encode(step);
    if (payload.empty()) continue;
    try {
      run.draw(step, body_of(payload));
    } catch (const RunError& e) {
      throw std::logic_error(std::string("a GP's own payload is refused: ") + e.what());
    }
  }
  run.finish();
}

std::vector<Input> opaque_news_seeds() {
  std::vector<Input> seeds;
  for (const unsigned choice : {0U, 1U, 2U, 6U}) {
    FrameSpec spec = small_frame(choice);
    spec.shown.opaque_threshold = 0.9;
    SmallRun run(spec, small_grid());
    Input seed(1, char(choice));
    for (int step = 0; step < run.geometry().slices; ++step) {
      if (const Bytes payload = run.encode(step); !payload.empty()) run.draw(step, body_of(payload));
      Bytes news;
      run.painter().news(0, news);
      append_part(seed, body_of(news));
    }
    seeds.push_back(seed);
  }
  return seeds;
}

/// Input: a choice of rank, then the report.
void run_link_counts(std::span<const std::byte> input) {
  const Layout mesh = mesh_layout(2, 2, 3);
  const int rank = int(take_choice(input) % unsigned(mesh.ranks()));
  for (const LinkCounts& count : decode_link_counts(copy_of(input), mesh, rank))
    static_cast<void>(name(mesh, count.link));
}

std::vector<Input> link_counts_seeds() {
  const Layout mesh = mesh_layout(2, 2, 3);
  std::vector<Input> seeds;
  for (int rank = 0; rank < mesh.ranks(); ++rank) {
    std::vector<LinkCounts> counts;
    for (const Link& link : links_from(mesh, rank))
      counts.push_back({.link = link, .messages = 3, .bytes = 99});
    const Bytes wire = encode(counts);
    seeds.emplace_back(1, char(rank)).append(text_of(body_of(wire)));
  }
  return seeds;
}

}  // namespace

std::vector<Driver> message_drivers() {
  return {{"message", run_message, message_seeds, {"RSP1"}, 20000},
          {"frame_spec", run_frame_spec, frame_spec_seeds, {}, 1000},
          {"payload", run_payload, payload_seeds, {}, 1500},
          {"opaque_news", run_opaque_news, opaque_news_seeds, {}, 700},
          {"link_counts", run_link_counts, link_counts_seeds, {}, 10000}};
}

}  // namespace ringsplat::fuzz
