#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <tuple>

#include "record/trace.hpp"

namespace ringsplat {
namespace {

using nlohmann::json;
using Nanoseconds = std::int64_t;

constexpr Nanoseconds mark_length = 1000;

/// By Activity, and by Moment.
constexpr const char *span_names[] = {"slice",     "wait for token", "send", "draw",
                                      "composite", "deliver",        "frame"},
                     *mark_names[] = {"pass token", "take token", "send payload", "take payload"};

bool leaves(Moment m) { return m == Moment::pass_token || m == Moment::send_payload; }
bool of_token(Moment m) { return m == Moment::pass_token || m == Moment::take_token; }

/// Both ends of a flow have the same key.
auto flow_key(const Mark& m) { return std::tuple(of_token(m.moment), m.frame, m.step, m.renderer); }
using FlowKey = decltype(flow_key(Mark{}));

/// Numbers the flows of which both ends were recorded.
std::map<FlowKey, std::int64_t> number_flows(const std::vector<NodeRecord>& nodes) {
  std::map<FlowKey, std::array<bool, 2>> ends;
  for (const auto& node : nodes)
    for (const auto& mark : node.marks) ends[flow_key(mark)][leaves(mark.moment)] = true;
  std::map<FlowKey, std::int64_t> numbers;
  for (const auto& [key, here] : ends)
    if (here[0] && here[1]) numbers.emplace(key, std::int64_t(numbers.size()) + 1);
  return numbers;
}

double first_time(const std::vector<NodeRecord>& nodes) {
  double first = 1e300;
  for (const auto& node : nodes) {
    for (const auto& span : node.spans) first = std::min(first, span.begin);
    for (const auto& mark : node.marks) first = std::min(first, mark.time);
  }
  return first;
}

double microseconds(Nanoseconds t) { return double(t) / 1000; }
double microseconds(double seconds) { return std::round(seconds * 1e9) / 1000; }

/// A node's row. Begins and ends are each rounded to nanoseconds once, so that nesting survives rounding.
struct Row {
  /// Kept as text, which takes a fraction of a JSON object's memory.
  struct Line {
    double time, duration;
    std::string event;
  };

  int process, thread;
  double start;
  std::vector<Line> lines = {};
  std::vector<Nanoseconds> edges = {};  ///< where something begins or ends

  /// A parent stands before its children and before the flows that bind to it.
  void append_to(std::string& text) {
    std::ranges::stable_sort(lines, {}, [](const Line& l) { return std::pair(l.time, -l.duration); });
    for (const auto& line : lines) text.append(",\n").append(line.event);
  }

  json event(const char* phase, const char* name, const char* category, Nanoseconds time, json args) const {
    json e{{"ph", phase}, {"name", name}, {"cat", category}, {"pid", process}, {"tid", thread}};
    e["ts"] = microseconds(time);
    e["args"] = std::move(args);
    return e;
  }

  void add(const json& e) { lines.push_back({e["ts"], e.value("dur", 0.0), e.dump()}); }
  Nanoseconds at(double time) const { return std::llround((time - start) * 1e9); }

  void write_complete(const char* what, const char* category, Nanoseconds begin, Nanoseconds end, json args) {
    json e = event("X", what, category, begin, std::move(args));
    e["dur"] = microseconds(end - begin);
    add(e);
    edges.push_back(begin);
    edges.push_back(end);
  }

  void write(const Span& span) {
    if (span.activity == Activity::frame) return write_frame(span);
    json args{{"frame", span.frame}, {"busy_us", microseconds(span.busy)}};
    if (span.step >= 0) args["step"] = span.step;
    write_complete(span_names[std::size_t(span.activity)], "node", at(span.begin), at(span.end), args);
  }

  /// Frames in flight overlap, so they are asynchronous events beside the rows.
  void write_frame(const Span& span) {
    for (const bool ends : {false, true}) {
      json e = event(ends ? "e" : "b", "frame", "frame", at(ends ? span.end : span.begin),
                     {{"frame", span.frame}});
      e["id"] = span.frame;
      add(e);
    }
  }

  /// A viewer binds a flow's end to the span at its time. So each mark gets a short span of its own, which
  /// ends before anything else begins or ends.
  void write_marks(std::vector<Mark> marks, const std::map<FlowKey, std::int64_t>& flows) {
    for (const auto& mark : marks) edges.push_back(at(mark.time));
    std::sort(edges.begin(), edges.end());
    const std::vector<Nanoseconds> all = edges;
    for (auto mark = marks.begin(); mark != marks.end(); ++mark) {
      const Nanoseconds begin = at(mark->time);
      Nanoseconds end = begin + mark_length;
      const auto next = std::upper_bound(all.begin(), all.end(), begin);
      if (next != all.end()) end = std::min(end, *next);
      if (mark + 1 != marks.end()) end = std::max(begin, std::min(end, at((mark + 1)->time)));
      const char* category = of_token(mark->moment) ? "token" : "payload";
      const json args{{"frame", mark->frame}, {"step", mark->step}, {"renderer", mark->renderer}};
      write_complete(mark_names[std::size_t(mark->moment)], category, begin, end, args);
      write_flow_end(*mark, begin, category, args, flows);
    }
  }

  void write_flow_end(const Mark& mark, Nanoseconds time, const char* category, const json& args,
                      const std::map<FlowKey, std::int64_t>& flows) {
    const auto number = flows.find(flow_key(mark));
    if (number == flows.end()) return;
    json e = event(leaves(mark.moment) ? "s" : "f", category, category, time, args);
    e["id"] = number->second;
    if (!leaves(mark.moment)) e["bp"] = "e";
    add(e);
  }
};

json metadata(const char* what, int process, int thread, const char* key, json value) {
  return {
      {"ph", "M"}, {"name", what}, {"pid", process}, {"tid", thread}, {"args", {{key, std::move(value)}}}};
}

/// What a reader must know beside the events.
json explanation(const Trace::Gathered& trace, const Layout& layout) {
  json j{{"gps", layout.gps}, {"renderers", layout.renderers}, {"ranks", layout.ranks()}};
  j["longest_gap_us"] = microseconds(NodeTrace::longest_gap);
  j["full"] = json::array();
  for (const auto& node : trace.nodes)
    if (node.full) j["full"].push_back(to_string(node.node));
  for (const auto& o : trace.offsets)
    j["clocks"].push_back({{"common", o.common},
                           {"offset_us", microseconds(o.offset)},
                           {"uncertainty_us", microseconds(o.uncertainty)}});
  return j;
}

}  // namespace

std::string to_chrome_trace(const Trace::Gathered& trace, const Layout& layout) {
  const auto flows = number_flows(trace.nodes);
  const double start = first_time(trace.nodes);
  std::string text =
      R"({"displayTimeUnit":"ms","otherData":)" + explanation(trace, layout).dump() + ",\"traceEvents\":[";
  const auto add = [&](const json& event) {
    text.append(text.back() == '[' ? "\n" : ",\n").append(event.dump());
  };
  // Numbers begin at 1: viewers treat process and thread 0 specially.
  for (int rank = 0; rank < layout.ranks(); ++rank) {
    add(metadata("process_name", rank + 1, 0, "name", "rank " + std::to_string(rank)));
    add(metadata("process_sort_index", rank + 1, 0, "sort_index", rank));
  }
  int thread = 0;
  for (const auto& record : trace.nodes) {
    const int process = layout.rank_of(record.node) + 1;
    ++thread;
    add(metadata("thread_name", process, thread, "name", to_string(record.node)));
    add(metadata("thread_sort_index", process, thread, "sort_index", thread));
    Row row{process, thread, start};
    for (const auto& span : record.spans) row.write(span);
    row.write_marks(record.marks, flows);
    row.append_to(text);
  }
  return text + "\n]}\n";
}

}  // namespace ringsplat
