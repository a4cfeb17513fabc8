#include "study/study_list.hpp"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "base/text.hpp"
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
    for (const auto& item : items_) {
      if (item.name == "++" || item.name == "--") continue;  // CLI11's marks of a section's start and end
      const std::string kind = item.parents.empty() ? "" : item.parents.front();
      if (item.parents.empty())
        top_level(item);
      else if (kind == "scene" && item.parents.size() > 1)
        scene(item, named(list_.scenes, name_of(item)));
      else if (kind == "setting" && item.parents.size() > 1)
        setting(item, named(list_.settings, name_of(item)));
      else
        wrong(item, "is in no section [scene.NAME] or [setting.NAME]");
    }
    for (auto& s : list_.settings) settle(s);
    check();
    return list_;
  }

 private:
  /// The name after [scene. or [setting. ; it may contain dots.
  static std::string name_of(const CLI::ConfigItem& item) {
    return joined({item.parents.begin() + 1, item.parents.end()}, ".");
  }

  [[noreturn]] void wrong(const CLI::ConfigItem& item, const std::string& problem) const {
    throw InputError(fmt::format("{}: {} {}", where_, item.fullname(), problem),
                     "ringsplat study --list shows what a list may say");
  }
  std::string text(const CLI::ConfigItem& item) const {
    if (item.inputs.size() != 1) wrong(item, "needs one value");
    return item.inputs.front();
  }
  double number(const CLI::ConfigItem& item, const std::string& word) const {
    double value = 0;
    if (!CLI::detail::lexical_cast(word, value) || !std::isfinite(value))
      wrong(item, fmt::format("is '{}', not a number", word));
    return value;
  }
  std::vector<double> numbers(const CLI::ConfigItem& item, const std::string& words) const {
    std::vector<double> all;
    for (const std::string& word : detail::words_of(words)) all.push_back(number(item, word));
    return all;
  }

  int count(const CLI::ConfigItem& item, double least, double most) const {
    const double value = number(item, text(item));
    if (!(value >= least && value <= most) || value != std::floor(value))
      wrong(item, fmt::format("is {}, not a whole number from {} to {}", text(item), least, most));
    return static_cast<int>(value);
  }
  bool flag(const CLI::ConfigItem& item) const {
    const std::string word = text(item);
    if (word != "true" && word != "false") wrong(item, fmt::format("is '{}', neither true nor false", word));
    return word == "true";
  }

  /// Reads a key as the option of that name, if it is one of `those`.
  bool option(const CLI::ConfigItem& item, RenderOptions& o,
              std::initializer_list<std::string_view> those) const {
    if (std::find(those.begin(), those.end(), item.name) == those.end()) return false;
    OptionList list;
    for (const auto& add :
         {add_method_options, add_picture_options, add_shortcut_options, add_size_options, add_clip_options})
      add(list, o);
    std::string name = "--" + item.name;
    std::replace(name.begin(), name.end(), '_', '-');
    list.find(name)->reader.read({text(item)}, item.fullname());
    return true;
  }

  template <class T>
  static T& named(std::vector<T>& list, const std::string& name) {
    const auto found = std::find_if(list.begin(), list.end(), [&](const T& t) { return t.name == name; });
    if (found != list.end()) return *found;
    list.emplace_back();
    list.back().name = name;
    return list.back();
  }

  void top_level(const CLI::ConfigItem& item) {
    if (item.name == "repetitions")
      list_.repetitions = count(item, 1, 1e6);
    else if (item.name == "error_pixels")
      list_.error_pixels = std::size_t(count(item, 1, 1 << 30));
    else if (item.name == "seed")
      list_.seed = std::uint64_t(count(item, 0, 1 << 30));
    else if (item.name == "size") {
      const Size size = parse_size(text(item), item.name);
      list_.width = size.width;
      list_.height = size.height;
    } else if (item.name == "truths") {
      list_.truths.clear();
      for (const auto& name : item.inputs) list_.truths.push_back(truth_from(name, "truths"));
    } else if (item.name == "views") {
      for (const auto& view : item.inputs) list_.views.push_back(view_of(item, view));
    } else if (item.name == "sweep") {
      sweep(item);
    } else {
      wrong(item, "is no key of a study");
    }
  }

  Camera view_of(const CLI::ConfigItem& item, const std::string& words) const {
    const std::vector<double> values = numbers(item, words);
    if (values.size() < 2 || values.size() > 4)
      wrong(item, fmt::format("has '{}', not azimuth and elevation [roll [zoom]]", words));
    Camera camera{.azimuth = values[0], .elevation = values[1]};
    if (values.size() > 2) camera.roll = values[2];
    if (values.size() > 3) camera.zoom = values[3];
    return camera;
  }

  void sweep(const CLI::ConfigItem& item) {
    std::string words = text(item);
    std::replace(words.begin(), words.end(), ':', ' ');
    const std::vector<double> values = numbers(item, words);
    if (values.size() != 3 || !(values[2] > 0) || !((values[1] - values[0]) / values[2] < 1e5))
      wrong(item, "is not FROM:TO:STEP");
    for (int k = 0; values[0] + k * values[2] <= values[1] + 1e-9; ++k)
      list_.views.push_back({.azimuth = values[0] + k * values[2]});
  }

  void scene(const CLI::ConfigItem& item, StudyList::Scene& s) const {
    if (item.name == "synth")
      s.synth = text(item);
    else if (item.name == "volume")
      s.options.volume.path = text(item);
    else if (item.name == "dims")
      s.dims = parse_dims(text(item), item.fullname());
    else if (item.name == "type")
      s.type = scalar_type_from(text(item));
    else if (!option(item, s.options, {"tf", "range", "opacity", "colours", "log", "interpolation", "clip"}))
      wrong(item, "is no key of a scene");
  }

  void setting(const CLI::ConfigItem& item, StudyList::Setting& s) const {
    auto& shown = s.options.frame.shown;
    if (item.name == "opacity_correction")
      shown.opacity_correction = flag(item);
    else if (item.name == "phong")
      shown.shading = flag(item) ? Shading::phong : Shading::none;
    else if (!option(item, s.options,
                     {"radius", "kernel", "phases", "qee_bits", "normalisation", "region", "image_plane",
                      "samples", "engine", "quality", "slabs", "light_points"}))
      wrong(item, "is no key of a setting");
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
