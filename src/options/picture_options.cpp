#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <string>
#include <tuple>
#include <type_traits>

#include "frame/frame_fields.hpp"
#include "options/option_tables.hpp"
#include "options/option_values.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::app {
namespace {

/// As many numbers as the target has.
template <class T>
Reader all_of(T& target) {
  constexpr std::size_t count = sizeof(ValueOf<T>) / sizeof(double);
  const auto read = [&target](const Words& words, const std::string& option) {
    ValueOf<T> value{};
    for (std::size_t k = 0; k < count; ++k) (&value[0])[k] = read_number<double>(words[k], option);
    target = value;
  };
  return {"FLOAT", read, int(count)};
}

/// A number whose default is shown as "1/512".
Reader one_part(double& target) {
  Reader reader = value(target);
  reader.initial = fmt::format("1/{:g}", 1 / target);
  return reader;
}

/// Of a slice that is given as plane:NX,NY,NZ,D; nothing where an axis is.
std::optional<ClipPlane> oblique_plane(const std::string& slice, const std::string& option) {
  constexpr std::string_view plane = "plane:";
  if (!slice.starts_with(plane)) return std::nullopt;
  return parse_clip_plane(slice.substr(plane.size()), option + " plane:");
}

/// With plane and samples, which both methods have; a method on the screen has no samples.
template <class How>
How placed(How how, const MethodOptions& o) {
  how.image_plane = o.image_plane.value_or(how.image_plane);
  const double samples = how.image_plane == ImagePlane::screen ? 1 : o.samples.value_or(how.plane_samples);
  constexpr bool whole = std::is_integral_v<decltype(how.plane_samples)>;
  if (whole && !(samples == std::floor(samples) && std::abs(samples) < 1e6))
    throw InputError(fmt::format("--samples cannot be {} with splats", samples),
                     "use 1, 2 or 4 pixels a voxel, or --engine sheets");
  how.plane_samples = static_cast<decltype(how.plane_samples)>(samples);
  return how;
}

}  // namespace

void add_series_options(OptionList& list, RenderOptions& o) {
  list.below("Volume") += {
      {"--frames", "A:B[:STEP]|all", nullptr,
       "The volumes of a series, from A to before B, or all; VOLUME is a file with several time points, or a "
       "quoted pattern: 'step_*.nrrd', counted from 0, or step_%04d.nrrd, with the names' own numbers",
       parsed(o.frames, parse_frames)},
  };
}

void add_render_output_options(OptionList& list, RenderOptions& o) {
  list.below("Output") += {
      {"-o,--output", "FILE", nullptr,
       "The picture: .png (sRGB), .exr (linear float), .tif .jpg .tga; of many views also .mp4, a film by "
       "ffmpeg; not needed with --stats or --count-only",
       value(o.output), Mark::of_program},
      {"--background", "COLOUR", "none", "A name, #rrggbb or r,g,b from 0 to 1; makes the picture opaque",
       parsed(o.background, parse_colour)},
      {"--annotate", nullptr, nullptr, "Draws orientation, a scale bar and a colour bar into the picture",
       flag(o.annotate)},
      {"--stats", "FILE", nullptr,
       "What each node did in each frame, as JSON; one array, or lines in a .jsonl; as a .txt, or the word "
       "table for one on stdout, what each rank did in all; of --stats, --trace and --tf-out one may be -, "
       "stdout, and lines of results then go to stderr",
       text([&o](const std::string& file, const std::string&) {
         o.stats_as_table = file == "table" || file.ends_with(".txt");
         o.stats = file == "table" ? "-" : file;
       }),
       Mark::of_program},
      {"--trace", "FILE", nullptr,
       "What each node did when, as Chrome trace-event JSON, which opens in Perfetto", value(o.trace),
       Mark::of_program},
  };
}

void add_clip_options(OptionList& list, RenderOptions& o) {
  list.below("Volume") += {
      {"--clip", "X0:X1,Y0:Y1,Z0:Z1", nullptr,
       "Only these voxels, as if the rest were cut off; from the first to before the last; an empty part or "
       "end means up to the face; of a pyramid in voxels of the finest level; with mm behind a part, or "
       "behind "
       "all, distances from the first face in the file's units",
       parsed(o.clip, parse_clip)},
      {"--clip-plane", "NX,NY,NZ,D[:...]", nullptr,
       "What lies behind a plane, or one of four, is cut off: a world direction to what is left, and how far "
       "along it the plane is from the volume's middle, in world lengths",
       parsed(o.frame.shown.clip_planes, parse_clip_planes), Mark::of_sheets},
      {"--slice", "AXIS=PLACE|plane:NX,NY,NZ,D", nullptr,
       "Show one slice, as x=40, z=12.5mm or an oblique plane, from straight before it: its values in grey "
       "or in --tf's colours; with --values as numbers",
       text([&o](const std::string& slice, const std::string& option) {
         o.colour.mode = Mode::mip;
         o.colour.slice = true;
         const auto plane = oblique_plane(slice, option);
         o.oblique_slice = plane.has_value();
         if (plane)
           o.frame.shown.clip_planes = {*plane};
         else
           std::tie(o.clip, o.slice) = parse_slice(slice, option);
       })},
  };
}

void add_camera_options(OptionList& list, RenderOptions& o) {
  list.below("View") += {
      {"--view", "SIDE", nullptr,
       "Seen from the front, back, left, right, top or bottom; without any such option a patient from the "
       "front, a flat volume from its broad side, all else from azimuth 30 and elevation 20",
       choice(o.side, named({Side::front, Side::back, Side::left, Side::right, Side::top, Side::bottom}))},
      {"--azimuth", nullptr, initial, "Degrees the viewer walks around to the right: 0 is in front",
       value(o.frame.shown.camera.azimuth)},
      {"--elevation", nullptr, initial, "Degrees the viewer climbs: 90 looks straight down, -90 up",
       value(o.frame.shown.camera.elevation)},
      {"--roll", nullptr, initial, "Degrees the picture is turned clockwise",
       value(o.frame.shown.camera.roll)},
      {"--zoom", nullptr, initial, "1 fits the volume to the image", value(o.frame.shown.camera.zoom)},
  };
}

void add_view_options(OptionList& list, RenderOptions& o) {
  list.below("View") += {
      {"--fit", nullptr, nullptr,
       "What --zoom 1 fits to the image: the volume's box as it is seen, or its bounding sphere, whose size "
       "does not change as the volume turns; without it the sphere for --orbit and --path, else the box",
       choice(o.fit, {{"box", Fit::box}, {"sphere", Fit::sphere}})},
      {"--matrix", "M11 ... M34", nullptr,
       "World to screen instead, 3 rows of 4: pixels right, pixels down, pixels of depth",
       all_of(o.frame.shown.camera.matrix)},
      {"--pan", "RIGHT DOWN", "0 0", "Moves the picture, in lengths of its shorter side",
       all_of(o.frame.shown.camera.pan)},
      {"--projection", nullptr, initial, "How the volume is seen; perspective needs sheets",
       choice(o.frame.shown.camera.fov, {{"orthographic", 0.0}, {"perspective", 40.0}})},
      {"--fov", "DEGREES", "40", "Field of view of the picture's shorter side, 0.01 to 179, in perspective",
       value(o.frame.shown.camera.fov)},
      {"--distance", "RADII", nullptr,
       "From the eye to the volume's centre, in radii of its bounding sphere, in perspective; else so that "
       "the volume fits the field of view",
       value(o.frame.shown.camera.distance)},
      {"--eye", "X Y Z", nullptr, "World position of the eye, instead of the angles and the distance",
       all_of(o.frame.shown.camera.eye)},
      {"--target", "X Y Z", nullptr,
       "World position that the picture shows in its middle, instead of the volume's centre",
       all_of(o.frame.shown.camera.target)},
      {"--up", "X Y Z", "0 0 1", "World direction that points up in the picture, with --eye",
       all_of(o.frame.shown.camera.up)},
      {"--orbit", "N", nullptr, "N frames once around, from --azimuth on, into OUT-0000.png ...",
       value(o.orbit, {1, 1'000'000}), Mark::of_program},
      {"--path", "FILE", nullptr,
       "A frame for each line of FILE: azimuth, elevation, roll, zoom, with commas or blanks, or as JSON; -: "
       "stdin",
       value(o.path), Mark::of_program},
  };
}

void add_size_options(OptionList& list, RenderOptions& o) {
  list.below("Picture") += {
      {"--size", "WxH", "512x512", "Pixels of the image",
       text([&o](const std::string& word, const std::string& option) {
         const glm::ivec2 size = parse_size(word, option);
         o.frame.shown.width = size.x;
         o.frame.shown.height = size.y;
       })},
      {"--no-opacity-correction", nullptr, nullptr,
       "Take opacities per slice, whatever the distance between slices along the ray",
       flag(o.frame.shown.opacity_correction, false)},
      {"--light", "X Y Z", "-0.4 0.6 0.7", "Direction to the light in the picture: right, up, to the viewer",
       all_of(o.frame.shown.light)},
      {"--tf", "NAME|FILE", initial, "Transfer function: a preset (info --presets) or a ParaView JSON file",
       value(o.transfer_function)},
  };
  list.below("Colours") += {
      {"--range", "LO:HI", nullptr,
       "Window of values that the transfer function spans; a preset or a file is stretched onto it",
       parsed(o.colour.range, parse_window)},
      {"--tf2d", "G0:G1", nullptr,
       "Show boundaries: opacity goes by the gradient's magnitude, too, in values over world lengths; "
       "nothing is left of it up to G0, all of it from G1 on",
       text([&o](const std::string& window, const std::string& option) {
         const DataRange range = parse_window(window, option);
         o.frame.shown.edges = EdgeOpacity{range.low, range.high};
       }),
       Mark::of_sheets},
      {"--opacity", "F", "1", "Makes the volume so many times as dense: 2 thicker, 0.5 thinner",
       parsed(o.colour.opacity,
              [](const std::string& text, const std::string& option) {
                return parse_positive(text, option, "for instance --opacity 2, for a picture twice as dense");
              })},
      {"--colours", "NAME", nullptr,
       "A colour map instead of the transfer function's own colours; list: shows the names",
       value(o.colour.colours)},
      {"--log", nullptr, nullptr,
       "Colours and opacities on a logarithmic axis of the positive values; all others are clear",
       flag(o.colour.log)},
      {"--labels", nullptr, nullptr,
       "Each whole number is a label with a colour of its own, 0 is clear; found by itself in most files of "
       "labels",
       flag(o.colour.labels)},
      {"--mode", nullptr, initial,
       "What a ray shows: light through the volume; its largest or least value, their mean, or their "
       "integral over length, in grey or in --tf's colours and opacities; the first surface of --isovalue; "
       "or the largest value of those dimmed by what lies before them, by --opacity; needs sheets; without "
       "it mip for several channels",
       choice(o.colour.mode, named(every_mode))},
      {"--materials", nullptr, nullptr,
       "Several channels dim each other's light, as materials in one place do, in place of being added",
       flag(o.frame.shown.mixed), Mark::of_sheets},
      {"--isovalue", nullptr, nullptr,
       "The value of --mode surface; without it the one that parts the volume's values best",
       value(o.colour.isovalue)},
      {"--interpolation", nullptr, nullptr,
       "The values between voxels, which sheets and the field's truth ask for: linear, or the nearest "
       "voxel's; without it nearest for labels, else linear",
       choice(o.colour.interpolation, named({Interpolation::linear, Interpolation::nearest}))},
  };
}

void add_tf_output_options(OptionList& list, RenderOptions& o) {
  list.below("Picture") += {
      {"--tf-out", "FILE", nullptr, "Write the transfer function used, as ParaView JSON",
       value(o.transfer_function_out)},
  };
}

void add_method_options(OptionList& list, RenderOptions& o) {
  list.below("Picture") += {
      {"--quality", nullptr, name(usual_quality),
       "Splats as in the paper, or sheets, from the fastest (draft) to the most exact (best); single options "
       "come first",
       choice(o.method.quality, named({Quality::paper, Quality::draft, Quality::normal, Quality::best}))},
      {"--engine", nullptr, nullptr,
       "Splats: voxels are classified and splatted; sheets: scalars are interpolated and then classified; "
       "without it --quality says",
       choice(o.method.engine, named({Engine::splats, Engine::sheets}))},
      {"--slabs", "1|2|3|4", nullptr,
       "Sheets: pre-integrated slabs from slice to slice; without it 2 for --quality draft and normal, else "
       "3",
       value(o.method.slabs), Mark::of_sheets},
      {"--light-points", "1|2", nullptr,
       "Sheets: points of a slab that are lit; without it 1 for --quality draft, else 2",
       value(o.method.light_points), Mark::of_sheets},
      {"--layers", "N", nullptr,
       "Sheets: draw layers of so many slices each for itself, then composite them: with many ranks less has "
       "to be sent; the picture is another one, and the same on any number of ranks",
       value(o.method.layers, {Sheets::least_layer, 1 << 20}), Mark::of_sheets},
  };
}

void add_shading_options(OptionList& list, RenderOptions& o) {
  list.below("Picture") += {
      {"--shading", nullptr, initial, "Lit by gradients, or the transfer function's colours as they are",
       choice(o.frame.shown.shading, {{"phong", Shading::phong}, {"none", Shading::none}})},
      {"--ambient", nullptr, initial, "Phong: light from everywhere", value(o.frame.shown.material.ambient)},
      {"--diffuse", nullptr, initial, "Phong: light by the angle to it",
       value(o.frame.shown.material.diffuse)},
      {"--specular", nullptr, initial, "Phong: highlights", value(o.frame.shown.material.specular)},
      {"--exponent", nullptr, initial, "Phong: how sharp highlights are",
       value(o.frame.shown.material.exponent)},
  };
}

void add_picture_options(OptionList& list, RenderOptions& o) {
  list.below("Picture") += {
      {"--values", nullptr, nullptr,
       "Numbers instead of colours, in red, green and blue of an .exr: the --mode's largest, least or mean "
       "value, or integral over length; of surface the distance behind the plane through the volume's "
       "middle; alpha is 1 where there are any",
       flag(o.colour.values)},
      {"--depth", "OPACITY", nullptr,
       "A channel Z in the .exr, for merging pictures: how far, in world lengths, where a ray's opacity "
       "reaches this (0.5, say), or the first surface, is behind the plane through the volume's middle; "
       "infinite where nothing is",
       value(o.frame.shown.depth), Mark::of_sheets},
      {"--cut", "AXIS=PLACE|plane:NX,NY,NZ,D", nullptr,
       "Cut the volume open along a slice, given as to --slice: what lies before it, from where it is seen, "
       "is cut off, and it shows its values in --tf's colours",
       text([&o](const std::string& slice, const std::string& option) {
         o.frame.shown.cut = oblique_plane(slice, option);
         if (!o.frame.shown.cut) std::tie(o.cut_at, o.cut_across) = parse_slice(slice, option);
       }),
       Mark::of_sheets},
      {"--radius", nullptr, initial, "Radius of a voxel's kernel in voxels",
       value(o.method.splats.kernel_radius), Mark::of_splats},
      {"--region", "N", nullptr,
       "Pixels of the side of a Renderer's region; without it 128, or less, down to 16, where that shares "
       "the work more evenly; strips in the slices' plane",
       value(o.frame.division.region_size, {1, 1 << 20})},
  };
}

void add_shortcut_options(OptionList& list, RenderOptions& o) {
  list.below("Shortcuts") += {
      {"--undersample", "1|2|4", initial, "Render a volume of every 2nd or 4th voxel along each axis",
       value(o.frame.shown.reduction.factor)},
      {"--prefilter", nullptr, nullptr,
       "Undersampled voxels are filtered from those that they stand for, not picked",
       flag(o.frame.shown.reduction.prefilter)},
      {"--image-plane", nullptr, nullptr,
       "Draw on the screen, or in the plane of the slices, of which one warp makes the picture in the end; "
       "without it slices for --quality draft and normal",
       choice(o.method.image_plane, named({ImagePlane::screen, ImagePlane::slices}))},
      {"--samples", "1|1.5|2|4", nullptr,
       "In the slices' plane: pixels a voxel along each axis, 1.5 for sheets only; without it 1.5 for "
       "--quality normal, else 1",
       value(o.method.samples)},
      {"--opaque-threshold", nullptr, initial,
       "Nothing is added to a pixel through which less light than this comes; 0: everything is",
       one_part(o.frame.shown.opaque_threshold)},
  };
}

Method method_for(const MethodOptions& o) {
  // The other options change its settings; without --quality those of the engine's best known.
  const Quality quality = o.quality.value_or(o.engine == Engine::splats ? Quality::paper : usual_quality);
  if (quality == Quality::paper) return placed(o.splats, o);
  Sheets sheets = sheets_of(quality);
  sheets.slabs = o.slabs.value_or(sheets.slabs);
  sheets.light_points = o.light_points.value_or(sheets.light_points);
  sheets.layers = o.layers.value_or(sheets.layers);
  return placed(sheets, o);
}

const char* items_of(const Method& method) {
  return std::holds_alternative<Sheets>(method) ? "blocks" : "splats";
}

}  // namespace ringsplat::app
