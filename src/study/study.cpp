#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <tuple>
#include <type_traits>
#include <variant>

#include "base/median.hpp"
#include "base/output_file.hpp"
#include "frame/frame_fields.hpp"
#include "images/image_io.hpp"
#include "options/option_values.hpp"
#include "options/transfer_function_option.hpp"
#include "program/progress.hpp"
#include "program/text_output.hpp"
#include "session/render_frames.hpp"
#include "study/commands.hpp"
#include "study/error_budget.hpp"
#include "study/study_list.hpp"
#include "volume/synth.hpp"

namespace ringsplat::app {
namespace {

namespace fs = std::filesystem;

/// One setting's frames of one view: the last, and the seconds of all.
struct Timed {
  FrameResult last;
  std::vector<double> seconds;
};

std::unique_ptr<VolumeSource> open_scene(const StudyList::Scene& s) {
  if (s.synth.empty()) return open_volume(s.options.volume);
  Grid grid;
  grid.dims = s.dims;
  grid.type = s.type;
  return synth_source(s.synth, grid);
}

FrameSpec frame_of(const StudyList& list, const StudyList::Setting& setting, const MadeFunction& made) {
  FrameSpec spec = setting.options.frame;
  spec.shown.width = list.width;
  spec.shown.height = list.height;
  made.set(spec.shown);
  check(spec);
  return spec;
}

/// Renders every view as often as the list says, one frame at a time, in this process.
std::vector<Timed> render_views(const StudyList& list, const StudyList::Scene& s, const FrameSpec& spec) {
  SoloCollectives solo;
  const Wiring wiring{solo};
  const Layout layout{1, 1};
  OpenedVolume volume = open_everywhere(solo, [&] { return open_scene(s); });
  LoadOptions load = needed_to_render(spec, volume.grid);
  load.kept_axes = needed_axes(spec, list.views, volume.grid);
  Scene scene = load_scene(volume, load, layout, wiring);
  std::vector<Timed> timed(list.views.size());
  std::vector<Camera> cameras;
  for (int k = 0; k < list.repetitions; ++k)
    cameras.insert(cameras.end(), list.views.begin(), list.views.end());
  const auto take = [&](FrameResult&& result) {
    Timed& t = timed[std::size_t(result.spec.frame) % list.views.size()];
    t.seconds.push_back(result.stats.seconds);
    t.last = std::move(result);
  };
  ProtocolOptions protocol;
  protocol.frames_in_flight = 1;  // so that a frame's time is its own
  render_frames(std::move(scene), layout, protocol, director_of(frames_of(spec, cameras), take), wiring);
  return timed;
}

/// Makes columns of a method's fields, or empty ones.
struct Columns {
  nlohmann::ordered_json& row;
  bool empty;
  std::string within = {};  ///< the field whose fields these are

  template <class T>
  void operator()(const std::string& field, const T& value) const {
    // A kernel's method is the kernel itself.
    const std::string column = field == "method" ? within : field;
    if constexpr (HasFields<const T>)
      fields(value, Columns{row, empty, field});
    else if (empty)
      row.emplace(column, nullptr);
    else if constexpr (std::is_enum_v<T>)
      row[column] = name(value);
    else
      row[column] = value;
  }
};

/// A row's columns that say how it is drawn; what only the other engine has is null.
nlohmann::ordered_json columns_of(const Method& method) {
  nlohmann::ordered_json row{{"engine", name(method)}};
  for (const Method& any : {Method(Splats{}), Method(Sheets{})})
    std::visit([&row](const auto& how) { fields(how, Columns{row, true}); }, any);
  std::visit([&row](const auto& how) { fields(how, Columns{row, false}); }, method);
  return row;
}

/// Files of a measurement, relative to the folder; empty when they are not kept.
struct KeptPictures {
  std::string picture, truth;
};

nlohmann::ordered_json row_of(const StudyList::Scene& s, const StudyList::Setting& setting,
                              Interpolation interpolation, const Camera& camera, const Timed& timed,
                              TruthKind truth, const truth::SampledError& error, const KeptPictures& kept) {
  const NodeStats sum = timed.last.stats.total();
  nlohmann::ordered_json row{{"scene", s.name}, {"setting", setting.name}};
  const FrameSpec& frame = setting.options.frame;
  row.update(columns_of(frame.how));
  row.update({{"opacity_correction", frame.shown.opacity_correction},
              {"phong", frame.shown.shading == Shading::phong},
              {"interpolation", name(interpolation)},
              {"azimuth", camera.azimuth},
              {"elevation", camera.elevation},
              {"roll", camera.roll},
              {"zoom", camera.zoom},
              {"axis", std::string(1, name(timed.last.axis))},
              {"seconds", median(timed.seconds)},
              {"frames", timed.seconds.size()},
              {"splats", sum.splats_sent},
              {"bytes", sum.payload_bytes_sent},
              {"truth", to_string(truth)},
              {"pixels", error.pixels},
              {"rmse", error.rmse},
              {"rmse_low", error.rmse_low},
              {"rmse_high", error.rmse_high},
              {"largest", error.largest},
              {"mean", error.mean},
              {"picture", kept.picture},
              {"truth_picture", kept.truth}});
  return row;
}

std::string to_csv(const nlohmann::ordered_json& rows) {
  std::vector<std::string> lines, names;
  for (const auto& [key, value] : rows.at(0).items()) names.push_back(key);
  lines.push_back(joined(names, ","));
  for (const auto& row : rows) {
    std::vector<std::string> cells;
    for (const auto& value : row)
      cells.push_back(value.is_string() ? value.get<std::string>()
                      : value.is_null() ? ""
                                        : plain_json_text(value));
    lines.push_back(joined(cells, ","));
  }
  return joined(lines, "\n") + "\n";
}

/// Turns a list's name into a file name: only letters, digits, dots, dashes and underscores.
std::string as_file_name(std::string name) {
  const auto harmless = [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '.' || c == '-' || c == '_';
  };
  std::replace_if(
      name.begin(), name.end(), [&](char c) { return !harmless(static_cast<unsigned char>(c)); }, '-');
  return name.front() == '.' ? "-" + name : name;
}

std::string file_of(const std::string& scene, const std::string& name, std::size_t view) {
  return fmt::format("{}/{}-{}.png", as_file_name(scene), as_file_name(name), view);
}

void make_folder(const fs::path& folder) {
  std::error_code failed;
  fs::create_directories(folder, failed);
  if (failed || !fs::is_directory(folder))
    throw InputError(fmt::format("the folder {} cannot be made: {}", folder.string(), failed.message()),
                     "give --keep-images a folder that can be written");
}

void write_picture(const Image& image, const fs::path& file) {
  make_folder(file.parent_path());
  write_image(image, file, glm::dvec3(0.0), {});
}

/// One scene under all settings. The field's and the formula's truths do not depend on the kernel, so they
/// are evaluated once for each view and shading, where the first setting's picture differs most. The method's
/// truth is evaluated for each setting.
class SceneStudy {
 public:
  SceneStudy(const StudyList& list, const StudyList::Scene& s, const fs::path& folder)
      : list_(list), scene_list_(s), folder_(folder) {
    WholeVolume volume = read_whole(*open_scene(s));
    made_ = TransferFunctionChoice(s.options.transfer_function, s.options.colour)
                .make(volume.statistics, volume.scene.grid);
    scene_ = std::move(volume.scene);
  }

  void run(const StudyList::Setting& setting, nlohmann::ordered_json& rows) {
    FrameSpec spec = frame_of(list_, setting, made_);
    spec.shown.clip = clip_box(scene_list_.options.clip, scene_.grid);
    const auto timed = render_views(list_, scene_list_, spec);
    for (std::size_t v = 0; v < list_.views.size(); ++v)
      for (const TruthKind kind : list_.truths) {
        const auto truth = truth_of(timed[v].last.image, kind, spec, v);
        const auto error = truth::sampled_error(timed[v].last.image, truth->sample, truth->colours);
        rows.push_back(row_of(scene_list_, setting, made_.interpolation, list_.views[v], timed[v], kind,
                              error, keep(setting, spec, timed[v], kind, v)));
      }
  }

 private:
  Evaluation show(TruthKind kind, const FrameSpec& spec, std::size_t view) {
    scene_.frame = spec;
    scene_.frame.shown.camera = list_.views[view];
    return {.truth = kind, .formula = scene_list_.synth};
  }

  /// Pictures of a measurement for --keep-images, as a display shows them. The method's truth looks like the
  /// picture itself, so it is not kept.
  KeptPictures keep(const StudyList::Setting& setting, const FrameSpec& spec, const Timed& timed,
                    TruthKind kind, std::size_t view) {
    if (folder_.empty() || kind == TruthKind::method) return {};
    const std::string name =
        "truth-" + to_string(kind) + (spec.shown.shading == Shading::phong ? "-phong" : "");
    const KeptPictures kept{file_of(scene_list_.name, setting.name, view),
                            file_of(scene_list_.name, name, view)};
    write_picture(timed.last.image, folder_ / kept.picture);
    if (truths_.insert(kept.truth).second) {
      const Evaluation whole = show(kind, spec, view);
      const auto colours = evaluate(scene_, whole, truth::all_pixels(list_.width, list_.height));
      write_picture(truth::to_image(list_.width, list_.height, colours), folder_ / kept.truth);
    }
    return kept;
  }

  std::shared_ptr<const SampledTruth> truth_of(const Image& image, TruthKind kind, const FrameSpec& spec,
                                               std::size_t view) {
    const auto sampled = [&] {
      const Evaluation evaluation = show(kind, spec, view);
      return std::make_shared<const SampledTruth>(
          sample_truth(image, scene_, evaluation, list_.error_pixels, list_.seed));
    };
    if (kind == TruthKind::method) return sampled();
    auto& known = known_[std::tuple(kind, spec.shown.shading, view)];
    if (!known) known = sampled();
    return known;
  }

  const StudyList& list_;
  const StudyList::Scene& scene_list_;
  const fs::path folder_;         ///< of the kept pictures; empty: none is kept
  std::set<std::string> truths_;  ///< whose pictures are written
  MadeFunction made_;
  truth::Scene scene_;
  std::map<std::tuple<TruthKind, Shading, std::size_t>, std::shared_ptr<const SampledTruth>> known_;
};

std::string list_text(const StudyOptions& o) {
  if (o.list.empty()) return default_study_list;
  std::ifstream in(o.list, std::ios::binary);
  if (!in)
    throw InputError(fmt::format("there is no list {}", o.list),
                     "ringsplat study --list shows one that works");
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace

ExitCode run_study(const StudyOptions& o) {
  if (o.show_list) {
    write_text_output("-", default_study_list);
    return ExitCode::done;
  }
  const StudyList list = parse_study_list(list_text(o), o.list.empty() ? "the default list" : o.list);
  if (fs::path(o.output).extension() != ".csv")
    throw InputError(fmt::format("-o '{}' does not name a .csv file", o.output), "for instance -o study.csv");
  const fs::path json_file = fs::path(o.output).replace_extension(".json");
  check_can_write(o.output, "-o");
  check_can_write(json_file, "-o's JSON");
  if (!o.pictures.empty()) make_folder(o.pictures);
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  Progress progress;
  progress.begin("measuring", double(list.scenes.size() * list.settings.size()));
  std::size_t done = 0;
  for (const auto& s : list.scenes) {
    SceneStudy study(list, s, o.pictures);
    for (const auto& setting : list.settings) {
      study.run(setting, rows);
      progress.at(double(++done));
    }
  }
  progress.end();
  write_texts({{o.output, to_csv(rows)}, {json_file, plain_json_text(rows, 1) + "\n"}});
  progress.print(fmt::format("{}  {} measurements", o.output, rows.size()));
  return ExitCode::done;
}

}  // namespace ringsplat::app
