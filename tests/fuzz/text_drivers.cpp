// Texts that people write (transfer functions, configurations, machines, lists of studies and views) and
// files that the program keeps from run to run.
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>

#include "app/views.hpp"
#include "classify/classifier.hpp"
#include "command_line/command_line.hpp"
#include "formats/files.hpp"
#include "frame/frame_spec_bytes.hpp"
#include "fuzz/driver.hpp"
#include "ringsplat/base/error.hpp"
#include "ringsplat/view/view.hpp"
#include "serve/client_message.hpp"
#include "serve/levels.hpp"
#include "session/render_frames.hpp"
#include "simulate/machine.hpp"

namespace ringsplat::fuzz {
namespace {

bool is_share(double v) { return v >= 0 && v <= 1; }

void run_transfer_function(std::span<const std::byte> input) {
  const TransferFunction tf = parse_transfer_function(std::string(text_of(input)), "a.json");
  static_cast<void>(parse_transfer_function(to_paraview_json(tf), "what was written of it"));
  const Classifier bytes(tf, ScalarType::uint8, 1.5), floats(tf, ScalarType::float32, 0.5);
  for (const double value : {-1e30, -1.0, 0.0, 0.5, 100.0, 1e30, double(INFINITY), double(NAN)}) {
    const ClassifiedSample s = floats.evaluate(value);
    if (!is_share(s.r) || !is_share(s.g) || !is_share(s.b) || !is_share(s.opacity))
      throw std::logic_error("a transfer function gives a colour or opacity outside 0..1");
  }
}

std::vector<Input> transfer_function_seeds() {
  return {
      R"([{"ColorSpace": "RGB", "Name": "a", "NanColor": [1, 0, 0],
 "RGBPoints": [0, 0, 0, 0, 0.5, 0.25, 0.5, 0.75, 255, 1, 1, 1],
 "Points": [0, 0, 0.5, 0, 100, 0.25, 0.3, 0.7, 255, 1, 0.5, 0]}])",
      R"({"ColorSpace": "HSV", "HSVWrap": true, "RGBPoints": [0, 1, 0, 0, 10, 0, 0, 1], "Points": [0, 0, 0.5, 0, 10, 1, 0.1, 1]})",
      R"([{"ColorSpace": "Diverging", "RGBPoints": [-1, 0.2, 0.3, 0.7, 0, 0.8, 0.8, 0.8, 1, 0.7, 0, 0.1], "Points": [-1, 1, 0.9, 0.5, 1, 0, 0.5, 0], "NanColor": null}])",
      R"({"ColorSpace": "Lab", "RGBPoints": [0, 0, 0, 0, 0, 1, 1, 1], "Points": [5, 0, 0.5, 0, 5, 1, 0.5, 0], "IndexedColors": [1]})"};
}

void run_arguments(const std::vector<std::string>& arguments) {
  std::vector<const char*> argv{"ringsplat"};
  for (const auto& argument : arguments) argv.push_back(argument.c_str());
  const auto line = app::parse_command_line(int(argv.size()), argv.data());
  if (line.error.empty() == std::holds_alternative<std::monostate>(line.command))
    throw std::logic_error("a command line is neither right nor wrong");
  if (!line.error.empty()) throw InputError(line.error);
}

void run_configuration(std::span<const std::byte> input) {
  const auto path = files::write(scratch() / "run.toml", std::string(text_of(input)));
  run_arguments({"render", "head.nrrd", "-o", "head.png", "--config", path.string()});
}

std::vector<Input> configuration_seeds() {
  return {"gps = 4\nrenderers = 2\nsize = \"640x480\"\nlight = [-0.4, 0.6, 0.7]\n",
          "# a mesh\ntopology = \"mesh\"\nmesh = \"4x4\"\nrouting = 'direct'\nframes-in-flight = 3\n",
          "[render]\nazimuth = 30.5\nzoom = 2\nshading = \"none\"\nannotate = true\nbackground = "
          "\"#102030\"\n",
          "region = 64\nimage-plane = \"slices\"\nsamples = 2\nmax-error = 2.5\nverbose = true\n"};
}

/// Input: one argument a line.
void run_command_line(std::span<const std::byte> input) {
  std::vector<std::string> arguments;
  std::istringstream lines{std::string(text_of(input))};
  // C ends arguments at a zero byte.
  for (std::string line; std::getline(lines, line);) arguments.emplace_back(line.c_str());
  run_arguments(arguments);
}

std::vector<Input> command_line_seeds() {
  return {
      "render\nhead.nrrd\n-o\nhead.png\n--gps\n4\n--size=640x480\n--light\n-0.4\n0.6\n0.7\n--"
      "matrix\n1\n0\n0\n0\n0\n1\n0"
      "\n0\n0\n0\n1\n0\n",
      "info\nhead.raw\n--dims\n5x4x3\n--type\nuint8\n--ranks\n8\n--json\n",
      "compare\na.png\nb.png\n--fail-above\n0.5\n",
      "synth\nball\n-o\nball.nrrd\n--dims\n64\n",
      "reference\nhead.nrrd\n-o\nhead.exr\n--truth\nfield\n",
      "--help\n",
      "render\n--help\n"};
}

void run_machine(std::span<const std::byte> input) {
  const Machine machine = parse_machine(std::string(text_of(input)), "a.toml");
  const double seconds = encoding_seconds(machine, 1e6, 1e5) + drawing_seconds(machine, 1e5, 100, 1e4) +
                         sending_seconds(machine, 1e6);
  if (!(seconds >= 0)) throw std::logic_error("a machine's work takes no number of seconds");
}

std::vector<Input> machine_seeds() {
  const std::filesystem::path folder(RINGSPLAT_MACHINES);
  return {
      files::slurp(folder / "pixel-planes-5.toml"),
      "name = \"a\"\npoll_interval = 1e-6\n[gp]\nvisible_voxel = 1e-6\ntransparent_voxel = "
      "1e-8\n[renderer]\nsplat "
      "= 1e-6\n[message]\npacket_bytes = 1500\npacket = 1e-6\n[platform]\nkind = \"fat_tree\"\nbandwidth = "
      "1e9\nlatency = 1e-6\ncores = 4\nleaf = 8\n"};
}

LatticeFrame small_lattice() { return {{5, 4, 3}, glm::dvec3(1, 2, 3), glm::dvec3(0.0), glm::dmat3(1.0)}; }

void run_path(std::span<const std::byte> input) {
  std::istringstream text{std::string(text_of(input))};
  const auto cameras = app::parse_path(text, "a.txt", Camera{});
  constexpr std::size_t enough = 64;
  for (std::size_t k = 0; k < std::min(cameras.size(), enough); ++k)
    static_cast<void>(make_view(cameras[k], small_lattice(), 64, 48));
}

std::vector<Input> path_seeds() {
  return {"# views\n30 10\n30.5, -10, 5\r\n\n1;2;3;4\n", "zoom azimuth elevation\n2 0 10\n3 5\n",
          "{\"azimuth\": 30, \"zoom\": 2}\n{\"matrix\": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]}\n",
          "Azimuth,Elevation,Roll,Zoom\n0,0,0,1\n1e1,+2,-3,0.5\n"};
}

Grid small_volume() {
  Grid grid;
  grid.dims = {70, 66, 64};
  grid.spacing = {1, 1.5, 2};
  return grid;
}

serve::MessageRules message_rules() {
  serve::MessageRules rules;
  rules.initial.shown.transfer_function = {
      .name = "ramp", .colours = {{0, glm::dvec3(0.0)}, {1, glm::dvec3(1.0)}}, .opacities = {{0, 0}, {1, 1}}};
  rules.grid.dims = small_volume().dims;
  return rules;
}

/// A view that is let through must be one that ranks draw: what they refuse ends the job.
void use(const serve::SceneState& scene) {
  static const auto levels = serve::make_levels(small_volume().dims);
  FrameSpec full{.how = Splats{}};
  full.shown = scene.shown;
  for (const auto& level : levels) {
    const FrameSpec spec = serve::at_level(full, level);
    check_frame(spec, small_volume());
    if (decode_frame_spec(encode(spec)) != spec)
      throw std::logic_error("a view changes on its way to the ranks");
  }
  const auto again = nlohmann::json::parse(serve::text_of(serve::to_json(scene)));
  static_cast<void>(serve::scene_from(again, message_rules()));
}

void run_client_message(std::span<const std::byte> input) {
  static_cast<void>(serve::id_of(text_of(input)));
  const auto message = serve::parse_client_message(text_of(input), message_rules());
  if (const auto* view = std::get_if<serve::ViewMessage>(&message)) use(view->scene);
  if (const auto* file = std::get_if<serve::FileMessage>(&message)) use(file->scene);
}

std::vector<Input> client_message_seeds() {
  return {
      R"({"type":"view","seq":3,"moving":true,"width":640,"height":480,"time":12.5,"state":{"camera":{"azimuth":30,"elevation":-20,"roll":1,"zoom":1.5,"pan":[0.1,-0.2],"fov":0,"distance":0},"shading":"phong","light":[1,2,3],"background":[0,0.5,1]}})",
      R"({"type":"view","seq":4,"width":64,"height":48,"state":{"transfer_function":{"name":"a","colours":[[0,0,0,0],[255,1,1,1]],"opacities":[[0,0],[100,0.25],[255,1]]},"clip":[[0,70],[3,60],[1,2]]}})",
      R"({"type":"ack","picture":17})",
      R"({"type":"drive"})",
      R"({"type":"probe","id":1,"x":10.5,"y":20})",
      R"({"type":"map","id":2,"map":{"ColorSpace":"Lab","RGBPoints":[0,0,0,0,1,1,1,1],"Points":[0,0,0.5,0,1,1,0.5,0]}})",
      R"({"type":"snapshot","id":2,"width":4096,"height":4096,"format":"exr","state":{"clip":null}})",
      R"({"type":"movie_frame","id":3,"index":2,"count":10000,"fps":29.97,"width":1280,"height":720,"state":{}})",
      R"({"type":"cancel","id":3})"};
}

using Words = std::vector<std::string_view>;

// Lists of words, as many to a line as fit.
// clang-format off
const Words transfer_function_words{
    "\"ColorSpace\": ", "\"RGB\"", "\"HSV\"", "\"Lab\"", "\"Diverging\"", "\"Step\"", "\"RGBPoints\": ",
    "\"Points\": ", "\"NanColor\": ", "\"Name\": ", "\"HSVWrap\": ", "null", "true", "[", "]", "{", "}",
    "[[[[[[[[", "1e308", "-1e308", "\\u0000", "\\ud800", "\xff", ","};
const Words configuration_words{
    "gps = ", "renderers = ", "size = ", "[render]", "[info]", "[[render]]", "[", "]", "\"", "'", "\\", "#",
    "=", "auto", "light = [", "tf = ", "matrix = ", "orbit = ", "threads-per-rank = ", "config = ",
    "help = true", "version = true", "render.gps = 2", "true", "false", "{}", "'''", "\"\"\"",
    "orbit = [1, 2]"};
const Words command_line_words{
    "render", "info", "compare", "--gps\n", "--gps=", "--size\n", "--help\n", "--version\n", "--config\n",
    "--", "-", "--tf\n", "--matrix\n", "--orbit\n", "--path\n", "--max-error\n", "--roles\n", "auto", "mesh",
    "--mesh\n", "--light\n", "--background\n", "--undersample\n", "--radius\n", "--no-such", "\n"};
const Words machine_words{
    "[gp]", "[renderer]", "[message]", "[platform]", "kind = ", "\"mesh\"", "\"torus\"", "\"backbone\"",
    "bandwidth = ", "packet_bytes = ", "cores = ", "hosts = ", "leaf = ", "=", "\"", "[", "]", "[[gp]]",
    "1e300"};
const Words path_words{
    "azimuth", "elevation", "roll", "zoom", "{\"azimuth\": ", "\"matrix\": [", "{", "}", "[", "]", "#",
    "\r\n", "\t", ",", ";", "1e400", "[[[[[[[["};
const Words client_message_words{
    "\"type\":", "\"view\"", "\"snapshot\"", "\"movie_frame\"", "\"index\":", "\"count\":", "\"id\":", "\"state\":", "\"camera\":", "\"zoom\":", "\"azimuth\":", "\"pan\":",
    "\"fov\":", "\"clip\":", "\"light\":", "\"transfer_function\":", "\"colours\":", "\"opacities\":", "null", "true",
    "1e308", "-1e-308", "1e999", "4294967295", "[", "]", "{", "}", "\"", "\\", "[[[[[[[[", "\xff", "1e6", "1e-6"};
// clang-format on

}  // namespace

std::vector<Driver> text_drivers() {
  return {
      {"transfer_function", run_transfer_function, transfer_function_seeds, transfer_function_words, 5000},
      {"configuration", run_configuration, configuration_seeds, configuration_words, 1000},
      {"command_line", run_command_line, command_line_seeds, command_line_words, 1000},
      {"machine", run_machine, machine_seeds, machine_words, 6000},
      {"path", run_path, path_seeds, path_words, 20000},
      {"client_message", run_client_message, client_message_seeds, client_message_words, 3000}};
}

}  // namespace ringsplat::fuzz
