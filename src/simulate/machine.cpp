#include "simulate/machine.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <functional>
#include <set>
#include <sstream>
#include <vector>

#include "ringsplat/base/error.hpp"

namespace ringsplat {
namespace {

constexpr std::array names{"backbone", "mesh", "torus", "fat_tree"};  // in PlatformKind's order

/// One number of the file: where it goes and what it may be.
struct Field {
  const char* key;
  double least, most;
  std::function<void(double)> set;
  bool required = false, whole = false;
  /// A cost of sheets in costs of a splat, where the file does not say it: about their ratio where both were
  /// measured (mpi_configs/machines/two-core.toml).
  double in_splats = 0;
};

constexpr double no_limit = 1e300;

template <class T>
std::function<void(double)> into(T& target) {
  return [&target](double value) { target = static_cast<T>(value); };
}

std::vector<Field> fields_of(Machine& m) {
  constexpr double longest = 3600, most_count = 1 << 20;
  const auto seconds = [](const char* key, double& target, bool required = false) {
    return Field{key, 0, longest, into(target), required};
  };
  const auto of_sheets = [](const char* key, double& target, double in_splats) {
    return Field{key, 0, longest, into(target), false, false, in_splats};
  };
  const auto count = [](const char* key, auto& target, double least, double most) {
    return Field{key, least, most, into(target), false, true};
  };
  return {seconds("gp.visible_voxel", m.gp.visible_voxel, true),
          seconds("gp.transparent_voxel", m.gp.transparent_voxel, true),
          seconds("gp.slice", m.gp.slice),
          seconds("gp.frame", m.gp.frame),
          seconds("gp.token", m.gp.token),
          seconds("renderer.splat", m.renderer.splat, true),
          seconds("renderer.pass", m.renderer.pass),
          seconds("renderer.slice", m.renderer.slice),
          seconds("renderer.composite", m.renderer.composite),
          seconds("renderer.pixel", m.renderer.pixel),
          seconds("renderer.frame", m.renderer.frame),
          of_sheets("sheets.look", m.sheets.look, 0.05),
          of_sheets("sheets.copy", m.sheets.copy, 1.0),
          of_sheets("sheets.place", m.sheets.place, 2),
          of_sheets("sheets.slice", m.sheets.slice, 100),
          of_sheets("sheets.sample", m.sheets.sample, 0.1),
          of_sheets("sheets.table", m.sheets.table, 2e4),
          seconds("message.send", m.message.send),
          seconds("message.receive", m.message.receive),
          seconds("message.wake", m.message.wake),
          seconds("message.packet", m.message.packet),
          count("message.packet_bytes", m.message.packet_bytes, 0, 1 << 30),
          {"poll_interval", 1e-9, longest, into(m.poll_interval), true},
          {"platform.bandwidth", 1, no_limit, into(m.platform.bandwidth), true},
          seconds("platform.latency", m.platform.latency, true),
          {"platform.backbone_bandwidth", 0, no_limit, into(m.platform.backbone_bandwidth)},
          {"platform.local_bandwidth", 0, no_limit, into(m.platform.local_bandwidth)},
          seconds("platform.local_latency", m.platform.local_latency),
          count("platform.cores", m.platform.cores, 1, most_count),
          count("platform.hosts", m.platform.hosts, 0, most_count),
          count("platform.leaf", m.platform.leaf, 1, most_count)};
}

class Reader {
 public:
  Reader(const std::string& toml, std::string where)
      : where_(std::move(where)), fields_(fields_of(machine_)) {
    std::istringstream in(toml);
    try {
      for (const auto& item : CLI::ConfigTOML().from_config(in))
        if (item.name != "++" && item.name != "--") take(item);  // CLI11's marks of a section's begin and end
    } catch (const CLI::Error& e) {
      throw InputError(fmt::format("{} is no TOML: {}", where_, e.what()), hint);
    }
  }

  Machine read() {
    for (const Field& field : fields_) {
      if (field.required) require(field.key);
      if (field.in_splats > 0 && seen_.count(field.key) == 0)
        field.set(field.in_splats * machine_.renderer.splat);
    }
    for (const char* key : {"name", "platform.kind"}) require(key);
    return machine_;
  }

 private:
  static constexpr const char* hint =
      "mpi_configs/machines has machines that work, docs/simulation.md the fields";

  void require(const char* key) const {
    if (seen_.count(key) == 0) wrong(key, "is missing");
  }
  [[noreturn]] void wrong(const std::string& key, const std::string& problem) const {
    throw InputError(fmt::format("{}: {} {}", where_, key, problem), hint);
  }

  void take(const CLI::ConfigItem& item) {
    const std::string key = item.fullname();
    seen_.insert(key);
    if (item.inputs.size() != 1) wrong(key, "needs one value");
    const std::string& text = item.inputs.front();
    if (key == "name") {
      machine_.name = text;
    } else if (key == "platform.kind") {
      machine_.platform.kind = kind_of(text);
    } else {
      take_number(key, text);
    }
  }

  PlatformKind kind_of(const std::string& text) const {
    const auto found = std::find(names.begin(), names.end(), text);
    if (found == names.end())
      wrong("platform.kind", fmt::format("is '{}', none of {}", text, fmt::join(names, ", ")));
    return PlatformKind(found - names.begin());
  }

  void take_number(const std::string& key, const std::string& text) const {
    const auto field =
        std::find_if(fields_.begin(), fields_.end(), [&](const Field& f) { return key == f.key; });
    if (field == fields_.end()) wrong(key, "is no field of a machine");
    double value = 0;
    if (!CLI::detail::lexical_cast(text, value) || !std::isfinite(value))
      wrong(key, fmt::format("is '{}', not a number", text));
    if (field->whole && value != std::floor(value))
      wrong(key, fmt::format("is {}, not a whole number", text));
    if (!(value >= field->least && value <= field->most))
      wrong(key, field->most < no_limit
                     ? fmt::format("is {}, not from {} to {}", text, field->least, field->most)
                     : fmt::format("is {}, below {}", text, field->least));
    field->set(value);
  }

  std::string where_;
  Machine machine_;
  std::vector<Field> fields_;
  std::set<std::string> seen_;
};

}  // namespace

const char* name(PlatformKind kind) { return names[std::size_t(kind)]; }

Machine parse_machine(const std::string& toml, const std::string& where) {
  return Reader(toml, where).read();
}

Machine read_machine(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  if (!in || !(text << in.rdbuf()))
    throw InputError(fmt::format("the machine {} cannot be read", path),
                     "name a file such as mpi_configs/machines/pixel-planes-5.toml");
  return parse_machine(text.str(), path);
}

double encoding_seconds(const Machine& m, double voxels, double visible, double slices) {
  return slices * m.gp.slice + visible * m.gp.visible_voxel + (voxels - visible) * m.gp.transparent_voxel;
}

double drawing_seconds(const Machine& m, double splats, double passes, double pixels, double slices) {
  return slices * m.renderer.slice + splats * m.renderer.splat + passes * m.renderer.pass +
         pixels * m.renderer.composite;
}

double selecting_seconds(const Machine& m, double blocks, double sent, double slices) {
  return slices * m.gp.slice + blocks * m.sheets.look + sent * m.sheets.copy;
}

double placing_seconds(const Machine& m, double blocks, double placed, double slices) {
  return slices * m.sheets.slice + blocks * m.sheets.look + placed * m.sheets.place;
}

double painting_seconds(const Machine& m, double samples) { return samples * m.sheets.sample; }

double painting_piece(const Machine& m) {
  constexpr double group = 16 * 16, slabs = 12;
  const double seconds = painting_seconds(m, group * slabs);
  return seconds > 0 ? std::min(seconds, m.poll_interval) : m.poll_interval;
}

bool shares_cores(const Machine& m, int ranks) {
  return m.platform.hosts > 0 && ranks > std::int64_t{m.platform.hosts} * m.platform.cores;
}

double sending_seconds(const Machine& m, double bytes) {
  const double packets =
      m.message.packet_bytes == 0 ? 1 : std::ceil(bytes / static_cast<double>(m.message.packet_bytes));
  return m.message.send + packets * m.message.packet;
}

}  // namespace ringsplat
