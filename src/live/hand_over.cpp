#include "live/hand_over.hpp"

#include "net/blocks.hpp"

namespace ringsplat {

template <class Archive>
void fields(Letter& l, Archive& archive) {
  archive(l.want, l.values, l.lets_go, l.step, l.time, l.steps);
}

void Post::send(int rank, const Letter& letter) {
  Bytes wire = Message::body_buffer();
  const Bytes body = to_bytes(letter);
  wire.insert(wire.end(), body.begin(), body.end());
  const NodeId from{Role::host, transport_.rank()}, to{Role::host, rank};
  transport_.send(rank, Message(make_header(Kind::report, from, to, 0), std::move(wire)));
}

std::optional<Letter> Post::receive() {
  static_cast<void>(transport_.sends_done());
  const auto message = transport_.receive();
  return message ? from_bytes<Letter>(message->body()) : std::nullopt;
}

Letter Post::wait_for_letter() {
  for (;; transport_.wait_next())
    if (auto letter = receive()) return std::move(*letter);
}

void take_values(Session& session, std::span<const double> values, std::span<double* const> offered) {
  if (values.size() != offered.size())
    return SessionParts::note_problem(
        session, fmt::format("rank {} offers {} parameters, rank 0 {}; hint: all ranks offer the same",
                             session.rank(), offered.size(), values.size()));
  for (std::size_t k = 0; k < values.size(); ++k) *offered[k] = values[k];
}

HandOver::HandOver(Session& session, double share)
    : session_(session),
      ranks_(SessionParts::collectives(session)),
      post_(session),
      answers_(ranks_.process() == 0),
      share_(share) {}

HandOver::~HandOver() {
  if (!answers_) return;
  post_.send(0, {.want = Want::end});
  while (post_.wait_for_letter().want != Want::end) continue;
}

/// The heaviest of those that have come.
Letter HandOver::next_question() {
  while (auto next = post_.receive())
    if (next->want >= question_.want) question_ = std::move(*next);
  Letter next = std::exchange(question_, {});
  if (next.want == Want::step && share_.debt() > 0) next.want = Want::news;
  return next;
}

void HandOver::show(std::int64_t step, double time, std::span<double* const> offered) {
  share_.step_ends();
  ++steps_;
  Letter letter;
  if (answers_) letter = next_question();
  const Block told = ranks_.broadcast(letter.want == Want::nothing ? Block{} : to_bytes(letter), 0);
  if (!told.empty()) {
    letter = value_of<Letter>(told, "what pages want");
    take_values(session_, letter.values, offered);
    letter = {letter.want, {}, false, step, time, std::exchange(steps_, 0)};
    for (const double* const value : offered) letter.values.push_back(*value);
    if (answers_) post_.send(0, letter);
  }
  const double begin = now_seconds();
  if (letter.want >= Want::step) session_.commit();
  if (letter.want == Want::step) share_.spend(now_seconds() - begin);
  if (letter.want == Want::hold) {
    do question_ = post_.wait_for_letter();
    while (!question_.lets_go);
    take_values(session_, question_.values, offered);
  }
  share_.step_begins();
}

}  // namespace ringsplat
