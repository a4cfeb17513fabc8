// The Python module ringsplat._core: what ringsplat/*.py stands on. Long work runs without the interpreter's
// lock.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "app/commands.hpp"
#include "base/clock.hpp"
#include "base/log.hpp"
#include "classify/colour_maps.hpp"
#include "formats/write.hpp"
#include "images/image_io.hpp"
#include "options/option_values.hpp"
#include "ringsplat/base/error.hpp"
#include "ringsplat/volume/source.hpp"
#include "session/render_frames.hpp"
#include "volume/scalars.hpp"
#include "words/block_session.hpp"
#include "words/picture.hpp"

namespace nb = nanobind;
using namespace ringsplat;
using namespace ringsplat::words;

namespace {

using Words = std::vector<std::string>;
using Three = std::array<double, 3>;

constexpr double seconds_between_polls = 0.03;

/// A volume in the caller's memory, which must outlive all that reads it.
struct ArrayVolume {
  Grid grid;
  const std::byte* first_voxel = nullptr;  ///< (0, 0, 0), a scalar in native byte order, aligned or not
  Strides strides;
  VolumeNotes notes;
};

class ArraySource final : public VolumeSource {
 public:
  explicit ArraySource(const ArrayVolume& volume) : volume_(volume) { check(volume.grid, "the array"); }
  const Grid& grid() const override { return volume_.grid; }
  bool concurrent() const override { return true; }
  VolumeNotes notes() const override { return volume_.notes; }

  void read_slices(int first, int count, std::span<std::byte> out) override {
    const glm::ivec3& dims = volume_.grid.dims;
    std::byte* to = out.data();
    for (int z = first; z < first + count; ++z)
      for (int y = 0; y < dims.y; ++y, to += row_bytes_)
        copy_row(scalar_, volume_.first_voxel + z * volume_.strides.z + y * volume_.strides.y,
                 volume_.strides.x, dims.x, to);
  }

 private:
  ArrayVolume volume_;
  std::size_t scalar_ = size_of(volume_.grid.type), row_bytes_ = scalar_ * std::size_t(volume_.grid.dims.x);
};

/// A function that throws what a signal's handler raised, KeyboardInterrupt after Ctrl-C.
std::function<void()> poll_now_and_then() {
  return [last = 0.0]() mutable {
    const double now = now_seconds();
    if (now - last < seconds_between_polls) return;
    last = now;
    const nb::gil_scoped_acquire lock;
    if (PyErr_CheckSignals() != 0) throw nb::python_error();
  };
}

/// `told`: a callable that outlives the hooks, or None.
Hooks hooks_of(nb::handle told) {
  Hooks hooks{poll_now_and_then(), {}};
  if (told.is_none()) return hooks;
  hooks.told = [told](const std::string& what, double done, double total) {
    const nb::gil_scoped_acquire lock;
    told(what, done, total);
  };
  return hooks;
}

glm::dvec3 to_vec(const Three& v) { return {v[0], v[1], v[2]}; }

Grid grid_of(const std::array<int, 3>& dims, const std::string& type, const Three& spacing,
             const Three& origin, const std::array<double, 9>& direction) {
  Grid grid;
  grid.dims = {dims[0], dims[1], dims[2]};
  grid.spacing = to_vec(spacing);
  grid.origin = to_vec(origin);
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      grid.direction[column][row] = direction[std::size_t(3 * row + column)];
  grid.type = scalar_type_from(type);
  return grid;
}

const std::byte* at_address(std::uintptr_t address) { return reinterpret_cast<const std::byte*>(address); }
Strides strides_of(const std::array<std::int64_t, 3>& xyz) { return {xyz[0], xyz[1], xyz[2]}; }

/// A picture's volume: an array or a file. The options say the rest.
void set_volume(app::VolumeOptions& options, const std::optional<ArrayVolume>& array,
                const std::string& name) {
  options.path = name;
  const VolumeChoice& choice = options.choice;
  const RawDescription& raw = options.raw;
  if (array && (choice.frame || !choice.channel.empty() || !choice.series.empty() || choice.memory ||
                choice.crop || raw.dims || raw.type || raw.big_endian || raw.offset))
    throw InputError("an array is a volume by itself, of which nothing is chosen as of a file",
                     "leave out frame, channel, series, memory, crop, dims, type, endian and offset");
  if (array)
    options.opener = [array = *array](const VolumeChoice&) { return std::make_unique<ArraySource>(array); };
}

std::vector<Picture> render(const Words& words, const std::vector<app::ViewAngles>& views,
                            const std::optional<ArrayVolume>& array, const std::string& name,
                            nb::handle told) {
  const nb::gil_scoped_release without;
  app::RenderOptions options = parse_picture(words, views, From::volume);
  set_volume(options.volume, array, name);
  return render_pictures(options, hooks_of(told));
}

app::MeasuredError measure_again(const Picture& picture, const Words& words,
                                 const std::optional<ArrayVolume>& array, const std::string& name,
                                 const std::string& truth, std::size_t pixels, std::uint64_t seed) {
  app::RenderOptions options = parse_picture(words, {}, From::volume);
  set_volume(options.volume, array, name);
  const app::ErrorOptions error{app::truth_from(truth, "truth"), pixels, seed};
  const nb::gil_scoped_release without;
  return measure(picture, options.volume, error, {poll_now_and_then(), {}});
}

/// Log lines go to a callable (level, text); levels are those of Python's logging.
void set_log(nb::object take) {
  if (take.is_none()) return set_log_sink({});
  set_log_sink([take = take.release()](LogLevel level, const std::string& text) {
    const nb::gil_scoped_acquire lock;
    constexpr int levels[] = {10, 20, 30, 40};
    take(levels[static_cast<int>(level)], text);
  });
}

int run_main(Words words) {
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  set_log_sink({});
  const nb::gil_scoped_release without;
  return app::run_program(int(words.size()), argv.data());
}

template <class Named>
std::vector<std::pair<std::string, std::string>> named(const std::vector<Named>& all) {
  return detail::mapped(
      all, [](const Named& one) { return std::pair<std::string, std::string>(one.name, one.description); });
}

void bind_pictures(nb::module_& m) {
  using Pixels = nb::ndarray<nb::numpy, const float, nb::shape<-1, -1, 4>>;
  using Depths = nb::ndarray<nb::numpy, const float, nb::shape<-1, -1>>;
  nb::class_<app::MeasuredError>(m, "MeasuredError")
      .def_prop_ro("truth", [](const app::MeasuredError& e) { return app::name(e.truth); })
      .def_prop_ro("rms", [](const app::MeasuredError& e) { return e.error.rmse; })
      .def_prop_ro("interval",
                   [](const app::MeasuredError& e) { return std::pair(e.error.rmse_low, e.error.rmse_high); })
      .def_prop_ro("max", [](const app::MeasuredError& e) { return e.error.largest; })
      .def_prop_ro("mean", [](const app::MeasuredError& e) { return e.error.mean; })
      .def_prop_ro("pixels", [](const app::MeasuredError& e) { return e.error.pixels; })
      .def_prop_ro("seed", [](const app::MeasuredError& e) { return e.seed; })
      .def_prop_ro("seconds", [](const app::MeasuredError& e) { return e.seconds; })
      .def("__str__", [](const app::MeasuredError& e) { return app::to_text(e); });
  nb::class_<Picture>(m, "Picture")
      .def_prop_ro("width", [](const Picture& p) { return p.image.width; })
      .def_prop_ro("height", [](const Picture& p) { return p.image.height; })
      .def_ro("seconds", &Picture::seconds)
      .def_ro("settings", &Picture::settings)
      .def_ro("error", &Picture::error)
      .def(
          "pixels",
          [](nb::handle self) {
            const auto& p = nb::cast<const Picture&>(self);
            return Pixels(p.image.rgba.data(), {std::size_t(p.image.height), std::size_t(p.image.width), 4},
                          self);
          },
          nb::rv_policy::reference)
      .def(
          "depth",
          [](nb::handle self) {
            const Image& image = nb::cast<const Picture&>(self).image;
            const std::size_t rows = image.depth.empty() ? 0 : std::size_t(image.height);
            return Depths(image.depth.data(), {rows, std::size_t(image.width)}, self);
          },
          nb::rv_policy::reference)
      .def("display",
           [](const Picture& p) {
             const auto bytes = display_bytes(p.image, p.background, p.overlay);
             return nb::bytes(bytes.data(), bytes.size());
           })
      .def("png",
           [](const Picture& p) {
             const Bytes bytes = image_bytes(p.image, ".png", p.background, p.settings, p.overlay);
             return nb::bytes(bytes.data(), bytes.size());
           })
      .def("save", [](const Picture& p, const std::string& file) {
        const nb::gil_scoped_release without;
        write_image(p.image, file, p.background, p.settings, p.overlay);
      });
}

/// Those that _mpi has connected, or this process alone for None.
Processes processes_of(nb::handle capsule) {
  if (capsule.is_none()) return {};
  auto* processes = static_cast<Processes*>(PyCapsule_GetPointer(capsule.ptr(), "ringsplat.Processes"));
  if (processes == nullptr) throw nb::python_error();
  return std::move(*processes);
}

nb::class_<BlockSession> bind_blocks(nb::module_& m) {
  return nb::class_<BlockSession>(m, "BlockSession")
      .def(
          "__init__",
          [](BlockSession* self, nb::handle capsule, const Words& layout, int threads, double stall_timeout,
             int visualisation_ranks, const std::string& problem) {
            const SessionOptions options{.threads_per_rank = threads,
                                         .stall_timeout = stall_timeout,
                                         .poll = poll_now_and_then(),
                                         .visualisation_ranks = visualisation_ranks};
            new (self) BlockSession(processes_of(capsule), layout, options, problem);
          },
          nb::arg("processes").none(), nb::arg("layout"), nb::arg("threads"), nb::arg("stall_timeout"),
          nb::arg("visualisation_ranks"), nb::arg("problem"))
      .def_prop_ro("rank", [](BlockSession& s) { return s.session().rank(); })
      .def_prop_ro("ranks", [](BlockSession& s) { return s.session().ranks(); })
      .def_prop_ro("visualises", [](BlockSession& s) { return s.session().visualises(); })
      .def("set_grid", [](BlockSession& s, const ArrayVolume& like) { s.set_grid(like.grid, like.notes); })
      .def("add_block",
           [](BlockSession& s, const std::array<int, 3>& first, const std::array<int, 3>& end,
              std::uintptr_t address, const std::array<std::int64_t, 3>& strides) {
             return s.session().add_block({{first[0], first[1], first[2]}, {end[0], end[1], end[2]}},
                                          at_address(address), strides_of(strides));
           })
      .def(
          "update_block",
          [](BlockSession& s, int block, std::uintptr_t address, const std::array<std::int64_t, 3>& strides) {
            s.session().update_block(block, at_address(address), strides_of(strides));
          })
      .def("clear_blocks", [](BlockSession& s) { s.session().clear_blocks(); })
      .def("note_problem", [](BlockSession& s, const std::string& problem) {
        SessionParts::note_problem(s.session(), problem);
      });
}

void bind_session(nb::module_& m) {
  const auto without_lock = nb::call_guard<nb::gil_scoped_release>();
  bind_blocks(m)
      .def("commit", &BlockSession::commit, without_lock)
      .def(
          "range",
          [](BlockSession& s) {
            const ValueRange range = s.session().range();
            return std::array{range.low, range.high};
          },
          without_lock)
      .def(
          "render",
          [](BlockSession& s, const Words& words, const std::vector<app::ViewAngles>& views,
             nb::handle told) {
            const nb::gil_scoped_release without;
            return s.render(words, views, hooks_of(told));
          },
          nb::arg("words"), nb::arg("views"), nb::arg("told").none())
      .def(
          "serve",
          [](BlockSession& s, const Words& words, const std::string& name, const std::string& address,
             int port, double share, const Words& hosts, const Words& origins, const Words& frames) {
            return s.serve(words, {.name = name,
                                   .address = address,
                                   .port = port,
                                   .allowed_hosts = hosts,
                                   .allowed_origins = origins,
                                   .allowed_frames = frames,
                                   .share = share});
          },
          without_lock)
      .def("act", &BlockSession::act, without_lock)
      .def("offer", &BlockSession::offer, nb::arg("name"), nb::arg("value"), nb::arg("low"), nb::arg("high"),
           nb::arg("choices").none())
      .def("show", &BlockSession::show, without_lock)
      .def(
          "visualise", [](BlockSession& s) { s.live().visualise(); }, without_lock);
}

}  // namespace

NB_MODULE(_core, m) {
  m.doc() = "What the package ringsplat stands on. Not for users.";
  m.attr("__version__") = RINGSPLAT_VERSION;
  nb::exception<InputError>(m, "InputError", PyExc_ValueError).doc() =
      "What was asked for cannot be drawn: a bad option, a volume that cannot be read.";
  nb::exception<RunError>(m, "RunError", PyExc_RuntimeError).doc() =
      "Something failed while running: a rank, the disk, memory.";
  nb::class_<ArrayVolume>(m, "ArrayVolume")
      .def("__init__", [](ArrayVolume* self, std::uintptr_t address, const std::array<int, 3>& dims,
                          const std::array<std::int64_t, 3>& strides, const std::string& type,
                          const Three& spacing, const Three& origin, const std::array<double, 9>& direction,
                          const std::string& unit, const std::string& quantity) {
        new (self) ArrayVolume{grid_of(dims, type, spacing, origin, direction),
                               at_address(address),
                               strides_of(strides),
                               {.unit = unit, .quantity = quantity}};
      });
  m.def("write_volume", [](const ArrayVolume& volume, const std::string& path) {
    ArraySource source(volume);
    const nb::gil_scoped_release without;
    write_volume(source, path, false, volume.notes.world);
  });
  bind_pictures(m);
  bind_session(m);
  m.def("render", &render, nb::arg("words"), nb::arg("views"), nb::arg("array").none(), nb::arg("name"),
        nb::arg("told").none());
  m.def("measure", &measure_again, nb::arg("picture"), nb::arg("words"), nb::arg("array").none(),
        nb::arg("name"), nb::arg("truth"), nb::arg("pixels"), nb::arg("seed"));
  m.def("picture_options_json", &picture_options_json);
  m.def("presets", [] { return named(preset_names()); });
  m.def("colour_maps", [] { return named(colour_map_names()); });
  m.def("likely_option", &app::likely_option,
        "\"did you mean size?\" for an unknown option, or an empty text.");
  m.def("set_log", &set_log, nb::arg("take").none());
  m.def("main", &run_main);
}
