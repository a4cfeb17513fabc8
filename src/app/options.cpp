#include "app/options.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "app/option_values.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::app {
namespace {

template <class T>
using Choices = std::vector<std::pair<std::string, T>>;

/// An option that takes one of a few words.
template <class T, class Target>
CLI::Option* add_choice(CLI::App& app, const std::string& name, Target& target, const Choices<T>& choices,
                        const std::string& fallback, const std::string& description) {
  std::string words;
  for (const auto& [word, value] : choices) words += (words.empty() ? "" : "|") + word;
  const auto choose = [&target, choices, name, words](const std::string& text) {
    const auto found =
        std::find_if(choices.begin(), choices.end(), [&](const auto& c) { return c.first == text; });
    if (found == choices.end())
      throw InputError(fmt::format("{} cannot be '{}'", name, text), fmt::format("use {} {}", name, words));
    target = found->second;
  };
  auto* option = app.add_option_function<std::string>(name, choose, description)->type_name(words);
  return fallback.empty() ? option : option->default_str(fallback);
}

/// An option whose text is turned into a value by `parse(text, name)`.
template <class Target, class Parse>
CLI::Option* add_parsed(CLI::App& app, const std::string& name, Target& target, Parse parse,
                        const std::string& form, const std::string& fallback,
                        const std::string& description) {
  auto* option = app.add_option_function<std::string>(
      name, [&target, parse, name](const std::string& text) { target = parse(text, name); }, description);
  option->type_name(form);
  return fallback.empty() ? option : option->default_str(fallback);
}

/// A number of nodes, or "auto", which sets `choose`.
CLI::Option* add_count(CLI::App& app, const std::string& name, std::optional<int>& count, bool& choose,
                       const std::string& form, const std::string& description) {
  const auto take = [&count, &choose, name](const std::string& text) {
    if (text == "auto")
      choose = true;
    else
      count = parse_count(text, name);
  };
  return app.add_option_function<std::string>(name, take, description)->type_name(form);
}

ScalarType parse_type(const std::string& text, const std::string&) { return scalar_type_from(text); }

glm::dvec3 vec3(const std::vector<double>& v) { return {v.at(0), v.at(1), v.at(2)}; }

/// Puts options under a heading of --help. A list, because only that is evaluated, and so shown, in the order
/// written.
void group(const std::string& heading, std::initializer_list<CLI::Option*> options) {
  for (CLI::Option* option : options) option->group(heading);
}

}  // namespace

void add_volume_options(CLI::App& app, VolumeOptions& o) {
  const std::string heading = "Raw volumes (others describe themselves)";
  app.add_option(
         "volume", o.path,
         "NRRD, MetaImage, NIfTI, VTK, TIFF or raw file, or a folder with a DICOM series or TIFF pages")
      ->type_name("VOLUME");
  group(heading, {add_parsed(app, "--dims", o.raw.dims, parse_dims, "XxYxZ", "", "Voxels along x, y, z"),
                  add_parsed(app, "--type", o.raw.type, parse_type, "TYPE", "",
                             "int8 uint8 int16 uint16 int32 uint32 float32 float64"),
                  add_choice(app, "--endian", o.raw.big_endian,
                             Choices<bool>{{"little", false}, {"big", true}}, "", "Byte order"),
                  app.add_option("--offset", o.raw.offset, "Bytes before the first voxel")
                      ->type_name("BYTES")
                      ->check(CLI::NonNegativeNumber),
                  add_parsed(app, "--spacing", o.raw.spacing, parse_spacing, "XxYxZ", "",
                             "Distances between voxels; replaces the file's own, whatever the format")});
}

void add_run_options(CLI::App& app, RunOptions& o) {
  group(
      "Ranks",
      {add_count(app, "--gps", o.gps, o.choose_roles, "G|auto",
                 "Ranks that hold slices and make splats; auto: as many as a measured frame needs"),
       add_count(app, "--renderers", o.renderers, o.choose_roles, "R|auto",
                 "Ranks that draw; what is left out follows from the launcher's count"),
       add_choice(
           app, "--roles", o.placement,
           Choices<Placement>{{"dedicated", Placement::dedicated}, {"colocated", Placement::colocated}}, "",
           "GPs and Renderers on ranks of their own, or GP p and Renderer p together on rank p"),
       add_choice(app, "--topology", o.topology,
                  Choices<Topology>{{"ring", Topology::ring}, {"mesh", Topology::mesh}}, "ring",
                  "How the GPs are linked"),
       add_parsed(
           app, "--mesh", o.mesh, parse_mesh, "COLUMNSxROWS", "",
           "GPs of a mesh; it has a Renderer at the left end of every row unless --renderers says otherwise, "
           "at both ends up to twice as many"),
       add_choice(app, "--routing", o.routing,
                  Choices<Routing>{{"manhattan", Routing::manhattan}, {"direct", Routing::direct}},
                  "manhattan",
                  "In a mesh, messages go along a column and then a row, from neighbour to neighbour, or "
                  "straight to "
                  "their rank"),
       app.add_option("--threads-per-rank", o.engine.threads_per_rank,
                      "Threads that share the work of a rank's GP and Renderer; they send no messages")
           ->type_name("T")
           ->capture_default_str(),
       add_choice(app, "--transport", o.transport,
                  Choices<TransportChoice>{{"auto", TransportChoice::automatic},
                                           {"mpi", TransportChoice::mpi},
                                           {"loopback", TransportChoice::loopback}},
                  "auto", "MPI, or all nodes in this process; auto: MPI when a launcher started it")});
  group("Protocol",
        {app.add_option("--frames-in-flight", o.protocol.frames_in_flight,
                        "Frames announced and not yet complete")
             ->capture_default_str(),
         app.add_option("--slots", o.protocol.slots, "Payloads a Renderer accepts before it has drawn them")
             ->capture_default_str(),
         app.add_option("--link-slots", o.protocol.link_slots,
                        "Messages of one buffer class that may be behind a mesh's link")
             ->capture_default_str(),
         app.add_option("--look-ahead", o.protocol.look_ahead,
                        "Slices a GP prepares before their tokens have passed")
             ->capture_default_str(),
         app.add_option("--send-ahead", o.protocol.send_ahead,
                        "Payloads that a token leaves behind before it waits until one is accepted")
             ->capture_default_str(),
         app.add_option("--stall-timeout", o.protocol.stall_timeout,
                        "Seconds without any progress until a run is given up")
             ->type_name("SECONDS")
             ->capture_default_str(),
         app.add_flag("--shuffle", o.loopback.reorder,
                      "Loopback: messages overtake each other and ranks take turns at random"),
         app.add_option("--max-delay", o.loopback.max_delay, "Loopback: turns by which a message may be late")
             ->check(CLI::NonNegativeNumber)
             ->capture_default_str(),
         app.add_flag("--in-step", o.loopback.in_step,
                      "Loopback: one frame at a time, and all tokens move one GP per step of a common clock"),
         app.add_option("--seed", o.loopback.seed, "Seed of what is random")
             ->check(CLI::NonNegativeNumber)
             ->capture_default_str()});
  SimulationOptions& simulation = o.engine.simulation;
  group("Simulated machines (docs/simulation.md)",
        {app.add_option("--machine", o.machine, "Charge what this described machine's nodes would spend")
             ->type_name("FILE"),
         app.add_flag("--count-only", simulation.count_only,
                      "Send payloads of the right size but draw nothing: for time and traffic, no picture"),
         app.add_option("--voxel-weight", simulation.voxel_weight,
                        "With --count-only: so many voxels of its slice for which each voxel stands")
             ->capture_default_str()
             ->check(CLI::Range(1.0, 1e6)),
         app.add_option("--step-seconds", simulation.step_seconds,
                        "Tokens move one GP per step of a common clock, which lasts so long; 0: freely")
             ->capture_default_str()
             ->check(CLI::Range(0.0, 1e6))});
}

void add_view_options(CLI::App& app, RenderOptions& o) {
  Camera& camera = o.frame.camera;
  group(
      "View",
      {app.add_option("--azimuth", camera.azimuth,
                      "Degrees the viewer walks around the volume; 0 is in front")
           ->capture_default_str(),
       app.add_option("--elevation", camera.elevation, "Degrees the viewer climbs; 90 looks straight down")
           ->capture_default_str(),
       app.add_option("--roll", camera.roll, "Degrees the picture is turned clockwise")
           ->capture_default_str(),
       app.add_option("--zoom", camera.zoom, "1 fits the volume's bounding sphere to the image")
           ->capture_default_str(),
       app.add_option_function<std::vector<double>>(
              "--matrix",
              [&camera](const std::vector<double>& m) {
                camera.matrix.emplace();
                std::copy_n(m.begin(), 12, camera.matrix->begin());
              },
              "World to screen instead, 3 rows of 4: pixels right, pixels down, pixels of depth")
           ->expected(12)
           ->type_name("M11 ... M34"),
       app.add_option("--orbit", o.orbit, "N frames once around, from --azimuth on, into OUT-0000.png ...")
           ->type_name("N")
           ->check([](const std::string& text) {
             const bool number = !text.empty() && text.find_first_not_of("0123456789") == std::string::npos;
             return number && text.size() <= 7 && std::stoi(text) >= 1 && std::stoi(text) <= 1'000'000
                        ? std::string()
                        : "needs 1 to 1000000 frames, not '" + text + "'";
           }),
       app.add_option("--path", o.path,
                      "A frame for each line of FILE: azimuth, elevation, roll, zoom, with commas or blanks, "
                      "or as JSON; -: for each line that comes on stdin")
           ->type_name("FILE")});
}

void add_picture_options(CLI::App& app, RenderOptions& o) {
  FrameSpec& f = o.frame;
  auto* size = app.add_option_function<std::string>(
      "--size",
      [&f](const std::string& text) {
        const Size s = parse_size(text, "--size");
        f.width = s.width;
        f.height = s.height;
      },
      "Pixels of the image");
  auto* no_correction = app.add_flag_callback(
      "--no-opacity-correction", [&f] { f.opacity_correction = false; },
      "Take opacities per slice, whatever the distance between slices along the ray");
  auto* light = app.add_option_function<std::vector<double>>(
      "--light", [&f](const std::vector<double>& v) { f.light = vec3(v); },
      "Direction to the light in the picture: right, up, to the viewer");
  group(
      "Picture",
      {size->type_name("WxH")->default_str("512x512"),
       app.add_option("--tf", o.transfer_function,
                      "Transfer function: a preset (ringsplat info --presets) or a ParaView JSON file")
           ->type_name("NAME|FILE")
           ->capture_default_str(),
       app.add_option("--tf-out", o.transfer_function_out,
                      "Write the transfer function used, as ParaView JSON")
           ->type_name("FILE"),
       add_choice(app, "--shading", f.shading,
                  Choices<Shading>{{"phong", Shading::phong}, {"none", Shading::none}}, "phong",
                  "Lit by gradients, or the transfer function's colours as they are"),
       app.add_option("--ambient", f.material.ambient, "Phong: light from everywhere")->capture_default_str(),
       app.add_option("--diffuse", f.material.diffuse, "Phong: light by the angle to it")
           ->capture_default_str(),
       app.add_option("--specular", f.material.specular, "Phong: highlights")->capture_default_str(),
       app.add_option("--exponent", f.material.exponent, "Phong: how sharp highlights are")
           ->capture_default_str(),
       light->expected(3)->type_name("X Y Z")->default_str("-0.4 0.6 0.7"),
       app.add_option("--radius", f.kernel_radius, "Radius of a voxel's kernel in voxels")
           ->capture_default_str(),
       add_choice(app, "--kernel", f.kernel.method,
                  Choices<KernelMethod>{{"qee", KernelMethod::qee}, {"texture", KernelMethod::texture}},
                  "qee",
                  "Compute a kernel's weight in each pixel, or look it up in a table of the footprint"),
       app.add_option("--phases", f.kernel.phases,
                      "Texture: sub-pixel positions along each axis that the table knows, 1 to 16")
           ->capture_default_str(),
       app.add_option(
              "--qee-bits", f.kernel.qee_bits,
              "Compute the kernel in fixed point of so many bits, as Pixel-Planes 5 did with 10; 0: float32")
           ->capture_default_str(),
       add_choice(
           app, "--normalisation", f.kernel.normalisation,
           Choices<Normalisation>{{"none", Normalisation::none},
                                  {"constant", Normalisation::constant},
                                  {"exact", Normalisation::exact}},
           "constant",
           "Divide the kernels' weights by nothing, by their sum's mean, or by their sum at each pixel"),
       app.add_option("--region", f.region_size,
                      "Pixels of the side of a Renderer's region; without it 128, or 64 or 32 where the "
                      "volume covers too few of those, and strips in the slices' plane")
           ->type_name("N")
           ->check(CLI::Range(1, 1 << 20)),
       no_correction});
}

void add_shortcut_options(CLI::App& app, RenderOptions& o) {
  FrameSpec& f = o.frame;
  group("Shortcuts",
        {app.add_flag("--progressive", o.progressive,
                      "Show each view from every 4th voxel, then from every 2nd (OUT-u4.png, OUT-u2.png), "
                      "then in full; a "
                      "newer view on --path - ends it"),
         app.add_option("--undersample", f.reduction.factor,
                        "Render a volume of every 2nd or 4th voxel along each axis")
             ->type_name("1|2|4")
             ->capture_default_str(),
         app.add_flag("--prefilter", f.reduction.prefilter,
                      "Undersampled voxels are filtered from those that they stand for, not picked"),
         add_choice(app, "--image-plane", f.image_plane,
                    Choices<ImagePlane>{{"screen", ImagePlane::screen}, {"slices", ImagePlane::slices}},
                    "screen",
                    "Draw on the screen, or in the plane of the slices, of which one warp makes the picture "
                    "in the end"),
         app.add_option("--samples", f.plane_samples, "In the slices' plane: pixels a voxel along each axis")
             ->type_name("1|2|4")
             ->capture_default_str(),
         app.add_option(
                "--opaque-threshold", f.opaque_threshold,
                "Nothing is added to a pixel through which less light than this comes; 0: everything is")
             ->default_str(fmt::format("1/{:g}", 1 / f.opaque_threshold)),
         add_choice(app, "--payload", f.payload,
                    Choices<PayloadForm>{{"runs", PayloadForm::runs}, {"words", PayloadForm::words}}, "runs",
                    "What GPs send: runs of voxels, or the paper's six words a splat; the same bits"),
         add_choice(app, "--precision", f.precision,
                    Choices<Precision>{
                        {"float", Precision::float32}, {"half", Precision::half}, {"u8", Precision::u8}},
                    "float", "Of colours and opacities in runs: 10, 8 or 4 bytes a voxel")});
}

void add_render_output_options(CLI::App& app, RenderOptions& o) {
  group("Output",
        {app.add_option("-o,--output", o.output,
                        "The picture: .png (straight sRGB), .exr (linear float), .tif .jpg .tga; not needed "
                        "with --stats or --count-only")
             ->type_name("FILE"),
         add_parsed(app, "--background", o.background, parse_colour, "COLOUR", "none",
                    "A name, #rrggbb or r,g,b from 0 to 1; makes the picture opaque"),
         app.add_option("--stats", o.stats,
                        "What each node did in each frame: a JSON array, or JSON lines in a .jsonl; of "
                        "--stats, --trace "
                        "and --tf-out one may be -, stdout, and lines of results then go to stderr")
             ->type_name("FILE"),
         app.add_option("--trace", o.trace,
                        "What each node did when, as Chrome trace-event JSON, which opens in Perfetto")
             ->type_name("FILE"),
         add_choice(app, "--axes", o.keep_all_axes, Choices<bool>{{"needed", false}, {"all", true}}, "needed",
                    "Slice sets that are kept in memory: those the views traverse, or all three")});
}

void add_info_options(CLI::App& app, InfoOptions& o) {
  group("Output",
        {app.add_option("--gps", o.gps, "Predict the memory of a GP for G of them")
             ->type_name("G")
             ->check(CLI::Range(1, 1 << 24)),
         app.add_flag("--json", o.json, "Write JSON"),
         app.add_flag("--presets", o.presets, "List the transfer functions that --tf knows by name")});
  group("Prediction",
        {app.add_option("--ranks", o.ranks,
                        "Measure a frame here and predict its time for all ways to give N ranks roles")
             ->type_name("N")
             ->check(CLI::Range(1, 4096)),
         app.add_option("--cores", o.cores, "Cores that the ranks share; without it this machine's")
             ->type_name("C")
             ->check(CLI::Range(1, 1 << 24)),
         app.add_option("--machine", o.machine,
                        "Predict for a described machine (docs/simulation.md) instead of measuring here")
             ->type_name("FILE")});
}

void add_compare_options(CLI::App& app, CompareOptions& o) {
  app.add_option("a", o.a, "The picture in question")->type_name("A")->required();
  app.add_option("b", o.b, "What it is compared with")->type_name("B")->required();
  group(
      "Output",
      {app.add_option("--threshold", o.threshold, "Count the pixels that differ by more than this, in 1/255")
           ->capture_default_str()
           ->check(CLI::NonNegativeNumber),
       app.add_option("--fail-above", o.fail_above, "Exit with 1 when the RMSE is above this, in 1/255")
           ->check(CLI::NonNegativeNumber),
       app.add_option("--diff", o.difference, "Write the difference: absolute, in an .exr signed")
           ->type_name("FILE"),
       app.add_option("--diff-scale", o.difference_scale, "Multiply the written difference")
           ->capture_default_str(),
       app.add_flag("--json", o.json, "Write JSON")});
}

void add_synth_options(CLI::App& app, SynthOptions& o) {
  app.add_option("name", o.name, "Which volume; --list says what there is")->type_name("NAME");
  group("Output",
        {app.add_option("-o,--output", o.output,
                        ".nrrd, .nhdr, .mhd or .raw (dimensions and type then go into its name)")
             ->type_name("FILE"),
         add_parsed(app, "--dims", o.dims, parse_dims, "XxYxZ", "64x64x64", "Voxels along x, y, z"),
         add_parsed(app, "--type", o.type, parse_type, "TYPE", "uint8",
                    "int8 uint8 int16 uint16 int32 uint32 float32 float64"),
         add_parsed(app, "--spacing", o.spacing, parse_spacing, "XxYxZ", "1x1x1", "Distances between voxels"),
         app.add_flag("--no-compression", o.no_compression,
                      "Write a .nrrd without gzip, so that all ranks can read it at once"),
         app.add_flag("--list", o.list, "List the volumes")});
}

}  // namespace ringsplat::app
