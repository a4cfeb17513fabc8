#include "study/study_list.hpp"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <map>
#include <optional>
#include <sstream>

#include "options/option_tables.hpp"
#include "options/option_values.hpp"
#include "ringsplat/base/error.hpp"
#include "volume/synth.hpp"

namespace ringsplat::app {

const char* const default_study_list =
    R"(# Settings, scenes and views of a study: ringsplat study LIST.toml -o RESULTS.csv
repetitions = 5
size = "256x256"
error_pixels = 4096
seed = 1
truths = ["method", "field"]
# azimuth elevation [roll [zoom]]
views = ["0 0", "20 10", "45 0", "30 35"]
# azimuths from:to:step, in addition, at elevation 0
# sweep = "0:90:1"

[scene.marschner-lobb]
synth = "marschner-lobb"
dims = "64x64x64"
tf = "mr-surface"
[scene.shell]
synth = "shell"
dims = "64x64x64"
tf = "mr-soft"
[scene.gaussians]
synth = "gaussians"
dims = "64x64x64"
tf = "grey"

[setting.radius-1.2]
radius = 1.2
[setting.radius-1.55]
radius = 1.55
[setting.radius-1.6]
radius = 1.6
[setting.radius-2.0]
radius = 2.0
[setting.radius-2.5]
radius = 2.5
[setting.no-correction]
opacity_correction = false
[setting.raw-weights]
normalisation = "none"
[setting.exact-1.2]
normalisation = "exact"
radius = 1.2
[setting.exact-1.6]
normalisation = "exact"
[setting.texture-1]
kernel = "texture"
phases = 1
[setting.texture-4]
kernel = "texture"
phases = 4
[setting.texture-16]
kernel = "texture"
phases = 16
[setting.ten-bits]
qee_bits = 10
[setting.ten-bits-exact]
qee_bits = 10
normalisation = "exact"
[setting.slabs-1]
engine = "sheets"
slabs = 1
[setting.slabs-2]
engine = "sheets"
slabs = 2
[setting.slabs-3]
engine = "sheets"
slabs = 3
[setting.light-points-1]
engine = "sheets"
light_points = 1
phong = true
[setting.light-points-2]
engine = "sheets"
light_points = 2
phong = true
[setting.draft]
quality = "draft"
[setting.normal]
quality = "normal"
[setting.best]
quality = "best"
)";

namespace {

/// What reads each key of a section.
using Keys = std::map<std::string, Reader>;

std::optional<std::vector<double>> finite_numbers(const std::string& text) {
  auto numbers = parse_numbers(text);
  if (numbers && !std::all_of(numbers->begin(), numbers->end(), [](double v) { return std::isfinite(v); }))
    numbers.reset();
  return numbers;
}

Camera view_from(const std::string& text, const std::string& key) {
  const auto n = finite_numbers(text).value_or(std::vector<double>());
  if (n.size() < 2 || n.size() > 4) refuse_word(key, text, "give azimuth and elevation [roll [zoom]]");
  Camera camera{.azimuth = n[0], .elevation = n[1]};
  if (n.size() > 2) camera.roll = n[2];
  if (n.size() > 3) camera.zoom = n[3];
  return camera;
}

void add_sweep(std::string text, const std::string& key, std::vector<Camera>& views) {
  std::replace(text.begin(), text.end(), ':', ' ');
  const auto n = finite_numbers(text).value_or(std::vector<double>());
  if (n.size() != 3 || !(n[2] > 0) || !((n[1] - n[0]) / n[2] < 1e5))
    refuse_word(key, text, "give FROM:TO:STEP");
  for (int k = 0; n[0] + k * n[2] <= n[1] + 1e-9; ++k) views.push_back({.azimuth = n[0] + k * n[2]});
}

Keys keys_of(StudyList& list) {
  const auto set_size = [&list](const std::string& text, const std::string& key) {
    const Size size = parse_size(text, key);
    list.width = size.width;
    list.height = size.height;
  };
  const auto set_truths = [&list](const Words& words, const std::string& key) {
    list.truths.clear();
    for (const auto& name : words) list.truths.push_back(truth_from(name, key));
  };
  const auto add_views = [&list](const Words& words, const std::string& key) {
    for (const auto& view : words) list.views.push_back(view_from(view, key));
  };
  return {
      {"repetitions", value(list.repetitions, {1, 1'000'000})},
      {"error_pixels", value(list.error_pixels, {1, std::size_t(1) << 30})},
      {"seed", value(list.seed)},
      {"size", text(set_size)},
      {"truths", {.read = set_truths, .repeats = true}},
      {"views", {.read = add_views, .repeats = true}},
      {"sweep", text([&list](const auto& range, const auto& key) { add_sweep(range, key, list.views); })}};
}

/// Puts the options of those names among the keys.
void add_options(RenderOptions& o, std::initializer_list<const char*> those, Keys& keys) {
  OptionList list;
  for (const auto& add :
       {add_method_options, add_picture_options, add_shortcut_options, add_size_options, add_clip_options})
    add(list, o);
  for (const std::string name : those) {
    std::string option = "--" + name;
    std::replace(option.begin(), option.end(), '_', '-');
    keys[name] = list.find(option)->reader;
  }
}

Keys keys_of(StudyList::Scene& s) {
  Keys keys{{"synth", value(s.synth)},
            {"volume", value(s.options.volume.path)},
            {"dims", parsed(s.dims, parse_dims)},
            {"type", parsed(s.type, [](const auto& name, const auto&) { return scalar_type_from(name); })}};
  add_options(s.options, {"tf", "range", "opacity", "colours", "log", "interpolation", "clip"}, keys);
  return keys;
}

Keys keys_of(StudyList::Setting& s) {
  Shown& shown = s.options.frame.shown;
  Keys keys{{"opacity_correction", choice(shown.opacity_correction, {{"true", true}, {"false", false}})},
            {"phong", choice(shown.shading, {{"true", Shading::phong}, {"false", Shading::none}})}};
  add_options(s.options,
              {"radius", "kernel", "phases", "qee_bits", "normalisation", "region", "image_plane", "samples",
               "engine", "quality", "slabs", "light_points"},
              keys);
  return keys;
}

class ListReader {
 public:
  ListReader(const std::string& toml, std::string where) : where_(std::move(where)) {
    std::istringstream in(toml);
    try {
      items_ = CLI::ConfigTOML().from_config(in);
    } catch (const CLI::Error& e) {
      throw InputError(fmt::format("{} is no TOML: {}", where_, e.what()),
                       "ringsplat study --list shows a list that works");
    }
  }

  StudyList read() {
    for (const auto& item : items_)
      if (item.name != "++" && item.name != "--")  // CLI11's marks of a section's start and end
        take(item, keys_for(item));
    for (auto& s : list_.settings) settle(s);
    check();
    return list_;
  }

 private:
  Keys keys_for(const CLI::ConfigItem& item) {
    if (item.parents.empty()) return keys_of(list_);
    // What follows [scene. or [setting. may contain dots.
    const std::string kind = item.parents.front(),
                      name = joined({item.parents.begin() + 1, item.parents.end()}, ".");
    if (!name.empty() && kind == "scene") return keys_of(named(list_.scenes, name));
    if (!name.empty() && kind == "setting") return keys_of(named(list_.settings, name));
    wrong(item, "is in no section [scene.NAME] or [setting.NAME]");
  }

  void take(const CLI::ConfigItem& item, const Keys& keys) const {
    const auto key = keys.find(item.name);
    if (key == keys.end())
      wrong(item, "is no key of a " + (item.parents.empty() ? "study" : item.parents.front()));
    if (!key->second.repeats && item.inputs.size() != 1) wrong(item, "needs one value");
    try {
      key->second.read(item.inputs, item.fullname());
    } catch (const InputError& e) {
      throw InputError(fmt::format("{}: {}", where_, e.what()));
    }
  }

  [[noreturn]] void wrong(const CLI::ConfigItem& item, const std::string& problem) const {
    throw InputError(fmt::format("{}: {} {}", where_, item.fullname(), problem),
                     "ringsplat study --list shows what a list may say");
  }

  template <class T>
  static T& named(std::vector<T>& list, const std::string& name) {
    const auto found = std::find_if(list.begin(), list.end(), [&](const T& t) { return t.name == name; });
    if (found != list.end()) return *found;
    list.emplace_back();
    list.back().name = name;
    return list.back();
  }

  /// Throws InputError that names the setting when its keys contradict each other.
  void settle(StudyList::Setting& s) const {
    MethodOptions& method = s.options.method;
    FrameSpec& frame = s.options.frame;
    if (!method.engine && !method.quality) method.quality = Quality::paper;
    try {
      frame.how = method_for(method);
      frame.shown.transfer_function = preset("grey", {});  // any: scenes have their own
      ringsplat::check(frame);
      if (method.light_points && frame.shown.shading == Shading::none)
        throw InputError("light_points has no effect on what is not lit", "add phong = true");
    } catch (const InputError& e) {
      throw InputError(fmt::format("{}: setting {}: {}", where_, s.name, e.what()));
    }
  }

  void check() const {
    const std::string hint = "ringsplat study --list shows a list that works";
    if (list_.scenes.empty() || list_.settings.empty() || list_.views.empty() || list_.truths.empty())
      throw InputError(fmt::format("{} needs at least one scene, setting, view and truth", where_), hint);
    for (const auto& s : list_.scenes) {
      if (s.synth.empty() == s.options.volume.path.empty())
        throw InputError(fmt::format("{}: scene {} needs either synth or volume", where_, s.name), hint);
      if (!s.synth.empty()) static_cast<void>(synth_field(s.synth));
    }
    const bool analytic =
        std::find(list_.truths.begin(), list_.truths.end(), TruthKind::analytic) != list_.truths.end();
    for (const auto& s : list_.scenes)
      if (analytic && s.synth.empty())
        throw InputError(fmt::format("{}: scene {} is a file, which has no analytic truth", where_, s.name),
                         "leave out the truth \"analytic\"");
  }

  std::string where_;
  std::vector<CLI::ConfigItem> items_;
  StudyList list_;
};

}  // namespace

StudyList parse_study_list(const std::string& toml, const std::string& where) {
  return ListReader(toml, where).read();
}

}  // namespace ringsplat::app
